//! A test line printed by the simulated printer as a whole: G-code, planner, drive, pressure and nozzle, seen through its
//! width gauge alone.

mod seen;

use advance_predictor::compensation::calibration::Line;
use anyhow::bail;
use models::advance::{Condition, TestLine};
use models::bead::ROUND_SIDES;
use models::gcode::Header;
use models::motion::{MotionParams, Segment};
use models::status::JobPhase;
use models::units::{Celsius, Seconds};
use printer_sim::job::{Preheat, Wishes};
use printer_sim::{JobSource, Output, Params, Scenario, Simulator};
use seen::Seen;
use std::sync::Arc;

/// Step of the simulation.
const STEP: Seconds = Seconds(1e-3);
/// Time between two widths `[s]`: 0.4 mm of the fast stretch, as close as the pattern's spacing.
const GAUGE_S: f64 = 5e-3;
/// Line laid before the test line, so that it begins steady: 4 s at 20 mm/s `[m]`.
const LEAD_IN_M: f64 = 0.08;

/// Line laid behind it, so that it ends steady `[m]`.
const LEAD_OUT_M: f64 = 0.01;
/// Where the lead-in begins `[m]`.
const X_M: f64 = 0.01;

/// Half widths of the parabola's three points about its centre, round by round, relative: a line with 5 % more or less
/// differs by far more than its spools do. And the spools whose truth is asked: each needs another K by 1 or 2 %, so that
/// the last round takes many.
const ROUNDS: [(f64, u64); 3] = [(0.2, 2), (0.1, 2), (0.05, 24)];
/// The first of them; none of a calibration's own.
const FIRST_SPOOL: u64 = 1;

/// Faster than this times the slow speed is the fast stretch, its ramps among it.
const SLOW: f64 = 1.01;
/// Who sees the width.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Eye {
    /// The gauge, with its noise.
    Gauge,
    /// The printer's own truth, at every step.
    Truth,
}

/// Two-sided 95 % quantile of Student's t with 23 degrees of freedom, those of the last round.
const CERTAIN: f64 = 2.07;

/// Standard error of half the ratio of two sums over spools, by how far each spool is off it.
fn ratio_error(pairs: &[[f64; 2]], ratio: f64, sum: f64) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "a small count")]
    let count = pairs.len() as f64;
    let squares = pairs.iter().map(|[above, below]| (above - ratio * below).powi(2)).sum::<f64>();
    0.5 * (count / (count - 1.0) * squares).sqrt() / sum
}

/// What prints the lines.
pub(super) struct PlantLine {
    params: Params,
    motion: MotionParams,
    line: TestLine,
    at: Condition,
}

impl PlantLine {
    /// A printer whose gauge looks at the finished line closely, with a noise of `width_sigma_m`.
    #[must_use]
    pub(super) fn new(
        mut params: Params,
        motion: MotionParams,
        (line, at): (TestLine, Condition),
        width_sigma_m: f64,
    ) -> Self {
        let sensors = &mut params.simulator.sensors;
        (sensors.width_period_s, sensors.width_dither) = (GAUGE_S, 0.0);
        sensors.width_delay_s = 0.0;
        sensors.width_sigma_m = width_sigma_m;
        params.simulator.imu.period_s = 0.0;
        params.camera.enabled = false;
        Self { params, motion, line, at }
    }

    /// A line with this advance by its widths: errors of the cross section by way, noise included. The mean square is about
    /// the mean: a spool that is thick or slips makes the whole line wide or narrow, which no advance mends.
    ///
    /// # Errors
    /// A print that does not come to its end.
    pub(super) fn line(&self, advance_s: f64, seed: u64) -> anyhow::Result<Line> {
        self.print(advance_s, seed, Eye::Gauge)
    }

