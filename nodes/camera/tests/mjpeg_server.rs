//! The MJPEG driver on servers that behave, and on servers that do not.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use std::time::Duration;

use camera::node::driver::DriverEvent;
use camera::node::mjpeg::Mjpeg;
use camera::params::MjpegParams;
use runtime::Reason;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};

const HEAD: &str = "HTTP/1.0 200 OK\r\nServer: MJPG-Streamer\r\nContent-Type: multipart/x-mixed-replace;boundary=frame\r\n\r\n";

/// A part as mjpg-streamer sends it.
fn part(body: &[u8]) -> Vec<u8> {
    let head = format!(
        "--frame\r\nContent-Type: image/jpeg\r\nContent-Length: {}\r\nX-Timestamp: 1.5\r\n\r\n",
        body.len()
    );
    [head.as_bytes(), body, b"\r\n"].concat()
}

/// A server, and a driver that is told where it is.
async fn server() -> (TcpListener, Mjpeg) {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let port = listener.local_addr().unwrap().port();
    let params: MjpegParams = serde_saphyr::from_str(&format!(
        "{{url: \"http://127.0.0.1:{port}/?action=stream\", answer_max_s: 0.5, frame_max_s: 0.5, retry_min_s: 0.02, \
         retry_max_s: 0.08}}"
    ))
    .unwrap();
    (listener, Mjpeg::new(params))
}

/// Takes a connection and its request.
async fn accept(listener: &TcpListener) -> (TcpStream, String) {
    let (mut stream, _) = listener.accept().await.unwrap();
    let (mut request, mut byte) = (Vec::new(), [0]);
    while !request.ends_with(b"\r\n\r\n") {
        assert_eq!(stream.read(&mut byte).await.unwrap(), 1);
        request.push(byte[0]);
    }
    (stream, String::from_utf8(request).unwrap())
}

/// Serves one connection with these bytes and closes it.
async fn answer(listener: &TcpListener, bytes: &[u8]) {
    let (mut stream, _) = accept(listener).await;
    // The driver may have closed before everything was written.
    drop(stream.write_all(bytes).await);
}

/// The bound only ends a test that hangs.
async fn next(driver: &mut Mjpeg) -> DriverEvent {
    tokio::time::timeout(Duration::from_secs(20), driver.next()).await.unwrap()
}

async fn lost(driver: &mut Mjpeg) -> (String, f64) {
    match next(driver).await {
        DriverEvent::Lost { reason, retry_s } => (reason, retry_s),
        event => panic!("{event:?}"),
    }
}

async fn found(driver: &mut Mjpeg) {
    let event = next(driver).await;
    assert!(matches!(event, DriverEvent::Found { .. }), "{event:?}");
}

fn run(test: impl Future<Output = ()>) {
    tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap().block_on(test);
}

#[test]
fn a_frame_is_given_when_its_last_byte_has_come() {
    run(async {
        let (listener, mut driver) = server().await;
        let serve = async {
            let (mut stream, request) = accept(&listener).await;
            stream.write_all(HEAD.as_bytes()).await.unwrap();
            let part = part(b"one");
            // Not even the line end after the body: the next part is a period away.
            stream.write_all(&part[..part.len() - 2]).await.unwrap();
            (stream, request)
        };
        let (served, ()) = tokio::join!(serve, found(&mut driver));
        assert!(served.1.starts_with("GET /?action=stream HTTP/1.0\r\nHost: 127.0.0.1:"), "{}", served.1);
        assert_eq!(next(&mut driver).await, DriverEvent::Frame(b"one".to_vec()));
    });
}

#[test]
fn a_connection_that_drops_is_made_again_with_growing_pauses() {
    run(async {
        let (listener, mut driver) = server().await;
        let stream = [HEAD.as_bytes(), &part(b"one"), &part(b"two")[..30]].concat();
        tokio::join!(answer(&listener, &stream), found(&mut driver));
        assert_eq!(next(&mut driver).await, DriverEvent::Frame(b"one".to_vec()));
        assert_eq!(lost(&mut driver).await, ("the server has closed the connection".into(), 0.02));
        // Nobody listens: 0.04, 0.08, 0.08 s.
        let port = listener.local_addr().unwrap();
        drop(listener);
        for pause_s in [0.04, 0.08, 0.08] {
            let (reason, retry_s) = lost(&mut driver).await;
            assert!((retry_s - pause_s).abs() < 1e-12 && reason.contains("refused"), "{reason} {retry_s}");
        }
        let listener = TcpListener::bind(port).await.unwrap();
        let stream = [HEAD.as_bytes(), &part(b"two")].concat();
        tokio::join!(answer(&listener, &stream), found(&mut driver));
        assert_eq!(next(&mut driver).await, DriverEvent::Frame(b"two".to_vec()));
        // A frame has come: from the shortest pause again.
        assert!((lost(&mut driver).await.1 - 0.02).abs() < 1e-12);
    });
}

