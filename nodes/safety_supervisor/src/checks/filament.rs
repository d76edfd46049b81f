//! P6, P7: the encoder against the length the motor was told to push.
//!
//! Both are reduced to their forward way through a play, the backlash of drive gear and tube: retractions and
//! their way back count as strokes forward, jitter at rest does not count at all. Over a sliding window of the
//! motor's way the share that the encoder has not seen is slip. A stroke that slips is as long again on the motor's side,
//! and so is the play at its beginning: at the limit both lose the same share of short strokes, which would else be found
//! to slip more than long ones.
//!
//! An encoder that reads more than the motor has gone, to and fro and without any play, tells nothing of slip: jitter, or
//! another unit. Then nobody watches over the filament, and that is told. For it both are looked at when the printer tells its
//! state: between two states that are far apart the motor strokes to and fro, which the encoder alone would be seen to do.

use models::units::Seconds;

use crate::params::FilamentParams;

/// Marks kept over the window.
const MARKS: usize = 16;
/// A message that is older than the newest by no more was overtaken on its way; by more, its clock was set back `[s]`.
const OVERTAKEN_S: f64 = 0.5;
/// Marks in a row at which an encoder that reads too much has done so for three windows. A state that comes late makes it
/// lead for one.
const TOO_MUCH: u32 = 48;

/// Forward way of a position with play.
#[derive(Debug, Clone, Copy, Default)]
struct Way {
    held_m: Option<f64>,
    forward_m: f64,
}

impl Way {
    fn follow(&mut self, position_m: f64, play_m: f64) {
        let held_m = self.held_m.unwrap_or(position_m);
        self.forward_m += (position_m - held_m).max(0.0);
        self.held_m = Some(if position_m > held_m { position_m } else { held_m.min(position_m + play_m) });
    }
}

/// Tells messages that were overtaken: they say nothing new, and taken for a way back and forth would be counted twice.
#[derive(Debug, Clone, Copy, Default)]
struct Order {
    newest: Option<Seconds>,
}

impl Order {
    fn takes(&mut self, stamp: Seconds) -> bool {
        let overtaken = self.newest.is_some_and(|newest| (0.0..=OVERTAKEN_S).contains(&(newest - stamp).0));
        if !overtaken {
            self.newest = Some(stamp);
        }
        !overtaken
    }
}

/// Watches slip and run-out.
#[derive(Debug, Clone)]
pub struct FilamentCheck {
    params: FilamentParams,
    motor: Way,
    /// The motor's without play: no sound encoder reads more.
    whole: Way,
    encoder: Way,
    order_of_encoder: Order,
    order_of_motor: Order,
    /// The encoder's at the moments of the motor's, and where it is now `[m]`.
    beside: Way,
    encoder_m: Option<f64>,
    /// The encoder was heard since the motor's last position that was compared.
    heard: bool,
    marks: [Option<Mark>; MARKS],
    /// Newest marks in a row at which the encoder read too much.
    too_much: u32,
}

/// Ways forward at one moment `[m]`.
#[derive(Debug, Clone, Copy)]
struct Mark {
    motor_m: f64,
    whole_m: f64,
    encoder_m: f64,
    beside_m: f64,
}

impl FilamentCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: FilamentParams) -> Self {
        let way = Way::default();
        let (marks, too_much) = ([None; MARKS], 0);
        Self {
            params,
            motor: way,
            whole: way,
            encoder: way,
            order_of_encoder: Order::default(),
            order_of_motor: Order::default(),
            beside: way,
            encoder_m: None,
            heard: false,
            marks,
            too_much,
        }
    }

    /// Takes the encoder's position at `stamp`.
    pub fn on_encoder(&mut self, stamp: Seconds, position_m: f64) {
        self.heard = true;
        if self.order_of_encoder.takes(stamp) {
            self.encoder.follow(position_m, self.params.play_m);
            self.encoder_m = Some(position_m);
        }
    }

    /// Takes the motor's position at `stamp`. While nothing is heard of the encoder nobody knows what it makes of the motor's
    /// way: that is compared when it is heard again.
    pub fn on_motor(&mut self, stamp: Seconds, position_m: f64) {
        if !(self.order_of_motor.takes(stamp) && std::mem::take(&mut self.heard)) {
            return;
        }
        self.motor.follow(position_m, self.params.play_m / (1.0 - self.params.slip_max));
        self.whole.follow(position_m, 0.0);
        if let Some(encoder_m) = self.encoder_m {
            self.beside.follow(encoder_m, self.params.play_m);
        }
        let spacing_m = self.params.window_m / (MARKS - 1) as f64;
        let newest_m = self.marks[MARKS - 1].map(|mark| mark.motor_m);
        if self.encoder.held_m.is_some()
            && newest_m.is_none_or(|newest_m| self.motor.forward_m - newest_m >= spacing_m)
        {
            self.marks.rotate_left(1);
            self.marks[MARKS - 1] = Some(Mark {
                motor_m: self.motor.forward_m,
                whole_m: self.whole.forward_m,
                encoder_m: self.encoder.forward_m,
                beside_m: self.beside.forward_m,
            });
            let beyond = self.surplus().is_some_and(|surplus| surplus > self.params.surplus_max);
            self.too_much = if beyond { self.too_much.saturating_add(1) } else { 0 };
        }
    }

    /// Slip over the window `[-]`, `None` until the motor has gone that far.
    #[must_use]
    pub fn slip(&self) -> Option<f64> {
        let from = self.marks[0]?;
        let pushed_m = self.motor.forward_m - from.motor_m;
        Some(1.0 - (self.encoder.forward_m - from.encoder_m) / pushed_m)
    }

    /// What the encoder reads beyond the motor's way over the window `[-]`, `None` until the motor has gone that far.
    #[must_use]
    pub fn surplus(&self) -> Option<f64> {
        let from = self.marks[0]?;
        let went_m = self.whole.forward_m - from.whole_m;
        Some((self.beside.forward_m - from.beside_m) / went_m - 1.0)
    }

    /// Whether the encoder reads more than any filament can have gone.
    #[must_use]
    pub fn reads_too_much(&self) -> bool {
        self.too_much >= TOO_MUCH
    }

    /// Whether more was lost than allowed.
    #[must_use]
    pub fn tripped(&self) -> bool {
        self.slip().is_some_and(|slip| slip > self.params.slip_max)
    }

    /// Forgets the way so far: after a resume or a gap of either stream.
    pub fn reset(&mut self) {
        *self = Self::new(self.params);
    }
}
