//! A person's own lines in the words of `fdm advance train`.

use advance_predictor::compensation::assess::OwnLines;

/// Contradictions that are told one by one.
const CONTRADICTIONS_TOLD: usize = 10;

/// How the person's own lines are met, before all that is said of virtual ones.
pub(super) fn text(own: &OwnLines) -> Vec<String> {
    let mut lines = vec![format!(
        "  own lines    foretold less measured: mean {:.4} s, largest {:.4} s; {} of {} within the interval of +- {:.4} s",
        own.mean_abs_s,
        own.max_abs_s,
        own.covered,
        own.count - own.outside_hull,
        own.mean_half_width_s
    )];
    for pair in own.contradictions.iter().take(CONTRADICTIONS_TOLD) {
        let ([one, other], [least_s, most_s]) = (pair.rows, pair.advance_s);
        lines.push(format!(
            "               line {one} ({least_s} s) and line {other} ({most_s} s) are of one condition: they CONTRADICT each other"
        ));
    }
    if let Some(more) = own.contradictions.len().checked_sub(CONTRADICTIONS_TOLD).filter(|more| *more > 0) {
        lines.push(format!("               and {more} conditions more"));
    }
    lines.push("  what follows is of virtual lines, scaled by own over physical model".to_owned());
    if own.virtual_left_out > 0 {
        lines.push(format!(
            "               {} that come to lie outside of the drive's range left out",
            own.virtual_left_out
        ));
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use advance_predictor::compensation::measured::Contradiction;

    /// How they are met, and what they contradict, up to ten.
    #[test]
    fn own_lines_are_told_before_the_virtual_ones() {
        let contradiction = Contradiction { rows: [3, 5], advance_s: [0.64, 0.7] };
        let own = OwnLines {
            count: 5,
            outside_hull: 1,
            mean_abs_s: 0.002,
            max_abs_s: 0.03,
            covered: 3,
            mean_half_width_s: 0.008,
            virtual_left_out: 14,
            contradictions: vec![contradiction; CONTRADICTIONS_TOLD + 2],
        };
        let told = text(&own);
        assert_eq!(
            told[..2],
            [
                "  own lines    foretold less measured: mean 0.0020 s, largest 0.0300 s; 3 of 4 within the interval of +- 0.0080 s",
                "               line 3 (0.64 s) and line 5 (0.7 s) are of one condition: they CONTRADICT each other",
            ]
        );
        assert_eq!(told[11..14].concat().matches("2 conditions more").count(), 1, "{told:?}");
        assert!(told[12].contains("virtual lines, scaled") && told[13].contains("14 that come"), "{told:?}");
    }
}
