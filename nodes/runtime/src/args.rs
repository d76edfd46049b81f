//! ROS 2 arguments: what `ros2 run` and `launch_ros` pass to a node.
//!
//! `--ros-args -r [node:]from:=to | -r [node:]__node:=name | -r [node:]__ns:=/ns | -p [node:]name:=value | --params-file
//! FILE | --log-level [logger:=]LEVEL | --enclave PATH | --log-config-file FILE | --(en|dis)able-*-logs --`

use std::borrow::Cow;
use std::path::PathBuf;

/// What was asked for at the start.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Args {
    /// Name of the node in place of its own (`-r __node:=`).
    pub node: Option<String>,
    /// Namespace of the node (`-r __ns:=`).
    pub namespace: Option<String>,
    /// Name remappings in order (`-r from:=to`); `node:` in front of any remapping: for the node of this name alone.
    pub remaps: Vec<(String, String)>,
    /// Parameter overrides in order (`-p name:=value`); `node:` in front as in a parameter file.
    pub parameters: Vec<(String, String)>,
    /// Parameter files in order; a later one wins.
    pub params_files: Vec<PathBuf>,
    /// Log levels in order: logger (`None`: all) and level.
    pub log_levels: Vec<(Option<String>, LogLevel)>,
    /// Nothing is written to standard error.
    pub no_stdout_logs: bool,
    /// Nothing is published on `/rosout`.
    pub no_rosout_logs: bool,
    /// What was accepted and means nothing here.
    pub remarks: Vec<String>,
    /// Arguments outside of `--ros-args ... --`: the node's own.
    pub rest: Vec<String>,
}

/// Level of `--log-level`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LogLevel {
    /// Everything the developer wants.
    Debug,
    /// Normal course.
    Info,
    /// Something is odd.
    Warn,
    /// Something failed.
    Error,
}

impl LogLevel {
    /// The level as a filter directive names it.
    pub(crate) fn directive(self) -> &'static str {
        match self {
            Self::Debug => "debug",
            Self::Info => "info",
            Self::Warn => "warn",
            Self::Error => "error",
        }
    }

    /// `ros2` takes any case; `fatal` ends with the errors, `unset` is the default level.
    fn parse(text: &str) -> Option<Self> {
        match text.to_ascii_lowercase().as_str() {
            "debug" => Some(Self::Debug),
            "info" | "unset" => Some(Self::Info),
            "warn" | "warning" => Some(Self::Warn),
            "error" | "fatal" => Some(Self::Error),
            _ => None,
        }
    }
}

/// Why arguments or environment variables were refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ArgsError {
    /// An argument that is not known after `--ros-args`.
    #[error(
        "unknown argument '{0}' after --ros-args (known: -r, -p, --params-file, --log-level, --log-config-file, -e; --enable- and --disable-rosout-logs, -stdout-logs, \
         -external-lib-logs; --)"
    )]
    Unknown(String),
    /// An argument outside of `--ros-args` that this node does not take.
    #[error("unknown argument '{0}': this node takes only '--ros-args ...'")]
    NotTaken(String),
    /// An argument that is no UTF-8.
    #[error("argument '{0}' is no text in UTF-8")]
    NotText(String),
    /// An option without its value.
    #[error("argument '{0}' needs a value")]
    MissingValue(String),
    /// A pair without `:=`.
    #[error("argument '{option} {value}': expected {expected}")]
    Malformed {
        /// The option.
        option: String,
        /// What stood behind it.
        value: String,
        /// What should stand there.
        expected: &'static str,
    },
    /// An environment variable with a value that cannot be used.
    #[error("{name}={value}: must be {rule}")]
    Environment {
        /// Name of the variable.
        name: &'static str,
        /// Its value.
        value: String,
        /// What it may be.
        rule: &'static str,
    },
}

/// Longest name of a parameter `[byte]`.
pub(crate) const NAME_MAX: usize = 255;

impl Args {
    /// Arguments of this process.
    ///
    /// # Errors
    /// [`ArgsError`] for what is not understood.
    pub fn from_env() -> Result<Self, ArgsError> {
        let words = std::env::args_os().skip(1).map(|word| {
            word.into_string().map_err(|word| ArgsError::NotText(word.to_string_lossy().into_owned()))
        });
        Self::parse(words.collect::<Result<Vec<_>, _>>()?)
    }

    /// Parses arguments without the program's name. What stands before `--ros-args` or behind `--` goes to `rest`.
    ///
    /// # Errors
    /// [`ArgsError`] for what is not understood.
    pub fn parse(words: impl IntoIterator<Item = String>) -> Result<Self, ArgsError> {
        let mut args = Self::default();
        let mut words = words.into_iter();
        let mut ros = false;
        while let Some(word) = words.next() {
            match (ros, word.as_str()) {
                (false, "--ros-args") => ros = true,
                (false, _) => args.rest.push(word),
                (true, "--") => ros = false,
                // launch_ros repeats it once per source of arguments.
                (true, "--ros-args") => {}
                (true, _) => args.ros_argument(&word, &mut words)?,
            }
        }
        Ok(args)
    }

