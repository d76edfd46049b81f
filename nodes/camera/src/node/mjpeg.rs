//! MJPEG over HTTP: `multipart/x-mixed-replace`, as mjpg-streamer, ustreamer and camera-streamer send it.
//!
//! The request is HTTP/1.0, whose answers come as they are, without chunks, until the connection ends; the head is
//! read by `httparse`. A general client would bring redirects, pools, TLS and a time limit on the whole body, which
//! here has no end: what is limited here is the time from one complete frame to the next, so that neither silence
//! nor a trickle of bytes holds the node up.

use std::collections::VecDeque;
use std::time::Duration;

use runtime::Reason;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::{Instant, sleep_until, timeout, timeout_at};

use super::driver::{BackOff, DriverEvent};
use crate::frames::BYTES_MAX;
use crate::multipart::{Limits, Part, PartError, Reader, boundary};
use crate::params::MjpegParams;

/// Longest head of an answer `[byte]`.
const HEAD_MAX: usize = 16 * 1024;
/// Most header lines of an answer.
const HEADERS_MAX: usize = 64;
/// Bounds of a part; a frame has a few lines.
const LIMITS: Limits = Limits { header_bytes: 4 * 1024, part_bytes: BYTES_MAX };
/// Bytes taken at once.
const CHUNK: usize = 64 * 1024;

/// A stream that is opened again whenever it is lost.
#[derive(Debug)]
pub struct Mjpeg {
    params: MjpegParams,
    connection: Option<Connection>,
    waiting: VecDeque<DriverEvent>,
    back_off: BackOff,
    retry_at: Instant,
}

#[derive(Debug)]
struct Connection {
    stream: TcpStream,
    reader: Reader,
    chunk: Vec<u8>,
    frame_due: Instant,
}

impl Mjpeg {
    /// Nothing is opened before the first [`Mjpeg::next`].
    #[must_use]
    pub fn new(params: MjpegParams) -> Self {
        let back_off = BackOff::new(params.retry_min_s, params.retry_max_s);
        Self { params, connection: None, waiting: VecDeque::new(), back_off, retry_at: Instant::now() }
    }

    /// The next event. Cancelling while it connects begins anew, else it loses nothing.
    pub async fn next(&mut self) -> DriverEvent {
        loop {
            if let Some(event) = self.waiting.pop_front() {
                return event;
            }
            let Some(connection) = &mut self.connection else {
                sleep_until(self.retry_at).await;
                return self.connect().await;
            };
            let read = timeout_at(connection.frame_due, connection.stream.read(&mut connection.chunk)).await;
            match read {
                Ok(Ok(0)) => return self.lose("the server has closed the connection".into()),
                Ok(Ok(count)) => {
                    if let Err(reason) = self.take(count) {
                        return self.lose(reason);
                    }
                }
                Ok(Err(error)) => return self.lose(error.to_string()),
                Err(_elapsed) => {
                    let limit_s = self.params.frame_max_s;
                    return self.lose(format!("no complete frame for {limit_s} s"));
                }
            }
        }
    }

    async fn connect(&mut self) -> DriverEvent {
        let limit = Duration::from_secs_f64(self.params.answer_max_s);
        let connected = timeout(limit, connect(&self.params)).await;
        let (connection, count) = match connected {
            Ok(Ok(connected)) => connected,
            Ok(Err(reason)) => return self.lose(reason),
            Err(_elapsed) => return self.lose(format!("no answer within {} s", self.params.answer_max_s)),
        };
        self.connection = Some(connection);
        let url = &self.params.url;
        let text = format!("MJPEG stream of {}:{}{}", url.host, url.port, url.path);
        // The first bytes of the body came with the head.
        match self.take(count) {
            Ok(()) => DriverEvent::Found { text },
            Err(reason) => self.lose(reason),
        }
    }

