use super::*;
use futures::FutureExt;

#[test]
fn simulated_time_stands_until_told() {
    let clock = Clock::simulated();
    assert_eq!(clock.now(), Seconds(0.0));
    assert!(!clock.set(Seconds(5.0)));
    assert_eq!(clock.now(), Seconds(5.0));
}

#[test]
fn a_jump_back_is_counted() {
    let clock = Clock::simulated();
    clock.set(Seconds(5.0));
    assert!(clock.set(Seconds(1.0)));
    assert_eq!((clock.jumps_back(), clock.now()), (1, Seconds(1.0)));
}

#[test]
fn monotonic_time_does_not_go_back_and_dates_by_age() {
    let clock = Clock::monotonic();
    let before = clock.now();
    let dated = clock.at_age(Seconds(1.0));
    assert!(clock.now() >= before);
    assert!((before - dated).0 <= 1.0 && (clock.now() - dated).0 >= 1.0);
}

#[test]
fn a_message_older_than_the_history_is_dated_to_its_begin() {
    let clock = Clock::simulated();
    clock.set(Seconds(7.0));
    assert_eq!(clock.at_age(Seconds(3600.0)), Seconds(7.0));
}

#[test]
fn a_timer_on_simulated_time_ticks_once_per_period_and_skips_what_was_missed() {
    let clock = Clock::simulated();
    let mut timer = clock.timer(Seconds(0.5));
    assert_eq!(timer.next().now_or_never(), None);
    clock.set(Seconds(0.5));
    assert_eq!(timer.next().now_or_never(), Some(Seconds(0.5)));
    clock.set(Seconds(2.1));
    assert_eq!(timer.next().now_or_never(), Some(Seconds(2.1)));
    // due again at 2.5, not at 1.5 and 2.0
    assert_eq!(timer.next().now_or_never(), None);
    clock.set(Seconds(2.5));
    assert_eq!(timer.next().now_or_never(), Some(Seconds(2.5)));
}

#[test]
fn a_timer_that_is_put_off_ticks_later_and_then_as_before() {
    let clock = Clock::simulated();
    let mut timer = clock.timer(Seconds(0.5));
    clock.set(Seconds(0.3));
    timer.put_off(Seconds(0.6));
    clock.set(Seconds(0.89));
    assert_eq!(timer.next().now_or_never(), None);
    for due_s in [0.91, 1.41] {
        clock.set(Seconds(due_s));
        assert_eq!(timer.next().now_or_never(), Some(Seconds(due_s)));
    }
}

#[test]
fn a_timer_goes_on_after_a_jump_back() {
    let clock = Clock::simulated();
    let mut timer = clock.timer(Seconds(1.0));
    clock.set(Seconds(100.0));
    assert!(timer.next().now_or_never().is_some());
    clock.set(Seconds(3.0));
    assert_eq!(timer.next().now_or_never(), None);
    clock.set(Seconds(4.0));
    assert_eq!(timer.next().now_or_never(), Some(Seconds(4.0)));
}

/// Who makes the time has limits of real time and stamps of the time that it makes.
#[test]
fn a_maker_of_time_stamps_by_it_and_runs_by_the_hosts() {
    let clock = Clock::monotonic();
    let told = clock.clone();
    clock.announce(Seconds(12.5));
    assert_eq!(told.stamp(), Seconds(12.5));
    assert!(told.now() >= monotonic() - Seconds(1.0));
    let listener = Clock::simulated();
    listener.set(Seconds(3.0));
    assert_eq!(listener.stamp(), Seconds(3.0));
}
