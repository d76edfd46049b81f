//! The node processes: started, watched, started again with a growing delay, stopped in order.

use models::units::Seconds;
use rustix::process::{Pid, Signal, kill_process};
use std::fs::OpenOptions;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};

mod happening;
mod recipe;

pub use happening::Happening;
pub use recipe::Recipe;

/// Delay before a process that has run for a minute is started again `[s]`: a thermistor has to be back 1.4 s after its
/// end, before the supervisor pauses the print (S7).
const FIRST_DELAY_S: f64 = 0.1;
/// Delay of the second start within a minute `[s]`; doubles with every further one.
const BACKOFF_MIN_S: f64 = 0.5;
/// Longest delay `[s]`: what the network ends six times in a storm is back within 5 s of the storm all the same (X1).
const BACKOFF_MAX_S: f64 = 2.0;
/// Starts within [`RESTART_WINDOW_S`] after which a process keeps ending: its ends are not told any more.
const RESTARTS_MAX: usize = 5;
/// Window of [`RESTARTS_MAX`] `[s]`; a process that keeps ending for as long is tried again every [`SLOW_S`] alone.
const RESTART_WINDOW_S: f64 = 60.0;
/// Delay before a process that has kept ending for a minute is tried again `[s]`: what keeps it down (a full disk, a broken
/// file) may pass, and who stayed down for good, a supervisor or a recorder, would be missing for the rest of the print.
const SLOW_S: f64 = 10.0;
/// A process that kept ending and has run for so long is back `[s]`.
const STAYED_S: f64 = 10.0;
/// Delay before a process that the network has driven out again within that window is started again `[s]`: as often as
/// it takes, for who stayed down would be missing when the network is sound again (X1: whole within 5 s).
const DRIVEN_OUT_DELAY_S: f64 = 0.5;

struct Member {
    recipe: Recipe,
    child: Option<Child>,
    restarts: Vec<Seconds>,
    driven_out: Option<Seconds>,
    due: Option<Seconds>,
    given_up: bool,
    /// Since when it keeps ending.
    keeps_ending: Option<Seconds>,
    /// When it was started last, of a process that keeps ending.
    tried: Option<Seconds>,
}

/// All node processes of one printer, in the order of their start.
pub struct Fleet {
    members: Vec<Member>,
    logs: PathBuf,
}

impl Fleet {
    /// Starts every recipe in order; their messages go to `<logs>/<name>.log`.
    ///
    /// # Errors
    /// Names the executable that could not be started; those already running are stopped again.
    pub fn start(recipes: Vec<Recipe>, logs: &Path) -> io::Result<Self> {
        Self::start_as(recipes, logs, Recipe::clone)
    }

    /// As [`Fleet::start`], but the nodes wait to be configured and activated. Who is started again does not wait.
    ///
    /// # Errors
    /// As [`Fleet::start`].
    pub fn start_held(recipes: Vec<Recipe>, logs: &Path) -> io::Result<Self> {
        Self::start_as(recipes, logs, Recipe::held)
    }

    fn start_as(recipes: Vec<Recipe>, logs: &Path, first: fn(&Recipe) -> Recipe) -> io::Result<Self> {
        std::fs::create_dir_all(logs)?;
        let mut fleet = Self { members: Vec::new(), logs: logs.to_owned() };
        for recipe in recipes {
            let child = spawn(&first(&recipe), &fleet.logs)?;
            fleet.members.push(Member {
                recipe,
                child: Some(child),
                restarts: Vec::new(),
                driven_out: None,
                due: None,
                given_up: false,
                keeps_ending: None,
                tried: None,
            });
        }
        Ok(fleet)
    }

    /// Looks after every process; call it some ten times a second.
    pub fn tend(&mut self, now: Seconds) -> Vec<Happening> {
        let mut happenings = Vec::new();
        for member in &mut self.members {
            if let Some(status) = member.ended() {
                happenings.push(member.plan_restart(now, status));
            }
            if member.due.is_some_and(|due| now >= due) {
                happenings.extend(member.restart(now, &self.logs));
            }
            happenings.extend(member.back(now));
        }
        happenings
    }

    /// Asks one of them to end that does nothing any more, or ends by force one that hangs; it is started again as after any
    /// end. Whether it may be.
    pub fn end(&self, name: &str, signal: Signal) -> bool {
        let replaceable = |member: &&Member| member.recipe.name == name && member.recipe.replaceable;
        let member = self.members.iter().find(replaceable);
        member.inspect(|member| member.signal(signal)).is_some()
    }

    /// Whether a node ended and will not be started again.
    #[must_use]
    pub fn has_lost(&self, name: &str) -> bool {
        self.members.iter().any(|member| member.recipe.name == name && member.given_up)
    }

