//! A record of the exciter: the sampled channels and what must be known to read them.
//!
//! A folder of two files. `signals.wav`: float, one channel a signal in SI units, in the
//! order of [`CHANNELS`]. `record.toml`: rate, excitation, constants of the magnets,
//! sensors; read by the same reader as the scenarios.

use super::drive::Drive;
use rarma_recordings::output::{self, NewFile, WavFile, WriteError};
use rarma_rigs::cers::{AxisForce, Eddy, Magnet};
use std::fmt::Write as _;
use std::path::Path;

/// Channels of `signals.wav`. The angle is the spindle's, 0 to 1 of a revolution.
pub const CHANNELS: [&str; 11] = [
    "command x A",
    "command y A",
    "current +x A",
    "current -x A",
    "current +y A",
    "current -y A",
    "displacement x m",
    "displacement y m",
    "acceleration x m/s2",
    "acceleration y m/s2",
    "angle of the spindle rev",
];

/// What a simulation knows of the structure.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Frequency at rest Hz, damping ratio at rest, parts of the motion in x and y.
    pub modes: Vec<[f64; 4]>,
    /// Speed at which the two changes below are reached, revolutions/s.
    pub at_hz: f64,
    /// Part by which frequencies change there, with the square of the speed.
    pub frequency_part: f64,
    /// Part by which damping ratios change there, with the speed.
    pub damping_part: f64,
}

impl Truth {
    /// Frequency Hz and damping ratio of the modes of a direction (those that move it most)
    /// at a speed, revolutions/s.
    pub fn at(&self, axis: usize, spindle_hz: f64) -> Vec<(f64, f64)> {
        let r = spindle_hz / self.at_hz;
        let (f, z) = (
            1.0 + self.frequency_part * r * r,
            1.0 + self.damping_part * r,
        );
        self.modes
            .iter()
            .filter(|m| (m[2].abs() >= m[3].abs()) == (axis == 0))
            .map(|m| (m[0] * f, m[1] * z))
            .collect()
    }
}

/// What must be known to read a record.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// Name of the structure.
    pub name: String,
    /// Samples a second.
    pub rate_hz: f64,
    /// Bias of every coil, A.
    pub bias_a: f64,
    /// The excitation.
    pub drive: Drive,
    /// Orders of the spindle and its bearings that are not the structure's.
    pub orders: Vec<f64>,
    /// Bands of the tracks of a sweep, Hz.
    pub tracks_hz: Vec<(f64, f64)>,
    /// Constants of +x, −x, +y, −y.
    pub magnets: [Magnet<f64>; 4],
    /// Gap with the rotor in the middle, m.
    pub gap_m: f64,
    /// Half the angle between a magnet's poles, rad.
    pub pole_angle_rad: f64,
    /// Lag of the flux; none: not corrected.
    pub lag: Option<Eddy<f64>>,
    /// Corner of the displacement sensors, Hz, second-order Butterworth; and of the
    /// accelerometer.
    pub corner_hz: [f64; 2],
    /// Rate at which those filters run if they are digital (bilinear), Hz; 0: analogue.
    pub sensor_rate_hz: f64,
    /// What a simulation knows.
    pub truth: Option<Truth>,
}

impl Setup {
    /// The law of a direction's force.
    pub fn law(&self, axis: usize) -> AxisForce<f64> {
        AxisForce {
            plus: self.magnets[2 * axis],
            minus: self.magnets[2 * axis + 1],
            gap_m: self.gap_m,
            gap_per_displacement: self.pole_angle_rad.cos(),
        }
    }
}

/// A record in memory; index 0 is x, 1 is y, all at the same instants.
#[derive(Debug, Clone, PartialEq)]
pub struct CersRecord {
    /// What must be known.
    pub setup: Setup,
    /// Commanded change of the current, A.
    pub command_a: [Vec<f64>; 2],
    /// Currents of +x, −x, +y, −y, A.
    pub current_a: [Vec<f64>; 4],
    /// Displacement, m.
    pub displacement_m: [Vec<f64>; 2],
    /// Acceleration, m/s².
    pub acceleration_m_per_s2: [Vec<f64>; 2],
    /// Revolutions of the spindle since the start.
    pub revolutions: Vec<f64>,
}

impl CersRecord {
    /// Samples.
    pub fn len(&self) -> usize {
        self.revolutions.len()
    }

    /// No sample.
    pub fn is_empty(&self) -> bool {
        self.revolutions.is_empty()
    }

    /// Length, s.
    pub fn seconds(&self) -> f64 {
        self.len() as f64 / self.setup.rate_hz
    }

    /// Speed at the start and at the end, each over a twentieth of the record,
    /// revolutions/s.
    pub fn speeds_hz(&self) -> (f64, f64) {
        let n = (self.len() / 20).max(2).min(self.len());
        let mean = |x: &[f64]| match x {
            [first, .., last] => (last - first) / (x.len() - 1) as f64 * self.setup.rate_hz,
            _ => 0.0,
        };
        (
            mean(&self.revolutions[..n]),
            mean(&self.revolutions[self.len() - n..]),
        )
    }

