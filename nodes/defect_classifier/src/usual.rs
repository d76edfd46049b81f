//! What widths this printer, spool and camera usually lay and see: a bead gain a few percent off is no defect and hides
//! none, and neither is an edge that the camera finds a little beside where it is.
//!
//! A printer that lays 7 % too much and then loses a fifth of its melt is 14 % short of what the file wanted, and 20 %
//! short of itself. Edges that face alike err alike: beside what is usual for those an error counts whole; beside what
//! is usual for the print, and beside what the file wanted, it counts less what looks err by. The largest of the three
//! is told. What is usual is learned from widths that are no defect, slowly, within a bound: a defect from the first road
//! on stays one by what the file wanted.
//!
//! One width may err; what errors exceed a slack by is added up, `S = max(0, S + e - k)` either way (E. S. Page,
//! Biometrika 41, 1954).

use crate::width::Facing;
use models::params::{ParamError, in_range, ordered};
use models::units::Seconds;
use serde::Deserialize;
use std::collections::BTreeMap;

/// How the usual width is learned. Built only from a valid [`RawUsual`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawUsual")]
pub struct UsualParams(RawUsual);

/// The `usual` block as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawUsual {
    /// Widths with edges that face alike until what is usual for them counts.
    pub widths_min: u32,
    /// Share of a new width in the usual one `[-]`.
    pub rate: f64,
    /// Farthest that a usual width may lie from the wanted one, relative `[-]`.
    pub range_rel: f64,
    /// Widths farther from what is wanted or usual are not learned, nor any after a larger drift `[-]`.
    pub learn_max_rel: f64,
    /// What looks and the bead gain err by, relative: taken off an error beside the file's width `[-]`.
    pub file_rel: f64,
    /// What looks err by, relative: taken off an error beside what is usual for the print `[-]`.
    pub print_rel: f64,
    /// A larger error counts for no more in the drift: one width alone convicts of nothing `[-]`.
    pub error_max_rel: f64,
    /// Error that adds nothing to the drift `[-]`.
    pub drift_slack_rel: f64,
    /// Largest drift: how fast sound widths take it back `[-]`.
    pub drift_max_rel: f64,
    /// From the first width of a print and after a resume, widths add nothing to the drift for so long: the pressure in
    /// the nozzle builds up, and sound roads are thin `[s]`.
    pub build_up_s: f64,
}

impl TryFrom<RawUsual> for UsualParams {
    type Error = ParamError;

    fn try_from(raw: RawUsual) -> Result<Self, ParamError> {
        in_range("usual.widths_min", f64::from(raw.widths_min), "widths", (1.0, 1e4))?;
        in_range("usual.rate", raw.rate, "-", (0.0, 1.0))?;
        in_range("usual.range_rel", raw.range_rel, "-", (0.0, 0.3))?;
        in_range("usual.learn_max_rel", raw.learn_max_rel, "-", (0.0, 0.5))?;
        in_range("usual.file_rel", raw.file_rel, "-", (0.0, 0.3))?;
        in_range("usual.print_rel", raw.print_rel, "-", (0.0, 0.3))?;
        in_range("usual.error_max_rel", raw.error_max_rel, "-", (0.01, 1.0))?;
        in_range("usual.drift_slack_rel", raw.drift_slack_rel, "-", (0.001, 0.5))?;
        in_range("usual.drift_max_rel", raw.drift_max_rel, "-", (0.01, 10.0))?;
        in_range("usual.build_up_s", raw.build_up_s, "s", (0.0, 60.0))?;
        let slack = ("usual.drift_slack_rel", raw.drift_slack_rel);
        ordered(slack, ("usual.error_max_rel", raw.error_max_rel))?;
        ordered(slack, ("usual.drift_max_rel", raw.drift_max_rel))?;
        Ok(Self(raw))
    }
}

/// What a width says beside what is usual.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WidthError {
    /// Error of this width, relative `[-]`.
    pub error_rel: f64,
    /// What this and the widths before it together exceed the slack by `[-]`: above 0 too much, below 0 too little.
    pub drift_rel: f64,
}

/// Mean of the first widths, slower and slower until the rate.
#[derive(Debug, Clone, Copy)]
struct Learned {
    ratio: f64,
    widths: u32,
}

