//! The page of `fdm report`: whole, small, escaped, offline, whatever the bag holds.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::expect_used,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "helpers of tests: a failure is the test's failure"
)]

#[path = "report/browser.rs"]
mod browser;
#[path = "report/picture.rs"]
mod picture;
#[path = "report/print.rs"]
mod print;
#[path = "report/writer.rs"]
mod writer;

use cli::report::page;
use fdm_loop_msgs::RosType;
use print::{Print, USUAL};
use proptest::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use writer::{BagFile, folder};

/// A finished bag with a print in it.
fn bag(name: &str, print: &Print) -> PathBuf {
    let folder = folder(name);
    let mut file = BagFile::create(&folder.join(format!("{name}_0.mcap")), true);
    print.write(&mut file);
    file.finish();
    folder
}

/// Titles of the sections.
const SECTIONS: [&str; 15] = [
    "summary",
    "events",
    "temperatures",
    "slip",
    "width",
    "commands",
    "quality",
    "confidence",
    "pictures",
    "layers",
    "consistency",
    "vibration",
    "truth",
    "recorder",
    "diagnostics",
];

/// Content of a section.
fn section<'a>(page: &'a str, id: &str) -> &'a str {
    let start = page.find(&format!("<h2 id=\"{id}\"")).unwrap_or_else(|| panic!("no section {id}"));
    let rest = &page[start..];
    rest[4..].find("<h2 ").map_or(rest, |end| &rest[..end])
}

/// Nothing is fetched and nothing runs.
fn is_self_contained(page: &str) {
    for word in
        ["<script", "http://", "https://", "url(", "@import", "<link rel=\"stylesheet", "srcset", "<iframe"]
    {
        assert!(!page.replace("http://www.w3.org/2000/svg", "").contains(word), "{word}");
    }
    assert!(page.contains("default-src 'none'") && page.contains("width=device-width"));
}

#[test]
fn a_whole_bag_fills_every_section() {
    let page = page(&bag("whole", &USUAL), None).unwrap();
    is_self_contained(&page);
    for id in SECTIONS {
        let section = section(&page, id);
        assert!(!section.contains("holds no usable message"), "{id}: {section:.300}");
    }
    for id in [
        "temperatures",
        "slip",
        "width",
        "commands",
        "quality",
        "confidence",
        "consistency",
        "vibration",
        "truth",
    ] {
        assert!(section(&page, id).contains("<svg"), "{id} has no plot");
    }
    assert!(!page.contains("This bag is not whole"));
    assert!(
        page.contains("square.gcode") && page.contains("PLA") && page.contains("P9: spaghetti, no way back")
    );
    // The paused print, its cause, and what a person has to do.
    assert!(page.contains("<b>Paused</b> at 100 %, and not gone on. P9: spaghetti"));
    assert!(page.contains("clear the bed"));
    let pictures = section(&page, "pictures");
    assert!(pictures.contains("<b>spaghetti</b> at 1:24 min"), "the first flagged frame: 0.7 of 120 s");
    assert!(pictures.contains("<b>degraded → paused</b> at 1:48 min"), "{pictures:.2000}");
    // The truth stands in its own section and nowhere before it.
    let (before, _) = page.split_once("<h2 id=\"truth\"").unwrap();
    assert!(!before.contains("true slip") && !before.contains("Feed error"));
}

#[test]
fn absent_topics_are_said_in_their_place() {
    let folder = folder("absent");
    let mut file = BagFile::create(&folder.join("absent_0.mcap"), true);
    let reading = fdm_loop_msgs::Temperature { temperature: 20.0, ..Default::default() };
    file.put(&runtime::topics::HOTEND_TEMPERATURE, 0.0, &reading);
    file.finish();
    let page = page(&folder, None).unwrap();
    for (id, topic) in [
        ("events", "events"),
        ("slip", "estimate/state"),
        ("width", "vision/bead_width"),
        ("quality", "quality/layer"),
        ("confidence", "vision/defects"),
        ("pictures", "vision/annotated/compressed"),
        ("layers", "printer/motion"),
        ("vibration", "sensors/imu/batch"),
        ("diagnostics", "/diagnostics"),
    ] {
        assert!(section(&page, id).contains(&format!("<code>{topic}</code>")), "{id}");
    }
    assert!(!page.contains("id=\"truth\""), "a real printer has no simulated truth");
}

/// An hour with a frame of 150 kB each 10 s: the page stays below 3 MB.
#[test]
fn an_hour_fits_into_three_megabytes() {
    let hour = Print {
        duration_s: 3600.0,
        layers: 150,
        period_s: 0.25,
        frame_s: 2.0,
        frame_bytes: 150_000,
        ..USUAL
    };
    let page = page(&bag("hour", &hour), None).unwrap();
    assert!(page.len() < 3_000_000, "{} bytes", page.len());
    assert!(page.len() > 500_000, "{} bytes: are plots and pictures there?", page.len());
    is_self_contained(&page);
}

