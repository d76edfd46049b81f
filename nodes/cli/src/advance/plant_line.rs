//! A test line printed by the simulated printer as a whole: G-code, planner, drive, pressure and nozzle, seen through its
//! width gauge alone.

use anyhow::bail;
use models::advance::{Condition, TestLine};
use models::bead::ROUND_SIDES;
use models::gcode::Header;
use models::motion::{MotionParams, Segment};
use models::status::JobPhase;
use models::units::{Celsius, Seconds};
use printer_sim::job::{Preheat, Wishes};
use printer_sim::{JobSource, Output, Params, Scenario, Simulator};
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
        sensors.width_period_s = GAUGE_S;
        sensors.width_delay_s = 0.0;
        sensors.width_sigma_m = width_sigma_m;
        params.simulator.imu.period_s = 0.0;
        params.camera.enabled = false;
        Self { params, motion, line, at }
    }

    /// Mean square of the cross section's relative error along a line with this advance, by way, noise included.
    ///
    /// # Errors
    /// A print that does not come to its end.
    pub(super) fn mean_square(&self, advance_s: f64, seed: u64) -> anyhow::Result<f64> {
        let bytes: Arc<[u8]> = self.gcode(advance_s).into_bytes().into();
        let job =
            JobSource::from_gcode(&bytes, &Header::scan(&bytes, &bytes), &self.motion, Wishes::default());
        let mut printer = Simulator::new(self.params.clone(), job, &Scenario::default(), seed)?;
        printer.warm_up(&Preheat { hotend: Some(self.at.temperature), bed: Some(Celsius(60.0)) });
        let (mut move_now, mut squares_m, mut way_m) = (None::<(Seconds, Segment)>, 0.0, 0.0);
        while !matches!(printer.phase(), JobPhase::Done | JobPhase::Failed) {
            printer.step(STEP);
            while let Some(output) = printer.poll() {
                match output {
                    Output::Motion { start, segment } => move_now = Some((start, *segment)),
                    Output::Width { exposed, width_m, .. } => {
                        let Some((start, segment)) = &move_now else { continue };
                        let Some(target_m) = segment.target_width_m else { continue };
                        let (point_m, state) = segment.at(exposed - *start);
                        if !(X_M + LEAD_IN_M..=self.end_m()).contains(&point_m[0]) {
                            continue;
                        }
                        let error = (width_m - target_m) / (target_m - self.at.height_m * ROUND_SIDES);
                        squares_m += error * error * state.speed_m_s;
                        way_m += state.speed_m_s;
                    }
                    _ => {}
                }
            }
        }
        if printer.phase() == JobPhase::Failed || way_m <= 0.0 {
            bail!("the simulated printer did not print the line");
        }
        Ok(squares_m / way_m)
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
        let rms = |advance_s: f64| plant.mean_square(advance_s, 1).unwrap().sqrt();
        let (none, near) = (rms(0.0), rms(0.75));
        assert!((0.4..0.6).contains(&none) && near < 0.3 * none, "{none} {near}");
    }
}
