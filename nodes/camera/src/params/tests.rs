//! What a camera's parameters may be.

use super::*;
use runtime::params::NodePath;

#[test]
fn schemes_of_ffmpeg_do_not_pass_as_files() {
    for (text, source) in [
        ("clip.avi", Some(VideoSource::File("clip.avi".into()))),
        ("/tmp/a:b.avi", Some(VideoSource::File("/tmp/a:b.avi".into()))),
        ("/dev/video0", Some(VideoSource::Device("/dev/video0".into()))),
        ("rtsp://cam/1", Some(VideoSource::Rtsp("rtsp://cam/1".into()))),
        ("concat:a|b", None),
        ("http://cam/", None),
        ("img_%03d.jpg", None),
    ] {
        assert_eq!(VideoSource::parse(text), source, "{text}");
    }
}

/// The driver is not started without what it needs, and says what that is.
#[test]
fn a_folder_without_a_name_is_refused_by_its_parameter() {
    let text =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/camera.param.yaml"))
            .unwrap();
    let with = |driver: &str, path: &str| {
        let text = text.replace("driver: printer ", &format!("driver: {driver} "));
        let text = text.replace("path: \"\"", &format!("path: \"{path}\""));
        let file = std::env::temp_dir().join(format!("camera_{driver}_{}.yaml", std::process::id()));
        std::fs::write(&file, text).unwrap();
        let node = NodePath { qualified: "/printer/camera".into(), base: "camera".into() };
        let read = runtime::params::load::<Params>(std::slice::from_ref(&file), &[], &node);
        std::fs::remove_file(file).unwrap();
        read.map(drop).map_err(|error| error.to_string())
    };
    assert_eq!(with("printer", ""), Ok(()));
    assert_eq!(with("folder", "/tmp"), Ok(()));
    let said = with("folder", "").unwrap_err();
    assert!(said.ends_with("folder.path = '': must name a folder, for driver = folder"), "{said}");
}
