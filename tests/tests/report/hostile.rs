//! Bags that nobody in his right mind writes.

use super::print::{Print, USUAL};
use super::writer::{BagFile, folder};
use super::{bag, is_self_contained, section};
use cli::report::page;
use fdm_loop_msgs::RosType;
use proptest::prelude::*;
use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;

#[test]
fn text_of_a_bag_never_becomes_markup() {
    let evil = "</style></title><script>alert(1)</script><img src=x onerror='a()'>\"'&\u{202e}\u{0}";
    let page = page(&bag("evil", &Print { text: evil, duration_s: 20.0, ..USUAL }), None).unwrap();
    is_self_contained(&page);
    assert!(!page.contains("<img src=x"));
    assert!(page.contains("&lt;script&gt;alert(1)"), "the text is shown, escaped");
    assert_eq!(page.matches("</style>").count(), 1);
}

#[test]
fn numbers_that_are_none_are_counted_and_never_drawn() {
    for number in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN, 1e300] {
        let page = page(&bag("numbers", &Print { number, duration_s: 20.0, ..USUAL }), None).unwrap();
        let (_, body) = page.split_once("<body>").unwrap();
        let body = body.replace("info", "").replace("infill", "");
        for word in ["NaN", "inf"] {
            let place = body.find(word).map(|at| &body[at.saturating_sub(60)..at]);
            assert_eq!(place, None, "{number}: {word}");
        }
        assert!(section(&page, "summary").contains("square.gcode"));
    }
}

/// The name of a known topic over bytes of another type, and channels of any number.
#[test]
fn wrong_types_and_thousands_of_topics_are_told_apart() {
    let folder = folder("wrong");
    let mut file = BagFile::create(&folder.join("wrong_0.mcap"), false);
    file.bytes("/printer/printer/state", "sensor_msgs/msg/Temperature", 0.0, &[7; 40]);
    file.bytes("/printer/estimate/state", "fdm_loop_msgs/msg/StateEstimate", 0.0, &[255; 60]);
    for number in 0..2000 {
        file.bytes(&format!("/x{number}/y"), "a/msg/B", 0.0, b"");
    }
    file.finish();
    let page = page(&folder, None).unwrap();
    assert!(
        page.contains("2002 messages were read, 2 of them could not be decoded"),
        "{}",
        section(&page, "recorder")
    );
    assert!(page.len() < 500_000);
}

/// Bytes at the beginning that make a bag of a file.
const MAGIC: usize = 8;

/// A small bag for the fuzzing below.
fn small(chunked: bool) -> Vec<u8> {
    static BYTES: [OnceLock<Vec<u8>>; 2] = [const { OnceLock::new() }; 2];
    let made = || {
        let path = folder(&format!("small_{chunked}")).join("small_0.mcap");
        let mut file = BagFile::create(&path, chunked);
        Print { duration_s: 2.0, layers: 2, period_s: 0.5, ..USUAL }.write(&mut file);
        file.finish();
        std::fs::read(path).unwrap()
    };
    BYTES[usize::from(chunked)].get_or_init(made).clone()
}

/// Length of the data that the checksum of a closed file is of: up to the record that ends them, 13 bytes before the
/// summary, of which the footer says where it begins; the footer's 20 bytes and 8 of magic close the file.
fn data_of(bytes: &[u8]) -> usize {
    let at = bytes.len() - 28;
    usize::try_from(u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap())).unwrap() - 13
}

