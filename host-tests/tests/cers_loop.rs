//! The exciter's current loop on magnets with iron, eddy currents and three-level PWM:
//! bandwidth, phase margin, voltage limit, ways to zero current.
//!
//! `cargo test --release -p host-tests --test cers_loop -- --nocapture`

use rarma_plants::cers::{COILS, CoilConfig, ExciterConfig, ExciterPlant};
use rarma_rigs::cers::{GapSchedule, Geometry, Regulator, RegulatorConfig, Tuning};
use rarma_rigs::els::Complex;
use std::f64::consts::TAU;

/// What the firmware is told about the magnets: right, but for eddy currents and knee.
fn geometry() -> Geometry<f32> {
    Geometry {
        iron_path_m: 0.12,
        leakage: 0.5e-3 / 4.19e-3,
        ..Geometry::textbook()
    }
}

fn tuning(rate_hz: f64, crossover: f32) -> Tuning {
    let g = geometry();
    RegulatorConfig {
        inductance_h: g.inductance_h(g.gap_m),
        resistance_ohm: 4.0,
        rate_hz: rate_hz as f32,
        crossover,
        most_duty: 0.95,
    }
    .tuning()
    .expect("a valid regulator")
}

struct Loop {
    plant: ExciterPlant,
    regulators: [Regulator; COILS],
    tuning: [Tuning; COILS],
    limiting: bool,
}

impl Loop {
    fn new(config: ExciterConfig, tuning: Tuning) -> Self {
        Self {
            plant: ExciterPlant::new(config, 1).expect("a valid plant"),
            regulators: [Regulator::default(); COILS],
            tuning: [tuning; COILS],
            limiting: false,
        }
    }

    /// One period; gives the currents it was decided on.
    fn period(&mut self, target_a: [f32; COILS]) -> [f64; COILS] {
        let seen = self.plant.read().current_a;
        let per_volt = 1.0 / self.plant.config().supply_v as f32;
        self.limiting = false;
        let duty = std::array::from_fn(|k| {
            let drive =
                self.regulators[k].update(&self.tuning[k], target_a[k], seen[k] as f32, per_volt);
            self.limiting |= drive.limiting;
            f64::from(drive.duty)
        });
        self.plant.period(Some(duty));
        seen
    }
}

/// Small-signal response i/target of coil +x about 0.8 A, at one frequency.
fn closed_loop(config: &ExciterConfig, tuning: Tuning, f_hz: f64) -> Complex<f64> {
    let mut at = Loop::new(config.clone(), tuning);
    let rate = config.loop_hz;
    let settle = 600;
    // Near to a whole number of cycles: 20 ms of them.
    let periods = ((0.02 * f_hz).ceil() * rate / f_hz).round() as usize;
    let mut sum = Complex::ZERO;
    let mut drive = Complex::ZERO;
    for n in 0..settle + periods {
        let phase = TAU * f_hz * n as f64 / rate;
        let swing = 0.02 * phase.cos();
        let i = at.period([(0.8 + swing) as f32, 0.8, 0.8, 0.8])[0];
        if n >= settle {
            let turn = Complex::new(phase.cos(), -phase.sin());
            sum = sum + turn.scale(i - 0.8);
            drive = drive + turn.scale(swing);
        }
    }
    sum * drive.inverse()
}

fn quiet(loop_hz: f64) -> ExciterConfig {
    let base = ExciterConfig::default();
    ExciterConfig {
        loop_hz,
        sensors: base.sensors.quiet(),
        ..base
    }
}

struct Measured {
    corner_hz: f64,
    crossover_hz: f64,
    margin_deg: f64,
    peak_db: f64,
}

/// Closed loop over frequency, and the open one from it: L = T/(1 − T).
fn measure(config: &ExciterConfig, tuning: Tuning) -> Measured {
    let mut out = Measured {
        corner_hz: f64::NAN,
        crossover_hz: f64::NAN,
        margin_deg: f64::NAN,
        peak_db: f64::MIN,
    };
    let one = Complex::new(1.0, 0.0);
    let (mut before, mut open_before) = (0.0, 0.0f64);
    let mut f_before = 0.0;
    for k in 0..40 {
        let f = 1200.0 + 250.0 * f64::from(k);
        let t = closed_loop(config, tuning, f);
        let db = 20.0 * t.abs().log10();
        out.peak_db = out.peak_db.max(db);
        let open = t * (one - t).inverse();
        let open_db = 20.0 * open.abs().log10();
        let between =
            |a: f64, b: f64, level: f64| f_before + (f - f_before) * (a - level) / (a - b);
        if k > 0 && open_before > 0.0 && open_db <= 0.0 && out.crossover_hz.is_nan() {
            out.crossover_hz = between(open_before, open_db, 0.0);
            out.margin_deg = 180.0 + open.im.atan2(open.re).to_degrees();
        }
        if k > 0 && before > -3.01 && db <= -3.01 {
            out.corner_hz = between(before, db, -3.01);
            break;
        }
        (before, open_before, f_before) = (db, open_db, f);
    }
    out
}

fn say(name: &str, m: &Measured) {
    println!(
        "{name}: −3 dB at {:.0} Hz, crossover {:.0} Hz, phase margin {:.1}°, peak {:+.2} dB",
        m.corner_hz, m.crossover_hz, m.margin_deg, m.peak_db
    );
}

