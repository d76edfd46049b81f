//! A latch on disk.

use super::*;

fn path(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("latch_{}_{name}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    folder.join("latch.json")
}

#[tokio::test]
async fn a_latch_survives_a_restart_and_ends_with_its_acknowledge() {
    let path = path("survives");
    let latch = Some(Latch { estop: true, cause: Cause::HeaterStuckOn });
    let mut file = LatchFile::open(Some(path.clone()));
    assert_eq!(file.stored(), None);
    assert!(file.keeps(None).await);
    assert!(!file.keeps(latch).await, "not kept before it is on disk");
    file.finish().await;
    assert!(file.keeps(latch).await);
    assert_eq!(LatchFile::open(Some(path.clone())).stored(), latch);
    assert!(!file.keeps(None).await);
    file.finish().await;
    assert_eq!(LatchFile::open(Some(path)).stored(), None);
}

/// A file cut short, an empty one, other text and other fields: each latches.
#[test]
fn what_cannot_be_read_is_a_latch() {
    let path = path("corrupt");
    let full = serde_json::to_string(&Latch { estop: false, cause: Cause::HotendRange }).unwrap();
    for text in ["", "{}", "nonsense", &full[..full.len() - 1], "{\"estop\":false,\"cause\":\"x\"}"] {
        fs::write(&path, text).unwrap();
        let latch = LatchFile::open(Some(path.clone())).stored().unwrap();
        assert_eq!((latch.estop, latch.cause), (false, Cause::LatchUnreadable), "{text}");
    }
    let folder = LatchFile::open(path.parent().map(Path::to_path_buf)).stored();
    assert!(folder.is_some(), "a folder is no record either");
}

#[tokio::test]
async fn a_disk_that_refuses_is_told_and_asked_again() {
    let folder = path("refuses").with_file_name("missing");
    let latch = Some(Latch { estop: false, cause: Cause::HotendRange });
    let mut file = LatchFile::open(Some(folder.join("latch.json")));
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

/// Heaters off is on its way to the disk while the emergency stop comes, and then the end of the process.
#[tokio::test]
async fn the_last_latch_of_a_run_is_kept_whatever_was_being_written() {
    let path = path("last");
    let (off, estop) = (
        Latch { estop: false, cause: Cause::HotendRange },
        Latch { estop: true, cause: Cause::OperatorEstop },
    );
    let mut file = LatchFile::open(Some(path.clone()));
    assert!(!file.keeps(Some(off)).await);
    assert!(!file.keeps(Some(estop)).await);
    file.end(Some(estop)).await;
    assert_eq!(LatchFile::open(Some(path)).stored(), Some(estop));
}
