//! What the services say of a file.

use super::super::{NodePath, Parameters};
use super::*;
use models::params::in_range;
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Params {
    rate_hz: f64,
    limits: Limits,
    names: Vec<String>,
}

#[derive(Deserialize)]
#[serde(try_from = "RawLimits")]
struct Limits(f64);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawLimits {
    flow_min: f64,
    flow_max: f64,
    samples: u32,
}

impl TryFrom<RawLimits> for Limits {
    type Error = models::params::ParamError;

    fn try_from(raw: RawLimits) -> Result<Self, Self::Error> {
        models::params::ordered(("flow_min", raw.flow_min), ("flow_max", raw.flow_max))?;
        in_range("samples", f64::from(raw.samples), "-", (1.0, 20.0))?;
        in_range("flow_max", raw.flow_max, "-", (1.0, 2.0)).map(Self)
    }
}

const FILE: &str = "/**:\n  ros__parameters:\n    rate_hz: 4\n    limits:\n      flow_min: 0.8  # [-] in [0, 1]; book\n      \
                    flow_max: 1.2  # [-] in [1, 2]; book\n      samples: 3  # [-] in [1, 20]\n    names: [a, b]\n";

fn store() -> Store {
    static COUNT: std::sync::atomic::AtomicU32 = std::sync::atomic::AtomicU32::new(0);
    let count = COUNT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    let file = std::env::temp_dir().join(format!("runtime_store_{}_{count}.yaml", std::process::id()));
    std::fs::write(&file, FILE).unwrap();
    let node = NodePath { qualified: "/printer/mpc".into(), base: "mpc".into() };
    let parameters = Parameters::read(std::slice::from_ref(&file), &[], &node).unwrap();
    std::fs::remove_file(file).unwrap();
    let store = Store::new(parameters);
    store.tell_check(|parameters| {
        parameters.parse::<Params>().map(|params| _ = (params.rate_hz, params.limits.0, params.names))
    });
    store
}

fn names(of: &[&str]) -> Vec<String> {
    of.iter().map(|name| (*name).to_owned()).collect()
}

fn wanted(name: &str, value: Value) -> Parameter {
    Parameter { name: name.to_owned(), value: to_ros(&value) }
}

fn reason(wanted: &[Parameter]) -> String {
    let store = store();
    let before = store.parameters().text();
    let reason = store.set(wanted, Policy::Nothing).unwrap_err();
    assert_eq!(store.parameters().text(), before);
    reason
}

fn list(prefixes: &[&str], depth: u64) -> ListParametersResult {
    store().look(|view| view.list(&names(prefixes), depth))
}

#[test]
fn names_are_listed_below_a_prefix_and_down_to_a_depth() {
    let all = list(&[], 0);
    let limits = ["limits.flow_max", "limits.flow_min", "limits.samples"];
    let root = ["autostart", "names", "rate_hz", "start_after", "use_sim_time"];
    assert_eq!(all.names, [&root[..1], &limits, &root[1..]].concat());
    assert_eq!(all.prefixes, ["limits"]);
    assert_eq!(list(&["limits"], 0).names, limits);
    assert_eq!(list(&[], 1).names, root);
    assert_eq!(list(&["limit", "rate_hz"], 0).names, ["rate_hz"]);
}

#[test]
fn values_come_in_the_order_asked_and_unset_where_there_is_none() {
    let asked = names(&["names", "limits.flow_max", "nothing", "limits", "use_sim_time"]);
    let values = store().look(|view| view.get(&asked));
    let kinds: Vec<u8> = values.iter().map(|value| value.kind).collect();
    assert_eq!(kinds, [9, 3, 0, 0, 1]);
    assert_eq!(
        (values[0].string_array_value.as_slice(), values[1].double_value),
        (names(&["a", "b"]).as_slice(), 1.2)
    );
}

#[test]
fn the_comment_is_the_description_and_its_range_the_range() {
    let asked = names(&["limits.flow_max", "limits.samples", "rate_hz", "nothing"]);
    let said = store().look(|view| view.describe(&asked, Policy::Nothing));
    assert_eq!(said[0].description, "[-] in [1, 2]; book");
    assert_eq!(
        (said[0].floating_point_range[0].from_value, said[0].floating_point_range[0].to_value),
        (1.0, 2.0)
    );
    assert_eq!((said[1].integer_range[0].from_value, said[1].integer_range[0].to_value), (1, 20));
    assert!(said[2].floating_point_range.is_empty() && said[2].integer_range.is_empty());
    assert!(said.iter().take(3).all(|descriptor| descriptor.read_only));
    assert_eq!((said[3].kind, said[3].description.as_str()), (0, "there is no such parameter"));
}

