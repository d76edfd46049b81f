//! What can go wrong between the graph and a node.

use crate::args::ArgsError;
use crate::names::NamespaceError;
use crate::params::ParamFileError;
use std::error::Error;

/// Why a node cannot start or take part in the graph.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RuntimeError {
    /// Arguments or environment were not understood.
    #[error(transparent)]
    Args(#[from] ArgsError),
    /// A parameter file was refused.
    #[error(transparent)]
    Parameters(#[from] ParamFileError),
    /// A name is not valid in ROS 2.
    #[error("name '{name}' is not a valid ROS 2 name: {rule}")]
    Name {
        /// The refused name.
        name: String,
        /// What names look like.
        rule: &'static str,
    },
    /// A namespace is not valid in ROS 2.
    #[error(transparent)]
    Namespace(#[from] NamespaceError),
    /// The middleware refused to create an entity.
    #[error("cannot create {what}: {reason}")]
    Create {
        /// What was to be created.
        what: String,
        /// Why not.
        reason: String,
    },
    /// Simulated time was demanded of a node that acts on the world.
    #[error("use_sim_time = true: {what} runs on the host's clock; leave it out")]
    SimulatedTime {
        /// Who refuses.
        what: &'static str,
    },
    /// A shell was asked how it checks its parameters, and is not to go on.
    #[error("asked for the check of the parameters alone")]
    Asked,
    /// A system call failed.
    #[error("{what}")]
    System {
        /// What was tried.
        what: &'static str,
        /// Why it failed.
        #[source]
        source: std::io::Error,
    },
}

impl RuntimeError {
    /// An entity that the middleware refused.
    pub(crate) fn create(what: impl Into<String>, reason: &dyn std::fmt::Debug) -> Self {
        Self::Create { what: what.into(), reason: format!("{reason:?}") }
    }

    /// Whether the person who started the node has to change something: exit code 2.
    #[must_use]
    pub fn is_usage(&self) -> bool {
        matches!(
            self,
            Self::Args(_)
                | Self::Parameters(_)
                | Self::Name { .. }
                | Self::Namespace(_)
                | Self::SimulatedTime { .. }
        )
    }
}

/// An error and its causes in one line.
pub(crate) fn chain(error: &(dyn Error + 'static)) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text = format!("{text}: {error}");
        cause = error.source();
    }
    text
}
