//! The smallest pair of nodes: `pair --ros-args -p role:=talker` and, in another shell, `-p role:=listener`.
//!
//! The talker publishes numbered widths at 100 Hz, a latched print and a service. The listener ends well when it has
//! received the print, 200 widths in order (decoded and as bytes) and an answer, and ends badly otherwise. The asker needs
//! an answer alone, to the one request that it sends.
//!
//! On simulated time (`-p use_sim_time:=true`): the pacer drives `/clock` at ten times real time, the sleeper ends well
//! after 20 ticks of a second each, all a second apart on its clock.
//!
//! The chatterer writes more lines than any pipe holds, and ends well. The teller writes as many as may wait for standard
//! error, and ends a second later. The stubborn one hears no demand to end.

use fdm_loop_msgs::{BeadWidth, Header, PrintInfo, SetModeRequest, SetModeResponse};
use models::units::Seconds;
use runtime::{CallError, Node, RuntimeError, topics};
use std::time::Duration;

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Params {
    role: Role,
}

#[derive(serde::Deserialize)]
#[serde(rename_all = "snake_case")]
enum Role {
    Talker,
    Listener,
    Asker,
    Pacer,
    Sleeper,
    Chatterer,
    Teller,
    Stubborn,
}

#[derive(Debug, thiserror::Error)]
enum PairError {
    #[error(transparent)]
    Runtime(#[from] RuntimeError),
    #[error(transparent)]
    Call(#[from] CallError),
    #[error("unexpected: {0}")]
    Unexpected(String),
}

/// Widths that the listener waits for.
const WIDTHS: usize = 200;

async fn talk(mut node: Node) -> Result<(), PairError> {
    let widths = node.publish_on(&topics::BEAD_WIDTH)?;
    let prints = node.publish_on(&topics::PRINT_INFO)?;
    let mut modes = node.serve(&topics::SAFETY_SET_MODE)?;
    let (clock, work) = (node.clock(), node.work());
    let mut ticks = node.timer(Seconds(0.01));
    prints.send(PrintInfo { print_id: "pair".into(), ..PrintInfo::default() });
    let mut number = 0.0;
    loop {
        tokio::select! {
            now = ticks.next() => {
                number += 1.0;
                widths.send(BeadWidth { header: Header::at(now.0), width_m: number, ..BeadWidth::default() });
                work.done();
            }
            asked = modes.next() => {
                let message = format!("mode {} at {:.3} s", asked.request.mode, clock.now().0);
                modes.answer(&asked, SetModeResponse { accepted: true, message });
            }
            () = node.shutdown() => return Ok(()),
        }
    }
}

async fn listen(mut node: Node) -> Result<(), PairError> {
    let mut widths = node.subscribe(&topics::BEAD_WIDTH)?;
    let mut raw = node.subscribe_raw(&topics::BEAD_WIDTH.info())?;
    let mut prints = node.subscribe(&topics::PRINT_INFO)?;
    let modes = node.client(&topics::SAFETY_SET_MODE)?;

    let print = prints.recv().await;
    let first = widths.recv().await;
    let mut newest = first.message.width_m;
    for _ in 1..WIDTHS {
        let width = widths.recv().await;
        let age = node.clock().now().0 - width.message.header.stamp.seconds().unwrap_or(0.0);
        if width.message.width_m <= newest || width.publisher != first.publisher || !(0.0..1.0).contains(&age)
        {
            return Err(PairError::Unexpected(format!("{width:?} after {newest}, {age} s old")));
        }
        newest = width.message.width_m;
    }
    let bytes = raw.recv().await;
    if bytes.payload.get(..4) != Some(&[0, 1, 0, 0]) || raw.type_name() != "fdm_loop_msgs/msg/BeadWidth" {
        return Err(PairError::Unexpected(format!("{bytes:?}")));
    }
    let answer = modes.call(SetModeRequest { mode: 3 }, Seconds(5.0)).await?;
    tracing::warn!("print '{}', {WIDTHS} widths, answer '{}'", print.message.print_id, answer.message);
    if answer.accepted { Ok(()) } else { Err(PairError::Unexpected(format!("{answer:?}"))) }
}

/// Asks as soon as it has joined, and once.
async fn ask(mut node: Node) -> Result<(), PairError> {
    let modes = node.client(&topics::SAFETY_SET_MODE)?;
    modes.call(SetModeRequest { mode: 3 }, Seconds(5.0)).await?;
    Ok(())
}

/// Simulated time between two readings of the clock `[s]`, and real time.
const STEP_S: f64 = 0.1;
const PACE: std::time::Duration = std::time::Duration::from_millis(10);

async fn pace(mut node: Node) -> Result<(), PairError> {
    let driver = node.drive_clock()?;
    let mut pace = tokio::time::interval(PACE);
    let mut now = Seconds(0.0);
    loop {
        tokio::select! {
            _ = pace.tick() => {
                now = now + Seconds(STEP_S);
                driver.set(now);
            }
            () = node.shutdown() => return Ok(()),
        }
    }
}

async fn sleep(node: Node) -> Result<(), PairError> {
    let mut seconds = node.timer(Seconds(1.0));
    // Where the pacer was there first, the first reading is a tick already, at any moment of its second.
    _ = seconds.next().await;
    let mut last = seconds.next().await;
    for _ in 0..20 {
        let now = seconds.next().await;
        // Readings may be lost under load, so a tick may come late, but none comes early or at another pace.
        let apart = (now - last).0;
        if !(0.4..2.0).contains(&apart) {
            return Err(PairError::Unexpected(format!("{apart} s between two ticks of 1 s")));
        }
        last = now;
    }
    Ok(())
}

/// Lines of 100 bytes: a pipe holds 64 KiB.
const LINES: u32 = 20_000;
/// Fewer than the runtime lets wait for standard error.
const TOLD: u32 = 4000;

async fn pair(node: Node) -> Result<(), PairError> {
    let role = node.parameters::<Params>()?.role;
    node.activated().await;
    match role {
        Role::Talker => talk(node).await,
        Role::Listener => listen(node).await,
        Role::Asker => ask(node).await,
        Role::Pacer => pace(node).await,
        Role::Sleeper => sleep(node).await,
        Role::Chatterer => {
            for line in 0..LINES {
                tracing::warn!(
                    "line {line} of {LINES}, which are more than any pipe holds that nobody reads"
                );
            }
            Ok(())
        }
        Role::Stubborn => std::future::pending().await,
        Role::Teller => {
            for line in 0..TOLD {
                tracing::warn!("line {line} of {TOLD}, which somebody reads");
            }
            // An end leaves its last lines a moment only, whoever reads them.
            tokio::time::sleep(Duration::from_secs(1)).await;
            Ok(())
        }
    }
}

fn main() -> std::process::ExitCode {
    runtime::run("pair", pair)
}
