//! Trims attached to a coming move: what is known ahead is planned, not chased.

/// Trims of one coming move; a host that streams the file, or plans it, executes them with the move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionTrim {
    /// The move, as the printer counts them from the start of the print.
    pub sequence: u64,
    /// Filament per path length relative to the slicer's `[-]`.
    pub flow: f64,
    /// Path speed relative to the slicer's `[-]`.
    pub speed: f64,
    /// Pressure advance over the move's speed.
    pub advance: AdvanceLaw,
}

/// Pressure advance over the feed `u`: `K_A(u) = K_lin + a u^(n-1)`, so that `x = K_A u` is held compressed.
///
/// One `K_A` holds at one speed only: the compressed length of a shear-thinning melt is no multiple of the flow (model
/// book 1.2). A law with `a = 0` is a constant `K_A`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdvanceLaw {
    /// Linear part K_lin `[s]`, 0 or more.
    pub linear_s: f64,
    /// Scale a of the melt's part `[m (s/m)^n]`, 0 or more.
    pub shear: f64,
    /// Flow index n `[-]`, in `(0, 1]`.
    pub index: f64,
}

impl AdvanceLaw {
    /// Filament held compressed at a feed `[m/s]` `[m]`; none at rest.
    #[must_use]
    pub fn held_m(&self, feed_m_s: f64) -> f64 {
        if feed_m_s > 0.0 { self.linear_s * feed_m_s + self.shear * feed_m_s.powf(self.index) } else { 0.0 }
    }

    fn is_valid(&self) -> bool {
        let size = |value: f64| value.is_finite() && value >= 0.0;
        size(self.linear_s) && size(self.shear) && self.index > 0.0 && self.index <= 1.0
    }
}

impl MotionTrim {
    /// Whether all of it is finite and physical.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let positive = |value: f64| value.is_finite() && value > 0.0;
        positive(self.flow) && positive(self.speed) && self.advance.is_valid()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_without_a_melts_part_is_one_k_a_and_rest_holds_nothing() {
        let law = AdvanceLaw { linear_s: 0.6, shear: 0.0, index: 0.4 };
        assert!(
            (law.held_m(2e-3) - 1.2e-3).abs() < 1e-15 && law.held_m(0.0) == 0.0 && law.held_m(-1.0) == 0.0
        );
    }

    #[test]
    fn what_is_not_physical_is_no_trim() {
        let law = AdvanceLaw { linear_s: 0.4, shear: 1e-3, index: 0.4 };
        let trim = MotionTrim { sequence: 1, flow: 1.0, speed: 1.0, advance: law };
        assert!(trim.is_valid());
        for broken in [f64::NAN, -1.0, f64::INFINITY] {
            assert!(!MotionTrim { flow: broken, ..trim }.is_valid());
            assert!(!MotionTrim { speed: broken, ..trim }.is_valid());
            assert!(!MotionTrim { advance: AdvanceLaw { linear_s: broken, ..law }, ..trim }.is_valid());
            assert!(!MotionTrim { advance: AdvanceLaw { shear: broken, ..law }, ..trim }.is_valid());
            assert!(!MotionTrim { advance: AdvanceLaw { index: broken, ..law }, ..trim }.is_valid());
        }
    }
}