    /// The speed changes by more than a hundredth of its largest: a sweep.
    pub fn is_sweep(&self) -> bool {
        let (a, b) = self.speeds_hz();
        (a - b).abs() > 0.01 * a.max(b).max(1.0)
    }

    /// Magnetic force of a direction at these displacements, N, and the samples that are
    /// not to be trusted.
    pub fn force_n(&self, axis: usize, displacement_m: &[f64]) -> (Vec<f64>, usize) {
        let law = self.setup.law(axis);
        let mut doubtful = 0;
        let force = self.current_a[2 * axis]
            .iter()
            .zip(&self.current_a[2 * axis + 1])
            .zip(displacement_m)
            .map(|((p, m), x)| {
                let f = law.force(*p, *m, *x);
                doubtful += usize::from(!f.trusted);
                f.newton
            })
            .collect();
        (force, doubtful)
    }

    /// Writes both files.
    ///
    /// # Errors
    /// The folder or a file cannot be written.
    pub fn write(&self, dir: &Path) -> Result<(), WriteError> {
        output::folder(dir)?;
        let spec = hound::WavSpec {
            channels: CHANNELS.len() as u16,
            sample_rate: self.setup.rate_hz.round() as u32,
            bits_per_sample: 32,
            sample_format: hound::SampleFormat::Float,
        };
        let mut wav = WavFile::create(&dir.join("signals.wav"), spec)?;
        for n in 0..self.len() {
            let r = self.revolutions[n];
            let lists = self
                .command_a
                .iter()
                .chain(&self.current_a)
                .chain(&self.displacement_m)
                .chain(&self.acceleration_m_per_s2);
            for x in lists.map(|list| list[n]).chain([r - r.floor()]) {
                wav.sample(x as f32)?;
            }
        }
        let text = self.setup.text();
        let text = NewFile::whole(&dir.join("record.toml"), text.as_bytes())?;
        output::keep(vec![wav.finish(None)?, text])
    }
}

impl Setup {
    /// The text of `record.toml`.
    pub fn text(&self) -> String {
        let mut out =
            String::from("# Record of rarma cers: channels of signals.wav in SI units:\n# ");
        out += &CHANNELS.join(", ");
        let d = &self.drive;
        let axes = match d.axes {
            [true, true] => "both",
            [true, false] => "x",
            _ => "y",
        };
        let list = |x: &[f64]| {
            let all: Vec<String> = x.iter().map(|x| format!("{x:?}")).collect();
            format!("[{}]", all.join(", "))
        };
        let tracks: Vec<f64> = self.tracks_hz.iter().flat_map(|b| [b.0, b.1]).collect();
        let name: String = self
            .name
            .chars()
            .filter(|c| !matches!(c, '"' | '\\'))
            .collect();
        let _ = write!(
            out,
            "\nname = \"{name}\"\nrate_hz = {:?}\nbias_a = {:?}\norders = {}\ntracks_hz = {}\n\n[excitation]\nsignal = \"{}\"\naxes = \"{axes}\"\nlow_hz = {:?}\nhigh_hz = {:?}\nrms_a = {:?}\ndodge_hz = {:?}\n\n[gap]\nat_rest_m = {:?}\npole_angle_rad = {:?}\n",
            self.rate_hz,
            self.bias_a,
            list(&self.orders),
            list(&tracks),
            d.signal.name(),
            d.band_hz.0,
            d.band_hz.1,
            d.rms_a,
            d.dodge_hz,
            self.gap_m,
            self.pole_angle_rad,
        );
        for (side, m) in ["+x", "-x", "+y", "-y"].iter().zip(&self.magnets) {
            let _ = write!(
                out,
                "\n[[magnet]]\nside = \"{side}\"\ngain_nm2_per_a2 = {:?}\ngap_offset_m = {:?}\nsaturation_a_per_m = {:?}\n",
                m.gain, m.gap_offset_m, m.saturation_a_per_m
            );
        }
        if let Some(e) = &self.lag {
            let _ = write!(
                out,
                "\n[lag]\nlamination_m = {:?}\nconductivity_s_per_m = {:?}\npermeability = {:?}\niron_path_m = {:?}\n",
                e.lamination_m, e.conductivity_s_per_m, e.permeability, e.iron_path_m
            );
        }
        let _ = write!(
            out,
            "\n[sensors]\ndisplacement_corner_hz = {:?}\nacceleration_corner_hz = {:?}\nfilter_rate_hz = {:?}\n",
            self.corner_hz[0], self.corner_hz[1], self.sensor_rate_hz
        );
        if let Some(t) = &self.truth {
            let column = |k: usize| list(&t.modes.iter().map(|m| m[k]).collect::<Vec<_>>());
            let _ = write!(
                out,
                "\n# What the simulation knows.\n[truth]\nf_hz = {}\nzeta = {}\nx = {}\ny = {}\nat_hz = {:?}\nfrequency_part = {:?}\ndamping_part = {:?}\n",
                column(0),
                column(1),
                column(2),
                column(3),
                t.at_hz,
                t.frequency_part,
                t.damping_part
            );
        }
        out
    }
}
