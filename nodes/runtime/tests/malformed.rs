//! Bytes that nobody sends: every reader of the wire answers, and what it lets through lies in its physical range.
//!
//! Random bytes and sound messages that were flipped, cut, lengthened, or given lengths and floats of the worst kind go
//! through the decoder of the middleware and the readers that all nodes use. `FDM_MALFORMED_PAYLOADS` sets how many for
//! each type; a payload is made of its number alone, so that a failure can be made again.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may panic and says what it did")]
#![allow(clippy::cast_possible_truncation, reason = "random bytes are the low ones of random numbers")]

#[path = "malformed/messages.rs"]
mod messages;
#[path = "malformed/mutation.rs"]
mod mutation;
#[path = "malformed/text.rs"]
mod text;

use byteorder::{BigEndian, LittleEndian};
use fdm_loop_msgs::RosType;
use mutation::Mutation;
use runtime::wire::WireError;

fn payloads() -> u64 {
    std::env::var("FDM_MALFORMED_PAYLOADS").ok().and_then(|text| text.parse().ok()).unwrap_or(3000)
}

/// What became of the payloads of a type.
#[derive(Debug, Default)]
struct Tally {
    undecodable: u64,
    refused: u64,
    taken: u64,
}

/// Sends payloads through decoder and reader; `check` looks at what a reader lets through.
fn storm<T: RosType + Clone, V>(
    sound: &T,
    read: impl Fn(&T) -> Result<V, WireError>,
    check: impl Fn(&V) -> bool,
) -> Tally {
    assert!(check(&read(sound).unwrap()), "{}: the sound one", T::DEFINITION.name);
    let bytes = cdr_encoding::to_vec::<T, LittleEndian>(sound).unwrap();
    let mut tally = Tally::default();
    for number in 0..payloads() {
        let mutation = Mutation::new(number);
        let payload = mutation.apply(&bytes);
        let decoded = if number % 16 == 15 {
            cdr_encoding::from_bytes::<T, BigEndian>(&payload)
        } else {
            cdr_encoding::from_bytes::<T, LittleEndian>(&payload)
        };
        let Ok((message, _)) = decoded else {
            tally.undecodable += 1;
            continue;
        };
        match read(&message) {
            Err(_) => tally.refused += 1,
            Ok(value) => {
                tally.taken += 1;
                assert!(check(&value), "{}: payload {number} was let through", T::DEFINITION.name);
            }
        }
    }
    println!("{:16} {tally:?}", T::DEFINITION.name);
    assert!(tally.undecodable > 0 && tally.refused > 0, "{}: the payloads are too tame", T::DEFINITION.name);
    tally
}

/// Whether each value is a number in a range.
fn all(values: &[f64], low: f64, high: f64) -> bool {
    values.iter().all(|value| (low..=high).contains(value))
}
