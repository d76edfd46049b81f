//! What a walk through a file has found.

use super::chunk::CHUNK_MAX;

/// How a file ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// With its closing record.
    Closed,
    /// In a whole record: it was never closed, or is being written.
    Open,
    /// In the middle of a record.
    Cut,
}

/// What the checksum of the data says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sum {
    /// It fits.
    Fits,
    /// There is none.
    Absent,
    /// Something was changed after it was written.
    Differs,
}

/// What a walk has found, beside the records.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Walked {
    /// How the file ends.
    pub ended: Ended,
    /// What the checksum says.
    pub sum: Sum,
    /// Messages that were read.
    pub messages: u64,
    /// Messages that the file says it has.
    pub stated: Option<u64>,
    /// Places before the end that could not be read.
    pub damages: u64,
    /// Bytes that could not be read, those of a record that was cut off at the end among them.
    pub lost_bytes: u64,
    /// Where the first of these places begins `[byte]`.
    pub first_damage: Option<u64>,
    /// Name of a compression of chunks that cannot be read.
    pub compression: Option<String>,
    /// What a chunk says to unpack to that is not unpacked, for it is too large `[byte]`.
    pub oversize: Option<u64>,
}

impl Walked {
    /// Nothing found yet.
    pub(super) fn begun(ended: Ended) -> Self {
        Self {
            ended,
            sum: Sum::Absent,
            messages: 0,
            stated: None,
            damages: 0,
            lost_bytes: 0,
            first_damage: None,
            compression: None,
            oversize: None,
        }
    }

    /// One more place that cannot be read.
    pub(super) fn damaged(&mut self, at: u64, bytes: u64) {
        self.damages += 1;
        self.lost_bytes += bytes;
        self.first_damage = Some(self.first_damage.map_or(at, |first| first.min(at)));
    }

    /// Closed, nothing in it was changed, and no message is missing.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let all = self.lost_messages().is_none_or(|lost| lost == 0);
        self.ended == Ended::Closed && self.sum != Sum::Differs && self.damages == 0 && all
    }

    /// Something before the end could not be read, or is not what was written.
    #[must_use]
    pub fn is_damaged(&self) -> bool {
        self.damages > 0 || self.sum == Sum::Differs
    }

    /// Messages that were not read; `None` where the file does not say how many it has.
    #[must_use]
    pub fn lost_messages(&self) -> Option<u64> {
        self.stated.map(|stated| stated.saturating_sub(self.messages))
    }

    /// What is damaged before the file's end, behind its name; `None` where nothing is.
    #[must_use]
    pub fn damage_in_words(&self) -> Option<String> {
        let missing = self.lost_messages().filter(|lost| *lost > 0);
        let Some(first) = self.first_damage else {
            return missing.map(|lost| format!("lacks {lost} of the messages that it says it has"));
        };
        let places = match self.damages {
            1 => "one place".to_owned(),
            places => format!("{places} places"),
        };
        let lost = match self.lost_messages() {
            Some(lost) => format!("{lost} of its {} messages are lost", self.stated.unwrap_or_default()),
            None => "how many messages are lost it does not say".to_owned(),
        };
        if let Some(name) = &self.compression {
            let lost_bytes = self.lost_bytes;
            return Some(format!(
                "has chunks compressed by '{name}', not by lz4 or zstd: {lost_bytes} bytes could not be read, {lost}"
            ));
        }
        if let Some(size) = self.oversize {
            return Some(format!(
                "has a chunk that says to unpack to {size} bytes: at most {CHUNK_MAX} are read; {} bytes of the file were \
                 left out, {lost}",
                self.lost_bytes
            ));
        }
        Some(format!(
            "is damaged in {places}, from byte {first} on: {} bytes could not be read, {lost}; what stands behind was read",
            self.lost_bytes
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chunk_that_is_too_large_is_told_with_its_size_and_the_bound() {
        let mut walked = Walked { oversize: Some(1_610_612_736), ..Walked::begun(Ended::Closed) };
        walked.damaged(30, 49_223);
        let told = walked.damage_in_words().unwrap();
        let start =
            "has a chunk that says to unpack to 1610612736 bytes: at most 268435456 are read; 49223 bytes of";
        assert!(told.starts_with(start) && !walked.is_sound(), "{told}");
    }
}
