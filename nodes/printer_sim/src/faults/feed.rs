//! Faults of a sensor that tells of itself, between its measurement and whoever hears it.

use super::Kind;

/// What comes of a sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Feed {
    /// What it measures.
    #[default]
    Live,
    /// What came last, again and again, as of now: its driver hangs.
    Stuck,
    /// Nothing: its plug is out.
    Off,
}

impl Feed {
    pub(super) fn overlay(&mut self, kind: Kind) {
        match kind {
            Kind::Off => *self = Self::Off,
            // Of what is unplugged nothing is repeated.
            Kind::Stuck if *self == Self::Live => *self = Self::Stuck,
            _ => {}
        }
    }
}

/// The line from a sensor to who hears it.
#[derive(Debug, Clone, Default)]
pub struct Line<T>(Option<T>);

impl<T: Clone> Line<T> {
    /// What comes of a measurement under this fault.
    pub fn pass(&mut self, feed: Feed, measured: T) -> Option<T> {
        match feed {
            Feed::Live => {
                self.0 = Some(measured.clone());
                Some(measured)
            }
            Feed::Stuck => Some(self.0.get_or_insert(measured).clone()),
            Feed::Off => None,
        }
    }

    /// What came last.
    #[must_use]
    pub fn last(&self) -> Option<&T> {
        self.0.as_ref()
    }
}
