//! Orders to a firmware: one line of a known shape or none, and no other line passes.

use super::laws::is_one_line;
use super::values::Values;
use models::gcode::order::{Firmware, Order, is_allowed};
use models::units::Celsius;

/// Two bytes say which order and to whom, then comes its value; what is left is a line that somebody wants to send.
pub fn gcode_order(bytes: &[u8]) {
    let mut values = Values::new(bytes);
    let firmware = values.pick(&[Firmware::Marlin, Firmware::Klipper]);
    let kind = values.below(10);
    let order = order(kind, values.number());
    if let Ok(line) = order.line(firmware) {
        is_one_line(&line);
        assert!(is_allowed(&line) && line.len() <= 40, "{order:?}: {line:?}");
    }
    let Ok(text) = std::str::from_utf8(values.rest()) else { return };
    if is_allowed(text) {
        is_one_line(text);
        let again = read(text).into_iter().flat_map(|order| {
            [Firmware::Marlin, Firmware::Klipper].map(|firmware| order.line(firmware).unwrap())
        });
        assert!(again.into_iter().any(|line| line == text), "{text:?} is no line of an order");
    }
}

fn order(kind: usize, value: f64) -> Order {
    match kind {
        0 => Order::Speed(value),
        1 => Order::Flow(value),
        2 => Order::Hotend(Celsius(value)),
        3 => Order::Bed(Celsius(value)),
        4 => Order::Fan(value),
        5 => Order::Advance(value),
        6 => Order::Pause,
        7 => Order::Resume,
        8 => Order::Cancel,
        _ => Order::EmergencyStop,
    }
}

/// The orders that may have written a line.
fn read(line: &str) -> Vec<Order> {
    let heads = ["M220 S", "M221 S", "M104 S", "M140 S", "M106 S", "M900 K", "SET_PRESSURE_ADVANCE ADVANCE="];
    let scale = [100.0, 100.0, 1.0, 1.0, 255.0, 1.0, 1.0];
    for (index, head) in heads.iter().enumerate() {
        if let Some(value) = line.strip_prefix(head).and_then(|number| number.parse::<f64>().ok()) {
            return vec![order(index.min(5), value / scale[index])];
        }
    }
    vec![Order::Pause, Order::Resume, Order::Cancel, Order::EmergencyStop]
}

pub(super) fn seeds() -> Vec<Vec<u8>> {
    let lines = [
        "M220 S95.7",
        "M221 S110",
        "M104 S208.2",
        "M140 S60.0",
        "M106 S128",
        "M900 K0.0500",
        "M25",
        "RESUME",
    ];
    let front = |kind: usize| {
        let kind = u8::try_from(kind).unwrap();
        [vec![kind & 1, kind, 1], 1.05_f64.to_le_bytes().to_vec()].concat()
    };
    lines.iter().enumerate().map(|(kind, line)| [front(kind), line.as_bytes().to_vec()].concat()).collect()
}
