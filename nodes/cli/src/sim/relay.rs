//! A relay on the ways of messages that loses, delays, repeats and falsifies them.

use super::message::{Content, Lane, Message};
use anyhow::bail;
use models::units::Seconds;
use printer_sim::camera::Frame;
use printer_sim::sensors::Noise;
use serde::Deserialize;

/// Random stream of the relay; those of the simulated printer are below ten.
const STREAM: u64 = 40;
/// Session of a second publisher, unlike those of the loop's own.
pub const RIVAL_SESSION: u64 = 999;
/// What a share of messages that do not arrive delays a stream of 50 Hz by `[s]`: ten of them.
const LOST_S: f64 = 0.2;
/// Flow that a second publisher asks for `[-]`, allowed, and unlike any that a loop comes to by itself.
pub const RIVAL_FLOW: f64 = 1.078_125;

/// What is done to the messages of some ways.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tampering {
    /// Whose messages.
    pub lanes: Vec<Lane>,
    /// What is done.
    pub how: How,
    /// Share of the messages that suffer `[0, 1]`.
    #[serde(default = "all")]
    pub share: f64,
}

impl Tampering {
    /// Refuses what does nothing and numbers that mean nothing.
    ///
    /// # Errors
    /// Names field, value and range.
    pub fn check(&self) -> anyhow::Result<()> {
        if self.lanes.is_empty() {
            bail!("relay: lanes is empty");
        }
        if !(self.share > 0.0 && self.share <= 1.0) {
            bail!("relay: share = {}: must be in (0, 1]", self.share);
        }
        match self.how {
            How::Delay(low_s, high_s) if !(low_s >= 0.0 && low_s <= high_s && high_s <= 60.0) => {
                bail!("relay: delay = [{low_s}, {high_s}] s: must be in [0, 60] and rise")
            }
            How::MoveStamp(by_s) if by_s.is_nan() || by_s.abs() > 1e6 => {
                bail!("relay: move_stamp = {by_s} s: must be in [-1e6, 1e6]")
            }
            How::CutPicture | How::OldPicture | How::GreyPicture if self.lanes != [Lane::Frames] => {
                bail!("relay: only the lane frames carries pictures")
            }
            How::NotANumber | How::Infinite | How::Absurd
                if self.lanes.iter().any(|lane| matches!(lane, Lane::Frames | Lane::Estimate)) =>
            {
                bail!("relay: the lanes frames and estimate carry no number that could be falsified")
            }
            How::Rival if self.lanes.iter().any(|lane| !matches!(lane, Lane::Command | Lane::Permit)) => {
                bail!("relay: only the lanes command and permit have a second publisher")
            }
            _ => Ok(()),
        }
    }

    /// Longest time for which it keeps back a message of a way `[s]`; infinite where none arrives.
    pub fn keeps_back_s(&self, lane: Lane) -> f64 {
        match self.how {
            _ if !self.lanes.contains(&lane) => 0.0,
            How::Delay(_, high_s) => high_s,
            How::Lose if self.share >= 1.0 => f64::INFINITY,
            // The next one that arrives says the same; a chance of .3 ten times in a row is one in 10^5.
            How::Lose => LOST_S,
            _ => 0.0,
        }
    }
}

fn all() -> f64 {
    1.0
}

/// What is done to a message.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum How {
    /// It does not arrive: its sender is dead or hangs, or the way is cut.
    Lose,
    /// It arrives twice.
    Repeat,
    /// It arrives late by a time that is equally likely anywhere between two `[s]`; messages overtake each other.
    Delay(f64, f64),
    /// It arrives with its stamp moved by this much `[s]`.
    MoveStamp(f64),
    /// It arrives with the stamp zero.
    ZeroStamp,
    /// Its first number is not a number.
    NotANumber,
    /// Its first number is infinite.
    Infinite,
    /// Its first number is far outside of what it can be.
    Absurd,
    /// A second publisher asks for a flow of its own.
    Rival,
    /// Its picture is cut off after half of its bytes.
    CutPicture,
    /// Its picture is that of the first message that suffered: the camera's driver hangs.
    OldPicture,
    /// Its picture is one grey: a lens cap, a lamp into the lens.
    GreyPicture,
}

/// A relay in its place.
#[derive(Debug, Clone)]
pub struct Relay {
    tamperings: Vec<Tampering>,
    noise: Noise,
    held: Vec<(f64, Message)>,
    active: bool,
    kept: Option<Vec<u8>>,
}

impl Relay {
    /// A relay that lets everything through until it is told.
    #[must_use]
    pub fn new(tamperings: Vec<Tampering>, seed: u64) -> Self {
        Self { tamperings, noise: Noise::new(seed, STREAM), held: Vec::new(), active: false, kept: None }
    }

    /// Begins or ends what it does.
    pub fn set_active(&mut self, active: bool) {
        self.active = active;
    }

    /// Whether it does anything now.
    #[must_use]
    pub fn is_active(&self) -> bool {
        self.active
    }