    /// The advance that prints the line best, by the printer's own truth, and half of its 95 % interval: what a calibration
    /// ought to find. Vertex of a parabola through three lines of the same spools, round by round closer.
    ///
    /// # Errors
    /// As [`Self::line`], and where the last of the parabolas has no least.
    pub(super) fn best_s(&self, start_s: f64) -> anyhow::Result<[f64; 2]> {
        let (mut centre_s, mut error_s) = (start_s, 0.0);
        for (reach, spools) in ROUNDS {
            let half_s = reach * centre_s;
            let mut pairs = vec![];
            for spool in 0..spools {
                let square = |advance_s: f64| {
                    Ok::<_, anyhow::Error>(self.print(advance_s, FIRST_SPOOL + spool, Eye::Truth)?.square)
                };
                let (low, middle, high) =
                    (square(centre_s - half_s)?, square(centre_s)?, square(centre_s + half_s)?);
                pairs.push([low - high, low - 2.0 * middle + high]);
            }
            let [slope, bend] = [0, 1].map(|part| pairs.iter().map(|pair| pair[part]).sum::<f64>());
            error_s = f64::INFINITY;
            if bend > 0.0 {
                let offset = (0.5 * slope / bend).clamp(-2.0, 2.0);
                centre_s += half_s * offset;
                error_s = half_s * ratio_error(&pairs, 2.0 * offset, bend);
            }
        }
        if !error_s.is_finite() {
            bail!("no advance about {centre_s:.4} s is best by the simulated printer's own widths");
        }
        Ok([centre_s, CERTAIN * error_s])
    }

    fn print(&self, advance_s: f64, seed: u64, eye: Eye) -> anyhow::Result<Line> {
        let bytes: Arc<[u8]> = self.gcode(advance_s).into_bytes().into();
        let job =
            JobSource::from_gcode(&bytes, &Header::scan(&bytes, &bytes), &self.motion, Wishes::default());
        let mut printer = Simulator::new(self.params.clone(), job, &Scenario::default(), seed)?;
        printer.warm_up(&Preheat { hotend: Some(self.at.temperature), bed: Some(Celsius(60.0)) });
        let (mut move_now, mut seen) = (None::<(Seconds, Segment)>, Seen::default());
        while !matches!(printer.phase(), JobPhase::Done | JobPhase::Failed) {
            printer.step(STEP);
            while let Some(output) = printer.poll() {
                match output {
                    Output::Motion { start, segment } => move_now = Some((start, *segment)),
                    Output::Width { exposed, width_m, .. } if eye == Eye::Gauge => {
                        self.see(move_now.as_ref(), (exposed, width_m), &mut seen);
                    }
                    _ => {}
                }
            }
            let truth = printer.truth();
            if eye == Eye::Truth && truth.depositing {
                self.see(move_now.as_ref(), (Seconds(truth.stamp_s), truth.width_m), &mut seen);
            }
        }
        match seen.line() {
            Some(line) if printer.phase() == JobPhase::Done => Ok(line),
            _ => bail!("the simulated printer did not print the line"),
        }
    }

    /// A width of the line: its cross section against the wanted one, where it is the test line's.
    fn see(&self, move_now: Option<&(Seconds, Segment)>, (at, width_m): (Seconds, f64), seen: &mut Seen) {
        let Some((start, segment)) = move_now else { return };
        let Some(target_m) = segment.target_width_m else { return };
        let (point_m, state) = segment.at(at - *start);
        if (X_M + LEAD_IN_M..=self.end_m()).contains(&point_m[0]) {
            let error = (width_m - target_m) / (target_m - self.at.height_m * ROUND_SIDES);
            let slow = state.speed_m_s <= SLOW * self.line.low_m_s;
            seen.add(error, (state.speed_m_s, slow));
        }
    }