#[test]
fn bad_parts_are_passed_over_and_the_next_frame_is_read() {
    run(async {
        let (listener, mut driver) = server().await;
        let stream = [
            HEAD.as_bytes(),
            b"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: 60\r\n\r\ncut off\r\n",
            b"--frame\r\nContent-Type: text/html\r\nContent-Length: 2\r\n\r\nno\r\n",
            b"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: 100000000\r\n\r\nhuge\r\n",
            &part(b"good"),
        ]
        .concat();
        tokio::join!(answer(&listener, &stream), found(&mut driver));
        for reason in [Reason::Malformed, Reason::Malformed, Reason::OutOfRange] {
            assert_eq!(next(&mut driver).await, DriverEvent::Refused(reason));
        }
        assert_eq!(next(&mut driver).await, DriverEvent::Frame(b"good".to_vec()));
    });
}

#[test]
fn an_answer_that_is_no_stream_is_refused_with_what_to_do() {
    run(async {
        for (bytes, advice) in [
            ("HTTP/1.0 404 Not Found\r\n\r\n".to_owned(), "the server answers 404"),
            (
                "HTTP/1.1 301 Moved\r\nLocation: http://cam/x\r\n\r\n".into(),
                "set mjpeg.url to \"http://cam/x\"",
            ),
            ("HTTP/1.1 401 Unauthorized\r\n\r\n".into(), "wants a log-in"),
            ("HTTP/1.0 200 OK\r\nContent-Type: image/jpeg\r\n\r\n".into(), "\"image/jpeg\", not multipart"),
            ("HTTP/1.0 200 OK\r\n\r\n".into(), "\"\", not multipart"),
            (HEAD.replace("Server:", "Transfer-Encoding: chunked\r\nServer:"), "chunks"),
            (format!("HTTP/1.0 200 OK\r\nX: {}", "a".repeat(20_000)), "head of the answer is too long"),
            (format!("HTTP/1.0 200 OK\r\n{}\r\n", "A: b\r\n".repeat(100)), "no HTTP"),
            ("SSH-2.0-OpenSSH_9.2\r\n".into(), "no HTTP"),
            ("HTTP/1.0 200".into(), "ends in its head"),
            (format!("{HEAD}--frame\r\nX: {}", "a".repeat(5000)), "header of a part is too long"),
            (format!("{HEAD}--frame--"), "ended the stream"),
        ] {
            let (listener, mut driver) = server().await;
            let ((), (reason, _)) = tokio::join!(answer(&listener, bytes.as_bytes()), lost(&mut driver));
            assert!(reason.contains(advice), "{reason} is not {advice}");
        }
    });
}

/// Bytes keep coming, frames do not: the time from frame to frame is what is limited.
#[test]
fn a_server_that_trickles_is_left() {
    run(async {
        let (listener, mut driver) = server().await;
        let trickle = async {
            let (mut stream, _) = accept(&listener).await;
            let head = "HTTP/1.0 200 OK\r\nX: ";
            stream.write_all(head.as_bytes()).await.unwrap();
            while stream.write_all(b"a").await.is_ok() {
                tokio::time::sleep(Duration::from_millis(20)).await;
            }
        };
        tokio::select! {
            () = trickle => panic!("the server ended first"),
            (reason, _) = lost(&mut driver) => assert!(reason.contains("no answer within 0.5 s"), "{reason}"),
        }
        let trickle = async {
            let (mut stream, _) = accept(&listener).await;
            let begin =
                [HEAD.as_bytes(), &part(b"one"), b"--frame\r\nContent-Type: image/jpeg\r\n\r\n"].concat();
            stream.write_all(&begin).await.unwrap();
            while stream.write_all(b"a").await.is_ok() {
                tokio::time::sleep(Duration::from_millis(20)).await;
            }
        };
        let driven = async {
            found(&mut driver).await;
            assert_eq!(next(&mut driver).await, DriverEvent::Frame(b"one".to_vec()));
            lost(&mut driver).await
        };
        tokio::select! {
            () = trickle => panic!("the server ended first"),
            (reason, _) = driven => assert!(reason.contains("no complete frame for 0.5 s"), "{reason}"),
        }
    });
}
