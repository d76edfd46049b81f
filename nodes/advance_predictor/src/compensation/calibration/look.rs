//! What the widths of a printed line show.

use crate::network::chance::Stream;
use models::advance::VirtualLine;

/// Up to this times the slow speed is slow.
const SLOW: f64 = 1.01;

/// A printed line, as its widths show it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Mean square of the relative error of its cross section, noise included.
    pub square: f64,
    /// How much thinner it is on its fast stretch than on its slow ones, relative to what was wanted `[-]`.
    pub thin: f64,
}

/// Sums of the errors of a virtual line, measured every so far.
#[derive(Default)]
struct Sums {
    count: f64,
    errors: f64,
    squares: f64,
}

impl Sums {
    fn add(&mut self, error: f64) {
        self.count += 1.0;
        self.errors += error;
        self.squares += error * error;
    }
}

/// What the widths of a virtual line show, measured every `spacing_m`.
pub(super) fn look(
    printer: &VirtualLine,
    spacing_m: f64,
    (advance_s, noise): (f64, f64),
    chance: &mut Stream,
) -> Line {
    let (mut way_m, mut due_m, mut slowest_m_s) = (0.0, 0.0, f64::INFINITY);
    let [mut slow, mut fast] = [Sums::default(), Sums::default()];
    printer.print(advance_s, |_, wanted_m_s, laid_m_s, dt| {
        way_m += wanted_m_s * dt.0 / printer.per_way();
        slowest_m_s = wanted_m_s.min(slowest_m_s);
        if way_m >= due_m {
            due_m += spacing_m;
            let error = laid_m_s / wanted_m_s - 1.0 + noise * chance.normal();
            // The line begins slowly; its ramps belong to the fast stretch.
            if wanted_m_s <= SLOW * slowest_m_s { slow.add(error) } else { fast.add(error) }
        }
    });
    Line {
        square: (slow.squares + fast.squares) / (slow.count + fast.count),
        thin: slow.errors / slow.count - fast.errors / fast.count,
    }
}
