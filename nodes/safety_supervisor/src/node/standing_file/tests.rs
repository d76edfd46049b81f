//! Mode and pause on disk.

use super::*;
use std::fs;

/// The latch's path in a folder of its own.
fn latch(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("standing_{}_{name}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    folder.join("latch.json")
}

fn left_at(latch: &Path) -> (Option<Standing>, Option<String>) {
    let (file, refused) = StandingFile::open(Some(latch));
    (file.stored().map(Standing::from), refused)
}

#[tokio::test]
async fn mode_and_pause_survive_a_restart_and_end_with_the_last_of_them() {
    let latch = latch("survives");
    assert_eq!(left_at(&latch), (None, None));
    let (mut file, _) = StandingFile::open(Some(&latch));
    let set = Standing { mode: Some(StartMode::Observe), paused: None, standby: false };
    for standing in [set, Standing { paused: Some(Cause::OperatorPause), ..set }, set] {
        assert!(!file.keeps(Some(standing.into())).await, "not kept before it is on disk");
        file.finish().await;
        assert!(file.keeps(Some(standing.into())).await);
        assert_eq!(left_at(&latch), (Some(standing), None));
    }
    file.end(None).await;
    assert_eq!(left_at(&latch), (None, None));
    assert!(StandingFile::open(None).0.keeps(Some(set.into())).await, "no path: nothing to wait for");
    fs::remove_dir_all(latch.parent().unwrap()).unwrap();
}

/// The latch is written beside its file first, and so is this record: neither takes the other's place.
#[test]
fn no_name_is_the_latchs_own() {
    for latch in ["/x/latch.json", "/x/latch", "/x/latch.standing.json"] {
        let latch = Path::new(latch);
        let standing = path_of(latch);
        let all = [latch.to_owned(), record::beside(latch), record::beside(&standing), standing];
        let different: std::collections::BTreeSet<_> = all.iter().collect();
        assert_eq!(different.len(), all.len(), "{all:?}");
    }
}

/// Cut anywhere, empty, of a later version, with a mode nobody can set, without a field or with another: each is the
/// strictest, with file, place, value and what it may be.
#[test]
fn what_cannot_be_read_is_observe_and_paused() {
    let latch = latch("corrupt");
    let standing =
        Standing { mode: Some(StartMode::Act), paused: Some(Cause::OperatorPause), standby: false };
    let full = serde_json::to_string(&Written::from(standing)).unwrap();
    assert_eq!(full, r#"{"version":1,"mode":"act","paused":"operator_pause"}"#);
    let record = path_of(&latch);
    let refused = |text: &str| {
        fs::write(&record, text).unwrap();
        let (left, refused) = left_at(&latch);
        assert_eq!(left, Some(Standing::UNREADABLE), "{text}");
        let refused = refused.unwrap();
        assert!(refused.starts_with(&format!("{}: ", record.display())), "{refused}");
        assert!(refused.ends_with(": taken for observe, paused"), "{refused}");
        refused
    };
    for cut in 0..full.len() {
        let refused = refused(&full[..cut]);
        assert!(refused.contains("line 1 column"), "{refused}");
    }
    for (text, told) in [
        (full.replace(":1", ":2"), "version = 2: must be 1"),
        (full.replace("act", "estop"), "unknown variant `estop`, expected one of `observe`, `advise`, `act`"),
        (full.replace("operator_pause", "tea"), "unknown variant `tea`"),
        (full.replace("mode", "mood"), "unknown field `mood`"),
        (full.replace(r#""mode":"act","#, ""), "missing field `mode`"),
        (full.replace(r#","paused":"operator_pause""#, ""), "missing field `paused`"),
        ("{}".to_owned(), "missing field `version`"),
    ] {
        let refused = refused(&text);
        assert!(refused.contains(told), "{refused}");
    }
    fs::write(&record, &full).unwrap();
    assert_eq!(
        left_at(&latch),
        (Some(standing), None),
        "a record that does not say what the pause rested on"
    );
    fs::remove_file(&record).unwrap();
    fs::create_dir(&record).unwrap();
    assert_eq!(left_at(&latch).0, Some(Standing::UNREADABLE), "no file");
    fs::remove_dir_all(latch.parent().unwrap()).unwrap();
}

#[tokio::test]
async fn a_record_tells_what_the_pause_rested_on() {
    let latch = latch("rested");
    let standing = Standing { mode: None, paused: Some(Cause::FilamentSlip), standby: false };
    let written = Written::new(standing, Evidence::of(Cause::FilamentSlip, 87.5, Some(42.0)));
    let (mut file, _) = StandingFile::open(Some(&latch));
    file.end(Some(written)).await;
    let (file, refused) = StandingFile::open(Some(&latch));
    let evidence = file.stored().and_then(Written::evidence).unwrap();
    assert_eq!((evidence.to_string().as_str(), refused), ("88 % slip, limit 42 %", None));
    assert_eq!(left_at(&latch).0, Some(standing));
    fs::remove_dir_all(latch.parent().unwrap()).unwrap();
}
