//! `rarma box`: the whole firmware on simulated hardware.

use crate::args::BoxArgs;
use crate::bridge::Bridge;
use crate::failure::Failure;
use crate::frames::Teller;
use crate::key;
use crate::output::{self, RecordFile, stdout};
use firmware::board::Origin;
use hal_sim::exciter::calibrated;
use hal_sim::rig::{FaultKind, RigSetUp, SimBox, SimRig};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rarma_box::guard::Severity;
use rarma_box::settings::{LINK_KEY, SettingValue};
use rarma_box::wire::{Answer, Command, LinkKey, Telemetry};
use rarma_plants::cers::ExciterConfig;
use rarma_plants::cut::VirtualCut;
use rarma_recordings::FrameReader;
use rarma_rigs::cers::Geometry;
use rarma_scenarios::scenario::{self, AtWork, BOX_SHIPPED, SHIPPED};
use rarma_scenarios::speech;
use serde_json::json;
use std::time::{Duration, Instant};

/// The box is stepped on for this long between two looks at a socket, µs.
const SLICE_US: u64 = 5_000;
/// Acceleration that is full scale, m/s².
const FULL_SCALE_M_PER_S2: f64 = 100.0;
/// Root mean square of the quiet, parts of full scale.
const QUIET_RMS: f32 = 0.02;

pub(super) fn main(args: &BoxArgs) -> Result<u8, Failure> {
    if args.list {
        for (name, text) in BOX_SHIPPED {
            say!("{name:24} {}", scenario::parse_box(name, text, None)?.about);
        }
        for (name, text) in SHIPPED {
            say!("{name:24} {}", scenario::parse(name, text, None)?.about);
        }
        return Ok(0);
    }
    if args.schema {
        say!("{:#}", scenario::box_schema());
        return Ok(0);
    }
    if args.faults {
        for kind in FaultKind::ALL {
            say!("{:22} {}", kind.name(), kind.about().trim());
        }
        return Ok(0);
    }
    if args.settings {
        let mut text = String::new();
        let written = if args.json {
            rarma_box::settings::write_schema(&mut text)
        } else {
            rarma_box::settings::markdown(&mut text)
        };
        written.map_err(|_| Failure::System("the page of settings cannot be made".to_owned()))?;
        say!("{}", text.trim_end());
        return Ok(0);
    }
    let name = args.sim.as_deref().unwrap_or_default();
    let at_work = scenario::load_box(name, args.seed)?;
    let key = args.key.as_deref().map(key::read).transpose()?;
    let mut rig = rig(&at_work)?;
    // The address first: a record is not touched for a box that cannot be served.
    let bridge = args.listen.as_deref().map(Bridge::open).transpose()?;
    let record = args.record.as_deref().map(output::record).transpose()?;
    // The scenario's own host is at the box's own port.
    let with_noise = |mut all: SimBox| {
        all.rig.link.noise = at_work.noise;
        all.rig.link.frame_loss = at_work.frame_loss;
        all
    };
    match bridge {
        Some(bridge) => {
            // Hosts that come over a network are not to know the session beforehand.
            rig.draws = rand::random();
            serve(&mut with_noise(served(rig, key)), &at_work, bridge, record)
        }
        None => {
            let mut all = with_noise(SimBox::new(rig));
            play(&mut all, &at_work, args.json, record)
        }
    }
}

/// A box on a network, with its key set at its own port before that.
fn served(rig: SimRig, key: Option<LinkKey>) -> SimBox {
    let mut all = SimBox::new(rig);
    if let Some(key) = key {
        let setting = LINK_KEY.number();
        let value = SettingValue::Key(key);
        all.send(&Command::Set { setting, value });
        all.host.speaker.set_key(Some(key));
        all.send(&Command::Save { setting });
    }
    all.send(&Command::Release);
    all.host.takes_control = false;
    all.host.heartbeat_us = None;
    all.host.keep_all = false;
    all.run_for(0.01);
    all.rig.link.origin = Origin::Network;
    all
}

/// The exciter's plant without its ripple, which takes most of the time.
fn magnets() -> ExciterConfig {
    ExciterConfig {
        substeps: 8,
        ..ExciterConfig::default()
    }
}

/// The constants of the magnets, measured on a bench, as commands.
fn calibration(seed: u64) -> Result<Vec<Command>, Failure> {
    let guess = Geometry::textbook();
    let (laws, _) = calibrated(&magnets(), &guess, seed)
        .map_err(|why| Failure::System(format!("calibration of the magnets: {why}")))?;
    let [x, y] = laws;
    let each = [
        ("xp", x.plus),
        ("xm", x.minus),
        ("yp", y.plus),
        ("ym", y.minus),
    ];
    let mut out = Vec::new();
    for (place, magnet) in each {
        for (what, value) in [
            ("gain", magnet.gain),
            ("offset", magnet.gap_offset_m),
            ("knee", magnet.saturation_a_per_m),
        ] {
            let words = format!("set cers.{what}-{place} {:e}", value as f32);
            out.push(speech::command(&words).map_err(Failure::System)?);
        }
    }
    Ok(out)
}

