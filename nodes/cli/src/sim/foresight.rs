//! The advance predictor between the simulated printer and the controller: it gets moves as they begin and set-points,
//! as over DDS, and nothing else.

use super::corners::Corners;
use super::report::AdvanceFigures;
use crate::config::Foresight as Setup;
use advance_predictor::compensation::Source;
use advance_predictor::{AdvancePredictor, Event, Output};
use models::motion::Segment;
use models::status::PrinterStatus;
use models::units::Seconds;
use mpc_controller::advance::{AdvanceReport, Basis, Foretold, Prediction, Turn};

/// The predictor, where it is asked, and what became of the pressure advance.
pub struct Foresight {
    predictor: Option<AdvancePredictor>,
    /// Sum and count of the advance in force over deposits.
    sum_s: (f64, f64),
    /// Width error near changes of speed.
    pub corners: Corners,
}

impl Foresight {
    /// Nothing seen yet.
    #[must_use]
    pub fn new(setup: Option<&Setup>) -> Self {
        let predictor = setup.map(|setup| {
            let (params, compensation) = (setup.params.clone(), setup.compensation.clone());
            AdvancePredictor::new(params, compensation, setup.network.clone())
        });
        Self { predictor, sum_s: (0.0, 0.0), corners: Corners::default() }
    }

    /// A move begins.
    pub fn on_motion(&mut self, segment: &Segment) -> Option<Output> {
        self.predictor.as_mut()?.on_event(Event::Move(*segment))
    }

    /// The set-point in force.
    pub fn on_status(&mut self, status: &PrinterStatus) -> Option<Output> {
        if status.depositing {
            self.sum_s.0 += status.advance_s;
            self.sum_s.1 += 1.0;
        }
        self.predictor.as_mut()?.on_event(Event::Target(status.stamp, status.hotend_target))
    }

    /// What became of the pressure advance.
    #[must_use]
    pub fn figures(&self, report: &AdvanceReport) -> AdvanceFigures {
        let (sum_s, count) = self.sum_s;
        let counts = self.predictor.as_ref().map(AdvancePredictor::counts);
        AdvanceFigures {
            mean_s: (count > 0.0).then(|| sum_s / count),
            hurried: report.hurried,
            without: report.without,
            learnt: report.learnt,
            outside_hull: counts.map(|counts| counts.outside_hull),
            unanswered: counts.map(|counts| counts.unanswered),
        }
    }
}

/// What the controller's shell makes of the message.
pub(super) fn told(stamp: Seconds, output: &Output) -> Prediction {
    let advance = output.advance.map(|advance| Foretold {
        advance_s: advance.advance().0,
        half_width_s: advance.half_width().0,
        law: advance.law,
        basis: match advance.prediction.source {
            Source::Network => Basis::Network,
            Source::Physics => Basis::Physics,
        },
    });
    let turn = output.turn.map(|turn| Turn {
        probability: turn.probability,
        expected: output.expected,
        lead: turn.lead,
    });
    Prediction { stamp, advance, turn }
}
