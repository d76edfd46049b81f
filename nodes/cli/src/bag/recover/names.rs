//! Which files of a folder are the bag.

use anyhow::{Context, bail};
use bag_recorder::layout::Layout;
use std::path::Path;

/// Endings of files that hold messages in other forms.
const STORED: [&str; 3] = [".db3", ".db3.zstd", ".mcap.zstd"];

/// How the files of a bag are called; the folder may have been renamed. Files of a second bag would be passed over, and
/// be missing in what is said of this one.
///
/// # Errors
/// A folder without a file that can be mended, or with more than one bag in it.
pub(super) fn of(bag: &Path) -> anyhow::Result<Layout> {
    refuse_packed_messages(bag)?;
    let mut own: Option<Layout> = None;
    let mut strangers = Vec::new();
    let shown = || bag.display().to_string();
    let mut names = std::fs::read_dir(bag)
        .and_then(|entries| entries.map(|entry| Ok(entry?.file_name())).collect::<Result<Vec<_>, _>>())
        .with_context(shown)?;
    names.sort();
    for name in names {
        let name = name.to_string_lossy().into_owned();
        match Layout::of_file(&name) {
            Some(layout) if own.as_ref().is_none_or(|own| *own == layout) => own = Some(layout),
            Some(_) => strangers.push(name),
            None if STORED.iter().any(|ending| name.ends_with(ending)) => strangers.push(name),
            None => {}
        }
    }
    match (own, strangers.first()) {
        (Some(own), None) => Ok(own),
        (Some(own), Some(other)) => bail!(
            "{}: holds {other} beside the files of {}: one bag a folder; move it elsewhere",
            shown(),
            own.bag()
        ),
        (None, Some(other)) => bail!(
            "{}: no .mcap file in this folder; {other} is of another form: unpack it first (`zstd -d`), or convert it \
             (`ros2 bag convert`)",
            shown()
        ),
        (None, None) => bail!("{}: no .mcap file in this folder", shown()),
    }
}

/// Refuses a bag in which each message is compressed on its own: `metadata.yaml` alone says so, and is written anew where
/// something is mended.
fn refuse_packed_messages(bag: &Path) -> anyhow::Result<()> {
    let path = bag.join("metadata.yaml");
    let Ok(text) = runtime::input::text(&path) else { return Ok(()) };
    let mode = text.lines().find_map(|line| line.trim().strip_prefix("compression_mode:"));
    let mode = mode.unwrap_or_default().trim().trim_matches(['"', '\'']);
    if mode.eq_ignore_ascii_case("message") {
        bail!(
            "{}: compression_mode is '{mode}': each message is compressed on its own, \
             write it anew first (`ros2 bag convert`)",
            path.display()
        );
    }
    Ok(())
}
