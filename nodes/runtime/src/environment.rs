//! Environment variables of ROS 2 that the client does not read.

use crate::args::{ArgsError, short};
use ros2_client::ServiceMapping;
use rustdds::{DomainParticipant, DomainParticipantBuilder};
use std::net::Ipv4Addr;

/// Where other nodes are looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Range {
    /// This host only: nothing is announced on other interfaces. The default.
    Localhost,
    /// Every interface.
    Subnet,
}

/// The settings of a process that the environment decides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Environment {
    /// `ROS_DOMAIN_ID`, 0 to 232: RTPS computes its ports from it.
    pub domain_id: u16,
    /// `ROS_AUTOMATIC_DISCOVERY_RANGE`, `ROS_LOCALHOST_ONLY`.
    pub range: Range,
    /// How services are written on DDS, by `RMW_IMPLEMENTATION`.
    pub(crate) services: Services,
}

/// How requests and replies find each other on DDS. (The client's `Basic` mapping is broken in 0.12.1.)
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Services {
    /// Sample identities in the protocol's header: Fast DDS.
    Enhanced,
    /// A header in the payload: Cyclone DDS.
    Cyclone,
}

impl Services {
    /// The client's form.
    pub(crate) fn mapping(self) -> ServiceMapping {
        match self {
            Self::Enhanced => ServiceMapping::Enhanced,
            Self::Cyclone => ServiceMapping::Cyclone,
        }
    }
}

/// Implementations whose mapping of services is known; the first is what an unknown one is taken for.
const KNOWN_RMW: [&str; 2] = ["rmw_fastrtps_cpp", "rmw_cyclonedds_cpp"];
/// The older variable for this host only: 1 is yes.
const LOCALHOST_ONLY: &str = "ROS_LOCALHOST_ONLY";

/// Highest domain whose ports fit into 16 bits.
const DOMAIN_MAX: u16 = 232;

impl Environment {
    /// Reads the variables of this process.
    ///
    /// # Errors
    /// [`ArgsError::Environment`] for a value that cannot be used.
    pub fn from_env() -> Result<Self, ArgsError> {
        Self::from_variables(|name| std::env::var(name).ok())
    }

    /// Reads the variables through `get`.
    ///
    /// # Errors
    /// [`ArgsError::Environment`] for a value that cannot be used.
    pub fn from_variables(get: impl Fn(&str) -> Option<String>) -> Result<Self, ArgsError> {
        let cyclone = get("RMW_IMPLEMENTATION").as_deref() == Some(KNOWN_RMW[1]);
        let services = if cyclone { Services::Cyclone } else { Services::Enhanced };
        Ok(Self { domain_id: domain(&get)?, range: range(&get)?, services })
    }

    /// What the variables ask for and this system has not, one line each.
    #[must_use]
    pub fn remarks(get: impl Fn(&str) -> Option<String>) -> Vec<String> {
        let set = |name| get(name).filter(|value| !value.is_empty());
        let mut remarks = Vec::new();
        if let Some(value) = set("RMW_IMPLEMENTATION").filter(|value| !KNOWN_RMW.contains(&value.as_str())) {
            let known = KNOWN_RMW.join(" or ");
            remarks.push(format!(
                "RMW_IMPLEMENTATION={}: not supported, {known} is; services speak as with {}, topics on DDS",
                short(&value),
                KNOWN_RMW[0]
            ));
        }
        for name in ["ROS_STATIC_PEERS", "ROS_DISCOVERY_SERVER"] {
            if let Some(value) = set(name) {
                remarks.push(format!(
                    "{name}={}: not supported; nodes are found by multicast and on this host",
                    short(&value)
                ));
            }
        }
        if let Some(value) = set(LOCALHOST_ONLY).filter(|value| value != "0" && value != "1") {
            remarks.push(format!("{LOCALHOST_ONLY}={}: must be 0 or 1; 0 is used", short(&value)));
        }
        remarks
    }

    /// Joins the domain.
    pub(crate) fn participant(&self) -> rustdds::dds::CreateResult<DomainParticipant> {
        let builder = DomainParticipantBuilder::new(self.domain_id);
        match self.range {
            Range::Localhost => builder.with_only_networks([Ipv4Addr::LOCALHOST]),
            Range::Subnet => builder,
        }
        .build()
    }
}

