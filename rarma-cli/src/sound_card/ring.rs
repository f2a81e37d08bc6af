//! Samples on their way from the sound card's thread to the monitor's.
//!
//! [`Tap`] is called by the audio thread for every block of samples: it neither waits nor allocates. [`Drain`]
//! gives them to the monitor in order. What did not come through is a gap in its right place:
//! so many samples are missing there.

use rtrb::{Consumer, Producer, RingBuffer};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

/// Gaps that may be on their way at once.
const MOST_GAPS: usize = 64;
/// Frames handed on at once.
const MOST_FRAMES: u64 = 1 << 12;
/// Between two blocks of a card that lost nothing there is less time than this, s.
const LONGEST_PAUSE_S: f64 = 1.0;
/// The rate is measured over this time, s.
const RATE_OVER_S: f64 = 10.0;

/// What the audio thread tells beside the samples.
#[derive(Debug, Default)]
pub struct Told {
    /// Samples were lost before the next block.
    pub lost: AtomicBool,
    /// Measured rate, bits of an `f64` in Hz; 0 while none has been measured.
    rate_hz: AtomicU64,
}

impl Told {
    /// The rate at which samples came by this computer's clock, Hz.
    pub fn rate_hz(&self) -> Option<f64> {
        let rate = f64::from_bits(self.rate_hz.load(Ordering::Relaxed));
        (rate > 0.0).then_some(rate)
    }
}

/// Samples of one channel that are missing.
#[derive(Debug, Clone, Copy)]
struct Gap {
    /// Frames that were passed on before it.
    at: u64,
    samples: u64,
}

/// The end at the audio thread.
#[derive(Debug)]
pub struct Tap {
    samples: Producer<f32>,
    gaps: Producer<Gap>,
    told: Arc<Told>,
    channels: usize,
    fs: f64,
    /// Frames passed on.
    passed: u64,
    /// Frames lost since then.
    lost: u64,
    last: Option<Instant>,
    /// Since when the rate is measured, and frames that have come since.
    measured: Option<(Instant, u64)>,
}

/// The end at the monitor.
#[derive(Debug)]
pub struct Drain {
    samples: Consumer<f32>,
    gaps: Consumer<Gap>,
    channels: usize,
    /// Frames taken out.
    taken: u64,
    /// Samples of a gap that are still to be told.
    missing: u64,
}

/// What comes out next.
#[derive(Debug, Clone, PartialEq)]
pub enum Piece {
    /// So many samples of every channel are missing.
    Missing(u64),
    /// Samples, those of one moment side by side.
    Frames(Vec<f32>),
}

/// A ring for so many seconds of `channels` channels.
pub fn ring(channels: usize, fs: f64, seconds: f64, told: Arc<Told>) -> (Tap, Drain) {
    let frames = (seconds * fs).ceil() as usize;
    let (samples_in, samples_out) = RingBuffer::new(frames * channels);
    let (gaps_in, gaps_out) = RingBuffer::new(MOST_GAPS);
    let tap = Tap {
        samples: samples_in,
        gaps: gaps_in,
        told,
        channels,
        fs,
        passed: 0,
        lost: 0,
        last: None,
        measured: None,
    };
    let drain = Drain {
        samples: samples_out,
        gaps: gaps_out,
        channels,
        taken: 0,
        missing: 0,
    };
    (tap, drain)
}

impl Tap {
    /// Takes the block that has come at `now`. Where samples were lost before it, only the clock
    /// tells how many; a block for which there is no room is lost whole.
    pub fn take<T: Copy>(&mut self, block: &[T], now: Instant, value: impl Fn(T) -> f32) {
        let frames = (block.len() / self.channels) as u64;
        let lost = self.told.lost.swap(false, Ordering::Acquire);
        if let Some(last) = self.last.replace(now) {
            let pause_s = now.duration_since(last).as_secs_f64();
            if lost || pause_s > LONGEST_PAUSE_S {
                let since = (pause_s * self.fs).round() as u64;
                self.lost += since.saturating_sub(frames).max(1);
                self.measured = None;
            }
        }
        self.measure(frames, now);
        let room = self.samples.write_chunk_uninit(block.len());
        let (Ok(room), true) = (room, self.lost == 0 || !self.gaps.is_full()) else {
            self.lost += frames;
            return;
        };
        // The gap goes first: who sees the samples behind it sees it, too.
        if self.lost > 0 {
            let gap = Gap {
                at: self.passed,
                samples: std::mem::take(&mut self.lost),
            };
            let _ = self.gaps.push(gap);
        }
        room.fill_from_iter(block.iter().map(|x| value(*x)));
        self.passed += frames;
    }

    fn measure(&mut self, frames: u64, now: Instant) {
        let Some((since, count)) = &mut self.measured else {
            self.measured = Some((now, 0));
            return;
        };
        *count += frames;
        let seconds = now.duration_since(*since).as_secs_f64();
        if seconds >= RATE_OVER_S {
            let rate = *count as f64 / seconds;
            self.told.rate_hz.store(rate.to_bits(), Ordering::Relaxed);
            self.measured = Some((now, 0));
        }
    }
}

