//! The parameters of a running node: what the six services of ROS 2 say of them.
//!
//! A node takes its parameters when it is configured. While it works those may change that it has declared; while it is
//! inactive all may, and it is configured anew with them. What is asked for is always checked by the node's own struct,
//! so that a wrong value is refused with its allowed range, and a right one at a wrong time with what to do.

mod change;

use super::own;
use super::tree::Tree;
use super::values::to_ros;
use super::{AUTOSTART, OWN, ParamFileError, Parameters, START_AFTER, USE_SIM_TIME};
use fdm_loop_msgs::{
    FloatingPointRange, IntegerRange, ListParametersResult, Parameter, ParameterDescriptor, ParameterValue,
};
use serde_json::Value;
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::{Notify, watch};

/// Parses parameters as the node does.
type Check = Box<dyn Fn(&Parameters) -> Result<(), ParamFileError> + Send>;

/// What may be changed now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Policy {
    /// Nothing: the node is not managed.
    Nothing,
    /// What the node has declared: it works.
    Declared,
    /// All: the node takes its parameters when it goes on.
    All,
    /// Nothing: the node is on its way from one state to another.
    UnderWay,
}

/// The parameters in force; clones share them.
#[derive(Clone)]
pub(crate) struct Store(Arc<Shared>);

struct Shared {
    state: Mutex<State>,
    /// The newest, for a shell that works.
    live: watch::Sender<Parameters>,
    /// Changed while the shell waits.
    changed: Notify,
}

struct State {
    parameters: Parameters,
    /// The check of the node, once it has told it.
    check: Option<Check>,
    /// What may change while the node works.
    declared: &'static [&'static str],
}

/// A parameter that was changed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Changed {
    pub(crate) parameter: Parameter,
    pub(crate) before: Value,
    pub(crate) after: Value,
}

/// The parameters of a working node, as they change.
#[derive(Debug)]
pub struct LiveParameters(watch::Receiver<Parameters>);

impl LiveParameters {
    /// Waits for the next change, which has been checked, and yields all parameters. Cancelling loses none.
    pub async fn next(&mut self) -> Parameters {
        if self.0.changed().await.is_err() {
            // The node is gone, and with it who could change anything.
            std::future::pending::<()>().await;
        }
        self.0.borrow_and_update().clone()
    }
}

impl Store {
    pub(crate) fn new(parameters: Parameters) -> Self {
        let (live, _) = watch::channel(parameters.clone());
        let state = State { parameters, check: None, declared: &[] };
        Self(Arc::new(Shared { state: Mutex::new(state), live, changed: Notify::new() }))
    }

    /// The node parses its parameters like this.
    pub(crate) fn tell_check(
        &self,
        check: impl Fn(&Parameters) -> Result<(), ParamFileError> + Send + 'static,
    ) {
        self.state().check = Some(Box::new(check));
    }

