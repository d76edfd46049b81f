//! What the log is told of a nozzle that narrows, and counts as sound again.

/// Factor by which the force has to differ from what was told last `[-]`: a log is no plot.
const STEP: f64 = 1.25;

/// The force that was told last.
#[derive(Debug)]
pub(super) struct Narrowing {
    told: f64,
}

impl Narrowing {
    /// Nothing was told.
    pub(super) const SOUND: Self = Self { told: 1.0 };

    /// Takes the force that the melt needs over that of a sound nozzle `[-]`, > 0; what is to be told of it.
    pub(super) fn follow(&mut self, force: f64) -> Option<String> {
        let news = (force / self.told).ln().abs() >= STEP.ln();
        let sound = self.told > 1.0 && force <= 1.0;
        if !(news || sound) {
            return None;
        }
        self.told = force;
        Some(if force > 1.0 {
            format!(
                "the nozzle has narrowed: its melt needs {force:.1} times the force of a sound one, which coming moves get; \
                 clean it where that comes again"
            )
        } else {
            "the nozzle counts as sound again".to_owned()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_nozzle_that_narrows_is_told_by_steps_and_its_end() {
        let mut narrowing = Narrowing::SOUND;
        let told: Vec<Option<String>> = [1.0, 1.1, 1.6, 1.5, 1.9, 2.1, 1.0, 1.0]
            .into_iter()
            .map(|force| narrowing.follow(force))
            .collect();
        let at = |index: usize| told[index].as_deref().unwrap_or_default();
        assert!(at(2).contains("1.6 times") && at(5).contains("2.1 times"), "{told:?}");
        assert!(at(6).contains("sound again"), "{told:?}");
        assert_eq!(told.iter().flatten().count(), 3, "{told:?}");
    }

    /// Little is told of, and so nobody asks whether it has passed.
    #[test]
    fn what_was_not_told_does_not_end() {
        let mut narrowing = Narrowing::SOUND;
        assert!([1.0, 1.2, 1.0].into_iter().all(|force| narrowing.follow(force).is_none()));
    }
}