/// What the node has declared changes while it works, all else while it is inactive, its clock never; what stands beside
/// a value stays there.
#[test]
fn what_may_change_when() {
    let one = |name: &str, value: f64| [wanted(name, Value::from(value))];
    let store = store();
    let mut live = store.declare(&["limits.flow_max"]);
    let changed = store.set(&one("limits.flow_max", 2.0), Policy::Declared).unwrap();
    assert_eq!((&changed[0].before, &changed[0].after), (&Value::from(1.2), &Value::from(2.0)));
    assert!(live.0.has_changed().unwrap());
    assert_eq!(live.0.borrow_and_update().text(), store.parameters().text());
    assert_eq!(store.set(&one("limits.flow_max", 2.0), Policy::Declared), Ok(vec![]), "nothing new");
    let said = |policy| store.look(|view| view.describe(&names(&["limits.flow_max", "rate_hz"]), policy));
    let read_only = |policy| said(policy).iter().map(|descriptor| descriptor.read_only).collect::<Vec<_>>();
    assert_eq!(said(Policy::Declared)[0].description, "[-] in [1, 2]; book");
    assert_eq!(read_only(Policy::Declared), [false, true]);
    assert_eq!((read_only(Policy::All), read_only(Policy::UnderWay)), (vec![false; 2], vec![true; 2]));
    let refused = store.set(&one("rate_hz", 5.0), Policy::Declared).unwrap_err();
    assert_eq!(
        refused,
        "rate_hz = 5: read-only while the node is active: deactivate it, set it, activate it again"
    );
    assert_eq!(store.set(&one("rate_hz", 5.0), Policy::All).unwrap().len(), 1);
    assert!(store.parameters().text().contains("rate_hz: 5"));
    let clock = [wanted("use_sim_time", Value::from(true))];
    assert!(
        store
            .set(&clock, Policy::All)
            .unwrap_err()
            .starts_with("use_sim_time = true: read-only while the node runs")
    );
}

#[test]
fn what_is_wrong_is_said_with_its_range_and_what_is_right_with_its_place() {
    let far = reason(&[wanted("limits.flow_max", Value::from(3.0))]);
    assert_eq!(far, "limits.flow_max = 3 (no unit): must be in [1, 2]");
    assert_eq!(
        reason(&[wanted("limits.flow_max", Value::from("much"))]),
        "limits.flow_max = \"much\": is a string, and must be a double; allowed in [1, 2] (no unit)"
    );
    assert_eq!(reason(&[wanted("flow", Value::from(1.0))]), "flow: there is no such parameter");
    assert_eq!(reason(&[wanted("rate_hz", Value::Null)]), "rate_hz = nothing: must be set, and finite");
    let right = reason(&[wanted("limits.flow_max", Value::from(1.5))]);
    assert!(
        right.starts_with("limits.flow_max = 1.5 (no unit): read-only while the node runs: change ")
            && right.contains(".yaml:6 ")
            && right.ends_with("; allowed in [1, 2]")
    );
}

/// Whole numbers too, in what a person reads: no name of a type.
#[test]
fn a_whole_number_is_refused_with_its_range() {
    let said = |value: Value| reason(&[wanted("limits.samples", value)]);
    assert_eq!(said(Value::from(-1)), "limits.samples = -1 (no unit): must be in [1, 20]");
    assert_eq!(
        said(Value::from(1.5)),
        "limits.samples = 1.5 (no unit): must be a whole number; allowed in [1, 20]"
    );
    let value = ParameterValue { kind: ParameterValue::DOUBLE, double_value: f64::NAN, ..Default::default() };
    assert_eq!(
        reason(&[Parameter { name: "limits.flow_max".into(), value }]),
        "limits.flow_max = NaN (no unit): must be set, and finite; allowed in [1, 2]"
    );
}

/// The first of two values would be told as a change, on `events` and `/parameter_events`, and never hold.
#[test]
fn a_name_that_is_asked_for_twice_is_refused() {
    let one = |value: f64| wanted("limits.flow_max", Value::from(value));
    assert_eq!(reason(&[one(1.5), one(1.7)]), "limits.flow_max: is asked to be set twice at once");
    assert_eq!(
        store().set(&[one(1.5), wanted("rate_hz", Value::from(5.0)), one(1.5)], Policy::All).unwrap_err(),
        "limits.flow_max: is asked to be set twice at once"
    );
}

