//! Removal of what the turning spindle forces: lines at multiples of one frequency,
//! on one phase of rotation, whose speed is followed.
//!
//! Rate: [`SpindleLines::process`] once a decimated sample; at the end of each row of up to 32 what
//! the lines are in the next one is worked out; every block of about 2.7 ms the amplitudes, the
//! phase and the speed are corrected. Words: *line*, a steady tone; *notch*, the band around a
//! line in which nothing else can be seen.

mod block;
mod config;
mod line;
mod multiples;
mod phase_loop;
mod row;

pub use config::{FLIP_TAU_S, Lock, SPEED_WANDER, SpindleLinesConfig, SpindleLinesError};
pub(crate) use multiples::is_home_of_flip;

use crate::condition::Band;
use crate::real::Real;
use crate::visit::{choice, state};
use line::{RotationLine, gain};
use multiples::Choice;
use phase_loop::PhaseLoop;
use row::{LONGEST, Row, product};

/// Length of a block, s.
const BLOCK_S: f64 = 1.0 / 375.0;

/// How far the speed is trusted that was started on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Trust {
    /// The lines have been found in the sound, or a tacho leads them.
    Found,
    /// Nothing has confirmed it: the lines must stand out by far.
    Tried,
    /// The lines may not be the rotation's: all are drawn slowly.
    Doubted,
}

choice!(Trust: Found, Tried, Doubted);

/// Removes up to `H` lines at multiples of the spindle frequency, and follows it.
///
/// ```text
/// φ ← φ + ω,   e = y − Σ_n Re(c_n·e^(jnφ))                       every sample
/// u_n = 2·mean(e·e^(−jnφ)),   c_n ← c_n + κ·u_n                  every block
/// z = Σ_n n·Im(u_n·c_n*)/s_n² / Σ_n n²|c_n|²/s_n²  → φ, ω        every block
/// ```
///
/// κ is 1/blocks at first (least squares of each line by itself), at most
/// spacing·block, then block/τ. z is the phase error by which all lines together say
/// the rotation leads; it drives a Kalman filter of phase and speed. s_n², the noise at
/// a line, is read off its errors along c_n and across it, less the n·z that all lines
/// share: a chatter near one line is loud in that line alone, which then has no say,
/// while a change of speed turns all lines alike. With a single line in the band only
/// the error along c_n is left to tell the two apart.
///
/// Which multiples: all in the band if they are at most `H`; else those of the teeth
/// first, then from the lowest up. With an even number of teeth the odd multiples of
/// half the tooth frequency up to 4.5 times it are home to flip chatter (period two):
/// those lines are *drawn slowly*, over [`FLIP_TAU_S`], so that the steady line of a
/// runout goes and what grows there stays in the signal; while [`Self::hold`] says so, they
/// are not drawn at all. They have no say about the speed.
///
/// Precision: the phase is a phasor put back on the unit circle at every row of samples, the
/// phasors of the lines its powers, so that an error never outlives a row.
#[derive(Debug, Clone)]
pub struct SpindleLines<T, const H: usize> {
    lines: [RotationLine<T>; H],
    used: usize,
    choice: Choice,
    trust: Trust,
    held: bool,
    /// Phasors of the rotation at the first sample of the row, and of its turn in a sample.
    base: (T, T),
    turn: (T, T),
    row: Row<T>,
    filter: PhaseLoop<T>,
    lock: Lock,
    running: bool,
    in_block: u16,
    block: u16,
    age: u16,
    bad_blocks: u16,
    band: (T, T),
    fs: T,
    /// Least κ, that of the lines that are drawn slowly, and wander per block.
    kappa: T,
    slow_kappa: T,
    wander: T,
    /// Mean square multiple of the lines, by power.
    square_multiple: T,
}

state! { SpindleLines<T, const H> {
    lines, used, choice, trust, held, base, turn, row, filter, lock, running, in_block, age,
    bad_blocks, square_multiple;
    settings block, band, fs, kappa, slow_kappa, wander;
    where *used <= H && *in_block < *block
} }

