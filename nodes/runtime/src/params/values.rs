//! Values as the files have them and as ROS 2 carries them.

use super::bounds::number;
use crate::args::short;
use fdm_loop_msgs::ParameterValue;
use serde_json::{Number, Value};

/// The value for the wire; a list of mixed things goes as the JSON of each.
pub(super) fn to_ros(value: &Value) -> ParameterValue {
    let of = |kind| ParameterValue { kind, ..ParameterValue::default() };
    match value {
        Value::Null => of(ParameterValue::NOT_SET),
        Value::Bool(value) => ParameterValue { bool_value: *value, ..of(ParameterValue::BOOL) },
        Value::Number(number) => match number.as_i64() {
            Some(value) => ParameterValue { integer_value: value, ..of(ParameterValue::INTEGER) },
            None => ParameterValue {
                double_value: number.as_f64().unwrap_or(f64::NAN),
                ..of(ParameterValue::DOUBLE)
            },
        },
        Value::String(text) => ParameterValue { string_value: text.clone(), ..of(ParameterValue::STRING) },
        Value::Object(_) => ParameterValue { string_value: value.to_string(), ..of(ParameterValue::STRING) },
        Value::Array(list) => list_to_ros(list),
    }
}

fn list_to_ros(list: &[Value]) -> ParameterValue {
    let of = |kind| ParameterValue { kind, ..ParameterValue::default() };
    let all = |is: fn(&Value) -> bool| !list.is_empty() && list.iter().all(is);
    if all(Value::is_boolean) {
        let bool_array_value = list.iter().filter_map(Value::as_bool).collect();
        ParameterValue { bool_array_value, ..of(ParameterValue::BOOL_ARRAY) }
    } else if all(Value::is_i64) {
        let integer_array_value = list.iter().filter_map(Value::as_i64).collect();
        ParameterValue { integer_array_value, ..of(ParameterValue::INTEGER_ARRAY) }
    } else if all(Value::is_number) {
        let double_array_value = list.iter().filter_map(Value::as_f64).collect();
        ParameterValue { double_array_value, ..of(ParameterValue::DOUBLE_ARRAY) }
    } else {
        let text = |item: &Value| item.as_str().map_or_else(|| item.to_string(), str::to_owned);
        let string_array_value = list.iter().map(text).collect();
        ParameterValue { string_array_value, ..of(ParameterValue::STRING_ARRAY) }
    }
}

/// The value for the files; `None` for what is not set, not finite or of no known kind.
pub(super) fn from_ros(value: &ParameterValue) -> Option<Value> {
    let finite = |value: f64| Number::from_f64(value).map(Value::Number);
    Some(match value.kind {
        ParameterValue::BOOL => Value::from(value.bool_value),
        ParameterValue::INTEGER => Value::from(value.integer_value),
        ParameterValue::DOUBLE => finite(value.double_value)?,
        ParameterValue::STRING => Value::from(value.string_value.as_str()),
        ParameterValue::BYTE_ARRAY => Value::from(value.byte_array_value.clone()),
        ParameterValue::BOOL_ARRAY => Value::from(value.bool_array_value.clone()),
        ParameterValue::INTEGER_ARRAY => Value::from(value.integer_array_value.clone()),
        ParameterValue::DOUBLE_ARRAY => {
            Value::Array(value.double_array_value.iter().copied().map(finite).collect::<Option<_>>()?)
        }
        ParameterValue::STRING_ARRAY => Value::from(value.string_array_value.clone()),
        _ => return None,
    })
}

/// What was asked for, for people.
pub(super) fn text(value: &ParameterValue) -> String {
    match (value.kind, from_ros(value)) {
        (_, Some(Value::Number(value))) => value.as_f64().map(number).unwrap_or_default(),
        (_, Some(value)) => short(&value.to_string()),
        (ParameterValue::DOUBLE, None) => value.double_value.to_string(),
        (ParameterValue::DOUBLE_ARRAY, None) => short(&format!("{:?}", value.double_array_value)),
        (..) => "nothing".to_owned(),
    }
}

/// Name of a kind as the ROS tools say it.
pub(super) fn kind_name(kind: u8) -> &'static str {
    match kind {
        ParameterValue::BOOL => "boolean",
        ParameterValue::INTEGER => "integer",
        ParameterValue::DOUBLE => "double",
        ParameterValue::STRING => "string",
        ParameterValue::BYTE_ARRAY => "byte array",
        ParameterValue::BOOL_ARRAY => "boolean array",
        ParameterValue::INTEGER_ARRAY => "integer array",
        ParameterValue::DOUBLE_ARRAY => "double array",
        ParameterValue::STRING_ARRAY => "string array",
        _ => "value that is not set",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_a_file_can_hold_survives_the_wire() {
        for value in [
            json!(true),
            json!(-3),
            json!(0.25),
            json!("a b"),
            json!([true, false]),
            json!([1, 2]),
            json!([1.5, 2.5]),
            json!(["a", "b"]),
        ] {
            assert_eq!(from_ros(&to_ros(&value)), Some(value));
        }
        assert_eq!(to_ros(&json!([1, 2.5])).double_array_value, [1.0, 2.5]);
        assert_eq!(to_ros(&json!([])).kind, ParameterValue::STRING_ARRAY);
    }

    #[test]
    fn what_no_file_can_hold_is_none() {
        let double = |double_value| ParameterValue { kind: 3, double_value, ..ParameterValue::default() };
        assert_eq!(from_ros(&double(f64::NAN)), None);
        let list = ParameterValue { kind: 8, double_array_value: vec![1.0, f64::INFINITY], ..double(0.0) };
        assert_eq!(from_ros(&list), None);
        assert_eq!(from_ros(&ParameterValue::default()), None);
        assert_eq!(from_ros(&ParameterValue { kind: 77, ..double(0.0) }), None);
    }
}
