//! Whether frames hang together as a tree: readers of `/tf` drop, or wait for ever on, what does not.

use super::{BED, RawFrames, TOOL};
use models::params::is_frame_name;

/// Why parts are no tree of frames. The message begins with the field, relative to the block.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FrameError {
    /// A text that is no name of a frame.
    #[error("{field} = '{value}': must be a frame's name, without blanks and without '/' in front")]
    Name {
        /// The field.
        field: String,
        /// What it says.
        value: String,
    },
    /// A part without a name, or with one that is none.
    #[error("parts: '{0}': must be a frame's name, without blanks and without '/' in front")]
    Part(String),
    /// The tool has a place already.
    #[error("parts.toolhead.parent = {0}: must be left out, as the tool moves over the bed")]
    Tool(String),
    /// A part that hangs on itself, if by way of others.
    #[error("parts.{part}.parent = {parent}: must not lead back to the part, as {way} does")]
    Circle {
        /// The part.
        part: String,
        /// What it hangs on.
        parent: String,
        /// From the part to itself.
        way: String,
    },
}

/// Refuses parts that are no tree.
pub(super) fn check(frames: &RawFrames) -> Result<(), FrameError> {
    if !(frames.prefix.is_empty() || is_frame_name(&frames.prefix)) {
        return Err(FrameError::Name { field: "prefix".to_owned(), value: frames.prefix.clone() });
    }
    for (name, part) in &frames.parts {
        if !is_frame_name(name) {
            return Err(FrameError::Part(name.clone()));
        }
        if !is_frame_name(&part.parent) {
            return Err(FrameError::Name {
                field: format!("parts.{name}.parent"),
                value: part.parent.clone(),
            });
        }
        if name == TOOL {
            return Err(FrameError::Tool(part.parent.clone()));
        }
        no_circle(frames, name, &part.parent)?;
    }
    Ok(())
}

/// Follows the parents of a part up to one that hangs on nothing.
fn no_circle(frames: &RawFrames, name: &str, parent: &str) -> Result<(), FrameError> {
    let above = |name: &str| match name {
        TOOL => Some(BED),
        _ => frames.parts.get(name).map(|part| part.parent.as_str()),
    };
    let mut way = vec![name, parent];
    while let Some(&last) = way.last() {
        if last == name {
            let (part, parent) = (name.to_owned(), parent.to_owned());
            return Err(FrameError::Circle { part, parent, way: way.join(" - ") });
        }
        // A circle among others, which is found from there.
        if way[..way.len() - 1].contains(&last) {
            return Ok(());
        }
        match above(last) {
            Some(next) => way.push(next),
            None => return Ok(()),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::frames::FrameParams;
    use crate::params::{NodePath, Parameters};

    /// What is said of parts, one a line from line 6 on; file and its name are left out.
    fn said(test: &str, prefix: &str, parts: &[(&str, &str)]) -> Result<FrameParams, String> {
        let place = "xyz_m: [0.0, 0.0, 0.0], rpy_rad: [0.0, 0.0, 0.0]";
        let lines: String = parts
            .iter()
            .map(|(name, parent)| format!("        \"{name}\": {{ parent: \"{parent}\", {place} }}\n"))
            .collect();
        let text = format!(
            "/**:\n  ros__parameters:\n    frames:\n      prefix: \"{prefix}\"\n      parts:\n{lines}"
        );
        let file = std::env::temp_dir().join(format!("frames_{test}_{}.yaml", std::process::id()));
        std::fs::write(&file, text).unwrap();
        let node = NodePath { qualified: "/printer/printer_sim".into(), base: "printer_sim".into() };
        let read = Parameters::read(std::slice::from_ref(&file), &[], &node).unwrap().block("frames");
        std::fs::remove_file(&file).unwrap();
        read.map_err(|error| error.to_string().replace(&file.display().to_string(), ""))
    }

    #[test]
    fn a_tree_under_a_prefix_is_taken() {
        let parts = [("bed", "printer"), ("nozzle", "toolhead"), ("camera_optical", "nozzle")];
        assert!(said("tree", "left/", &parts).is_ok());
    }

    /// Each with file, line and field.
    #[test]
    fn parts_that_hang_on_themselves_are_refused() {
        let own = said("own", "", &[("bed", "printer"), ("nozzle", "nozzle")]).unwrap_err();
        let told = ":7: frames.parts.nozzle.parent = nozzle: must not lead back to the part, as nozzle - nozzle does";
        assert_eq!(own, told);
        let parts = [("a", "b"), ("b", "c"), ("c", "b")];
        let circle = said("circle", "", &parts).unwrap_err();
        assert!(
            circle.starts_with(":7: frames.parts.b.parent = c") && circle.contains("b - c - b"),
            "{circle}"
        );
        let moved = said("moved", "", &[("bed", "nozzle"), ("nozzle", "toolhead")]).unwrap_err();
        assert!(moved.contains("bed - nozzle - toolhead - bed"), "{moved}");
        let tool = said("tool", "", &[("bed", "printer"), ("toolhead", "printer")]).unwrap_err();
        assert!(tool.starts_with(":7: frames.parts.toolhead.parent = printer: must be left out"), "{tool}");
    }

    #[test]
    fn blank_names_are_refused() {
        for (test, value) in [("empty", ""), ("blank", " "), ("two", "two words"), ("slash", "/bed")] {
            let parent = said(test, "", &[("nozzle", value)]).unwrap_err();
            let field = format!(":6: frames.parts.nozzle.parent = '{value}': must be a frame's name");
            assert!(parent.starts_with(&field), "{parent}");
            let name = said(test, "", &[(value, "printer")]).unwrap_err();
            assert!(
                name.starts_with(":") && name.contains(&format!("frames: parts: '{value}': must")),
                "{name}"
            );
        }
        let prefix = said("prefix", "left ", &[("bed", "printer")]).unwrap_err();
        assert!(prefix.starts_with(":4: frames.prefix = 'left '"), "{prefix}");
    }
}
