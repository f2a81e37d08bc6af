//! Several hosts on one box over a network: everybody hears everything, and what each says
//! goes to the box frame by frame. Who may change anything is the box's to say.

use crate::failure::Failure;
use rarma_box::wire::MAX_FRAME;
use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};

/// Hosts at a time; one more is let go at once.
const MOST_HOSTS: usize = 8;
/// Bytes taken from a host at a time.
const TAKEN: usize = 1024;

/// The hosts there are, and the place where they come in.
#[derive(Debug)]
pub struct Bridge {
    listener: TcpListener,
    hosts: Vec<Host>,
}

#[derive(Debug)]
struct Host {
    socket: TcpStream,
    /// The frame that is on its way; longer than any frame once it is none.
    half: Vec<u8>,
}

impl Bridge {
    /// Waits for hosts at an address.
    ///
    /// # Errors
    /// It cannot be had; in one line.
    pub fn open(address: &str) -> Result<Self, Failure> {
        let listener = TcpListener::bind(address)
            .map_err(|why| Failure::Usage(format!("--listen {address}: {why}")))?;
        listener.set_nonblocking(true)?;
        Ok(Self {
            listener,
            hosts: Vec::new(),
        })
    }

    /// Where they come in.
    ///
    /// # Errors
    /// The system does not say.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Bytes of the box, to all. A host that is slow loses bytes, one that is gone is let go.
    pub fn say(&mut self, bytes: &[u8]) {
        self.hosts
            .retain_mut(|host| stays(host.socket.write_all(bytes)));
    }

    /// Lets new hosts in and takes what has come, whole frames of one after those of another.
    /// A frame that a cut connection leaves half is dropped.
    pub fn hear(&mut self, mut with: impl FnMut(&[u8])) {
        if let Ok((socket, _)) = self.listener.accept()
            && self.hosts.len() < MOST_HOSTS
            && socket.set_nonblocking(true).is_ok()
            && socket.set_nodelay(true).is_ok()
        {
            self.hosts.push(Host {
                socket,
                half: Vec::new(),
            });
        }
        let mut bytes = [0; TAKEN];
        self.hosts
            .retain_mut(|host| match host.socket.read(&mut bytes) {
                Ok(0) => false,
                Ok(n) => {
                    host.take(&bytes[..n], &mut with);
                    true
                }
                Err(why) => stays::<()>(Err(why)),
            });
    }
}

impl Host {
    fn take(&mut self, bytes: &[u8], with: &mut impl FnMut(&[u8])) {
        for &byte in bytes {
            if self.half.len() <= MAX_FRAME {
                self.half.push(byte);
            }
            if byte == 0 {
                // One that is too long is the box's to count, as one broken frame.
                if self.half.last() != Some(&0) {
                    self.half.push(0);
                }
                with(&self.half);
                self.half.clear();
            }
        }
    }
}

fn stays<T>(result: io::Result<T>) -> bool {
    result.map_or_else(|why| why.kind() == io::ErrorKind::WouldBlock, |_| true)
}
