//! Pictures of what was flagged and of what led to decisions: few, small, checked before they go into a page.

use super::super::decode::short;
use super::events::coded;
use fdm_loop_msgs::{CompressedImage, DefectReport, PrintEvent};
use std::collections::VecDeque;

/// Pictures on the page.
const PICTURES_MAX: usize = 12;
/// Longest picture `[byte]`.
const BYTES_MAX: usize = 160_000;
/// Bytes of all pictures: two thirds of the page's 3 MB hold a third more as base64.
const TOTAL_MAX: usize = 1_300_000;
/// Pictures and reports that wait for their partner.
const WAIT: usize = 16;
/// Events of which the picture is wanted though they are no errors.
const DECISIONS: [&str; 3] = ["mode_changed", "cause_changed", "impulse"];
/// A picture tells of an event no older than this `[s]`.
const BEFORE_S: f64 = 10.0;
/// Or no later.
const AFTER_S: f64 = 3.0;

/// What a picture shows and why it stands there.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Picture {
    pub(crate) at: f64,
    pub(crate) media: &'static str,
    pub(crate) data: Vec<u8>,
    pub(crate) title: String,
    pub(crate) detail: String,
    weight: f64,
}

#[derive(Debug, Clone)]
struct Frame {
    at: f64,
    media: &'static str,
    data: Vec<u8>,
    annotated: bool,
}

#[derive(Debug, Clone, PartialEq)]
struct Wanted {
    at: f64,
    title: String,
    detail: String,
    weight: f64,
    /// Taken for a report: the frame of that very moment; for an event: one near it.
    exact: bool,
}

/// All pictures of a bag that may go onto the page.
#[derive(Debug, Default)]
pub(crate) struct Pictures {
    chosen: Vec<Picture>,
    frames: VecDeque<Frame>,
    wanted: VecDeque<Wanted>,
    episode: Option<(String, f64)>,
    /// What the camera's judge said of the newest frames.
    said: VecDeque<(f64, String)>,
    /// Frames that were seen.
    pub(crate) seen: u64,
    /// Frames that are no picture, or too large.
    pub(crate) refused: u64,
    /// Pictures for which there was no room.
    pub(crate) left_out: u64,
    has_annotated: bool,
}

impl Pictures {
    pub(crate) fn annotated(&mut self, at: f64, image: CompressedImage) {
        if !self.has_annotated {
            // From here on the raw frames are not needed.
            self.has_annotated = true;
            self.frames.clear();
        }
        self.frame(at, image, true);
    }

    pub(crate) fn camera(&mut self, at: f64, image: CompressedImage) {
        if !self.has_annotated {
            self.frame(at, image, false);
        }
    }

    fn frame(&mut self, at: f64, image: CompressedImage, annotated: bool) {
        self.seen += 1;
        match media(&image.data).filter(|_| image.data.len() <= BYTES_MAX) {
            Some(media) => {
                self.frames.push_back(Frame { at, media, data: image.data, annotated });
                if self.frames.len() > WAIT {
                    self.frames.pop_front();
                }
                self.join(at);
            }
            None => self.refused += 1,
        }
    }

    /// A report: the first frame of each episode with one cause is wanted, and its surest one.
    pub(crate) fn report(&mut self, at: f64, report: DefectReport) {
        self.said.push_back((at, said_of(&report)));
        if self.said.len() > WAIT * 2 {
            self.said.pop_front();
        }
        let flagged = report.usable && report.cause != "ok" && (report.confirmed || report.confidence >= 0.5);
        if !flagged || !report.confidence.is_finite() {
            self.episode = None;
            return;
        }
        let surer = match &self.episode {
            Some((cause, confidence)) if *cause == report.cause => report.confidence > *confidence + 0.1,
            _ => true,
        };
        if !surer {
            return;
        }
        let cause = short(&report.cause, 60);
        self.episode = Some((report.cause.clone(), report.confidence));
        let detail = format!(
            "confidence c_k {:.2}, detection {:.2}, {} of {} frames in favour{}",
            report.confidence,
            report.detection,
            report.in_favour,
            report.window,
            beside(&report)
        );
        let weight = report.confidence + if report.confirmed { 1.0 } else { 0.0 };
        self.want(Wanted { at, title: cause, detail, weight, exact: true });
    }

    /// A warning or an error: what the camera saw then is wanted.
    pub(crate) fn event(&mut self, at: f64, event: &PrintEvent) {
        if !DECISIONS.contains(&event.what.as_str()) && event.severity < 2 {
            return;
        }
        let title = if event.before == event.after {
            short(&event.what, 60)
        } else {
            format!("{} → {}", short(&event.before, 40), short(&event.after, 40))
        };
        let weight = 2.0 + f64::from(event.severity.min(2));
        self.want(Wanted { at, title, detail: short(&coded(&event.why), 160), weight, exact: false });
    }

