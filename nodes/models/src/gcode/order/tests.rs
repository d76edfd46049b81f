use super::*;
use proptest::prelude::*;

#[test]
fn orders_are_written_as_their_firmware_reads_them() {
    for (order, marlin, klipper) in [
        (Order::Speed(0.957), "M220 S96", "M220 S95.7"),
        (Order::Flow(1.1), "M221 S110", "M221 S110.0"),
        (Order::Hotend(Celsius(208.25)), "M104 S208.2", "M104 S208.2"),
        (Order::Bed(Celsius(60.0)), "M140 S60.0", "M140 S60.0"),
        (Order::Fan(0.5), "M106 S128", "M106 S128"),
        (Order::Advance(0.05), "M900 K0.0500", "SET_PRESSURE_ADVANCE ADVANCE=0.0500"),
        (Order::Pause, "M25", "PAUSE"),
        (Order::Resume, "M24", "RESUME"),
        (Order::Cancel, "M524", "CANCEL_PRINT"),
        (Order::EmergencyStop, "M112", "M112"),
    ] {
        assert_eq!(order.line(Firmware::Marlin).unwrap(), marlin);
        assert_eq!(order.line(Firmware::Klipper).unwrap(), klipper);
    }
}

#[test]
fn a_value_beyond_its_bounds_is_written_as_the_bound_and_one_that_is_none_not_at_all() {
    for (order, line) in [
        (Order::Speed(1e300), "M220 S200"),
        (Order::Flow(-3.0), "M221 S50"),
        (Order::Hotend(Celsius(1e9)), "M104 S350.0"),
        (Order::Hotend(Celsius(-0.0)), "M104 S0.0"),
        (Order::Fan(-1e-300), "M106 S0"),
        (Order::Advance(5e-324), "M900 K0.0000"),
    ] {
        assert_eq!(order.line(Firmware::Marlin).unwrap(), line);
    }
    // 1e308 in percent is infinite.
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308] {
        assert_eq!(Order::Flow(value).line(Firmware::Klipper), Err(NotFinite));
    }
}

#[test]
fn nothing_else_passes() {
    for line in [
        "",
        "M220",
        "M220 S",
        "M220 S100.00",
        "M220 S+100.0",
        "M220 S1e2",
        "M220 S100.0 ",
        " M25",
        "M25\n",
        "M220 S100.0\nM112",
        "M220 S100.0;M112",
        "M104 S351.0",
        "M104 S0351.0",
        "M104 S0208.2",
        "M106 S00000000000000000000000000000000000000004",
        "m25",
        "M106 S128.",
        "M106 S.",
        "M109 S200.0",
        "M302 S0",
        "M500",
        "G28",
        "FIRMWARE_RESTART",
        "SET_PRESSURE_ADVANCE ADVANCE=0.0500 EXTRUDER=x",
        "M104 S\u{0661}.0",
        "M900 K-0.0000",
        "M900 KNaN",
        "M220 Sinf",
    ] {
        assert!(!is_allowed(line), "{line:?}");
    }
}

fn any_order() -> impl Strategy<Value = Order> {
    let value = || prop_oneof![any::<u64>().prop_map(f64::from_bits), -1.0..3.0, -400.0..400.0];
    prop_oneof![
        value().prop_map(Order::Speed),
        value().prop_map(Order::Flow),
        value().prop_map(|value| Order::Hotend(Celsius(value))),
        value().prop_map(|value| Order::Bed(Celsius(value))),
        value().prop_map(Order::Fan),
        value().prop_map(Order::Advance),
        Just(Order::Pause),
        Just(Order::Resume),
        Just(Order::Cancel),
        Just(Order::EmergencyStop),
    ]
}

/// `FDM_GCODE_CASES` sets how many orders are written.
fn cases() -> u32 {
    std::env::var("FDM_GCODE_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(10_000)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(cases()) })]

    /// Any order: one line of a known shape, its number finite and in its bounds, or none at all.
    #[test]
    fn any_order_is_one_line_of_a_known_shape(order in any_order(), klipper: bool) {
        let firmware = if klipper { Firmware::Klipper } else { Firmware::Marlin };
        let Ok(line) = order.line(firmware) else { return Ok(()) };
        prop_assert!(is_allowed(&line), "{order:?}: {line:?}");
        prop_assert!(line.len() <= 40 && line.bytes().all(|byte| byte == b' ' || byte.is_ascii_graphic()));
        if line.contains(' ') {
            let value: f64 = line.rsplit(['S', 'K', '=']).next().unwrap().parse().unwrap();
            prop_assert!((0.0..=350.0).contains(&value));
        }
    }

    /// Any text: what passes is what some order writes.
    #[test]
    fn any_text_that_passes_is_what_an_order_writes(
        text in "(M220 S|M221 S|M104 S|M140 S|M106 S|M900 K|SET_PRESSURE_ADVANCE ADVANCE=|M112|PAUSE|M25)?[0-9]{0,3}(\\.[0-9]{0,4})?[ \n;*A-Z]{0,2}"
    ) {
        if is_allowed(&text) {
            prop_assert!(!text.contains(['\n', '\r', ';', '*']));
            let value = |head: &str| text.strip_prefix(head).and_then(|number| number.parse::<f64>().ok());
            let inside = |(head, field): &(&str, Field)| {
                value(head).is_some_and(|value| value >= field.low && value <= field.high)
            };
            let known = BARE.contains(&text.as_str()) || NUMBERED.iter().any(inside);
            prop_assert!(known, "{}", text);
        }
    }
}
