//! The six parameter services and `/parameter_events`.

use super::store::Store;
use crate::clock::Clock;
use crate::error::RuntimeError;
use crate::node::Node;
use crate::publisher::Publisher;
use crate::service::Server;
use crate::topics;
use fdm_loop_msgs::{
    DescribeParameters, DescribeParametersResponse, GetParameterTypes, GetParameterTypesResponse,
    GetParameters, GetParametersResponse, ListParameters, ListParametersResponse, ParameterEvent,
    SetParameters, SetParametersAtomically, SetParametersAtomicallyResponse, SetParametersResponse, Time,
};

/// The answering ends.
pub(crate) struct ParameterServices {
    list: Server<ListParameters>,
    get: Server<GetParameters>,
    kinds: Server<GetParameterTypes>,
    describe: Server<DescribeParameters>,
    set: Server<SetParameters>,
    set_together: Server<SetParametersAtomically>,
    events: Publisher<ParameterEvent>,
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
            events: node.publish_on(&topics::PARAMETER_EVENTS)?,
        })
    }

    /// Announces the parameters and answers for ever.
    pub(crate) async fn serve(mut self, store: Store, clock: Clock, node: String) {
        self.events.send(ParameterEvent {
            stamp: Time::from_seconds(clock.now().0),
            node,
            new_parameters: store.all(),
            ..ParameterEvent::default()
        });
        loop {
            self.answer_next(&store).await;
        }
    }

    async fn answer_next(&mut self, store: &Store) {
        tokio::select! {
            asked = self.list.next() => {
                let result = store.list(&asked.request.prefixes, asked.request.depth);
                self.list.answer(&asked, ListParametersResponse { result })
            }
            asked = self.get.next() => {
                let values = store.get(&asked.request.names);
                self.get.answer(&asked, GetParametersResponse { values })
            }
            asked = self.kinds.next() => {
                let types = store.get(&asked.request.names).iter().map(|value| value.kind).collect();
                self.kinds.answer(&asked, GetParameterTypesResponse { types })
            }
            asked = self.describe.next() => {
                let descriptors = store.describe(&asked.request.names);
                self.describe.answer(&asked, DescribeParametersResponse { descriptors })
            }
            asked = self.set.next() => {
                let each = |wanted| store.set(std::slice::from_ref(wanted));
                let results = asked.request.parameters.iter().map(each).collect();
                self.set.answer(&asked, SetParametersResponse { results })
            }
            asked = self.set_together.next() => {
                let result = store.set(&asked.request.parameters);
                self.set_together.answer(&asked, SetParametersAtomicallyResponse { result })
            }
        };
    }
}