    fn want(&mut self, wanted: Wanted) {
        let at = wanted.at;
        self.wanted.push_back(wanted);
        if self.wanted.len() > WAIT * 2 {
            self.wanted.pop_front();
        }
        self.join(at);
    }

    /// Joins frames and wishes that belong together.
    fn join(&mut self, now: f64) {
        let mut waiting = std::mem::take(&mut self.wanted);
        waiting.retain(|wanted| {
            let (before, after) = if wanted.exact { (1e-3, 1e-3) } else { (-0.0, AFTER_S) };
            let fits = |frame: &&Frame| (-before..=after).contains(&(frame.at - wanted.at));
            if let Some(frame) = self.frames.iter().find(fits) {
                let picture = self.shown(frame, wanted);
                self.choose(picture);
                return false;
            }
            now - wanted.at <= AFTER_S || self.settle(wanted)
        });
        self.wanted = waiting;
    }

    /// The newest frame before an event whose own never came. Always `false`: the wish is gone.
    fn settle(&mut self, wanted: &Wanted) -> bool {
        let before = |frame: &&Frame| (0.0..BEFORE_S).contains(&(wanted.at - frame.at));
        if let Some(frame) = self.frames.iter().rev().find(before).filter(|_| !wanted.exact) {
            let picture = self.shown(frame, wanted);
            self.choose(picture);
        }
        false
    }

    fn choose(&mut self, picture: Picture) {
        self.chosen.push(picture);
        while self.chosen.len() > PICTURES_MAX
            || self.chosen.iter().map(|kept| kept.data.len()).sum::<usize>() > TOTAL_MAX
        {
            let lightest = self.chosen.iter().enumerate().min_by(|a, b| a.1.weight.total_cmp(&b.1.weight));
            let Some((index, _)) = lightest else { return };
            self.chosen.remove(index);
            self.left_out += 1;
        }
    }

    fn shown(&self, frame: &Frame, wanted: &Wanted) -> Picture {
        let mut detail = wanted.detail.clone();
        let said = self.said.iter().rev().find(|(at, _)| (at - frame.at).abs() < 1e-3);
        if let Some((_, said)) = said.filter(|_| !wanted.exact) {
            detail = format!("{detail}; {said}");
        }
        if !frame.annotated {
            detail.push_str(" (frame of the camera, nothing drawn in)");
        }
        let (title, weight) = (wanted.title.clone(), wanted.weight);
        Picture { at: wanted.at, media: frame.media, data: frame.data.clone(), title, detail, weight }
    }

    /// After the last message: what still waits, and the last frame where nothing was flagged.
    pub(crate) fn finish(&mut self) {
        for wanted in std::mem::take(&mut self.wanted) {
            self.settle(&wanted);
        }
        if self.chosen.is_empty()
            && let Some(frame) = self.frames.back()
        {
            let title = "last frame".to_owned();
            let detail = "no frame was flagged".to_owned();
            let wanted = Wanted { at: frame.at, title, detail, weight: 0.0, exact: true };
            self.chosen.push(self.shown(frame, &wanted));
        }
        self.frames.clear();
    }

    /// The pictures in the order of their times.
    pub(crate) fn chosen(&self) -> Vec<&Picture> {
        let mut chosen: Vec<&Picture> = self.chosen.iter().collect();
        chosen.sort_by(|a, b| a.at.total_cmp(&b.at));
        chosen
    }
}

/// What the camera's judge says of a frame; the line in the picture is the same in short.
fn said_of(report: &DefectReport) -> String {
    if !report.usable {
        return "the camera's judge could not use this frame".to_owned();
    }
    let (cause, sure) = (short(&report.cause, 60), report.confidence);
    format!("the camera's judge calls this frame {cause}, confidence c_k {sure:.2}{}", beside(report))
}

/// Offset of the layers in a frame, where it is known.
fn beside(report: &DefectReport) -> String {
    if !report.offset_known {
        return String::new();
    }
    let [x, y] = report.offset_m.map(|m| m * 1e3);
    format!(", layers lie {x:+.2} mm, {y:+.2} mm beside")
}

/// Kind of a picture by its first bytes; a name in the message is not believed.
fn media(data: &[u8]) -> Option<&'static str> {
    match data {
        [0xff, 0xd8, 0xff, ..] => Some("image/jpeg"),
        [0x89, b'P', b'N', b'G', 0x0d, 0x0a, 0x1a, 0x0a, ..] => Some("image/png"),
        _ => None,
    }
}