    /// Reads the parts in the first bytes of the chunk.
    fn take(&mut self, count: usize) -> Result<(), String> {
        let Some(connection) = &mut self.connection else { return Ok(()) };
        let (waiting, mut complete) = (&mut self.waiting, false);
        let pushed = connection.reader.push(&connection.chunk[..count], |part| match part {
            Part::Picture(jpeg) => {
                complete = true;
                waiting.push_back(DriverEvent::Frame(jpeg.to_vec()));
            }
            Part::Refused(PartError::TooLong) => waiting.push_back(DriverEvent::Refused(Reason::OutOfRange)),
            Part::Refused(PartError::Content | PartError::Length | PartError::CutOff) => {
                waiting.push_back(DriverEvent::Refused(Reason::Malformed));
            }
        });
        if complete {
            connection.frame_due = Instant::now() + Duration::from_secs_f64(self.params.frame_max_s);
            self.back_off.reset();
        }
        pushed.map_err(|error| error.to_string())
    }

    /// What was complete before is still given.
    fn lose(&mut self, reason: String) -> DriverEvent {
        self.connection = None;
        let lost = self.back_off.lost(reason);
        if let DriverEvent::Lost { retry_s, .. } = lost {
            self.retry_at = Instant::now() + Duration::from_secs_f64(retry_s);
        }
        self.waiting.push_back(lost.clone());
        self.waiting.pop_front().unwrap_or(lost)
    }
}

/// Connects, asks, and reads the head of the answer; how many bytes of the body came with it.
async fn connect(params: &MjpegParams) -> Result<(Connection, usize), String> {
    let url = &params.url;
    let mut stream =
        TcpStream::connect((url.host.as_str(), url.port)).await.map_err(|error| error.to_string())?;
    let host = if url.host.contains(':') { format!("[{}]", url.host) } else { url.host.clone() };
    let request = format!(
        "GET {} HTTP/1.0\r\nHost: {host}:{}\r\nAccept: multipart/x-mixed-replace\r\nUser-Agent: fdm_loop\r\n\r\n",
        url.path, url.port
    );
    stream.write_all(request.as_bytes()).await.map_err(|error| error.to_string())?;
    let mut chunk = vec![0; CHUNK];
    let mut length = 0;
    let (reader, begin) = loop {
        let count = stream.read(&mut chunk[length..HEAD_MAX]).await.map_err(|error| error.to_string())?;
        if count == 0 {
            let full = length == HEAD_MAX;
            let reason =
                if full { "the head of the answer is too long" } else { "the answer ends in its head" };
            return Err(reason.into());
        }
        length += count;
        if let Some(found) = head(&chunk[..length])? {
            break found;
        }
    };
    chunk.copy_within(begin..length, 0);
    let frame_due = Instant::now() + Duration::from_secs_f64(params.frame_max_s);
    Ok((Connection { stream, reader, chunk, frame_due }, length - begin))
}

/// Reads the head of an answer; `None` while it is incomplete, else a reader of its body and where that begins.
fn head(bytes: &[u8]) -> Result<Option<(Reader, usize)>, String> {
    let mut headers = [httparse::EMPTY_HEADER; HEADERS_MAX];
    let mut answer = httparse::Response::new(&mut headers);
    let status = answer.parse(bytes).map_err(|error| format!("the answer is no HTTP: {error}"))?;
    let httparse::Status::Complete(begin) = status else { return Ok(None) };
    let value = |name: &str| {
        let header = answer.headers.iter().find(|header| header.name.eq_ignore_ascii_case(name));
        header.map(|header| String::from_utf8_lossy(header.value).into_owned())
    };
    match answer.code {
        Some(200) => {}
        Some(code @ 300..=399) => {
            let place = value("location").unwrap_or_default();
            return Err(format!("the server answers {code}: set mjpeg.url to {place:?}"));
        }
        Some(code @ (401 | 403)) => {
            return Err(format!(
                "the server answers {code}: it wants a log-in, which needs a proxy on this host"
            ));
        }
        code => return Err(format!("the server answers {}", code.unwrap_or(0))),
    }
    if value("transfer-encoding").is_some() {
        return Err("the server sends chunks to a request of HTTP/1.0".into());
    }
    let kind = value("content-type").unwrap_or_default();
    let boundary = boundary(&kind)
        .ok_or_else(|| format!("the answer is {kind:?}, not multipart/x-mixed-replace with a boundary"))?;
    Ok(Some((Reader::new(boundary, LIMITS), begin)))
}
