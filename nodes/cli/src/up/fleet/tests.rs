//! Real processes on a virtual clock.

use super::*;

fn recipe(name: &'static str, script: &str) -> Recipe {
    Recipe { name, program: "/bin/sh".into(), arguments: vec!["-c".into(), script.into()], replaceable: true }
}

fn logs(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("fdm_fleet_{}_{name}", std::process::id()))
}

/// Tends the fleet on a virtual clock until it says something.
fn next(fleet: &mut Fleet, now: &mut Seconds) -> Happening {
    loop {
        if let Some(happening) = fleet.tend(*now).into_iter().next() {
            return happening;
        }
        // Virtual time; the child itself needs some real time to end.
        // A sum of such steps and of whole seconds is exact: a time that is due is due.
        now.0 += 1.0 / 128.0;
        std::thread::yield_now();
    }
}

/// A disk that is full for a while ends a recorder six times in a minute: it is tried again every 2 s, after a minute every
/// 10 s, told once when that begins and once when it has stayed, and nothing of what is between.
#[test]
fn a_process_that_keeps_ending_is_tried_again_until_it_stays() {
    let logs = logs("short");
    std::fs::create_dir_all(&logs).unwrap();
    let mark = logs.join("sound");
    _ = std::fs::remove_file(&mark);
    let script = format!("test -e '{}' && exec sleep 60; exit 3", mark.display());
    let mut fleet = Fleet::start(vec![recipe("short", &script)], &logs).unwrap();
    // No delay is longer than 2 s: all five restarts lie inside one minute of virtual time.
    let (mut now, mut restarts) = (Seconds(0.0), 0);
    loop {
        // Time stands still while the child is alive, so that the window cannot slip away.
        let mut still = now;
        match next(&mut fleet, &mut still) {
            Happening::Ended { how, .. } => assert!(how.contains('3'), "{how}"),
            Happening::Restarted { .. } => {
                restarts += 1;
                now.0 += 2.0;
            }
            Happening::KeepsEnding { name, how } => {
                assert_eq!((name, restarts), ("short", 5));
                assert!(how.contains('3'), "{how}");
                now = still;
                break;
            }
            other => panic!("{other:?}"),
        }
    }
    let began = now;
    for delay_s in std::iter::repeat_n(2.0, 30).chain([10.0; 3]) {
        assert_eq!(fleet.tend(now + Seconds(delay_s - 0.1)), [], "not yet, {:.1} s", (now - began).0);
        now.0 += delay_s;
        assert_eq!(fleet.tend(now), [], "started, and not told");
        // Time stands still until the child has ended.
        let mut told = Vec::new();
        while told.is_empty() {
            told = fleet.tend(now);
        }
        assert_eq!(told, [Happening::EndedAgain { name: "short" }]);
    }
    assert!(!fleet.has_lost("short"));
    std::fs::write(&mark, "").unwrap();
    now.0 += 10.0;
    assert_eq!(fleet.tend(now), []);
    assert_eq!(fleet.tend(now + Seconds(9.9)), [], "it may end yet");
    assert!(matches!(fleet.tend(now + Seconds(10.0))[..], [Happening::Restarted { name: "short", .. }]));
    assert_eq!(fleet.tend(now + Seconds(20.0)), [], "told once");
    // From here on it is as any other.
    fleet.ask_to_end(None);
    assert!(matches!(next(&mut fleet, &mut now), Happening::Ended { name: "short", .. }));
    std::fs::remove_dir_all(logs).unwrap();
}

/// The printer's process has its job in its memory: another one would begin it anew.
#[test]
fn a_printer_that_ended_stays_down() {
    let printer = Recipe { replaceable: false, ..recipe("printer_sim", "exit 3") };
    let mut fleet = Fleet::start(vec![printer], &logs("printer")).unwrap();
    assert!(!fleet.end("printer_sim", Signal::TERM));
    assert_eq!(next(&mut fleet, &mut Seconds(0.0)), Happening::GivenUp { name: "printer_sim" });
    assert!(fleet.has_lost("printer_sim"));
}

/// X1: garbage that ends a process each time it is started keeps nobody down once it stops.
#[test]
fn a_process_that_is_driven_out_is_started_again_as_often_as_it_takes() {
    let mut fleet = Fleet::start(vec![recipe("driven", "exit 75")], &logs("driven")).unwrap();
    let (mut now, mut restarts) = (Seconds(0.0), 0);
    let mut ended = now;
    while restarts < 20 {
        match next(&mut fleet, &mut now) {
            Happening::Ended { how, .. } => {
                assert!(how.contains("75"), "{how}");
                ended = now;
            }
            // A tenth of a second at first, then half a one, and a look.
            Happening::Restarted { .. } => {
                restarts += 1;
                let limit_s = if restarts == 1 { 0.12 } else { 0.52 };
                assert!((now - ended).0 < limit_s, "restart {restarts} after {} s", (now - ended).0);
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn delays_grow_from_a_tenth_to_two_seconds() {
    let delays: Vec<f64> = (0..6).map(|restarts| delay(restarts).0).collect();
    assert_eq!(delays, [0.1, 0.5, 1.0, 2.0, 2.0, 2.0]);
}

#[test]
fn a_program_that_is_not_there_is_named() {
    let missing = Recipe { name: "x", program: "/nowhere/x".into(), arguments: vec![], replaceable: true };
    let error = Fleet::start(vec![missing], &logs("missing")).err().unwrap();
    assert!(error.to_string().starts_with("/nowhere/x:"), "{error}");
}

/// Who ends in order is none of them, nor who still runs.
#[test]
fn who_ended_badly_is_named_with_how() {
    let logs = logs("badly");
    let scripts = [("well", "exit 0"), ("badly", "exit 3"), ("killed", "kill -9 $$"), ("runs", "sleep 60")];
    let recipes = scripts.map(|(name, script)| recipe(name, script)).into();
    let mut fleet = Fleet::start(recipes, &logs).unwrap();
    while !fleet.all_ended(Some("runs")) {
        std::thread::yield_now();
    }
    let badly = fleet.ended_badly();
    assert_eq!(badly.iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["badly", "killed"]);
    assert_eq!(badly[0].1, "exit status: 3");
    assert!(badly[1].1.starts_with("signal: 9"), "{badly:?}");
    assert_eq!(fleet.names().count(), 4);
    drop(fleet);
    std::fs::remove_dir_all(logs).unwrap();
}

#[test]
fn all_end_when_asked() {
    let mut fleet =
        Fleet::start(vec![recipe("a", "sleep 60"), recipe("b", "sleep 60")], &logs("asked")).unwrap();
    assert_eq!(fleet.pids().len(), 2);
    fleet.ask_to_end(None);
    while !fleet.all_ended(None) {
        std::thread::yield_now();
    }
    assert!(fleet.kill_rest(None).is_empty());
}

/// The recorder is left its time when the others have had theirs.
#[test]
fn who_does_not_end_is_ended_by_force_but_for_the_recorder() {
    let both = vec![recipe("hangs", "sleep 60"), recipe("bag_recorder", "sleep 60")];
    let mut fleet = Fleet::start(both, &logs("force")).unwrap();
    assert_eq!(fleet.kill_rest(Some("bag_recorder")), ["hangs"]);
    assert!(fleet.all_ended(Some("bag_recorder")) && !fleet.all_ended(None));
    assert_eq!(fleet.kill_rest(None), ["bag_recorder"]);
}
