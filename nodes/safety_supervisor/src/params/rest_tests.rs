use super::*;

/// Corrections that came back before the slicer's values were reached would leap.
#[test]
fn a_ramp_that_outlasts_the_hold_is_refused() {
    let text = include_str!("../../../../config/safety_supervisor.param.yaml");
    let file: serde_json::Value = serde_saphyr::from_str(text).unwrap();
    let modes = |ramp_s: f64| {
        let mut modes = file["/**"]["ros__parameters"]["modes"].clone();
        (modes["ramp_s"], modes["hold_s"]) = (ramp_s.into(), 1.0.into());
        serde_json::from_value::<ModeParams>(modes).map_err(|error| error.to_string())
    };
    assert!(modes(0.9).is_ok());
    assert_eq!(modes(1.0).unwrap_err(), "ramp_s = 1: must be below hold_s = 1");
}

#[test]
fn ages_that_do_not_rise_and_attention_that_never_ends_are_refused() {
    let stale =
        |pause_s| StaleParams::try_from(RawStaleParams { degraded_s: 0.5, pause_s, safe_off_s: Some(3.0) });
    let error = stale(Some(4.0)).unwrap_err().to_string();
    assert_eq!(error, "pause_s = 4: must be below safe_off_s = 3");
    assert!(stale(None).is_ok() && stale(Some(0.4)).is_err());
    let calm = RawAttentionParams { soft: 0.3, hard: 0.8, hysteresis: 0.4, n_soft: 2, n_hard: 3, n_off: 5 };
    let error = AttentionParams::try_from(calm).unwrap_err().to_string();
    assert_eq!(error, "hysteresis = 0.4 (no unit): must be in [0, 0.3]");
}
