//! A pipe that is read until somebody says that it is enough, also while nothing comes; that
//! nothing comes may be told.

use std::io::{self, ErrorKind, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

/// Whether it is enough is looked at this often.
const LOOK: Duration = Duration::from_millis(50);
/// Read at once.
const BLOCK: usize = 1 << 16;
/// Blocks that wait to be taken; whoever fills the pipe waits then.
const WAITING: usize = 4;
/// After this long without a byte it is told.
const STALLED: Duration = Duration::from_secs(2);

/// What is told of a pipe that stalls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stall {
    /// Nothing has come for so long.
    Begun(Duration),
    /// Something comes again, after so long.
    Over(Duration),
}

/// What comes out of a source, and its end once it is enough.
pub struct Until {
    blocks: Receiver<io::Result<Vec<u8>>>,
    here: Vec<u8>,
    from: usize,
    enough: Arc<AtomicBool>,
    tell: Box<dyn FnMut(Stall) + Send>,
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
            tell: Box::new(|_| {}),
        }
    }

    /// The same, and `tell` is told of each stall of 2 s or more, once when it begins and once when it is over.
    #[must_use]
    pub fn telling(self, tell: impl FnMut(Stall) + Send + 'static) -> Self {
        Self {
            tell: Box::new(tell),
            ..self
        }
    }

    /// The block that comes next; none at the end, or once it is enough.
    fn wait(&mut self) -> io::Result<Option<Vec<u8>>> {
        let begun = Instant::now();
        let mut stalled = false;
        while !self.enough.load(Ordering::Relaxed) {
            match self.blocks.recv_timeout(LOOK) {
                Ok(block) => {
                    if stalled {
                        (self.tell)(Stall::Over(begun.elapsed()));
                    }
                    return block.map(|bytes| Some(bytes).filter(|bytes| !bytes.is_empty()));
                }
                Err(RecvTimeoutError::Timeout) => {
                    if !stalled && begun.elapsed() >= STALLED {
                        stalled = true;
                        (self.tell)(Stall::Begun(STALLED));
                    }
                }
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
        Ok(None)
    }
}

impl Read for Until {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        if self.from == self.here.len() {
            match self.wait()? {
                Some(block) => (self.here, self.from) = (block, 0),
                None => return Ok(0),
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
    use std::io::Write;
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
    fn a_pipe_that_stalls_is_told_of_once_and_so_is_its_return() {
        let (mut tap, end) = UnixStream::pair().expect("a pipe");
        let (say, said) = mpsc::channel();
        let mut until = Until::new(end, Arc::default()).telling(move |stall| {
            say.send(stall).expect("the test listens");
        });
        let writes = thread::spawn(move || {
            for pause in [STALLED / 2, STALLED + STALLED / 2] {
                thread::sleep(pause);
                tap.write_all(b"x").expect("written");
            }
        });
        let mut came = Vec::new();
        until.read_to_end(&mut came).expect("read");
        writes.join().expect("written");
        assert_eq!(came, b"xx");
        let said: Vec<Stall> = said.try_iter().collect();
        let [Stall::Begun(STALLED), Stall::Over(pause)] = said[..] else {
            panic!("{said:?}");
        };
        assert!((STALLED..3 * STALLED).contains(&pause), "{pause:?}");
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
