//! A pipe that is read until somebody says that it is enough, also while nothing comes.

use std::io::{self, ErrorKind, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::Duration;

/// Whether it is enough is looked at this often.
const LOOK: Duration = Duration::from_millis(50);
/// Read at once.
const BLOCK: usize = 1 << 16;
/// Blocks that wait to be taken; whoever fills the pipe waits then.
const WAITING: usize = 4;

/// What comes out of a source, and its end once it is enough.
pub struct Until {
    blocks: Receiver<io::Result<Vec<u8>>>,
    here: Vec<u8>,
    from: usize,
    enough: Arc<AtomicBool>,
}

impl Until {
    /// Reads `source` on a thread of its own, which waits there if need be to the end of the
    /// program.
    pub fn new(mut source: impl Read + Send + 'static, enough: Arc<AtomicBool>) -> Self {
        let (give, blocks) = mpsc::sync_channel(WAITING);
        thread::spawn(move || {
            loop {
                let mut block = vec![0; BLOCK];
                let read = match source.read(&mut block) {
                    Err(why) if why.kind() == ErrorKind::Interrupted => continue,
                    read => read,
                };
                let last = !matches!(read, Ok(1..));
                let read = read.map(|n| {
                    block.truncate(n);
                    block
                });
                if give.send(read).is_err() || last {
                    break;
                }
            }
        });
        Self {
            blocks,
            here: Vec::new(),
            from: 0,
            enough,
        }
    }
}

impl Read for Until {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        while self.from == self.here.len() {
            if self.enough.load(Ordering::Relaxed) {
                return Ok(0);
            }
            match self.blocks.recv_timeout(LOOK) {
                Ok(block) => (self.here, self.from) = (block?, 0),
                Err(RecvTimeoutError::Timeout) => continue,
                Err(RecvTimeoutError::Disconnected) => return Ok(0),
            }
            if self.here.is_empty() {
                return Ok(0);
            }
        }
        let n = (&self.here[self.from..]).read(bytes)?;
        self.from += n;
        Ok(n)
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::net::UnixStream;

    #[test]
    fn all_of_a_source_comes_in_order() {
        let all: Vec<u8> = (0..300_000_u32).map(|n| n as u8).collect();
        let mut until = Until::new(io::Cursor::new(all.clone()), Arc::default());
        let mut came = Vec::new();
        until.read_to_end(&mut came).expect("read");
        assert!(came == all);
    }

    #[test]
    fn a_pipe_without_a_word_ends_when_it_is_enough() {
        let (_silent, end) = UnixStream::pair().expect("a pipe");
        let enough = Arc::new(AtomicBool::new(false));
        let mut until = Until::new(end, Arc::clone(&enough));
        let says = thread::spawn(move || {
            thread::sleep(2 * LOOK);
            enough.store(true, Ordering::Relaxed);
        });
        assert_eq!(until.read(&mut [0; 8]).expect("its end"), 0);
        says.join().expect("said");
    }
}
