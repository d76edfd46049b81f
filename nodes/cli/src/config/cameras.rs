//! What a pixel is: who renders frames, who passes them on and who measures in them have to mean the same.

use super::ConfigDir;
use anyhow::bail;
use runtime::params::{NodePath, Parameters};
use serde::de::DeserializeOwned;

/// A number of a camera as one node's file has it.
struct Said {
    node: &'static str,
    field: &'static str,
    value: f64,
    unit: &'static str,
}

impl ConfigDir {
    /// Refuses cameras of which the nodes' files know different sizes or scales: widths would be measured wrong by their
    /// ratio, and sound roads taken for thin or thick ones.
    ///
    /// # Errors
    /// Both files, fields and values; file, line and field of what cannot be read.
    pub fn check_cameras(&self, material: &str) -> anyhow::Result<()> {
        let rendered: printer_sim::camera::CameraParams = self.camera_of("printer_sim", material)?;
        let passed: camera::params::CameraParams = self.camera_of("camera", material)?;
        let measured: defect_classifier::camera::RawCamera = self.camera_of("defect_classifier", material)?;
        let said = |node, field, value, unit| Said { node, field, value, unit };
        let pixels = |node, [width_px, height_px]: [f64; 2], scale_m| {
            [
                said(node, "width_px", width_px, "px"),
                said(node, "height_px", height_px, "px"),
                said(node, "scale_m", scale_m, "m/px"),
            ]
        };
        let sim = &rendered.geometry;
        #[allow(clippy::cast_precision_loss, reason = "4096 at most")]
        let size_px = [sim.width_px() as f64, sim.height_px() as f64];
        let reference = pixels("printer_sim", size_px, sim.scale_m());
        let passed_px = [f64::from(passed.width_px), f64::from(passed.height_px)];
        let measured_px = [f64::from(measured.width_px), f64::from(measured.height_px)];
        for other in [
            pixels("camera", passed_px, passed.scale_m),
            pixels("defect_classifier", measured_px, measured.scale_m),
        ] {
            reference.iter().zip(&other).try_for_each(|(one, other)| self.check_same(one, other))?;
        }
        let distance = |node, value| said(node, "working_distance_m", value, "m");
        self.check_same(
            &distance("printer_sim", sim.working_distance_m()),
            &distance("camera", passed.working_distance_m),
        )?;
        let [column, row] = sim.principal_px();
        for (place, measured) in [column, row].into_iter().zip(measured.centre_px) {
            let centre = |node, value| said(node, "centre_px", value, "px");
            self.check_same(
                &Said {
                    field: "width_px and height_px, the centre of which is",
                    ..centre("printer_sim", place)
                },
                &centre("defect_classifier", measured),
            )?;
        }
        Ok(())
    }

    fn camera_of<T: DeserializeOwned>(&self, node: &str, material: &str) -> anyhow::Result<T> {
        let path = NodePath { qualified: format!("/printer/{node}"), base: node.to_owned() };
        Ok(Parameters::read(&self.files_of(node, material), &[], &path)?.block("camera")?)
    }

    fn check_same(&self, one: &Said, other: &Said) -> anyhow::Result<()> {
        if (one.value - other.value).abs() <= 1e-9 * one.value.abs() {
            return Ok(());
        }
        let said = |said: &Said| {
            let file = self.file(&format!("{}.param.yaml", said.node));
            format!("{}: camera.{} = {} {}", file.display(), said.field, said.value, said.unit)
        };
        bail!("{}, but {}: must be the same, or widths are measured wrong", said(one), said(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::{Path, PathBuf};

    fn shipped() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config")
    }

    /// The files that are looked at, one of them with a change.
    fn folder(name: &str, (node, from, to): (&str, &str, &str)) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("fdm-cameras-{name}-{}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        for part in ["", "plants", "printers", "materials"] {
            std::fs::create_dir_all(folder.join(part)).unwrap();
            for entry in std::fs::read_dir(shipped().join(part)).unwrap() {
                let path = entry.unwrap().path();
                if path.is_file() {
                    std::fs::copy(&path, folder.join(part).join(path.file_name().unwrap())).unwrap();
                }
            }
        }
        let file = folder.join(format!("{node}.param.yaml"));
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(text.contains(from), "{node}: {from}");
        std::fs::write(&file, text.replacen(from, to, 1)).unwrap();
        folder
    }

    #[test]
    fn the_shipped_cameras_agree() {
        ConfigDir::find(Some(&shipped())).unwrap().check_cameras("pla").unwrap();
    }

    /// A classifier that takes a pixel for a fifth more than it is measures every road a fifth too wide.
    #[test]
    fn a_camera_that_another_file_knows_otherwise_is_refused_with_both_values() {
        for (node, from, to, told) in [
            (
                "defect_classifier",
                "scale_m: 3.0e-5",
                "scale_m: 3.6e-5",
                ["scale_m = 0.00003 ", "scale_m = 0.000036 "],
            ),
            ("camera", "width_px: 640 ", "width_px: 800 ", ["width_px = 640 ", "width_px = 800 "]),
            ("camera", "working_distance_m: 0.05 ", "working_distance_m: 0.06 ", ["= 0.05 m", "= 0.06 m"]),
            ("defect_classifier", "[319.5, 239.5]", "[319.5, 250.0]", ["= 239.5 px", "centre_px = 250 px"]),
        ] {
            let folder = folder(&format!("{node}_{}", to.len()), (node, from, to));
            let config = ConfigDir::find(Some(&folder)).unwrap();
            let error = config.check_cameras("pla").unwrap_err().to_string();
            let files = ["printer_sim.param.yaml".to_owned(), format!("{node}.param.yaml")];
            let all = told.iter().copied().chain(files.iter().map(String::as_str));
            all.for_each(|word| assert!(error.contains(word), "{word} in {error}"));
            let choice = crate::config::Choice::of("PLA".to_owned(), mpc_controller::params::Level::Mpc);
            assert_eq!(config.load(&choice).unwrap_err().to_string(), error);
            std::fs::remove_dir_all(folder).unwrap();
        }
    }
}
