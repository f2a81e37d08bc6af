//! The demonstration's recording, and what the command says of it.

use rarma_box::wire::MonitorJob;
use rarma_cli::commands::{listen, simulate};
use rarma_cli::record::Summary;
use rarma_core::monitor::MonitorConfig;
use rarma_scenarios::scenario;
use std::path::Path;

/// The demonstration's cut.
const SCENARIO: &str = "chatter-onset";
/// Rate of Chromium's stand-in.
const STAND_IN_HZ: f64 = 44_100.0;
/// Its speed, 1/min, and its teeth, as the page is told them.
pub const RPM: f64 = 1680.0;
pub const TEETH: u32 = 6;

/// A recording.
pub struct Sound {
    pub samples: Vec<f32>,
    pub fs: f64,
}

impl Sound {
    /// The demonstration's, heard at the rate of Chromium's own stand-in for a microphone, so
    /// that nothing is converted on the way.
    pub fn of_the_demonstration() -> Self {
        let mut loaded = scenario::load(SCENARIO, None).expect("it is shipped");
        loaded.scenario.microphone.sample_rate_hz = STAND_IN_HZ;
        let played = simulate(&loaded).expect("it can be cut");
        Self {
            samples: played.samples.iter().map(|x| *x as f32).collect(),
            fs: played.fs,
        }
    }

    /// Of a WAV file of one channel, 16 bit or float.
    pub fn read(bytes: &[u8]) -> Self {
        let reader = hound::WavReader::new(bytes).expect("a WAV");
        let spec = reader.spec();
        let samples = match spec.sample_format {
            hound::SampleFormat::Float => {
                reader.into_samples::<f32>().map(Result::unwrap).collect()
            }
            hound::SampleFormat::Int => reader
                .into_samples::<i16>()
                .map(|x| f32::from(x.expect("a sample")) / 32_768.0)
                .collect(),
        };
        Self {
            samples,
            fs: f64::from(spec.sample_rate),
        }
    }

    /// The same after so much silence, s: the page's time begins with the first sound, so it
    /// does not matter when it begins to listen.
    pub fn after_silence(&self, seconds: f64) -> Self {
        let silence = vec![0.0; (seconds * self.fs) as usize];
        Self {
            samples: [silence, self.samples.clone()].concat(),
            fs: self.fs,
        }
    }

    /// As a WAV file of 16 bit.
    pub fn write(&self, path: &Path) {
        let spec = hound::WavSpec {
            channels: 1,
            sample_rate: self.fs as u32,
            bits_per_sample: 16,
            sample_format: hound::SampleFormat::Int,
        };
        let mut writer = hound::WavWriter::create(path, spec).expect("a file");
        for x in &self.samples {
            let code = (x * 32_768.0).round().clamp(-32_768.0, 32_767.0);
            writer.write_sample(code as i16).expect("written");
        }
        writer.finalize().expect("written");
    }

    /// What the command says of it, told the speed and the teeth.
    pub fn by_the_command(&self) -> Summary {
        let job = MonitorJob {
            monitor: MonitorConfig {
                full_scale: Some(1.0),
                spindle_hz: Some(RPM / 60.0),
                teeth: Some(TEETH),
                ..MonitorConfig::new(self.fs)
            },
            channel: 0,
            every_s: 0.01,
        };
        let run = listen(&job, self.samples.iter().copied(), |_| {});
        run.expect("settings are sound").summary
    }

    /// The sample at a time, between two of them on a straight line.
    fn at(&self, t_s: f64) -> f64 {
        let place = t_s * self.fs;
        let k = place.floor();
        let sample = |k: f64| f64::from(self.samples.get(k as usize).copied().unwrap_or(0.0));
        sample(k) + (place - k) * (sample(k + 1.0) - sample(k))
    }

    /// Where in this recording the stretch of `heard` from `t_s` on lies, less `t_s`: by how much
    /// later a thing happens in this recording than in `heard`, s; and the correlation there.
    pub fn offset_of(&self, heard: &Self, t_s: f64, range_s: (f64, f64)) -> (f64, f64) {
        let n = (0.1 * heard.fs) as usize;
        let from = (t_s * heard.fs) as usize;
        let stretch = heard.samples.get(from..from + n).expect("heard so long");
        let of = |offset: f64, every: usize| {
            let (mut xy, mut xx, mut yy) = (0.0, 0.0, 1e-12);
            for (k, x) in stretch.iter().enumerate().step_by(every) {
                let y = self.at((from + k) as f64 / heard.fs + offset);
                xy += f64::from(*x) * y;
                xx += f64::from(*x) * f64::from(*x);
                yy += y * y;
            }
            xy / (xx * yy).sqrt()
        };
        let steps = ((range_s.1 - range_s.0) * self.fs) as usize;
        (0..steps)
            .map(|k| range_s.0 + k as f64 / self.fs)
            .map(|offset| (offset, of(offset, 4)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(offset, _)| (offset, of(offset, 1)))
            .expect("a range")
    }
}
