//! What the rigs say of a machine: the truth with the deviations of a test, and those that no test states.

use super::life::Life;
use super::machine::Drawn;
use super::says::Says;
use crate::record::{
    Body, DirectionLimit, DirectionStiffness, Limits, Modes, Name, Stiffness, StructuralMode,
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Days between two tests with the ball bar, and with the exciter.
const BAR_DAYS: u32 = 14;
/// Days between two tests of the linked system.
const LINKED_DAYS: u32 = 28;

/// Deviation of one direction that the bar states, 1.
const RAY_SD: f64 = 0.004;
/// What it does not state, 1: the gain of the force from set-up to set-up, in all directions alike; and how
/// the plane is set up, different in each direction.
const GAIN_SD: f64 = 0.006;
const SETUP_SD: f64 = 0.004;
/// Of an operator, 1: how the balls are seated.
const OPERATOR_SD: f64 = 0.008;

/// Deviations of the exciter, 1: stated, and from test to test.
const F_SD: f64 = 0.0004;
const F_SETUP_SD: f64 = 0.001;
const ZETA_SD: f64 = 0.015;
const ZETA_SETUP_SD: f64 = 0.02;
/// What another holder does to frequency and damping, 1.
const HOLDER_F_SD: f64 = 0.01;
const HOLDER_ZETA_SD: f64 = 0.06;

/// Deviations of the linked system, 1: stated of a direction, and of the whole test.
const WIDTH_SD: f64 = 0.03;
const WIDTH_SETUP_SD: f64 = 0.03;
/// Distance of its lines, Hz.
const LINE_HZ: f64 = 2.0;

/// One test in so many is set up badly, and is off by several times the usual.
const BAD_ONE_IN: f64 = 80.0;
const BAD: f64 = 5.0;

const OPERATORS: [&str; 4] = ["ada", "ben", "cem", "dora"];
const HOLDERS: [&str; 3] = ["H1", "H2", "H3"];

fn gauss(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// A deviation that belongs to a name and a machine: the same each time it is asked.
fn of_name(name: &str, salt: &str, machine: &Name) -> f64 {
    let bits = crate::record::session_of_bytes(format!("{name} {salt} {machine}").as_bytes());
    // Twelve parts of 4 bits each have nearly a normal sum.
    let sum: f64 = (0..13).map(|n| ((bits >> (4 * n)) & 15) as f64).sum();
    (sum - 13.0 * 7.5) / (13.0 * 255.0 / 12.0_f64).sqrt()
}

pub(super) fn of_day(says: &mut Says, drawn: &Drawn, life: &Life, rng: &mut ChaCha8Rng) {
    // Every machine has its own weekday.
    let shift = u32::try_from(of_name("day", "shift", &drawn.name).to_bits() % 14).unwrap_or(0);
    let day = says.day() + shift;
    let operator = OPERATORS[rng.random_range(0..OPERATORS.len())];
    // The holder of a machine is used for a season, then there is a new one.
    let holder = HOLDERS[(day / 130) as usize % HOLDERS.len()];
    if day % BAR_DAYS == 3 {
        bar(says, drawn, life, operator, rng);
    }
    if day % BAR_DAYS == 5 {
        exciter(says, drawn, life, (holder, operator), rng);
    }
    if day % LINKED_DAYS == 6 {
        linked(says, drawn, life, operator, rng);
    }
}

fn badly(rng: &mut ChaCha8Rng) -> f64 {
    if rng.random::<f64>() < 1.0 / BAD_ONE_IN {
        BAD
    } else {
        1.0
    }
}

fn bar(says: &mut Says, drawn: &Drawn, life: &Life, operator: &str, rng: &mut ChaCha8Rng) {
    let part = rng.random_range(0.3..0.7);
    let now = life.at(drawn, f64::from(says.day()) + part);
    let bad = badly(rng);
    let gain = bad * GAIN_SD * gauss(rng) + OPERATOR_SD * of_name(operator, "bar", &drawn.name);
    // A plane that is set up a little off: two of the tensor's numbers.
    let (a, b) = (bad * SETUP_SD * gauss(rng), bad * SETUP_SD * gauss(rng));
    let directions = (0..12).map(|n| {
        let angle_deg = f64::from(n) * 30.0;
        let angle = angle_deg.to_radians();
        let off = gain + a * (2.0 * angle).cos() + b * (2.0 * angle).sin() + RAY_SD * gauss(rng);
        let n_per_um = 1.0 / (now.plane.along(angle) * (1.0 + off));
        DirectionStiffness {
            angle_deg,
            n_per_um,
            sd_n_per_um: RAY_SD * n_per_um,
        }
    });
    let directions = directions.collect();
    let seated = of_name(operator, "loop", &drawn.name);
    let body = Body::Stiffness(Stiffness {
        plane: Name::new("XY").expect("two letters"),
        radius_mm: 150.0,
        inclination_deg: 0.0,
        directions,
        scale_sd: GAIN_SD,
        hysteresis: now.geometry.loops(bad, seated, &mut || gauss(rng)),
        errors: now.geometry.errors(bad, &mut || gauss(rng)),
    });
    says.test("bar", part, "", operator, body);
}

fn exciter(says: &mut Says, drawn: &Drawn, life: &Life, who: (&str, &str), rng: &mut ChaCha8Rng) {
    let (holder, operator) = who;
    let part = rng.random_range(0.3..0.7);
    let now = life.at(drawn, f64::from(says.day()) + part);
    let bad = badly(rng);
    let modes = now.modes.iter().enumerate().map(|(n, mode)| {
        let of = |salt: &str| of_name(holder, &format!("{salt} {n}"), &drawn.name);
        let f = F_SD * gauss(rng) + bad * F_SETUP_SD * gauss(rng) + HOLDER_F_SD * of("f");
        let zeta =
            ZETA_SD * gauss(rng) + bad * ZETA_SETUP_SD * gauss(rng) + HOLDER_ZETA_SD * of("zeta");
        let (f_hz, zeta) = (mode.f_hz * f.exp(), mode.zeta * zeta.exp());
        StructuralMode {
            axis: Name::new(&mode.axis.to_string()).expect("a letter"),
            f_hz,
            f_sd_hz: F_SD * f_hz,
            zeta,
            zeta_sd: ZETA_SD * zeta,
            n_per_um: None,
        }
    });
    let body = Body::Modes(Modes {
        rpm: 0.0,
        modes: modes.collect(),
    });
    says.test("exciter", part, holder, operator, body);
}

fn linked(says: &mut Says, drawn: &Drawn, life: &Life, operator: &str, rng: &mut ChaCha8Rng) {
    let part = rng.random_range(0.3..0.7);
    let now = life.at(drawn, f64::from(says.day()) + part);
    let whole = badly(rng) * WIDTH_SETUP_SD * gauss(rng);
    let directions = (0..12).map(|n| {
        let angle_deg = f64::from(n) * 30.0;
        let width = now.width_mm(angle_deg.to_radians()) * (whole + WIDTH_SD * gauss(rng)).exp();
        DirectionLimit {
            angle_deg,
            width_mm: width,
            sd_mm: WIDTH_SD * width,
            chatter_hz: Some((now.chatter_hz(angle_deg.to_radians()) / LINE_HZ).round() * LINE_HZ),
        }
    });
    let body = Body::Limits(Limits {
        ks_n_per_mm2: now.ks_n_per_mm2,
        directions: directions.collect(),
    });
    says.test("linked", part, "", operator, body);
}
