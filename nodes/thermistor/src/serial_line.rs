//! Lines of a serial thermistor: Marlin's report `ok T:21.30 /0.00 B:22.1 /0 @:64` or plain `T:21.3 B:22.0`; `N:` is a
//! sensor in the nozzle, of which no firmware speaks.

use models::units::Celsius;

/// Longest line `[bytes]`: what is longer is no reading.
pub const LINE_MAX: usize = 160;

/// What one line says.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Reading {
    /// Hot end.
    pub hotend: Option<Celsius>,
    /// Bed.
    pub bed: Option<Celsius>,
    /// Nozzle.
    pub nozzle: Option<Celsius>,
}

/// Why a line is no reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LineError {
    /// No temperature in it: an echo, a greeting, an answer to somebody else.
    Other,
    /// A temperature that is no finite number, or bytes that are no text.
    Garbage,
}

/// Reads one line. The first `T:`, the first `B:` and the first `N:` count; set-points after a slash and duties do not.
///
/// # Errors
/// [`LineError`]; both kinds are to be counted.
pub fn parse(line: &[u8]) -> Result<Reading, LineError> {
    let text = std::str::from_utf8(line).map_err(|_| LineError::Garbage)?;
    let mut reading = Reading::default();
    let mut words = text.split_ascii_whitespace();
    while let Some(word) = words.next() {
        let (slot, rest) = if let Some(rest) = word.strip_prefix("T:") {
            (&mut reading.hotend, rest)
        } else if let Some(rest) = word.strip_prefix("B:") {
            (&mut reading.bed, rest)
        } else if let Some(rest) = word.strip_prefix("N:") {
            (&mut reading.nozzle, rest)
        } else {
            continue;
        };
        let rest = if rest.is_empty() { words.next().unwrap_or_default() } else { rest };
        let number = rest.split('/').next().unwrap_or_default();
        let value = number.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or(LineError::Garbage)?;
        slot.get_or_insert(Celsius(value));
    }
    if reading == Reading::default() { Err(LineError::Other) } else { Ok(reading) }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn both(hotend: f64, bed: f64) -> Result<Reading, LineError> {
        Ok(Reading { hotend: Some(Celsius(hotend)), bed: Some(Celsius(bed)), nozzle: None })
    }

    #[test]
    fn lines_of_firmwares() {
        assert_eq!(parse(b"ok T:21.30 /0.00 B:22.1 /0 @:64"), both(21.3, 22.1));
        assert_eq!(parse(b" T:210.06 /210.00 B:59.9 /60.00 T0:1.0 /2 @:67 B@:30"), both(210.06, 59.9));
        assert_eq!(parse(b"T:21.3 B:22.0"), both(21.3, 22.0));
        assert_eq!(parse(b"T:21.3/0.0 B: 22.0/0.0"), both(21.3, 22.0));
        let three = Reading { nozzle: Some(Celsius(201.5)), ..both(210.0, 60.0).unwrap() };
        assert_eq!(parse(b"T:210.0 B:60.0 N:201.5"), Ok(three));
        assert_eq!(parse(b"T:-14.0").map(|reading| reading.hotend), Ok(Some(Celsius(-14.0))));
        assert_eq!(parse(b"echo:busy: processing"), Err(LineError::Other));
        for garbage in
            [&b"T:nan"[..], b"T:inf B:1", b"T:", b"T:2x.3", b"T:210 N:nan", b"B:1e999", b"\xff\xfe T:20"]
        {
            assert_eq!(parse(garbage), Err(LineError::Garbage));
        }
    }

    proptest! {
        #[test]
        fn what_is_read_is_finite(line in "(ok )?T:[-0-9.eENnaif]{0,8}( /[0-9]{1,3})? B:[-0-9.eE]{0,8}") {
            if let Ok(reading) = parse(line.as_bytes()) {
                prop_assert!(reading.hotend.is_none_or(|temp| temp.0.is_finite()));
                prop_assert!(reading.bed.is_none_or(|temp| temp.0.is_finite()));
            }
        }

        #[test]
        fn a_written_temperature_is_read_back(hotend in -50.0..500.0f64, bed in -50.0..200.0f64) {
            prop_assert_eq!(parse(format!("ok T:{hotend} /0 B:{bed} /0").as_bytes()), both(hotend, bed));
        }
    }
}