/// The answer begins with what was asked for, also where two do not go together.
#[test]
fn a_refusal_begins_with_what_was_asked_for() {
    let one = |name: &str, value: f64| [wanted(name, Value::from(value))];
    let store = store();
    store.set(&one("limits.flow_min", 1.0), Policy::All).unwrap();
    assert_eq!(
        store.set(&one("limits.flow_max", 1.0), Policy::All).unwrap_err(),
        "limits.flow_max = 1 (no unit): must be above limits.flow_min = 1; allowed in [1, 2]"
    );
    store.tell_check(|_| {
        let (at, message) = ("a.yaml:3".to_owned(), "names: one is missing".to_owned());
        Err(ParamFileError::Refused { at, message })
    });
    assert_eq!(
        store.set(&one("rate_hz", 5.0), Policy::All).unwrap_err(),
        "rate_hz = 5: does not go with the others: a.yaml:3: names: one is missing"
    );
}

/// Each alone is sound; together the lower bound lies above the upper one.
#[test]
fn what_is_set_together_is_checked_together() {
    let text =
        reason(&[wanted("limits.flow_max", Value::from(1.0)), wanted("limits.flow_min", Value::from(1.0))]);
    assert!(text.contains("flow_min") && !text.contains("read-only"), "{text}");
}

/// What the runtime itself takes is described as well, and a refusal does not say a whole megabyte again.
#[test]
fn every_parameter_of_the_runtime_is_described() {
    let said = store().look(|view| view.describe(&OWN.map(str::to_owned), Policy::All));
    assert!(said.iter().all(|descriptor| !descriptor.description.is_empty()), "{said:?}");
    let long = "x".repeat(1_000_000);
    assert!(reason(&[wanted("rate_hz", Value::from(long.as_str()))]).len() < 300);
    assert!(reason(&[wanted(&long, Value::from(1))]).len() < 300);
}

/// T5: whatever a client asks for: an answer for each name, and a change that passes the node's own check or none at all.
#[test]
fn hostile_requests_are_answered_and_change_nothing_unchecked() {
    let store = store();
    let known = ["rate_hz", "limits.flow_max", "limits.samples", "names", "use_sim_time", "autostart"];
    let odd = ["", ".", "limits", "limits.", ".limits", "rate_hz.x", "names[0]", "a\n\u{1b}[31m", "ä"];
    let all: Vec<String> =
        names(&known).into_iter().chain(names(&odd)).chain(["x".repeat(100_000)]).collect();
    let numbers = [f64::NAN, f64::NEG_INFINITY, -0.0, 1.5, 4.0, 1e308];
    let mut changes = 0;
    for (name, kind) in all.iter().flat_map(|name| (0..=11_u8).map(move |kind| (name, kind))) {
        for (index, number) in numbers.into_iter().enumerate() {
            let value = ParameterValue {
                kind: if kind == 11 { 255 } else { kind },
                bool_value: index % 2 == 0,
                integer_value: [i64::MIN, -1, 0, 1, 7, i64::MAX][index],
                double_value: number,
                string_value: name.clone(),
                byte_array_value: vec![0, 255],
                bool_array_value: vec![true; index],
                integer_array_value: vec![i64::MAX; index],
                double_array_value: vec![number; index],
                string_array_value: vec![name.clone(); index],
            };
            let policy = [Policy::Nothing, Policy::Declared, Policy::All, Policy::UnderWay][index % 4];
            let before = store.parameters().text();
            match store.set(&[Parameter { name: name.clone(), value }], policy) {
                Ok(changed) => changes += changed.len(),
                Err(reason) => {
                    assert!(!reason.is_empty() && reason.len() < 1500, "{reason:.2000}");
                    assert_eq!(store.parameters().text(), before, "{reason}");
                }
            }
            store.parameters().parse::<Params>().unwrap();
        }
        let one = std::slice::from_ref(name);
        let told = store.look(|view| (view.get(one).len(), view.describe(one, Policy::All).len()));
        assert_eq!(told, (1, 1));
        store.look(|view| view.list(one, u64::from(kind).wrapping_sub(1)));
    }
    assert!(changes >= 3, "{changes} requests were right");
}
