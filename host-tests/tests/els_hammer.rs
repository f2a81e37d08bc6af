//! Promise: a hammer record gives receptance and modes, by two methods that share
//! nothing but the record, and both are those of the tool.
//!
//! `cargo test --release -p host-tests --test els_hammer -- --nocapture`

use host_tests::resources::{Known, shared_or_skip};
use rarma_rigs::els::AgreedMode;
use rarma_scenarios::els::hammer::{Blow, Sensor, modes_in_frequency};

const BAND_HZ: (f64, f64) = (500.0, 3000.0);

/// The recording's reference: frequencies off the imaginary parts of a five-point test,
/// the first damping off the peaks of the real part.
const REFERENCE_HZ: [f64; 3] = [1074.0, 1961.0, 2617.0];
const REFERENCE_ZETA: f64 = 0.0340;

fn nearest(modes: &[AgreedMode<f64>], f: f64) -> AgreedMode<f64> {
    *modes
        .iter()
        .min_by(|a, b| (a.f_hz - f).abs().total_cmp(&(b.f_hz - f).abs()))
        .expect("a mode")
}

fn show(what: &str, modes: &[AgreedMode<f64>]) {
    for m in modes {
        println!(
            "{what:10} {:8.1} ± {:5.1} Hz   zeta {:.4} ± {:.4}   {} fits",
            m.f_hz, m.f_spread_hz, m.zeta, m.zeta_spread, m.fits
        );
    }
}

#[test]
fn the_recorded_tool_has_its_modes() {
    let Some(folder) = shared_or_skip("the_recorded_tool_has_its_modes") else {
        return;
    };
    let read = |name: &str| Known::read(&folder, &format!("leekun_tool_impact/{name}")).recording;
    let (force, response) = (read("point1_force_N"), read("point1_acc_mps2"));
    let blow = Blow {
        force: &force.samples,
        response: &response.samples,
        fs: force.fs,
        sensor: Sensor::Acceleration,
    };
    let (f, g) = blow.receptance(BAND_HZ).expect("a receptance");
    let by_frequency = modes_in_frequency(&f, &g).expect("modes");
    let in_time = blow.modes_in_time(BAND_HZ).expect("modes");
    show("frequency", &by_frequency);
    show("time", &in_time);
    for modes in [&by_frequency, &in_time] {
        for want in REFERENCE_HZ {
            let m = nearest(modes, want);
            let off = m.f_hz / want - 1.0;
            println!("{want} Hz: {:+.2} %", 100.0 * off);
            assert!(off.abs() < 0.015, "{want}: {m:?}");
        }
        let first = nearest(modes, REFERENCE_HZ[0]);
        let off = first.zeta / REFERENCE_ZETA - 1.0;
        println!("zeta 1: {:+.1} %", 100.0 * off);
        assert!(off.abs() < 0.10, "{first:?}");
    }
}
