//! The drivers for folders and video files, on files that are made here by OpenCV.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use std::fs;
use std::path::{Path, PathBuf};

use camera::frames::BYTES_MAX;
use camera::node::driver::DriverEvent;
use camera::node::folder::Folder;
use camera::node::video::Video;
use camera::params::{CameraParams, FolderParams, VideoParams};
use camera::picture::{Header, jpeg_header};
use opencv::core::{CV_8UC3, Mat, Scalar, Size, Vector};
use opencv::imgcodecs::{imdecode, imencode_def};
use opencv::prelude::*;
use opencv::videoio::{CAP_OPENCV_MJPEG, VideoWriter};
use runtime::Reason;

/// A folder that is taken away at the end.
struct Place(PathBuf);

impl Place {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("camera_{test}_{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        fs::write(self.0.join(name), bytes).unwrap();
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        drop(fs::remove_dir_all(&self.0));
    }
}

fn camera() -> CameraParams {
    serde_saphyr::from_str(
        "{frame: camera_optical, width_px: 96, height_px: 64, scale_m: 5.0e-5, working_distance_m: 0.05, rate_hz: 2.0, \
         rate_max_hz: 30.0, jpeg_quality: 95, stamp_future_max_s: 0.2, stamp_age_max_s: 2.0, lost_after_s: 1.5}",
    )
    .unwrap()
}

/// A picture of one colour: blue `blue`, green 100, red 200.
fn picture(blue: u8) -> Mat {
    Mat::new_size_with_default(Size::new(96, 64), CV_8UC3, Scalar::new(f64::from(blue), 100.0, 200.0, 0.0))
        .unwrap()
}

fn encoded(kind: &str, blue: u8) -> Vec<u8> {
    let mut bytes = Vector::new();
    assert!(imencode_def(kind, &picture(blue), &mut bytes).unwrap());
    bytes.to_vec()
}

/// The blue of the middle of a frame: what was compressed twice may differ by a few steps.
fn blue(jpeg: &[u8]) -> u8 {
    assert_eq!(jpeg_header(jpeg), Ok(Header { width_px: 96, height_px: 64, components: 3 }));
    let picture = imdecode(&Mat::from_slice(jpeg).unwrap(), opencv::imgcodecs::IMREAD_COLOR).unwrap();
    picture.at_2d::<opencv::core::Vec3b>(32, 48).unwrap()[0]
}

fn frame(event: DriverEvent) -> Vec<u8> {
    let DriverEvent::Frame(jpeg) = event else { panic!("{event:?}") };
    jpeg
}

fn folder(place: &Place, repeat: bool) -> Folder {
    Folder::new(FolderParams { path: place.0.display().to_string(), repeat }, &camera())
}

#[test]
fn pictures_come_in_the_order_of_their_names_and_jpegs_untouched() {
    let place = Place::new("folder");
    let jpeg = encoded(".jpg", 10);
    place.write("frame_2.JPG", &jpeg);
    place.write("frame_1.png", &encoded(".png", 60));
    place.write("frame_3.txt", b"no picture");
    let mut folder = folder(&place, true);
    for _ in 0..2 {
        assert!(matches!(folder.next_event(), DriverEvent::Found { text } if text.starts_with("2 pictures")));
        // JPEG at quality 95 keeps a flat colour within 2 steps.
        assert!(blue(&frame(folder.next_event())).abs_diff(60) <= 2);
        assert_eq!(frame(folder.next_event()), jpeg);
    }
    let mut once = self::folder(&place, false);
    let events: Vec<_> = (0..4).map(|_| once.next_event()).collect();
    assert_eq!(events[3], DriverEvent::Ended);
}

/// S9: a picture of 100 MP and a file beyond 4 MiB are refused before a decoder sees them.
#[test]
fn pictures_that_cannot_be_are_passed_over() {
    let place = Place::new("hostile");
    let mut huge = encoded(".png", 1);
    huge[16..24].copy_from_slice(&[0, 0, 0x27, 0x10, 0, 0, 0x27, 0x10]);
    place.write("1.png", &huge);
    place.write("2.png", b"GIF89a");
    let whole = encoded(".png", 1);
    place.write("3.png", &whole[..40]);
    place.write("4.jpg", &vec![0xff; BYTES_MAX + 1]);
    place.write("5.jpg", &encoded(".jpg", 5));
    let mut folder = folder(&place, false);
    assert!(matches!(folder.next_event(), DriverEvent::Found { .. }));
    for reason in [Reason::OutOfRange, Reason::Malformed, Reason::Malformed, Reason::OutOfRange] {
        assert_eq!(folder.next_event(), DriverEvent::Refused(reason));
    }
    assert!(blue(&frame(folder.next_event())).abs_diff(5) <= 2);
}

