//! Values out of the bytes of a case.

/// Floats that break what is computed with them.
const ODD: [f64; 16] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE / 8.0,
    -f64::MIN_POSITIVE,
    -0.0,
    0.0,
    1.0,
    -1.0,
    1e300,
    -1e9,
    4.3e9,
    1e6,
    1e-9,
];

/// The bytes that are left; behind their end all are zero.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Values<'a>(&'a [u8]);

impl<'a> Values<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(crate) fn rest(self) -> &'a [u8] {
        self.0
    }

    pub(crate) fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        *first
    }

    pub(crate) fn below(&mut self, end: usize) -> usize {
        usize::from(self.byte()) % end
    }

    pub(crate) fn flag(&mut self) -> bool {
        self.byte() & 1 == 1
    }

    pub(crate) fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }

    pub(crate) fn whole(&mut self) -> u64 {
        u64::from_le_bytes([0; 8].map(|_: u8| self.byte()))
    }

    /// One that breaks arithmetic, any bits, or one of the sizes that occur.
    pub(crate) fn number(&mut self) -> f64 {
        match self.byte() % 4 {
            0 => self.pick(&ODD),
            1 => f64::from_bits(self.whole()),
            2 => f64::from(i16::from_le_bytes([self.byte(), self.byte()])) / 50.0,
            _ => f64::from(self.byte()) / 100.0 - 0.5,
        }
    }
}