    /// What of a message arrives at once; the rest comes by [`Self::due`].
    pub fn pass(&mut self, now: Seconds, message: Message) -> Vec<Message> {
        let lane = message.lane();
        let mut through = vec![message];
        for tampering in self.tamperings.clone() {
            if tampering.lanes.contains(&lane) && self.noise.between((0.0, 1.0)) < tampering.share {
                through = through.into_iter().flat_map(|one| self.suffer(now, tampering.how, one)).collect();
            }
        }
        through
    }

    /// Messages whose time has come.
    pub fn due(&mut self, now: Seconds) -> Vec<Message> {
        if self.held.is_empty() {
            return Vec::new();
        }
        let (due, held): (Vec<_>, Vec<_>) = self.held.drain(..).partition(|(at_s, _)| *at_s <= now.0);
        self.held = held;
        due.into_iter().map(|(_, message)| message).collect()
    }

    fn suffer(&mut self, now: Seconds, how: How, mut message: Message) -> Vec<Message> {
        match how {
            How::Lose => return Vec::new(),
            How::Repeat => return vec![message.clone(), message],
            How::Delay(low_s, high_s) => {
                let late_s = if low_s < high_s { self.noise.between((low_s, high_s)) } else { low_s };
                self.held.push((now.0 + late_s, message));
                return Vec::new();
            }
            How::Rival => return vec![message.clone(), rival(message)],
            How::MoveStamp(by_s) => message.stamp.0 += by_s,
            How::ZeroStamp => message.stamp = Seconds(0.0),
            How::NotANumber => falsify(&mut message.content, f64::NAN),
            How::Infinite => falsify(&mut message.content, f64::INFINITY),
            How::Absurd => falsify(&mut message.content, 1e9),
            How::CutPicture | How::OldPicture | How::GreyPicture => self.spoil(how, &mut message.content),
        }
        vec![message]
    }

    fn spoil(&mut self, how: How, content: &mut Content) {
        let Content::Frame(jpeg) = content else { return };
        match how {
            How::CutPicture => jpeg.truncate(jpeg.len() / 2),
            How::OldPicture => jpeg.clone_from(self.kept.get_or_insert_with(|| jpeg.clone())),
            How::GreyPicture => *jpeg = grey_like(jpeg),
            _ => {}
        }
    }
}

/// What a second publisher says at the same time.
fn rival(mut message: Message) -> Message {
    let (session, trims) = match &mut message.content {
        Content::Command(command, _) => (&mut command.session, &mut command.trims),
        Content::Permit(permit) => (&mut permit.session, &mut permit.trims),
        _ => return message,
    };
    (*session, trims.flow) = (RIVAL_SESSION, RIVAL_FLOW);
    message
}

/// Puts `value` where the message's first number is.
fn falsify(content: &mut Content, value: f64) {
    match content {
        Content::Hotend(temp) | Content::Bed(temp) | Content::Nozzle(temp) => temp.0 = value,
        Content::Encoder(position_m) => *position_m = value,
        Content::Printer(status) => status.hotend_duty = value,
        Content::Imu(batch) => {
            if let Some(sample) = batch.samples.first_mut() {
                sample[0] = value;
            }
        }
        Content::Vision(report) => report.confidence = value,
        Content::Command(command, _) => command.trims.flow = value,
        Content::Permit(permit) => permit.trims.flow = value,
        Content::Frame(_) | Content::Estimate(_) => {}
    }
}

/// A picture of one grey, as large as a baseline JPEG.
fn grey_like(jpeg: &[u8]) -> Vec<u8> {
    // Frame header: marker, two bytes of length, one of precision, then height and width.
    let size = jpeg.windows(9).find(|bytes| bytes[..2] == [0xff, 0xc0]).map(|bytes| {
        let pair = |at: usize| usize::from(u16::from_be_bytes([bytes[at], bytes[at + 1]]));
        (pair(7), pair(5))
    });
    let Some((width_px, height_px)) = size else { return Vec::new() };
    let frame = Frame { width_px, height_px, grey: vec![128; width_px * height_px] };
    frame.jpeg(90).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What would pass unharmed would be a trial that shows nothing.
    #[test]
    fn what_a_lane_cannot_suffer_is_refused() {
        let check = |how, lanes: &[Lane]| Tampering { lanes: lanes.to_vec(), how, share: 1.0 }.check();
        for how in [How::NotANumber, How::Infinite, How::Absurd] {
            assert!(check(how, &[Lane::Hotend, Lane::Vision]).is_ok());
            let refused = check(how, &[Lane::Hotend, Lane::Estimate]).unwrap_err().to_string();
            assert!(refused.contains("no number"), "{refused}");
        }
        assert!(check(How::Rival, &[Lane::Command, Lane::Permit]).is_ok());
        assert!(check(How::Rival, &[Lane::Command, Lane::Encoder]).is_err());
        assert!(
            check(How::GreyPicture, &[Lane::Frames]).is_ok()
                && check(How::GreyPicture, &[Lane::Imu]).is_err()
        );
    }
}
