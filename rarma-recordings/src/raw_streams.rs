//! The raw samples of a box, put together again by their numbers, as they come: the same
//! memory for a day as for a second.
//!
//! A *stream* is what may be listened to as one: samples of one run of the box (one session)
//! without a gap of more than [`GAP_S`]. Up to that long, zeros stand where samples are
//! missing, and the gap is told.

use rarma_box::wire::{Answer, Telemetry};

/// Longest gap within a stream, s.
pub const GAP_S: f64 = 1.0;
/// Numbers from here on are none: at 96 kHz a box counts to it in 93 years.
const MOST_NUMBER: u64 = 1 << 48;
/// Rate until a message tells it, Hz.
const USUAL_HZ: f64 = 48_000.0;
/// Gaps of a stream that are told one by one.
const GAPS_TOLD: usize = 5;
/// Full scale.
const FULL_SCALE: f64 = 32_767.0;

/// Samples that are missing in a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gap {
    /// Samples of the stream before it.
    pub at: u64,
    /// Samples that are missing.
    pub samples: u64,
}

/// Why a stream began.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Why {
    /// It is the first.
    First,
    /// The box has started anew.
    Restart,
    /// So many samples are missing before it.
    Gap(u64),
    /// The numbers went back.
    Back,
}

/// What is known of a stream.
#[derive(Debug, Clone, PartialEq)]
pub struct Stream {
    /// Counted from 1.
    pub number: usize,
    /// The run of the box.
    pub session: u32,
    /// Why it began.
    pub why: Why,
    /// Number of its first sample, counted from the box's start.
    pub first: u64,
    /// Rate, Hz, where a message told it.
    pub fs_hz: Option<f64>,
    /// Samples so far, those that are missing included.
    pub samples: u64,
    /// Of them, missing.
    pub missing: u64,
    /// Gaps.
    pub gaps: u64,
    /// The first of them.
    pub told: Vec<Gap>,
}

impl Stream {
    fn seconds(&self, samples: u64) -> f64 {
        samples as f64 / self.fs_hz.unwrap_or(USUAL_HZ)
    }

    /// In one line: how long, from when, why it is one of its own, and what is missing.
    pub fn words(&self) -> String {
        let mut out = format!(
            "stream {}: {:.3} s, from {:.3} s after the start of run {:08x}",
            self.number,
            self.seconds(self.samples),
            self.seconds(self.first),
            self.session
        );
        match self.why {
            Why::First => {}
            Why::Restart => out += ", the box was started anew",
            Why::Gap(samples) => {
                out += &format!(", after a gap of {:.3} s", self.seconds(samples));
            }
            Why::Back => out += ", the samples' numbers went back",
        }
        if self.gaps > 0 {
            let told: Vec<String> = self
                .told
                .iter()
                .map(|gap| {
                    format!(
                        "{:.4} s at {:.3} s",
                        self.seconds(gap.samples),
                        self.seconds(gap.at)
                    )
                })
                .collect();
            let more = self.gaps - self.told.len() as u64;
            out += &format!(
                "; {} samples are missing, zeros stand in their place: {}{}",
                self.missing,
                told.join(", "),
                if more > 0 {
                    format!(", and {more} more gaps")
                } else {
                    String::new()
                }
            );
        }
        out
    }
}

