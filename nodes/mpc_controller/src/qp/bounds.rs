//! Bounds and rates of a start, and the vectors that say them to the solver.

use super::{Move, Qp, ROWS, STAGE, Start, input};

impl Qp {
    /// Inside bounds and rates, with the ceiling where the rates allow it.
    pub(super) fn clamped(&self, wish: Move, start: &Start) -> Move {
        let (low, high, rate) = (self.limits.low(), self.limits.high(), self.limits.rate());
        std::array::from_fn(|index| {
            let last = if start.last[index].is_finite() { start.last[index] } else { 0.0 };
            let last = last.clamp(low[index], high[index]);
            let high =
                if index == input::FEED { self.feed_high(start.feed_cap, last, 0) } else { high[index] };
            let (least, most) = ((last - rate[index]).max(low[index]), (last + rate[index]).min(high));
            if wish[index].is_finite() { wish[index].max(least).min(most) } else { last.min(most) }
        })
    }

    /// Ceiling of the feed at a step: what the force allows, as soon as the rate lets it be reached.
    fn feed_high(&self, cap: Option<f64>, last: f64, step: u32) -> f64 {
        let reachable = last - self.limits.feed_rate * (f64::from(step) + 1.0);
        let cap = cap.filter(|cap| cap.is_finite()).unwrap_or(self.limits.feed);
        cap.max(reachable).clamp(-self.limits.feed, self.limits.feed)
    }

    /// Whether the ceiling contradicts rate or lower bound and has to give way.
    fn is_ceiling_soft(&mut self, start: &Start, last: f64) -> bool {
        let needed = start.feed_cap.is_some_and(|cap| cap < self.feed_high(start.feed_cap, last, 0));
        self.softened += u64::from(needed && self.soften);
        !needed || self.soften
    }

    /// Writes the vectors; false where one of them is not finite.
    pub(super) fn fill(&mut self, start: &Start) -> bool {
        let width = 2.0 * (start.width_ratio / self.cost.width_scale).powi(2) * start.gain;
        for stage in self.linear.chunks_exact_mut(STAGE) {
            stage.copy_from_slice(&[0.0, -width, 0.0, width, 0.0]);
        }
        let low = self.limits.low();
        let high = self.limits.high();
        let last: Move = std::array::from_fn(|index| start.last[index].clamp(low[index], high[index]));
        for (index, weight) in self.cost.change_weights().into_iter().enumerate() {
            self.linear[index] -= 2.0 * weight * last[index];
        }
        let n = self.lags.horizon;
        self.bounds[..2 * n].fill(0.0);
        self.bounds[0] = self.lags.keep_flow() * start.flow;
        self.bounds[1] = self.lags.keep_temperature() * start.temperature_k;
        let rate = self.limits.rate();
        let soft = self.is_ceiling_soft(start, last[input::FEED]);
        for (step, rows_at) in (0_u32..).zip((2 * n..self.bounds.len()).step_by(ROWS)) {
            for index in 0..input::COUNT {
                let most = match start.feed_cap.filter(|_| index == input::FEED) {
                    Some(cap) if !soft => cap,
                    Some(cap) => self.feed_high(Some(cap), last[index], step),
                    None => high[index],
                };
                let from = if step == 0 { last[index] } else { 0.0 };
                let at = rows_at + 4 * index;
                self.bounds[at..at + 4].copy_from_slice(&[
                    most,
                    -low[index],
                    rate[index] + from,
                    rate[index] - from,
                ]);
            }
        }
        self.linear.iter().chain(&self.bounds).all(|value| value.is_finite())
    }
}
