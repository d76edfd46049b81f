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

    /// Motor speed `[m/s]` for this step; `encoder_m` is what the filament encoder reads now.
    pub fn step(&mut self, feed: Feed, trims: &Trims, goal: Goal, (encoder_m, dt_s): (f64, f64)) -> f64 {
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
                let slip = self.prime.slip(slip, feed.other_m_s > 0.0, (self.motor_m, encoder_m));
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
    fn compensated(&mut self, wanted_m_s: f64, slip: f64, (encoder_m, dt_s): (f64, f64)) -> f64 {
        let forward_m_s = if wanted_m_s > 0.0 { wanted_m_s / (1.0 - slip) } else { wanted_m_s };
        if self.host != HostProfile::Native {
            return forward_m_s;
        }
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
mod tests {
    use super::*;

    const SETTINGS: Settings = Settings {
        loop_gain_1_s: 1.5,
        shortfall_kept_m: 2e-4,
        shortfall_fades_s: 0.7,
        loop_period_s: 0.01,
        advance_smooth_s: 0.02,
    };
    const DEPOSIT: Feed = Feed { deposited_m_s: 2e-3, other_m_s: 0.0 };

    /// Runs one second at 1 ms with a gear that loses `slip`; returns (wanted, motor, delivered) in metres.
    fn one_second(drive: &mut Drive, trims: &Trims, slip: f64) -> (f64, f64, f64) {
        let mut delivered_m = 0.0;
        for _ in 0..1000 {
            delivered_m +=
                (1.0 - slip) * drive.step(DEPOSIT, trims, Goal::Now(0.0, 0.0), (delivered_m, 1e-3)) * 1e-3;
        }
        (drive.wanted_m(), drive.motor_m(), delivered_m)
    }

    #[test]
    fn an_open_loop_passes_the_slicers_feed_on() {
        let mut drive = Drive::new(SETTINGS, HostProfile::Native);
        let (wanted_m, motor_m, delivered_m) = one_second(&mut drive, &Trims::NEUTRAL, 0.09);
        assert!((wanted_m - 2e-3).abs() < 1e-12 && (motor_m - 2e-3).abs() < 1e-12);
        assert!((delivered_m - 0.91 * 2e-3).abs() < 1e-12);
    }

    #[test]
    fn a_known_slip_is_made_up_for_at_once() {
        let trims = Trims { slip: Some(0.09), ..Trims::NEUTRAL };
        for host in [HostProfile::Native, HostProfile::Serial] {
            let (wanted_m, _, delivered_m) = one_second(&mut Drive::new(SETTINGS, host), &trims, 0.09);
            assert!((delivered_m / wanted_m - 1.0).abs() < 1e-9, "{host:?}");
        }
    }

    #[test]
    fn the_native_loop_catches_up_an_unknown_slip_and_the_serial_host_cannot() {
        let trims = Trims { slip: Some(0.0), ..Trims::NEUTRAL };
        let shortfall_after = |host| {
            let mut drive = Drive::new(SETTINGS, host);
            let (mut delivered_m, mut last) = (0.0, 0.0);
            for _ in 0..10_000 {
                delivered_m +=
                    0.91 * drive.step(DEPOSIT, &trims, Goal::Now(0.0, 0.0), (delivered_m, 1e-3)) * 1e-3;
                last = drive.wanted_m() - delivered_m;
            }
            last
        };
        // Steady state of the loop: 0.91 (v + k e) = v, e = v (1/0.91 - 1) / k = 0.132 mm.
        assert!((shortfall_after(HostProfile::Native) - 2e-3 * (1.0 / 0.91 - 1.0) / 1.5).abs() < 2e-6);
        assert!((shortfall_after(HostProfile::Serial) - 0.09 * 2e-2).abs() < 1e-9);
    }

    /// `dE/dt = v - 0.7 (v + k E) - (E - kept)/tau`: at rest `E = 0.357 mm`, and what fades is lost to the roads.
    #[test]
    fn what_was_laid_thin_long_ago_is_not_pushed_into_later_roads() {
        let trims = Trims { slip: Some(0.0), ..Trims::NEUTRAL };
        let mut drive = Drive::new(SETTINGS, HostProfile::Native);
        let (mut delivered_m, mut before_m) = (0.0, 0.0);
        for step in 0..10_000 {
            before_m = if step == 9_000 { delivered_m } else { before_m };
            delivered_m += 0.7 * drive.step(DEPOSIT, &trims, Goal::Now(0.0, 0.0), (delivered_m, 1e-3)) * 1e-3;
        }
        let shortfall_m = (0.3 * 2e-3 + 2e-4 / 0.7) / (0.7 * 1.5 + 1.0 / 0.7);
        let expected_m = 2e-3 - (shortfall_m - 2e-4) / 0.7;
        assert!((delivered_m - before_m - expected_m).abs() < 4e-6, "{}", delivered_m - before_m);
    }

    #[test]
    fn advance_displaces_by_k_times_the_feed_and_is_withdrawn_at_the_end() {
        let mut drive = Drive::new(SETTINGS, HostProfile::Native);
        for _ in 0..500 {
            drive.step(DEPOSIT, &Trims::NEUTRAL, Goal::Now(0.5, 0.0), (0.0, 1e-3));
        }
        assert!((drive.wanted_m() - (1e-3 + 0.5 * 2e-3)).abs() < 1e-9);
        for _ in 0..500 {
            drive.step(Feed::default(), &Trims::NEUTRAL, Goal::Now(0.5, 0.0), (0.0, 1e-3));
        }
        assert!((drive.wanted_m() - 1e-3).abs() < 1e-9);
    }

    #[test]
    fn a_retraction_is_neither_trimmed_nor_compensated() {
        let mut drive = Drive::new(SETTINGS, HostProfile::Native);
        let trims = Trims { flow: 1.2, slip: Some(0.3), ..Trims::NEUTRAL };
        let speed = drive.step(
            Feed { deposited_m_s: 0.0, other_m_s: -0.035 },
            &trims,
            Goal::Now(0.5, 0.0),
            (-1.0, 1e-3),
        );
        assert!((speed + 0.035).abs() < 1e-12);
    }
    /// 20 mm at 5 mm/s, of which the gear loses half: the loop would push twice as hard, and grind.
    #[test]
    fn a_purge_is_passed_on_as_it_is_behind_the_length_of_a_prime() {
        let mut drive = Drive::new(SETTINGS, HostProfile::Native);
        let trims = Trims { slip: Some(0.3), ..Trims::NEUTRAL };
        let purge = Feed { deposited_m_s: 0.0, other_m_s: 5e-3 };
        let mut push = |feed, ms: u32| {
            let speeds =
                (0..ms).map(|_| drive.step(feed, &trims, Goal::Now(0.0, 0.0), (0.5 * drive.motor_m(), 1e-3)));
            speeds.last().unwrap_or_default()
        };
        assert!(push(purge, 1_000) > 6e-3, "a prime is compensated");
        assert!((push(purge, 3_000) - 5e-3).abs() < 1e-12, "a purge is not");
        assert!(push(DEPOSIT, 10) > 2.8e-3, "a road is again");
    }
}