    /// Takes one ROS argument and its value in.
    fn ros_argument(
        &mut self,
        word: &str,
        words: &mut impl Iterator<Item = String>,
    ) -> Result<(), ArgsError> {
        let mut value = || words.next().ok_or_else(|| ArgsError::MissingValue(word.to_owned()));
        match word {
            "-r" | "--remap" => {
                let (from, to) = pair(word, &value()?)?;
                self.remap(from, to);
            }
            "-p" | "--param" => {
                let (name, value) = pair(word, &value()?)?;
                if name.len() > NAME_MAX {
                    let (option, value) = (word.to_owned(), short(&name));
                    return Err(ArgsError::Malformed {
                        option,
                        value,
                        expected: "a name of 255 bytes at most",
                    });
                }
                self.parameters.push((name, value));
            }
            "--params-file" => self.params_files.push(PathBuf::from(value()?)),
            "--log-level" => self.log_levels.push(log_level(word, &value()?)?),
            // Outputs that are always on here; launch files may still name them.
            "--enable-rosout-logs" | "--enable-stdout-logs" => {}
            "--disable-rosout-logs" => self.no_rosout_logs = true,
            "--disable-stdout-logs" => self.no_stdout_logs = true,
            // A library for logs beside those two: there is none.
            "--enable-external-lib-logs" | "--disable-external-lib-logs" => {}
            "--log-config-file" => {
                let file = value()?;
                self.remarks.push(format!(
                    "--log-config-file {}: is not read, as with the ROS default logger; levels: --log-level or RUST_LOG",
                    short(&file)
                ));
            }
            "-e" | "--enclave" => self.enclave(word, value()?)?,
            other => return Err(ArgsError::Unknown(short(other))),
        }
        Ok(())
    }

    /// The place of keys and certificates: there is no security for it to name.
    fn enclave(&mut self, word: &str, enclave: String) -> Result<(), ArgsError> {
        if !enclave.starts_with('/') {
            let (option, value) = (word.to_owned(), short(&enclave));
            return Err(ArgsError::Malformed { option, value, expected: "an absolute name, as /printer" });
        }
        self.remarks.push(format!("{word} {}: has no effect, DDS security is not built in", short(&enclave)));
        Ok(())
    }

    /// Sorts a remapping into node name, namespace or name. What is for one node alone waits until its name is known.
    fn remap(&mut self, from: String, to: String) {
        match from.as_str() {
            "__node" | "__name" => self.node = Some(to),
            "__ns" => self.namespace = Some(to),
            _ => self.remaps.push((from, to)),
        }
    }
}

/// Longest text of a person that is said again `[character]`.
const SAID: usize = 120;

/// A text in one line: whatever would move the cursor is written as its escape.
pub(crate) fn one_line(text: &str) -> Cow<'_, str> {
    let written = |letter: char| match letter.is_control() {
        true => letter.escape_default().to_string(),
        false => letter.to_string(),
    };
    if text.contains(char::is_control) { text.chars().map(written).collect() } else { Cow::Borrowed(text) }
}

/// A text as it is said again in one line: not its whole megabyte.
pub(crate) fn short(text: &str) -> String {
    let text = &*one_line(text);
    match text.char_indices().nth(SAID) {
        None => text.to_owned(),
        Some((end, _)) => format!("{}... ({} bytes)", &text[..end], text.len()),
    }
}

/// Longest word of a parser that is passed on `[character]`: it may list all names that there are.
const PARSED: usize = 1000;

/// Beginning and end of what a parser says, which may hold a whole value: the rule stands at the end.
pub(crate) fn ends(text: &str) -> String {
    let text = &*one_line(text);
    let count = text.chars().count();
    if count <= PARSED {
        return text.to_owned();
    }
    let front: String = text.chars().take(PARSED / 2).collect();
    let back: String = text.chars().skip(count - PARSED / 2).collect();
    format!("{front} ... {back}")
}

/// A name of a rule without the node that stands in front; `None` where that is another one.
pub(crate) fn of_node(rule: &str, is_meant: impl Fn(&str) -> bool) -> Option<&str> {
    // `rostopic://` and `rosservice://` begin a name.
    match rule.split_once(':').filter(|(_, rest)| !rest.starts_with("//")) {
        None => Some(rule),
        Some((node, name)) => is_meant(node).then_some(name),
    }
}

/// Splits `name:=value`.
fn pair(option: &str, text: &str) -> Result<(String, String), ArgsError> {
    match text.split_once(":=") {
        Some((name, value)) if !name.is_empty() => Ok((name.to_owned(), value.to_owned())),
        _ => Err(ArgsError::Malformed {
            option: option.to_owned(),
            value: short(text),
            expected: "name:=value",
        }),
    }
}

/// Parses `level` or `logger:=level`.
fn log_level(option: &str, text: &str) -> Result<(Option<String>, LogLevel), ArgsError> {
    let (logger, level) = match text.split_once(":=") {
        Some((logger, level)) => (Some(logger.to_owned()), level),
        None => (None, text),
    };
    let level = LogLevel::parse(level).ok_or_else(|| ArgsError::Malformed {
        option: option.to_owned(),
        value: short(text),
        expected: "debug, info, warn, error or fatal",
    })?;
    Ok((logger, level))
}

#[cfg(test)]
mod tests;
