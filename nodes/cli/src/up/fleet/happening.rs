//! What becomes of processes.

/// What happened to a process.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Happening {
    /// It ended although nobody had asked; it will be started again.
    Ended {
        /// Name of the node.
        name: &'static str,
        /// Exit status or signal, for people.
        how: String,
    },
    /// It runs again.
    Restarted {
        /// Name of the node.
        name: &'static str,
        /// Its new process id.
        pid: u32,
    },
    /// It ended and stays down: it is not to be replaced.
    GivenUp {
        /// Name of the node.
        name: &'static str,
    },
    /// It ended too often: from now on it is tried again now and then, and told again when it has stayed.
    KeepsEnding {
        /// Name of the node.
        name: &'static str,
        /// Exit status or signal, for people.
        how: String,
    },
    /// One of those tries ended: nothing new.
    EndedAgain {
        /// Name of the node.
        name: &'static str,
    },
    /// Its heart stands still, though the process may live.
    Silent {
        /// Name of the node.
        name: &'static str,
    },
    /// It has been silent for so long that it is ended by force.
    Hung {
        /// Name of the node.
        name: &'static str,
    },
    /// Its heart beats again.
    HeardAgain {
        /// Name of the node.
        name: &'static str,
    },
}

impl Happening {
    /// The node it happened to.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Ended { name, .. }
            | Self::Restarted { name, .. }
            | Self::GivenUp { name }
            | Self::KeepsEnding { name, .. }
            | Self::EndedAgain { name }
            | Self::Silent { name }
            | Self::Hung { name }
            | Self::HeardAgain { name } => name,
        }
    }

    /// The node whose process has ended by it.
    #[must_use]
    pub fn ended(&self) -> Option<&'static str> {
        match self {
            Self::Ended { name, .. }
            | Self::GivenUp { name }
            | Self::KeepsEnding { name, .. }
            | Self::EndedAgain { name } => Some(name),
            Self::Restarted { .. } | Self::Silent { .. } | Self::Hung { .. } | Self::HeardAgain { .. } => {
                None
            }
        }
    }
}
