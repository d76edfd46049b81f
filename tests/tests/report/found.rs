//! What was found in a bag beside what it should hold.

use super::print::{Print, USUAL};
use super::section;
use super::writer::{BagFile, folder};
use cli::report::page;
use fdm_loop_msgs::{DiagnosticArray, RosType};

/// A bag of another robot: its topics are named, however usual some of them are; where it was cut, on the page.
#[test]
fn a_bag_of_another_robot_is_refused_with_what_it_holds() {
    let folder = folder("foreign");
    let path = folder.join("foreign_0.mcap");
    let mut file = BagFile::create(&path, false);
    file.bytes("/diagnostics", &DiagnosticArray::DEFINITION.full_name(), 0.0, &[0; 16]);
    // A name that ends as one of ours does.
    file.bytes("/arm/events", "arm_msgs/msg/Event", 0.0, &[0; 8]);
    for number in 0..8 {
        file.bytes(&format!("/wheel_{number}\u{1b}[2J"), "std_msgs/msg/Float64", 0.0, &[0; 8]);
    }
    file.finish();
    let said = page(&folder, None).unwrap_err().to_string();
    assert!(said.contains("no topic of a printer's graph is in this bag; there are"), "{said}");
    assert!(said.contains("/arm/events (arm_msgs/msg/Event)") && said.contains("/diagnostics ("), "{said}");
    assert!(said.contains(", 4 more, see `fdm bag info`"), "{said}");
    assert!(!said.contains('\u{1b}'), "{said:?}");
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() - 20]).unwrap();
    let cut = page(&folder, None).unwrap();
    assert!(cut.contains("This bag is not whole") && cut.contains("arm_msgs/msg/Event"));
}

/// A file of the bag is gone: the recorder's count stands beside what was read, at the top too.
#[test]
fn messages_that_were_recorded_and_are_not_there_are_told() {
    let folder = folder("gone");
    let short = Print { duration_s: 10.0, layers: 1, period_s: 0.2, ..USUAL };
    let mut file = BagFile::create(&folder.join("gone_0.mcap"), true);
    short.write(&mut file);
    let read = file.finish();
    let told = |recorded: u64| {
        let counts = format!("{{\"state\": \"closed\", \"messages\": {recorded}}}");
        std::fs::write(folder.join("counts.json"), counts).unwrap();
        page(&folder, None).unwrap()
    };
    let whole = told(read);
    assert!(section(&whole, "summary").contains(&format!("{read} recorded")));
    assert!(!whole.contains("recorded messages were found"));
    let gone = told(read + 7);
    assert!(gone.contains(&format!("{read} of {} recorded messages were found", read + 7)));
    assert!(section(&gone, "summary").contains(&format!("{read} read, {} recorded", read + 7)));
    // Messages that came since are no loss: the recorder counts finished files.
    let more = told(read - 7);
    assert!(!more.contains("recorded messages were found"));
    assert!(section(&more, "summary").contains(&format!("{read} read, {} recorded", read - 7)));
}
