//! The sample duty of the whole box: microphone and tacho in, verdicts and raw samples
//! out, in every mode; verdicts in Monitor, and in CERS where `cers.order` asks for them.
//!
//! Fast path per sample; called at every pass of the main loop.

use crate::board::{BoxBoard, Pulse};
use crate::microphones::Microphones;
use crate::monitor::MonitorDuty;
use crate::tell::Teller;
use rarma_box::guard::{FaultCode, InARow};
use rarma_box::settings::{
    MONITOR_BAND_HIGH, MONITOR_BAND_LOW, MONITOR_MEMORY, MONITOR_MICROPHONES, MONITOR_ORDER,
    MONITOR_SPINDLE, MONITOR_TEETH, MONITOR_THRESHOLD, Settings, TACHO_PULSES, TELL_VERDICT,
};
use rarma_box::wire::{MonitorJob, Raw, Telemetry, Verdict};
use rarma_core::Order;
use rarma_core::condition::{Band, Fault, Health};
use rarma_core::decide::{Reason, State};
use rarma_core::monitor::{MonitorConfig, MonitorError};

/// Samples taken at a time: those of a millisecond, and some.
const BLOCK: usize = 64;
/// Blocks taken in one pass: five milliseconds' worth at 192 kHz.
const BLOCKS: usize = 16;
/// Without a sample for this long the converter has stopped, µs.
const STOPPED_US: u64 = 50_000;
/// Root mean square over [`LOUD_S`] beyond this part of full scale: no cut is that loud
/// without clipping, but noise and a torn cable are.
const LOUD_RMS: f32 = 0.5;
const LOUD_S: f64 = 0.05;
/// An interval of the tacho this far off the one before is out of rhythm.
const RHYTHM: f32 = 0.3;
/// So many out of rhythm in a row are noise.
const NOISY_PULSES: u32 = 4;

/// The sample duty.
#[derive(Debug)]
pub struct Listening {
    fs_hz: f64,
    /// The same in single precision, for what is done while samples are taken.
    fs: f32,
    /// Idle while nobody listens. In place, because it is large.
    duty: MonitorDuty,
    /// What is listened with, while somebody listens.
    job: Option<MonitorJob>,
    microphones: Microphones,
    /// A microphone was dropped in the last pass; the change to the other is still to be made.
    change: bool,
    /// The box shakes what it listens to: there is no chatter to be called.
    excited: bool,
    /// Health of the samples while nobody listens. A monitor that listens has a health of its own.
    health: Health<f32>,
    /// Samples that have gone by since start-up, with those that were lost.
    gone: u64,
    taken: u64,
    missing: u64,
    verdicts: u32,
    last_us: u64,
    loud: f32,
    loud_gain: f32,
    raw: Raw,
    raw_left: u64,
    pulse: Option<Pulse>,
    last_pulse: Option<Pulse>,
    pulse_us: u64,
    spindle_hz: Option<f32>,
    /// Speed by the tacho, the lower of the last two intervals', so that one pulse too many is no overspeed.
    sure_hz: Option<f32>,
    rhythm: InARow,
    noisy: Option<f32>,
}

/// The job that the settings describe.
pub fn job(settings: &Settings, fs_hz: f64) -> MonitorJob {
    let some = |x: u32| (x > 0).then_some(x);
    let spindle = settings.real(MONITOR_SPINDLE);
    let order = Order::ALL.get(settings.whole(MONITOR_ORDER) as usize);
    MonitorJob {
        monitor: MonitorConfig {
            full_scale: Some(1.0),
            band: Some(Band {
                low_hz: f64::from(settings.real(MONITOR_BAND_LOW)),
                high_hz: f64::from(settings.real(MONITOR_BAND_HIGH)),
            }),
            order: order.copied().unwrap_or(Order::O87),
            spindle_hz: (spindle > 0.0).then_some(f64::from(spindle)),
            teeth: some(settings.whole(MONITOR_TEETH)),
            tacho_pulses: some(settings.whole(TACHO_PULSES)),
            threshold: f64::from(settings.real(MONITOR_THRESHOLD)),
            memory_s: f64::from(settings.real(MONITOR_MEMORY)),
            verdict: settings.verdict(),
            ..MonitorConfig::new(fs_hz)
        },
        channel: 0,
        every_s: f64::from(settings.real(TELL_VERDICT)),
    }
}

/// A verdict without its state, while the box itself shakes the structure: the sine reads as undamped, and the excited mode
/// is loud, but neither is chatter.
fn modes_only(verdict: &Verdict) -> Verdict {
    Verdict {
        state: State::Idle,
        reason: Reason::Excited,
        ..verdict.clone()
    }
}

impl Listening {
    /// A duty that has heard nothing, of a microphone of rate `fs_hz`.
    pub fn new(fs_hz: f64) -> Self {
        Self {
            fs_hz,
            fs: fs_hz as f32,
            duty: MonitorDuty::idle(),
            job: None,
            microphones: Microphones::default(),
            change: false,
            excited: false,
            health: Health::new(fs_hz, Some(1.0)),
            gone: 0,
            taken: 0,
            missing: 0,
            verdicts: 0,
            last_us: 0,
            loud: 0.0,
            loud_gain: (1.0 / (LOUD_S * fs_hz)) as f32,
            raw: Raw::new(0),
            raw_left: 0,
            pulse: None,
            last_pulse: None,
            pulse_us: 0,
            spindle_hz: None,
            sure_hz: None,
            rhythm: InARow::default(),
            noisy: None,
        }
    }