    /// The pattern's line: lead-in and slow stretch, fast stretch, slow stretch.
    fn gcode(&self, advance_s: f64) -> String {
        let Condition { temperature, height_m, width_m } = self.at;
        let area_m2 = self.params.plant.extruder.filament_area_m2();
        let (low, high) = (6e4 * self.line.low_m_s, 6e4 * self.line.high_m_s);
        let acceleration = 1e3 * self.line.acceleration_m_s2;
        let mut x_mm = 1e3 * X_M;
        let begin_mm = x_mm;
        let mut road = |way_m: f64, feed: f64| {
            x_mm += 1e3 * way_m;
            let filament_mm = 1e3 * way_m * height_m * width_m / area_m2;
            format!("G1 X{x_mm:.4} E{filament_mm:.5} F{feed:.1}\n")
        };
        // Jerk as good as none: the speeds change in ramps alone.
        let mut text = format!(
            "M140 S60\nM104 S{:.1}\nG28\nG90\nM83\nM201 X{acceleration:.0} Y{acceleration:.0} E10000\n\
             M204 P{acceleration:.0} T{acceleration:.0}\nM205 X0.01 Y0.01 E5\nM900 K{advance_s:.5}\n;LAYER_CHANGE\n;Z:{h:.3}\n\
             ;HEIGHT:{h:.3}\n;TYPE:External perimeter\n;WIDTH:{:.4}\nG1 X{begin_mm:.3} Y50 Z{h:.3} F3000\n",
            temperature.0,
            1e3 * width_m,
            h = 1e3 * height_m,
        );
        text.push_str(&road(LEAD_IN_M, low));
        text.push_str(&road(self.line.low_m, low));
        text.push_str(&road(self.line.high_m, high));
        text.push_str(&road(self.line.low_m, low));
        text.push_str(&road(LEAD_OUT_M, low));
        text
    }

    /// Where the test line ends `[m]`.
    fn end_m(&self) -> f64 {
        X_M + LEAD_IN_M + 2.0 * self.line.low_m + self.line.high_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::advance::Setup;
    use crate::config::{Choice, ConfigDir};
    use mpc_controller::params::{AdvanceSource, Level};

    fn plant() -> PlantLine {
        let folder = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config"));
        let config = ConfigDir::find(Some(folder)).unwrap();
        let choice = Choice { advance: AdvanceSource::File, ..Choice::of("PLA".into(), Level::Off) };
        let loaded = config.load(&choice).unwrap();
        let at = Condition { temperature: Celsius(215.0), height_m: 2e-4, width_m: 4e-4 };
        let line = Setup::load(&config).unwrap().physics.test_line;
        PlantLine::new(loaded.simulated, loaded.motion, (line, at), 1.2e-5)
    }

    /// 0.08 mm2 of section over 2.405 mm2 of filament: 80 mm of lead-in take 2.661 mm.
    #[test]
    fn the_line_is_the_papers() {
        let text = plant().gcode(0.5);
        assert!(text.contains("M900 K0.50000\n") && text.contains("M204 P1000"), "{text}");
        assert!(text.contains("G1 X90.0000 E2.66081 F1200.0\n"), "{text}");
        assert!(text.contains("F4800.0") && text.trim_end().ends_with("F1200.0"), "{text}");
    }

    /// Without compensation the line is half of a mean wrong (model book 2.2: RMS 0.51 at K = 0.55 s); with about the
    /// printer's own lag a fifth of that.
    #[test]
    fn its_width_shows_the_advance() {
        let plant = plant();
        let rms = |advance_s: f64| plant.line(advance_s, 1).unwrap().square.sqrt();
        let (none, near) = (rms(0.0), rms(0.79));
        assert!((0.4..0.6).contains(&none) && near < 0.2 * none, "{none} {near}");
    }

    /// What the truth calls best is better than 5 % less and 5 % more, with spools that it was not found with, and is told
    /// closer than that.
    #[test]
    fn the_best_advance_is_a_valley() {
        let plant = plant();
        let [best_s, half_width_s] = plant.best_s(0.63).unwrap();
        let square = |advance_s: f64| -> f64 {
            (101..=104).map(|seed| plant.print(advance_s, seed, Eye::Truth).unwrap().square).sum()
        };
        let least = square(best_s);
        assert!(least < square(0.95 * best_s) && least < square(1.05 * best_s), "{best_s}");
        assert!((0.0..0.02 * best_s).contains(&half_width_s) && half_width_s > 0.0, "{half_width_s}");
    }

    /// By hand: 3/4 over two spools that are off it by 1/4 and -1/4: sqrt(2/1 (1/16 + 1/16)) / 2 / 2.
    #[test]
    fn spools_that_differ_make_the_truth_less_sure() {
        assert!((ratio_error(&[[1.0, 1.0], [0.5, 1.0]], 0.75, 2.0) - 0.125).abs() < 1e-15);
        assert!(ratio_error(&[[0.75, 1.0], [1.5, 2.0]], 0.75, 3.0).abs() < 1e-15);
    }
}
