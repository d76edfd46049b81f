//! Messages out of the bytes of a bag. What does not fit its type is refused, whatever it claims.

use byteorder::{BigEndian, LittleEndian};
use fdm_loop_msgs::RosType;

/// Bytes of the encapsulation header in front of the data.
const ENCAPSULATION: usize = 4;

/// A message of plain CDR in either byte order; `None` where the bytes are none.
pub(crate) fn decode<T: RosType>(payload: &[u8]) -> Option<T> {
    let body = payload.get(ENCAPSULATION..)?;
    match payload {
        [0, 0, ..] => cdr_encoding::from_bytes::<T, BigEndian>(body).ok().map(|(message, _)| message),
        [0, 1, ..] => cdr_encoding::from_bytes::<T, LittleEndian>(body).ok().map(|(message, _)| message),
        _ => None,
    }
}

/// At most `longest` letters of a text, controls as spaces: it comes from anywhere.
pub(crate) fn short(text: &str, longest: usize) -> String {
    let mut letters = text.chars().map(|letter| if letter.is_control() { ' ' } else { letter });
    let mut kept: String = letters.by_ref().take(longest).collect();
    if letters.next().is_some() {
        kept.push('…');
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use fdm_loop_msgs::{DiagnosticArray, PrintEvent, PrinterState, StateEstimate, Temperature};
    use proptest::prelude::*;

    /// A sequence that claims four thousand million elements: refused at once, nothing is set aside for them.
    #[test]
    fn a_huge_length_is_refused() {
        let mut bytes = vec![0, 1, 0, 0];
        bytes.extend([0_u8; 8]);
        bytes.extend([1, 0, 0, 0, 0]);
        bytes.extend([0xff_u8; 8]);
        assert_eq!(decode::<StateEstimate>(&bytes), None);
        assert_eq!(decode::<DiagnosticArray>(&bytes), None);
    }

    #[test]
    fn both_byte_orders_are_read_and_others_refused() {
        let little = [[0, 1, 0, 0].as_slice(), &[0; 8], &[1, 0, 0, 0, 0, 0, 0, 0], &[0; 16]].concat();
        let read: Temperature = decode(&little).unwrap();
        assert_eq!(read.temperature.to_bits(), 0);
        let mut other = little.clone();
        other[1] = 7;
        assert_eq!(decode::<Temperature>(&other), None);
        assert_eq!(decode::<Temperature>(&[]), None);
    }

    #[test]
    fn text_is_cut_by_letters() {
        assert_eq!(short("äöü\n\u{7}x", 4), "äöü …");
    }

    proptest! {
        #[test]
        fn any_bytes_are_decoded_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
            let mut payload = vec![0, 1, 0, 0];
            payload.extend(&bytes);
            _ = decode::<StateEstimate>(&payload);
            _ = decode::<PrinterState>(&payload);
            _ = decode::<PrintEvent>(&payload);
            _ = decode::<DiagnosticArray>(&payload);
        }
    }
}
