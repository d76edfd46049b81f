//! What the commands of the process models share: blocks of parameter files, seeds, pictures.

use crate::config::ConfigDir;
use anyhow::{Context, anyhow, bail};
use plotters::coord::Shift;
use plotters::prelude::{DrawingArea, IntoDrawingArea, SVGBackend, WHITE};
use runtime::params::{NodePath, Parameters};
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};

/// A drawing, empty at first.
pub type Canvas<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// One block of a parameter file of the configuration folder.
///
/// # Errors
/// File, line, field, value and range of what is refused.
pub fn block<T: DeserializeOwned>(config: &ConfigDir, file: &str, name: &str) -> anyhow::Result<T> {
    let path = NodePath { qualified: "/printer/fdm".into(), base: "fdm".into() };
    Ok(Parameters::read(&[config.file(file)], &[], &path)?.block(name)?)
}

/// Seeds from `A..B`, both included, as the option `option` gives them.
///
/// # Errors
/// Says what the form is.
pub fn seeds(option: &str, range: &str) -> anyhow::Result<Vec<u64>> {
    let bounds = range.split_once("..").and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    match bounds {
        Some((first, last)) if first <= last && last - first < 10_000 => Ok((first..=last).collect()),
        _ => bail!(
            "{option} {range}: must be A..B with A <= B, both included, at most 10000 of them: 1..5 are five seeds"
        ),
    }
}

/// A picture file: SVG, or a page that holds one.
#[derive(Debug, Clone)]
pub struct Picture {
    path: PathBuf,
    page: bool,
}

impl Picture {
    /// Chooses the form by the name's ending, before the work begins.
    ///
    /// # Errors
    /// An ending that is neither `.svg` nor `.html`; a file that the command line names as something else too.
    pub fn new(path: &Path) -> anyhow::Result<Self> {
        crate::output::check_named_once(path)?;
        match path.extension().and_then(|ending| ending.to_str()) {
            Some("svg") => Ok(Self { path: path.to_path_buf(), page: false }),
            Some("html") => Ok(Self { path: path.to_path_buf(), page: true }),
            _ => bail!("--picture {}: must end in .svg or .html", path.display()),
        }
    }

    /// Draws and writes; width and height in pixels.
    ///
    /// # Errors
    /// What the drawing says, or a file that cannot be written.
    pub fn draw(
        &self,
        title: &str,
        size: (u32, u32),
        draw: impl FnOnce(&Canvas<'_>) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let mut svg = String::new();
        {
            let canvas = SVGBackend::with_string(&mut svg, size).into_drawing_area();
            canvas.fill(&WHITE).map_err(|error| anyhow!("{error}"))?;
            draw(&canvas)?;
            canvas.present().map_err(|error| anyhow!("{error}"))?;
        }
        let text = if self.page {
            format!(
                "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
                 content=\"width=device-width\"><title>{title}</title>\
                 <style>svg {{ max-width: 100%; height: auto }}</style></head>\n\
                 <body><h1>{title}</h1>\n{svg}\n</body></html>\n"
            )
        } else {
            svg
        };
        std::fs::write(&self.path, text).with_context(|| self.path.display().to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_that_is_none_is_named_by_its_option() {
        assert_eq!(seeds("--trial", "2..4").unwrap(), [2, 3, 4]);
        for range in ["1..0", "1", "0..10000", "a..b"] {
            let refused = seeds("--trial", range).unwrap_err().to_string();
            assert!(refused.starts_with(&format!("--trial {range}: must be A..B")), "{refused}");
        }
    }
}
