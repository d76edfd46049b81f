//! Python peers: a script gets a problem as one JSON object and says one in its last line.

use anyhow::{Context, bail};
use serde_json::Value;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

/// What the script makes of the problem; `None`, and a note, where the peers are not installed.
pub(super) fn ask(python: &Path, script: &str, problem: &Value) -> anyhow::Result<Option<Value>> {
    if !python.is_file() {
        let missing = python.display();
        crate::output::note(&format!("{missing} is missing: no peer; tests/bench_peers/setup.sh makes it"));
        return Ok(None);
    }
    let mut child = Command::new(python)
        .args(["-W", "ignore", "-c", script])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .with_context(|| python.display().to_string())?;
    if let Some(mut stdin) = child.stdin.take() {
        stdin.write_all(problem.to_string().as_bytes())?;
    }
    let output = child.wait_with_output()?;
    let text = String::from_utf8_lossy(&output.stdout);
    match text.lines().last().filter(|_| output.status.success()) {
        Some(line) => Ok(Some(serde_json::from_str(line).with_context(|| format!("the peer said: {line}"))?)),
        None => bail!("the peer ended with {}: {}", output.status, String::from_utf8_lossy(&output.stderr)),
    }
}

/// Numbers of a list; nothing where it is none.
pub(super) fn numbers(list: &Value) -> Vec<f64> {
    list.as_array().into_iter().flatten().filter_map(Value::as_f64).collect()
}

/// The value below which a share of the values lies.
pub(super) fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)]
    let place = ((sorted.len().saturating_sub(1)) as f64 * share.clamp(0.0, 1.0)).round() as usize;
    sorted.get(place).copied().unwrap_or(f64::NAN)
}

/// Median time of `work` over `rounds` `[s]`, and what it gave last.
pub(super) fn median_s<T>(rounds: u32, mut work: impl FnMut() -> T) -> (f64, T) {
    let mut last = work();
    let mut spent = Vec::new();
    for _ in 0..rounds {
        let begin = Instant::now();
        last = work();
        spent.push(begin.elapsed().as_secs_f64());
    }
    (quantile(&spent, 0.5), last)
}

/// Median time of each of `count` works over `rounds` `[s]`, done in turn: a machine that slows down slows all of them.
pub(super) fn in_turn_s(rounds: u32, count: usize, mut work: impl FnMut(usize)) -> Vec<f64> {
    let mut spent = vec![Vec::new(); count];
    for round in 0..=rounds {
        for (index, spent) in spent.iter_mut().enumerate() {
            let begin = Instant::now();
            work(index);
            if round > 0 {
                spent.push(begin.elapsed().as_secs_f64());
            }
        }
    }
    spent.iter().map(|spent| quantile(spent, 0.5)).collect()
}
