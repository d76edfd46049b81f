//! What a type is called on the wire and in a bag.

use serde::Serialize;
use serde::de::DeserializeOwned;

/// Name and text of a message definition.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Definition {
    /// ROS package, as `sensor_msgs`.
    pub package: &'static str,
    /// Type without package, as `Temperature`.
    pub name: &'static str,
    /// Text of the `.msg` file.
    pub text: &'static str,
    /// Definitions of the types of its fields.
    pub dependencies: &'static [&'static Self],
}

/// Line between the definitions of a schema: `rosbag2` and MCAP readers look for 80 equal signs.
const SEPARATOR: &str = "================================================================================";

impl Definition {
    /// Name in a bag and in `ros2 topic list -t`: `package/msg/Name`.
    #[must_use]
    pub fn full_name(&self) -> String {
        format!("{}/msg/{}", self.package, self.name)
    }

    /// Schema text of an MCAP channel (`ros2msg`): the definition and each type it needs once, with `MSG:` lines.
    #[must_use]
    pub fn schema_text(&self) -> String {
        let mut needed: Vec<&Self> = Vec::new();
        self.collect(&mut needed);
        let mut text = self.text.to_owned();
        for part in needed {
            text.push_str(&format!("{SEPARATOR}\nMSG: {}/{}\n{}", part.package, part.name, part.text));
        }
        text
    }

    /// Adds the dependencies that are not in `found` yet, nearest first.
    fn collect(&self, found: &mut Vec<&'static Self>) {
        for part in self.dependencies {
            if !found.contains(part) {
                found.push(part);
                part.collect(found);
            }
        }
    }
}

/// A message that can go over a topic and into a bag.
pub trait RosType: Serialize + DeserializeOwned + Send + 'static {
    /// Its definition.
    const DEFINITION: Definition;
}

/// A service.
pub trait RosService: 'static {
    /// What is asked.
    type Request: Serialize + DeserializeOwned + Send + Sync + 'static;
    /// What is answered.
    type Response: Serialize + DeserializeOwned + Send + Sync + 'static;
    /// ROS package.
    const PACKAGE: &'static str;
    /// Type without package.
    const NAME: &'static str;
    /// Text of the `.srv` file.
    const TEXT: &'static str;
    /// Definitions of the types of its fields.
    const DEPENDENCIES: &'static [&'static Definition] = &[];
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DiagnosticArray;

    #[test]
    fn a_schema_holds_every_nested_type_once() {
        let text = DiagnosticArray::DEFINITION.schema_text();
        for part in ["std_msgs/Header", "builtin_interfaces/Time", "diagnostic_msgs/DiagnosticStatus"] {
            assert_eq!(text.matches(&format!("MSG: {part}\n")).count(), 1, "{part}");
        }
        assert_eq!(SEPARATOR.len(), 80);
    }
}
