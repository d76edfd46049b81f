//! The line of corrections.

use crate::sim::group::Group;
use std::fmt::Write;

/// How much of the time was corrected, and how.
pub(super) fn corrected(text: &mut String, group: &Group) {
    let share = |name: &str| {
        group
            .mean
            .get(name)
            .map_or("-".to_owned(), |mean| format!("{:.2} %{}", 1e2 * mean, group.share(name)))
    };
    // Writing to a string cannot fail.
    _ = writeln!(
        text,
        "{:<9} beyond 1 %: trimmed {} of the time, by feedback {}, in moves planned slower {}",
        group.control,
        share("trimmed_share"),
        share("feedback_share"),
        share("slowed_share")
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sim::report::Run;

    #[test]
    fn feedback_and_plan_are_told_apart() {
        let run = Run {
            trimmed_share: Some(0.5),
            feedback_share: Some(0.004),
            slowed_share: Some(0.125),
            ..Run::default()
        };
        let mut text = String::new();
        corrected(&mut text, &Group::of("mpc".to_owned(), vec![run, Run::default()]));
        let told = "trimmed 50.00 % (1 of 2) of the time, by feedback 0.40 % (1 of 2), in moves planned slower 12.50 % (1 of 2)";
        assert!(text.contains(told), "{text}");
    }
}
