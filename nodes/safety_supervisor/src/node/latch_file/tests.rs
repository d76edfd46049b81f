//! A latch on disk.

use super::super::record::REST;
use super::*;
use runtime::NodePath;

fn path(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("latch_{}_{name}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    folder.join("latch.json")
}

fn latched(estop: bool, cause: Cause) -> Option<Latched> {
    Some(Latched::new(Latch { estop, cause }, None))
}

fn opened(path: &Path) -> LatchFile {
    LatchFile::open(Some(path.to_owned())).0
}

#[tokio::test]
async fn a_latch_survives_a_restart_and_ends_with_its_acknowledge() {
    let path = path("survives");
    let latch = Latch { estop: true, cause: Cause::HeaterStuckOn };
    let latch = Some(Latched::new(latch, Evidence::of(latch.cause, 12.5, Some(8.0))));
    let mut file = opened(&path);
    assert_eq!(file.stored(), None);
    assert!(file.keeps(None).await);
    assert!(!file.keeps(latch).await, "not kept before it is on disk");
    file.finish().await;
    assert!(file.keeps(latch).await);
    assert_eq!(opened(&path).stored(), latch);
    assert!(!file.keeps(None).await);
    file.finish().await;
    assert_eq!(opened(&path).stored(), None);
}

/// A file cut short, an empty one, other text and other fields: each latches.
#[test]
fn what_cannot_be_read_is_a_latch() {
    let path = path("corrupt");
    let full = serde_json::to_string(&latched(false, Cause::HotendRange)).unwrap();
    for (text, told) in [
        ("", "EOF while parsing a value at line 1 column 0"),
        ("{}", "missing field `estop` at line 1 column 2"),
        ("nonsense", "expected ident at line 1 column 2"),
        (&full[..full.len() - 1], "EOF while parsing an object at line 1 column"),
        ("{\"estop\":false,\"cause\":\"x\"}", "unknown variant `x`"),
        (
            "{\"estop\":false,\"cause\":\"spaghetti\",\"value\":\"x\"}",
            "invalid type: string \"x\", expected f64",
        ),
    ] {
        fs::write(&path, text).unwrap();
        let (file, refused) = LatchFile::open(Some(path.clone()));
        assert_eq!(file.stored(), latched(false, Cause::LatchUnreadable), "{text}");
        let refused = refused.unwrap();
        assert!(refused.starts_with(&format!("{}: {told}", path.display())), "{refused}");
        assert!(refused.ends_with(": taken for a latched SAFE_OFF"), "{refused}");
    }
}

/// An escalation that came no further than beside the record, on a full disk: the emergency stop counts, whichever is read
/// first, and beside one that cannot be read, too. Acknowledged, both are gone.
#[tokio::test]
async fn of_two_records_the_stricter_one_counts() {
    let path = path("two");
    let [stop, estop] = [(false, Cause::HotendRange), (true, Cause::HeaterStuckOn)].map(|(estop, cause)| {
        (serde_json::to_string(&latched(estop, cause)).unwrap(), latched(estop, cause))
    });
    let nonsense = ("nonsense".to_owned(), latched(false, Cause::LatchUnreadable));
    for (first, second, counts) in [
        (&stop, &estop, &estop),
        (&estop, &stop, &estop),
        (&nonsense, &estop, &estop),
        (&nonsense, &stop, &nonsense),
    ] {
        fs::write(&path, &first.0).unwrap();
        fs::write(record::beside(&path), &second.0).unwrap();
        let mut file = opened(&path);
        assert_eq!(file.stored(), counts.1, "{} and {}", first.0, second.0);
        assert!(!file.keeps(None).await);
        file.finish().await;
        assert_eq!(opened(&path).stored(), None, "{} and {}", first.0, second.0);
    }
}

/// With value and limit as they were when the cause was found; a record of a build that did not write them is as good.
#[test]
fn a_record_tells_what_the_latch_rested_on() {
    let path = path("rested");
    for (text, rested) in [
        (
            r#"{"estop":false,"cause":"hotend_range","value":450.25,"limit":285.0}"#,
            Some("450.2 degC, limit 285.0 degC"),
        ),
        (r#"{"estop":false,"cause":"hotend_frozen","value":5.5}"#, Some("5.5 s")),
        (r#"{"estop":true,"cause":"operator_estop"}"#, None),
    ] {
        fs::write(&path, text).unwrap();
        let (file, refused) = LatchFile::open(Some(path.clone()));
        let stored = file.stored().unwrap();
        assert_eq!((stored.evidence().map(|number| number.to_string()).as_deref(), refused), (rested, None));
        let again = Latched::new(stored.latch(), stored.evidence());
        assert_eq!(serde_json::to_string(&again).unwrap(), text);
    }
}

/// Whoever opens a pipe waits for its other end: the supervisor would never begin, or never end.
#[test]
fn what_is_there_and_is_no_file_is_refused_by_its_name() {
    let path = path("pipe");
    let asked = |path: &Path| {
        let node =
            NodePath { qualified: "/printer/safety_supervisor".into(), base: "safety_supervisor".into() };
        let given = [(LATCH_FILE.to_owned(), format!("{path:?}"))];
        path_of(&Parameters::read(&[], &given, &node).unwrap()).map_err(|error| error.to_string())
    };
    assert_eq!(asked(Path::new("")), Ok(None));
    assert_eq!(asked(&path), Ok(Some(path.clone())), "not there yet");
    let folder = path.parent().unwrap();
    let deep = folder.join("not/there/latch.json");
    assert_eq!(asked(&deep), Ok(Some(deep.clone())));
    assert!(deep.parent().unwrap().is_dir(), "a stop needs a place");
    fs::write(folder.join("file"), "").unwrap();
    let refused = asked(&folder.join("file/latch.json")).unwrap_err();
    assert!(
        refused.starts_with(&format!("latch_file: no folder {}/file for it: ", folder.display())),
        "{refused}"
    );
    let must = "must be a file, or not there yet";
    assert_eq!(asked(folder), Err(format!("latch_file: {} is a folder: {must}", folder.display())));
    let pipe = |path: &Path| {
        _ = fs::remove_file(path);
        assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success());
        format!("latch_file: {} is a pipe, socket or device: {must}", path.display())
    };
    let refused = pipe(&path);
    assert_eq!(asked(&path), Err(refused));
    fs::remove_file(&path).unwrap();
    // What is written beside it first is opened as well, and so are mode and pause.
    for other in ["new", "standing.json", "standing.new"] {
        let other = path.with_extension(other);
        let refused = pipe(&other);
        assert_eq!(asked(&path), Err(refused));
        fs::remove_file(&other).unwrap();
    }
    assert_eq!(asked(&path), Ok(Some(path.clone())));
    fs::remove_dir_all(folder).unwrap();
}

#[tokio::test]
async fn a_disk_that_refuses_is_told_and_asked_again() {
    let folder = path("refuses").with_file_name("missing");
    let latch = latched(false, Cause::HotendRange);
    let mut file = opened(&folder.join("latch.json"));
    assert!(!file.keeps(latch).await);
    file.finish().await;
    let failed = file.failed.clone().unwrap();
    assert!(failed.contains("missing/latch.json: No such file"), "{failed}");
    fs::create_dir_all(&folder).unwrap();
    for _ in 0..=REST {
        assert!(!file.keeps(latch).await);
    }
    file.finish().await;
    assert!(file.keeps(latch).await && file.failed.is_none());
    fs::remove_dir_all(&folder).unwrap();
}

/// Told from the start, not with the first stop: where nothing can be written a restart knows of no latch.
#[tokio::test]
async fn a_place_that_takes_nothing_is_told_before_the_first_stop() {
    let mut file = opened(Path::new("/proc/self/latch.json"));
    let failed = file.failed.clone().unwrap();
    assert!(failed.starts_with("/proc/self/latch.json: "), "{failed}");
    for _ in 0..=REST {
        assert!(!file.keeps(None).await);
        file.finish().await;
    }
    assert_eq!(file.failed, Some(failed), "nothing to keep is no proof that it could be kept");
    let path = path("takes");
    assert!(opened(&path).failed.is_none());
    assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 0, "nothing is left of the try");
}

/// Who takes the record away, or writes another one, ends no latch: within a second it is there again.
#[tokio::test]
async fn a_record_that_is_taken_away_is_written_again() {
    let path = path("taken");
    let latch = latched(true, Cause::OperatorEstop);
    let mut file = opened(&path);
    assert!(!file.keeps(latch).await);
    file.finish().await;
    for taken in [None, Some("{}")] {
        match taken {
            None => fs::remove_file(&path).unwrap(),
            Some(text) => fs::write(&path, text).unwrap(),
        }
        for _ in 0..REST {
            assert!(file.keeps(latch).await);
        }
        file.finish().await;
        assert_eq!((opened(&path).stored(), file.failed.as_deref()), (latch, None));
    }
    fs::remove_dir_all(path.parent().unwrap()).unwrap();
}

/// Heaters off is on its way to the disk while the emergency stop comes, and then the end of the process.
#[tokio::test]
async fn the_last_latch_of_a_run_is_kept_whatever_was_being_written() {
    let path = path("last");
    let (off, estop) = (latched(false, Cause::HotendRange), latched(true, Cause::OperatorEstop));
    let mut file = opened(&path);
    assert!(!file.keeps(off).await);
    assert!(!file.keeps(estop).await);
    file.end(estop).await;
    assert_eq!(opened(&path).stored(), estop);
}

/// A full disk takes an empty file and no byte: a restart knows that something was to be kept. What is acknowledged then
/// leaves nothing behind.
#[tokio::test]
async fn a_record_that_was_begun_and_came_no_further_is_a_latch() {
    let path = path("begun");
    let begun = record::beside(&path);
    fs::write(&begun, "").unwrap();
    let (mut file, refused) = LatchFile::open(Some(path.clone()));
    assert_eq!(file.stored(), latched(false, Cause::LatchUnreadable));
    let refused = refused.unwrap();
    assert!(refused.starts_with(&format!("{}: EOF", begun.display())), "{refused}");
    file.end(None).await;
    assert!(file.keeps(None).await && !begun.exists());
    let whole = latched(true, Cause::OperatorEstop);
    fs::write(&begun, serde_json::to_vec(&whole).unwrap()).unwrap();
    assert_eq!(opened(&path).stored(), whole, "it lacked its name alone");
    fs::remove_dir_all(path.parent().unwrap()).unwrap();
}

/// What cannot be written leaves its beginning beside; acknowledged before the disk took it, that goes too.
#[tokio::test]
async fn a_failed_try_is_cleared_away_with_its_acknowledge() {
    let path = path("cleared");
    let begun = record::beside(&path);
    fs::create_dir_all(path.join("in_the_way")).unwrap();
    let mut file = LatchFile::new(Some(path.clone()), None);
    file.keeps(latched(false, Cause::HotendRange)).await;
    file.finish().await;
    assert!(file.failed.is_some() && begun.exists(), "{:?}", file.failed);
    fs::remove_dir_all(&path).unwrap();
    assert!(!file.keeps(None).await, "a restart would latch");
    for _ in 0..=REST {
        file.keeps(None).await;
    }
    file.finish().await;
    assert!(file.keeps(None).await && !begun.exists());
    fs::remove_dir_all(path.parent().unwrap()).unwrap();
}