impl<T: Real, const H: usize> SpindleLines<T, H> {
    /// Lines of no speed: samples pass.
    ///
    /// # Errors
    /// See [`SpindleLinesError`].
    pub fn new(config: &SpindleLinesConfig) -> Result<Self, SpindleLinesError> {
        const { assert!(H >= 1 && H <= 200, "1 to 200 lines") };
        let fs = config.fs_hz;
        if !(fs.is_finite() && fs >= 200.0) {
            return Err(SpindleLinesError::Rate);
        }
        let Band { low_hz, high_hz } = config.band;
        if !(low_hz > 0.0 && low_hz < high_hz && high_hz < 0.5 * fs) {
            return Err(SpindleLinesError::Band);
        }
        if config.teeth.is_some_and(|z| !(1..=1000).contains(&z)) {
            return Err(SpindleLinesError::Teeth);
        }
        if !(config.tau_s >= 0.02 && config.tau_s <= 10.0) {
            return Err(SpindleLinesError::Memory);
        }
        if !(config.wander >= 1e-6 && config.wander <= 0.1) {
            return Err(SpindleLinesError::Wander);
        }
        let block = ((fs * BLOCK_S + 0.5) as u16).clamp(1, 256);
        let block_s = f64::from(block) / fs;
        // No standard root without std; the block is short, the root need not be fine.
        let wander = T::from_f64(config.wander) * T::from_f64(block_s).sqrt();
        Ok(Self {
            lines: [RotationLine::new(0); H],
            used: 0,
            choice: Choice::new(config.teeth),
            trust: Trust::Found,
            held: false,
            base: (T::ONE, T::ZERO),
            turn: (T::ONE, T::ZERO),
            row: Row::EMPTY,
            filter: PhaseLoop::new(T::ZERO, T::ZERO, wander),
            lock: Lock::Searching,
            running: false,
            in_block: 0,
            block,
            age: 0,
            bad_blocks: 0,
            band: (T::from_f64(low_hz), T::from_f64(high_hz)),
            fs: T::from_f64(fs),
            kappa: T::from_f64(block_s / config.tau_s),
            slow_kappa: T::from_f64(block_s / config.tau_s.max(FLIP_TAU_S)),
            wander,
            square_multiple: T::ONE,
        })
    }

    /// Forgets the speed and the lines: samples pass.
    pub fn reset(&mut self) {
        self.running = false;
        self.used = 0;
        self.lock = Lock::Searching;
    }

    /// Starts on a speed, Hz, with its standard deviation, from nothing. Ignored if
    /// either is no number, the speed not positive or not below half the rate. Slow
    /// path.
    pub fn start(&mut self, spindle_hz: T, sd_hz: T) {
        let most = self.fs * T::from_f64(0.5);
        if !(spindle_hz > T::ZERO && spindle_hz < most && sd_hz >= T::ZERO && sd_hz < most) {
            return;
        }
        self.trust = Trust::Found;
        let scale = self.rad_per_block();
        self.filter = PhaseLoop::new(spindle_hz * scale, sd_hz * scale, self.wander);
        self.base = (T::ONE, T::ZERO);
        self.used = 0;
        self.in_block = 0;
        self.age = 0;
        self.bad_blocks = 0;
        self.lock = Lock::Searching;
        self.running = true;
        self.square_multiple = T::ONE;
        self.choose();
        self.steer();
        self.begin_row();
    }

    /// Starts on a speed that nothing in the sound has confirmed: lines that are taken for
    /// its own must stand out by far.
    pub fn try_speed(&mut self, spindle_hz: T, sd_hz: T) {
        self.start(spindle_hz, sd_hz);
        self.trust = Trust::Tried;
    }

    /// Starts on a comb that may not be the rotation's: all of its lines are drawn slowly,
    /// so that it goes as it stands, and what changes of it stays in the signal.
    pub fn start_slowly(&mut self, spacing_hz: T, sd_hz: T) {
        self.start(spacing_hz, sd_hz);
        self.trust = Trust::Doubted;
    }

    /// A speed is followed, or tried.
    pub fn is_running(&self) -> bool {
        self.running
    }

    /// All lines are drawn slowly.
    pub fn are_slow(&self) -> bool {
        self.trust == Trust::Doubted
    }

    /// A line is drawn slowly: what is there may be self-excited.
    fn is_slow(&self, multiple: u16) -> bool {
        self.are_slow() || self.choice.is_flip(multiple)
    }

    /// A line has a say about the speed.
    fn speaks(&self, multiple: u16) -> bool {
        self.are_slow() || !self.choice.is_flip(multiple)
    }

    /// A speed from elsewhere (tacho, finder), Hz, and its standard deviation: drawn
    /// into the loop by its weight, from the next block on. Slow path.
    pub fn measure_speed(&mut self, spindle_hz: T, sd_hz: T) {
        if self.running {
            let scale = self.rad_per_block();
            self.filter.measure(spindle_hz * scale, sd_hz * scale);
        }
    }

