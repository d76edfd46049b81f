//! What is found, and what is read of it.

use super::*;
use crate::up::recipes::NODES;
use std::collections::BTreeSet;

/// A copy of the shipped configuration, to be changed.
pub(crate) fn copied(name: &str) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config");
    let folder = std::env::temp_dir().join(format!("fdm_config_{name}_{}", std::process::id()));
    for below in ["", "printers", "plants", "materials", "hosts", "advance", "models"] {
        std::fs::create_dir_all(folder.join(below)).unwrap();
        for entry in std::fs::read_dir(root.join(below)).unwrap().flatten().filter(|it| it.path().is_file()) {
            std::fs::copy(entry.path(), folder.join(below).join(entry.file_name())).unwrap();
        }
    }
    folder
}

/// A folder of changed files alone is no configuration: what to do with it is said, not to give one.
#[test]
fn a_folder_that_lacks_files_is_refused_with_what_to_do() {
    let folder = std::env::temp_dir().join(format!("fdm_config_{}", std::process::id()));
    let refused = ConfigDir::find(Some(&folder)).unwrap_err().to_string();
    let says = [
        &format!("--config {}: no printer_sim.param.yaml in it", folder.display()),
        "copy the folder config/",
    ];
    assert!(says.iter().all(|part| refused.contains(part)), "{refused}");
}

/// YAML 1.1 reads a bare `off` as a boolean.
#[test]
fn corrections_are_off_where_the_file_says_so_without_quotes() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config");
    let config = ConfigDir::find(Some(&root)).unwrap();
    let with = |value: &str| {
        let path = NodePath { qualified: "/printer/mpc_controller".into(), base: "mpc_controller".into() };
        let files = config.files_of("mpc_controller", "PLA");
        let read = Parameters::read(&files, &[("control".into(), value.into())], &path).unwrap();
        let parsed = read.without(&["printer", "material"]).parse::<mpc_controller::Params>();
        parsed.map(|params| params.control).map_err(|error| error.to_string())
    };
    for (value, level) in
        [("off", Level::Off), ("\"off\"", Level::Off), ("false", Level::Off), ("mpc", Level::Mpc)]
    {
        assert_eq!(with(value), Ok(level), "{value}");
    }
    assert!(with("on").unwrap_err().contains("expected off, encoder or mpc"), "{:?}", with("on"));
    assert!(
        with("some").unwrap_err().contains("expected one of `off`, `encoder`, `mpc`"),
        "{:?}",
        with("some")
    );
}

/// Commands that are over before the next one comes would leave the printer alone for half the time.
#[test]
fn a_command_counts_until_the_next_one_comes() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config");
    let config = ConfigDir::find(Some(&root)).unwrap();
    let path = NodePath { qualified: "/printer/mpc_controller".into(), base: "mpc_controller".into() };
    let validity = [("validity_s".to_owned(), "0.2".to_owned())];
    let read = Parameters::read(&config.files_of("mpc_controller", "PLA"), &validity, &path).unwrap();
    let parsed = read.without(&["printer", "material"]).parse::<mpc_controller::Params>();
    assert_eq!(
        parsed.unwrap_err().to_string(),
        "-p validity_s:=0.2: validity_s = 0.2 s: must be in [0.25, 1]"
    );
}

/// Who believes another printer, a learned one say, prints with the same set-points and is scored by the same measure.
#[test]
fn what_is_believed_of_the_printer_moves_no_yardstick() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config");
    let folder = copied("believed");
    let loaded = |folder: &Path| {
        let config = ConfigDir::find(Some(folder)).unwrap();
        let setup = config.load(&Choice::of("PETG".into(), Level::Mpc)).unwrap();
        (
            setup.printer.hotend.coupling_w_k,
            setup.simulated.clone(),
            setup.simulated.set_points(&setup.material),
        )
    };
    let shipped = loaded(&root);
    let file = folder.join("printers/ender3.yaml");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, text.replace("coupling_w_k: 0.45", "coupling_w_k: 0.30")).unwrap();
    let learned = loaded(&folder);
    std::fs::remove_dir_all(&folder).unwrap();
    assert!((learned.0 - 0.30).abs() < 1e-12 && (shipped.0 - 0.45).abs() < 1e-12);
    assert_eq!((learned.1, learned.2), (shipped.1, shipped.2));
}

/// What `ros2 param describe` says: something of every parameter of every node, whatever material and host.
#[test]
fn every_parameter_of_every_node_is_described() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config");
    let config = ConfigDir::find(Some(&root)).unwrap();
    let (mut named, mut undescribed) = (0, BTreeSet::new());
    let mut look = |node: &str, files: &[PathBuf]| {
        let path = NodePath { qualified: format!("/printer/{node}"), base: node.to_owned() };
        let parameters = Parameters::read(files, &[], &path).unwrap();
        named += parameters.text().lines().count();
        undescribed.extend(parameters.undescribed().into_iter().map(|name| format!("{node}: {name}")));
    };
    for material in ["PLA", "PETG", "ABS"] {
        for node in NODES.into_iter().chain(["printer_bridge"]) {
            look(node, &config.files_of(node, material));
        }
    }
    for host in config.names_in("hosts") {
        look("printer_sim", &[config.file(&format!("hosts/{host}.yaml"))]);
    }
    for (node, files) in crate::wire::up::FILES {
        look(node, &files.iter().map(|file| config.file(file)).collect::<Vec<_>>());
    }
    assert!(named > 2500, "{named}");
    assert_eq!(undescribed, BTreeSet::new());
}