    /// Begins to listen with these settings; with an `order` to what the box itself shakes, in
    /// place of theirs.
    ///
    /// # Errors
    /// They do not fit each other or the rate: nothing has changed.
    pub fn begin<B: BoxBoard>(
        &mut self,
        board: &mut B,
        settings: &Settings,
        order: Option<Order>,
        tell: &mut Teller,
    ) -> Result<(), MonitorError> {
        let mut job = job(settings, self.fs_hz);
        job.monitor.order = order.unwrap_or(job.monitor.order);
        job.monitor.check()?;
        self.end(board, tell);
        self.duty.begin(&job)?;
        self.excited = order.is_some();
        self.job = Some(job);
        self.microphones = Microphones::begin(settings.whole(MONITOR_MICROPHONES) == 2);
        board.listen_to(self.microphones.now());
        tell.tell(board, &self.duty.started());
        Ok(())
    }

    /// Ends listening and sends the totals.
    pub fn end<B: BoxBoard>(&mut self, board: &mut B, tell: &mut Teller) {
        if !self.duty.is_idle() {
            let last = self.duty.finished(0, 0, tell.dropped());
            self.duty.end();
            self.health = Health::new(self.fs_hz, Some(1.0));
            self.job = None;
            tell.tell(board, &last);
        }
    }

    /// The control tells the speed of the spindle, Hz, from now on; 0, unknown, counts when a
    /// mode is started.
    pub fn tell_speed(&mut self, spindle_hz: f32) {
        if let Some(job) = &mut self.job
            && self.duty.tell_speed(spindle_hz).is_ok()
        {
            job.monitor.spindle_hz = Some(f64::from(spindle_hz));
        }
    }

    /// Sends raw samples for so many seconds from now on.
    pub fn stream(&mut self, seconds: f32) {
        self.raw_left = (f64::from(seconds) * self.fs_hz) as u64;
        self.raw = Raw::new(self.gone);
    }

    /// One pass: everything that has come. `found` is told what is wrong.
    ///
    /// It is never inlined, so that a linked image can be searched for all that this duty calls.
    #[inline(never)]
    pub fn pass<B: BoxBoard>(
        &mut self,
        board: &mut B,
        now_us: u64,
        tell: &mut Teller,
        found: &mut impl FnMut(FaultCode, f32),
    ) {
        let mut block = [0.0f32; BLOCK];
        for _ in 0..BLOCKS {
            // A failed conversion shows as samples that stop.
            let Ok(read) = board.samples(&mut block) else {
                break;
            };
            if read.missing > 0 {
                self.lost(board, read.missing, tell);
                found(FaultCode::SamplesMissing, read.missing as f32);
            }
            let Some(samples) = block.get(..read.samples).filter(|s| !s.is_empty()) else {
                break;
            };
            self.last_us = now_us;
            self.samples(board, samples, tell);
        }
        let mut dropped = None;
        let mut microphones = self.microphones;
        let mut clipped = false;
        self.judge(now_us, &mut |code, value| {
            // A cut that clips is loud on both microphones: neither is to be dropped for that.
            clipped |= code == FaultCode::SamplesClipped;
            if !(clipped && code == FaultCode::SamplesLoud) {
                dropped = dropped.or(microphones.fault(code));
            }
            found(code, value);
        });
        self.microphones = microphones;
        if let Some(which) = dropped {
            found(FaultCode::MicrophoneDropped, f32::from(which) + 1.0);
            self.change = true;
        }
        self.tacho(board, now_us);
    }

    /// Changes to the other microphone where the last pass has dropped one. The model starts anew, for level and response are
    /// others. To be called after a pass and not in it, because a pass has a deadline.
    pub fn change_over<B: BoxBoard>(&mut self, board: &mut B, now_us: u64, tell: &mut Teller) {
        if !core::mem::take(&mut self.change) {
            return;
        }
        board.listen_to(self.microphones.now());
        self.health = Health::new(self.fs_hz, Some(1.0));
        self.loud = 0.0;
        self.last_us = now_us;
        let Some(job) = self.job else { return };
        self.end(board, tell);
        // It has been accepted before.
        if self.duty.begin(&job).is_ok() {
            self.job = Some(job);
            tell.tell(board, &self.duty.started());
        }
    }