fn rig(at_work: &AtWork) -> Result<SimRig, Failure> {
    let of_coils = at_work.faults.iter().find(|f| f.kind.needs_chokes());
    if let Some(fault) = of_coils.filter(|_| at_work.magnets) {
        return Err(Failure::Input(format!(
            "{}: fault {} needs a rig without magnets (set magnets = false)",
            at_work.name,
            fault.kind.name()
        )));
    }
    let set_up = RigSetUp {
        magnets: at_work.magnets.then(magnets),
        accelerometer_m_per_s2: at_work.magnets.then_some(FULL_SCALE_M_PER_S2),
        seed: at_work.seed,
        spindle_hz: at_work.spindle_hz,
        faults: at_work.faults.clone(),
        ..RigSetUp::default()
    };
    Ok(match &at_work.cut {
        Some(cut) => {
            let cut = VirtualCut::new(&cut.scenario)
                .map_err(|why| Failure::whole(&at_work.name, why, "correct the fields it names"))?;
            SimRig::new(set_up, cut.map(|reading| reading.value))
        }
        None => {
            let mut rng = ChaCha8Rng::seed_from_u64(at_work.seed);
            let sound = std::iter::repeat_with(move || {
                let x: f32 = StandardNormal.sample(&mut rng);
                QUIET_RMS * x
            });
            SimRig::new(set_up, sound)
        }
    })
}

/// The scenario with its own host, as fast as it goes.
fn play(
    all: &mut SimBox,
    at_work: &AtWork,
    json: bool,
    mut record: Option<RecordFile>,
) -> Result<u8, Failure> {
    if !json {
        say!("Scenario {}: {}.", at_work.name, at_work.about);
    }
    let mut acts = at_work.host.clone();
    acts.sort_by(|a, b| a.0.total_cmp(&b.0));
    if at_work.magnets {
        let first = calibration(at_work.seed)?.into_iter().map(|c| (0.05, c));
        acts.splice(0..0, first);
    }
    let mut acts = acts.into_iter().peekable();
    let end_us = (1e6 * at_work.duration_s) as u64;
    let mut reader = FrameReader::default();
    let mut teller = Teller::default();
    let mut summary = Summary::default();
    let mut last_status = String::new();
    all.host.keep_all = false;
    while all.rig.world_us() < end_us {
        let now_s = 1e-6 * all.rig.world_us() as f64;
        while let Some((_, command)) = acts.next_if(|(at_s, _)| *at_s <= now_s) {
            all.send(&command);
        }
        let bytes = all.step_and_take();
        if let Some(file) = record.as_mut() {
            file.write(&bytes)?;
        }
        reader.take(&bytes, |head, message| {
            summary.take(&message);
            if json {
                say!("{}", teller.json(head, &message));
            } else if let Some(text) = shown(&mut teller, &message, &mut last_status) {
                say!("{now_s:9.3} s  {text}");
            }
        });
        stdout::check()?;
    }
    record.map_or(Ok(()), RecordFile::end)?;
    let health = all.app.health(all.rig.world_us());
    let code = u8::from(summary.chatter > 0 || summary.trips > 0);
    if json {
        say!(
            "{}",
            json!({ "summary": { "scenario": at_work.name, "seconds": at_work.duration_s, "resets": all.resets, "chatter": summary.chatter, "trips": summary.trips, "frames": reader.whole, "broken": reader.broken, "missing": reader.missing, "health": health } })
        );
    } else {
        say!(
            "{} verdicts, {} calls of chatter, {} trips, {} resets; frames: {} whole, {} broken, {} missing.",
            health.verdicts,
            summary.chatter,
            summary.trips,
            all.resets,
            reader.whole,
            reader.broken,
            reader.missing
        );
    }
    Ok(code)
}

#[derive(Default)]
struct Summary {
    chatter: u32,
    trips: u32,
}

impl Summary {
    fn take(&mut self, message: &Telemetry) {
        match message {
            Telemetry::Alarm(alarm) if alarm.on => self.chatter += 1,
            Telemetry::Fault(f) if f.severity == Severity::Trip => self.trips += 1,
            _ => {}
        }
    }
}

/// What is worth a line: everything but heartbeats' answers and a status like the last.
fn shown(teller: &mut Teller, message: &Telemetry, last_status: &mut String) -> Option<String> {
    let text = teller.words(message);
    match message {
        Telemetry::Reply(reply) if reply.answer == Answer::Done => None,
        Telemetry::Health(_) => None,
        Telemetry::Status(s) => {
            let state = format!("{} {}", s.mode.name(), s.stage.name());
            if state == *last_status {
                return None;
            }
            *last_status = state;
            text
        }
        _ => text,
    }
}

/// The box in real time on a socket.
fn serve(
    all: &mut SimBox,
    at_work: &AtWork,
    mut bridge: Bridge,
    mut record: Option<RecordFile>,
) -> Result<u8, Failure> {
    say!("{}: listening on {}", at_work.name, bridge.address()?);
    stdout::check()?;
    let begun = Instant::now();
    let end_us = (1e6 * at_work.duration_s) as u64;
    while all.rig.world_us() < end_us {
        let until = all.rig.world_us() + SLICE_US;
        while all.rig.world_us() < until {
            let bytes = all.step_and_take();
            if let Some(file) = record.as_mut() {
                file.write(&bytes)?;
            }
            bridge.say(&bytes);
        }
        bridge.hear(|frame| all.rig.link.host_sends(frame));
        let ahead = Duration::from_micros(all.rig.world_us()).saturating_sub(begun.elapsed());
        std::thread::sleep(ahead);
    }
    record.map_or(Ok(()), RecordFile::end)?;
    Ok(0)
}