impl Learned {
    fn learn(&mut self, ratio: f64, params: &RawUsual) {
        self.widths = self.widths.saturating_add(1);
        let share = params.rate.max(1.0 / f64::from(self.widths));
        let learned = self.ratio + share * (ratio - self.ratio);
        self.ratio = learned.clamp(1.0 - params.range_rel, 1.0 + params.range_rel);
    }
}

/// The usual width over the wanted one, without the loop's own corrections.
#[derive(Debug, Clone)]
pub struct Usual {
    params: RawUsual,
    facings: BTreeMap<Facing, Learned>,
    /// Sums of what exceeded the slack: too little, too much.
    drifts_rel: [f64; 2],
    /// When the first width since then was laid.
    first: Option<Seconds>,
}

impl Usual {
    /// Nothing learned: the file's own width is the usual one.
    #[must_use]
    pub fn new(params: UsualParams) -> Self {
        Self { params: params.0, facings: BTreeMap::new(), drifts_rel: [0.0; 2], first: None }
    }

    /// Forgets what errors add up to: after a pause the flow may be another.
    pub fn forget_drift(&mut self) {
        (self.drifts_rel, self.first) = ([0.0; 2], None);
    }

    /// What a width says; `ratio` is the width over the wanted one, without the loop's corrections.
    pub fn on_width(&mut self, laid: Seconds, ratio: f64, facing: Facing) -> WidthError {
        let error_rel = self.error_rel(ratio, facing);
        if !error_rel.is_finite() {
            return WidthError { error_rel, drift_rel: error_rel };
        }
        if laid.0 < self.first.get_or_insert(laid).0 + self.params.build_up_s {
            return WidthError { error_rel, drift_rel: 0.0 };
        }
        let counts_rel = error_rel.clamp(-self.params.error_max_rel, self.params.error_max_rel);
        for (drift_rel, sign) in self.drifts_rel.iter_mut().zip([-1.0, 1.0]) {
            let more = *drift_rel + sign * counts_rel - self.params.drift_slack_rel;
            *drift_rel = more.clamp(0.0, self.params.drift_max_rel);
        }
        let [little, much] = self.drifts_rel;
        WidthError { error_rel, drift_rel: if little > much { -little } else { much } }
    }

    /// The largest of the three errors.
    fn error_rel(&mut self, ratio: f64, facing: Facing) -> f64 {
        let params = self.params;
        let calm = self.drifts_rel.iter().all(|drift_rel| *drift_rel <= params.learn_max_rel);
        let of_file = beyond(ratio - 1.0, params.file_rel);
        let of_print = beyond(ratio / self.of_print() - 1.0, params.print_rel);
        let alike = self.facings.entry(facing).or_insert(Learned { ratio: 1.0, widths: 0 });
        let known = alike.widths >= params.widths_min;
        let of_alike = if known { ratio / alike.ratio - 1.0 } else { 0.0 };
        let error_rel = larger(larger(of_file, of_print), of_alike);
        if calm && error_rel.abs() <= params.learn_max_rel {
            alike.learn(ratio, &params);
        }
        error_rel
    }

    /// Mean over the ways that edges face, the file's own width among them.
    fn of_print(&self) -> f64 {
        let known = self.facings.values().filter(|learned| learned.widths >= self.params.widths_min);
        let (sum, count) = known.fold((1.0, 1.0), |(sum, count), learned| (sum + learned.ratio, count + 1.0));
        sum / count
    }
}

/// What of an error lies beyond `usual_rel` either way.
fn beyond(error_rel: f64, usual_rel: f64) -> f64 {
    error_rel - error_rel.clamp(-usual_rel, usual_rel)
}

