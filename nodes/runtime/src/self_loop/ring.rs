//! The way of a number through DDS and back.

use crate::error::RuntimeError;
use crate::participants::Participants;
use rustdds::no_key::{DataWriterCdr, SimpleDataReaderCdr};
use rustdds::policy::{History, Reliability};
use rustdds::{DomainParticipant, QosPolicies, QosPolicyBuilder, TopicKind};

/// The ends of the loop.
pub(super) struct Ring {
    out: DataWriterCdr<u64>,
    back: SimpleDataReaderCdr<u64>,
    echo: Option<Echo>,
    // Kept to the end: the ends live as long as their participants.
    participants: Participants,
    session: u64,
}

/// Where the number turns round.
struct Echo {
    there: SimpleDataReaderCdr<u64>,
    back: DataWriterCdr<u64>,
}

impl Ring {
    /// Creates the topics, named after the session, so that no other process listens. They carry no ROS prefix and do not
    /// show in `ros2 topic list`.
    pub(super) fn new(participants: Participants, session: u64) -> Result<Self, RuntimeError> {
        Self::through(participants, session).map_err(|error| RuntimeError::create("self loop", &error))
    }

    fn through(participants: Participants, session: u64) -> rustdds::dds::CreateResult<Self> {
        let qos = QosPolicyBuilder::new()
            .reliability(Reliability::BestEffort)
            .history(History::KeepLast { depth: 1 })
            .build();
        let own = &participants.own;
        let name = |end: &str| format!("fdm_loop_self_{session:016x}_{end}");
        let Some(second) = &participants.echo else {
            let (out, back) = (writer(own, &name("alone"), &qos)?, reader(own, &name("alone"), &qos)?);
            return Ok(Self { out, back, echo: None, participants, session });
        };
        let echo =
            Echo { there: reader(second, &name("there"), &qos)?, back: writer(second, &name("back"), &qos)? };
        let (out, back) = (writer(own, &name("there"), &qos)?, reader(own, &name("back"), &qos)?);
        Ok(Self { out, back, echo: Some(echo), participants, session })
    }

    /// The participant is expected to hear itself.
    pub(super) fn is_alone(&self) -> bool {
        self.echo.is_none()
    }

    /// The same with an echo.
    pub(super) fn with_echo(self) -> Result<Self, RuntimeError> {
        let mut participants = self.participants;
        participants.add_echo()?;
        Self::new(participants, self.session)
    }

    /// Sends a number, passes on what the echo heard, and says whether one came back. A failed write shows as silence.
    pub(super) fn turn(&self, number: u64) -> bool {
        _ = self.out.write(number, None);
        if let Some(echo) = &self.echo
            && let Some(heard) = newest(&echo.there)
        {
            _ = echo.back.write(heard, None);
        }
        newest(&self.back).is_some()
    }
}

/// The newest number that is here.
fn newest(reader: &SimpleDataReaderCdr<u64>) -> Option<u64> {
    reader.drain_read_notifications();
    let mut newest = None;
    while let Ok(Some(sample)) = reader.try_take_one() {
        newest = Some(sample.into_value());
    }
    newest
}

/// Type name of both topics.
const TYPE: &str = "fdm_loop::SelfLoop";

fn writer(
    participant: &DomainParticipant,
    name: &str,
    qos: &QosPolicies,
) -> rustdds::dds::CreateResult<DataWriterCdr<u64>> {
    let topic = participant.create_topic(name.to_owned(), TYPE.to_owned(), qos, TopicKind::NoKey)?;
    participant.create_publisher(qos)?.create_datawriter_no_key_cdr(&topic, Some(qos.clone()))
}

fn reader(
    participant: &DomainParticipant,
    name: &str,
    qos: &QosPolicies,
) -> rustdds::dds::CreateResult<SimpleDataReaderCdr<u64>> {
    let topic = participant.create_topic(name.to_owned(), TYPE.to_owned(), qos, TopicKind::NoKey)?;
    participant.create_subscriber(qos)?.create_simple_datareader_no_key(&topic, Some(qos.clone()))
}
