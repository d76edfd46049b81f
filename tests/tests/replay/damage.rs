//! Bags that were cut off or damaged: told, and saved as far as they can be read.

use super::{fdm, json, recorded};
use serde_json::Value;
use std::path::PathBuf;

/// A bag cut off in its middle: `fdm bag info` says so, `fdm recover` closes it with every whole record, and again finds
/// nothing to do.
#[test]
fn a_torn_bag_is_told_and_recovered() {
    let bag = recorded("torn");
    let file = |name: &str| PathBuf::from(&bag).join(name);
    let whole = json(&["bag", "info", &bag]);
    assert_eq!((&whole["whole"], &whole["remarks"]), (&true.into(), &serde_json::json!([])), "{whole}");
    // Half of a chunked file: the chunks before the cut are whole.
    let length = std::fs::metadata(file("torn_0.mcap")).unwrap().len();
    std::fs::rename(file("torn_0.mcap"), file("torn_0.mcap.active")).unwrap();
    let active = std::fs::OpenOptions::new().write(true).open(file("torn_0.mcap.active")).unwrap();
    active.set_len(length / 2).unwrap();
    let torn = json(&["bag", "info", &bag]);
    assert_eq!((&torn["whole"], &torn["files"][0]["state"]), (&false.into(), &"active".into()), "{torn}");
    let held = torn["messages"].as_u64().unwrap();
    assert!(held > 1000 && held < whole["messages"].as_u64().unwrap(), "{held}");

    let recovered = json(&["recover", &bag]);
    assert_eq!(
        (&recovered["messages"], &recovered["files"][0]["outcome"]),
        (&held.into(), &"recovered".into())
    );
    let mended = json(&["bag", "info", &bag]);
    assert_eq!((&mended["whole"], &mended["messages"]), (&true.into(), &held.into()), "{mended}");
    assert_eq!(mended["topics"], torn["topics"]);
    assert_eq!(json(&["recover", &bag])["files"][0]["outcome"], "sound");

    // The finished file cut off in turn: what is whole is saved, the rest is kept beside.
    let cut = std::fs::OpenOptions::new().write(true).open(file("torn_0.mcap")).unwrap();
    cut.set_len(cut.metadata().unwrap().len() / 2).unwrap();
    let salvaged = json(&["recover", &bag]);
    let saved = salvaged["messages"].as_u64().unwrap();
    assert!(salvaged["files"][0]["outcome"] == "recovered" && saved > 500 && saved < held, "{salvaged}");
    // How many it had says the bag's description, for the file's own end is gone.
    assert_eq!(salvaged["lost_messages"], held - saved, "{salvaged}");
    assert!(file("torn_0.mcap.torn").is_file());
    assert_eq!(json(&["bag", "info", &bag])["messages"], saved);

    // Cut off once more: what was kept the first time is not replaced.
    let kept = std::fs::metadata(file("torn_0.mcap.torn")).unwrap().len();
    let cut = std::fs::OpenOptions::new().write(true).open(file("torn_0.mcap")).unwrap();
    cut.set_len(cut.metadata().unwrap().len() / 2).unwrap();
    assert!(!fdm(&["recover", &bag]).status.success());
    assert_eq!(std::fs::metadata(file("torn_0.mcap.torn")).unwrap().len(), kept);

    // No bag any more: it is told, and what the folder says of it stands.
    std::fs::write(file("torn_0.mcap"), [0; 1000]).unwrap();
    let before = std::fs::read_to_string(file("metadata.yaml")).unwrap();
    let refused = fdm(&["recover", &bag]);
    assert!(!refused.status.success());
    assert_eq!(std::fs::read(file("torn_0.mcap")).unwrap(), [0; 1000]);
    assert_eq!(std::fs::read_to_string(file("metadata.yaml")).unwrap(), before);
}

/// A place from which 4096 bytes lie within one chunk of messages, as near to the middle of the file as may be: what stands
/// between chunks are indices, whose loss costs no message.
fn amid_a_chunk(bytes: &[u8]) -> usize {
    const CHUNK: u8 = 6;
    let (mut at, mut found) = (8, 0);
    while at + 9 < bytes.len() && (found == 0 || at < bytes.len() / 2) {
        let length = usize::try_from(u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap())).unwrap();
        if bytes[at] == CHUNK && length > 3 * 4096 {
            found = at + 9 + length / 2;
        }
        at += 9 + length;
    }
    assert!(found > 0, "a chunk that is long enough");
    found
}

/// A page of zeros in the middle: `fdm bag info` and `fdm report` go on behind it and say what is missing, `fdm recover`
/// finds it in a file with a sound summary, saves what stands on both sides, and keeps the original.
#[test]
fn a_bag_damaged_in_its_middle_is_told_and_saved_on_both_sides() {
    let bag = recorded("damaged");
    let file = |name: &str| PathBuf::from(&bag).join(name);
    let whole = json(&["bag", "info", &bag]);
    let mut bytes = std::fs::read(file("damaged_0.mcap")).unwrap();
    let at = amid_a_chunk(&bytes);
    bytes[at..at + 4096].fill(0);
    std::fs::write(file("damaged_0.mcap"), &bytes).unwrap();

    let told = json(&["bag", "info", &bag]);
    let number = |value: &Value| value.as_u64().unwrap();
    let lost = number(&told["lost_messages"]);
    assert!(lost > 0 && number(&told["lost_bytes"]) >= 4096, "{told}");
    assert_eq!(number(&told["messages"]) + lost, number(&whole["messages"]));
    // What comes last was read: it stands behind the damage.
    assert_eq!((&told["end_s"], &told["whole"]), (&whole["end_s"], &false.into()));
    assert!(number(&told["messages"]) > number(&whole["messages"]) / 2, "{told}");
    let page = file("../damaged.html").display().to_string();
    assert!(fdm(&["report", &bag, "--out", &page]).status.success());
    let page = std::fs::read_to_string(page).unwrap();
    let stated = number(&whole["files"][0]["messages"]);
    assert!(page.contains(&format!("{lost} of its {stated} messages are lost")), "{page:.4000}");

    let recovered = json(&["recover", &bag]);
    assert_eq!(recovered["files"][0]["outcome"], "recovered", "{recovered}");
    assert_eq!(
        (number(&recovered["messages"]), number(&recovered["lost_messages"])),
        (number(&told["messages"]), lost)
    );
    assert_eq!(std::fs::read(file("damaged_0.mcap.torn")).unwrap(), bytes, "the original");
    let mended = json(&["bag", "info", &bag]);
    assert_eq!((&mended["whole"], &mended["topics"]), (&true.into(), &told["topics"]), "{mended}");
    assert_eq!(json(&["recover", &bag])["files"][0]["outcome"], "sound");
}
