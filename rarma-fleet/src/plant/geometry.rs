//! Loops and errors of a machine, as a ball bar sees them: truth, and what a test makes of it.

use crate::record::{Hysteresis, MachineError, Name};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Loops and errors, as they are at the smallest force.
#[derive(Debug, Clone, PartialEq)]
pub struct Geometry {
    /// Width of the loop, mean over all directions, µm.
    pub loop_um: f64,
    /// How much wider it is along the first axis than along the second: part of the mean, −1 to 1.
    pub loop_wave: f64,
    /// How much longer the first axis measures than the second, µm over the circle.
    pub scale_mismatch_um: f64,
    /// Departure from a right angle, µrad.
    pub squareness_urad: f64,
    /// Of each axis, µm.
    pub straightness_um: [f64; 2],
    /// Of each axis, µm.
    pub backlash_um: [f64; 2],
    /// Of each axis, µm.
    pub lateral_play_um: [f64; 2],
    /// How much more the first axis lags than the second, ms.
    pub servo_mismatch_ms: f64,
    /// What 1 kN adds to the scale mismatch, µm, and to the squareness, µrad: errors that grow with load are
    /// compliance.
    pub per_kn: [f64; 2],
    /// What a degree of the hall adds to the scale mismatch, µm/K, and to the squareness, µrad/K.
    pub per_k: [f64; 2],
}

/// Deviations from test to test. The simulated rig itself (24 tests of `ldbb-m3`: seeds, balls somewhere else, feeds of 1
/// to 2 m/min) scatters by 0.3 % of the mean loop, 0.05 µm of scale mismatch, 0.2 µrad, 0.04 µm of straightness, 0.03 µm of
/// backlash and of play, 0.002 ms. What it does not have is put on top: half a degree between two axes (1.8 µm/K on 150 mm),
/// oil, another bar whose seal has a third more or less friction (0.26 µm of backlash at 1.5 N).
const LOOP_SD: f64 = 0.03;
const LOOP_OPERATOR_SD: f64 = 0.02;
const SCALE_SD_UM: f64 = 0.8;
const SQUARENESS_SD_URAD: f64 = 1.5;
const STRAIGHTNESS_SD_UM: f64 = 0.15;
const BACKLASH_SD_UM: f64 = 0.08;
const PLAY_SD_UM: f64 = 0.06;
const SERVO_SD_MS: f64 = 0.01;
/// Of one loop, µm: stated nowhere, measured like the others.
const ONE_LOOP_SD_UM: f64 = 0.05;
/// Where the balls stand, µm: no property of the machine.
const CENTRE_SD_UM: f64 = 15.0;

/// Forces at which errors are told, N: the least and the largest of a test.
const FORCES_N: [f64; 2] = [50.0, 800.0];

impl Geometry {
    /// Draws one: ranges around the machines M3 and M5 of the shipped tests.
    pub(super) fn draw(rng: &mut ChaCha8Rng) -> Self {
        let mut two = |from: f64, to: f64| [rng.random_range(from..to), rng.random_range(from..to)];
        let ([loop_um, _], [loop_wave, _]) = (two(2.5, 6.0), two(-0.35, 0.35));
        Self {
            loop_um,
            loop_wave,
            scale_mismatch_um: two(-12.0, 12.0)[0],
            squareness_urad: two(-25.0, 25.0)[0],
            straightness_um: two(-3.0, 3.0),
            backlash_um: two(0.5, 2.5),
            lateral_play_um: two(0.0, 0.6),
            servo_mismatch_ms: two(-0.3, 0.3)[0],
            per_kn: two(-10.0, 10.0),
            per_k: two(-0.3, 0.3),
        }
    }

    /// In a hall that is warmer by so many K.
    pub(super) fn warmer(&mut self, kelvin: f64) {
        self.scale_mismatch_um += self.per_k[0] * kelvin;
        self.squareness_urad += self.per_k[1] * kelvin;
    }

    /// A joint of an axis (0 or 1) has worn: loops are wider by a part, and its backlash grows.
    pub(super) fn worn(&mut self, axis: usize, part: f64, backlash_um: f64) {
        self.loop_um *= 1.0 + part;
        self.backlash_um[axis] += backlash_um;
    }

    /// What a test says of the loops: in twelve directions.
    pub(super) fn loops(
        &self,
        bad: f64,
        operator: f64,
        gauss: &mut impl FnMut() -> f64,
    ) -> Vec<Hysteresis> {
        let whole = (bad * LOOP_SD * gauss() + LOOP_OPERATOR_SD * operator).exp();
        (0..12)
            .map(|n| {
                let angle_deg = f64::from(n) * 30.0;
                let wave = self.loop_wave * (2.0 * angle_deg.to_radians()).cos();
                let um = self.loop_um * (1.0 + wave) * whole + ONE_LOOP_SD_UM * gauss();
                Hysteresis {
                    angle_deg,
                    um: um.max(0.0),
                    sd_um: 0.0,
                }
            })
            .collect()
    }

    /// What a test says of the errors: at the least and the largest force.
    pub(super) fn errors(&self, bad: f64, gauss: &mut impl FnMut() -> f64) -> Vec<MachineError> {
        let centre = [CENTRE_SD_UM * gauss(), CENTRE_SD_UM * gauss()];
        // The same set-up at both forces.
        let named = [
            ("centre_um.0", centre[0], 0.0, 0.0),
            ("centre_um.1", centre[1], 0.0, 0.0),
            (
                "scale_mismatch_um",
                self.scale_mismatch_um,
                SCALE_SD_UM,
                self.per_kn[0],
            ),
            (
                "squareness_urad",
                self.squareness_urad,
                SQUARENESS_SD_URAD,
                self.per_kn[1],
            ),
            (
                "straightness_um.0",
                self.straightness_um[0],
                STRAIGHTNESS_SD_UM,
                0.0,
            ),
            (
                "straightness_um.1",
                self.straightness_um[1],
                STRAIGHTNESS_SD_UM,
                0.0,
            ),
            ("backlash_um.0", self.backlash_um[0], BACKLASH_SD_UM, 0.0),
            ("backlash_um.1", self.backlash_um[1], BACKLASH_SD_UM, 0.0),
            (
                "lateral_play_um.0",
                self.lateral_play_um[0],
                PLAY_SD_UM,
                0.0,
            ),
            (
                "lateral_play_um.1",
                self.lateral_play_um[1],
                PLAY_SD_UM,
                0.0,
            ),
            (
                "servo_mismatch_ms",
                self.servo_mismatch_ms,
                SERVO_SD_MS,
                0.0,
            ),
        ];
        let set_up = named.map(|(_, _, sd, _)| bad * sd * gauss());
        let mut all = Vec::new();
        for force_n in FORCES_N {
            for ((name, value, sd, per_kn), off) in named.into_iter().zip(set_up) {
                // Stated: a tenth of what tests differ by, as on the rig.
                let stated = 0.1 * sd + 0.001;
                all.push(MachineError {
                    name: Name::new(name).expect("a name of ours"),
                    force_n,
                    value: value + per_kn * force_n / 1e3 + off + stated * gauss(),
                    sd: stated,
                });
            }
        }
        all
    }
}
