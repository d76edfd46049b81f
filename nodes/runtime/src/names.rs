//! From a name as declared to the one on the graph: namespace, `~` and remappings.

use crate::args::{Args, of_node, short};
use crate::error::RuntimeError;
use ros2_client::{Name, NodeName};

/// Namespace where none is asked for: every printer has its own.
pub(crate) const DEFAULT_NAMESPACE: &str = "/printer";

/// What a rule calls the node's own name and namespace.
const OWN: [&str; 3] = ["__node", "__name", "__ns"];

/// The name or namespace that a rule for this node alone gives it.
fn own<'a>(args: &'a Args, node: &str, what: &str) -> Option<&'a str> {
    let fits = |from: &str| from.contains(':') && of_node(from, |other| other == node) == Some(what);
    args.remaps.iter().find(|(from, _)| fits(from)).map(|(_, to)| to.as_str())
}

/// Whether every part of an absolute name is one: the client itself asks only when a topic is made.
fn is_valid(absolute: &str) -> bool {
    let fits = |part: &str| {
        !part.starts_with(|first: char| first.is_ascii_digit())
            && !part.is_empty()
            && part.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
    };
    absolute.strip_prefix('/').is_some_and(|parts| parts.split('/').all(fits))
}

/// Passes a namespace as ROS writes it: `/`, or parts of letters, digits and `_` that begin with no digit, each behind a `/`.
///
/// # Errors
/// What is wrong with it, and one that may be meant.
pub fn check_namespace(namespace: &str) -> Result<String, NamespaceError> {
    let fault = if namespace == "/" || is_valid(namespace) {
        return Ok(namespace.to_owned());
    } else if !namespace.starts_with('/') {
        "begins with no /"
    } else {
        "each part of it has letters, digits and _ alone and begins with no digit"
    };
    let part = |part: &str| {
        let letter = |letter: char| if letter.is_ascii_alphanumeric() { letter } else { '_' };
        let gap = if part.starts_with(|first: char| first.is_ascii_digit()) { "/_" } else { "/" };
        gap.chars().chain(part.chars().map(letter)).collect::<String>()
    };
    let meant: String = namespace.split('/').filter(|part| !part.is_empty()).map(part).collect();
    Err(NamespaceError {
        given: short(namespace),
        fault,
        meant: if meant.is_empty() { "/printer".to_owned() } else { short(&meant) },
    })
}

/// A namespace that ROS does not know.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("namespace '{given}': {fault}: write {meant}")]
pub struct NamespaceError {
    given: String,
    fault: &'static str,
    meant: String,
}

/// Name of the node and the remappings in force.
#[derive(Debug, Clone)]
pub(crate) struct Names {
    node: NodeName,
    remaps: Vec<(String, String)>,
}

impl Names {
    /// Checks the node's name and all remappings.
    pub(crate) fn new(default_node: &str, args: &Args) -> Result<Self, RuntimeError> {
        // A rule for one node knows it by its own name; all others by the one that it gets.
        let base = args.node.as_deref().or_else(|| own(args, default_node, "__node"));
        let base = base.or_else(|| own(args, default_node, "__name")).unwrap_or(default_node);
        let namespace = args.namespace.as_deref().or_else(|| own(args, base, "__ns"));
        let namespace = check_namespace(namespace.unwrap_or(DEFAULT_NAMESPACE))?;
        let node = NodeName::new(&namespace, base).ok().filter(|node| is_valid(&node.fully_qualified_name()));
        let node = node.ok_or_else(|| RuntimeError::Name {
            name: short(base),
            rule: "a node's name has letters, digits and _ alone and begins with no digit",
        })?;
        let mut names = Self { node, remaps: Vec::new() };
        for (from, to) in &args.remaps {
            let Some(from) = of_node(from, |node| node == names.base()) else { continue };
            if OWN.contains(&from) {
                continue;
            }
            let pair = (names.expand(from), names.expand(to));
            names.check(&pair.0)?;
            names.check(&pair.1)?;
            names.remaps.push(pair);
        }
        Ok(names)
    }

    /// The node's name as the client wants it.
    pub(crate) fn node(&self) -> &NodeName {
        &self.node
    }

    /// Name without namespace.
    pub(crate) fn base(&self) -> &str {
        self.node.base_name()
    }

