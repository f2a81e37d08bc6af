//! Frequency and damping of two modes, each with its standard deviation, ten times a second:
//! the estimator alone, of an order that is known when the program is built.
//!
//! ```sh
//! cargo run --release -p rarma-core --example damping
//! ```

use rarma_core::prelude::*;

const FS_HZ: f64 = 6000.0;
/// True frequency, Hz, and damping ratio of each mode; the second loses its damping.
const MODES: [(f64, f64); 2] = [(420.0, 0.03), (900.0, 0.02)];

fn main() {
    let mut model = Arma43::<f64>::new(RarmaConfig {
        forgetting: 1.0 - 1.0 / 3000.0, // remembers half a second
        ..RarmaConfig::default()
    });
    let mut roots = FactorTracker::<f64, 4>::new();
    let mut machine = Machine::new();
    println!("    t, s       true ζ, %        f, Hz            ζ, %");
    for n in 1..=12_000u32 {
        let t = f64::from(n) / FS_HZ;
        let damping = MODES[1].1 * (1.0 - t / 2.2);
        model.update(machine.sound(damping));
        roots.track(model.a());
        if n % 1200 != 0 {
            continue;
        }
        for pole in roots.factors(4) {
            let covariance = (model.covariance(), model.covariance_factor());
            let (Some(mode), Some(sd)) = (
                modal(pole, FS_HZ),
                deviation(model.a(), 7, pole, FS_HZ, covariance.0, covariance.1),
            ) else {
                continue; // a real root is no vibration
            };
            let is_low = mode.frequency < 660.0;
            let truth = if is_low { MODES[0].1 } else { damping };
            println!(
                "{t:8.1} {:14.2} {:10.1} ± {:4.1} {:8.2} ± {:.2}",
                100.0 * truth,
                mode.frequency,
                sd.frequency,
                100.0 * mode.damping,
                100.0 * sd.damping
            );
        }
    }
}

/// Two resonators driven by the same noise, heard together.
struct Machine {
    past: [[f64; 2]; 2],
    seed: u32,
}

impl Machine {
    fn new() -> Self {
        Self {
            past: [[0.0; 2]; 2],
            seed: 1,
        }
    }

    fn sound(&mut self, second_damping: f64) -> f64 {
        self.seed = self
            .seed
            .wrapping_mul(1_664_525)
            .wrapping_add(1_013_904_223);
        let force = f64::from(self.seed >> 8) / 8_388_608.0 - 1.0;
        let mut sum = 0.0;
        for (k, (f, zeta)) in [MODES[0], (MODES[1].0, second_damping)]
            .into_iter()
            .enumerate()
        {
            let w = core::f64::consts::TAU * f / FS_HZ;
            let (r, angle) = ((-zeta * w).exp(), w * (1.0 - zeta * zeta).sqrt());
            let [y1, y2] = self.past[k];
            let y = 2.0 * r * angle.cos() * y1 - r * r * y2 + force;
            self.past[k] = [y, y1];
            sum += y;
        }
        sum
    }
}
