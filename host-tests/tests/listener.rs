//! Promise: a board that only listens, made a box by `ListeningBox`, hears and obeys as every box does, says
//! nothing of parts that it does not have, cannot be armed, and keeps its settings in a flash of the Pico's
//! geometry.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use firmware::board::{Listener, ResetCause};
use firmware::{Block, Board, BoardErrorKind, Clock, ListeningBox, SensorBox};
use hal_sim::SimHost;
use rarma_box::guard::{Denial, FaultCode, KEPT_BYTES, Mode};
use rarma_box::settings::{self, SettingValue};
use rarma_box::wire::{Answer, Command, Refused, SettingMessage, Telemetry};
use rarma_core::decide::State;
use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::ops::Range;

const RATE_HZ: u64 = 48_000;
/// A step of the board's clock, µs: what it waits at most.
const STEP_US: u64 = 1_000;
/// The tone that swells, Hz, and from when on, s.
const TONE_HZ: f64 = 900.0;
const SWELLS_S: f64 = 1.5;
/// Number of the setting `monitor.teeth`.
const TEETH: u16 = 16;

#[derive(Debug)]
struct OffGrid;

impl NorFlashError for OffGrid {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::NotAligned
    }
}

/// Bytes that can be written one by one, sectors of 4 KB.
#[derive(Clone)]
struct PicoFlash(Vec<u8>);

const SECTOR: usize = 4096;
const SECTORS: usize = 8;

impl ErrorType for PicoFlash {
    type Error = OffGrid;
}

impl ReadNorFlash for PicoFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), OffGrid> {
        let from = offset as usize;
        bytes.copy_from_slice(self.0.get(from..from + bytes.len()).ok_or(OffGrid)?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.len()
    }
}

impl NorFlash for PicoFlash {
    const WRITE_SIZE: usize = 1;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), OffGrid> {
        let (from, to) = (from as usize, to as usize);
        if from % SECTOR != 0 || to % SECTOR != 0 {
            return Err(OffGrid);
        }
        self.0.get_mut(from..to).ok_or(OffGrid)?.fill(0xFF);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), OffGrid> {
        let from = offset as usize;
        let there = self.0.get_mut(from..from + bytes.len()).ok_or(OffGrid)?;
        for (there, byte) in there.iter_mut().zip(bytes) {
            // What is programmed can only lose ones.
            *there &= byte;
        }
        Ok(())
    }
}

/// A board as small as the trait.
struct Fake {
    now_us: u64,
    taken: u64,
    noise: u32,
    /// Samples that are lost at the next look.
    lose: u32,
    from_host: VecDeque<u8>,
    to_host: Vec<u8>,
    flash: PicoFlash,
    kept: [u8; KEPT_BYTES],
    fed: u64,
}

impl Fake {
    fn new(flash: PicoFlash) -> Self {
        Self {
            now_us: 0,
            taken: 0,
            noise: 1,
            lose: 0,
            from_host: VecDeque::new(),
            to_host: Vec::new(),
            flash,
            kept: [0; KEPT_BYTES],
            fed: 0,
        }
    }

    fn sound(&mut self) -> f32 {
        let t = self.taken as f64 / RATE_HZ as f64;
        self.taken += 1;
        self.noise = self
            .noise
            .wrapping_mul(1_664_525)
            .wrapping_add(1_013_904_223);
        let noise = f64::from(self.noise >> 8) / 8_388_608.0 - 1.0;
        let swell = (t - SWELLS_S).clamp(0.0, 1.0);
        (0.002 * noise + 0.2 * swell * (TAU * TONE_HZ * t).sin()) as f32
    }
}

impl Clock for Fake {
    fn now_us(&mut self) -> u64 {
        self.now_us
    }
}

impl Board for Fake {
    type Error = BoardErrorKind;

    fn samples(&mut self, block: &mut [f32]) -> Result<Block, BoardErrorKind> {
        let missing = std::mem::take(&mut self.lose);
        self.taken += u64::from(missing);
        let due = self.now_us * RATE_HZ / 1_000_000;
        let samples = block.len().min(due.saturating_sub(self.taken) as usize);
        for place in block.iter_mut().take(samples) {
            *place = self.sound();
        }
        Ok(Block { samples, missing })
    }

    fn send(&mut self, frame: &[u8]) -> Result<(), BoardErrorKind> {
        self.to_host.extend(frame);
        Ok(())
    }
}

impl Listener for Fake {
    type Flash = PicoFlash;

    const NAME: &'static str = "fake";
    const SAMPLE_RATE_HZ: f64 = RATE_HZ as f64;

    fn wait(&mut self) {
        self.now_us += STEP_US;
    }

    fn receive(&mut self, bytes: &mut [u8]) -> Result<usize, BoardErrorKind> {
        let count = bytes.len().min(self.from_host.len());
        for (place, byte) in bytes.iter_mut().zip(self.from_host.drain(..count)) {
            *place = byte;
        }
        Ok(count)
    }

    fn flash(&mut self) -> (&mut PicoFlash, Range<u32>) {
        (&mut self.flash, 0..(SECTOR * SECTORS) as u32)
    }

    fn entropy(&mut self) -> u32 {
        self.noise = self.noise.wrapping_mul(747_796_405).wrapping_add(1);
        self.noise
    }

    fn keep(&mut self, bytes: &[u8; KEPT_BYTES]) {
        self.kept = *bytes;
    }

    fn kept(&mut self) -> [u8; KEPT_BYTES] {
        self.kept
    }

    fn reset_cause(&mut self) -> ResetCause {
        ResetCause::PowerOn
    }

    fn feed_watchdog(&mut self) {
        self.fed += 1;
    }
}

