//! Which streams must come: not every machine has every sensor.

use models::params::ParamError;
use serde::Deserialize;

use crate::event::Stream;

/// A set of streams, written as a list of their names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(from = "Vec<Stream>")]
pub struct Streams(u8);

impl Streams {
    /// The set of these streams.
    #[must_use]
    pub fn of(streams: &[Stream]) -> Self {
        Self(streams.iter().fold(0, |set, stream| set | bit(*stream)))
    }

    /// Whether a stream is in the set.
    #[must_use]
    pub fn has(self, stream: Stream) -> bool {
        self.0 & bit(stream) != 0
    }

    /// The streams of the set.
    pub fn iter(self) -> impl Iterator<Item = Stream> {
        Stream::ALL.into_iter().filter(move |stream| self.has(*stream))
    }
}

impl From<Vec<Stream>> for Streams {
    fn from(streams: Vec<Stream>) -> Self {
        Self::of(&streams)
    }
}

fn bit(stream: Stream) -> u8 {
    1 << stream as u8
}

/// A printer that extrudes: its hot end and its state.
pub(super) fn at_start() -> Streams {
    Streams::of(&[Stream::Hotend, Stream::Printer])
}

/// What the corrections of a printer that extrudes are made of.
pub(super) fn to_act() -> Streams {
    Streams::of(&[Stream::Estimate, Stream::Encoder])
}

/// Without the printer's state nothing else can be judged.
pub(super) fn check(required: Streams) -> Result<(), ParamError> {
    if required.has(Stream::Printer) {
        return Ok(());
    }
    let value = f64::from(required.0.count_ones());
    let rule = "a list that holds printer".to_owned();
    Err(ParamError::OutOfRange { name: "required", value, unit: "streams", rule })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_holds_what_was_named_and_must_hold_the_printer() {
        let set = Streams::of(&[Stream::Vision, Stream::Hotend, Stream::Vision]);
        assert_eq!(set.iter().collect::<Vec<_>>(), [Stream::Hotend, Stream::Vision]);
        let error = check(set).unwrap_err().to_string();
        assert_eq!(error, "required = 2 streams: must be a list that holds printer");
        assert!(check(at_start()).is_ok() && !to_act().has(Stream::Printer));
    }
}
