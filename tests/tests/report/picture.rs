//! Pictures to put into a bag, and what a screenshot shows.

use std::path::Path;

/// A picture with a blot where `flagged`; padded to `bytes` where that is more.
pub(crate) fn png(width: u32, height: u32, flagged: bool, bytes: usize) -> Vec<u8> {
    let mut pixels = Vec::with_capacity((width * height) as usize);
    for y in 0..height {
        for x in 0..width {
            let blot = flagged && (i64::from(x) - 90).pow(2) + (i64::from(y) - 60).pow(2) < 900;
            pixels.push(if blot { 250 } else { ((x * 5 + y * 3) % 97) as u8 });
        }
    }
    let mut data = Vec::new();
    let mut encoder = png::Encoder::new(&mut data, width, height);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
    // Readers of pictures stop at the end mark.
    data.resize(data.len().max(bytes), 0);
    data
}

/// Size of a screenshot, its number of different colours, and the share of its most common one.
pub(crate) fn colours(path: &Path) -> ((u32, u32), usize, f64) {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut buffer = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut buffer).unwrap();
    let mut counts = std::collections::BTreeMap::<&[u8], usize>::new();
    for pixel in buffer[..info.buffer_size()].chunks(info.color_type.samples()) {
        *counts.entry(pixel).or_default() += 1;
    }
    let all = f64::from(info.width * info.height);
    let most = counts.values().copied().max().unwrap_or(0) as f64;
    ((info.width, info.height), counts.len(), most / all)
}
