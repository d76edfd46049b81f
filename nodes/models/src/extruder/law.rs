//! Static law of the compressed filament, its inverse, and the step of the compressed length.

use super::Extruder;
use super::lag::fading_mean;
use crate::command::AdvanceLaw;
use crate::melt::Melt;
use crate::units::{Kelvin, Seconds};

/// Static law `x = a u^n + K_lin u` at one melt temperature and clog factor, `a u^n = c F / kappa`.
///
/// Holds what depends on temperature and clog alone, so that the 1 kHz step pays no exponential for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StaticLaw {
    flow_index: f64,
    inverse_index: f64,
    /// Force per `u^n`, clog included `[N (s/m)^n]`.
    force_scale: f64,
    /// Compression per `u^n` `[m (s/m)^n]`.
    compression_scale: f64,
    linear_lag_s: f64,
}

/// Newton steps at most; three are the rule from a warm start, about ten from a cold one.
const NEWTON_STEPS: usize = 40;
/// Relative step at which Newton's quadratic convergence has used up the f64's digits.
const NEWTON_TOLERANCE: f64 = 1e-9;

impl StaticLaw {
    /// Law at a melt temperature; `clog` is kappa in `(0, 1]`, 1 being a free nozzle.
    #[must_use]
    pub fn new(melt: &Melt, extruder: &Extruder, temp: Kelvin, clog: f64) -> Self {
        let flow_index = melt.flow_index();
        let force_scale = melt.force_scale(temp) / clog;
        Self {
            flow_index,
            inverse_index: 1.0 / flow_index,
            force_scale,
            compression_scale: extruder.compliance_m_n * force_scale,
            linear_lag_s: extruder.linear_lag_s,
        }
    }

    /// Law of a melt that leaves the colder the faster it flows, `T_m(u)` (model book 1.2), as one power law: exact at two
    /// outlet speeds `[m/s]`, 0 < low < high; `None` where no force drives it: of a melt that is frozen.
    #[must_use]
    pub fn of_melting(
        (melt, extruder): (&Melt, &Extruder),
        (nozzle, filament): (Kelvin, Kelvin),
        (low_m_s, high_m_s): (f64, f64),
    ) -> Option<Self> {
        let force_n = |outlet_m_s: f64| {
            let flow_m3_s = outlet_m_s * melt.filament_area_m2();
            melt.force_n(flow_m3_s, melt.melt_temperature(nozzle, filament, flow_m3_s))
        };
        let (least_n, most_n) = (force_n(low_m_s), force_n(high_m_s));
        let flow_index = ((most_n / least_n).ln() / (high_m_s / low_m_s).ln()).min(1.0);
        let force_scale = most_n / high_m_s.powf(flow_index);
        (flow_index > 0.0 && force_scale > 0.0 && force_scale.is_finite()).then(|| Self {
            flow_index,
            inverse_index: 1.0 / flow_index,
            force_scale,
            compression_scale: extruder.compliance_m_n * force_scale,
            linear_lag_s: extruder.linear_lag_s,
        })
    }

    /// Law `x = b u^n + K_lin u` given by its compression alone, `b` in `[m (s/m)^n]`: for drives whose force is not
    /// known. [`StaticLaw::force_n`] then reads as for a compliance of 1 m/N.
    #[must_use]
    pub fn of_compression(flow_index: f64, compression_scale: f64, linear_lag_s: f64) -> Self {
        Self {
            flow_index,
            inverse_index: 1.0 / flow_index,
            force_scale: compression_scale,
            compression_scale,
            linear_lag_s,
        }
    }

