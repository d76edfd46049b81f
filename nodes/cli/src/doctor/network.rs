//! What DDS needs of this machine: domain, interfaces, multicast, free places.

use super::finding::Finding;
use super::machine::Machine;
use super::netlink;
use runtime::{Environment, Range};

/// Flags of an interface, `linux/if.h`.
const UP: u32 = 0x1;
const LOOPBACK: u32 = 0x8;
const MULTICAST: u32 = 0x1000;
/// Processes of a domain that find each other on a `lo` without multicast.
const ALONE: u32 = 12;
/// Processes of the graph, `fdm` itself, and one to look at it.
const GRAPH: u32 = 12;
/// Ports of RTPS 2.5, 9.6.2.3: base, per domain, first and second port of a participant.
const PORT_BASE: u32 = 7400;
const PORT_DOMAIN: u32 = 250;
const PORT_FIRST: u32 = 10;
const PORT_STEP: u32 = 2;
/// Participants that have a port in a domain.
const PARTICIPANTS_MAX: u32 = 120;

/// Variables that decide who is heard; nothing further where they cannot be used.
pub(super) fn environment() -> Vec<Finding> {
    const NAME: &str = "domain";
    let environment = match Environment::from_env() {
        Ok(environment) => environment,
        Err(error) => return vec![Finding::fail(NAME, error.to_string(), "change or unset that variable")],
    };
    let range = match environment.range {
        Range::Localhost => "this host alone",
        Range::Subnet => "every interface",
    };
    vec![Finding::ok(NAME, format!("ROS_DOMAIN_ID {}, discovery on {range}", environment.domain_id))]
}

/// Loopback, and the interfaces that lead out, of the network namespace that this runs in.
pub(super) fn interfaces() -> Vec<Finding> {
    let all = match netlink::interfaces() {
        Ok(all) => all,
        Err(error) => return vec![Finding::warn("loopback", format!("not known: {error}"), "")],
    };
    let out: Vec<&str> = all
        .iter()
        .filter(|(_, flags)| flags & UP != 0 && flags & LOOPBACK == 0)
        .map(|(name, _)| name.as_str())
        .collect();
    let out = if out.is_empty() { "none".to_owned() } else { out.join(", ") };
    vec![loopback(&all), Finding::ok("interfaces", format!("up beside loopback: {out}"))]
}

fn loopback(all: &[(String, u32)]) -> Finding {
    const NAME: &str = "loopback";
    let lo = all.iter().find(|(_, flags)| flags & LOOPBACK != 0);
    match lo {
        None => Finding::fail(NAME, "there is none", "the nodes talk over it: sudo ip link set lo up"),
        Some((name, flags)) if flags & UP == 0 => {
            Finding::fail(NAME, format!("{name} is down"), format!("sudo ip link set {name} up"))
        }
        Some((name, flags)) if flags & MULTICAST == 0 => Finding::warn(
            NAME,
            format!(
                "{name} is up, without multicast: {ALONE} processes a domain find each other, enough for one printer"
            ),
            format!(
                "for more, or for other ROS 2 tools:\nsudo ip link set {name} multicast on\nsudo ip route add 239.0.0.0/8 dev {name}"
            ),
        ),
        Some((name, _)) => Finding::ok(NAME, format!("{name} is up, with multicast")),
    }
}

/// Participants of the domain that are there already.
pub(super) fn participants(machine: &Machine) -> Finding {
    const NAME: &str = "neighbours";
    let domain = Environment::from_env().map_or(0, |environment| u32::from(environment.domain_id));
    let ports = [machine.text("proc/net/udp"), machine.text("proc/net/udp6")];
    let taken = taken(&ports.into_iter().flatten().collect::<String>(), domain);
    let found = format!("{taken} participants of domain {domain} on this host");
    if taken + GRAPH > PARTICIPANTS_MAX {
        return Finding::fail(
            NAME,
            found,
            "there is no place left: end them, or choose another ROS_DOMAIN_ID",
        );
    }
    match taken {
        0 => Finding::ok(NAME, found),
        _ => Finding::warn(
            NAME,
            found,
            "a graph runs already, or a tool: a second one needs another --namespace or ROS_DOMAIN_ID",
        ),
    }
}

/// Participants with a port in a table of `/proc/net`.
fn taken(table: &str, domain: u32) -> u32 {
    let port = |line: &str| {
        let local = line.split_whitespace().nth(1)?;
        u32::from_str_radix(local.rsplit_once(':')?.1, 16).ok()
    };
    let ports: Vec<u32> = table.lines().filter_map(port).collect();
    let first = PORT_BASE + PORT_DOMAIN * domain + PORT_FIRST;
    let is_taken = |number: &u32| ports.contains(&(first + PORT_STEP * number));
    u32::try_from((0..PARTICIPANTS_MAX).filter(is_taken).count()).unwrap_or(PARTICIPANTS_MAX)
}

#[cfg(test)]
mod tests {
    use super::super::finding::Level;
    use super::*;

    #[test]
    fn loopback_by_its_flags() {
        let level = |flags: u32| loopback(&[("eth0".to_owned(), 0x1003), ("lo".to_owned(), flags)]).level;
        assert_eq!([level(0x9), level(0x1009), level(0x8)], [Level::Warn, Level::Ok, Level::Fail]);
        assert_eq!(loopback(&[]).level, Level::Fail);
    }

    /// Domain 7: 7400 + 250 * 7 + 10 = 9160, 0x23C8; the second participant has 0x23CA.
    #[test]
    fn participants_are_counted_by_their_ports() {
        let table = "  sl  local_address rem_address\n   1: 00000000:23C8 00000000:0000 07\n   2: 00000000:23CA x\n   \
                     3: 00000000:1CF2 x\n";
        assert_eq!([taken(table, 7), taken(table, 0), taken("", 0)], [2, 1, 0]);
    }
}
