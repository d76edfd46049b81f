//! What can happen to the bytes of a message.

use models::units::Seconds;

/// Random numbers of a seed: SplitMix64.
#[derive(Debug, Clone)]
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Below `end`; 0 where that is none.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        usize::try_from(self.next() % (end.max(1) as u64)).unwrap()
    }
}

/// Floats that break what is computed with them.
const FLOATS: [f64; 16] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE / 8.0,
    -f64::MIN_POSITIVE,
    -0.0,
    1e300,
    -1e300,
    1e18,
    -1e9,
    1e7,
    -1.0,
    2.0,
    1e3,
];
/// Lengths that a reader must not believe.
const LENGTHS: [u32; 8] = [0, 1, 2, 0xff, 0xffff, 0x7fff_ffff, 0x8000_0000, u32::MAX];

/// One way to break a message.
#[derive(Debug, Clone)]
pub(crate) struct Mutation(Random);

impl Mutation {
    pub(crate) fn new(number: u64) -> Self {
        Self(Random(number))
    }

    /// The bytes that arrive in place of the sound ones.
    pub(crate) fn apply(&self, sound: &[u8]) -> Vec<u8> {
        let mut random = self.0.clone();
        let mut bytes = sound.to_vec();
        match random.below(8) {
            0 => bytes = (0..random.below(2 * sound.len() + 16)).map(|_| random.next() as u8).collect(),
            1 => bytes.truncate(random.below(sound.len())),
            2 => bytes.extend((0..random.below(64)).map(|_| random.next() as u8)),
            3 => {
                let length = LENGTHS[random.below(LENGTHS.len())];
                overwrite(&mut bytes, 4 * random.below(sound.len() / 4), &length.to_le_bytes());
            }
            4 | 5 => {
                for _ in 0..=random.below(3) {
                    let float = FLOATS[random.below(FLOATS.len())];
                    // Most floats lie on a boundary of 8 bytes, with or without the header of 4.
                    let at = 4 * random.below(sound.len() / 4);
                    overwrite(&mut bytes, at, &float.to_le_bytes());
                }
            }
            _ => {
                for _ in 0..=random.below(8) {
                    let at = random.below(sound.len());
                    bytes[at] ^= 1 << random.below(8);
                }
            }
        }
        bytes
    }
}

fn overwrite(bytes: &mut [u8], at: usize, with: &[u8]) {
    for (place, byte) in bytes.iter_mut().skip(at).zip(with) {
        *place = *byte;
    }
}

/// A stamp is an `int32` of seconds: no clock is farther.
pub(crate) fn is_a_stamp(stamp: Seconds) -> bool {
    stamp.0.abs() <= 2_147_483_649.0
}
