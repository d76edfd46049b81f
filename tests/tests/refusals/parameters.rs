//! What a ROS user asks of a running node's parameters: `ros2 param list`, `get`, `describe`, `set`.

use fdm_loop_msgs::{
    DescribeParametersRequest, GetParameterTypesRequest, GetParametersRequest, ListParametersRequest,
    Parameter, ParameterValue, SetParametersAtomicallyRequest, SetParametersRequest,
};
use models::units::Seconds;
use runtime::{Node, topics};

const NODE: &str = "/printer/safety_supervisor";
const PATIENCE: Seconds = Seconds(5.0);

fn double(name: &str, double_value: f64) -> Parameter {
    let value = ParameterValue { kind: ParameterValue::DOUBLE, double_value, ..ParameterValue::default() };
    Parameter { name: name.to_owned(), value }
}

/// The six services of the supervisor: values with their description are told, a wrong one is refused with its range, a
/// right one while the node is active with what to do.
pub(crate) async fn are_told_and_refused(node: &mut Node) {
    let list = node.client_of(NODE, &topics::LIST_PARAMETERS).unwrap();
    let get = node.client_of(NODE, &topics::GET_PARAMETERS).unwrap();
    let kinds = node.client_of(NODE, &topics::GET_PARAMETER_TYPES).unwrap();
    let describe = node.client_of(NODE, &topics::DESCRIBE_PARAMETERS).unwrap();
    let set = node.client_of(NODE, &topics::SET_PARAMETERS).unwrap();
    let set_together = node.client_of(NODE, &topics::SET_PARAMETERS_ATOMICALLY).unwrap();
    let of_estimator = node.client_of("/printer/state_estimator", &topics::SET_PARAMETERS).unwrap();

    let asked = ListParametersRequest { prefixes: vec!["modes".to_owned()], depth: 0 };
    let listed = list.call(asked, PATIENCE).await.unwrap().result;
    assert!(listed.names.contains(&"modes.ramp_s".to_owned()), "{listed:?}");
    assert_eq!(listed.prefixes, ["modes"]);

    let names = vec!["modes.ramp_s".to_owned(), "no.such".to_owned()];
    let values = get.call(GetParametersRequest { names: names.clone() }, PATIENCE).await.unwrap().values;
    assert_eq!((values[0].double_value, values[1].kind), (0.8, ParameterValue::NOT_SET));
    let types = kinds.call(GetParameterTypesRequest { names: names.clone() }, PATIENCE).await.unwrap().types;
    assert_eq!(types, [ParameterValue::DOUBLE, ParameterValue::NOT_SET]);

    let described = describe.call(DescribeParametersRequest { names }, PATIENCE).await.unwrap().descriptors;
    assert!(described[0].description.starts_with("[s] in [0.05, 2]"), "{described:?}");
    let range = &described[0].floating_point_range[0];
    assert_eq!((range.from_value, range.to_value), (0.05, 2.0));
    assert!(described[0].read_only);

    let parameters = vec![double("modes.ramp_s", 7.0), double("modes.ramp_s", 0.9), double("no.such", 1.0)];
    let results = set.call(SetParametersRequest { parameters }, PATIENCE).await.unwrap().results;
    assert!(results.iter().all(|result| !result.successful));
    assert!(results[0].reason.contains("modes.ramp_s = 7 s: must be in [0.05, 2]"), "{results:?}");
    assert!(results[1].reason.contains("read-only while the node is active: deactivate it"), "{results:?}");
    assert!(results[2].reason.contains("no such parameter"), "{results:?}");

    let parameters = vec![double("attention.soft", 0.9), double("attention.hard", 0.95)];
    let asked = SetParametersAtomicallyRequest { parameters };
    let together = set_together.call(asked, PATIENCE).await.unwrap().result;
    assert!(!together.successful && together.reason.contains("read-only"), "{together:?}");
    let asked = SetParametersRequest { parameters: vec![double("spread.alpha", -1.0)] };
    let results = of_estimator.call(asked, PATIENCE).await.unwrap().results;
    assert!(
        results[0].reason.contains("must be in [0.001, 1]"),
        "a node with shared files checks too: {results:?}"
    );
}
