//! Scans of Linux industrial I/O: how a device file's bytes hold the samples of its enabled channels.
//!
//! `scan_elements/<channel>_type` reads `[be|le]:[s|u]bits/storagebits>>shift` (kernel documentation, "Industrial I/O
//! buffers"); channels lie in the order of their index, each aligned to its own storage size, and a scan ends aligned
//! to the largest one.

/// How one channel's value is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Storage {
    little_endian: bool,
    signed: bool,
    bits: u32,
    bytes: usize,
    shift: u32,
}

/// Text that is no storage of a channel.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{text:?} is no channel type like le:s13/16>>0 with at most 64 bits")]
pub struct StorageError {
    text: String,
}

impl Storage {
    /// Reads the file `<channel>_type`.
    ///
    /// # Errors
    /// [`StorageError`] where it is none, or repeats a value.
    pub fn parse(text: &str) -> Result<Self, StorageError> {
        read(text.trim()).ok_or_else(|| StorageError { text: text.trim().to_owned() })
    }

    /// The value in these bytes, which are as long as the storage.
    fn value(self, bytes: &[u8]) -> f64 {
        let push = |value: u64, byte: &u8| (value << 8) | u64::from(*byte);
        let stored =
            if self.little_endian { bytes.iter().rev().fold(0, push) } else { bytes.iter().fold(0, push) };
        let unused = 64 - self.bits;
        let raised = (stored >> self.shift) << unused;
        #[allow(clippy::cast_precision_loss, reason = "converters have fewer than 53 bits")]
        if self.signed {
            #[allow(clippy::cast_possible_wrap, reason = "the sign bit is the highest one now")]
            let value = raised as i64 >> unused;
            value as f64
        } else {
            (raised >> unused) as f64
        }
    }
}

fn read(text: &str) -> Option<Storage> {
    let (endian, rest) = text.split_once(':')?;
    let little_endian = match endian {
        "le" => true,
        "be" => false,
        _ => return None,
    };
    let signed = match rest.get(..1)? {
        "s" => true,
        "u" => false,
        _ => return None,
    };
    let (bits, rest) = rest.get(1..)?.split_once('/')?;
    let (storage, shift) = rest.split_once(">>")?;
    let [bits, storage, shift] = [bits, storage, shift].map(|number| number.parse::<u32>().ok());
    let (bits, storage, shift) = (bits?, storage?, shift?);
    let fits = bits >= 1 && matches!(storage, 8 | 16 | 32 | 64) && bits.checked_add(shift)? <= storage;
    fits.then_some(Storage { little_endian, signed, bits, bytes: storage as usize / 8, shift })
}

/// One channel of a scan: its index, and how it is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Channel {
    /// As the file `<channel>_index` has it.
    pub index: u32,
    /// As the file `<channel>_type` has it.
    pub storage: Storage,
}

/// Where x, y and z lie in a scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    channels: [(usize, Storage); 3],
    bytes: usize,
}

impl Layout {
    /// The layout of x, y and z, no other channel being enabled.
    #[must_use]
    pub fn new(channels: [Channel; 3]) -> Self {
        let mut order = [0, 1, 2];
        order.sort_by_key(|axis| channels[*axis].index);
        let mut offsets = [0; 3];
        let (mut end, mut largest) = (0_usize, 1);
        for axis in order {
            let size = channels[axis].storage.bytes;
            offsets[axis] = end.next_multiple_of(size);
            end = offsets[axis] + size;
            largest = largest.max(size);
        }
        let channels = [0, 1, 2].map(|axis| (offsets[axis], channels[axis].storage));
        Self { channels, bytes: end.next_multiple_of(largest) }
    }

    /// Length of a scan `[byte]`.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// Raw values x, y, z of one scan; `None` where it is too short.
    #[must_use]
    pub fn raw(&self, scan: &[u8]) -> Option<[f64; 3]> {
        let read = |(offset, storage): (usize, Storage)| {
            scan.get(offset..offset + storage.bytes).map(|bytes| storage.value(bytes))
        };
        let [x, y, z] = self.channels.map(read);
        Some([x?, y?, z?])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn channel(index: u32, text: &str) -> Channel {
        Channel { index, storage: Storage::parse(text).unwrap() }
    }

    #[test]
    fn an_adxl345_is_read() {
        // 13 bits, sign-extended to 16 or not: bits above the 13 do not count.
        let layout = Layout::new([0, 1, 2].map(|index| channel(index, "le:s13/16>>0\n")));
        assert_eq!(layout.bytes(), 6);
        assert_eq!(layout.raw(&[0x00, 0x01, 0xff, 0xff, 0x00, 0x10]), Some([256.0, -1.0, -4096.0]));
        assert_eq!(layout.raw(&[0; 5]), None);
    }

    #[test]
    fn shift_order_sign_and_alignment_count() {
        // lis2dh12: 12 bits, left-justified.
        let layout = Layout::new([0, 1, 2].map(|index| channel(index, "le:s12/16>>4")));
        assert_eq!(layout.raw(&[0xf0, 0x7f, 0x10, 0x00, 0xf0, 0xff]), Some([2047.0, 1.0, -1.0]));
        // z first, big-endian, unsigned bytes between words.
        let layout =
            Layout::new([channel(2, "be:u16/16>>0"), channel(1, "le:u8/8>>0"), channel(0, "be:s20/32>>12")]);
        assert_eq!(layout.bytes(), 8);
        assert_eq!(
            layout.raw(&[0xff, 0xff, 0xf0, 0, 7, 0, 0x12, 0x34]),
            Some([f64::from(0x1234), 7.0, -1.0])
        );
    }

    #[test]
    fn what_is_no_type_is_refused() {
        for text in [
            "",
            "le:s13/16",
            "me:s1/8>>0",
            "le:s0/16>>0",
            "le:s17/16>>0",
            "le:s13/16>>4",
            "le:s8/24>>0",
            "le:ß",
        ] {
            assert!(Storage::parse(text).is_err(), "{text}");
        }
    }

    proptest! {
        #[test]
        fn any_value_that_fits_is_read_back(value in -4096i16..4096, shift in 0u32..4, little in any::<bool>()) {
            let endian = if little { "le" } else { "be" };
            let storage = Storage::parse(&format!("{endian}:s13/16>>{shift}")).unwrap();
            let stored = value << shift;
            let bytes = if little { stored.to_le_bytes() } else { stored.to_be_bytes() };
            prop_assert!((storage.value(&bytes) - f64::from(value)).abs() < 1e-9);
        }

        #[test]
        fn any_text_is_a_type_or_an_error(text in ".{0,24}") {
            let _ = Storage::parse(&text);
        }
    }
}
