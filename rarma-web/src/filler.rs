//! Silence that a browser puts in for sound it has lost.
//!
//! Between the device and the page lie queues of some 10 ms. Where one runs dry the page is handed
//! zeros, and where one runs over sound is dropped; neither shows in the page's own count of frames.
//! Both leave a run of exact zeros of the length of what is missing, within a block of 10 ms
//! (docs/web.md has the measurements). Every open microphone is never exactly 0 for so long.

/// Zeros in a row, s, from which on they stand for missing samples: less than any of the blocks
/// that browsers lose (128 samples), more than a converter of 16 bits gives by chance.
const LEAST_S: f64 = 0.002;
/// Never fewer than so many, whatever the rate.
const LEAST: u64 = 32;

/// What is to be done with the samples, in order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Piece {
    /// A sample that was heard.
    Sample(f32),
    /// So many samples are missing before the next one.
    Missing(u64),
}

/// Parts sound from filler.
#[derive(Debug, Clone)]
pub struct Filler {
    least: u64,
    /// Sound has come; before that, zeros are the time before the beginning.
    begun: bool,
    /// Zeros that are held back, for they may be sound.
    held: u64,
    /// The run has been told to be filler.
    told: bool,
}

impl Filler {
    /// For samples of rate `fs`, Hz.
    pub fn new(fs: f64) -> Self {
        Self {
            least: ((LEAST_S * fs) as u64).max(LEAST),
            begun: false,
            held: 0,
            told: false,
        }
    }

    /// Sound has come.
    pub fn has_begun(&self) -> bool {
        self.begun
    }

    /// Takes the next sample and hands on what is known now.
    #[inline]
    pub fn push(&mut self, x: f32, take: &mut impl FnMut(Piece)) {
        if x != 0.0 {
            self.begun = true;
            self.release(take);
            self.told = false;
            take(Piece::Sample(x));
        } else if self.begun {
            self.held += 1;
            self.told |= self.held >= self.least;
        }
    }

    /// A block is over: filler is told of at once and not only when sound comes again.
    pub fn end_of_block(&mut self, take: &mut impl FnMut(Piece)) {
        if self.told {
            self.release(take);
        }
    }

    fn release(&mut self, take: &mut impl FnMut(Piece)) {
        let zeros = std::mem::take(&mut self.held);
        if zeros == 0 {
            return;
        }
        if self.told {
            take(Piece::Missing(zeros));
        } else {
            (0..zeros).for_each(|_| take(Piece::Sample(0.0)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples and runs of missing ones, joined.
    fn parted(x: &[f32], block: usize) -> Vec<(bool, u64)> {
        let mut filler = Filler::new(48_000.0);
        let mut out: Vec<(bool, u64)> = Vec::new();
        let mut take = |piece| {
            let (missing, n) = match piece {
                Piece::Sample(_) => (false, 1),
                Piece::Missing(n) => (true, n),
            };
            match out.last_mut().filter(|last| last.0 == missing) {
                Some(last) => last.1 += n,
                None => out.push((missing, n)),
            }
        };
        for block in x.chunks(block) {
            block.iter().for_each(|x| filler.push(*x, &mut take));
            filler.end_of_block(&mut take);
        }
        out
    }

    #[test]
    fn runs_of_zeros_are_missing_and_short_ones_are_sound() {
        let mut x = vec![0.0; 900];
        x.extend(vec![0.1; 1000]);
        x.extend(vec![0.0; 480]);
        x.extend(vec![-0.1; 500]);
        x.extend(vec![0.0; 40]);
        x.extend(vec![0.1; 10]);
        for block in [1, 7, 128, 4000] {
            let out = parted(&x, block);
            assert_eq!(out, [(false, 1000), (true, 480), (false, 550)], "{block}");
        }
    }

    #[test]
    fn a_muted_input_is_missing_as_it_goes_on() {
        let mut x = vec![0.1; 10];
        x.extend(vec![0.0; 1280]);
        assert_eq!(parted(&x, 128), [(false, 10), (true, 1280)]);
        assert!(parted(&[0.0; 4000], 128).is_empty(), "never begun");
    }
}