    /// Name with namespace.
    pub(crate) fn qualified(&self) -> String {
        self.node.fully_qualified_name()
    }

    /// Absolute name of a topic or service after remapping.
    pub(crate) fn resolve(&self, name: &str) -> String {
        let name = self.expand(name);
        self.remaps.iter().find(|(from, _)| *from == name).map_or(name, |(_, to)| to.clone())
    }

    /// The client's form of an absolute name.
    pub(crate) fn check(&self, absolute: &str) -> Result<Name, RuntimeError> {
        Name::parse(absolute).ok().filter(|_| is_valid(absolute)).ok_or_else(|| RuntimeError::Name {
            name: short(absolute),
            rule: "each part between single / has letters, digits and _ alone and begins with no digit",
        })
    }

    /// Makes a name absolute.
    fn expand(&self, name: &str) -> String {
        if name.starts_with('/') {
            name.to_owned()
        } else if let Some(private) = name.strip_prefix("~/") {
            format!("{}/{private}", self.qualified())
        } else {
            format!("{}/{name}", self.node.namespace().trim_end_matches('/'))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(line: &str) -> Result<Names, RuntimeError> {
        Names::new("thermistor", &Args::parse(line.split_whitespace().map(str::to_owned)).unwrap())
    }

    #[test]
    fn relative_absolute_and_private_names() {
        let names = names("--ros-args -r __ns:=/a/b").unwrap();
        assert_eq!(names.resolve("printer/state"), "/a/b/printer/state");
        assert_eq!(names.resolve("/clock"), "/clock");
        assert_eq!(names.resolve("~/status"), "/a/b/thermistor/status");
        assert_eq!(self::names("").unwrap().resolve("events"), "/printer/events");
        assert_eq!(self::names("--ros-args -r __ns:=/").unwrap().resolve("events"), "/events");
    }

    #[test]
    fn a_remapping_holds_for_the_resolved_name() {
        let names = names("--ros-args -r events:=/all/events -r /clock:=sim_clock").unwrap();
        assert_eq!(names.resolve("/printer/events"), "/all/events");
        assert_eq!(names.resolve("/clock"), "/printer/sim_clock");
    }

    /// `-r node:from:=to`, as one launch file for several nodes has it: each takes its own.
    #[test]
    fn a_remapping_may_be_for_one_node_alone() {
        let line = "--ros-args -r thermistor:__node:=warm -r imu:__node:=moved -r warm:__ns:=/a -r imu:__ns:=/b \
                    -r warm:events:=said -r imu:events:=heard -r thermistor:clock:=other";
        let names = names(line).unwrap();
        assert_eq!(names.qualified(), "/a/warm");
        assert_eq!(names.resolve("events"), "/a/said");
        assert_eq!(names.resolve("clock"), "/a/clock", "the node is called warm");
    }

    #[test]
    fn bad_names_are_refused() {
        assert!(names("--ros-args -r __node:=1st").is_err());
        assert!(names("--ros-args -r a:=b//c").is_err());
        let said = names("--ros-args -r a:=/x/1b").unwrap_err().to_string();
        assert!(said.ends_with("has letters, digits and _ alone and begins with no digit"), "{said}");
    }

    /// A namespace that is refused is told with one that may be meant.
    #[test]
    fn bad_namespaces_are_refused_with_a_good_one() {
        let line = "--ros-args -r __ns:=left";
        let said = names(line).unwrap_err().to_string();
        assert_eq!(said, "namespace 'left': begins with no /: write /left");
        let meant =
            |given| check_namespace(given).unwrap_err().to_string().split("write ").nth(1).map(str::to_owned);
        for (given, wanted) in [
            ("/1a", "/_1a"),
            ("/a b/", "/a_b"),
            ("a//b", "/a/b"),
            ("/left/", "/left"),
            ("", "/printer"),
            ("//", "/printer"),
        ] {
            assert_eq!(meant(given).as_deref(), Some(wanted), "{given}");
            assert_eq!(check_namespace(wanted).as_deref(), Ok(wanted));
        }
        for fine in ["/", "/left", "/a/b_1"] {
            assert_eq!(check_namespace(fine).as_deref(), Ok(fine));
        }
    }
}
