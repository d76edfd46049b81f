//! What the commands share.

use super::*;

pub(super) fn setup() -> (ConfigDir, Setup) {
    let folder = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config"));
    let config = ConfigDir::find(Some(folder)).unwrap();
    let setup = Setup::load(&config).unwrap();
    (config, setup)
}

/// An empty folder of one test.
pub(super) fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("fdm_advance_{name}_{}", std::process::id()));
    _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Metres for millimetres, no number, another scale of temperature, a polymer that nobody knows.
#[test]
fn options_are_refused_by_name_value_and_range() {
    let (_, setup) = setup();
    let sound = Place { temperature: 215.0, height: 0.2, width: 0.4 };
    let refused = |polymer: &str, place: Place| setup.check(polymer, &place).unwrap_err().to_string();
    assert!(setup.check("PLA", &sound).is_ok());
    let error = refused("WOOD", sound);
    assert_eq!(error, "--polymer WOOD: must be one of ABS, PETG, PLA");
    let error = refused("PLA", Place { temperature: 488.15, ..sound });
    assert_eq!(error, "--temperature 488.15 degC: must be in [160, 320] degC");
    let error = refused("PLA", Place { height: 2e-4, ..sound });
    assert_eq!(error, "--height 0.0002 mm: must be in [0.05, 1] mm");
    let error = refused("PLA", Place { width: f64::NAN, ..sound });
    assert_eq!(error, "--width NaN mm: must be in [0.15, 2] mm");
    let error = refused("PLA", Place { height: 0.4, width: 0.3, ..sound });
    assert_eq!(error, "--height 0.4 mm: must be at most the line's width, 0.3 mm");
    assert!(setup.check("PLA", &Place { height: 0.4, ..sound }).is_ok());
}

/// Neither a file that is read nor a network that training is about to make is replaced by figures.
#[test]
fn an_output_takes_no_place_of_what_is_read() {
    let (config, _) = setup();
    let folder = folder("apart");
    let refused =
        |output: &Path, models: Option<&Path>| Setup::check_apart(Some(output), &config, models).is_err();
    for name in READ.into_iter().chain(["models/turn.json"]) {
        assert!(refused(&config.file(name), None), "{name}");
    }
    for name in NETWORKS {
        assert!(refused(&folder.join(name), Some(&folder)), "{name}");
        assert!(!refused(&folder.join(name), None), "{name}");
    }
    assert!(!refused(&folder.join("figures.json"), Some(&folder)));
    assert!(!refused(Path::new("-"), None));
    std::fs::remove_dir_all(&folder).unwrap();
}