/// Where a kill, a full disk or a broken stick cut the file: what is there is shown, and the cut is said.
#[test]
fn a_bag_cut_anywhere_gives_a_report_that_says_so() {
    let folder = folder("cut");
    let short = Print { duration_s: 20.0, layers: 2, period_s: 0.2, ..USUAL };
    for chunked in [false, true] {
        let whole = folder.join(format!("whole_{chunked}.mcap"));
        let mut file = BagFile::create(&whole, chunked);
        short.write(&mut file);
        if chunked {
            file.finish()
        } else {
            file.kill()
        };
        let bytes = std::fs::read(&whole).unwrap();
        for part in 0..20 {
            let cut = folder.join(format!("cut_{part}.mcap.active"));
            let length = bytes.len() * part / 20;
            std::fs::write(&cut, &bytes[..length]).unwrap();
            let page = page(&cut, None).unwrap();
            assert!(page.contains("This bag is not whole"), "{length} of {} bytes", bytes.len());
            assert_eq!(std::fs::read(&cut).unwrap(), &bytes[..length], "the bag was changed");
            if !chunked && part > 15 {
                assert!(section(&page, "temperatures").contains("<svg"), "{length} bytes hold temperatures");
            }
        }
    }
}

/// A recorder that still writes: the finished file and the active one are one bag.
#[test]
fn a_bag_that_is_being_written_is_read_to_its_last_record() {
    let folder = folder("active");
    let short = Print { duration_s: 10.0, layers: 1, period_s: 0.2, ..USUAL };
    let mut finished = BagFile::create(&folder.join("active_0.mcap"), true);
    short.write(&mut finished);
    let mut active = BagFile::create(&folder.join("active_1.mcap.active"), false);
    short.write(&mut active);
    let messages = finished.finish() + active.kill();
    let page = page(&folder, None).unwrap();
    assert!(page.contains(&format!("{messages} messages were read")), "{}", section(&page, "recorder"));
    assert!(page.contains("active_1.mcap.active ends in a whole record, but was never closed"));
}

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

/// A small bag for the fuzzing below.
fn small() -> Vec<u8> {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    let made = || {
        let path = folder("small").join("small_0.mcap");
        let mut file = BagFile::create(&path, false);
        Print { duration_s: 2.0, layers: 2, period_s: 0.5, ..USUAL }.write(&mut file);
        file.finish();
        std::fs::read(path).unwrap()
    };
    BYTES.get_or_init(made).clone()
}

fn page_of(bytes: &[u8], name: &str) -> String {
    let path = folder(name).join("x.mcap");
    std::fs::write(&path, bytes).unwrap();
    page(&path, None).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// Bytes changed anywhere: records, lengths, channels, floats. There is a page all the same, without markup of the
    /// bag's.
    #[test]
    fn a_bag_with_any_bytes_changed_gives_a_page(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..40),
    ) {
        let mut bytes = small();
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        is_self_contained(&page_of(&bytes, "changed"));
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
    assert!(page(Path::new("/nowhere"), None).is_err());
    assert!(page(&folder("nothing"), None).is_err());
}

/// A real browser shows the page in both widths and both colour schemes and asks the network for nothing.
#[test]
fn a_browser_shows_the_page_and_fetches_nothing() {
    let folder = bag("browser", &USUAL);
    let path = folder.join("page.html");
    std::fs::write(&path, page(&folder, None).unwrap()).unwrap();
    for (name, size, dark) in
        [("desk", (1200, 1600), false), ("phone", (500, 1600), false), ("dark", (1200, 1600), true)]
    {
        let picture = folder.join(format!("{name}.png"));
        let asked = browser::screenshot(&path, size, dark, &picture);
        assert_eq!(asked, [""; 0], "requests to the network");
        let (seen, colours, most) = picture::colours(&picture);
        assert_eq!(seen, size);
        // A page of text and plots on a plain ground: letters are smoothed, so there are many colours.
        assert!(colours > 100, "{name}: {colours} colours");
        assert!((0.3..0.98).contains(&most), "{name}: {most} of one colour");
    }
}

/// The proxy sees what a page fetches: the test above can fail.
#[test]
fn a_page_that_fetches_is_found_out() {
    let folder = folder("fetches");
    let path = folder.join("page.html");
    std::fs::write(&path, "<img src=\"http://example.invalid/x.png\">").unwrap();
    let asked = browser::screenshot(&path, (500, 500), false, &folder.join("page.png"));
    assert!(asked.iter().any(|line| line.contains("example.invalid/x.png")), "{asked:?}");
}