    /// Takes samples, all at once where possible: one by one where a pulse of the tacho belongs to one of them or
    /// raw samples are sent.
    fn samples<B: BoxBoard>(&mut self, board: &mut B, samples: &[f32], tell: &mut Teller) {
        if self.duty.is_idle() {
            for &x in samples {
                self.health.admit(x);
            }
        }
        let gain = self.loud_gain;
        self.loud = samples.iter().fold(self.loud, |loud, &x| {
            // Not a number, or beyond full scale: not counted as sound.
            let heard = if x.abs() <= 1.0 { x * x } else { 0.0 };
            loud + gain * (heard - loud)
        });
        self.taken += samples.len() as u64;
        if self.pulse.is_none() && self.raw_left == 0 {
            self.gone += samples.len() as u64;
            self.hear(board, samples, tell);
            return;
        }
        for &x in samples {
            self.gone += 1;
            self.hear(board, &[x], tell);
            if let Some(pulse) = self.pulse
                && pulse.sample < self.gone
            {
                self.duty
                    .pulse(pulse.before + (self.gone - 1 - pulse.sample) as f32);
                self.pulse = None;
            }
            self.raw(board, x, tell);
        }
    }

    #[inline(never)]
    fn hear<B: BoxBoard>(&mut self, board: &mut B, samples: &[f32], tell: &mut Teller) {
        let (verdicts, excited) = (&mut self.verdicts, self.excited);
        self.duty.samples(samples, &mut |message| match message {
            Telemetry::Verdict(verdict) => {
                *verdicts = verdicts.wrapping_add(1);
                if excited {
                    tell.tell(board, &Telemetry::Verdict(modes_only(verdict)));
                } else {
                    tell.tell(board, message);
                }
            }
            Telemetry::Alarm(_) if excited => {}
            _ => {
                tell.tell(board, message);
            }
        });
    }

    fn raw<B: BoxBoard>(&mut self, board: &mut B, x: f32, tell: &mut Teller) {
        if self.raw_left == 0 {
            return;
        }
        self.raw_left -= 1;
        let full = !self.raw.push(x);
        if full || self.raw_left == 0 {
            self.flush_raw(board, tell);
            if full {
                self.raw.first = self.gone - 1;
                self.raw.push(x);
            }
        }
    }

    fn flush_raw<B: BoxBoard>(&mut self, board: &mut B, tell: &mut Teller) {
        if self.raw.is_empty() {
            return;
        }
        let raw = core::mem::replace(&mut self.raw, Raw::new(self.gone));
        tell.tell(board, &Telemetry::Raw(raw));
    }

    fn lost<B: BoxBoard>(&mut self, board: &mut B, missing: u32, tell: &mut Teller) {
        self.flush_raw(board, tell);
        let missing_long = u64::from(missing);
        self.gone += missing_long;
        self.missing += missing_long;
        self.raw_left = self.raw_left.saturating_sub(missing_long);
        self.raw.first = self.gone;
        self.health.missing(missing);
        self.duty.missing(missing);
    }

    fn judge(&mut self, now_us: u64, found: &mut impl FnMut(FaultCode, f32)) {
        let silence = now_us.saturating_sub(self.last_us);
        if silence > STOPPED_US {
            found(FaultCode::SamplesStopped, silence as f32 * 1e-6);
            return;
        }
        let fault = if self.duty.is_idle() {
            self.health.fault()
        } else {
            self.duty.fault()
        };
        match fault {
            Some(Fault::NotFinite) => found(FaultCode::SamplesNotFinite, 0.0),
            Some(Fault::Stuck) => found(FaultCode::SamplesStuck, 0.0),
            Some(Fault::Clipped) => found(FaultCode::SamplesClipped, 0.0),
            // Reported by `lost`, when they went missing.
            Some(Fault::Missing) | None => {}
        }
        if self.loud > LOUD_RMS * LOUD_RMS {
            found(FaultCode::SamplesLoud, rarma_core::Real::sqrt(self.loud));
        }
        if let Some(hz) = self.noisy.take() {
            found(FaultCode::TachoNoisy, hz);
        }
    }

    fn tacho<B: BoxBoard>(&mut self, board: &mut B, now_us: u64) {
        if self.pulse.is_some() {
            return;
        }
        let Some(pulse) = board.pulse() else { return };
        self.pulse_us = now_us;
        if let Some(last) = self.last_pulse {
            let whole = pulse.sample.saturating_sub(last.sample) as f32;
            let interval = whole - pulse.before + last.before;
            let hz = self.fs / interval.max(1.0);
            let before = self.spindle_hz.replace(hz).unwrap_or(hz);
            self.sure_hz = Some(hz.min(before));
            let off = (hz - before).abs() > RHYTHM * before;
            if self.rhythm.bad(off, NOISY_PULSES) {
                self.noisy = Some(hz);
            }
        }
        self.last_pulse = Some(pulse);
        self.pulse = Some(pulse);
    }

    /// Pulses a second, and how long the last one is ago, µs.
    pub fn pulses(&self, now_us: u64) -> (Option<f32>, u64) {
        (self.sure_hz, now_us.saturating_sub(self.pulse_us))
    }

    /// The tacho has fallen silent: its speed means nothing any more.
    pub fn forget_tacho(&mut self) {
        self.spindle_hz = None;
        self.sure_hz = None;
        self.last_pulse = None;
    }

    /// Samples taken, samples lost, verdicts made.
    pub fn counts(&self) -> (u64, u64, u32) {
        (self.taken, self.missing, self.verdicts)
    }
}