/// `ROS_DOMAIN_ID`.
fn domain(get: &impl Fn(&str) -> Option<String>) -> Result<u16, ArgsError> {
    let Some(value) = get("ROS_DOMAIN_ID").filter(|value| !value.is_empty()) else { return Ok(0) };
    match value.parse() {
        Ok(domain) if domain <= DOMAIN_MAX => Ok(domain),
        _ => Err(ArgsError::Environment { name: "ROS_DOMAIN_ID", value, rule: "a whole number in [0, 232]" }),
    }
}

/// `ROS_LOCALHOST_ONLY=1` wins over the range, as in ROS 2.
fn range(get: &impl Fn(&str) -> Option<String>) -> Result<Range, ArgsError> {
    const NAME: &str = "ROS_AUTOMATIC_DISCOVERY_RANGE";
    if get(LOCALHOST_ONLY).as_deref() == Some("1") {
        return Ok(Range::Localhost);
    }
    let value = get(NAME).unwrap_or_default();
    match value.as_str() {
        "" | "LOCALHOST" | "SYSTEM_DEFAULT" => Ok(Range::Localhost),
        "SUBNET" => Ok(Range::Subnet),
        _ => Err(ArgsError::Environment { name: NAME, value, rule: "LOCALHOST, SUBNET or SYSTEM_DEFAULT" }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn environment(pairs: &[(&str, &str)]) -> Result<Environment, ArgsError> {
        Environment::from_variables(|name| {
            pairs.iter().find(|(key, _)| *key == name).map(|(_, value)| (*value).to_owned())
        })
    }

    #[test]
    fn the_default_stays_on_this_host() {
        let default = environment(&[]).unwrap();
        assert_eq!((default.domain_id, default.range), (0, Range::Localhost));
    }

    #[test]
    fn localhost_only_wins_over_the_range() {
        let both = [("ROS_LOCALHOST_ONLY", "1"), ("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")];
        assert_eq!(environment(&both).unwrap().range, Range::Localhost);
        assert_eq!(environment(&both[1..]).unwrap().range, Range::Subnet);
    }

    #[test]
    fn values_out_of_range_are_refused_by_name() {
        let text = environment(&[("ROS_DOMAIN_ID", "233")]).unwrap_err().to_string();
        assert_eq!(text, "ROS_DOMAIN_ID=233: must be a whole number in [0, 232]");
        assert!(environment(&[("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")]).is_err());
    }

    #[test]
    fn services_are_written_as_the_middleware_variable_says() {
        let services = |name: &str| environment(&[("RMW_IMPLEMENTATION", name)]).unwrap().services;
        assert_eq!(services("rmw_cyclonedds_cpp"), Services::Cyclone);
        for name in ["rmw_fastrtps_cpp", "", "rmw_zenoh_cpp"] {
            assert_eq!(services(name), Services::Enhanced, "{name}");
        }
        assert_eq!(environment(&[]).unwrap().services, Services::Enhanced);
    }

    /// One line each, with name, value and what is used instead; nothing of what is supported.
    #[test]
    fn what_is_not_supported_is_told() {
        let remarks = |name: &str, value: &str| {
            Environment::remarks(|asked| (asked == name).then(|| value.to_owned())).join("|")
        };
        for (name, value, told) in [
            ("RMW_IMPLEMENTATION", "rmw_zenoh_cpp", "rmw_fastrtps_cpp or rmw_cyclonedds_cpp is"),
            ("ROS_STATIC_PEERS", "10.0.0.7", "found by multicast"),
            ("ROS_DISCOVERY_SERVER", "10.0.0.7:11811", "found by multicast"),
            ("ROS_LOCALHOST_ONLY", "7", "must be 0 or 1; 0 is used"),
        ] {
            let said = remarks(name, value);
            assert!(said.starts_with(&format!("{name}={value}: ")) && said.contains(told), "{said}");
            assert!(!said.contains('|'), "one line: {said}");
            assert_eq!(remarks(name, ""), "");
        }
        for (name, value) in [
            ("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp"),
            ("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp"),
            ("ROS_LOCALHOST_ONLY", "0"),
            ("ROS_LOCALHOST_ONLY", "1"),
        ] {
            assert_eq!(remarks(name, value), "");
        }
    }
}
