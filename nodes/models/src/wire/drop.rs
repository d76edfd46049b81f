//! The drop as a hemisphere and what it lacks to a cylinder ([WIRE] (13)-(21), corrected).

use std::f64::consts::PI;

use crate::params::{ParamError, in_range, positive};

/// Radius of the hemisphere of a volume `[m]`: `R = (3V/2pi)^(1/3)`; (13) with the factor 3 that it lacks.
#[must_use]
pub fn radius_m(volume_m3: f64) -> f64 {
    (1.5 * volume_m3 / PI).cbrt()
}

/// What a drop lacks to the cylinder of its radius and height `[m3]`: `V_m = pi R^3 - V`, for a hemisphere `V/2`.
#[must_use]
pub fn missing_m3(radius_m: f64, volume_m3: f64) -> f64 {
    PI * radius_m.powi(3) - volume_m3
}

/// Volume of the spherical cap between `a` and `2R` of a sphere that begins at 0 `[m3]`:
/// `V(a) = (pi/3) (2R - a)^2 (R + a)`; falls from `4 pi R^3/3` at 0 to 0 at 2R.
#[must_use]
pub fn cap_m3(radius_m: f64, lower_m: f64) -> f64 {
    PI / 3.0 * (2.0 * radius_m - lower_m).powi(2) * (radius_m + lower_m)
}

/// Lower limit `a` of the cap of a volume `[m]`, in `[0, 2R]`.
///
/// Root of `pi a^3 - 3 pi R a^2 + 4 pi R^3 - 3V = 0` in that interval: `a = R + 2R cos(phi - 2pi/3)` with
/// `phi = arccos(1 - (4R^3 - 3V/pi)/(2R^3))/3`. Three real roots stand there, so no complex number is needed.
///
/// # Errors
/// [`ParamError::OutOfRange`] for a radius not above 0 or a volume outside `[0, 4 pi R^3/3]`.
pub fn cap_lower_limit_m(radius_m: f64, volume_m3: f64) -> Result<f64, ParamError> {
    positive("radius_m", radius_m, "m")?;
    let sphere_m3 = 4.0 / 3.0 * PI * radius_m.powi(3);
    in_range("volume_m3", volume_m3, "m3", (0.0, sphere_m3))?;
    let cosine = 1.0 - 2.0 * (1.0 - volume_m3 / sphere_m3);
    // Rounding at the ends of the interval alone can leave it.
    let phi = cosine.clamp(-1.0, 1.0).acos() / 3.0;
    Ok(radius_m * (1.0 + 2.0 * (phi - 2.0 * PI / 3.0).cos()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Model book 3.2: the nominal row's 3 mm of 3 mm wire make the printed 2.16 mm.
    #[test]
    fn the_nominal_drop_has_the_printed_height() {
        let radius_m = radius_m(super::super::melting::wire_volume_m3(3e-3, 3e-3));
        assert!((radius_m - 2.1634e-3).abs() < 1e-7);
    }

    #[test]
    fn twice_the_missing_volume_is_cut_off_at_the_radius() {
        let volume_m3 = 21.2e-9;
        let radius = radius_m(volume_m3);
        let lower_m = cap_lower_limit_m(radius, 2.0 * missing_m3(radius, volume_m3)).unwrap();
        assert!((lower_m / radius - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_cap_larger_than_its_sphere_is_refused() {
        let error = cap_lower_limit_m(1.0, 5.0).unwrap_err();
        assert!(error.to_string().starts_with("volume_m3 = 5 m3: must be in [0, 4.18"), "{error}");
        assert!(cap_lower_limit_m(-1.0, 0.0).is_err() && cap_lower_limit_m(1.0, f64::NAN).is_err());
    }

    proptest! {
        /// Away from the poles, where the volume is flat, the round trip keeps nine digits.
        #[test]
        fn the_cap_of_its_lower_limit_has_the_volume(radius in 1e-4..1e-2_f64, share in 0.0..=1.0_f64) {
            let sphere = cap_m3(radius, 0.0);
            let lower = cap_lower_limit_m(radius, share * sphere).unwrap();
            prop_assert!((-1e-9 * radius..=2.0 * radius * (1.0 + 1e-9)).contains(&lower));
            prop_assert!((cap_m3(radius, lower) - share * sphere).abs() < 1e-9 * sphere);
        }

        #[test]
        fn more_volume_means_a_lower_limit(radius in 1e-4..1e-2_f64, share in 0.01..0.98_f64) {
            let sphere = cap_m3(radius, 0.0);
            let less = cap_lower_limit_m(radius, share * sphere).unwrap();
            let more = cap_lower_limit_m(radius, (share + 0.01) * sphere).unwrap();
            prop_assert!(more < less);
        }
    }
}
