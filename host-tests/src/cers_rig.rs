//! The box with magnets and a spindle behind its coils, as the exciter's tests use it.

use crate::exciter::{drawing, plant};
use crate::rig::{answer, quiet, set};
use hal_sim::exciter::calibrated;
use hal_sim::rig::{FaultEvent, Heard, RigConfig, RigSetUp, SimBox, SimRig};
use rarma_box::guard::{Mode, Stage};
use rarma_box::settings::SettingValue;
use rarma_box::wire::{Answer, Command, EndMessage, ExcitationMessage, LineMessage, Telemetry};
use rarma_plants::cers::ExciterConfig;
use rarma_rigs::cers::{Direction, ExcitationJob, Magnet, Signal};

/// A stepped sine over the band of the modes.
pub const JOB: ExcitationJob = ExcitationJob {
    signal: Signal::Steps,
    direction: Direction::X,
    rms_a: 0.15,
    low_hz: 250.0,
    high_hz: 3000.0,
    seconds: 40.0,
    lines: 160,
};

/// B of the winding's thermistor, K.
pub const THERMISTOR_B_K: f64 = 3950.0;

/// The plant of the exciter's tests at 40 kHz, its slowest part left out: the ripple.
pub fn magnets() -> ExciterConfig {
    plant()
}

/// Sets a real setting.
pub fn real(all: &mut SimBox, name: &str, value: f32) {
    set(all, name, SettingValue::Real(value));
}

/// Constants of the four magnets, as an operator types them after a calibration.
///
/// # Panics
/// The bench gives none: a mistake here.
pub fn calibrate(all: &mut SimBox, seed: u64) {
    let (laws, _) = calibrated(&magnets(), &drawing(), seed).expect("calibrated");
    let four: [(&str, Magnet<f64>); 4] = [
        ("xp", laws[0].plus),
        ("xm", laws[0].minus),
        ("yp", laws[1].plus),
        ("ym", laws[1].minus),
    ];
    for (name, m) in four {
        real(all, &format!("cers.gain-{name}"), m.gain as f32);
        real(all, &format!("cers.offset-{name}"), m.gap_offset_m as f32);
        real(
            all,
            &format!("cers.knee-{name}"),
            m.saturation_a_per_m as f32,
        );
    }
}

/// A box in mode cers, outputs off, magnets calibrated or not.
pub fn cers(seed: u64, spindle_hz: f64, faults: Vec<FaultEvent>, calibration: bool) -> SimBox {
    let set_up = RigSetUp {
        seed,
        spindle_hz,
        faults,
        magnets: Some(magnets()),
        plant: RigConfig {
            thermistor: Some((313.0, THERMISTOR_B_K)),
            ..RigConfig::default()
        },
        ..RigSetUp::default()
    };
    let mut all = SimBox::new(SimRig::new(set_up, quiet(seed)));
    all.run_to(100_000);
    set(
        &mut all,
        "tacho.pulses",
        SettingValue::Whole(u32::from(spindle_hz > 0.0)),
    );
    all.send(&Command::Start(Mode::Cers));
    real(&mut all, "cers.thermistor", THERMISTOR_B_K as f32);
    if calibration {
        calibrate(&mut all, 100 * seed);
    }
    all.run_to(200_000);
    all
}

/// Sends a command and waits for its answer.
///
/// # Panics
/// There is none.
pub fn ask(all: &mut SimBox, command: Command) -> Answer {
    let to = all.send(&command);
    all.run_for(0.02);
    answer(all, to).expect("answered")
}

/// The lines that were told.
pub fn lines(all: &SimBox) -> Vec<LineMessage> {
    let of = |heard: &Heard| match heard.message {
        Telemetry::Excitation(ExcitationMessage::Line(line)) => Some(line),
        _ => None,
    };
    all.host.heard.iter().filter_map(of).collect()
}

/// How the last signal ended.
pub fn ended(all: &SimBox) -> Option<EndMessage> {
    all.host
        .heard
        .iter()
        .rev()
        .find_map(|heard| match heard.message {
            Telemetry::Excitation(ExcitationMessage::Ended(end)) => Some(end),
            _ => None,
        })
}

/// Runs until a signal has ended.
///
/// # Panics
/// It does not.
pub fn run_until_ended(all: &mut SimBox, most_s: f64) -> EndMessage {
    let until = all.rig.world_us() + (1e6 * most_s) as u64;
    while all.rig.world_us() < until {
        all.run_for(0.1);
        if let Some(end) = ended(all) {
            return end;
        }
    }
    panic!("it does not end: {:?}", all.app.supervisor().stage());
}

/// A box that excites both directions with noise.
///
/// # Panics
/// It does not come to that.
pub fn exciting(faults: Vec<FaultEvent>) -> SimBox {
    let mut all = cers(4, 50.0, faults, true);
    let job = ExcitationJob {
        signal: Signal::Noise,
        direction: Direction::Both,
        seconds: 3.0,
        ..JOB
    };
    assert_eq!(ask(&mut all, Command::Excite(job)), Answer::Done);
    assert_eq!(ask(&mut all, Command::Arm), Answer::Done);
    all.run_to(1_000_000);
    assert_eq!(all.app.supervisor().stage(), Stage::Exciting);
    all
}
