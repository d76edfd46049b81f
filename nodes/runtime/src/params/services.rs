//! The six parameter services, `/parameter_events`, and changes as events.

use super::store::{Changed, Policy, Store};
use crate::clock::Clock;
use crate::error::RuntimeError;
use crate::lifecycle::Life;
use crate::node::Node;
use crate::publisher::Publisher;
use crate::service::Server;
use crate::topics;
use byteorder::LittleEndian;
use fdm_loop_msgs::{
    DescribeParameters, DescribeParametersResponse, GetParameterTypes, GetParameterTypesResponse,
    GetParameters, GetParametersResponse, Header, ListParameters, ListParametersResponse, Parameter,
    ParameterEvent, PrintEvent, SetParameters, SetParametersAtomically, SetParametersAtomicallyResponse,
    SetParametersResponse, SetParametersResult, State, Time,
};
use serde::Serialize;

/// The answering ends.
pub(crate) struct ParameterServices {
    list: Server<ListParameters>,
    get: Server<GetParameters>,
    kinds: Server<GetParameterTypes>,
    describe: Server<DescribeParameters>,
    set: Server<SetParameters>,
    set_together: Server<SetParametersAtomically>,
    changes: Changes,
}

/// What the answers are about.
pub(crate) struct Subject {
    pub(crate) store: Store,
    pub(crate) life: Life,
    pub(crate) clock: Clock,
    /// Name of the node with its namespace.
    pub(crate) node: String,
}

/// Where changes are told.
struct Changes {
    parameters: Publisher<ParameterEvent>,
    events: Publisher<PrintEvent>,
}

impl ParameterServices {
    /// Offers all of them.
    pub(crate) fn open(node: &mut Node) -> Result<Self, RuntimeError> {
        Ok(Self {
            list: node.serve(&topics::LIST_PARAMETERS)?,
            get: node.serve(&topics::GET_PARAMETERS)?,
            kinds: node.serve(&topics::GET_PARAMETER_TYPES)?,
            describe: node.serve(&topics::DESCRIBE_PARAMETERS)?,
            set: node.serve(&topics::SET_PARAMETERS)?,
            set_together: node.serve(&topics::SET_PARAMETERS_ATOMICALLY)?,
            changes: Changes {
                parameters: node.publish_on(&topics::PARAMETER_EVENTS)?,
                events: node.publish_on(&topics::EVENTS)?,
            },
        })
    }

    /// Announces the parameters and answers for ever.
    pub(crate) async fn serve(mut self, subject: Subject) {
        self.changes.parameters.send(ParameterEvent {
            stamp: Time::from_seconds(subject.clock.stamp().0),
            node: subject.node.clone(),
            new_parameters: subject.store.look(|view| view.all()),
            ..ParameterEvent::default()
        });
        loop {
            self.answer_next(&subject).await;
        }
    }

    async fn answer_next(&mut self, subject: &Subject) {
        let store = &subject.store;
        tokio::select! {
            asked = self.list.next() => {
                let result = store.look(|view| view.list(&asked.request.prefixes, asked.request.depth));
                self.list.answer(&asked, fitting(ListParametersResponse { result }, subject))
            }
            asked = self.get.next() => {
                let values = store.look(|view| view.get(&asked.request.names));
                self.get.answer(&asked, fitting(GetParametersResponse { values }, subject))
            }
            asked = self.kinds.next() => {
                let values = store.look(|view| view.get(&asked.request.names));
                let types = values.iter().map(|value| value.kind).collect();
                self.kinds.answer(&asked, fitting(GetParameterTypesResponse { types }, subject))
            }
            asked = self.describe.next() => {
                let descriptors = store.look(|view| view.describe(&asked.request.names, subject.policy()));
                self.describe.answer(&asked, fitting(DescribeParametersResponse { descriptors }, subject))
            }
            asked = self.set.next() => {
                let each = |wanted| self.changes.set(subject, std::slice::from_ref(wanted));
                let results = asked.request.parameters.iter().map(each).collect();
                self.set.answer(&asked, fitting(SetParametersResponse { results }, subject))
            }
            asked = self.set_together.next() => {
                let result = self.changes.set(subject, &asked.request.parameters);
                self.set_together.answer(&asked, SetParametersAtomicallyResponse { result })
            }
        };
    }
}

/// Longest answer that every DDS takes from us `[byte]`: beyond a datagram of 64 KiB Cyclone takes none, and the next ones
/// do not reach it either.
const ANSWER_MAX: usize = 64_000;

/// An answer that arrives: in place of one that is too long the empty one, and a line that says so. Nobody waits in vain.
fn fitting<T: Serialize + Default>(answer: T, subject: &Subject) -> T {
    let bytes = cdr_encoding::to_vec::<T, LittleEndian>(&answer).map_or(0, |bytes| bytes.len());
    if bytes <= ANSWER_MAX {
        return answer;
    }
    tracing::warn!(
        "{}: an answer of {bytes} bytes was asked for, {ANSWER_MAX} at most are sent: it is empty; ask for fewer names at once",
        subject.node
    );
    T::default()
}

impl Subject {
    /// What may be changed in the state that the node is in.
    fn policy(&self) -> Policy {
        match self.life.managed_state().map(|state| state.id) {
            None | Some(State::FINALIZED) => Policy::Nothing,
            Some(State::ACTIVE) => Policy::Declared,
            Some(State::INACTIVE | State::UNCONFIGURED) => Policy::All,
            Some(_) => Policy::UnderWay,
        }
    }
}

impl Changes {
    /// Sets these together and tells it, or refuses them.
    fn set(&self, subject: &Subject, wanted: &[Parameter]) -> SetParametersResult {
        match subject.store.set(wanted, subject.policy()) {
            Ok(changed) => {
                self.tell(subject, changed);
                SetParametersResult { successful: true, reason: String::new() }
            }
            Err(reason) => {
                tracing::warn!("parameter refused: {reason}");
                SetParametersResult { successful: false, reason }
            }
        }
    }

    fn tell(&self, subject: &Subject, changed: Vec<Changed>) {
        if changed.is_empty() {
            return;
        }
        let now = subject.clock.stamp();
        for Changed { parameter, before, after } in &changed {
            tracing::info!("{} = {after}, was {before}", parameter.name);
            self.events.send(PrintEvent {
                header: Header::at(now.0),
                severity: PrintEvent::SEVERITY_INFO,
                who: subject.node.clone(),
                what: "parameter_set".to_owned(),
                why: format!("{} was asked to be set", parameter.name),
                before: before.to_string(),
                after: after.to_string(),
            });
        }
        self.parameters.send(ParameterEvent {
            stamp: Time::from_seconds(now.0),
            node: subject.node.clone(),
            changed_parameters: changed.into_iter().map(|change| change.parameter).collect(),
            ..ParameterEvent::default()
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::Parameters;
    use fdm_loop_msgs::ParameterValue;

    /// 2000 values of 48 bytes and more are above 64 000 bytes, 500 are not.
    #[test]
    fn an_answer_that_would_not_arrive_is_empty() {
        let subject = Subject {
            store: Store::new(Parameters::default()),
            life: Life::default(),
            clock: Clock::monotonic(),
            node: "/printer/thermistor".to_owned(),
        };
        let values = |count| GetParametersResponse { values: vec![ParameterValue::default(); count] };
        assert_eq!(fitting(values(500), &subject).values.len(), 500);
        assert_eq!(fitting(values(2000), &subject), GetParametersResponse::default());
    }
}
