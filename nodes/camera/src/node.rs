//! The shell: frames of the printer, a folder, OpenCV or an MJPEG server in; checked frames and calibration out.

pub mod driver;
mod encode;
pub mod folder;
pub mod mjpeg;
pub mod video;
mod worker;

use fdm_loop_msgs::{CameraInfo, CompressedImage};
use models::units::Seconds;
use runtime::{
    Clock, Diagnostics, Inlet, Level, Node, Presence, Publisher, Reason, Refused, RuntimeError, Timer, topics,
};

use crate::convert;
use crate::frames::Frames;
use crate::params::{CameraParams, Driver, LIVE, Params, VideoSource};
use driver::DriverEvent;
use worker::{Pace, Stream, Worker};

/// Looks at the clock within the time after which the source counts as lost.
const LOOKS: f64 = 4.0;

/// Runs the node to its end.
///
/// # Errors
/// [`RuntimeError`] where it cannot start.
pub async fn run(mut node: Node) -> Result<(), RuntimeError> {
    let params: Params = node.parameters()?;
    let mut source = Source::open(&mut node, &params)?;
    let mut outlet = Outlet::open(&mut node, &params, source.name())?;
    let mut looks = node.timer(Seconds(params.camera.lost_after_s / LOOKS));
    let work = node.work();
    let mut live = node.live_parameters(&LIVE);
    node.activated().await;
    loop {
        tokio::select! {
            arrival = source.next() => if outlet.take(arrival) {
                work.done();
            },
            _ = looks.next() => outlet.look(),
            changed = live.next() => outlet.frames.retune(changed.parse::<Params>()?.camera),
            () = node.shutdown() => return Ok(()),
        }
    }
}

/// What a source gives.
enum Arrival {
    Frame {
        exposed: Seconds,
        jpeg: Vec<u8>,
    },
    Event(DriverEvent),
    /// Refused and counted already.
    Refused,
}

/// Where frames come from.
enum Source {
    Printer(Box<Inlet<CompressedImage>>),
    /// Files: one frame a period.
    Paced {
        timer: Box<Timer>,
        clock: Clock,
        worker: Worker,
        name: &'static str,
    },
    /// Frames come when they come.
    Live {
        worker: Worker,
        name: &'static str,
    },
    Stream(Stream),
}

impl Source {
    fn open(node: &mut Node, params: &Params) -> Result<Self, RuntimeError> {
        let camera = &params.camera;
        let timer = |node: &Node| Box::new(node.timer(Seconds(1.0 / camera.rate_hz)));
        Ok(match params.driver {
            Driver::Printer => {
                let oldest = Seconds(camera.stamp_age_max_s);
                Self::Printer(Box::new(node.inlet(&topics::CAMERA_REPORT, oldest)?))
            }
            Driver::Folder => {
                let mut folder = folder::Folder::new(params.folder.clone(), camera);
                let worker = Worker::spawn(node, Pace::Demand, move || folder.next_event())?;
                Self::Paced { timer: timer(node), clock: node.clock(), worker, name: "folder" }
            }
            Driver::Video => {
                let file = matches!(params.video.source, VideoSource::File(_));
                let mut video = video::Video::new(params.video.clone(), camera.clone());
                let pace = if file { Pace::Demand } else { Pace::Own };
                let worker = Worker::spawn(node, pace, move || video.next_event())?;
                if file {
                    Self::Paced { timer: timer(node), clock: node.clock(), worker, name: "video" }
                } else {
                    Self::Live { worker, name: "video" }
                }
            }
            Driver::Mjpeg => Self::Stream(Stream::spawn(node, mjpeg::Mjpeg::new(params.mjpeg.clone()))),
        })
    }

    /// Name of the source in counters and events.
    fn name(&self) -> &'static str {
        match self {
            Self::Printer(_) => topics::CAMERA_REPORT.name(),
            Self::Paced { name, .. } | Self::Live { name, .. } => name,
            Self::Stream(_) => "mjpeg",
        }
    }

    /// The next frame or event. Cancelling delays a file's frame by a period, and loses nothing.
    async fn next(&mut self) -> Arrival {
        let (stamp, event) = match self {
            Self::Printer(frames) => {
                let taken = frames.next(convert::frame).await;
                return taken.map_or(Arrival::Refused, |(exposed, jpeg)| Arrival::Frame { exposed, jpeg });
            }
            Self::Paced { timer, clock, worker, .. } => {
                timer.next().await;
                let (_read, event) = worker.recv().await;
                (clock.now(), event)
            }
            Self::Live { worker, .. } => worker.recv().await,
            Self::Stream(stream) => stream.recv().await,
        };
        match event {
            DriverEvent::Frame(jpeg) => Arrival::Frame { exposed: stamp, jpeg },
            event => Arrival::Event(event),
        }
    }
}

