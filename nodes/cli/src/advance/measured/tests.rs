//! What is refused, and in which words.

use super::super::tests::setup;
use super::*;

const HEAD: &str = "drive,polymer,temperature_c,height_mm,width_mm,advance_s\n";

fn refused(text: &str) -> String {
    parse(text, &setup().1).unwrap_err().to_string()
}

#[test]
fn measured_lines_are_refused_by_line_and_column() {
    assert_eq!(refused("drive,polymer\n"), "line 1: no column 'temperature_c'; found 'drive', 'polymer'");
    assert_eq!(refused(""), "line 1: no column 'drive'; found none");
    assert_eq!(
        refused("# mine\n\ndrive,polymer\n"),
        "line 3: no column 'temperature_c'; found 'drive', 'polymer'"
    );
    let twice = format!("advance_s,{HEAD}0.6,bowden,PLA,215,0.2,0.4,0.6\n");
    assert_eq!(refused(&twice), "line 1: column 'advance_s' stands there twice");
    assert_eq!(refused(HEAD), "no measured line below line 1");
    // A row cut short is no row with empty cells.
    let error = refused(&format!("{HEAD}# mine\nbowden,PLA,215,0.2\n"));
    assert_eq!(error, "line 3: 4 cells, must be 6 as in line 1");
}

/// Kelvin for degrees Celsius, metres and tenths for millimetres, milliseconds for seconds, the other drive's K.
#[test]
fn a_slip_of_a_unit_is_refused_with_the_range() {
    for (row, error) in [
        ("remote,PLA,215,0.2,0.4,0.6", "drive is 'remote', must be bowden or direct"),
        ("bowden,WOOD,215,0.2,0.4,0.6", "polymer is 'WOOD', must be one of ABS, PETG, PLA"),
        ("bowden,,215,0.2,0.4,0.6", "polymer is '', must be one of ABS, PETG, PLA"),
        ("bowden,PLA,488,0.2,0.4,0.6", "temperature_c is '488', must be a number in [160, 320]"),
        ("bowden,PLA,nan,0.2,0.4,0.6", "temperature_c is 'nan', must be a number in [160, 320]"),
        ("bowden,PLA,215,0.0002,0.4,0.6", "height_mm is '0.0002', must be a number in [0.05, 1]"),
        ("bowden,PLA,215,0.4,0.3,0.6", "height_mm is '0.4', must be at most width_mm, 0.3"),
        ("bowden,PLA,215,0.2,200,0.6", "width_mm is '200', must be a number in [0.15, 2]"),
        (
            "bowden,PLA,215,0.2,0.4,600",
            "advance_s is '600', must be a number in [0.3, 1.5] for a bowden drive",
        ),
        (
            "direct,PLA,215,0.2,0.4,0.6",
            "advance_s is '0.6', must be a number in [0.01, 0.2] for a direct drive",
        ),
    ] {
        assert_eq!(
            refused(&format!("{HEAD}bowden,PLA,215,0.2,0.4,0.6\n{row}\n")),
            format!("line 3: {error}")
        );
    }
}

/// Tables of other programs, and one without a first line of names: what was found, and what it seems to be.
#[test]
fn other_separators_and_missing_names_are_told() {
    let found = "line 1: no column 'drive'; found 'drive;polymer;temperature_c', separated by semicolons: must be commas";
    assert_eq!(refused("drive;polymer;temperature_c\nbowden;PLA;215\n"), found);
    let tabs = refused("drive\tpolymer\nbowden\tPLA\n");
    assert!(tabs.ends_with("found 'drive\\tpolymer', separated by tabs: must be commas"), "{tabs}");
    let nameless = refused("bowden,PLA,215,0.2,0.4,0.6\n");
    assert!(nameless.ends_with("'0.6': the first line must name the columns"), "{nameless}");
}

/// The rows below an open quote would be part of a note.
#[test]
fn an_open_quote_is_refused_by_its_line() {
    let text = "note,drive,polymer,temperature_c,height_mm,width_mm,advance_s\n\
                ok,bowden,PLA,215,0.2,0.4,0.6\n\"dry,bowden,PLA,215,0.2,0.4,0.6\nwet\",bowden,PLA,215,0.2,0.4,0.7\n";
    let error = refused(text);
    assert!(error.starts_with("line 3: the cell 'dry,bowden,PLA,215,0.2,0.4,0.6\\nwet' has"), "{error}");
}

/// All of them in one line, up to ten; what a cell has in it cannot break the message.
#[test]
fn all_rows_that_are_refused_are_told() {
    let row = |polymer: &str| format!("bowden,{polymer},215,0.2,0.4,0.6\n");
    let error = refused(&format!("{HEAD}{}{}{}", row("A\u{1b}[31mB"), row("PLA"), row(&"W".repeat(900))));
    let names = "must be one of ABS, PETG, PLA";
    let long = "W".repeat(40);
    assert_eq!(
        error,
        format!("line 2: polymer is 'A\\u{{1b}}[31mB', {names}; line 4: polymer is '{long}...', {names}")
    );
    let many = refused(&format!("{HEAD}{}", row("WOOD").repeat(13)));
    assert!(many.contains("; line 11: ") && many.ends_with("; and 3 rows more"), "{many}");
}

/// Each line is counted once, whatever stands between: places that rise, and the first row behind each.
#[test]
fn lines_are_counted_once() {
    let text = "a\n#\n\nb\nc\n";
    let mut lines = Lines { text, byte: 0, line: 1 };
    assert_eq!([0, 2, 6, 8].map(|byte| lines.at(byte)), [1, 4, 5, 6]);
    assert_eq!((lines.byte, lines.line), (8, 5));
}

/// Comments, empty lines and the line ends of other systems do not move the line that is named.
#[test]
fn the_line_is_the_files_own() {
    let odd = "bowden,PLA,215,0.2,0.4,-1";
    let sound = "bowden,PLA,215,0.2,0.4,0.6";
    for text in [
        format!("{HEAD}# one\n# two\n\n{sound}\n# three\n\n{odd}\n"),
        format!("# one\r\n\r\n{}\r\n{sound}\r\n{sound}\r\n# two\r\n{odd}\r\n", HEAD.trim()),
        format!("{}\r{}{odd}\r", HEAD.trim(), format!("{sound}\r").repeat(6)),
    ] {
        let expected =
            1 + text.replace("\r\n", "\n").split(['\n', '\r']).position(|line| line == odd).unwrap();
        assert!(refused(&text).starts_with(&format!("line {expected}: advance_s is '-1'")), "{text}");
    }
}

/// Comments, notes, any order of columns, a comma inside of quotes.
#[test]
fn measured_lines_are_read_with_what_a_person_notes() {
    let text = "note,drive,polymer,temperature_c,height_mm,width_mm,advance_s\n# mine\n\n\
                \"dry, new\",Direct, pla ,215,0.2,0.4,0.04\n";
    let at = Condition { temperature: Celsius(215.0), height_m: 2e-4, width_m: 4e-4 };
    let polymer = "PLA".to_owned();
    let wanted = Measured { row: 4, drive: DriveKind::Direct, polymer, at, advance_s: 0.04 };
    assert_eq!(parse(text, &setup().1).unwrap(), [wanted]);
}
