//! What the camera sees in a simulated print: the classifier between the printer and the other brains, and its widths
//! beside the truth.

use crate::config::Sight as Setup;
use defect_classifier::{Classifier, Event, Output};
use models::motion::Segment;
use models::status::PrinterStatus;
use models::units::{Kelvin, Seconds};
use printer_sim::Truth;
use safety_supervisor::{Defect, VisionReport};
use serde::Serialize;
use state_estimator::{Estimate, state};
use std::collections::VecDeque;

/// How far back the truth is kept `[s]`: frames come late, and what they show was laid before.
const TRUTH_KEPT_S: f64 = 5.0;

/// What the other brains get of a frame.
#[derive(Debug, Clone, Copy)]
pub enum Seen {
    /// A width of the road.
    Width {
        /// When it was laid.
        laid: Seconds,
        /// Width `[m]`.
        width_m: f64,
        /// Its stated standard deviation `[m]`.
        sigma_m: f64,
    },
    /// What the frame says of the print.
    Report(VisionReport),
}

/// Figures of what was seen, beside the simulator's truth.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct SightFigures {
    /// Frames judged.
    pub frames: u64,
    /// Frames that could not be judged.
    pub unusable: u64,
    /// Widths measured.
    pub widths: u64,
    /// Mean of measured less true width `[m]`.
    pub width_bias_m: Option<f64>,
    /// Standard deviation of it `[m]`.
    pub width_sigma_m: Option<f64>,
    /// Largest offset that was told `[m]`.
    pub offset_max_m: f64,
    /// Comparisons of seams with the layers below.
    pub seams: u64,
    /// Mean square of their changes in stated standard deviations; about 1 or below on a sound print.
    pub seam_nis: Option<f64>,
    /// Darkest of them in standard deviations; 0 where none was darker than usual.
    pub seam_darkest_sigmas: f64,
    /// Largest drift of their readings, in standard deviations.
    pub seam_drift_sigmas: f64,
}

/// The classifier and the truth that its widths are compared with.
pub struct Sight {
    classifier: Classifier,
    /// Time and width while a road is laid.
    truth: VecDeque<(f64, f64)>,
    count: f64,
    sum_m: f64,
    sum_squares_m2: f64,
    offset_max_m: f64,
    seams: u32,
    seam_squares: f64,
    seam_darkest: f64,
    seam_drift: f64,
}

impl Sight {
    /// A classifier that has seen nothing.
    ///
    /// # Errors
    /// Parameters and network that do not belong together.
    pub fn new(setup: &Setup) -> anyhow::Result<Self> {
        Ok(Self {
            classifier: Classifier::new(setup.params.clone(), setup.models.clone())?,
            truth: VecDeque::new(),
            count: 0.0,
            sum_m: 0.0,
            sum_squares_m2: 0.0,
            offset_max_m: 0.0,
            seams: 0,
            seam_squares: 0.0,
            seam_darkest: 0.0,
            seam_drift: 0.0,
        })
    }

    /// A move begins, `path_s` along the slicer's plan.
    pub fn on_motion(&mut self, (start, path_s): (Seconds, f64), segment: &Segment) -> Vec<Output> {
        self.classifier.on_event(Event::Motion { start, path_s, segment: Box::new(*segment) })
    }

    /// State of printer and job.
    pub fn on_status(&mut self, status: &PrinterStatus) -> Vec<Output> {
        self.classifier.on_event(Event::Printer(Box::new(*status)))
    }

    /// The estimator's newest word.
    pub fn on_estimate(&mut self, estimate: &Estimate) -> Vec<Output> {
        let sum =
            |window: &Option<_>| window.as_ref().map_or(0.0, |window: &state_estimator::Window| window.chi2);
        self.classifier.on_event(Event::Estimate(defect_classifier::EstimateReading {
            stamp: estimate.stamp,
            nozzle: Kelvin(estimate.x[state::NOZZLE]),
            chi_square: estimate.window.iter().map(sum).collect(),
            window: u32::try_from(state_estimator::WINDOW).unwrap_or(u32::MAX),
        }))
    }

