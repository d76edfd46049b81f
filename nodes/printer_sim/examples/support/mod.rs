//! What the examples share: the camera block of `config/`, and grey PNG files.

use printer_sim::camera::{CameraParams, Frame};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

#[derive(Deserialize)]
struct Node {
    #[serde(rename = "ros__parameters")]
    parameters: BTreeMap<String, serde_json::Value>,
}

/// Error of an example.
pub(crate) type Failure = Box<dyn std::error::Error>;

/// The camera of `config/printer_sim.param.yaml`.
pub(crate) fn camera() -> Result<CameraParams, Failure> {
    block("printer_sim.param.yaml", "camera")
}

/// A block of a file of `config/`.
pub(crate) fn block<T: serde::de::DeserializeOwned>(file: &str, name: &str) -> Result<T, Failure> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config").join(file);
    let mut nodes: BTreeMap<String, Node> = serde_saphyr::from_str(&std::fs::read_to_string(path)?)?;
    let value = nodes.get_mut("/**").and_then(|node| node.parameters.remove(name));
    Ok(serde_json::from_value(value.ok_or_else(|| format!("{file}: no block {name}"))?)?)
}

/// A grey PNG without compression: no decoder needs more, and no encoder has to be linked.
pub(crate) fn png(frame: &Frame) -> Vec<u8> {
    let mut raw = Vec::new();
    for row in frame.grey.chunks_exact(frame.width_px) {
        raw.push(0);
        raw.extend_from_slice(row);
    }
    let mut zlib = vec![0x78, 0x01];
    let blocks = raw.chunks(0xffff).count();
    for (number, block) in raw.chunks(0xffff).enumerate() {
        let length = block.len() as u16;
        zlib.push(u8::from(number + 1 == blocks));
        zlib.extend(length.to_le_bytes());
        zlib.extend((!length).to_le_bytes());
        zlib.extend_from_slice(block);
    }
    let (a, b) = raw.iter().fold((1_u32, 0_u32), |(a, b), byte| {
        let a = (a + u32::from(*byte)) % 65_521;
        (a, (b + a) % 65_521)
    });
    zlib.extend((b << 16 | a).to_be_bytes());
    let mut png = vec![0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1a, b'\n'];
    let mut header = Vec::new();
    header.extend((frame.width_px as u32).to_be_bytes());
    header.extend((frame.height_px as u32).to_be_bytes());
    header.extend([8, 0, 0, 0, 0]);
    chunk(&mut png, *b"IHDR", &header);
    chunk(&mut png, *b"IDAT", &zlib);
    chunk(&mut png, *b"IEND", &[]);
    png
}

fn chunk(png: &mut Vec<u8>, name: [u8; 4], data: &[u8]) {
    png.extend((data.len() as u32).to_be_bytes());
    let from = png.len();
    png.extend(name);
    png.extend_from_slice(data);
    let crc = png[from..].iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(
            crc ^ u32::from(*byte),
            |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 },
        )
    });
    png.extend((!crc).to_be_bytes());
}

/// Frames of one size beside each other, `columns` to a row.
#[allow(dead_code, reason = "not every example shows sheets")]
pub(crate) fn sheet(frames: &[Frame], columns: usize) -> Frame {
    let Some(first) = frames.first() else { return Frame { width_px: 0, height_px: 0, grey: Vec::new() } };
    let (width, height) = (first.width_px, first.height_px);
    let rows = frames.len().div_ceil(columns);
    let mut grey = vec![0; columns * width * rows * height];
    for (number, frame) in frames.iter().enumerate() {
        for (y, row) in frame.grey.chunks_exact(width).enumerate() {
            let at = ((number / columns * height + y) * columns + number % columns) * width;
            grey[at..at + width].copy_from_slice(row);
        }
    }
    Frame { width_px: columns * width, height_px: rows * height, grey }
}
