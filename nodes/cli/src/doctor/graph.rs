//! Two processes that really talk over DDS.

use super::finding::Finding;
use crate::output;
use crate::participant;
use anyhow::bail;
use models::units::Seconds;
use runtime::topics;
use std::process::{Child, Command, Output, Stdio};

/// Names of the two.
const ROLES: [&str; 2] = ["doctor_a", "doctor_b"];
/// So long each waits for the other `[s]`.
const WAIT_S: f64 = 10.0;
/// So long each goes on talking after it has heard the other `[s]`.
const LINGER_S: f64 = 1.5;
/// Ten processes find each other in 0.5 s (ros.md).
const USUAL_S: f64 = 3.0;

/// Starts both and waits for what they heard.
pub(super) fn pair() -> Finding {
    const NAME: &str = "DDS";
    const TODO: &str =
        "see domain and loopback above; a firewall must let UDP pass on lo; then start fdm doctor again";
    let heard: Result<Vec<f64>, String> = match ROLES.map(start) {
        [Ok(first), Ok(second)] => [first, second].map(ended).into_iter().collect(),
        [Err(error), _] | [_, Err(error)] => Err(error.to_string()),
    };
    match heard {
        Err(why) => Finding::fail(NAME, format!("two processes do not hear each other: {why}"), TODO),
        Ok(times) => {
            let longest_s = times.into_iter().fold(0.0, f64::max);
            let found = format!("two processes hear each other after {longest_s:.1} s");
            if longest_s > USUAL_S {
                Finding::warn(NAME, found, "nodes find each other slowly: see processors")
            } else {
                Finding::ok(NAME, found)
            }
        }
    }
}

fn start(role: &str) -> std::io::Result<Child> {
    // A name of its own for each run: a graph that is there is not disturbed.
    Command::new(std::env::current_exe()?)
        .args(["doctor", "--talk", &format!("/fdm_doctor_{}/{role}", std::process::id())])
        .env(runtime::STOP_WITH_PARENT, std::process::id().to_string())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
}

/// Seconds until a process heard the other.
fn ended(child: Child) -> Result<f64, String> {
    let Output { status, stdout, stderr } = child.wait_with_output().map_err(|error| error.to_string())?;
    let heard = String::from_utf8_lossy(&stdout).trim().parse::<f64>().ok();
    let last = || String::from_utf8_lossy(&stderr).lines().next_back().unwrap_or_default().to_owned();
    heard.filter(|_| status.success()).ok_or_else(|| match status.code() {
        Some(_) => last(),
        None => format!("its own messages do not come back to it ({status})"),
    })
}

/// One of the two: its heart beats, and it waits for the other's.
pub(super) fn talk(role: &str) -> anyhow::Result<()> {
    let Some((namespace, name)) = role.rsplit_once('/') else { bail!("--talk {role}: no namespace") };
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let heard_s = executor.block_on(async {
        let args = runtime::Args { namespace: Some(namespace.to_owned()), ..runtime::Args::default() };
        let mut node = participant::join(name, args)?;
        let mut beats = node.subscribe(&topics::HEARTBEAT)?;
        let (clock, mut ticks) = (node.clock(), node.timer(Seconds(0.02)));
        let start = clock.now();
        let mut heard_s = None;
        while heard_s.map_or(WAIT_S, |at_s| at_s + LINGER_S) > (clock.now() - start).0 {
            _ = ticks.next().await;
            while let Some(beat) = beats.try_recv() {
                let other = !beat.message.node.ends_with(name);
                heard_s = heard_s.or(other.then(|| (clock.now() - start).0));
            }
        }
        anyhow::Ok(heard_s)
    })?;
    match heard_s {
        Some(at_s) => output::line(&format!("{at_s:.3}")),
        None => bail!("nothing was heard in {WAIT_S} s"),
    }
}
