use super::*;

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
