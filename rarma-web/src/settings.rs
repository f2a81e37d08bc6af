//! What the page asks for, as it writes it.

use rarma_cli::Failure;
use rarma_cli::args::{InputArgs, MonitorArgs, NumbersArgs};
use rarma_cli::commands::About;
use rarma_core::condition::Band;
use rarma_core::monitor::MonitorConfig;
use serde::Deserialize;
use std::path::PathBuf;

/// Lines come this often, s; as those of the command do.
const EVERY_S: f64 = 0.01;
/// Teeth that a cutter may have.
const TEETH: std::ops::RangeInclusive<u32> = 1..=1000;

/// A job as the page writes it, in JSON. Other fields are refused.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// What is listened to, for messages and the report: a file's name, or the microphone's.
    pub name: String,
    /// Sampling rate, Hz.
    pub fs: f64,
    /// Largest value of the converter where it is known; live sound has 1.
    #[serde(default)]
    pub full_scale: Option<f64>,
    /// Spindle speed, 1/min, where it is known.
    #[serde(default)]
    pub rpm: Option<f64>,
    /// Teeth of the cutter, where they are known.
    #[serde(default)]
    pub teeth: Option<u32>,
    /// Band that is analysed, Hz; none: the usual one.
    #[serde(default)]
    pub band: Option<(f64, f64)>,
    /// Orders p and q of the model; none: (8, 7).
    #[serde(default)]
    pub order: Option<(usize, usize)>,
}

impl Settings {
    /// Reads them.
    ///
    /// # Errors
    /// It is no such JSON, which is a defect of the page.
    pub fn read(json: &[u8]) -> Result<Self, Failure> {
        serde_json::from_slice(json)
            .map_err(|why| Failure::System(format!("settings: {why} (reload the page)")))
    }

    /// The options of `rarma monitor` that say the same.
    ///
    /// # Errors
    /// Teeth that no cutter has. All else is checked where it is used.
    pub fn args(&self) -> Result<MonitorArgs, Failure> {
        if let Some(teeth) = self.teeth.filter(|teeth| !TEETH.contains(teeth)) {
            return Err(Failure::Usage(format!(
                "teeth: {teeth} is no number of teeth (write 1 to 1000, or leave it empty)"
            )));
        }
        let usual = MonitorConfig::new(self.fs);
        let band = |(low_hz, high_hz)| Band { low_hz, high_hz };
        Ok(MonitorArgs {
            input: InputArgs {
                input: PathBuf::from(&self.name),
                channel: 0,
                fs: None,
                stream: None,
                raw: None,
            },
            more: Vec::new(),
            order: self.order.unwrap_or((usual.order.p(), usual.order.q())),
            rpm: self.rpm,
            teeth: self.teeth,
            band: self.band.map(band),
            threshold: usual.threshold,
            idle: None,
            second: None,
            tacho: None,
            pulses: 1,
            speed_from: None,
            structure: None,
            aliased: false,
            numbers: NumbersArgs { set: Vec::new() },
            every: EVERY_S,
            json: false,
            screen: None,
            report: None,
            window: None,
            notes: Vec::new(),
        })
    }

    /// What is listened to; `samples`: how many there are, where that is known.
    pub fn about(&self, samples: Option<u64>) -> About {
        About {
            path: PathBuf::from(&self.name),
            fs: self.fs,
            full_scale: self.full_scale,
            samples,
        }
    }

    /// The band in use, Hz.
    pub fn band_hz(&self) -> (f64, f64) {
        let usual = MonitorConfig::new(self.fs).band();
        self.band.unwrap_or((usual.low_hz, usual.high_hz))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_page_writes_is_what_the_command_is_told() {
        let json = br#"{"name":"cut.wav","fs":48000,"rpm":6900,"teeth":3,"band":[300,2500],"order":[4,3]}"#;
        let settings = Settings::read(json).expect("settings");
        let args = settings.args().expect("options");
        assert_eq!(
            (args.rpm, args.teeth, args.order),
            (Some(6900.0), Some(3), (4, 3))
        );
        assert_eq!(
            args.band.map(|b| (b.low_hz, b.high_hz)),
            Some((300.0, 2500.0))
        );
        let usual = Settings::read(br#"{"name":"microphone","fs":48000}"#).expect("settings");
        assert_eq!(usual.args().expect("options").order, (8, 7));
        assert_eq!(usual.band_hz(), (300.0, 2500.0));
    }

    #[test]
    fn what_cannot_be_is_refused_in_words() {
        let odd = Settings::read(br#"{"name":"a","fs":48000,"teeth":0}"#).expect("settings");
        let why = odd.args().expect_err("no teeth").to_string();
        assert!(
            why.contains("teeth: 0") && why.contains("leave it empty"),
            "{why}"
        );
        let unknown = Settings::read(br#"{"name":"a","fs":48000,"speed":1}"#);
        assert!(unknown.is_err_and(|why| why.to_string().contains("speed")));
    }
}