/// What comes of a message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Piece<'a> {
    /// A stream begins.
    Begin(&'a Stream),
    /// It has ended, for another begins; the last one ends with the record.
    End(&'a Stream),
    /// Samples are missing, as many as this.
    Gap(u64),
    /// Samples, 32767 being full scale.
    Samples(&'a [i16]),
}

/// Takes messages, gives streams.
#[derive(Debug, Default)]
pub struct RawStreams {
    now: Option<Stream>,
    /// The rate that was told last, and in which session.
    rate: Option<(u32, f64)>,
    /// Blocks with numbers that cannot be.
    impossible: u64,
}

/// A sample in parts of full scale.
pub fn value(code: i16) -> f64 {
    f64::from(code) / FULL_SCALE
}

impl RawStreams {
    /// The stream that is running.
    pub fn now(&self) -> Option<&Stream> {
        self.now.as_ref()
    }

    /// What was left out, for people.
    pub fn notice(&self) -> Option<String> {
        (self.impossible > 0).then(|| {
            format!(
                "blocks of raw samples left out, for their numbers cannot be: {}",
                self.impossible
            )
        })
    }

    /// Takes what there is in a message of a session.
    ///
    /// # Errors
    /// What `with` says.
    pub fn take<E>(
        &mut self,
        session: u32,
        message: &Telemetry,
        mut with: impl FnMut(Piece<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        match message {
            Telemetry::Started { fs_hz, .. } => self.told(session, *fs_hz),
            Telemetry::Hello(id) => self.told(session, f64::from(id.sample_rate_hz)),
            Telemetry::Reply(reply) => {
                if let Answer::Identity(id) = &reply.answer {
                    self.told(session, f64::from(id.sample_rate_hz));
                }
            }
            Telemetry::Raw(raw) if raw.first >= MOST_NUMBER => self.impossible += 1,
            Telemetry::Raw(raw) => {
                let mut codes = [0; 128];
                let mut n = 0;
                for (place, pair) in codes.iter_mut().zip(raw.bytes.as_chunks().0) {
                    *place = i16::from_le_bytes(*pair);
                    n += 1;
                }
                return self.block(session, raw.first, &codes[..n], &mut with);
            }
            _ => {}
        }
        Ok(())
    }

    fn told(&mut self, session: u32, fs_hz: f64) {
        // From a link that anything may come over.
        if !(1.0..=1e7).contains(&fs_hz) {
            return;
        }
        self.rate = Some((session, fs_hz));
        if let Some(now) = self.now.as_mut().filter(|now| now.session == session) {
            now.fs_hz = Some(fs_hz);
        }
    }

    fn block<E>(
        &mut self,
        session: u32,
        first: u64,
        codes: &[i16],
        with: &mut impl FnMut(Piece<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        if codes.is_empty() {
            return Ok(());
        }
        let end = first + codes.len() as u64;
        let mut known = 0;
        let why = match &self.now {
            None => Some(Why::First),
            Some(now) if now.session != session => Some(Why::Restart),
            Some(now) => {
                let bound = (GAP_S * now.fs_hz.unwrap_or(USUAL_HZ)) as u64;
                let next = now.first + now.samples;
                match first.checked_sub(next) {
                    Some(gap) if gap > bound => Some(Why::Gap(gap)),
                    Some(_) => None,
                    // A block that came twice.
                    None if next - first <= bound => {
                        known = (next - first).min(codes.len() as u64);
                        None
                    }
                    None => Some(Why::Back),
                }
            }
        };
        if let Some(why) = why {
            let mut number = 1;
            if let Some(now) = &self.now {
                with(Piece::End(now))?;
                number = now.number + 1;
            }
            // The rate of an earlier run stands until this one tells its own.
            let stream = self.now.insert(Stream {
                number,
                session,
                why,
                first,
                fs_hz: self.rate.map(|(_, fs_hz)| fs_hz),
                samples: 0,
                missing: 0,
                gaps: 0,
                told: Vec::new(),
            });
            with(Piece::Begin(stream))?;
        }
        let Some(now) = &mut self.now else {
            return Ok(());
        };
        let next = now.first + now.samples;
        if let Some(gap) = first.checked_sub(next).filter(|gap| *gap > 0) {
            if now.told.len() < GAPS_TOLD {
                now.told.push(Gap {
                    at: now.samples,
                    samples: gap,
                });
            }
            now.gaps += 1;
            now.missing += gap;
            now.samples += gap;
            with(Piece::Gap(gap))?;
        }
        let fresh = codes.get(known as usize..).unwrap_or_default();
        if !fresh.is_empty() {
            now.samples = end - now.first;
            with(Piece::Samples(fresh))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rarma_box::wire::Raw;

    /// A block of samples that are their own numbers, modulo 1000.
    fn raw(first: u64, n: u64) -> Telemetry {
        let mut raw = Raw::new(first);
        for k in first..first + n {
            let code = (k % 1000) as i16;
            assert!(raw.bytes.extend_from_slice(&code.to_le_bytes()).is_ok());
        }
        Telemetry::Raw(raw)
    }

    /// Session, number of the first sample, samples with zeros for gaps.
    type Taken = (u32, u64, Vec<i16>);

    /// The streams, and what is said of each.
    fn taken(blocks: &[(u32, u64, u64)]) -> (Vec<Taken>, Vec<String>) {
        let mut streams = RawStreams::default();
        let mut out: Vec<Taken> = Vec::new();
        let mut words = Vec::new();
        streams.told(1, 48_000.0);
        for (session, first, n) in blocks {
            let result = streams.take::<()>(*session, &raw(*first, *n), |piece| {
                match piece {
                    Piece::Begin(s) => out.push((s.session, s.first, Vec::new())),
                    Piece::End(s) => words.push(s.words()),
                    Piece::Gap(n) => {
                        let last = &mut out.last_mut().unwrap().2;
                        last.resize(last.len() + n as usize, 0);
                    }
                    Piece::Samples(codes) => out.last_mut().unwrap().2.extend_from_slice(codes),
                }
                Ok(())
            });
            assert_eq!(result, Ok(()));
        }
        words.extend(streams.now().map(Stream::words));
        (out, words)
    }

    fn numbers(from: u64, to: u64) -> Vec<i16> {
        (from..to).map(|k| (k % 1000) as i16).collect()
    }

    #[test]
    fn losses_are_zeros_and_copies_come_once() {
        let (streams, words) = taken(&[
            (1, 100, 100),
            (1, 200, 120),
            (1, 200, 120),
            (1, 440, 60),
            (1, 450, 70),
        ]);
        let mut expected = numbers(100, 320);
        expected.resize(340, 0);
        expected.extend(numbers(440, 520));
        assert_eq!(streams, [(1, 100, expected)]);
        assert!(words[0].contains("120 samples are missing"), "{words:?}");
        assert!(words[0].contains("0.0025 s at 0.005 s"), "{words:?}");
    }

    #[test]
    fn restarts_long_gaps_and_numbers_that_go_back_begin_streams() {
        let (streams, words) = taken(&[
            (1, 0, 120),
            (1, 120 + 48_000, 120),
            (1, 240 + 96_001, 120),
            (2, 0, 120),
            (2, 200_000, 120),
            (2, 0, 120),
        ]);
        let heads: Vec<_> = streams.iter().map(|(s, f, x)| (*s, *f, x.len())).collect();
        assert_eq!(
            heads,
            [
                (1, 0, 48_240),
                (1, 96_241, 120),
                (2, 0, 120),
                (2, 200_000, 120),
                (2, 0, 120)
            ]
        );
        for (words, says) in words[1..].iter().zip([
            "after a gap of 1.000 s",
            "started anew",
            "after a gap of 4.164 s",
            "went back",
        ]) {
            assert!(words.contains(says), "{words} does not say {says}");
        }
    }

    #[test]
    fn numbers_beyond_reason_are_left_out() {
        let (streams, _) = taken(&[(1, 0, 120), (1, 1 << 60, 120), (1, 120, 120)]);
        assert_eq!(streams, [(1, 0, numbers(0, 240))]);
        let mut streams = RawStreams::default();
        let far = raw(u64::MAX - 200, 100);
        assert_eq!(streams.take::<()>(1, &far, |_| Err(())), Ok(()));
        assert_eq!(streams.impossible, 1);
    }
}
