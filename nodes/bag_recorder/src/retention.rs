//! Which file goes where room is short: the oldest one that nobody wants kept, never the one that is being written.

use crate::params::Room;

/// A finished file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Held {
    /// Its number.
    pub number: u32,
    /// Its size `[byte]`.
    pub bytes: u64,
    /// An event, or a person, wants it kept.
    pub kept: bool,
}

/// What is to be done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// There is room.
    Fine,
    /// The file with this number goes.
    Drop(u32),
    /// The disk is nearly full, and nothing may go.
    Full,
}

/// Judges the finished files, oldest first, beside the size of the one that is being written and what the disk has left
/// `[byte]`.
#[must_use]
pub fn judge(room: &Room, held: &[Held], active_bytes: u64, free_bytes: u64) -> Verdict {
    let total = held.iter().map(|file| file.bytes).sum::<u64>().saturating_add(active_bytes);
    let nearly_full = free_bytes < room.free_bytes;
    if !nearly_full && room.bag_bytes.is_none_or(|most| total <= most) {
        return Verdict::Fine;
    }
    // A bag does not lose its one file for one that has hardly begun, or for none.
    let outgrown = |file: &Held| held.len() > 1 || active_bytes >= file.bytes.max(1);
    match held.iter().find(|file| !file.kept && outgrown(file)) {
        Some(oldest) => Verdict::Drop(oldest.number),
        None if nearly_full => Verdict::Full,
        None => Verdict::Fine,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROOM: Room = Room { bag_bytes: Some(100), free_bytes: 50, keep_severity: 2 };

    fn held(kept: [bool; 3]) -> [Held; 3] {
        [0, 1, 2].map(|number| Held { number, bytes: 40, kept: kept[usize::try_from(number).unwrap()] })
    }

    #[test]
    fn the_oldest_file_that_is_not_kept_goes_first() {
        assert_eq!(judge(&ROOM, &held([false; 3]), 0, 1000), Verdict::Drop(0));
        assert_eq!(judge(&ROOM, &held([true, false, false]), 0, 1000), Verdict::Drop(1));
        assert_eq!(judge(&ROOM, &held([false; 3])[1..], 20, 1000), Verdict::Fine);
        assert_eq!(judge(&ROOM, &held([false; 3])[1..], 21, 1000), Verdict::Drop(1));
    }

    #[test]
    fn no_limit_costs_a_bag_its_one_file() {
        let one = &held([false; 3])[2..];
        assert_eq!(judge(&ROOM, one, 39, 49), Verdict::Full);
        assert_eq!(judge(&ROOM, one, 40, 49), Verdict::Drop(2));
        assert_eq!(judge(&ROOM, &held([false; 3])[1..], 0, 49), Verdict::Drop(1));
        assert_eq!(judge(&ROOM, one, 61, 1000), Verdict::Drop(2), "what is being written is as long");
        // Closed as the last file, and longer than the bag may be.
        let long = [Held { number: 7, bytes: 120, kept: false }];
        assert_eq!(judge(&ROOM, &long, 0, 1000), Verdict::Fine);
        assert_eq!(judge(&ROOM, &long, 0, 49), Verdict::Full);
    }

    /// What is kept outlives the bag's own limit, but not the disk: recording stops before it is full.
    #[test]
    fn kept_files_never_go() {
        assert_eq!(judge(&ROOM, &held([true; 3]), 0, 1000), Verdict::Fine);
        assert_eq!(judge(&ROOM, &held([true; 3]), 0, 49), Verdict::Full);
        assert_eq!(judge(&ROOM, &[], 0, 49), Verdict::Full);
        assert_eq!(judge(&ROOM, &[], 1000, 50), Verdict::Fine);
    }
}
