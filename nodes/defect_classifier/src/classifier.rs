//! The classifier: frames, moves, statuses and estimates in; defects, widths, layer quality and pictures out.
//!
//! Frames count while a job prints. In any other phase nothing is said of them: the head is parked, the bed is being
//! cleared, a person's hand is in the picture.

mod judge;
mod notes;
#[cfg(test)]
pub(crate) mod tests;

use crate::annotate;
use crate::event::{Defects, EstimateReading, Event, Judged, Output};
use crate::frame::{FrameGate, Unusable};
use crate::fusion::{Fusion, FusionError};
use crate::layer::{LayerQuality, Nominal, SeenWidth};
use crate::network::Network;
use crate::offset::{Offset, OffsetFinder};
use crate::params::Params;
use crate::path::PathHistory;
use crate::pressure::NominalFlow;
use crate::seam::{SeamGauge, SeamReading};
use crate::surroundings::in_view;
use crate::unexplained::Surface;
use crate::usual::Usual;
use crate::width::{EdgeModel, Seen, WidthGauge, WidthMeasurement};
use models::motion::Segment;
use models::status::{JobPhase, PrinterStatus};
use models::units::Seconds;
use opencv::core::Mat;

/// What a classifier is made with beside its parameters.
#[derive(Debug, Clone)]
pub struct Models {
    /// Network over the features of a frame.
    pub network: Network,
    /// Network that finds the edge of a road.
    pub edge: EdgeModel,
    /// Quality functional, nominal printer and material.
    pub nominal: Nominal,
}

/// What was refused or could not be judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Frames judged.
    pub judged: u64,
    /// Frames that could not be judged while the job printed.
    pub unusable: u64,
    /// Frames outside of printing: not looked at.
    pub idle: u64,
    /// Estimates with an impossible statistic.
    pub estimates_refused: u64,
    /// Statuses and moves out of order.
    pub path_refused: u64,
    /// Widths told.
    pub widths: u64,
}

/// Knows no clock and no middleware.
#[derive(Debug)]
pub struct Classifier {
    params: Params,
    network: Network,
    gate: FrameGate,
    path: PathHistory,
    gauge: WidthGauge,
    seams: SeamGauge,
    nozzle: NominalFlow,
    usual: Usual,
    finder: OffsetFinder,
    surface: Surface,
    fusion: Fusion,
    quality: LayerQuality,
    status: Option<PrinterStatus>,
    exposed: Option<Seconds>,
    unusable: Option<String>,
    confirmed: Option<String>,
    /// What was laid before is not known: this print was under way when the first status came.
    joined_late: bool,
    counts: Counts,
}

impl Classifier {
    /// A classifier that has seen nothing.
    ///
    /// # Errors
    /// [`FusionError`] for a rule of a class that the network does not have.
    pub fn new(params: Params, models: Models) -> Result<Self, FusionError> {
        Ok(Self {
            gate: FrameGate::new(params.checks, &params.camera),
            path: PathHistory::new(params.history),
            gauge: WidthGauge::new(params.width, models.edge),
            seams: SeamGauge::new(params.seam, &params.width),
            nozzle: NominalFlow::new(params.pressure, models.nominal.clone(), params.layer.ambient()),
            usual: Usual::new(params.usual),
            finder: OffsetFinder::new(params.offset, &params.camera),
            surface: Surface::new(params.unexplained),
            fusion: Fusion::new(
                params.fusion.clone().with_machine_error(params.machine.error_m.unwrap_or(0.0)),
                models.network.classes(),
            )?,
            quality: LayerQuality::new(params.layer, models.nominal),
            network: models.network,
            params,
            status: None,
            exposed: None,
            unusable: None,
            confirmed: None,
            joined_late: false,
            counts: Counts::default(),
        })
    }

    /// Other bounds of what can be judged from now on; what was seen stays.
    pub fn retune(&mut self, params: Params) {
        self.gate.retune(params.checks);
        self.params = params;
    }

    /// Names of the classes, in the order of the probabilities.
    #[must_use]
    pub fn classes(&self) -> &[String] {
        self.network.classes()
    }

