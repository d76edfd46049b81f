//! `fdm report`: one self-contained HTML page out of a bag.
//!
//! The bag is read once, record by record, in bounded memory, and never changed. What a bag says comes from anywhere:
//! every text is escaped and cut, every number checked, every count bounded.

mod bag;
pub(crate) mod decode;
mod record;
mod scan;
mod series;
mod timeline;
mod view;

use crate::output;
use anyhow::Context;
use bag::Bag;
use clap::Args;
use record::Record;
use scan::{Ended, scan};
use std::path::{Path, PathBuf};

/// Makes a page with plots, events, pictures and layer maps out of a bag.
#[derive(Debug, Args)]
pub struct ReportArgs {
    /// Folder of the bag, or one .mcap or .mcap.active file.
    pub bag: PathBuf,
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
/// A bag that is not there or holds nothing, a page that cannot be written.
pub fn run(args: &ReportArgs) -> anyhow::Result<()> {
    let text = page(&args.bag, args.namespace.as_deref())?;
    let path = args.out.clone().unwrap_or_else(|| beside(&args.bag));
    std::fs::write(&path, &text).with_context(|| path.display().to_string())?;
    output::line(&format!("{} ({})", path.display(), view::words::bytes(text.len() as u64)))
}

/// The page of a bag as text.
///
/// # Errors
/// A bag that is not there or cannot be read at all.
pub fn page(path: &Path, namespace: Option<&str>) -> anyhow::Result<String> {
    let bag = Bag::find(path)?;
    let namespace = namespace.map(|name| name.trim_end_matches('/').to_owned());
    let mut record = Record { namespace, ..Record::default() };
    let mut torn = Vec::new();
    for file in &bag.files {
        let name = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        if let Ended::Torn(how) = scan(file, &mut record)? {
            torn.push(format!("{name} ends in {how}"));
        }
    }
    if record.tally.messages == 0 {
        torn.push("no message could be read".to_owned());
    }
    record.pictures.finish();
    Ok(view::page(&bag, &record, &torn))
}

/// `<bag>.html` beside the bag.
fn beside(bag: &Path) -> PathBuf {
    let whole = std::fs::canonicalize(bag).unwrap_or_else(|_| bag.to_path_buf());
    let mut name = whole.file_name().map(ToOwned::to_owned).unwrap_or_else(|| "report".into());
    name.push(".html");
    whole.with_file_name(name)
}
