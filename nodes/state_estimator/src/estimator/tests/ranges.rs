//! What a parameter file may say: whatever is taken runs, and a refusal names field and range.

use super::*;

/// What is said of the shipped file with another value of a key in a block; `None` where it is taken.
fn refusal(block: &str, key: &str, value: &str) -> Option<String> {
    let (before, rest) = SHIPPED.split_once(&format!("  {block}:")).unwrap();
    let at = rest.find(&format!("  {key}: ")).unwrap();
    let end = at + rest[at..].find('\n').unwrap();
    let text = format!("{before}  {block}:{}  {key}: {value}{}", &rest[..at], &rest[end..]);
    serde_saphyr::from_str::<File>(&text).err().map(|error| error.to_string())
}

#[test]
fn a_refused_trust_is_told_with_its_channel() {
    for channel in ["thermistor", "nozzle_sensor", "encoder", "width"] {
        let keys = ["age_limit_s", "gate", "gate_again", "step_fade", "step_samples", "step_threshold"];
        for key in keys {
            let said = refusal(channel, key, "1000000000").unwrap();
            assert!(said.contains(&format!("{channel}.trust.{key} = 1000000000")), "{said}");
            assert!(said.contains("must be in ["), "{said}");
        }
    }
    let said = refusal("width", "rate", "0.06").unwrap();
    assert!(said.contains("width.adaptation.rate = 0.06 (no unit): must be in [0, 0.05]"), "{said}");
}

/// Bounds never reach what a filter starts from, nor a period the longest interval: each end alone is taken, what is beyond
/// the end at the other one is not.
#[test]
fn bounds_and_what_they_bound_stay_apart() {
    for (block, key, taken, refused, range) in [
        ("bounds", "slip_low", "-0.1", "-0.05", "[-10, -0.1]"),
        ("prior", "slip", "-0.05", "-0.1", "[-0.05, 0.9]"),
        ("prior", "slip", "0.9", "1.0", "[-0.05, 0.9]"),
        ("bounds", "slip_high", "1.0", "0.9", "[1, 10]"),
        ("bounds", "gain_low", "0.9", "1.0", "[0.001, 0.9]"),
        ("bounds", "gain_high", "1.1", "1.0", "[1.1, 100]"),
        ("bounds", "temperature_low_k", "240.0", "250.0", "[1, 240]"),
        ("ros__parameters", "ambient_k", "250.0", "240.0", "[250, 400]"),
        ("ros__parameters", "ambient_k", "400.0", "450.0", "[250, 400]"),
        ("bounds", "temperature_high_k", "450.0", "400.0", "[450, 2000]"),
        ("ros__parameters", "period_s", "0.1", "0.2", "[0.01, 0.1]"),
        ("encoder", "interval_min_s", "0.1", "0.2", "[0.001, 0.1]"),
        ("encoder", "interval_max_s", "0.2", "0.1", "[0.2, 10]"),
    ] {
        assert_eq!(refusal(block, key, taken), None, "{block}.{key} = {taken}");
        let said = refusal(block, key, refused).unwrap();
        let name = if block == "ros__parameters" { key.to_owned() } else { format!("{block}.{key}") };
        assert!(
            said.contains(&format!("{name} = ")) && said.contains(&format!("must be in {range}")),
            "{said}"
        );
    }
}

#[test]
fn what_is_learnt_of_the_lag_and_told_of_a_step_has_its_ranges() {
    for (block, key, taken, refused, range) in [
        ("melt_lag", "reach", "0.5", "0.6", "[0, 0.5]"),
        ("melt_lag", "width_noise", "0.001", "0.0", "[0.001, 1]"),
        ("melt_lag", "frames", "2.0", "1.0", "[2, 100000]"),
        ("melt_lag", "lever_min", "1.0", "1.1", "[0, 1]"),
        ("melt_lag", "error_max", "0.01", "0.0", "[0.01, 10]"),
        ("widths_alone", "followed", "1.0", "1.1", "[0, 1]"),
        ("widths_alone", "outlier", "0.5", "0.4", "[0.5, 100]"),
        ("widths_alone", "slip_most", "0.05", "0.0", "[0.05, 1]"),
    ] {
        assert_eq!(refusal(block, key, taken), None, "{block}.{key} = {taken}");
        let said = refusal(block, key, refused).unwrap();
        assert!(said.contains(&format!("{block}.{key} = ")), "{said}");
        assert!(said.contains(&format!("must be in {range}")), "{said}");
    }
}

/// Nothing is forgotten at rest where `frozen` is 0: that is no divergence, with an encoder and without.
#[test]
fn a_filter_that_forgets_nothing_at_rest_goes_on() {
    for form in ["square_root", "unscented", "extended"] {
        let form = format!("filter: {form} ");
        let mut rig = Rig::with(&[("frozen: 0.3 ", "frozen: 0.0 "), ("filter: square_root ", &form)]);
        rig.host = Box::new(|status| status.depositing = false);
        assert_eq!(rig.run(300).resets, 0, "{form}");
        (rig.encoder, rig.width_noise_m) = (false, f64::NAN);
        assert_eq!(rig.run(500).resets, 0, "{form}");
    }
}
