//! A file as a job: measured first, so that "half of the filament" has a meaning, then planned lazily.

use crate::simulator::JobSource;
use models::gcode::Header;
use models::motion::{Action, Job, MotionParams, MoveKind, Step};
use models::units::Celsius;
use std::io::Cursor;
use std::sync::Arc;

/// What is asked of a file.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wishes {
    /// Print only the first layers.
    pub layers: Option<u32>,
    /// Another material than the file's: its set-points replace the file's.
    pub set_points: Option<SetPoints>,
}

/// Set-points of a material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SetPoints {
    /// Hot end block.
    pub hotend: Celsius,
    /// Bed.
    pub bed: Celsius,
    /// Factor on the part fan `[-]`.
    pub fan: f64,
}

/// First set-points of a job: what a warm printer already has.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Preheat {
    /// Hot end block.
    pub hotend: Option<Celsius>,
    /// Bed.
    pub bed: Option<Celsius>,
}

impl Preheat {
    fn note(&mut self, step: &Step) {
        match step {
            Step::Action(Action::HotendTarget { target, .. }, _) if target.0 > 0.0 => {
                self.hotend.get_or_insert(*target);
            }
            Step::Action(Action::BedTarget { target, .. }, _) if target.0 > 0.0 => {
                self.bed.get_or_insert(*target);
            }
            _ => {}
        }
    }
}

impl JobSource {
    /// A job over a file in memory.
    #[must_use]
    pub fn from_gcode(bytes: &Arc<[u8]>, header: &Header, motion: &MotionParams, wishes: Wishes) -> Self {
        let steps = || Job::new(Cursor::new(Arc::clone(bytes)), header, motion);
        let wished =
            || first_layers(steps(), wishes.layers).map(move |step| with_set_points(step, wishes.set_points));
        let mut preheat = Preheat::default();
        let mut filament_m = 0.0;
        for step in wished() {
            filament_m += pushed_m(&step);
            preheat.note(&step);
        }
        Self { steps: Box::new(wished()), filament_m, preheat }
    }
}

/// The steps up to the layer after the last wanted one.
fn first_layers(
    steps: impl Iterator<Item = Step> + Send + 'static,
    layers: Option<u32>,
) -> impl Iterator<Item = Step> + Send {
    let beyond = move |step: &Step| match (step, layers) {
        (Step::Action(Action::LayerChange { layer, .. }, _), Some(layers)) => *layer >= layers,
        _ => false,
    };
    steps.take_while(move |step| !beyond(step))
}

/// Filament that a step pushes `[m]`; a retraction takes nothing back, since what follows pushes it again.
fn pushed_m(step: &Step) -> f64 {
    match step {
        Step::Move(segment) if segment.kind == MoveKind::Deposit || segment.filament_m > 0.0 => {
            segment.filament_m.max(0.0)
        }
        _ => 0.0,
    }
}

fn with_set_points(step: Step, set_points: Option<SetPoints>) -> Step {
    let Some(wanted) = set_points else { return step };
    match step {
        Step::Action(Action::HotendTarget { target, wait }, line) if target.0 > 0.0 => {
            Step::Action(Action::HotendTarget { target: wanted.hotend, wait }, line)
        }
        Step::Action(Action::BedTarget { target, wait }, line) if target.0 > 0.0 => {
            Step::Action(Action::BedTarget { target: wanted.bed, wait }, line)
        }
        Step::Action(Action::Fan(share), line) => Step::Action(Action::Fan(share * wanted.fan), line),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWO_LAYERS: &[u8] = b";LAYER_CHANGE\n;Z:0.2\nM104 S200\nM83\nG1 X10 E1 F1200\nG1 E-0.8\nG1 E0.8\n\
        ;LAYER_CHANGE\n;Z:0.4\nG1 X20 E2\n";

    fn motion() -> MotionParams {
        crate::simulator::tests::motion()
    }

    fn job(wishes: Wishes) -> JobSource {
        let bytes: Arc<[u8]> = TWO_LAYERS.into();
        JobSource::from_gcode(&bytes, &Header::scan(TWO_LAYERS, TWO_LAYERS), &motion(), wishes)
    }

    #[test]
    fn the_first_layer_alone_ends_before_the_second() {
        assert!((job(Wishes::default()).filament_m - 3.8e-3).abs() < 1e-9);
        let first = job(Wishes { layers: Some(1), set_points: None });
        assert!((first.filament_m - 1.8e-3).abs() < 1e-9, "{}", first.filament_m);
        let lines = first.steps.filter(|step| matches!(step, Step::Move(_))).count();
        assert_eq!(lines, 3);
    }

    #[test]
    fn another_material_brings_its_set_points() {
        let set_points = SetPoints { hotend: Celsius(250.0), bed: Celsius(85.0), fan: 0.5 };
        let mut hot =
            job(Wishes { layers: None, set_points: Some(set_points) }).steps.filter_map(|step| match step {
                Step::Action(Action::HotendTarget { target, .. }, _) => Some(target),
                _ => None,
            });
        assert_eq!(hot.next(), Some(Celsius(250.0)));
    }
}
