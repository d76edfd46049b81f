//! Payloads that nobody sends, through the decoder of the middleware and a reader. The nodes' own readers are tested with
//! it as well.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may panic and says what it did")]
#![allow(clippy::cast_possible_truncation, reason = "random bytes are the low ones of random numbers")]
#![allow(dead_code, reason = "not every reader has numbers or a stamp")]

#[path = "mutation.rs"]
mod mutation;

use byteorder::{BigEndian, LittleEndian};
use fdm_loop_msgs::RosType;
pub(crate) use mutation::{Mutation, is_a_stamp};
use runtime::wire::WireError;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// How many payloads each type gets.
pub(crate) fn payloads() -> u64 {
    std::env::var("FDM_MALFORMED_PAYLOADS").ok().and_then(|text| text.parse().ok()).unwrap_or(3000)
}

/// What became of the payloads of a type.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    undecodable: u64,
    refused: u64,
    taken: u64,
}

/// Sends payloads through decoder and reader; `check` looks at what a reader lets through.
pub(crate) fn storm<T: RosType + Clone, V>(
    sound: &T,
    read: impl Fn(&T) -> Result<V, WireError>,
    check: impl Fn(&V) -> bool,
) -> Tally {
    let tally = any_storm(sound, read, check);
    assert!(tally.refused > 0, "{}: the payloads are too tame", T::DEFINITION.name);
    tally
}

/// As [`storm`], of a type whose reader takes whatever can be decoded.
pub(crate) fn any_storm<T: RosType + Clone, V>(
    sound: &T,
    read: impl Fn(&T) -> Result<V, WireError>,
    check: impl Fn(&V) -> bool,
) -> Tally {
    assert!(check(&read(sound).unwrap()), "{}: the sound one", T::DEFINITION.name);
    bytes_storm(T::DEFINITION.name, sound, |message, number| match read(message) {
        Err(_) => false,
        Ok(value) => {
            assert!(check(&value), "{}: payload {number} was let through", T::DEFINITION.name);
            true
        }
    })
}

/// As [`any_storm`], of what need not be a message; `take` says whether it takes what was decoded.
pub(crate) fn bytes_storm<T: Serialize + DeserializeOwned>(
    name: &str,
    sound: &T,
    take: impl Fn(&T, u64) -> bool,
) -> Tally {
    let bytes = cdr_encoding::to_vec::<T, LittleEndian>(sound).unwrap();
    let mut tally = Tally::default();
    for number in 0..payloads() {
        let payload = Mutation::new(number).apply(&bytes);
        let decoded = if number % 16 == 15 {
            cdr_encoding::from_bytes::<T, BigEndian>(&payload)
        } else {
            cdr_encoding::from_bytes::<T, LittleEndian>(&payload)
        };
        match decoded {
            Err(_) => tally.undecodable += 1,
            Ok((message, _)) if take(&message, number) => tally.taken += 1,
            Ok(_) => tally.refused += 1,
        }
    }
    println!("{name:16} {tally:?}");
    assert!(tally.undecodable > 0, "{name}: the payloads are too tame");
    tally
}

/// Whether each value is a number in a range.
pub(crate) fn all(values: &[f64], low: f64, high: f64) -> bool {
    values.iter().all(|value| (low..=high).contains(value))
}
