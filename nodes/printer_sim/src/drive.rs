//! From the slicer's filament feed to the motor: flow trim, pressure advance, slip compensation.
//!
//! ```text
//! wanted  = slicer's feed x flow + d/dt(advance)      advance -> K v_feed, smoothed
//! motor   = wanted / (1 - s) + k (wanted position - encoder position)     native host, loop closed
//!         = wanted / (1 - s)                                             other hosts
//! ```
//! What is lacking has been laid thin; what the melt still lacks of its pressure is as much as the feed lost within the
//! melt's lag. Only that is made up for: to push all of it later would make one thin road and one fat. Hence a
//! shortfall beyond `shortfall_kept_m` fades with `shortfall_fades_s`, as long as filament is fed.
//!
//! A purge, pushed without a road for longer than any prime, is passed on as it is: no road misses what it lacks, and beyond
//! what the nozzle melts more push grinds the filament.
//!
//! A prime after a retraction meets less force than a road, and slips less: the native host learns its slip by itself.
//! Model book 1.7 (inner loop) and 2.2 (advance). What is scheduled is known ahead: the advance then goes through a
//! window centred on now, as Klipper's does, instead of the lag of a drive that only sees what it executes.

use models::command::Trims;
use models::status::HostProfile;

/// What the planner asks of the extruder over one step, at the executed pace.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Feed {
    /// Filament speed into roads `[m/s]`: flow trim and advance apply.
    pub deposited_m_s: f64,
    /// Filament speed without a road `[m/s]`: retraction (negative), priming.
    pub other_m_s: f64,
}

/// Settings of the drive; from `config/printer_sim.param.yaml`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Gain on the encoder's shortfall `[1/s]`.
    pub loop_gain_1_s: f64,
    /// Shortfall that is made up for whatever its age `[m]`.
    pub shortfall_kept_m: f64,
    /// Time constant with which a shortfall beyond that fades: the melt's lag `[s]`.
    pub shortfall_fades_s: f64,
    /// Period of the firmware's extruder loop `[s]`.
    pub loop_period_s: f64,
    /// Time constant with which the advance displacement follows `[s]`.
    pub advance_smooth_s: f64,
}

/// Longest way that a prime pushes without a road, through a Bowden tube `[m]`: beyond it is a purge.
const PRIME_MAX_M: f64 = 0.01;

mod prime;
mod window;

use prime::Prime;
use window::Window;

/// What the advance follows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Goal {
    /// `K_A` times the feed of now `[s]`, less what is held without it `[m]`.
    Now(f64, f64),
    /// Filament to be held compressed half a window from now `[m]`.
    Ahead(f64),
}

/// State of the drive.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    settings: Settings,
    host: HostProfile,
    advance_m: f64,
    window: Option<Window>,
    wanted_m: f64,
    motor_m: f64,
    loop_target: Option<LoopTarget>,
    prime: Prime,
    /// Pushed without a road since the last road or retraction `[m]`.
    pushed_m: f64,
    correction_m_s: f64,
    until_loop_s: f64,
}

/// Origin of the closed loop: set when it closes, so that closing it moves nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LoopTarget {
    wanted_m: f64,
    encoder_m: f64,
}

impl Drive {
    /// A drive at rest.
    #[must_use]
    pub fn new(settings: Settings, host: HostProfile) -> Self {
        Self {
            settings,
            host,
            advance_m: 0.0,
            window: None,
            wanted_m: 0.0,
            motor_m: 0.0,
            loop_target: None,
            prime: Prime::default(),
            pushed_m: 0.0,
            correction_m_s: 0.0,
            until_loop_s: 0.0,
        }
    }

    /// Filament that ought to have passed the gear `[m]`.
    #[must_use]
    pub fn wanted_m(&self) -> f64 {
        self.wanted_m
    }

    /// Filament that the motor was told to push `[m]`.
    #[must_use]
    pub fn motor_m(&self) -> f64 {
        self.motor_m
    }

    /// Motor speed `[m/s]` for this step; `encoder_m` is what the filament encoder reads now, where one is fitted.
    pub fn step(
        &mut self,
        feed: Feed,
        trims: &Trims,
        goal: Goal,
        (encoder_m, dt_s): (Option<f64>, f64),
    ) -> f64 {
        let into_roads_m_s = feed.deposited_m_s * trims.flow;
        let before_m = self.advance_m;
        match goal {
            Goal::Now(advance_s, carried_m) => {
                let goal_m = advance_s * into_roads_m_s - carried_m;
                let share = 1.0 - (-dt_s / self.settings.advance_smooth_s).exp();
                self.advance_m += (goal_m - before_m) * share;
                self.window = None;
            }
            Goal::Ahead(goal_m) => {
                let half_s = self.settings.advance_smooth_s;
                let window = self.window.get_or_insert_with(|| Window::new(before_m, (half_s, dt_s)));
                self.advance_m = window.step(goal_m);
            }
        }
        let wanted_m_s = into_roads_m_s + feed.other_m_s + (self.advance_m - before_m) / dt_s;

        let pushes = feed.other_m_s > 0.0 && feed.deposited_m_s <= 0.0;
        self.pushed_m = if pushes { self.pushed_m + feed.other_m_s * dt_s } else { 0.0 };
        let motor_m_s = match trims.slip.filter(|_| self.pushed_m <= PRIME_MAX_M) {
            None => {
                self.open_loop();
                wanted_m_s
            }
            Some(slip) => {
                let slip = encoder_m.map_or(slip, |encoder_m| {
                    self.prime.slip(slip, feed.other_m_s > 0.0, (self.motor_m, encoder_m))
                });
                self.compensated(wanted_m_s, slip, (encoder_m, dt_s))
            }
        };
        self.wanted_m += wanted_m_s * dt_s;
        self.motor_m += motor_m_s * dt_s;
        motor_m_s
    }

    fn open_loop(&mut self) {
        self.loop_target = None;
        self.prime = Prime::default();
        self.correction_m_s = 0.0;
        self.until_loop_s = 0.0;
    }

    /// Filament slips when it is pushed; a retraction is passed on as it is.
    fn compensated(&mut self, wanted_m_s: f64, slip: f64, (encoder_m, dt_s): (Option<f64>, f64)) -> f64 {
        let forward_m_s = if wanted_m_s > 0.0 { wanted_m_s / (1.0 - slip) } else { wanted_m_s };
        let (Some(encoder_m), HostProfile::Native) = (encoder_m, self.host) else { return forward_m_s };
        let origin = self.loop_target.get_or_insert(LoopTarget { wanted_m: self.wanted_m, encoder_m });
        self.until_loop_s -= dt_s;
        if self.until_loop_s <= 0.0 {
            let settings = &self.settings;
            self.until_loop_s += settings.loop_period_s;
            let shortfall_m = (self.wanted_m - origin.wanted_m) - (encoder_m - origin.encoder_m);
            self.correction_m_s = settings.loop_gain_1_s * shortfall_m;
            if wanted_m_s > 0.0 {
                let kept_m = shortfall_m.clamp(-settings.shortfall_kept_m, settings.shortfall_kept_m);
                let share = (settings.loop_period_s / settings.shortfall_fades_s).min(1.0);
                origin.wanted_m += (shortfall_m - kept_m) * share;
            }
        }
        // The loop only tops up a feed: at rest and in a retraction it would push filament into nothing.
        if wanted_m_s > 0.0 { (forward_m_s + self.correction_m_s).max(0.0) } else { forward_m_s }
    }
}

#[cfg(test)]
mod tests;
