//! Environment variables of ROS 2 that the client does not read.

use crate::args::ArgsError;
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
        let cyclone = get("RMW_IMPLEMENTATION").as_deref() == Some("rmw_cyclonedds_cpp");
        let services = if cyclone { Services::Cyclone } else { Services::Enhanced };
        Ok(Self { domain_id: domain(&get)?, range: range(&get)?, services })
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
    if get("ROS_LOCALHOST_ONLY").as_deref() == Some("1") {
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
    fn cyclone_services_are_chosen_by_the_middleware_variable() {
        let cyclone = environment(&[("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp")]).unwrap();
        assert_eq!(cyclone.services, Services::Cyclone);
    }
}
