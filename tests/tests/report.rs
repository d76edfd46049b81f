//! The page of `fdm report`: whole, small, escaped, offline, whatever the bag holds.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::expect_used,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "helpers of tests: a failure is the test's failure"
)]

#[path = "report/against.rs"]
mod against;
#[path = "report/browser.rs"]
mod browser;
#[path = "report/ending.rs"]
mod ending;
#[path = "report/found.rs"]
mod found;
#[path = "report/headline.rs"]
mod headline;
#[path = "report/hostile.rs"]
mod hostile;
#[path = "report/messages.rs"]
mod messages;
#[path = "report/phone.rs"]
mod phone;
#[path = "report/picture.rs"]
mod picture;
#[path = "report/print.rs"]
mod print;
#[path = "report/writer.rs"]
mod writer;

use cli::report::page;
use print::{Print, USUAL};
use std::path::PathBuf;
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
    assert!(pictures.contains("<b>impulse</b> at 36.0 s"), "{pictures:.2000}");
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
    assert!(!page.contains("id=\"wall\""), "no wall was built");
}

/// Heights of 2.16 mm a layer, the truth 0.35 mm off: both on the page, each in its place; none where no wall was built.
#[test]
fn a_wall_of_wire_is_shown() {
    let folder = folder("wall");
    let mut file = BagFile::create(&folder.join("wall_0.mcap"), true);
    for (layer, at) in [(0, 0.0), (1, 60.0), (2, 120.0)] {
        let header = fdm_loop_msgs::Header::at(at);
        let height_m = 2.16e-3 * f64::from(layer + 1);
        let measured = fdm_loop_msgs::LayerHeight {
            header: header.clone(),
            layer,
            height_m,
            sigma_m: 1e-4,
            along_m: 0.0,
        };
        file.put(&runtime::topics::LAYER_HEIGHT, at, &measured);
        let truth = fdm_loop_msgs::SimWire {
            header,
            height_m,
            layers_complete: layer + 1,
            layer_rms_m: 3.5e-4,
            rms_m: 3.1e-4,
            ..Default::default()
        };
        file.put(&runtime::topics::SIM_WIRE, at, &truth);
    }
    file.finish();
    let page = page(&folder, None).unwrap();
    let wall = section(&page, "wall");
    let (seen, truth) = wall.split_once("The process was simulated").unwrap();
    assert!(seen.contains("Height of the wall") && !seen.contains("RMS"), "{seen}");
    assert!(
        truth.contains("0.350 mm") && truth.contains("0.310 mm") && truth.contains("<dd>3</dd>"),
        "{truth}"
    );
    assert!(!page.contains("holds no usable message of <code>sensors") && !page.contains(">Hot end</b>"));
    for id in ["temperatures", "slip", "width", "quality", "pictures", "layers", "vibration"] {
        assert!(!page.contains(&format!("<h2 id=\"{id}\"")), "{id}: a wire machine has none");
    }
    assert!(page.contains("<dt>Layers</dt><dd>3<wbr></dd>"), "{}", section(&page, "summary"));
}

/// An hour with a frame of 150 kB each 30 s: the page stays below 3 MB.
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

/// Whom the browser asks of its own accord when a slow machine keeps it open for long.
const BROWSERS_OWN: &str = ".google.com:443";

/// A real browser shows the page in both widths and both colour schemes and asks the network for nothing.
#[test]
fn a_browser_shows_the_page_and_fetches_nothing() {
    let folder = bag("browser", &USUAL);
    let path = folder.join("page.html");
    let text = page(&folder, None).unwrap();
    assert!(
        !text.contains(BROWSERS_OWN),
        "what the page asks for could not be told from what the browser does"
    );
    std::fs::write(&path, text).unwrap();
    for (name, size, dark) in
        [("desk", (1200, 1600), false), ("phone", (500, 1600), false), ("dark", (1200, 1600), true)]
    {
        let picture = folder.join(format!("{name}.png"));
        let mut asked = browser::screenshot(&path, size, dark, &picture);
        asked.retain(|line| !line.contains(BROWSERS_OWN));
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