    /// What was refused so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        Counts { path_refused: self.path.refused() + self.surface.refused(), ..self.counts }
    }

    /// Takes one event in.
    pub fn on_event(&mut self, event: Event) -> Vec<Output> {
        match event {
            Event::Frame { exposed, jpeg } => self.on_frame(exposed, &jpeg),
            Event::Motion { start, path_s, segment } => {
                self.nozzle.on_move(path_s, &segment);
                self.on_motion(start, &segment);
                Vec::new()
            }
            Event::Printer(status) => self.on_status(&status),
            Event::Estimate(estimate) => {
                self.on_estimate(&estimate);
                Vec::new()
            }
        }
    }

    fn on_motion(&mut self, start: Seconds, segment: &Segment) {
        self.path.on_move(start, segment);
        self.surface.on_move(segment);
    }

    fn on_status(&mut self, status: &PrinterStatus) -> Vec<Output> {
        self.path.on_status(status.stamp, status.path_time_s, status.position_m);
        self.nozzle.on_status(status);
        let before = self.status.replace(*status);
        let printing = status.phase == JobPhase::Printing;
        let mut outputs = Vec::new();
        if before.is_none() && notes::under_way(status) {
            self.joined_late = true;
            outputs.push(Output::Note(notes::joined_late(status)));
        }
        if printing && before.is_none_or(|before| before.phase != JobPhase::Printing) {
            // After a start or a resume the past says nothing of now.
            self.fusion.reset(status.stamp);
            self.finder.forget();
            self.seams.forget_drift();
            self.usual.forget_drift();
            if before.is_none_or(|before| before.phase != JobPhase::Paused) {
                self.surface.clear();
                self.seams.clear();
                self.joined_late &= before.is_none();
                self.usual = Usual::new(self.params.usual);
            }
        }
        if printing {
            outputs.extend(self.quality.on_layer(status.stamp, status.layer).map(Output::Quality));
        }
        outputs
    }

    fn on_estimate(&mut self, estimate: &EstimateReading) {
        if !self.fusion.on_estimate(estimate.stamp, &estimate.chi_square, estimate.window) {
            self.counts.estimates_refused += 1;
        }
        if let Some(status) = self.status.filter(|status| status.depositing) {
            self.quality.on_nozzle(estimate.nozzle, &status);
        }
    }

    fn on_frame(&mut self, exposed: Seconds, jpeg: &[u8]) -> Vec<Output> {
        if self.status.is_none_or(|status| status.phase != JobPhase::Printing) {
            self.counts.idle += 1;
            return Vec::new();
        }
        let mut outputs = Vec::new();
        let judged = self.open(exposed, jpeg).and_then(|(grey, tool_m)| {
            let found = self.measure(&grey, exposed, tool_m)?;
            outputs.extend(found.width.map(Output::Width));
            let judged = self.judge(&grey, exposed, &found)?;
            self.picture(&grey, (exposed, tool_m), (&found, &judged), &mut outputs)?;
            Ok(judged)
        });
        match &judged {
            Ok(judged) => {
                self.counts.judged += 1;
                self.quality.on_frame(judged.offset.map(|offset| offset.offset_m));
            }
            Err(_) => self.counts.unusable += 1,
        }
        outputs.extend(self.notes(exposed, &judged).map(Output::Note));
        outputs.push(Output::Defects(Box::new(Defects { exposed, frame: self.frames(), judged })));
        outputs
    }

    fn frames(&self) -> u64 {
        self.counts.judged + self.counts.unusable
    }

    /// The picture and where the tool was, or why the frame cannot be judged.
    fn open(&mut self, exposed: Seconds, jpeg: &[u8]) -> Result<(Mat, [f64; 2]), Unusable> {
        let grey = self.gate.open(jpeg)?;
        if !exposed.0.is_finite() || self.exposed.is_some_and(|before| exposed.0 <= before.0) {
            return Err(Unusable::Order);
        }
        self.exposed = Some(exposed);
        let (tool_m, _) = self.path.tool(exposed).ok_or(Unusable::NoPlace)?;
        Ok((grey, tool_m))
    }

    fn measure(&mut self, grey: &Mat, exposed: Seconds, tool_m: [f64; 2]) -> Result<Found, Unusable> {
        let view = (&self.params.camera, tool_m);
        let (width, seen) = self.gauge.on_frame(grey, (&self.path, exposed), view)?;
        let seams = self.seams.on_frame(grey, (&self.path, exposed), view, |laid| {
            self.nozzle.share(laid, self.path.path_s(laid))
        })?;
        let offset = self.finder.on_frame(grey, (&self.path, exposed), view)?;
        if let Some(width) = width {
            self.counts.widths += 1;
            self.quality.on_width(&SeenWidth {
                width_m: width.width_m,
                sigma_m: width.sigma_m,
                wanted_m: width.wanted_m,
                height_m: width.height_m,
            });
        }
        let unexplained = self.surface.find(grey, view)?;
        // Who does not know the whole part would take the rest of it for shifted or loose.
        let known = !self.joined_late;
        Ok(Found {
            width,
            seen,
            seams,
            offset: offset.filter(|_| known),
            unexplained: known.then_some(unexplained),
        })
    }

    fn picture(
        &self,
        grey: &Mat,
        (exposed, tool_m): (Seconds, [f64; 2]),
        (found, judged): (&Found, &Judged),
        outputs: &mut Vec<Output>,
    ) -> Result<(), Unusable> {
        if !self.params.picture.wants(self.frames() + 1) {
            return Ok(());
        }
        let view = (&self.params.camera, tool_m);
        let roads = in_view(&self.path, exposed, view);
        let lines = judge::captions(exposed, found, judged);
        let overlay = annotate::Overlay {
            roads: &roads,
            view,
            edges: &found.seen.edges,
            region_px: judged.region_px,
            lines: &lines,
        };
        let jpeg = annotate::draw(grey, &overlay, &self.params.picture)?;
        outputs.push(Output::Picture { exposed, jpeg });
        Ok(())
    }
}

/// What was measured in a frame.
struct Found {
    width: Option<WidthMeasurement>,
    seen: Seen,
    /// Shade of the seams beside what is usual there.
    seams: Option<SeamReading>,
    offset: Option<Offset>,
    /// Share of the strong edges that no road explains; `None` where the roads are not all known.
    unexplained: Option<f64>,
}