fn larger(a: f64, b: f64) -> f64 {
    if a.abs() > b.abs() { a } else { b }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn params() -> UsualParams {
        raw().try_into().unwrap()
    }

    fn raw() -> RawUsual {
        RawUsual {
            widths_min: 6,
            rate: 0.02,
            range_rel: 0.15,
            learn_max_rel: 0.1,
            file_rel: 0.1,
            print_rel: 0.06,
            error_max_rel: 0.2,
            drift_slack_rel: 0.06,
            drift_max_rel: 0.3,
            build_up_s: 4.0,
        }
    }

    fn after(ratios: impl IntoIterator<Item = f64>) -> Usual {
        let mut usual = Usual::new(params());
        // The first of them opens the time in which pressure builds up, the others come after it.
        for (number, ratio) in ratios.into_iter().enumerate() {
            usual.on_width(Seconds(if number == 0 { 0.0 } else { 4.0 }), ratio, here());
        }
        usual
    }

    fn here() -> Facing {
        Facing::numbered(0)
    }

    /// 1.07 * 0.8 is 0.856: 14 % short of the file, a fifth short of itself.
    #[test]
    fn a_fifth_is_a_fifth_on_a_printer_that_lays_too_much() {
        let error_rel = after([1.07; 40]).on_width(Seconds(4.0), 0.856, here()).error_rel;
        assert!((error_rel + 0.2).abs() < 1e-9, "{error_rel}");
    }

    /// Against the file an error counts less what looks err by.
    #[test]
    fn an_edge_that_faces_as_none_before_may_err() {
        let mut usual = after([1.0; 40]);
        let there = Facing::numbered(3);
        let errors: Vec<f64> = (0..20).map(|_| usual.on_width(Seconds(4.0), 0.87, there).error_rel).collect();
        assert!(errors[..6].iter().all(|error_rel| (error_rel + 0.07).abs() < 1e-9), "{errors:?}");
        // What is usual for it has become known; a fifth of it is one.
        let error_rel = usual.on_width(Seconds(4.0), 0.8 * 0.87, there).error_rel;
        assert!((-0.22..-0.2 + 1e-9).contains(&error_rel), "{error_rel}");
        assert!((after([1.0; 40]).on_width(Seconds(4.0), 0.8, there).error_rel + 0.14).abs() < 1e-9);
    }

    #[test]
    fn a_defect_does_not_become_usual() {
        let mut usual = after([1.0; 40]);
        for _ in 0..1000 {
            assert!((usual.on_width(Seconds(4.0), 0.82, here()).error_rel + 0.18).abs() < 1e-9);
        }
        let from_the_first = after([0.8; 1000]).on_width(Seconds(4.0), 0.8, here()).error_rel;
        assert!((from_the_first + 0.14).abs() < 1e-9, "{from_the_first}");
    }

    #[test]
    fn what_creeps_stays_a_defect_by_the_file() {
        let creeping = (0..4000).map(|width| 1.0 - 5e-5 * f64::from(width));
        let last = after(creeping).on_width(Seconds(4.0), 0.8, here());
        assert!(last.error_rel < -0.099 && last.drift_rel < -0.299, "{last:?}");
    }

    /// Each of them alone is nothing, and after a pause all of them are.
    #[test]
    fn what_one_width_hides_many_tell() {
        let mut usual = after([1.0; 40]);
        let drifts: Vec<f64> = (0..8).map(|_| usual.on_width(Seconds(4.0), 0.91, here()).drift_rel).collect();
        assert!((drifts[0] + 0.03).abs() < 1e-9 && drifts[7] < -0.19 && drifts[7] > -0.241, "{drifts:?}");
        usual.forget_drift();
        for laid_s in [20.0, 22.0, 23.9] {
            assert!(
                usual.on_width(Seconds(laid_s), 0.7, here()).drift_rel.abs() < 1e-9,
                "it builds up: {laid_s}"
            );
        }
        let wild = usual.on_width(Seconds(24.0), 0.3, here()).drift_rel;
        assert!((wild + 0.14).abs() < 1e-9, "one convicts of nothing: {wild}");
        let much = (0..20).map(|_| usual.on_width(Seconds(25.0), 1.2, here()).drift_rel).last().unwrap();
        assert!((much - 0.3).abs() < 1e-9, "bounded: {much}");
    }

    #[test]
    fn too_much_and_too_little_by_turns_is_no_drift() {
        let mut usual = after([1.0; 40]);
        for width in 0..100 {
            let error = if width % 2 == 0 { 0.09 } else { -0.09 };
            assert!(usual.on_width(Seconds(4.0), 1.0 + error, here()).drift_rel.abs() < 0.04);
        }
    }

    #[test]
    fn nothing_is_learned_from_a_nan() {
        let mut usual = after([1.05; 40]);
        assert!(usual.on_width(Seconds(4.0), f64::NAN, here()).error_rel.is_nan());
        let after = usual.on_width(Seconds(4.0), 1.05, here());
        assert!(after.error_rel.abs() < 0.051 && after.drift_rel.abs() < 1e-9, "{after:?}");
    }

    #[test]
    fn a_slack_beyond_the_largest_drift_is_refused() {
        let error =
            UsualParams::try_from(RawUsual { drift_slack_rel: 0.4, ..raw() }).unwrap_err().to_string();
        assert!(error.contains("usual.drift_slack_rel"), "{error}");
    }
}