impl Drain {
    /// What comes next, if there is something.
    pub fn piece(&mut self) -> Option<Piece> {
        // In this order: a gap is on its way before the samples behind it.
        let here = (self.samples.slots() / self.channels) as u64;
        if let Ok(gap) = self.gaps.peek()
            && gap.at == self.taken
        {
            self.missing += gap.samples;
            let _ = self.gaps.pop();
        }
        if self.missing > 0 {
            let now = self.missing.min(MOST_FRAMES);
            self.missing -= now;
            return Some(Piece::Missing(now));
        }
        let to_gap = self.gaps.peek().map_or(u64::MAX, |gap| gap.at - self.taken);
        let frames = here.min(MOST_FRAMES).min(to_gap);
        if frames == 0 {
            return None;
        }
        let chunk = self.samples.read_chunk(frames as usize * self.channels);
        let chunk = chunk.ok()?;
        let (first, second) = chunk.as_slices();
        let samples = [first, second].concat();
        chunk.commit_all();
        self.taken += frames;
        Some(Piece::Frames(samples))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    const FS: f64 = 1000.0;

    /// A ring of one channel and a second, and the moment it begins.
    fn begun() -> (Tap, Drain, Arc<Told>, Instant) {
        let told = Arc::new(Told::default());
        let (tap, drain) = ring(1, FS, 1.0, Arc::clone(&told));
        (tap, drain, told, Instant::now())
    }

    fn all(drain: &mut Drain) -> Vec<Piece> {
        std::iter::from_fn(|| drain.piece()).collect()
    }

    fn at(begin: Instant, ms: u64) -> Instant {
        begin + Duration::from_millis(ms)
    }

    #[test]
    fn samples_come_out_as_they_went_in() {
        let told = Arc::new(Told::default());
        let (mut tap, mut drain) = ring(2, FS, 1.0, told);
        let begin = Instant::now();
        tap.take(&[1_i16, -2, 3, -4], begin, f32::from);
        tap.take(&[5_i16, -6], at(begin, 2), f32::from);
        let frames = vec![1.0, -2.0, 3.0, -4.0, 5.0, -6.0];
        assert_eq!(all(&mut drain), [Piece::Frames(frames)]);
    }

    #[test]
    fn what_does_not_fit_is_missing_in_its_place() {
        let (mut tap, mut drain, _, begin) = begun();
        let block = |x: f32| [x; 400];
        // The third and the fourth find no room for all of their samples.
        for k in 0..4 {
            tap.take(&block(k as f32), at(begin, 400 * k), |x| x);
        }
        let before = all(&mut drain);
        let expected = [block(0.0), block(1.0)].concat();
        assert_eq!(before, [Piece::Frames(expected)]);
        tap.take(&block(4.0), at(begin, 1600), |x| x);
        let after = all(&mut drain);
        let expected = [Piece::Missing(800), Piece::Frames(block(4.0).to_vec())];
        assert_eq!(after, expected);
    }

    #[test]
    fn the_clock_tells_how_many_the_card_lost() {
        let (mut tap, mut drain, told, begin) = begun();
        tap.take(&[1.0; 100], begin, |x| x);
        told.lost.store(true, Ordering::Release);
        // 250 ms after the last block, of which this one is 100.
        tap.take(&[2.0; 100], at(begin, 250), |x| x);
        let expected = [
            Piece::Frames(vec![1.0; 100]),
            Piece::Missing(150),
            Piece::Frames(vec![2.0; 100]),
        ];
        assert_eq!(all(&mut drain), expected);
        // Late, but nothing was lost.
        tap.take(&[3.0; 100], at(begin, 900), |x| x);
        assert_eq!(all(&mut drain), [Piece::Frames(vec![3.0; 100])]);
        // So late that the card cannot have kept it.
        tap.take(&[4.0; 100], at(begin, 3000), |x| x);
        assert_eq!(all(&mut drain)[0], Piece::Missing(2000));
    }

    #[test]
    fn a_loss_before_the_first_block_is_none() {
        let (mut tap, mut drain, told, begin) = begun();
        told.lost.store(true, Ordering::Release);
        tap.take(&[1.0; 10], begin, |x| x);
        assert_eq!(all(&mut drain), [Piece::Frames(vec![1.0; 10])]);
    }

    #[test]
    fn more_gaps_than_may_be_on_their_way_lose_no_count() {
        let (mut tap, mut drain, told, begin) = begun();
        for k in 0..100 {
            told.lost.store(true, Ordering::Release);
            tap.take(&[k as f32], at(begin, 10 * k), |x| x);
        }
        tap.take(&[100.0], at(begin, 1000), |x| x);
        let mut pieces = all(&mut drain);
        tap.take(&[101.0], at(begin, 1001), |x| x);
        pieces.extend(all(&mut drain));
        let count = |piece: &Piece| match piece {
            Piece::Missing(n) => *n,
            Piece::Frames(x) => x.len() as u64,
        };
        // A block a 10 ms at first, then one a millisecond: 1002 in all, but for the last
        // pause in which nothing was lost.
        let total: u64 = pieces.iter().map(count).sum();
        assert_eq!(total, 100 * 10 - 9 + 2);
        assert_eq!(pieces.last(), Some(&Piece::Frames(vec![101.0])));
    }

    #[test]
    fn a_long_gap_comes_in_parts() {
        let (mut tap, mut drain, _, begin) = begun();
        tap.take(&[1.0], begin, |x| x);
        tap.take(&[2.0], at(begin, 3_600_000), |x| x);
        let pieces = all(&mut drain);
        let missing: u64 = pieces
            .iter()
            .map(|piece| match piece {
                Piece::Missing(n) => {
                    assert!(*n <= MOST_FRAMES, "{n}");
                    *n
                }
                Piece::Frames(_) => 0,
            })
            .sum();
        assert_eq!(missing, 3_600_000 - 1);
    }

    #[test]
    fn the_rate_is_that_of_the_clock() {
        let (mut tap, mut drain, told, begin) = begun();
        assert_eq!(told.rate_hz(), None);
        // A card that says 1000 Hz and gives 900.
        for k in 0..=110 {
            tap.take(&[0.0; 90], at(begin, 100 * k), |x| x);
            all(&mut drain);
        }
        let rate = told.rate_hz().expect("measured over ten seconds");
        assert!((rate - 900.0).abs() < 1.0, "{rate}");
    }
}