    /// Takes a sample, gives what is left of it: the sample itself unless locked, or
    /// if it is no number.
    #[inline]
    pub fn process(&mut self, y: T) -> T {
        if !self.running {
            return y;
        }
        let e = self.row.rest(y);
        if self.row.is_full() {
            self.end_row();
        }
        if self.lock == Lock::Locked && e.is_finite() {
            e
        } else {
            y
        }
    }

    /// A row is full: the next one begins, behind the correction if it is the block's last.
    #[inline(never)]
    fn end_row(&mut self) {
        let lines = &mut self.lines[..self.used.min(H)];
        self.row.end(lines, self.base, self.turn);
        let samples = self.row.length();
        for _ in 0..samples {
            self.base = product(self.base, self.turn);
        }
        // One step of Newton keeps the length at 1 whatever rounding does.
        let (x, y) = self.base;
        let stretch = T::from_f64(1.5) - T::from_f64(0.5) * (x * x + y * y);
        self.base = (x * stretch, y * stretch);
        self.in_block += samples as u16;
        if self.in_block >= self.block {
            self.in_block = 0;
            self.end_block();
        }
        self.begin_row();
    }

    /// What the lines will be until the next correction, or as far as a row reaches.
    fn begin_row(&mut self) {
        let length = usize::from(self.block - self.in_block).min(LONGEST);
        let lines = &self.lines[..self.used.min(H)];
        self.row.begin(lines, self.base, self.turn, length);
    }

    fn rad_per_block(&self) -> T {
        T::from_f64(2.0) * T::PI * T::from_u32(u32::from(self.block)) / self.fs
    }

    fn steer(&mut self) {
        let (s, c) = (self.filter.omega / T::from_u32(u32::from(self.block))).sin_cos();
        self.turn = (c, s);
    }

    /// Lines that came into the band or left it.
    fn choose(&mut self) {
        let f = self.filter.omega / self.rad_per_block();
        let chosen = self.choice.renew::<T, H>(f, self.band, self.used == 0);
        let Some((chosen, used)) = chosen else {
            return;
        };
        let old = self.lines;
        let old = &old[..self.used.min(H)];
        for (multiple, place) in chosen.iter().zip(&mut self.lines) {
            let known = old.iter().find(|l| l.multiple == *multiple);
            *place = known.copied().unwrap_or(RotationLine::new(*multiple));
        }
        self.used = used;
    }

    /// What the lines hold.
    pub fn lock(&self) -> Lock {
        self.lock
    }

    /// Speed that is followed, Hz, and its standard deviation; none before a start and
    /// when lost.
    pub fn spindle_hz(&self) -> Option<(T, T)> {
        let scale = self.rad_per_block();
        let sd = self.filter.p.2.max(T::ZERO).sqrt();
        self.running
            .then(|| (self.filter.omega / scale, sd / scale))
    }

    /// Mean power removed, input units squared; none is removed unless locked.
    pub fn power(&self) -> T {
        self.lines()
            .fold(T::ZERO, |sum, (_, a)| sum + a * a * T::from_f64(0.5))
    }

    /// Whether the lines that are drawn slowly are kept as they are: what is there
    /// may be one.
    pub fn hold(&mut self, held: bool) {
        self.held = held;
    }

    /// Power of the loudest of the lines that are drawn slowly, input units squared.
    pub fn loudest_slow(&self) -> T {
        let used = match self.lock {
            Lock::Locked => self.used.min(H),
            _ => 0,
        };
        let lines = self.lines[..used].iter();
        let slow = lines.filter(|line| self.is_slow(line.multiple));
        slow.fold(T::ZERO, |most, line| most.max(line.square())) * T::from_f64(0.5)
    }

    /// Multiple and amplitude (peak, input units) of every line removed.
    pub fn lines(&self) -> impl Iterator<Item = (u32, T)> + '_ {
        let used = match self.lock {
            Lock::Locked => self.used.min(H),
            _ => 0,
        };
        let lines = self.lines[..used].iter();
        lines.map(|l| (u32::from(l.multiple), l.square().sqrt()))
    }

    /// Amplitude of the line at this multiple, input units; none if none is removed
    /// there.
    pub fn amplitude(&self, multiple: u32) -> Option<T> {
        let mut lines = self.lines();
        lines.find(|(n, _)| *n == multiple).map(|(_, a)| a)
    }

    /// Half the width of the notch around each line, Hz: what lies d from it keeps
    /// d/√(d² + notch²) of its amplitude. 1/(2π·τ), wider in the first τ.
    pub fn notch_hz(&self) -> T {
        let most = self.filter.omega / (T::from_f64(2.0) * T::PI);
        let kappa = gain(self.age, most.min(T::ONE), self.kappa);
        kappa / self.rad_per_block()
    }
}
