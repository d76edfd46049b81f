//! Many edges, one width: robust, with an honest standard deviation.

use super::facing::Facing;
use super::params::WidthParams;
use models::units::Seconds;

/// What one piece says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PieceWidth {
    /// When its middle was laid.
    pub laid: Seconds,
    /// Width over the wanted one `[-]`.
    pub ratio: f64,
    /// Standard deviation of the ratio, without what all pieces share `[-]`.
    pub sigma: f64,
    /// Wanted `[m]`.
    pub wanted_m: f64,
    /// Height of the road `[m]`.
    pub height_m: f64,
    /// Which way its edges face.
    pub facing: Facing,
}

/// A measured width.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WidthMeasurement {
    /// When the measured stretch was laid.
    pub laid: Seconds,
    /// Width `[m]`.
    pub width_m: f64,
    /// Its standard deviation `[m]`.
    pub sigma_m: f64,
    /// Wanted there `[m]`.
    pub wanted_m: f64,
    /// Height of the road `[m]`.
    pub height_m: f64,
    /// Which way the edges of the newest piece face.
    pub facing: Facing,
    /// Pieces in it.
    pub pieces: u32,
}

/// One width from the pieces laid later than `after`, of those that were laid together.
///
/// Ratios to the wanted width are combined, so that roads of several widths may stand together: the weighted mean of
/// those within `outlier_spreads` of the median. Its variance is the larger of what the pieces state and what they
/// scatter, and a floor for what they share (light, gloss, the lens).
#[must_use]
pub fn combine(
    pieces: &[PieceWidth],
    after: Option<Seconds>,
    params: &WidthParams,
) -> Option<WidthMeasurement> {
    let mut fresh: Vec<PieceWidth> =
        pieces.iter().filter(|piece| after.is_none_or(|after| piece.laid.0 > after.0)).copied().collect();
    fresh.sort_by(|a, b| a.laid.0.total_cmp(&b.laid.0));
    let together = group(&fresh, params.together_s)?;
    let middle = median(together.iter().map(|piece| piece.ratio).collect())?;
    let spread = 1.4826 * median(together.iter().map(|piece| (piece.ratio - middle).abs()).collect())?;
    let least = together.iter().map(|piece| piece.sigma).fold(f64::INFINITY, f64::min);
    let bound = params.outlier_spreads * spread.max(least);
    let kept: Vec<&PieceWidth> =
        together.iter().filter(|piece| (piece.ratio - middle).abs() <= bound).collect();
    let weight = |piece: &&PieceWidth| piece.sigma.powi(-2);
    let total: f64 = kept.iter().map(weight).sum();
    let ratio = kept.iter().map(|piece| weight(piece) * piece.ratio).sum::<f64>() / total;
    let laid_s = kept.iter().map(|piece| weight(piece) * piece.laid.0).sum::<f64>() / total;
    let scatter = kept.iter().map(|piece| weight(piece) * (piece.ratio - ratio).powi(2)).sum::<f64>() / total;
    let count = kept.len();
    #[expect(clippy::cast_precision_loss, reason = "a handful of pieces")]
    let of_mean = if count > 1 { scatter / (count as f64 - 1.0) } else { 0.0 };
    let newest = kept.last()?;
    let sigma_m = (newest.wanted_m * of_mean.max(1.0 / total).sqrt()).hypot(params.sigma_floor_m);
    (sigma_m <= params.sigma_max_m).then_some(WidthMeasurement {
        laid: Seconds(laid_s),
        width_m: ratio * newest.wanted_m,
        sigma_m,
        wanted_m: newest.wanted_m,
        height_m: newest.height_m,
        facing: newest.facing,
        pieces: u32::try_from(count).unwrap_or(u32::MAX),
    })
}

/// The pieces within `span_s` that together say most; of equal ones the newest.
fn group(sorted: &[PieceWidth], span_s: f64) -> Option<&[PieceWidth]> {
    let mut best: Option<(f64, &[PieceWidth])> = None;
    for first in 0..sorted.len() {
        let end = sorted.partition_point(|piece| piece.laid.0 <= sorted[first].laid.0 + span_s);
        let weight: f64 = sorted[first..end].iter().map(|piece| piece.sigma.powi(-2)).sum();
        if best.is_none_or(|(most, _)| weight >= most) {
            best = Some((weight, &sorted[first..end]));
        }
    }
    best.map(|(_, pieces)| pieces)
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let count = values.len();
    let (low, high) = (values.get(count.checked_sub(1)? / 2)?, values.get(count / 2)?);
    Some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::super::params::tests::params;
    use super::*;

    fn piece(laid_s: f64, ratio: f64) -> PieceWidth {
        let facing = Facing::numbered(0);
        PieceWidth { laid: Seconds(laid_s), ratio, sigma: 0.04, wanted_m: 4.5e-4, height_m: 2e-4, facing }
    }

    #[test]
    fn an_outlier_does_not_move_the_width() {
        let mut pieces: Vec<_> = (0..8).map(|k| piece(5.0 + 0.01 * f64::from(k), 1.02)).collect();
        let alone = combine(&pieces, None, &params()).unwrap();
        pieces.push(piece(5.03, 1.4));
        let with = combine(&pieces, None, &params()).unwrap();
        assert!((with.width_m - alone.width_m).abs() < 1e-12 && with.pieces == 8);
    }

    /// 0.04 / sqrt(4) of 450 um is 9 um; with the floor of 10 um, 13.5 um.
    #[test]
    fn sigma_falls_with_the_root_of_the_pieces_to_the_floor() {
        let pieces: Vec<_> = (0..4).map(|k| piece(5.0 + 0.01 * f64::from(k), 1.0)).collect();
        let sigma_m = combine(&pieces, None, &params()).unwrap().sigma_m;
        assert!((sigma_m - 9e-6_f64.hypot(10e-6)).abs() < 1e-9, "{sigma_m}");
    }

    #[test]
    fn what_was_said_before_is_not_said_again() {
        let pieces = [piece(5.0, 1.0), piece(5.9, 1.1), piece(5.95, 1.1), piece(6.0, 1.1)];
        let width = combine(&pieces, None, &params()).unwrap();
        assert!((width.laid.0 - 5.95).abs() < 1e-9 && (width.width_m - 4.95e-4).abs() < 1e-9);
        assert_eq!(combine(&pieces, Some(Seconds(6.0)), &params()), None);
    }
}