    /// These may change while the node works; their changes come from now on.
    pub(crate) fn declare(&self, names: &'static [&'static str]) -> LiveParameters {
        self.state().declared = names;
        LiveParameters(self.0.live.subscribe())
    }

    /// The parameters now.
    pub(crate) fn parameters(&self) -> Parameters {
        self.state().parameters.clone()
    }

    /// Waits for a change.
    pub(crate) async fn changed(&self) {
        self.0.changed.notified().await;
    }

    /// What is asked of the parameters now.
    pub(crate) fn look<T>(&self, question: impl FnOnce(&View<'_>) -> T) -> T {
        question(&View(&self.state()))
    }

    /// Sets these together, or none of them.
    ///
    /// # Errors
    /// Name, value and allowed range of what is refused.
    pub(crate) fn set(&self, wanted: &[Parameter], policy: Policy) -> Result<Vec<Changed>, String> {
        let mut state = self.state();
        let (parameters, changed) = View(&state).changed(wanted, policy)?;
        if !changed.is_empty() {
            state.parameters = parameters.clone();
            drop(state);
            self.0.live.send_replace(parameters);
            if policy == Policy::All {
                self.0.changed.notify_one();
            }
        }
        Ok(changed)
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.0.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What the services say of the parameters.
pub(crate) struct View<'a>(&'a State);

impl View<'_> {
    /// Every parameter with its value.
    pub(crate) fn all(&self) -> Vec<Parameter> {
        let names = self.names();
        let values = self.get(&names);
        names.into_iter().zip(values).map(|(name, value)| Parameter { name, value }).collect()
    }

    /// Names below any of `prefixes` (none: all), at most `depth` levels of blocks down (0: all), and their blocks.
    pub(crate) fn list(&self, prefixes: &[String], depth: u64) -> ListParametersResult {
        let levels = |name: &str| name.matches('.').count() as u64;
        let is_asked = |name: &String| {
            let shallow = |below: &str| depth == 0 || levels(below) < depth;
            let below = |prefix: &String| {
                name == prefix
                    || name.strip_prefix(prefix).and_then(|rest| rest.strip_prefix('.')).is_some_and(shallow)
            };
            if prefixes.is_empty() { shallow(name) } else { prefixes.iter().any(below) }
        };
        let names: Vec<String> = self.names().into_iter().filter(is_asked).collect();
        let blocks: BTreeSet<String> = names
            .iter()
            .filter_map(|name| name.rsplit_once('.'))
            .map(|(block, _)| block.to_owned())
            .collect();
        ListParametersResult { names, prefixes: blocks.into_iter().collect() }
    }

    /// Values in the order asked; not set for what is not there.
    pub(crate) fn get(&self, names: &[String]) -> Vec<ParameterValue> {
        names.iter().map(|name| self.value(name).map(|value| to_ros(&value)).unwrap_or_default()).collect()
    }

    /// What is known of each, from the comment beside it.
    pub(crate) fn describe(&self, names: &[String], policy: Policy) -> Vec<ParameterDescriptor> {
        names.iter().map(|name| self.descriptor(name, policy)).collect()
    }

    fn descriptor(&self, name: &str, policy: Policy) -> ParameterDescriptor {
        let Some(value) = self.value(name) else {
            let description = "there is no such parameter".to_owned();
            return ParameterDescriptor { name: name.to_owned(), description, ..Default::default() };
        };
        let said = self.0.parameters.descriptions.of(name);
        let description = match self.0.parameters.tree.origin(name) {
            _ if OWN.contains(&name) => own::description(name).to_owned(),
            // A launch file gives what no file has.
            Some(origin) if said.text.is_empty() => format!("given by {origin}, described by no file"),
            _ => said.text.clone(),
        };
        let kind = to_ros(&value).kind;
        let bounds = said.bounds.range().filter(|_| value.is_number());
        let read_only = self.read_only(name, policy);
        let mut descriptor = ParameterDescriptor {
            name: name.to_owned(),
            kind,
            description,
            read_only: read_only.is_some(),
            additional_constraints: read_only.unwrap_or_default(),
            ..Default::default()
        };
        if let Some((from, to)) = bounds {
            if kind == ParameterValue::INTEGER {
                #[expect(clippy::cast_possible_truncation, reason = "a float's cast saturates")]
                let (from_value, to_value) = (from.ceil() as i64, to.floor() as i64);
                descriptor.integer_range.push(IntegerRange { from_value, to_value, step: 0 });
            } else {
                let range = FloatingPointRange { from_value: from, to_value: to, step: 0.0 };
                descriptor.floating_point_range.push(range);
            }
        }
        descriptor
    }

    fn names(&self) -> Vec<String> {
        let mut names = self.0.parameters.tree.leaves();
        names.extend(OWN.map(str::to_owned));
        names.sort();
        names
    }

    fn value(&self, name: &str) -> Option<Value> {
        match name {
            USE_SIM_TIME => return Some(Value::from(self.0.parameters.use_sim_time)),
            AUTOSTART => return Some(Value::from(self.0.parameters.autostart)),
            START_AFTER => return Some(Value::from(self.0.parameters.start_after.clone())),
            _ => {}
        }
        match self.0.parameters.tree.get(name)?.0 {
            Tree::Leaf(value) => Some(value.clone()),
            Tree::Block(_) | Tree::NotFinite(_) => None,
        }
    }
}

#[cfg(test)]
mod tests;
