//! The words of one command: at most one value a letter.

/// Values by letter.
#[derive(Debug, Clone, Default)]
pub struct Words {
    value: [f64; 26],
    valued: u32,
    bare: u32,
}

fn bit(letter: u8) -> u32 {
    if letter.is_ascii_uppercase() { 1 << (letter - b'A') } else { 0 }
}

impl Words {
    /// Value of a letter (upper case), if one is given.
    #[must_use]
    pub fn get(&self, letter: u8) -> Option<f64> {
        (self.valued & bit(letter) != 0).then(|| self.value[usize::from(letter - b'A')])
    }

    /// Whether the letter stands there, with or without a value.
    #[must_use]
    pub fn has(&self, letter: u8) -> bool {
        (self.valued | self.bare) & bit(letter) != 0
    }

    /// First letter of `letters` without a value.
    #[must_use]
    pub fn bare_of(&self, letters: &[u8]) -> Option<u8> {
        letters.iter().copied().find(|letter| self.bare & bit(*letter) != 0)
    }

    /// Whether there is no word at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.valued | self.bare == 0
    }

    pub(super) fn clear(&mut self) {
        self.valued = 0;
        self.bare = 0;
    }

    pub(super) fn set(&mut self, letter: u8, value: f64) {
        self.valued |= bit(letter);
        self.value[usize::from(letter - b'A')] = value;
    }

    pub(super) fn set_bare(&mut self, letter: u8) {
        self.bare |= bit(letter);
    }
}