/// Lengths that claim 4 GB: of the record, and of a text in each kind of record that has one. Nothing is set aside for
/// them: the command, held to an address space of 4 GB, makes a page of the last of them.
#[test]
fn a_length_of_four_gigabytes_breaks_the_bag_alone() {
    let whole = small(false);
    let huge = 0xff00_0000_u32.to_le_bytes();
    let mut at = MAGIC;
    while at + 9 < whole.len() - 37 {
        let length = u64::from_le_bytes(whole[at + 1..at + 9].try_into().unwrap()) as usize;
        let first_text = match whole[at] {
            1 | 12 => Some(0),
            3 => Some(2),
            4 => Some(4),
            _ => None,
        };
        for place in [Some(at + 1), first_text.map(|text| at + 9 + text)].into_iter().flatten() {
            let mut bytes = whole.clone();
            bytes[place..place + 4].copy_from_slice(&huge);
            assert!(page_of(&bytes, "huge").contains("This bag is not whole"), "byte {place}");
        }
        at += 9 + length;
        if whole[at] == 5 {
            break;
        }
    }
    let place = folder("huge_page");
    let page = place.join("page.html");
    let bag = folder("huge").with_extension("mcap");
    let schema = whole.windows(11).position(|bytes| bytes[0] == 3 && bytes[3..9] == [0; 6]).unwrap();
    let mut bytes = whole;
    bytes[schema + 11..schema + 15].copy_from_slice(&huge);
    std::fs::write(&bag, bytes).unwrap();
    let fdm = std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("fdm");
    assert!(fdm.is_file(), "{} is missing: cargo build --workspace --bins", fdm.display());
    let held = Command::new("sh")
        .args(["-c", "ulimit -v 4000000; exec \"$0\" report \"$1\" --out \"$2\""])
        .args([&fdm, &bag, &page])
        .output()
        .unwrap();
    assert!(held.status.success() && page.is_file(), "{}", String::from_utf8_lossy(&held.stderr));
}

fn page_of(bytes: &[u8], name: &str) -> String {
    let path = folder(name).join("x.mcap");
    std::fs::write(&path, bytes).unwrap();
    page(&path, None).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// Bytes changed anywhere: records, lengths, channels, floats, in chunks or not. There is a page all the same, without
    /// markup of the bag's; it says so wherever the data are not those that were written.
    #[test]
    fn a_bag_with_any_bytes_changed_gives_a_page_that_says_so(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..40),
        chunked in any::<bool>(),
    ) {
        let whole = small(chunked);
        let (mut bytes, data) = (whole.clone(), data_of(&whole));
        for (at, byte) in changes {
            let at = MAGIC + at.index(bytes.len() - MAGIC);
            bytes[at] = byte;
        }
        let page = page_of(&bytes, "changed");
        is_self_contained(&page);
        prop_assert!(bytes[..data] == whole[..data] || page.contains("This bag is not whole"));
    }

    /// Any payload under any declared type.
    #[test]
    fn any_payload_gives_a_page(body in prop::collection::vec(any::<u8>(), 0..600), which in 0..6_usize) {
        let folder = folder("payload");
        let mut file = BagFile::create(&folder.join("payload_0.mcap"), false);
        let names = [
            ("/printer/printer/state", fdm_loop_msgs::PrinterState::DEFINITION),
            ("/printer/estimate/state", fdm_loop_msgs::StateEstimate::DEFINITION),
            ("/printer/printer/motion", fdm_loop_msgs::MotionSegment::DEFINITION),
            ("/printer/vision/defects", fdm_loop_msgs::DefectReport::DEFINITION),
            ("/printer/sensors/imu/batch", fdm_loop_msgs::ImuBatch::DEFINITION),
            ("/diagnostics", fdm_loop_msgs::DiagnosticArray::DEFINITION),
        ];
        let (topic, definition) = names[which];
        // A bag without any topic of a printer's has no page.
        file.bytes(names[0].0, &names[0].1.full_name(), 0.0, &body);
        for _ in 0..3 {
            file.bytes(topic, &definition.full_name(), 0.0, &body);
        }
        file.finish();
        is_self_contained(&page(&folder, None).unwrap());
    }
}

#[test]
fn bytes_that_are_no_bag_give_a_page_and_no_file_an_error() {
    assert!(page_of(b"", "empty").contains("no message could be read"));
    assert!(
        page_of(&[0x89, b'M', b'C', b'A', b'P', b'0', b'\r', b'\n', 5, 255, 255, 255], "head")
            .contains("not whole")
    );
    for text in ["solid x\n", "%YAML 1.2\n", "\u{89}MCAP1"] {
        let path = folder("text").join("x.mcap");
        std::fs::write(&path, text).unwrap();
        assert!(page(&path, None).unwrap_err().to_string().contains("no bag"), "{text}");
    }
    assert!(page(Path::new("/nowhere"), None).is_err());
    assert!(page(&folder("nothing"), None).is_err());
}
