//! How well turns are foreseen, against the buffer alone and against extrapolated curvature.

use super::file::TurnNetwork;
use super::params::TurnParams;
use super::path::Piece;
use super::samples::Track;
use super::training::Path;
use serde::Serialize;

/// Figures of one path with one buffer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figures {
    /// Moves that the buffer holds behind the current one.
    pub buffered: u32,
    /// Moments looked at.
    pub moments: usize,
    /// Moments at which the buffer ends before the horizon without a turn.
    pub starved: usize,
    /// Over all moments.
    pub all: Methods,
    /// Over the starved ones, where the buffer alone says nothing.
    pub when_starved: Methods,
    /// Turns behind as many short pieces as the buffer holds, shorter together than the horizon, with no other turn
    /// within the horizon before them: an earlier one would be what is foreseen.
    pub short_turns: usize,
    /// Median lead of the predictor at those turns.
    pub lead_median_s: f64,
    /// Median lead of the buffer alone at those turns.
    pub buffer_lead_median_s: f64,
}

/// The predictor and its baselines.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Methods {
    /// Buffer, memory and network.
    pub predictor: Score,
    /// A turn where the buffer shows one.
    pub buffer_only: Score,
    /// Buffer, and the last turns carried on in a line.
    pub curvature_line: Score,
    /// Buffer, and the mean curvature carried on.
    pub curvature_mean: Score,
}

/// Counts and what follows from them.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Score {
    /// Turns foreseen.
    pub hits: usize,
    /// Turns foreseen that did not come.
    pub false_alarms: usize,
    /// Turns that came unforeseen.
    pub missed: usize,
    /// Share of the turns that were foreseen.
    pub recall: f64,
    /// Share of the foreseen that came.
    pub precision: f64,
    /// Harmonic mean of both.
    pub f1: f64,
}

impl Score {
    fn add(&mut self, alarm: bool, turns: bool) {
        match (alarm, turns) {
            (true, true) => self.hits += 1,
            (true, false) => self.false_alarms += 1,
            (false, true) => self.missed += 1,
            (false, false) => {}
        }
    }

    #[expect(clippy::cast_precision_loss, reason = "counts")]
    fn finished(mut self) -> Self {
        let share = |part: usize, whole: usize| if whole > 0 { part as f64 / whole as f64 } else { 0.0 };
        self.recall = share(self.hits, self.hits + self.missed);
        self.precision = share(self.hits, self.hits + self.false_alarms);
        self.f1 = share(2 * self.hits, 2 * self.hits + self.missed + self.false_alarms);
        self
    }

    /// Adds another path's counts.
    #[must_use]
    pub fn with(self, other: &Self) -> Self {
        Self {
            hits: self.hits + other.hits,
            false_alarms: self.false_alarms + other.false_alarms,
            missed: self.missed + other.missed,
            ..self
        }
        .finished()
    }
}

impl Methods {
    fn add(&mut self, alarms: [bool; 4], turns: bool) {
        self.predictor.add(alarms[0], turns);
        self.buffer_only.add(alarms[1], turns);
        self.curvature_line.add(alarms[2], turns);
        self.curvature_mean.add(alarms[3], turns);
    }

    fn finished(self) -> Self {
        Self {
            predictor: self.predictor.finished(),
            buffer_only: self.buffer_only.finished(),
            curvature_line: self.curvature_line.finished(),
            curvature_mean: self.curvature_mean.finished(),
        }
    }
}

/// Since when an alarm stands.
#[derive(Debug, Clone, Copy, Default)]
struct Standing(Option<f64>);

impl Standing {
    fn see(&mut self, alarm: bool, time_s: f64) {
        self.0 = if alarm { self.0.or(Some(time_s)) } else { None };
    }

    /// Lead at a turn; what stands after it belongs to the next one.
    fn lead_s(&mut self, turn_s: f64) -> f64 {
        self.0.take().map_or(0.0, |since_s| turn_s - since_s)
    }
}

/// Judges a network on a path.
#[must_use]
pub fn assess(network: &TurnNetwork, path: &Path, params: &TurnParams) -> Figures {
    let Path { buffered, pieces } = path;
    let buffered = *buffered;
    let track = Track::new(pieces, params);
    let turns: Vec<usize> = track.turns().collect();
    let (mut all, mut when_starved) = (Methods::default(), Methods::default());
    let (mut moments, mut starved) = (0, 0);
    let mut standing = [Standing::default(); 2];
    let mut leads: [Vec<f64>; 2] = [vec![], vec![]];
    let mut coming = turns.iter().copied().peekable();
    track.run(buffered as usize, params, |watcher, moment| {
        while let Some(turn) = coming.next_if(|turn| *turn < moment.piece) {
            let turn_s = track.starts_s[turn] + pieces[turn].duration_s;
            let short = is_short(pieces, turn, buffered as usize, params);
            for (standing, leads) in standing.iter_mut().zip(&mut leads) {
                let lead_s = standing.lead_s(turn_s);
                if short {
                    leads.push(lead_s);
                }
            }
        }
        let shown = watcher.by_buffer(moment.gone_m);
        let by_buffer = shown.is_some_and(|shown| shown.probability > 0.5);
        let foreseen = watcher.foresee(network, moment.gone_m);
        let by_network = foreseen.is_some_and(|foreseen| foreseen.probability >= network.threshold());
        let [line, mean] = if shown.is_some() { [by_buffer; 2] } else { watcher.extrapolated(moment.gone_m) };
        let alarms = [if shown.is_some() { by_buffer } else { by_network }, by_buffer, line, mean];
        moments += 1;
        all.add(alarms, moment.turns);
        if shown.is_none() {
            starved += 1;
            when_starved.add(alarms, moment.turns);
        }
        standing[0].see(alarms[0], moment.time_s);
        standing[1].see(alarms[1], moment.time_s);
    });
    Figures {
        buffered,
        moments,
        starved,
        all: all.finished(),
        when_starved: when_starved.finished(),
        short_turns: leads[0].len(),
        lead_median_s: median(&mut leads[0]),
        buffer_lead_median_s: median(&mut leads[1]),
    }
}

/// Moments of a path, and those that are starved: the buffer ends before the horizon and shows no turn.
#[must_use]
pub fn starved(path: &Path, params: &TurnParams) -> (usize, usize) {
    let (mut moments, mut starved) = (0, 0);
    Track::new(&path.pieces, params).run(path.buffered as usize, params, |watcher, moment| {
        moments += 1;
        starved += usize::from(watcher.by_buffer(moment.gone_m).is_none());
    });
    (moments, starved)
}

/// Whether the buffer that shows a turn at last is shorter than the horizon.
fn is_short(pieces: &[Piece], turn: usize, buffered: usize, params: &TurnParams) -> bool {
    let first = turn.saturating_sub(buffered.saturating_sub(1));
    let short = pieces[first..=turn].iter().map(|piece| piece.length_m).sum::<f64>() < params.horizon_m;
    let mut way_m = 0.0;
    for place in (1..=turn).rev() {
        way_m += pieces[place].length_m;
        if way_m > params.horizon_m {
            break;
        }
        if pieces[place - 1].turn_into(&pieces[place]).abs() > params.threshold_rad {
            return false;
        }
    }
    short
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}
