//! Whose session an id is: the id travels in every message and can be copied, so it counts beside who has sent it (C8, X2).

use crate::subscription::Gid;
use std::hash::{BuildHasher, RandomState};

/// Makes session ids that nobody else can have, within this process. The key is random: to choose an id so that it meets
/// another's is a guess among 2^64.
#[derive(Debug, Clone, Default)]
pub struct Sessions(RandomState);

impl Sessions {
    /// The session `id` of a publisher; the same for all publishers of its process.
    #[must_use]
    pub fn of(&self, publisher: Gid, id: u64) -> u64 {
        self.0.hash_one((publisher.process(), id))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_session_is_one_process_and_one_id() {
        let sessions = Sessions::default();
        let gid = |process: u8, entity: u8| {
            Gid(std::array::from_fn(|byte| if byte < 12 { process } else { entity }))
        };
        let one = sessions.of(gid(1, 1), 7);
        assert_eq!(sessions.of(gid(1, 2), 7), one, "another topic of the same process");
        assert_ne!(sessions.of(gid(2, 1), 7), one, "the same id from elsewhere");
        assert_ne!(sessions.of(gid(1, 1), 8), one);
        assert_ne!(Sessions::default().of(gid(1, 1), 7), one, "nobody knows the key");
    }
}
