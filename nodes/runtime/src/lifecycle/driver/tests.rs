use super::*;
use crate::args::Args;
use crate::error::RuntimeError;
use crate::params::store::Policy;
use fdm_loop_msgs::{Parameter, ParameterValue, State, Transition};
use std::cell::Cell;

/// What the shell under test takes.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Params {
    /// Told while it works.
    number: i64,
    /// It cannot be configured.
    broken: bool,
    /// It cannot begin to work.
    unwritable: bool,
}

#[derive(Debug, thiserror::Error)]
enum Refused {
    #[error("parameters")]
    Parameters(#[from] RuntimeError),
    #[error("broken")]
    Broken,
    #[error("unwritable")]
    Unwritable,
}

/// A driven node, and what its shell works with (0: it does not work).
struct Bench {
    node: Node,
    orders: mpsc::Sender<Order>,
    number: Cell<i64>,
}

impl Bench {
    fn new(name: &str, parameters: &[(&str, &str)]) -> (Self, mpsc::Receiver<Order>) {
        let own = [("number", "1"), ("broken", "false"), ("unwritable", "false")];
        let parameters = own.iter().chain(parameters).map(|(name, value)| ((*name).into(), (*value).into()));
        let args = Args { parameters: parameters.collect(), ..Args::default() };
        let (orders, receiver) = mpsc::channel(1);
        let node = Node::start_with(name, args).unwrap();
        (Self { node, orders, number: Cell::new(0) }, receiver)
    }

    async fn shell(&self, mut node: Node) -> Result<(), Refused> {
        let params: Params = node.parameters()?;
        if params.broken {
            return Err(Refused::Broken);
        }
        node.activated().await;
        if params.unwritable {
            return Err(Refused::Unwritable);
        }
        self.number.set(params.number);
        node.shutdown().await;
        self.number.set(0);
        Ok(())
    }

    /// Drives the shell through what `steps` asks for, and ends the process.
    async fn drive(&self, orders: mpsc::Receiver<Order>, autostart: bool, steps: impl Future<Output = ()>) {
        let steps = async {
            steps.await;
            self.node.stop();
        };
        let (end, ()) = tokio::join!(drive(&self.node, |node| self.shell(node), orders, autostart), steps);
        end.unwrap();
    }

    /// Asks for a step; `None` where it is refused at once.
    fn ask(&self, id: u8) -> Option<oneshot::Receiver<bool>> {
        let step = self.node.life().request(&Transition { id, label: String::new() })?;
        let (ended, end) = oneshot::channel();
        self.orders.try_send(Order { step, ended }).unwrap();
        Some(end)
    }

    /// Asks for a step and waits for its end.
    async fn to(&self, id: u8) -> bool {
        self.ask(id).unwrap().await.unwrap()
    }

    fn set(&self, name: &str, value: ParameterValue) {
        let wanted = [Parameter { name: name.to_owned(), value }];
        self.node.store().set(&wanted, Policy::All).unwrap();
    }

    fn set_broken(&self, broken: bool) {
        self.set("broken", flag(broken));
    }

    fn state(&self) -> u8 {
        self.node.life().state().id
    }
}

fn flag(flag: bool) -> ParameterValue {
    ParameterValue { kind: ParameterValue::BOOL, bool_value: flag, ..ParameterValue::default() }
}

fn integer(number: i64) -> ParameterValue {
    ParameterValue { kind: ParameterValue::INTEGER, integer_value: number, ..ParameterValue::default() }
}

/// Lets the driver go on until it waits.
async fn idle() {
    for _ in 0..10 {
        tokio::task::yield_now().await;
    }
}

/// Whatever is asked for while a node is configured anew in vain is answered, and leaves a node that can be asked again.
#[tokio::test]
async fn a_step_during_a_configuration_that_fails_is_answered() {
    let (bench, orders) = Bench::new("in_vain", &[]);
    let steps = async {
        for (id, success) in [(Transition::ACTIVATE, false), (Transition::CLEANUP, true)] {
            assert!(bench.to(Transition::CONFIGURE).await);
            bench.set_broken(true);
            assert_eq!(bench.to(id).await, success, "transition {id}");
            assert_eq!((bench.state(), bench.number.get()), (State::UNCONFIGURED, 0), "transition {id}");
            assert!(bench.ask(Transition::ACTIVATE).is_none(), "refused, not lost");
            assert!(!bench.to(Transition::CONFIGURE).await, "as broken as before");
            bench.set_broken(false);
        }
        assert!(bench.to(Transition::CONFIGURE).await && bench.to(Transition::ACTIVATE).await);
        assert_eq!((bench.state(), bench.number.get()), (State::ACTIVE, 1), "active, and at work");
        assert!(bench.to(Transition::DEACTIVATE).await);
        bench.set_broken(true);
        assert!(bench.to(Transition::INACTIVE_SHUTDOWN).await);
        assert_eq!(bench.state(), State::FINALIZED);
    };
    bench.drive(orders, false, steps).await;
}

/// A parameter that was set before `activate` was asked for is in force when that has succeeded.
#[tokio::test]
async fn what_was_set_before_an_activation_holds_in_it() {
    let (bench, orders) = Bench::new("in_force", &[]);
    let steps = async {
        assert!(bench.to(Transition::CONFIGURE).await);
        // Forty times: the order of two things that have both happened was left to chance.
        for number in 2..42 {
            bench.set("number", integer(number));
            assert!(bench.to(Transition::ACTIVATE).await);
            assert_eq!(bench.number.get(), number);
            assert!(bench.to(Transition::DEACTIVATE).await);
        }
    };
    bench.drive(orders, false, steps).await;
}

/// What cannot begin to work is not active, and whoever asked hears it.
#[tokio::test]
async fn work_that_cannot_begin_fails_the_activation() {
    let (bench, orders) = Bench::new("unwritable", &[("unwritable", "true")]);
    let steps = async {
        assert!(bench.to(Transition::CONFIGURE).await && !bench.to(Transition::ACTIVATE).await);
        assert_eq!(bench.state(), State::UNCONFIGURED);
        bench.set("unwritable", flag(false));
        assert!(bench.to(Transition::CONFIGURE).await && bench.to(Transition::ACTIVATE).await);
        assert_eq!((bench.state(), bench.number.get()), (State::ACTIVE, 1));
    };
    bench.drive(orders, false, steps).await;
}

/// A node that waits for others before it starts by itself takes steps and parameters meanwhile.
#[tokio::test]
async fn a_node_that_waits_for_others_can_be_asked() {
    let (bench, orders) = Bench::new("waiting", &[("start_after", "[nobody]")]);
    let steps = async {
        idle().await;
        assert_eq!((bench.state(), bench.number.get()), (State::INACTIVE, 0));
        bench.set("number", integer(2));
        assert!(bench.to(Transition::ACTIVATE).await);
        assert_eq!((bench.state(), bench.number.get()), (State::ACTIVE, 2));
        assert!(bench.to(Transition::DEACTIVATE).await && bench.to(Transition::CLEANUP).await);
        idle().await;
        assert_eq!((bench.state(), bench.number.get()), (State::UNCONFIGURED, 0));
    };
    bench.drive(orders, true, steps).await;
}