/// Brain, topics, counters.
struct Outlet {
    frames: Frames,
    params: CameraParams,
    clock: Clock,
    images: Publisher<CompressedImage>,
    infos: Publisher<CameraInfo>,
    presence: Presence,
    refused: Refused,
    diagnostics: Diagnostics,
    told: String,
}

impl Outlet {
    fn open(node: &mut Node, params: &Params, source: &str) -> Result<Self, RuntimeError> {
        let params = params.camera.clone();
        Ok(Self {
            frames: Frames::new(params.clone()),
            clock: node.clock(),
            images: node.publish_on(&topics::CAMERA_IMAGE)?,
            infos: node.publish_on(&topics::CAMERA_INFO)?,
            presence: node.presence(source, Seconds(params.lost_after_s))?,
            refused: Refused::new(node.diagnostics(), source),
            diagnostics: node.diagnostics(),
            told: String::new(),
            params,
        })
    }

    /// True where a frame went on.
    fn take(&mut self, arrival: Arrival) -> bool {
        match arrival {
            Arrival::Frame { exposed, jpeg } => return self.pass(exposed, jpeg),
            Arrival::Event(DriverEvent::Refused(reason)) => self.refused.count(reason),
            Arrival::Event(DriverEvent::Found { text }) => {
                if self.is_new(&text) {
                    tracing::info!("{text}");
                }
            }
            Arrival::Event(DriverEvent::Ended) => self.presence.explain("its last frame was shown"),
            Arrival::Event(DriverEvent::Lost { reason, .. }) => {
                self.presence.explain(&reason);
                if self.is_new(&reason) {
                    tracing::warn!("{reason}");
                }
            }
            Arrival::Event(DriverEvent::Frame(_)) | Arrival::Refused => {}
        }
        false
    }

    /// Whether a line for the log is another than the last one.
    fn is_new(&mut self, text: &str) -> bool {
        let new = self.told != text;
        text.clone_into(&mut self.told);
        new
    }

    fn pass(&mut self, exposed: Seconds, jpeg: Vec<u8>) -> bool {
        let accepted = self.frames.on_frame(self.clock.now(), exposed, &jpeg);
        let passed = accepted.is_ok();
        if let Ok(accepted) = accepted {
            if !accepted.frozen {
                self.presence.seen();
            }
            self.infos.send(convert::info(&self.params, exposed));
            self.images.send(convert::image(&self.params, exposed, accepted.header, jpeg));
        }
        for (reason, total) in convert::reasons(&self.frames.refusals()) {
            self.refused.follow(reason, total);
        }
        passed
    }

    fn look(&mut self) {
        let complaint = self.frames.complaint();
        if let Some(complaint) = &complaint {
            self.presence.explain(complaint);
        }
        self.presence.look();
        let (level, text) = standing(self.presence.loss(), complaint.as_deref().or(self.presence.reason()));
        let diagnostics = &self.diagnostics;
        diagnostics.report(level, &text);
        let refusals = self.frames.refusals();
        for (name, value) in [
            ("dropped_frames", self.frames.dropped()),
            ("corrupt_frames", refusals.corrupt),
            ("too_large_frames", refusals.too_large),
            ("frames_of_another_size", refusals.size),
            ("frozen_frames", self.frames.frozen()),
            ("frames_beyond_rate", refusals.too_fast),
            ("malformed_parts", self.refused.total(Reason::Malformed)),
            ("source_losses", self.presence.losses()),
        ] {
            diagnostics.set(name, value);
        }
        if let Some(interval) = self.frames.interval() {
            diagnostics.set("interval_s", format_args!("{:.3}", interval.0));
        }
    }
}

/// How the source stands: lost, or with something that is wrong with it meanwhile.
fn standing(loss: Option<String>, trouble: Option<&str>) -> (Level, String) {
    match (loss, trouble) {
        (Some(loss), _) => (Level::Error, loss),
        (None, Some(trouble)) => (Level::Warn, trouble.to_owned()),
        (None, None) => (Level::Ok, "ok".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder that is not there is told before the source counts as lost.
    #[test]
    fn what_the_driver_says_is_a_warning_until_the_source_is_lost() {
        let (lost, gone) = ("folder is lost: /gone: not there", "/gone: not there");
        assert_eq!(standing(None, Some(gone)), (Level::Warn, gone.to_owned()));
        assert_eq!(standing(Some(lost.to_owned()), Some(gone)), (Level::Error, lost.to_owned()));
        assert_eq!(standing(None, None), (Level::Ok, "ok".to_owned()));
    }
}