#[test]
fn a_folder_without_pictures_is_told() {
    let place = Place::new("empty");
    let lost = folder(&place, false).next_event();
    assert!(matches!(&lost, DriverEvent::Lost { reason, .. } if reason.contains("no .jpg")), "{lost:?}");
    let path = place.0.join("not/there").display().to_string();
    let mut gone = Folder::new(FolderParams { path: path.clone(), repeat: false }, &camera());
    let lost = gone.next_event();
    let told = format!("{path}: No such file or directory");
    assert!(matches!(&lost, DriverEvent::Lost { reason, .. } if reason.starts_with(&told)), "{lost:?}");
    // It is looked for again, and found when it is there.
    fs::create_dir_all(&path).unwrap();
    fs::write(Path::new(&path).join("1.jpg"), encoded(".jpg", 7)).unwrap();
    assert!(matches!(gone.next_event(), DriverEvent::Found { text } if text.contains(&path)));
}

fn clip(path: &Path, frames: u8) {
    let codec = VideoWriter::fourcc('M', 'J', 'P', 'G').unwrap();
    let mut writer = VideoWriter::new_with_backend(
        path.to_str().unwrap(),
        CAP_OPENCV_MJPEG,
        codec,
        10.0,
        Size::new(96, 64),
        true,
    )
    .unwrap();
    assert!(writer.is_opened().unwrap());
    for index in 0..frames {
        writer.write(&picture(20 * index)).unwrap();
    }
    writer.release().unwrap();
}

fn video(path: &Path, repeat: bool) -> Video {
    let params: VideoParams = serde_saphyr::from_str(&format!(
        "{{source: {:?}, repeat: {repeat}, retry_min_s: 0.5, retry_max_s: 2.0}}",
        path.display().to_string()
    ))
    .unwrap();
    Video::new(params, camera())
}

#[test]
fn a_video_file_gives_its_frames_and_ends_or_begins_again() {
    let place = Place::new("video");
    let path = place.0.join("clip.avi");
    clip(&path, 5);
    let mut once = video(&path, false);
    assert!(
        matches!(once.next_event(), DriverEvent::Found { text } if text.contains("96x64 px, 10.0 frames"))
    );
    for index in 0..5 {
        // Compressed twice, through 4:2:0: within 4 steps; frames differ by 20.
        assert!(blue(&frame(once.next_event())).abs_diff(20 * index) <= 4, "{index}");
    }
    assert_eq!(once.next_event(), DriverEvent::Ended);
    let mut repeated = video(&path, true);
    let blues: Vec<_> = (0..13)
        .filter_map(|_| match repeated.next_event() {
            DriverEvent::Frame(jpeg) => Some(blue(&jpeg)),
            _ => None,
        })
        .collect();
    assert!(blues.len() == 10 && blues[5].abs_diff(0) <= 4 && blues[9].abs_diff(80) <= 4, "{blues:?}");
}

/// `VideoCapture` answers Ok for what is no video.
#[test]
fn what_is_no_video_is_lost_with_growing_pauses() {
    let place = Place::new("no_video");
    place.write("clip.avi", b"RIFF but no more");
    let mut driver = video(&place.0.join("clip.avi"), true);
    for expected_s in [0.5, 1.0, 2.0, 2.0] {
        let event = driver.next_event();
        let DriverEvent::Lost { retry_s, reason } = &event else { panic!("{event:?}") };
        assert!((retry_s - expected_s).abs() < 1e-12 && reason.contains("cannot be opened"), "{event:?}");
    }
    let missing = video(&place.0.join("none.avi"), false).next_event();
    assert!(
        matches!(&missing, DriverEvent::Lost { reason, .. } if reason.contains("is no file")),
        "{missing:?}"
    );
    let device = video(Path::new("/dev/video_that_is_not_there"), false).next_event();
    assert!(
        matches!(&device, DriverEvent::Lost { reason, .. } if reason.contains("cannot be opened")),
        "{device:?}"
    );
}
