//! The other end of a box: a serial port, a socket, a file or standard input.

mod serial;

use crate::failure::Failure;
use rarma_recordings::system_words;
use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

/// A read gives up after this long, so that the view goes on without bytes.
const PATIENCE: Duration = Duration::from_millis(50);

/// Reads bytes; a read may come back empty-handed with `Ok(None)`.
pub struct Port {
    /// As it was named.
    name: String,
    end: End,
}

enum End {
    Serial(serial::SerialPort),
    Socket(TcpStream),
    File(File),
    Input,
}

impl Port {
    /// Opens what `name` says. Files and `-` are read only.
    ///
    /// # Errors
    /// It cannot be opened; in one line.
    pub fn open(name: &str, baud: u32) -> Result<Self, Failure> {
        let end = if name == "-" {
            End::Input
        } else if let Some(address) = name.strip_prefix("tcp:") {
            let opened = || -> io::Result<End> {
                let socket = TcpStream::connect(address)?;
                socket.set_read_timeout(Some(PATIENCE))?;
                socket.set_nodelay(true)?;
                Ok(End::Socket(socket))
            };
            opened().map_err(|why| refused(name, not_connected(&why)))?
        } else if std::fs::metadata(name).is_ok_and(|meta| meta.is_file()) {
            let file = File::open(name);
            End::File(file.map_err(|why| refused(name, not_opened(&why)))?)
        } else {
            let opened = || -> io::Result<End> {
                let mut port = serial::SerialPort::open(name, baud)?;
                port.set_read_timeout(PATIENCE)?;
                Ok(End::Serial(port))
            };
            opened().map_err(|why| refused(name, not_opened(&why)))?
        };
        Ok(Self {
            name: name.to_owned(),
            end,
        })
    }

    /// Reads wait no longer than a thousandth of a second: for those who look again soon.
    ///
    /// # Errors
    /// The port cannot be set so; in one line.
    pub fn impatient(mut self) -> Result<Self, Failure> {
        let patience = Duration::from_millis(1);
        let set = match &mut self.end {
            End::Serial(port) => port.set_read_timeout(patience),
            End::Socket(socket) => socket.set_read_timeout(Some(patience)),
            End::File(_) | End::Input => Ok(()),
        };
        set.map_err(|why| self.gone("set", &why))?;
        Ok(self)
    }

    /// Whether there is somebody at the other end who could answer.
    pub fn answers(&self) -> bool {
        matches!(self.end, End::Serial(_) | End::Socket(_))
    }

    /// Bytes that have come: none yet, or none any more (`Some(0)`).
    ///
    /// # Errors
    /// The port is gone; in one line.
    pub fn read(&mut self, bytes: &mut [u8]) -> Result<Option<usize>, Failure> {
        let read = match &mut self.end {
            End::Serial(port) => port.read(bytes),
            End::Socket(socket) => socket.read(bytes),
            End::File(file) => file.read(bytes),
            End::Input => io::stdin().lock().read(bytes),
        };
        match read {
            Ok(n) => Ok(Some(n)),
            Err(why)
                if matches!(
                    why.kind(),
                    ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
                ) =>
            {
                Ok(None)
            }
            Err(why) => Err(self.gone("read", &why)),
        }
    }

    /// Sends bytes.
    ///
    /// # Errors
    /// The port is gone, or is one that is only read; in one line.
    pub fn send(&mut self, bytes: &[u8]) -> Result<(), Failure> {
        let sent = match &mut self.end {
            End::Serial(port) => port.write_all(bytes),
            End::Socket(socket) => socket.write_all(bytes),
            End::File(_) | End::Input => Err(ErrorKind::Unsupported.into()),
        };
        sent.map_err(|why| self.gone("send", &why))
    }

    /// What is said when the other end has closed.
    pub fn closed(&self) -> Failure {
        self.gone("read", &ErrorKind::ConnectionReset.into())
    }

    fn gone(&self, step: &str, why: &io::Error) -> Failure {
        let (what, remedy) = match why.kind() {
            ErrorKind::ConnectionReset | ErrorKind::ConnectionAborted | ErrorKind::BrokenPipe => (
                "the other end closed the connection".to_owned(),
                "see whether it still runs, and connect again",
            ),
            _ => (system_words(why), "check the cable, and connect again"),
        };
        Failure::System(format!("{}: {step}: {what} ({remedy})", self.name))
    }
}

fn refused(name: &str, (what, remedy): (String, &str)) -> Failure {
    Failure::Input(format!("{name}: open: {what} ({remedy})"))
}

/// What is wrong with a socket that does not open, and what to do.
fn not_connected(why: &io::Error) -> (String, &'static str) {
    let (what, remedy) = match why.kind() {
        ErrorKind::ConnectionRefused => (
            "nobody listens there",
            "start the box or the program, check the port",
        ),
        ErrorKind::TimedOut | ErrorKind::HostUnreachable | ErrorKind::NetworkUnreachable => {
            ("no answer from there", "check the address and the cable")
        }
        ErrorKind::InvalidInput => ("not an address", "give tcp:HOST:PORT, such as tcp:box:4711"),
        _ => return (system_words(why), "check the host's name and the port"),
    };
    (what.to_owned(), remedy)
}

/// What is wrong with a file or a serial port that does not open, and what to do.
fn not_opened(why: &io::Error) -> (String, &'static str) {
    let (what, remedy) = match why.kind() {
        ErrorKind::NotFound => (
            "no such file or port",
            "check the spelling, and that it is plugged in",
        ),
        ErrorKind::PermissionDenied => (
            "permission denied",
            "let this user read it; serial ports often belong to the group dialout",
        ),
        ErrorKind::IsADirectory => ("is a directory", "name one file inside it"),
        ErrorKind::ResourceBusy => ("in use", "end the program that has it"),
        // What a terminal's settings say of something that is no terminal.
        _ if why.raw_os_error() == Some(NOT_A_TERMINAL) => (
            "neither a file nor a serial port",
            "name one of them, or tcp:HOST:PORT",
        ),
        _ => return (system_words(why), "check that it is a port of a box"),
    };
    (what.to_owned(), remedy)
}

/// ENOTTY, as every Unix counts it.
const NOT_A_TERMINAL: i32 = 25;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_the_system_says_becomes_one_line_of_four_parts() {
        let port = Port {
            name: "tcp:box:1".to_owned(),
            end: End::Input,
        };
        // Every error that this system knows.
        for number in 1..=133 {
            let why = io::Error::from_raw_os_error(number);
            for said in [
                refused("tcp:box:1", not_connected(&why)),
                refused("tcp:box:1", not_opened(&why)),
                port.gone("read", &why),
            ] {
                let line = said.to_string();
                let parts = line.strip_prefix("tcp:box:1: ");
                assert!(parts.is_some_and(|p| p.contains(": ")), "{line}");
                assert!(line.ends_with(')') && line.contains(" ("), "{line}");
                assert!(!line.contains("os error"), "{line}");
                assert!(!line.contains("reset by peer"), "{line}");
            }
        }
    }
}
