//! The other end of a box: a serial port, a socket, a file or standard input.

use crate::failure::Failure;
use std::fs::File;
use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

/// A read gives up after this long, so that the view goes on without bytes.
const PATIENCE: Duration = Duration::from_millis(50);

/// Reads bytes; a read may come back empty-handed with `Ok(None)`.
pub enum Port {
    /// A serial port.
    Serial(serial2::SerialPort),
    /// A socket.
    Socket(TcpStream),
    /// A file.
    File(File),
    /// Standard input.
    Input,
}

impl Port {
    /// Opens what `name` says. Files and `-` are read only.
    ///
    /// # Errors
    /// It cannot be opened; in one line.
    pub fn open(name: &str, baud: u32) -> Result<Self, Failure> {
        let failed = |why: &io::Error| {
            Failure::Input(format!("{name}: open: {}", why.to_string().to_lowercase()))
        };
        if name == "-" {
            return Ok(Self::Input);
        }
        if let Some(address) = name.strip_prefix("tcp:") {
            let socket = TcpStream::connect(address).map_err(|why| failed(&why))?;
            socket.set_read_timeout(Some(PATIENCE))?;
            socket.set_nodelay(true)?;
            return Ok(Self::Socket(socket));
        }
        let is_file = std::fs::metadata(name).is_ok_and(|meta| meta.is_file());
        if is_file {
            return Ok(Self::File(File::open(name).map_err(|why| failed(&why))?));
        }
        let mut port = serial2::SerialPort::open(name, baud).map_err(|why| failed(&why))?;
        port.set_read_timeout(PATIENCE)?;
        Ok(Self::Serial(port))
    }

    /// Bytes that have come: none yet, or none any more (`Some(0)`).
    ///
    /// # Errors
    /// The port is gone.
    pub fn read(&mut self, bytes: &mut [u8]) -> io::Result<Option<usize>> {
        let read = match self {
            Self::Serial(port) => port.read(bytes),
            Self::Socket(socket) => socket.read(bytes),
            Self::File(file) => file.read(bytes),
            Self::Input => io::stdin().lock().read(bytes),
        };
        match read {
            Ok(n) => Ok(Some(n)),
            Err(why)
                if matches!(
                    why.kind(),
                    io::ErrorKind::WouldBlock
                        | io::ErrorKind::TimedOut
                        | io::ErrorKind::Interrupted
                ) =>
            {
                Ok(None)
            }
            Err(why) => Err(why),
        }
    }

    /// Sends bytes.
    ///
    /// # Errors
    /// The port is gone, or is one that is only read.
    pub fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        match self {
            Self::Serial(port) => port.write_all(bytes),
            Self::Socket(socket) => socket.write_all(bytes),
            Self::File(_) | Self::Input => Err(io::ErrorKind::Unsupported.into()),
        }
    }
}
