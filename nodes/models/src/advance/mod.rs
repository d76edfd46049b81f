//! Pressure advance (System 2 of the model book, [ADV]): what holds the melt back, how long it lags, what makes up for it.
//!
//! | module | what |
//! |---|---|
//! | [`forces`] | friction and acceleration forces on the melt in the nozzle |
//! | [`compensation`] | lag K with compensation `K_A`, propagated exactly |
//! | [`line`] | the paper's test line: slow, fast, slow |
//! | [`width`] | width errors weighted by the way |
//! | [`drive`] | lag of a drive for polymer, temperature, layer height and line width |
//! | [`physics`] | the parameters of both, and short ways to their answers |
//! | [`virtual_line`] | the test line printed with that lag, and the `K_A` that prints it best |
//! | [`turn`] | turns of a path and the way to the next one, by hindsight |
//! | [`published`] | the seven `K_A` that the paper prints |
//!
//! Junction speed stands in [`crate::motion::junction_speed_m_s`].
//!
//! # Where this differs from the paper
//!
//! - (4): as printed, with the derivative of the outlet beside `K_A`, the transfer is `1/(1 + (K - K_A) s)`, unstable
//!   for `K_A > K`. It has to be the derivative of the commanded speed: `y = v0 + K_A dv0/dt - K dy/dt`, transfer
//!   `(1 + K_A s)/(1 + K s)`, stable for every `K_A`, and `K_A = K` cancels the lag.
//! - The printed `F_a` lacks the area `pi d_in^2` (it is a pressure); `F_f` uses the outlet's area, `F_a` the inlet's.
//!   Both are given here; on the filament friction is `(d_in/d_out)^2` larger.
//! - Friction, not inertia, rules: by 4 to 5 orders of magnitude. One sentence of the paper says the opposite.
//! - [`virtual_line`] stands in for the authors' data set, which is not to be had. Only its shape at PLA, 215 degC is
//!   fitted to print (7 points); every other polymer and every coefficient of temperature is an assumption.

pub mod compensation;
pub mod drive;
pub mod forces;
pub mod line;
pub mod physics;
pub mod published;
pub mod turn;
pub mod virtual_line;
pub mod width;

pub use compensation::Compensation;
pub use drive::{Condition, Drive, DriveKind, Polymer, RawDrive, RawPolymer};
pub use forces::{Forces, Passage};
pub use line::{RawTestLine, TestLine};
pub use physics::Physics;
pub use virtual_line::{Best, VirtualLine};
pub use width::WidthErrors;

#[cfg(test)]
mod tests;
