//! Statistics of judged pictures, each with its 95 % interval.

use super::chance::Stream;
use std::collections::BTreeMap;

/// Value, lower and upper end of its 95 % interval.
pub(super) type Interval = [f64; 3];
/// Normal point of a two-sided 95 %.
const NORMAL_95: f64 = 1.959_964;

/// A judged picture.
#[derive(Debug, Clone)]
pub(super) struct Scored {
    /// Its label.
    pub(super) class: String,
    /// Pictures of one cluster depend on each other and are drawn together.
    pub(super) cluster: u64,
    /// Probability by class, in the network's order.
    pub(super) probabilities: Vec<f64>,
}

impl Scored {
    /// Index of the largest of the given probabilities.
    pub(super) fn best_of(&self, classes: &[usize]) -> Option<usize> {
        classes.iter().copied().reduce(|best, class| {
            if self.probabilities[class] > self.probabilities[best] { class } else { best }
        })
    }
}

/// A share with Wilson's interval (1927); `None` of nothing.
pub(super) fn share(hits: usize, total: usize) -> Option<Interval> {
    if total == 0 {
        return None;
    }
    let (hits, total) = (number(hits), number(total));
    let (share, square) = (hits / total, NORMAL_95 * NORMAL_95);
    let middle = (share + square / (2.0 * total)) / (1.0 + square / total);
    let reach = NORMAL_95 / (1.0 + square / total)
        * (share * (1.0 - share) / total + square / (4.0 * total * total)).sqrt();
    Some([share, (middle - reach).max(0.0), (middle + reach).min(1.0)])
}

/// A count as a number.
#[expect(clippy::cast_precision_loss, reason = "counts of pictures")]
pub(super) fn number(count: usize) -> f64 {
    count as f64
}

/// Area under the receiver's curve: how often a positive scores above a negative, ties half (Mann and Whitney).
pub(super) fn auroc(scores: &[(f64, bool)]) -> Option<f64> {
    let mut sorted = scores.to_vec();
    sorted.sort_by(|one, other| one.0.total_cmp(&other.0));
    let positives = number(sorted.iter().filter(|(_, positive)| *positive).count());
    let negatives = number(sorted.len()) - positives;
    if positives == 0.0 || negatives == 0.0 {
        return None;
    }
    let (mut above, mut below) = (0.0, 0.0);
    for tied in sorted.chunk_by(|one, other| one.0.total_cmp(&other.0).is_eq()) {
        let here = number(tied.iter().filter(|(_, positive)| *positive).count());
        let others = number(tied.len()) - here;
        above += here * (below + others / 2.0);
        below += others;
    }
    Some(above / (positives * negatives))
}

/// Share of the positives above the score that at most `rate` of the negatives exceed.
pub(super) fn recall_at(scores: &[(f64, bool)], rate: f64) -> Option<f64> {
    let mut negatives: Vec<f64> =
        scores.iter().filter(|(_, positive)| !positive).map(|(score, _)| *score).collect();
    let positives: Vec<f64> =
        scores.iter().filter(|(_, positive)| *positive).map(|(score, _)| *score).collect();
    if negatives.is_empty() || positives.is_empty() {
        return None;
    }
    negatives.sort_by(|one, other| other.total_cmp(one));
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place in the list")]
    let allowed = (rate * number(negatives.len())).floor() as usize;
    let bar = negatives.get(allowed).copied().unwrap_or(f64::NEG_INFINITY);
    Some(number(positives.iter().filter(|score| **score > bar).count()) / number(positives.len()))
}

/// F1 of a class: `2 tp / (2 tp + fp + fn)`; `None` where it is neither there nor named.
pub(super) fn f1<T: PartialEq>(pairs: &[(T, T)], class: &T) -> Option<f64> {
    let count = |of: &dyn Fn(&(T, T)) -> bool| number(pairs.iter().filter(|pair| of(pair)).count());
    let both = count(&|(truth, said)| truth == class && said == class);
    let one = count(&|(truth, said)| (truth == class) != (said == class));
    (both + one > 0.0).then(|| 2.0 * both / (2.0 * both + one))
}

/// A statistic with the 2.5 and 97.5 % points of its bootstrap over clusters (Efron 1979).
pub(super) fn bootstrap(
    items: &[&Scored],
    (seed, resamples): (u64, u32),
    statistic: &dyn Fn(&[&Scored]) -> Option<f64>,
) -> Option<Interval> {
    let value = statistic(items)?;
    let mut clusters: BTreeMap<u64, Vec<&Scored>> = BTreeMap::new();
    for item in items {
        clusters.entry(item.cluster).or_default().push(item);
    }
    let clusters: Vec<Vec<&Scored>> = clusters.into_values().collect();
    let mut stream = Stream::new(seed);
    let mut values: Vec<f64> = (0..resamples)
        .filter_map(|_| {
            let drawn: Vec<&Scored> = (0..clusters.len())
                .flat_map(|_| clusters[stream.place(clusters.len())].iter().copied())
                .collect();
            statistic(&drawn)
        })
        .collect();
    values.sort_by(f64::total_cmp);
    let at = |share: f64| {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place in the list")]
        let place = (share * number(values.len().saturating_sub(1))).round() as usize;
        values.get(place).copied()
    };
    Some([value, at(0.025)?, at(0.975)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Wilson's interval of 8 in 10 is [0.490, 0.943] (Brown, Cai and DasGupta 2001).
    #[test]
    fn a_share_of_8_in_10_has_wilsons_interval() {
        let [value, low, high] = share(8, 10).unwrap();
        assert!((value - 0.8).abs() < 1e-12 && (low - 0.490).abs() < 5e-4 && (high - 0.943).abs() < 5e-4);
        assert_eq!(share(0, 0), None);
    }

    #[test]
    fn the_area_counts_pairs_in_order_and_ties_half() {
        // Pairs: 0.9 above both, 0.4 ties one and is above none of the rest: (2 + 0.5) / 4.
        let scores = [(0.9, true), (0.4, true), (0.4, false), (0.5, false)];
        assert_eq!(auroc(&scores), Some(0.625));
        assert_eq!(auroc(&scores[..2]), None);
    }

    #[test]
    fn recall_is_taken_where_no_more_than_the_rate_of_negatives_exceed() {
        let negatives = (0..20).map(|step| (f64::from(step) / 20.0, false));
        let scores: Vec<_> = negatives.chain([(0.93, true), (0.91, true), (0.2, true)]).collect();
        // One of 20 may exceed: the bar is the second largest, 0.9.
        assert_eq!(recall_at(&scores, 0.05), Some(2.0 / 3.0));
    }

    #[test]
    fn a_bootstrap_holds_its_value_and_repeats() {
        let items: Vec<Scored> = (0..40)
            .map(|step| Scored {
                class: "x".into(),
                cluster: step / 2,
                probabilities: vec![f64::from(u8::from(step % 4 < 2))],
            })
            .collect();
        let items: Vec<&Scored> = items.iter().collect();
        let mean = |drawn: &[&Scored]| {
            Some(drawn.iter().map(|item| item.probabilities[0]).sum::<f64>() / number(drawn.len()))
        };
        let first = bootstrap(&items, (7, 200), &mean).unwrap();
        assert!(first[1] < first[0] && first[0] < first[2]);
        assert_eq!(Some(first), bootstrap(&items, (7, 200), &mean));
    }
}
