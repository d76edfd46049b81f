//! A recorder that somebody waits for: what a person wants reaches it, and what it leaves behind becomes a bag.

use super::shown::{LOOK, Shown};
use crate::output::Failed;
use crate::suspension::Suspension;
use crate::up::close;
use anyhow::Context;
use rustix::process::{Pid, Signal, kill_process};
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::ExitStatus;
use tokio::process::Command;
use tokio::signal::unix::{SignalKind, signal};
use tokio::time::MissedTickBehavior;

/// Exit code of a command whose recorder was ended by a signal, as shells have it: this and the signal's number.
const SIGNALLED: i32 = 128;

/// Runs the recorder to its end. One that did not end in order leaves a file that no reader opens: it is closed here.
///
/// # Errors
/// A recorder that cannot be started.
pub(super) fn run(program: &Path, arguments: &[String], shown: &mut Shown<'_>) -> anyhow::Result<()> {
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let ended =
        executor.block_on(wait(program, arguments, shown)).with_context(|| program.display().to_string())?;
    let bag = shown.bag;
    shown.end()?;
    if ended.success() {
        return Ok(());
    }
    if ended.code() == Some(i32::from(runtime::DRIVEN_OUT)) || ended.signal().is_some() {
        close(bag);
        let how = "the recorder was stopped and continued, or driven out or ended by force";
        return Err(Failed(format!("{how}: start it again, to the same bag")).into());
    }
    // It has said why.
    std::process::exit(ended.code().unwrap_or(SIGNALLED));
}

async fn wait(program: &Path, arguments: &[String], shown: &mut Shown<'_>) -> std::io::Result<ExitStatus> {
    let mut interrupt = signal(SignalKind::interrupt())?;
    let mut terminate = signal(SignalKind::terminate())?;
    let mut hang_up = signal(SignalKind::hangup())?;
    let mut suspended = Suspension::listen();
    let parent = std::process::id().to_string();
    let mut recorder =
        Command::new(program).args(arguments).env(runtime::STOP_WITH_PARENT, parent).spawn()?;
    let mut looks = tokio::time::interval(LOOK);
    looks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let pid = recorder.id().and_then(|id| Pid::from_raw(id.cast_signed()));
    loop {
        let wanted = tokio::select! {
            ended = recorder.wait() => return ended,
            _ = interrupt.recv() => Signal::INT,
            _ = terminate.recv() => Signal::TERM,
            _ = hang_up.recv() => Signal::HUP,
            _ = looks.tick() => {
                shown.look();
                continue;
            }
            // A recorder does not heed Ctrl-Z either: what it listens to goes on.
            () = suspended.asked() => continue,
        };
        if let Some(pid) = pid {
            // One that has gone meanwhile is waited for.
            _ = kill_process(pid, wanted);
        }
    }
}