#[test]
fn bandwidth_and_phase_margin_are_those_of_the_design() {
    // The design's own plant: one inductance, no lag. 90° − 540°/18 = 60°; −3 dB 5.0 kHz.
    let mut ideal = quiet(40e3);
    for c in &mut ideal.coils {
        *c = CoilConfig {
            lamination_m: 0.0,
            saturation_t: 3.0,
            ..*c
        };
    }
    let m = measure(&ideal, tuning(40e3, 1.0 / 18.0));
    say("40 kHz, no eddy currents", &m);
    assert!((4900.0..5500.0).contains(&m.corner_hz), "{}", m.corner_hz);
    assert!((57.0..63.0).contains(&m.margin_deg), "{}", m.margin_deg);
    assert!((2100.0..2400.0).contains(&m.crossover_hz));

    // With 0.35 mm laminations the flux lags and the coil is less of an inductance.
    let m = measure(&quiet(40e3), tuning(40e3, 1.0 / 18.0));
    say("40 kHz, 0.35 mm laminations", &m);
    assert!((5750.0..6350.0).contains(&m.corner_hz), "{}", m.corner_hz);
    assert!((55.0..70.0).contains(&m.margin_deg), "{}", m.margin_deg);

    let m = measure(&quiet(50e3), tuning(50e3, 1.0 / 18.0));
    say("50 kHz, 0.35 mm laminations", &m);
    assert!((7600.0..8400.0).contains(&m.corner_hz), "{}", m.corner_hz);
    assert!((55.0..70.0).contains(&m.margin_deg), "{}", m.margin_deg);
}

#[test]
fn the_schedule_keeps_the_bandwidth_where_the_gap_closes() {
    let mut narrow = quiet(40e3);
    narrow.gap_m = 100e-6;
    let fixed = tuning(40e3, 1.0 / 18.0);
    let scheduled = GapSchedule::new(fixed, &geometry()).at(100e-6);
    let (a, b) = (measure(&narrow, fixed), measure(&narrow, scheduled));
    say("100 µm, gain of 150 µm", &a);
    say("100 µm, gain of 100 µm", &b);
    let at_rest = measure(&quiet(40e3), fixed);
    assert!((0.55..0.85).contains(&(a.crossover_hz / at_rest.crossover_hz)));
    assert!((0.95..1.12).contains(&(b.crossover_hz / at_rest.crossover_hz)));
    assert!((b.margin_deg - at_rest.margin_deg).abs() < 6.0);
}

#[test]
fn a_step_at_the_voltage_limit_does_not_wind_up() {
    let mut at = Loop::new(quiet(40e3), tuning(40e3, 1.0 / 18.0));
    for _ in 0..2000 {
        at.period([0.8; COILS]);
    }
    let (mut limited, mut peak, mut reached, mut settled) = (0, 0.0f64, None, 0);
    for n in 0..800 {
        let i = at.period([2.0, 0.8, 0.8, 0.8])[0];
        limited += usize::from(at.limiting);
        peak = peak.max(i);
        if i > 1.9 && reached.is_none() {
            reached = Some(n);
        }
        if (i - 2.0).abs() > 0.02 {
            settled = n;
        }
    }
    let ms = |n: usize| n as f64 / 40.0;
    println!(
        "0.8 to 2.0 A at 48 V: {limited} periods at the limit, 1.9 A after {:.3} ms, overshoot \
         {:.1} %, within 1 % after {:.3} ms",
        ms(reached.expect("reached")),
        100.0 * (peak / 2.0 - 1.0),
        ms(settled)
    );
    assert!((2..=4).contains(&limited), "{limited}");
    assert!((0.14..0.21).contains(&ms(reached.unwrap())));
    assert!(
        (1.99..2.02).contains(&peak) && (0.7..1.0).contains(&ms(settled)),
        "{peak} {settled}"
    );

    // A target beyond a supply of 12 V for half a second, then back: down at once.
    let weak = ExciterConfig {
        supply_v: 12.0,
        ..quiet(40e3)
    };
    let mut at = Loop::new(weak, tuning(40e3, 1.0 / 18.0));
    for _ in 0..20_000 {
        at.period([4.0, 0.8, 0.8, 0.8]);
    }
    let held = at.period([4.0, 0.8, 0.8, 0.8])[0];
    assert!((2.80..2.86).contains(&held), "{held}");
    let mut down = 0;
    while at.period([0.8; COILS])[0] > 0.99 * held {
        down += 1;
    }
    println!("{held:.2} A held for 0.5 s, falls after {down} periods");
    assert!(down <= 6, "{down}");
}

#[test]
fn open_switches_end_the_current_in_the_70_microsecond_class() {
    for (amps, low, high) in [(0.8f32, 50.0, 100.0), (1.6, 100.0, 200.0)] {
        let mut at = Loop::new(quiet(40e3), tuning(40e3, 1.0 / 18.0));
        for _ in 0..2000 {
            at.period([amps; COILS]);
        }
        let mut us = 0.0;
        while at.plant.truth().current_a.iter().any(|i| *i > 0.0) {
            at.plant.period(None);
            us += 25.0;
        }
        println!("{amps} A in four coils: no current after {us} µs (in steps of 25)");
        assert!((low..=high).contains(&us), "{us}");
    }
}
