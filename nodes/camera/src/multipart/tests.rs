use super::*;
use proptest::prelude::*;

const LIMITS: Limits = Limits { header_bytes: 200, part_bytes: 1000 };

#[derive(Debug, Clone, PartialEq, Eq)]
enum Found {
    Picture(Vec<u8>),
    Refused(PartError),
}

/// Everything found in bytes that come in pieces, and how the stream ended.
fn read(pieces: &[&[u8]]) -> (Vec<Found>, Option<StreamError>) {
    let (mut reader, mut found) = (Reader::new("frame", LIMITS), Vec::new());
    for piece in pieces {
        let pushed = reader.push(piece, |part| {
            found.push(match part {
                Part::Picture(bytes) => Found::Picture(bytes.to_vec()),
                Part::Refused(error) => Found::Refused(error),
            });
        });
        if let Err(error) = pushed {
            return (found, Some(error));
        }
    }
    (found, None)
}

fn part(header: &str, body: &str) -> String {
    format!("--frame\r\nContent-Type: image/jpeg\r\n{header}\r\n{body}\r\n")
}

fn picture(body: &str) -> Found {
    Found::Picture(body.as_bytes().to_vec())
}

#[test]
fn a_part_of_known_length_is_handed_over_with_its_last_byte() {
    let stream = part("Content-Length: 5\r\n", "hello");
    let body_end = stream.len() - 2;
    assert_eq!(read(&[&stream.as_bytes()[..body_end - 1]]).0, []);
    assert_eq!(read(&[&stream.as_bytes()[..body_end]]).0, [picture("hello")]);
}

#[test]
fn a_part_of_unknown_length_ends_at_the_next_boundary() {
    let stream = part("", "hel\r\nlo") + &part("", "-- frame");
    assert_eq!(read(&[stream.as_bytes()]).0, [picture("hel\r\nlo")]);
    let stream = stream + "--frame";
    assert_eq!(read(&[stream.as_bytes()]).0, [picture("hel\r\nlo"), picture("-- frame")]);
}

#[test]
fn servers_differ_in_line_ends_dashes_and_the_case_of_names() {
    let text = "junk before\n--frame\ncontent-type:image/jpeg;q=1\nCONTENT-LENGTH:2\n\nab--frame\n";
    assert_eq!(read(&[text.as_bytes()]).0, [picture("ab")]);
    // The boundary of the answer's head may hold the dashes: --frame, or ----frame in the body.
    let mut reader = Reader::new("--frame", LIMITS);
    let mut found = 0;
    reader
        .push(b"----frame\r\nContent-Type: image/jpeg\r\nContent-Length: 1\r\n\r\nx", |_| found += 1)
        .unwrap();
    assert_eq!(found, 1);
}

#[test]
fn a_bad_part_is_told_and_the_next_one_is_read() {
    let next = part("Content-Length: 2\r\n", "ok");
    for (bad, error) in [
        (part("Content-Length: 60\r\n", "short"), PartError::CutOff),
        (part("Content-Length: 1001\r\n", "long"), PartError::TooLong),
        (part("Content-Length: -1\r\n", "x"), PartError::Length),
        (part("Content-Length: 99999999999999999999\r\n", "x"), PartError::Length),
        (part("", &"x".repeat(1100)), PartError::TooLong),
        ("--frame\r\nContent-Type: text/html\r\n\r\nno\r\n".to_owned(), PartError::Content),
        ("--frame\r\n\r\nno type\r\n".to_owned(), PartError::Content),
    ] {
        let stream = bad + &next;
        let (found, ended) = read(&[stream.as_bytes()]);
        assert_eq!((found, ended), (vec![Found::Refused(error), picture("ok")], None));
    }
}

#[test]
fn a_stream_without_an_order_is_given_up() {
    let huge = format!("--frame\r\nX: {}", "a".repeat(300));
    assert_eq!(read(&[huge.as_bytes()]).1, Some(StreamError::Header));
    let line = format!("--frame{}", "a".repeat(300));
    assert_eq!(read(&[line.as_bytes()]).1, Some(StreamError::Header));
    assert_eq!(read(&["x".repeat(1200).as_bytes()]).1, Some(StreamError::Boundary));
    assert_eq!(read(&[b"--frame--"]).1, Some(StreamError::Ended));
}

#[test]
fn the_boundary_stands_in_the_content_type() {
    assert_eq!(boundary("multipart/x-mixed-replace; boundary=frame"), Some("frame"));
    assert_eq!(boundary("Multipart/X-Mixed-Replace;a=b; Boundary=\"--f r\""), Some("--f r"));
    for none in [
        "image/jpeg",
        "multipart/mixed; boundary=x",
        "multipart/x-mixed-replace",
        "multipart/x-mixed-replace; boundary=--",
    ] {
        assert_eq!(boundary(none), None);
    }
}

proptest! {
    /// However the bytes are cut, the parts are the same, and no more is held than the limits allow.
    #[test]
    fn any_bytes_in_any_pieces_give_the_same_parts(
        words in proptest::collection::vec(
            prop_oneof![
                Just("--frame".to_owned()), Just("\r\n".to_owned()), Just("Content-Type: image/jpeg\r\n".to_owned()),
                Just("Content-Length: 3\r\n\r\n".to_owned()), Just("Content-Length: 700\r\n\r\n".to_owned()), ".{0,30}",
            ], 0..60),
        cut in 1usize..40,
    ) {
        let stream = words.concat();
        let pieces: Vec<&[u8]> = stream.as_bytes().chunks(cut).collect();
        let (whole, cut) = (read(&[stream.as_bytes()]), read(&pieces));
        prop_assert_eq!(whole.1.is_some(), cut.1.is_some());
        prop_assert_eq!(whole.0, cut.0);
        let mut reader = Reader::new("frame", LIMITS);
        for piece in pieces {
            if reader.push(piece, |_| {}).is_err() { break }
            prop_assert!(reader.buffer.len() <= LIMITS.part_bytes + 40);
        }
    }
}
