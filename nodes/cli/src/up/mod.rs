//! x
pub mod fleet;
use clap::Args;
/// x
#[derive(Debug, Args)]
pub struct UpArgs {}
/// x
/// # Errors
/// x
pub fn run(_args: &UpArgs) -> anyhow::Result<()> { Ok(()) }
