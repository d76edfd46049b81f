//! What a check found.

use serde::Serialize;

/// How much it matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Level {
    Ok,
    /// The graph runs, something else may not.
    Warn,
    /// The graph cannot run as it should.
    Fail,
}

/// One check.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(super) struct Finding {
    pub(super) name: &'static str,
    pub(super) level: Level,
    /// What is there.
    pub(super) found: String,
    /// Next step for a person; empty where nothing is to be done.
    pub(super) what_to_do: String,
}

impl Finding {
    pub(super) fn ok(name: &'static str, found: impl Into<String>) -> Self {
        Self { name, level: Level::Ok, found: found.into(), what_to_do: String::new() }
    }

    pub(super) fn warn(name: &'static str, found: impl Into<String>, what_to_do: impl Into<String>) -> Self {
        Self { name, level: Level::Warn, found: found.into(), what_to_do: what_to_do.into() }
    }

    pub(super) fn fail(name: &'static str, found: impl Into<String>, what_to_do: impl Into<String>) -> Self {
        Self { name, level: Level::Fail, found: found.into(), what_to_do: what_to_do.into() }
    }
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let level = match self.level {
            Level::Ok => "ok",
            Level::Warn => "warn",
            Level::Fail => "FAIL",
        };
        write!(f, "{level:<5} {:<14} {}", self.name, self.found)?;
        for line in self.what_to_do.lines() {
            write!(f, "\n{:20} -> {line}", "")?;
        }
        Ok(())
    }
}
