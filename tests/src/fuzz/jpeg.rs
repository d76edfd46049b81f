//! What a camera sends: the headers of pictures, the stream that they come in, and the address of it.

use super::shipped;
use super::values::Values;
use camera::multipart::{Limits, Part, Reader, boundary};
use camera::params::CameraParams;
use camera::picture::{jpeg_header, png_header};
use camera::url::Url;
use camera::{Frames, Params};
use models::units::Seconds;
use std::sync::LazyLock;

static PARAMS: LazyLock<CameraParams> =
    LazyLock::new(|| shipped::parameters("camera").parse::<Params>().unwrap().camera);

/// The first byte says what it is.
pub fn jpeg(bytes: &[u8]) {
    let mut values = Values::new(bytes);
    match values.below(4) {
        0 => frame(values.rest()),
        1 => {
            if let Ok(header) = png_header(values.rest()) {
                assert!(header.width_px > 0 && header.height_px > 0, "{header:?}");
            }
        }
        2 => stream(values.byte(), values.rest()),
        _ => address(values.rest()),
    }
}

fn frame(bytes: &[u8]) {
    let mut frames = Frames::new(PARAMS.clone());
    let taken = frames.on_frame(Seconds(1.0), Seconds(0.9), bytes);
    match jpeg_header(bytes) {
        Err(_) => assert!(taken.is_err(), "a picture without a header"),
        Ok(header) => {
            assert!(
                header.width_px > 0 && header.height_px > 0 && matches!(header.components, 1 | 3),
                "{header:?}"
            );
            if let Ok(accepted) = taken {
                assert!(accepted.header == header && header.bounded(), "{header:?}");
            }
        }
    }
    assert_eq!(frames.refusals().total(), u64::from(taken.is_err()));
}

/// Pieces of a stream: what is handed over is as long as allowed at most, whatever the stream says of itself.
fn stream(piece: u8, bytes: &[u8]) {
    let limits = Limits { header_bytes: 256, part_bytes: 1024 };
    let mut reader = Reader::new("frame", limits);
    for piece in bytes.chunks(1 + usize::from(piece)) {
        let given_up = reader.push(piece, |part| {
            if let Part::Picture(picture) = part {
                assert!(picture.len() <= limits.part_bytes);
            }
        });
        if given_up.is_err() {
            return;
        }
    }
}

fn address(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Some(boundary) = boundary(text) {
        assert!(!boundary.is_empty() && text.contains(boundary));
    }
    if let Ok(url) = Url::parse(text) {
        // Host and path stand in lines of a request.
        let words = [&url.host, &url.path];
        assert!(
            words.iter().all(|word| !word.is_empty() && word.bytes().all(|byte| byte.is_ascii_graphic())),
            "{url:?}"
        );
        assert!(url.port > 0 && url.path.starts_with('/') && !url.host.contains(['/', '@']), "{url:?}");
    }
}

pub(super) fn seeds() -> Vec<Vec<u8>> {
    let size = [PARAMS.height_px.to_be_bytes(), PARAMS.width_px.to_be_bytes()]
        .map(|side| [side[2], side[3]])
        .concat();
    let head = b"\xff\xd8\xff\xe0\x00\x04ab\xff\xc0\x00\x0b\x08";
    let picture =
        [&head[..], &size, b"\x01\x01\x11\x00\xff\xda\x00\x08\x01\x01\x00\x00\x3f\x00ab\xff\xd9"].concat();
    let mut parts = b"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: 5\r\n\r\nabcde\r\n--frame\r\nContent-Type: image/jpeg\r\n\r\n".to_vec();
    parts.extend(&picture);
    parts.extend(b"\r\n--frame--\r\n");
    let png = b"\x89PNG\r\n\x1a\n\x00\x00\x00\x0dIHDR\x00\x00\x02\x80\x00\x00\x01\xe0\x08\x02\x00\x00\x00";
    let front = |front: &[u8], bytes: &[u8]| [front, bytes].concat();
    vec![
        front(&[0], &picture),
        front(&[1], png),
        front(&[2, 16], &parts),
        front(&[3], b"http://printer.local:8080/webcam/?action=stream"),
        front(&[3], b"http://[fe80::1]/"),
        front(&[3], b"multipart/x-mixed-replace; boundary=\"frame\""),
    ]
}