    /// Every node, whether it runs or not.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.members.iter().map(|member| member.recipe.name)
    }

    /// Process ids by node, of those that run.
    #[must_use]
    pub fn pids(&self) -> Vec<(&'static str, u32)> {
        let running = |member: &Member| Some((member.recipe.name, member.child.as_ref()?.id()));
        self.members.iter().filter_map(running).collect()
    }

    /// Asks all but `except` to end.
    pub fn ask_to_end(&self, except: Option<&str>) {
        for member in self.members.iter().filter(|member| Some(member.recipe.name) != except) {
            member.signal(Signal::TERM);
        }
    }

    /// Whether all but `except` have ended.
    pub fn all_ended(&mut self, except: Option<&str>) -> bool {
        self.members
            .iter_mut()
            .filter(|member| Some(member.recipe.name) != except)
            .all(|member| member.child.as_mut().is_none_or(|child| !matches!(child.try_wait(), Ok(None))))
    }

    /// Which of those that have ended did so with an error or by a signal, and how.
    pub fn ended_badly(&mut self) -> Vec<(&'static str, String)> {
        let badly = |member: &mut Member| {
            let status = member.child.as_mut()?.try_wait().ok().flatten()?;
            (!status.success()).then(|| (member.recipe.name, status.to_string()))
        };
        self.members.iter_mut().filter_map(badly).collect()
    }

    /// Ends by force what still runs, but for `except`; returns the names.
    pub fn kill_rest(&mut self, except: Option<&str>) -> Vec<&'static str> {
        let mut killed = Vec::new();
        for member in self.members.iter_mut().filter(|member| Some(member.recipe.name) != except) {
            if let Some(child) = &mut member.child
                && matches!(child.try_wait(), Ok(None))
                && child.kill().is_ok()
            {
                let _reaped = child.wait();
                killed.push(member.recipe.name);
            }
        }
        killed
    }
}

impl Drop for Fleet {
    /// No process outlives the command, whatever ended it.
    fn drop(&mut self) {
        self.kill_rest(None);
    }
}

impl Member {
    fn ended(&mut self) -> Option<ExitStatus> {
        let status = self.child.as_mut()?.try_wait().ok().flatten()?;
        self.child = None;
        Some(status)
    }

    fn plan_restart(&mut self, now: Seconds, status: ExitStatus) -> Happening {
        let name = self.recipe.name;
        self.restarts.retain(|at| (now - *at).0 < RESTART_WINDOW_S);
        let driven_out = status.code() == Some(runtime::DRIVEN_OUT.into());
        if !self.recipe.replaceable {
            self.given_up = true;
            return Happening::GivenUp { name };
        }
        if !driven_out && (self.keeps_ending.is_some() || self.restarts.len() >= RESTARTS_MAX) {
            let told = self.try_later(now);
            let how = status.to_string();
            return if told { Happening::EndedAgain { name } } else { Happening::KeepsEnding { name, how } };
        }
        self.due = Some(now + if driven_out { self.pause(now) } else { delay(self.restarts.len()) });
        if driven_out {
            self.driven_out = Some(now);
        } else {
            self.restarts.push(now);
        }
        Happening::Ended { name, how: status.to_string() }
    }

    /// Plans a try of a process that keeps ending; whether that was known.
    fn try_later(&mut self, now: Seconds) -> bool {
        let known = self.keeps_ending.is_some();
        let since = *self.keeps_ending.get_or_insert(now);
        let long = (now - since).0 >= RESTART_WINDOW_S;
        self.due = Some(now + Seconds(if long { SLOW_S } else { BACKOFF_MAX_S }));
        known
    }

    /// Delay before a process that was driven out is started again.
    fn pause(&self, now: Seconds) -> Seconds {
        let again = self.driven_out.is_some_and(|at| (now - at).0 < RESTART_WINDOW_S);
        Seconds(if again { DRIVEN_OUT_DELAY_S } else { FIRST_DELAY_S })
    }

    fn restart(&mut self, now: Seconds, logs: &Path) -> Option<Happening> {
        self.due = None;
        let name = self.recipe.name;
        match spawn(&self.recipe, logs) {
            Ok(child) => {
                let pid = child.id();
                self.child = Some(child);
                self.tried = Some(now);
                self.keeps_ending.is_none().then_some(Happening::Restarted { name, pid })
            }
            // As after a process that ended at once.
            Err(error) => {
                let told = self.try_later(now);
                (!told).then(|| Happening::KeepsEnding { name, how: error.to_string() })
            }
        }
    }

    /// Tells of a process that kept ending and has stayed now.
    fn back(&mut self, now: Seconds) -> Option<Happening> {
        let pid = self.child.as_ref()?.id();
        self.keeps_ending?;
        if self.tried.is_none_or(|tried| (now - tried).0 < STAYED_S) {
            return None;
        }
        self.keeps_ending = None;
        self.restarts.clear();
        Some(Happening::Restarted { name: self.recipe.name, pid })
    }

    fn signal(&self, signal: Signal) {
        let pid =
            self.child.as_ref().and_then(|child| i32::try_from(child.id()).ok()).and_then(Pid::from_raw);
        if let Some(pid) = pid {
            // It may have ended meanwhile; then there is nobody left to tell.
            let _told = kill_process(pid, signal);
            // A stopped process would never see the request.
            let _woken = kill_process(pid, Signal::CONT);
        }
    }
}

/// Delay before the next start, after so many restarts within the window.
fn delay(restarts: usize) -> Seconds {
    let Some(doublings) = restarts.checked_sub(1) else { return Seconds(FIRST_DELAY_S) };
    let doublings = i32::try_from(doublings).unwrap_or(i32::MAX);
    Seconds((BACKOFF_MIN_S * 2_f64.powi(doublings)).min(BACKOFF_MAX_S))
}

fn spawn(recipe: &Recipe, logs: &Path) -> io::Result<Child> {
    let log = OpenOptions::new().create(true).append(true).open(logs.join(format!("{}.log", recipe.name)))?;
    Command::new(&recipe.program)
        .args(&recipe.arguments)
        .env(runtime::STOP_WITH_PARENT, std::process::id().to_string())
        .envs(recipe.replaceable.then_some((runtime::STARTED_AGAIN, "1")))
        .stdin(Stdio::null())
        .stdout(log.try_clone()?)
        .stderr(log)
        .spawn()
        .map_err(|error| io::Error::new(error.kind(), format!("{}: {error}", recipe.program.display())))
}

#[cfg(test)]
mod tests;
