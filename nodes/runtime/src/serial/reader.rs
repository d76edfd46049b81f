//! Reads a serial line in a thread of its own; connects again, with a growing pause, whenever it is lost.

use super::line::LineBuffer;
use models::params::SerialParams;
use serialport::SerialPort;
use std::io::ErrorKind;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Longest wait of one read or write `[s]`: how long a line to be sent, or the end of the reader, may take.
const WAIT_S: f64 = 0.1;

/// Lines that may wait to be sent.
const WAITING: usize = 8;

/// What the line has to say.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PortEvent {
    /// The device is open.
    Connected,
    /// The device could not be opened or was lost; the next try follows after this time.
    Lost {
        /// Why, for people.
        reason: String,
        /// Pause before the next try.
        retry: Duration,
    },
    /// A line without its end.
    Line(Vec<u8>),
    /// A line longer than any of its device; to be counted.
    Overlong,
}

/// A running reader; dropping it ends the thread.
#[derive(Debug)]
pub struct SerialReader {
    outgoing: Option<SyncSender<Vec<u8>>>,
    thread: Option<JoinHandle<()>>,
}

impl SerialReader {
    /// Starts reading lines of at most `longest` bytes; every event goes to `sink` on the reader's thread.
    ///
    /// # Errors
    /// If no thread can be started.
    pub fn spawn(
        params: SerialParams,
        longest: usize,
        sink: impl FnMut(PortEvent) + Send + 'static,
    ) -> std::io::Result<Self> {
        let (outgoing, taken) = sync_channel(WAITING);
        let thread = std::thread::Builder::new()
            .name("serial".into())
            .spawn(move || run(&params, longest, &taken, sink))?;
        Ok(Self { outgoing: Some(outgoing), thread: Some(thread) })
    }

    /// Sends a line, its end added; false where too many wait. What waits when the device is lost is never sent.
    #[must_use]
    pub fn send(&self, line: &str) -> bool {
        let bytes = [line.as_bytes(), b"\n"].concat();
        self.outgoing.as_ref().is_some_and(|outgoing| outgoing.try_send(bytes).is_ok())
    }
}

impl Drop for SerialReader {
    fn drop(&mut self) {
        drop(self.outgoing.take());
        if let Some(thread) = self.thread.take() {
            // A reader that panicked has nothing left to end.
            drop(thread.join());
        }
    }
}

fn run(params: &SerialParams, longest: usize, outgoing: &Receiver<Vec<u8>>, mut sink: impl FnMut(PortEvent)) {
    let mut retry_s = params.retry_min_s;
    loop {
        let opened =
            serialport::new(&params.path, params.baud).timeout(Duration::from_secs_f64(WAIT_S)).open();
        let reason = match opened {
            Ok(mut port) => {
                sink(PortEvent::Connected);
                retry_s = params.retry_min_s;
                match serve(port.as_mut(), longest, outgoing, &mut sink) {
                    Some(reason) => reason,
                    None => return,
                }
            }
            Err(error) => error.to_string(),
        };
        let retry = Duration::from_secs_f64(retry_s);
        sink(PortEvent::Lost { reason, retry });
        if !pause(outgoing, retry) {
            return;
        }
        retry_s = (2.0 * retry_s).min(params.retry_max_s);
    }
}

/// Waits, and throws away what is to be sent; false when the reader is to end.
fn pause(outgoing: &Receiver<Vec<u8>>, length: Duration) -> bool {
    let begin = Instant::now();
    loop {
        match outgoing.recv_timeout(length.saturating_sub(begin.elapsed())) {
            Ok(_) => {}
            Err(RecvTimeoutError::Timeout) => return true,
            Err(RecvTimeoutError::Disconnected) => return false,
        }
    }
}

/// Reads and sends until the line is lost, then says why; `None` when the reader is to end.
fn serve(
    port: &mut dyn SerialPort,
    longest: usize,
    outgoing: &Receiver<Vec<u8>>,
    sink: &mut impl FnMut(PortEvent),
) -> Option<String> {
    let mut lines = LineBuffer::new(longest);
    let mut bytes = [0_u8; 256];
    loop {
        match outgoing.try_recv() {
            Ok(line) => {
                if let Err(error) = port.write_all(&line) {
                    return Some(error.to_string());
                }
            }
            Err(TryRecvError::Empty) => {}
            Err(TryRecvError::Disconnected) => return None,
        }
        match port.read(&mut bytes) {
            Ok(0) => return Some("end of file".into()),
            Ok(count) => lines.push(&bytes[..count], |line| {
                sink(line.map_or(PortEvent::Overlong, |line| PortEvent::Line(line.to_vec())));
            }),
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => {}
            Err(error) => return Some(error.to_string()),
        }
    }
}
