//! Bead cross section: width from flow and back.
//!
//! The paper's rectangle and the slicer's stadium differ by `h (1 - pi/4)` in width, 9 % of a usual bead: planner,
//! plant and estimator must use the same one (model book 1.2). Everything here that runs uses [`stadium`].
//! Flow q `[m3/s]`, path speed v `[m/s]` above 0, layer height h `[m]` above 0, width w `[m]`.

/// Part of the height by which a stadium is wider than the rectangle of the same area `[-]`: `1 - pi/4`.
pub const ROUND_SIDES: f64 = 1.0 - std::f64::consts::FRAC_PI_4;

/// How the width answers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensitivities {
    /// dw/dq `[s/m2]`.
    pub to_flow_s_m2: f64,
    /// dw/dv `[s]`; below 0: faster is thinner (the paper prints it without the sign).
    pub to_speed_s: f64,
    /// dw/dh `[-]`.
    pub to_height: f64,
}

/// The paper's rectangle: `q = v h w`.
pub mod rectangle {
    use super::Sensitivities;

    /// Cross section `[m2]`.
    #[must_use]
    pub fn area_m2(width_m: f64, height_m: f64) -> f64 {
        width_m * height_m
    }

    /// Flow for a width.
    #[must_use]
    pub fn flow_m3_s(width_m: f64, speed_m_s: f64, height_m: f64) -> f64 {
        speed_m_s * area_m2(width_m, height_m)
    }

    /// Width from a flow.
    #[must_use]
    pub fn width_m(flow_m3_s: f64, speed_m_s: f64, height_m: f64) -> f64 {
        flow_m3_s / (speed_m_s * height_m)
    }

    /// `dw/dq = 1/(v h)`, `dw/dv = -q/(v^2 h)`, `dw/dh = -q/(v h^2)`.
    #[must_use]
    pub fn sensitivities(flow_m3_s: f64, speed_m_s: f64, height_m: f64) -> Sensitivities {
        let width_m = width_m(flow_m3_s, speed_m_s, height_m);
        Sensitivities {
            to_flow_s_m2: 1.0 / (speed_m_s * height_m),
            to_speed_s: -width_m / speed_m_s,
            to_height: -width_m / height_m,
        }
    }
}

/// The slicer's stadium, a rectangle with half-round sides: `A = h (w - h) + pi h^2 / 4`, for `w >= h`.
pub mod stadium {
    use super::{ROUND_SIDES, Sensitivities, rectangle};

    /// Cross section `[m2]`.
    #[must_use]
    pub fn area_m2(width_m: f64, height_m: f64) -> f64 {
        height_m * (width_m - height_m * ROUND_SIDES)
    }

    /// Width for a cross section `[m2]`.
    #[must_use]
    pub fn width_of_area_m(area_m2: f64, height_m: f64) -> f64 {
        area_m2 / height_m + height_m * ROUND_SIDES
    }

    /// Flow for a width.
    #[must_use]
    pub fn flow_m3_s(width_m: f64, speed_m_s: f64, height_m: f64) -> f64 {
        speed_m_s * area_m2(width_m, height_m)
    }

    /// Width from a flow: `w = q/(v h) + h (1 - pi/4)`.
    #[must_use]
    pub fn width_m(flow_m3_s: f64, speed_m_s: f64, height_m: f64) -> f64 {
        width_of_area_m(flow_m3_s / speed_m_s, height_m)
    }

    /// As the rectangle's, with `1 - pi/4` more per height.
    #[must_use]
    pub fn sensitivities(flow_m3_s: f64, speed_m_s: f64, height_m: f64) -> Sensitivities {
        let flat = rectangle::sensitivities(flow_m3_s, speed_m_s, height_m);
        Sensitivities { to_height: flat.to_height + ROUND_SIDES, ..flat }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Model book 1.2: +42.9 um at h = 0.2 mm.
    #[test]
    fn a_stadium_is_wider_than_the_rectangle_by_its_round_sides() {
        let wider_m = stadium::width_m(4.8e-9, 0.05, 2e-4) - rectangle::width_m(4.8e-9, 0.05, 2e-4);
        assert!((wider_m - 42.92e-6).abs() < 0.01e-6);
    }

    proptest! {
        #[test]
        fn width_to_flow_and_back_is_the_identity(
            width_m in 2e-4..1.2e-3_f64, speed_m_s in 1e-3..0.5_f64, height_m in 5e-5..4e-4_f64,
        ) {
            let back = stadium::width_m(stadium::flow_m3_s(width_m, speed_m_s, height_m), speed_m_s, height_m);
            prop_assert!((back - width_m).abs() < 1e-12 * width_m.max(height_m));
            let back = rectangle::width_m(rectangle::flow_m3_s(width_m, speed_m_s, height_m), speed_m_s, height_m);
            prop_assert!((back - width_m).abs() < 1e-12 * width_m);
        }

        #[test]
        fn sensitivities_are_the_slopes_of_the_width(
            flow in 1e-9..1e-8_f64, speed in 1e-2..0.2_f64, height in 1e-4..3e-4_f64,
        ) {
            let slopes = stadium::sensitivities(flow, speed, height);
            // Central difference with relative step 1e-5: error of order 1e-10, rounding of order 1e-11.
            let step = 1e-5;
            let to_speed = (stadium::width_m(flow, speed * (1.0 + step), height)
                - stadium::width_m(flow, speed * (1.0 - step), height)) / (2.0 * step * speed);
            let to_height = (stadium::width_m(flow, speed, height * (1.0 + step))
                - stadium::width_m(flow, speed, height * (1.0 - step))) / (2.0 * step * height);
            let to_flow = (stadium::width_m(flow * (1.0 + step), speed, height)
                - stadium::width_m(flow * (1.0 - step), speed, height)) / (2.0 * step * flow);
            prop_assert!(slopes.to_speed_s < 0.0);
            prop_assert!((slopes.to_speed_s - to_speed).abs() < 1e-7 * to_speed.abs());
            prop_assert!((slopes.to_height - to_height).abs() < 1e-7 * (1.0 + to_height.abs()));
            prop_assert!((slopes.to_flow_s_m2 - to_flow).abs() < 1e-7 * to_flow);
        }
    }
}
