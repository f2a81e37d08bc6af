//! Sockets to boxes, for a gateway under test.

use rarma_box::wire::{Deframer, FrameError, Head, LinkKey, Telemetry};
use rarma_fleet::gateway::link::{Counts, Link, Open};
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::time::Duration;

pub struct Sockets;

impl Open for Sockets {
    fn open(&self, port: &str, _: u32) -> Result<Box<dyn Link>, String> {
        let address = port.strip_prefix("tcp:").ok_or("no socket")?;
        let socket = TcpStream::connect(address).map_err(|why| why.to_string())?;
        socket
            .set_read_timeout(Some(Duration::from_millis(50)))
            .map_err(|why| why.to_string())?;
        Ok(Box::new(Socket {
            socket,
            deframer: Deframer::default(),
            expected: None,
            counts: Counts::default(),
        }))
    }

    /// The bytes of the file.
    fn key(&self, path: &Path) -> Result<LinkKey, String> {
        let bytes = std::fs::read(path).map_err(|why| why.to_string())?;
        Ok(LinkKey(bytes.try_into().map_err(|_| "no key")?))
    }
}

struct Socket {
    socket: TcpStream,
    deframer: Deframer,
    expected: Option<(u32, u32)>,
    counts: Counts,
}

impl Link for Socket {
    fn listen(&mut self, with: &mut dyn FnMut(Head, Telemetry)) -> Result<bool, String> {
        let mut bytes = [0; 16 * 1024];
        let n = match self.socket.read(&mut bytes) {
            Ok(0) => return Err("the box is gone".to_owned()),
            Ok(n) => n,
            Err(why) if matches!(why.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => 0,
            Err(why) => return Err(why.to_string()),
        };
        for &byte in &bytes[..n] {
            match self.deframer.push::<Telemetry>(byte) {
                None => {}
                Some(Err(FrameError::Version { found })) => self.counts.foreign = Some(found),
                Some(Err(_)) => self.counts.broken += 1,
                Some(Ok((head, message))) => {
                    self.counts.whole += 1;
                    if let Some((session, number)) = self.expected
                        && session == head.session
                    {
                        self.counts.missing += u64::from(head.sequence.wrapping_sub(number));
                    }
                    self.expected = Some((head.session, head.sequence.wrapping_add(1)));
                    with(head, message);
                }
            }
        }
        Ok(true)
    }

    fn send(&mut self, frame: &[u8]) -> Result<(), String> {
        self.socket.write_all(frame).map_err(|why| why.to_string())
    }

    fn answers(&self) -> bool {
        true
    }

    fn counts(&self) -> Counts {
        self.counts
    }
}
