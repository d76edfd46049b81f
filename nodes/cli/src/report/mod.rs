//! `fdm report`: one self-contained HTML page out of a bag.
//!
//! The bag is read once, record by record, in bounded memory, and never changed. What a bag says comes from anywhere:
//! every text is escaped and cut, every number checked, every count bounded.

pub(crate) mod bag;
pub(crate) mod decode;
mod record;
pub(crate) mod scan;
mod series;
pub(crate) mod stated;
mod timeline;
mod view;

use crate::output;
use anyhow::{Context, bail};
use bag::Bag;
use clap::Args;
use record::Record;
use scan::{Ended, Sum, scan};
use std::path::{Path, PathBuf};

/// Makes a page with plots, events, pictures and layer maps out of a bag.
#[derive(Debug, Args)]
pub struct ReportArgs {
    /// Folder of the bag, or one .mcap or .mcap.active file.
    pub bag: PathBuf,
    /// Another print to draw beside it, as with corrections off: width error, flow, slip, temperature, trims.
    #[arg(long)]
    pub against: Option<PathBuf>,
    /// File of the page; `<bag>.html` beside the bag by default.
    #[arg(long)]
    pub out: Option<PathBuf>,
    /// Namespace of the printer; the first one in the bag by default.
    #[arg(long)]
    pub namespace: Option<String>,
}

/// Runs the command.
///
/// # Errors
/// What is no bag, a bag that holds nothing, a page that cannot be written or would replace what is read.
pub fn run(args: &ReportArgs) -> anyhow::Result<()> {
    let path = args.out.clone().unwrap_or_else(|| beside(&args.bag));
    check_out(&path, &args.bag)?;
    if let Some(other) = &args.against {
        check_out(&path, other)?;
    }
    output::check_writable(if args.out.is_some() { "--out" } else { "page" }, &path)?;
    let text = page_against(&args.bag, args.namespace.as_deref(), args.against.as_deref())?;
    output::write_whole(&path, &text)?;
    output::line(&format!("{} ({})", path.display(), view::words::bytes(text.len() as u64)))
}

/// A page replaces nothing of a bag: neither a file of it nor what lies beside them.
fn check_out(out: &Path, bag: &Path) -> anyhow::Result<()> {
    output::check_apart(out, &[bag.to_path_buf()])?;
    let is_page = out.extension().is_some_and(|ending| ending == "html");
    match std::fs::canonicalize(bag).ok().as_deref().and_then(Path::parent) {
        Some(folder) if bag.is_file() && !is_page => output::check_apart(out, &[folder.to_path_buf()]),
        _ => Ok(()),
    }
}

/// The page of a bag as text.
///
/// # Errors
/// What is no bag, cannot be read at all, or holds nothing of the namespace or of any printer.
pub fn page(path: &Path, namespace: Option<&str>) -> anyhow::Result<String> {
    page_against(path, namespace, None)
}

/// The same with another print on the same axes.
///
/// # Errors
/// As [`page`], of either bag; another bag out of which no message can be read.
pub fn page_against(path: &Path, namespace: Option<&str>, other: Option<&Path>) -> anyhow::Result<String> {
    let gathered = Gathered::read(path, namespace)?;
    let beside = other.map(|other| Gathered::read(other, namespace)).transpose()?;
    if let Some(empty) = beside.as_ref().filter(|beside| beside.record.tally.messages == 0) {
        bail!("{}: no message could be read", empty.bag.name);
    }
    if let Some(unlike) = beside.as_ref().and_then(|beside| gathered.unlike(beside)) {
        output::note(&unlike);
    }
    for print in std::iter::once(&gathered).chain(&beside) {
        for torn in &print.torn {
            // One file that is a bag is named once.
            let of = if torn.starts_with(&print.bag.name) {
                String::new()
            } else {
                format!("{}: ", print.bag.name)
            };
            output::note(&format!("{of}{torn}"));
        }
    }
    let beside =
        beside.as_ref().map(|beside| view::against::Other { bag: &beside.bag, record: &beside.record });
    Ok(view::page(&gathered.bag, &gathered.record, &gathered.torn, beside.as_ref()))
}

/// A bag and what it says.
struct Gathered {
    bag: Bag,
    record: Record,
    /// What is missing or broken.
    torn: Vec<String>,
}

impl Gathered {
    fn read(path: &Path, namespace: Option<&str>) -> anyhow::Result<Self> {
        let bag = Bag::find(path)?;
        let namespace = namespace.map(|name| name.trim_end_matches('/').to_owned());
        let mut record = Record { namespace: namespace.clone(), ..Record::default() };
        let (mut torn, mut strangers) = (Vec::new(), 0);
        for file in &bag.files {
            let name = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            match scan(file, &mut record)? {
                Ended::Whole(Sum::Fits) => record.tally.sums_fit += 1,
                Ended::Whole(_) => {}
                Ended::Torn(found) => torn.push(format!("{name} {}", found.how)),
                Ended::NoBag => {
                    torn.push(format!("{name} does not begin as a file of a bag does"));
                    strangers += 1;
                }
            }
        }
        if strangers == bag.files.len() {
            bail!(
                "{}: no bag: it does not begin as an MCAP file does; give a bag's folder or an .mcap file",
                path.display()
            );
        }
        if let Some(namespace) = namespace.filter(|_| record.tally.messages > 0) {
            record.check_namespace(&namespace).with_context(|| path.display().to_string())?;
        }
        if record.tally.messages == 0 {
            torn.push("no message could be read".to_owned());
        }
        match record.foreign() {
            // What is missing may have been a printer's.
            Some(said) if !torn.is_empty() => torn.push(said),
            Some(said) => bail!("{}: {said}", path.display()),
            None => {}
        }
        record.pictures.finish();
        Ok(Self { bag, record, torn })
    }

    /// What makes figures of the two prints no comparison: they are of different files, as far as both say.
    fn unlike(&self, other: &Self) -> Option<String> {
        let both = [self, other].map(|print| &print.record.print);
        let [mine, theirs] =
            both.map(|print| print.described.get("gcode_file").filter(|file| !file.is_empty()));
        let (mine, theirs) = mine.zip(theirs).filter(|(mine, theirs)| mine != theirs)?;
        Some(format!(
            "--against {}: a print of {theirs}, {} one of {mine}: figures side by side are no comparison",
            other.bag.name, self.bag.name
        ))
    }
}

/// `<bag>.html` beside the bag.
fn beside(bag: &Path) -> PathBuf {
    let whole = std::fs::canonicalize(bag).unwrap_or_else(|_| bag.to_path_buf());
    let mut name = whole.file_name().map(ToOwned::to_owned).unwrap_or_else(|| "report".into());
    name.push(".html");
    whole.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn print_of(file: &str) -> Gathered {
        let bag = Bag {
            name: format!("bags/{file}"),
            files: Vec::new(),
            counts: None,
            stated: None,
            broken: Vec::new(),
        };
        let mut record = Record::default();
        record.print.described.insert("gcode_file", file.to_owned());
        Gathered { bag, record, torn: Vec::new() }
    }

    /// Of a print that does not say its file nothing is said.
    #[test]
    fn prints_of_different_files_are_told() {
        let (cube, ring) = (print_of("cube.gcode"), print_of("ring.gcode"));
        let told = cube.unlike(&ring).unwrap();
        assert!(
            told.starts_with(
                "--against bags/ring.gcode: a print of ring.gcode, bags/cube.gcode one of cube.gcode"
            ),
            "{told}"
        );
        assert_eq!((cube.unlike(&print_of("cube.gcode")), cube.unlike(&print_of(""))), (None, None));
    }
}