    /// Law of an extruder that holds `factor` times as much compressed at every outlet speed, by more compliance and friction.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            compression_scale: factor * self.compression_scale,
            linear_lag_s: factor * self.linear_lag_s,
            ..self
        }
    }

    /// Compressed length `[m]` that holds an outlet speed `[m/s]` of 0 or more.
    #[must_use]
    pub fn compression_m(&self, outlet_m_s: f64) -> f64 {
        self.compression_scale * outlet_m_s.powf(self.flow_index) + self.linear_lag_s * outlet_m_s
    }

    /// Force on the filament `[N]` at an outlet speed `[m/s]` of 0 or more; a clog raises it.
    #[must_use]
    pub fn force_n(&self, outlet_m_s: f64) -> f64 {
        self.force_scale * outlet_m_s.powf(self.flow_index)
    }

    /// Pressure advance that holds compressed what this law asks at every outlet speed.
    #[must_use]
    pub fn advance(&self) -> AdvanceLaw {
        AdvanceLaw { linear_s: self.linear_lag_s, shear: self.compression_scale, index: self.flow_index }
    }

    /// Local lag dx/du `[s]` at an outlet speed `[m/s]` above 0.
    #[must_use]
    pub fn lag_s(&self, outlet_m_s: f64) -> f64 {
        self.flow_index * self.compression_scale * outlet_m_s.powf(self.flow_index - 1.0) + self.linear_lag_s
    }

    /// Outlet at a compressed length `[m]`; still for a length of 0 or less. `warm` is the last outlet found
    /// under a law of the same flow index.
    ///
    /// Newton in `y = u^n`: `a y + K_lin y^(1/n) = x` is convex and rising, so it converges from any start, and
    /// nothing is infinite at `u = 0` (in u itself the slope is).
    #[must_use]
    pub fn outlet(&self, compression_m: f64, warm: Outlet) -> Outlet {
        if compression_m <= 0.0 {
            return Outlet::STILL;
        }
        // Without the linear part y would be x/a: never more.
        let most = compression_m / self.compression_scale;
        // A warm start brings its power along: unchanged compression costs none at all.
        let (mut shape, mut speed_m_s) = if warm.shape > 0.0 && warm.shape <= most {
            (warm.shape, warm.speed_m_s)
        } else {
            (most, most.powf(self.inverse_index))
        };
        for _ in 0..NEWTON_STEPS {
            let missing_m = compression_m - self.compression_scale * shape - self.linear_lag_s * speed_m_s;
            let slope = self.compression_scale + self.linear_lag_s * self.inverse_index * speed_m_s / shape;
            let change = missing_m / slope;
            // du = u/(n y) dy, so the speed follows the last, tiny change without another power.
            if change.abs() <= NEWTON_TOLERANCE * shape {
                speed_m_s += self.inverse_index * speed_m_s * change / shape;
                shape += change;
                break;
            }
            shape += change;
            speed_m_s = shape.powf(self.inverse_index);
        }
        Outlet { speed_m_s, shape, force_n: self.force_scale * shape }
    }
}

/// What leaves the nozzle, and the force that goes with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outlet {
    /// Outlet speed u in filament lengths `[m/s]`, 0 or more; the flow is this times the filament's area.
    pub speed_m_s: f64,
    /// Force on the filament `[N]`, 0 or more.
    pub force_n: f64,
    /// `u^n`, the inverse's unknown and warm start.
    shape: f64,
}

impl Outlet {
    /// Nothing flows.
    pub const STILL: Self = Self { speed_m_s: 0.0, force_n: 0.0, shape: 0.0 };
}

/// Compressed length of the filament and what leaves the nozzle because of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pressure {
    compression_m: f64,
    outlet: Outlet,
}

impl Pressure {
    /// Relaxed filament.
    pub const RELAXED: Self = Self { compression_m: 0.0, outlet: Outlet::STILL };

    /// Steady at an outlet speed `[m/s]` of 0 or more.
    #[must_use]
    pub fn steady(law: &StaticLaw, outlet_m_s: f64) -> Self {
        let compression_m = law.compression_m(outlet_m_s);
        Self { compression_m, outlet: law.outlet(compression_m, Outlet::STILL) }
    }

    /// A chamber that `missing_m` of filament, 0 or more, are missing in.
    #[must_use]
    pub(super) fn dry(missing_m: f64) -> Self {
        Self { compression_m: -missing_m, outlet: Outlet::STILL }
    }

    /// Compressed length x `[m]`; below 0 after a retraction, when the melt chamber is not full.
    #[must_use]
    pub fn compression_m(&self) -> f64 {
        self.compression_m
    }

    /// Outlet at the end of the last step.
    #[must_use]
    pub fn outlet(&self) -> Outlet {
        self.outlet
    }

    /// Advances by `dt` under a filament feed `[m/s]` (below 0: retraction) and returns the filament length `[m]`
    /// that left the nozzle, 0 or more.
    ///
    /// Exact for the law's tangent at the start of the step, so stable for any `dt`; and the returned length is the
    /// one that x was reduced by, so filament is conserved to rounding whatever `dt` is.
    pub fn step(&mut self, law: &StaticLaw, feed_m_s: f64, dt: Seconds) -> f64 {
        // The law changes with temperature and clog: the outlet is found under the law of this step.
        let start = law.outlet(self.compression_m, self.outlet);
        let mean_m_s = if start.speed_m_s > 0.0 {
            let ratio = dt.0 / law.tangent_lag_s(start);
            (feed_m_s + (start.speed_m_s - feed_m_s) * fading_mean(ratio)).max(0.0)
        } else {
            0.0
        };
        let laid_m = mean_m_s * dt.0;
        self.compression_m += feed_m_s * dt.0 - laid_m;
        self.outlet = law.outlet(self.compression_m, start);
        laid_m
    }
}

impl StaticLaw {
    fn tangent_lag_s(&self, outlet: Outlet) -> f64 {
        self.flow_index * self.compression_scale * outlet.shape / outlet.speed_m_s + self.linear_lag_s
    }
}