/// A box on the board with a host at its link.
struct Bench {
    board: ListeningBox<Fake>,
    sensor_box: Box<SensorBox>,
    host: SimHost,
}

impl Bench {
    fn start(flash: PicoFlash) -> Self {
        let mut board = ListeningBox::new(Fake::new(flash));
        let sensor_box = Box::new(SensorBox::start(&mut board));
        Self {
            board,
            sensor_box,
            host: SimHost::default(),
        }
    }

    fn run(&mut self, seconds: f64) {
        for _ in 0..(seconds * 1e6) as u64 / STEP_US {
            use firmware::BoxBoard as _;
            self.sensor_box.poll(&mut self.board);
            self.board.wait();
            let fake = self.board.board();
            let said = std::mem::take(&mut fake.to_host);
            self.host.hears(fake.now_us, &said);
            fake.from_host.extend(self.host.by_itself(fake.now_us));
        }
    }

    /// What the box answers a command.
    fn ask(&mut self, command: &Command) -> Answer {
        let (number, frame) = self.host.command(command);
        self.board.board().from_host.extend(frame);
        self.run(0.05);
        let heard = self.host.heard.iter().rev();
        let mut replies = heard.filter_map(|heard| match &heard.message {
            Telemetry::Reply(reply) if reply.to == number => Some(reply.answer.clone()),
            _ => None,
        });
        replies.next().expect("an answer")
    }

    fn faults(&self) -> Vec<FaultCode> {
        let heard = self.host.heard.iter();
        heard
            .filter_map(|heard| match &heard.message {
                Telemetry::Fault(fault) => Some(fault.record.code),
                _ => None,
            })
            .collect()
    }
}

fn erased() -> PicoFlash {
    PicoFlash(vec![0xFF; SECTOR * SECTORS])
}

#[test]
fn it_hears_a_tone_swell_and_says_nothing_of_parts_that_it_has_not() {
    let mut bench = Bench::start(erased());
    bench.run(4.0);
    let faults = bench.faults();
    assert!(faults.is_empty(), "{faults:?}");
    assert_eq!((bench.host.missing, bench.host.broken), (0, 0));
    let heard = bench.host.heard.iter();
    let called: Vec<_> = heard
        .filter_map(|heard| match &heard.message {
            Telemetry::Verdict(verdict) if verdict.state == State::Chatter => Some(verdict),
            _ => None,
        })
        .collect();
    let first = called.first().expect("chatter is called");
    let t = first.sample as f64 / RATE_HZ as f64;
    assert!((SWELLS_S..SWELLS_S + 1.5).contains(&t), "{t} s");
    let nearest = first
        .modes
        .iter()
        .map(|mode| f64::from(mode.frequency) - TONE_HZ);
    let nearest = nearest.map(f64::abs).fold(f64::INFINITY, f64::min);
    assert!(nearest < 9.0, "{nearest} Hz off");
    // A verdict every 50 ms, and the watchdog once a millisecond.
    let verdicts = bench.host.heard.iter();
    let verdicts = verdicts.filter(|h| matches!(h.message, Telemetry::Verdict(_)));
    assert!((70..=80).contains(&verdicts.count()));
    let fed = bench.board.board().fed;
    assert!((3900..=4001).contains(&fed), "{fed}");
}

#[test]
fn lost_samples_are_told_and_time_goes_on() {
    let mut bench = Bench::start(erased());
    bench.run(0.5);
    bench.board.board().lose = 48;
    bench.run(0.5);
    assert_eq!(bench.faults(), [FaultCode::SamplesMissing]);
    let last = bench
        .host
        .heard
        .iter()
        .rev()
        .find_map(|h| match &h.message {
            Telemetry::Verdict(verdict) => Some(verdict.sample),
            _ => None,
        });
    // The lost ones are counted: the last verdict is at most its interval and a block old.
    let behind = 48_000 - last.expect("a verdict") as i64;
    assert!((0..=2600).contains(&behind), "{behind}");
}

#[test]
fn it_cannot_be_armed_in_any_mode() {
    let mut bench = Bench::start(erased());
    bench.run(0.5);
    assert!(bench.host.speaker.in_control());
    for mode in [Mode::Monitor, Mode::Cers, Mode::Ldbb] {
        assert_eq!(bench.ask(&Command::Start(mode)), Answer::Done, "{mode:?}");
        bench.run(0.2);
        let answer = bench.ask(&Command::Arm);
        // No enable input is closed, and no supply bears the coils' bias.
        let expected = match mode {
            Mode::Cers => matches!(answer, Answer::Refused(Refused::OutOfReach(_))),
            Mode::Monitor => answer == Answer::Refused(Refused::Denied(Denial::Mode)),
            _ => matches!(
                answer,
                Answer::Refused(Refused::Denied(Denial::EnableOpen | Denial::FaultLatched))
            ),
        };
        assert!(expected, "{mode:?}: {answer:?}");
    }
}

#[test]
fn settings_survive_a_restart() {
    let mut bench = Bench::start(erased());
    bench.run(0.5);
    let (setting, value) = (TEETH, SettingValue::Whole(6));
    let (_, teeth) = settings::find(setting).expect("a setting");
    assert_eq!(teeth.name, "monitor.teeth");
    let of = |stored| {
        Answer::Setting(SettingMessage {
            setting,
            value,
            stored,
        })
    };
    assert_eq!(bench.ask(&Command::Set { setting, value }), of(None));
    assert_eq!(bench.ask(&Command::Save { setting }), of(Some(value)));
    let flash = bench.board.board().flash.clone();
    assert!(flash.0.iter().any(|byte| *byte != 0xFF));
    let mut again = Bench::start(flash);
    again.run(0.5);
    assert_eq!(again.ask(&Command::Read { setting }), of(Some(value)));
}