    /// Keeps the truth that a width will be compared with.
    pub fn note_truth(&mut self, truth: &Truth) {
        if truth.depositing {
            self.truth.push_back((truth.stamp_s, truth.width_m));
        }
        while self.truth.front().is_some_and(|(stamp_s, _)| truth.stamp_s - stamp_s > TRUTH_KEPT_S) {
            self.truth.pop_front();
        }
    }

    /// A frame, and what the classifier says of it.
    pub fn on_frame(&mut self, exposed: Seconds, jpeg: Vec<u8>) -> Vec<Output> {
        self.classifier.on_event(Event::Frame { exposed, jpeg })
    }

    /// Names of the classes.
    pub fn classes(&self) -> &[String] {
        self.classifier.classes()
    }

    /// What the other brains get of it.
    pub fn seen(&mut self, output: Output) -> Option<Seen> {
        match output {
            Output::Width(found) => {
                self.compare(found.laid, found.width_m);
                let (width_m, sigma_m) = (found.width_m, found.sigma_m);
                Some(Seen::Width { laid: found.laid, width_m, sigma_m })
            }
            Output::Defects(defects) => {
                let blind = VisionReport {
                    usable: false,
                    confidence: 0.0,
                    defect: None,
                    confirmed: false,
                    told: false,
                    offset_m: None,
                };
                Some(Seen::Report(match &defects.judged {
                    Err(_) => blind,
                    Ok(judged) => {
                        let offset_m = judged.offset.map(|offset| offset.offset_m);
                        if let Some(seams) = judged.seams {
                            let sigmas = seams.shade / seams.sigma;
                            self.seams += 1;
                            self.seam_squares += sigmas * sigmas;
                            self.seam_darkest = self.seam_darkest.min(sigmas);
                            self.seam_drift = self.seam_drift.max(seams.drift_sigmas);
                        }
                        let apart_m = offset_m.map_or(0.0, |[x_m, y_m]| x_m.hypot(y_m));
                        self.offset_max_m = self.offset_max_m.max(apart_m);
                        VisionReport {
                            usable: true,
                            confidence: judged.fused.confidence,
                            defect: Defect::from_name(&judged.fused.cause),
                            confirmed: judged.fused.confirmed,
                            told: judged.fused.told,
                            offset_m,
                        }
                    }
                }))
            }
            Output::Quality(_) | Output::Picture { .. } | Output::Note(_) => None,
        }
    }

    fn compare(&mut self, laid: Seconds, width_m: f64) {
        let at = self.truth.partition_point(|(stamp_s, _)| *stamp_s < laid.0);
        let Some((stamp_s, true_m)) = self.truth.get(at) else { return };
        // Beyond a pause or a travel there is no truth of that moment.
        if stamp_s - laid.0 < 0.05 {
            let error_m = width_m - true_m;
            self.count += 1.0;
            self.sum_m += error_m;
            self.sum_squares_m2 += error_m * error_m;
        }
    }

    /// The figures so far.
    #[must_use]
    pub fn figures(&self) -> SightFigures {
        let counts = self.classifier.counts();
        let mean_m = (self.count > 0.0).then(|| self.sum_m / self.count);
        let deviation = |mean_m: f64| (self.sum_squares_m2 / self.count - mean_m * mean_m).max(0.0).sqrt();
        SightFigures {
            frames: counts.judged,
            unusable: counts.unusable,
            widths: counts.widths,
            width_bias_m: mean_m,
            width_sigma_m: mean_m.map(deviation),
            offset_max_m: self.offset_max_m,
            seams: u64::from(self.seams),
            seam_nis: (self.seams > 0).then(|| self.seam_squares / f64::from(self.seams)),
            seam_darkest_sigmas: self.seam_darkest,
            seam_drift_sigmas: self.seam_drift,
        }
    }
}
