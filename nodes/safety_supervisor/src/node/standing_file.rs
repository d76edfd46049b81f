//! Mode and pause on disk, beside the latch: a restart of the supervisor is no order to correct or to go on.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::record::{self, Record};
use crate::cause::Cause;
use crate::event::Evidence;
use crate::modes::Standing;
use crate::params::StartMode;

/// Version of the record that this build writes and reads.
const VERSION: u64 = 1;

/// Keeps mode and pause of the brain and those on disk the same.
pub(super) type StandingFile = Record<Written>;

/// The record as it is written, with what the pause rested on: no field but that and a standby that is none may be missing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Written {
    version: u64,
    #[serde(deserialize_with = "Option::deserialize")]
    mode: Option<StartMode>,
    #[serde(deserialize_with = "Option::deserialize")]
    paused: Option<Cause>,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    standby: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    value: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    limit: Option<f64>,
}

impl Written {
    pub(super) fn new(Standing { mode, paused, standby }: Standing, evidence: Option<Evidence>) -> Self {
        let (value, limit) = (evidence.map(|number| number.value), evidence.and_then(|number| number.limit));
        Self { version: VERSION, mode, paused, standby, value, limit }
    }

    /// What the pause rested on; `None` where the record does not tell.
    pub(super) fn evidence(self) -> Option<Evidence> {
        Evidence::of(self.paused?, self.value?, self.limit)
    }
}

impl From<Standing> for Written {
    fn from(standing: Standing) -> Self {
        Self::new(standing, None)
    }
}

impl From<Written> for Standing {
    fn from(Written { mode, paused, standby, .. }: Written) -> Self {
        Self { mode, paused, standby }
    }
}

/// The record beside a latch.
pub(super) fn path_of(latch: &Path) -> PathBuf {
    latch.with_extension("standing.json")
}

impl StandingFile {
    /// Reads what a former run left behind beside its latch; without a path nothing is kept. What cannot be read is taken
    /// for the strictest that can, and the reason is told.
    pub(super) fn open(latch: Option<&Path>) -> (Self, Option<String>) {
        let path = latch.map(path_of);
        let (stored, refused) = match path.as_deref().and_then(|path| record::read(path, parse)) {
            None => (None, None),
            Some(Ok(written)) => (Some(written), None),
            Some(Err(error)) => (Some(Standing::UNREADABLE.into()), Some(error)),
        };
        let refused = path.as_deref().zip(refused).map(|(path, error)| {
            let told = format!("{}: {error}: taken for observe, paused", path.display());
            tracing::error!("{told}");
            told
        });
        (Self::new(path, stored), refused)
    }
}

/// A record, of this version alone: another one may mean something else.
fn parse(bytes: &[u8]) -> Result<Written, String> {
    #[derive(Deserialize)]
    struct Version {
        version: u64,
    }
    let told = |error: serde_json::Error| error.to_string();
    let Version { version } = serde_json::from_slice(bytes).map_err(told)?;
    if version != VERSION {
        return Err(format!("version = {version}: must be {VERSION}"));
    }
    serde_json::from_slice(bytes).map_err(told)
}

#[cfg(test)]
mod tests;
