//! A real browser that looks at a page, behind a proxy that only counts what it is asked for.

use std::io::{BufRead, BufReader, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::JoinHandle;

/// Hosts that Chromium asks on its own, whatever the page.
const OWN_HOSTS: [&str; 6] = [
    "clients2.google.com",
    "update.googleapis.com",
    "accounts.google.com",
    "optimizationguide-pa.googleapis.com",
    "content-autofill.googleapis.com",
    "safebrowsing.googleapis.com",
];

/// Takes a picture of a page of this file system; returns what the browser asked the network for.
pub(crate) fn screenshot(page: &Path, size: (u32, u32), dark: bool, picture: &Path) -> Vec<String> {
    _ = std::fs::remove_file(picture);
    let mut wishes = vec![format!("--screenshot={}", picture.display())];
    if dark {
        wishes.extend(["--force-dark-mode", "--blink-settings=preferredColorScheme=0"].map(str::to_owned));
    }
    let (ended, asked) = shown(page, size, &wishes);
    assert!(picture.is_file(), "no screenshot: {}", String::from_utf8_lossy(&ended.stderr));
    asked
}

/// A page as it stands once its scripts have run.
pub(crate) fn document(page: &Path, size: (u32, u32)) -> String {
    let (ended, _) = shown(page, size, &["--dump-dom".to_owned()]);
    String::from_utf8(ended.stdout).unwrap()
}

/// Shows a page; what came of it, and what the browser asked the network for.
fn shown(page: &Path, size: (u32, u32), wishes: &[String]) -> (Output, Vec<String>) {
    let proxy = Proxy::start();
    let profile = page.with_extension("profile");
    _ = std::fs::remove_dir_all(&profile);
    std::fs::create_dir_all(&profile).unwrap();
    let mut command = Command::new("chromium");
    command
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-quic",
            "--no-first-run",
            "--hide-scrollbars",
        ])
        .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
        .args([
            "--disable-extensions",
            "--disable-default-apps",
            "--metrics-recording-only",
            "--no-default-browser-check",
        ])
        .args(["--disable-client-side-phishing-detection", "--disable-domain-reliability", "--no-pings"])
        .arg(format!("--proxy-server=http://{}", proxy.address))
        .arg("--proxy-bypass-list=<-loopback>")
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(format!("--window-size={},{}", size.0, size.1))
        .args(wishes);
    let ended = command
        .arg(format!("file://{}", page.display()))
        .stdin(Stdio::null())
        .output()
        .expect("chromium is missing: apt-get install --no-install-recommends chromium (test.sh does)");
    _ = std::fs::remove_dir_all(&profile);
    (ended, proxy.stop())
}

/// A proxy that answers nobody and remembers what it was asked.
struct Proxy {
    address: SocketAddr,
    thread: JoinHandle<Vec<String>>,
}

/// What ends it.
const STOP: &str = "STOP";

impl Proxy {
    fn start() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let thread = std::thread::spawn(move || {
            let mut asked = Vec::new();
            for caller in listener.incoming() {
                let mut line = String::new();
                // A caller that says nothing asks for nothing.
                _ = BufReader::new(caller.unwrap()).read_line(&mut line);
                match line.trim() {
                    STOP => break,
                    "" => {}
                    line => asked.push(line.to_owned()),
                }
            }
            asked
        });
        Self { address, thread }
    }

    fn stop(self) -> Vec<String> {
        TcpStream::connect(self.address).unwrap().write_all(STOP.as_bytes()).unwrap();
        let own = |line: &String| {
            OWN_HOSTS
                .iter()
                .any(|host| line.contains(&format!("//{host}/")) || line.contains(&format!(" {host}:443 ")))
        };
        self.thread.join().unwrap().into_iter().filter(|line| !own(line)).collect()
    }
}
