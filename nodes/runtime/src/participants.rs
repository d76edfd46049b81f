//! Joining a domain with the one or two participants of a process.
//!
//! Where the loopback interface carries multicast a participant hears itself. Elsewhere a second one, the echo, sends its
//! messages back.
//!
//! On a `lo` without multicast RustDDS 0.15.1 announces itself to the participant numbers 0 to 11 of the host alone
//! (`SPDP_LOCALHOST_PEER_COUNT`): two participants with higher numbers never find each other. A participant takes the
//! lowest free number. So the numbers below 12 are kept for nodes: the echo participant of the self loop, which only its
//! own node must find, is pushed above them by holding the free ports while it chooses. Processes of one domain do this
//! in turn. Twelve processes a domain see each other this way; with multicast there is no such limit.

use crate::environment::Environment;
use crate::error::RuntimeError;
use rustdds::DomainParticipant;
use rustix::fs::{FlockOperation, flock};
use std::fs::File;
use std::net::{Ipv4Addr, UdpSocket};
use std::time::Duration;

/// Participant numbers that are announced to on a `lo` without multicast.
const ANNOUNCED: u16 = 12;
/// Tries to get a turn, and the pause between them: together longer than twelve processes take one after another. A
/// process that was stopped in its turn does not keep the others from starting.
const TRIES: u32 = 150;
const PAUSE: Duration = Duration::from_millis(20);

/// The participants of a process.
pub(crate) struct Participants {
    /// The node's.
    pub(crate) own: DomainParticipant,
    /// The one that sends the node's own messages back, where it does not hear itself.
    pub(crate) echo: Option<DomainParticipant>,
    environment: Environment,
}

impl Participants {
    /// Joins the domain.
    pub(crate) fn join(environment: &Environment) -> Result<Self, RuntimeError> {
        let _turn = turn(environment.domain_id);
        let own = environment.participant().map_err(|error| RuntimeError::create("participant", &error))?;
        let hears_itself = lo_has_multicast();
        if own.participant_id() >= ANNOUNCED && !hears_itself {
            tracing::warn!(
                "participant {} of domain {}: without multicast only the first {ANNOUNCED} processes see each other",
                own.participant_id(),
                environment.domain_id
            );
        }
        let echo = if hears_itself { None } else { Some(echo(environment)?) };
        Ok(Self { own, echo, environment: *environment })
    }

    /// An echo for a participant that was expected to hear itself and does not.
    pub(crate) fn add_echo(&mut self) -> Result<(), RuntimeError> {
        let _turn = turn(self.environment.domain_id);
        self.echo = Some(echo(&self.environment)?);
        Ok(())
    }
}

/// A participant above the numbers that are kept for nodes.
fn echo(environment: &Environment) -> Result<DomainParticipant, RuntimeError> {
    let port_of = |number| (Ipv4Addr::UNSPECIFIED, port(environment.domain_id, number));
    let ports: Vec<UdpSocket> =
        (0..ANNOUNCED).filter_map(|number| UdpSocket::bind(port_of(number)).ok()).collect();
    let echo = environment.participant().map_err(|error| RuntimeError::create("echo participant", &error))?;
    drop(ports);
    Ok(echo)
}

/// Whether the loopback interface was told to carry multicast (`ip link set lo multicast on`), in this process's own
/// network namespace: `/sys` may show another one.
pub(crate) fn lo_has_multicast() -> bool {
    netdev::get_interfaces().iter().any(|interface| interface.is_loopback() && interface.is_multicast())
}

/// Port of a participant's discovery: RTPS 2.5, 9.6.2.3, `PB + DG domain + d1 + PG participant`. Domains up to 232 and
/// numbers below 12 stay below 2^16.
pub(crate) fn port(domain: u16, number: u16) -> u16 {
    7400_u16.saturating_add(domain.saturating_mul(250)).saturating_add(10 + 2 * number)
}

/// Waits for this process's turn in the domain; the lock ends with the file. Without a lock the process starts all the
/// same: the order matters where several start at once.
fn turn(domain: u16) -> Option<File> {
    let path = std::env::temp_dir().join(format!("fdm_loop_domain_{domain}.lock"));
    // Another user's file can be locked too, though not written.
    let file = File::options().append(true).create(true).open(&path).or_else(|_| File::open(&path)).ok()?;
    for _ in 0..TRIES {
        if flock(&file, FlockOperation::NonBlockingLockExclusive).is_ok() {
            return Some(file);
        }
        std::thread::sleep(PAUSE);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn discovery_ports_are_those_of_the_standard() {
        assert_eq!(port(0, 0), 7410);
        assert_eq!(port(0, 1), 7412);
        assert_eq!(port(232, 11), 65432);
    }
}
