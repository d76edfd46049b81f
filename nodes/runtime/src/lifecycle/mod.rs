//! Managed nodes: five services, `transition_event`, and who drives the shell through its states.
//!
//! A shell is one function. What it does before [`crate::Node::activated`] is its configuration: parameters are loaded
//! and checked, endpoints opened. What follows is its work, until [`crate::Node::shutdown`] tells it to say its last, safe
//! word and return. So a deactivation is an orderly end of the work, after which the shell is configured anew, from
//! the parameters that are then in force, and waits.
//!
//! ```text
//!                configure            activate
//! unconfigured ------------> inactive ----------> active      a node of ours goes there by itself (`autostart`)
//!              <------------          <----------
//!                 cleanup             deactivate              shutdown from each of them -> finalized
//! ```

mod driver;
mod gate;
mod life;
mod machine;
mod order;
mod services;
mod stage;

pub(crate) use driver::drive;
pub(crate) use gate::Gate;
pub(crate) use life::Life;
pub(crate) use services::{LifecycleServices, Order};
pub(crate) use stage::Stage;
