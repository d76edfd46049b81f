//! Readings of a thermistor: their noise, and the single ones that are wrong.

use super::record::At;

/// Second differences farther out than so many deviations are no noise `[-]`: of a Gaussian one in two million.
const OUTLYING: f64 = 5.0;
/// Rounds in which those are left out: what a wrong reading adds to the deviation is gone after two or three.
const ROUNDS: u32 = 10;
/// One of so many is left out at most: of readings in coarse steps most differ by nothing, and the steps are their noise.
const OUTLYING_ONE_OF: usize = 100;
/// A reading farther from both neighbours than so many deviations is wrong `[-]`, and by so much `[K]`: a step of a coarse one is not.
const SPIKE: f64 = 8.0;
const SPIKE_LEAST_K: f64 = 1.0;

/// Noise of white readings `[K]`, whatever they follow: second differences have six times its variance.
pub(super) fn noise(readings: &[At]) -> Option<f64> {
    let second = |triple: &[At]| triple[0].1 - 2.0 * triple[1].1 + triple[2].1;
    let mut squares: Vec<f64> = readings.windows(3).map(|triple| second(triple).powi(2)).collect();
    squares.sort_by(f64::total_cmp);
    let least = squares.len() - squares.len() / OUTLYING_ONE_OF;
    for _ in 0..ROUNDS {
        let most = OUTLYING.powi(2) * mean(&squares);
        squares.truncate(squares.partition_point(|square| *square <= most).max(least));
    }
    let sigma_k = (mean(&squares) / 6.0).sqrt();
    (sigma_k.is_finite() && sigma_k > 0.0).then_some(sigma_k)
}

fn mean(values: &[f64]) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "a count of readings")]
    let count = values.len() as f64;
    values.iter().sum::<f64>() / count
}

/// Readings without single wrong ones: that lie farther from both neighbours, on one side, than noise does.
pub(super) fn without_spikes(readings: &[At], sigma_k: f64) -> Vec<At> {
    let far_k = (SPIKE * sigma_k).max(SPIKE_LEAST_K);
    let is_spike = |place: usize| {
        let Some((before, after)) = place.checked_sub(1).zip(readings.get(place + 1)) else { return false };
        let (up_k, down_k) = (readings[place].1 - readings[before].1, readings[place].1 - after.1);
        up_k * down_k > 0.0 && up_k.abs().min(down_k.abs()) > far_k
    };
    (0..readings.len()).filter(|place| !is_spike(*place)).map(|place| readings[place]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A reading in steps of 0.1 K that takes one once in 10 s: the steps are all the noise there is, and none of them is wrong.
    #[test]
    fn steps_of_a_coarse_reading_are_its_noise() {
        let steps: Vec<At> = (0..1000)
            .map(|place| (0.1 * f64::from(place), if place % 100 == 50 { 200.1 } else { 200.0 }))
            .collect();
        let sigma_k = noise(&steps).unwrap();
        assert!((0.003..0.02).contains(&sigma_k), "{sigma_k}");
        assert_eq!(without_spikes(&steps, sigma_k).len(), steps.len());
    }
}
