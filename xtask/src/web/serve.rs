//! A folder on this machine's own address, for browsers that ask for one before they let a page
//! listen. Nobody else can reach it.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;
use std::{fs, io};

use crate::{Failure, Result};

/// A request is this long at most, bytes.
const LONGEST: u64 = 16_384;
/// A browser that opens a connection and says nothing is waited for so long.
const PATIENCE: Duration = Duration::from_secs(10);

/// Answers until it is dropped.
#[derive(Debug)]
pub struct Server {
    port: u16,
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Holds `folder`; port 0 takes any that is free.
    ///
    /// # Errors
    /// The port is taken.
    pub fn start(folder: &Path, port: u16) -> Result<Self> {
        let failed = |why: io::Error| {
            Failure::new(format!("cannot serve {} on port {port}", folder.display()))
                .because(why)
                .advise("choose another port")
        };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(failed)?;
        let port = listener.local_addr().map_err(failed)?.port();
        let ends = Arc::new(AtomicBool::new(false));
        let (folder, end) = (folder.to_path_buf(), Arc::clone(&ends));
        let thread = thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                if end.load(Ordering::Relaxed) {
                    return;
                }
                let folder = folder.clone();
                // A browser that goes away in the middle is none of ours.
                thread::spawn(move || drop(answer(stream, &folder)));
            }
        });
        Ok(Self {
            port,
            ends,
            thread: Some(thread),
        })
    }

    /// Where it answers.
    pub fn address(&self) -> String {
        format!("http://localhost:{}/", self.port)
    }

    /// Answers for ever.
    pub fn wait(mut self) {
        if let Some(thread) = self.thread.take() {
            // It only ends with this process.
            let _ = thread.join();
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        // Wakes it, so that it sees the end.
        let _ = TcpStream::connect((Ipv4Addr::LOCALHOST, self.port));
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// One request, one answer.
fn answer(mut stream: TcpStream, folder: &Path) -> io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    let mut lines = BufReader::new(stream.try_clone()?.take(LONGEST)).lines();
    let first = lines.next().transpose()?.unwrap_or_default();
    while lines
        .next()
        .transpose()?
        .is_some_and(|line| !line.is_empty())
    {}
    let asked = first
        .strip_prefix("GET /")
        .and_then(|rest| rest.split(' ').next());
    let path = asked.and_then(|asked| within(folder, asked));
    let found = path.and_then(|path| Some((fs::read(&path).ok()?, kind(&path))));
    let (status, (body, kind)) = match found {
        Some(found) => ("200 OK", found),
        None => ("404 Not Found", (b"not here\n".to_vec(), "text/plain")),
    };
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-cache\r\nConnection: close\r\n\r\n",
        body.len()
    )?;
    stream.write_all(&body)
}

/// The file of a request, never one outside.
fn within(folder: &Path, asked: &str) -> Option<PathBuf> {
    let name = asked
        .split(['?', '#'])
        .next()
        .filter(|name| !name.is_empty());
    let name = Path::new(name.unwrap_or("index.html"));
    let plain = name
        .components()
        .all(|part| matches!(part, Component::Normal(_)));
    plain.then(|| folder.join(name))
}

/// What browsers must be told of a file before they take it.
fn kind(path: &Path) -> &'static str {
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("html") => "text/html; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("wasm") => "application/wasm",
        Some("svg") => "image/svg+xml",
        Some("webmanifest") => "application/manifest+json",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn get(server: &Server, path: &str) -> String {
        let mut stream = TcpStream::connect((Ipv4Addr::LOCALHOST, server.port)).expect("there");
        write!(stream, "GET /{path} HTTP/1.1\r\nHost: localhost\r\n\r\n").expect("asked");
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("answered");
        answer
    }

    #[test]
    fn files_are_given_with_their_kind_and_nothing_outside() {
        let folder = std::env::temp_dir().join(format!("rarma-serve-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        fs::write(folder.join("index.html"), "<p>here</p>").expect("a file");
        let server = Server::start(&folder, 0).expect("a free port");
        for path in ["", "index.html", "?a=1"] {
            let answer = get(&server, path);
            assert!(answer.starts_with("HTTP/1.1 200 OK\r\n"), "{answer}");
            assert!(answer.contains("text/html") && answer.ends_with("<p>here</p>"));
        }
        for path in ["../Cargo.toml", "/etc/passwd", "none.js"] {
            assert!(get(&server, path).starts_with("HTTP/1.1 404"), "{path}");
        }
        drop(server);
        fs::remove_dir_all(&folder).expect("removed");
    }
}
