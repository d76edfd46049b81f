//! Why recording cannot begin or go on.

use crate::clock;
use runtime::RuntimeError;
use std::error::Error;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// What is tried of a file that is only read.
const READ: &str = "read";

/// What can be recorded, as declared.
fn topic_names() -> String {
    runtime::topics::ALL.iter().map(|topic| topic.name).collect::<Vec<_>>().join(", ")
}

/// The recorder's errors.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecorderError {
    /// The graph.
    #[error(transparent)]
    Runtime(#[from] RuntimeError),
    /// A file or folder.
    #[error("cannot {what} {}", path.display())]
    File {
        /// What was tried.
        what: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// Why it failed.
        #[source]
        source: std::io::Error,
    },
    /// An MCAP file.
    #[error("cannot {what} {}", path.display())]
    Mcap {
        /// What was tried.
        what: &'static str,
        /// The file.
        path: PathBuf,
        /// Why it failed.
        #[source]
        source: mcap::McapError,
    },
    /// A finished file that is not what was written.
    #[error("{}: damaged: `fdm recover` saves what can be read of it", .0.display())]
    Damaged(PathBuf),
    /// A file that holds what a copy would lose.
    #[error("{}: holds {what}, which would be lost: bags of ROS 2 alone are mended", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What it holds.
        what: String,
    },
    /// The folder is another recorder's.
    #[error("{}: another recorder is writing to this bag", .0.display())]
    InUse(PathBuf),
    /// The bag's times are of another clock than this run's would be.
    #[error(
        "{name}: its times are of the {was} clock, those of this run would be of the {is} one: record to another folder, or \
         start with use_sim_time:={wanted} (fdm record --use-sim-time={wanted})",
        name = .file.display(),
        wanted = was == clock::SIMULATED
    )]
    OtherClock {
        /// The bag's newest file.
        file: PathBuf,
        /// Its clock.
        was: String,
        /// The clock of this run.
        is: String,
    },
    /// A name in `leave_out` or `topics` is no topic.
    #[error("{parameter}: '{name}' is no topic of this system; there are {}", topic_names())]
    NoTopic {
        /// The parameter.
        parameter: &'static str,
        /// What it names.
        name: String,
    },
    /// `topics` and `leave_out` leave nothing.
    #[error("topics, leave_out: they leave no topic to record")]
    NothingLeft,
    /// A thread cannot be started, or ended before it should.
    #[error("{0}")]
    Thread(&'static str),
}

impl RecorderError {
    /// Whether a file that is there cannot be read, where all else is what could not be written.
    #[must_use]
    pub fn is_of_source(&self) -> bool {
        matches!(self, Self::File { what: READ, .. } | Self::Mcap { what: READ, .. } | Self::Damaged(_))
    }

    /// The error and what is behind it, without what libraries say in between.
    #[must_use]
    pub fn in_words(&self) -> String {
        let mut root = self.source();
        while let Some(deeper) = root.and_then(Error::source) {
            root = Some(deeper);
        }
        root.map_or_else(|| self.to_string(), |root| format!("{self}: {root}"))
    }

    /// Whether the disk has no room left.
    #[must_use]
    pub fn is_full_disk(&self) -> bool {
        let full = |error: &std::io::Error| {
            matches!(error.kind(), ErrorKind::StorageFull | ErrorKind::QuotaExceeded)
        };
        match self {
            Self::File { source, .. } | Self::Mcap { source: mcap::McapError::Io(source), .. } => {
                full(source)
            }
            _ => false,
        }
    }

    /// For `map_err` of file operations.
    pub fn file(what: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        move |source| Self::File { what, path: path.to_path_buf(), source }
    }

    /// For `map_err` of MCAP operations.
    pub fn mcap(what: &'static str, path: &Path) -> impl FnOnce(mcap::McapError) -> Self {
        move |source| Self::Mcap { what, path: path.to_path_buf(), source }
    }
}
