//! Grbl 1.1 and grblHAL over a serial port or a socket: override bytes and status reports.
//!
//! An override byte changes by one percent and is executed within some tens of milliseconds; of
//! two that come at once one may be lost. So one byte a lever is sent, then a report is asked
//! for, and only the report says where the override is. That makes some 16 % a second.
//!
//! What Grbl does not have: a dead man. A cable that is pulled leaves the override as it is
//! until the program ends, or a person sets it back.

use super::Controller;
use crate::failure::Failure;
use crate::port::Port;
use rarma_core::act::{ActOrder, Overrides, Reading};
use std::time::{Duration, Instant};

/// Bytes of the protocol: one percent more and less of the speed, and of the feed.
const SPINDLE: [u8; 2] = [0x9C, 0x9D];
/// See [`SPINDLE`].
const FEED: [u8; 2] = [0x93, 0x94];
/// Overrides that Grbl takes.
const RANGE: (f64, f64) = (0.1, 2.0);
/// A byte, the report that shows it and the next byte take 50 to 60 ms: 16 % a second at least.
const FASTEST_PER_S: f64 = 0.15;
/// A report is asked for so often while nothing changes: ten a second is what Grbl's own pages
/// advise at most.
const ASK: Duration = Duration::from_millis(100);
/// After a byte a report is asked for so much later, so that it shows what the byte did.
const AFTER_A_BYTE: Duration = Duration::from_millis(25);
/// An unanswered question is asked again.
const AGAIN: Duration = Duration::from_millis(300);
/// A program that is sent line by line runs dry now and then; after so long it has ended.
const IDLE: Duration = Duration::from_secs(1);
/// No report is longer, bytes.
const LONGEST: usize = 512;

/// A Grbl at the other end of a port.
pub struct Grbl {
    port: Port,
    line: Vec<u8>,
    /// Percent, as last reported: feed, speed.
    overrides: Option<(i32, i32)>,
    /// Speed of the program, turns a second, while no order of ours stands.
    program_hz: f64,
    orders: bool,
    asked: Option<Instant>,
    /// The last question has not been answered.
    waits: bool,
    sent: Option<Instant>,
    /// Percent that the last bytes lead to: feed, speed.
    expected: Option<(i32, i32)>,
    /// Reports that were asked for since.
    reports: u32,
    /// They have shown what the bytes did.
    shown: bool,
    ran: Option<Instant>,
    /// The sender has no speed in its reports; said once.
    mute: bool,
}

/// What a status report says, as far as it matters.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// `Run`, `Idle`, `Hold:0`, ….
    pub state: String,
    /// Speed as commanded, overrides included, 1/min.
    pub rpm: Option<f64>,
    /// Speed as measured, 1/min; of grblHAL with an encoder.
    pub measured_rpm: Option<f64>,
    /// Percent: feed, speed. Not in every report.
    pub overrides: Option<(i32, i32)>,
}

/// Reads a status report; nothing if the line is none.
pub fn report(line: &str) -> Option<Report> {
    let mut fields = line.trim().strip_prefix('<')?.strip_suffix('>')?.split('|');
    let mut out = Report {
        state: fields.next()?.to_owned(),
        rpm: None,
        measured_rpm: None,
        overrides: None,
    };
    for field in fields {
        let (name, values) = field.split_once(':')?;
        let mut values = values.split(',');
        match name {
            "FS" => {
                let mut speeds = values.skip(1).map(|x| x.parse::<f64>().ok());
                out.rpm = speeds.next()?.filter(|x| x.is_finite() && *x >= 0.0);
                out.measured_rpm = speeds.next().flatten();
            }
            "Ov" => {
                let feed = values.next()?.parse().ok()?;
                out.overrides = Some((feed, values.nth(1)?.parse().ok()?));
            }
            _ => {}
        }
    }
    Some(out)
}

impl Grbl {
    /// Opens a serial port, or `tcp:HOST:PORT`.
    ///
    /// # Errors
    /// As [`Port::open`].
    pub fn open(name: &str, baud: u32) -> Result<Self, Failure> {
        let port = Port::open(name, baud)?;
        if !port.answers() {
            return Err(Failure::Usage(format!(
                "--controller grbl:{name}: it is neither a serial port nor tcp:HOST:PORT"
            )));
        }
        Ok(Self {
            port: port.impatient()?,
            line: Vec::new(),
            overrides: None,
            program_hz: 0.0,
            orders: false,
            asked: None,
            waits: false,
            sent: None,
            expected: None,
            reports: 0,
            shown: false,
            ran: None,
            mute: false,
        })
    }

    /// What has come; the last whole report in it.
    fn heard(&mut self) -> Result<Option<Report>, Failure> {
        let mut bytes = [0; LONGEST];
        let mut last = None;
        while let Some(n) = self.port.read(&mut bytes)? {
            if n == 0 {
                return Err(self.port.closed());
            }
            for byte in &bytes[..n] {
                if *byte == b'\n' {
                    let text = String::from_utf8_lossy(&self.line);
                    last = report(&text).or(last);
                    self.line.clear();
                } else if self.line.len() < LONGEST {
                    self.line.push(*byte);
                }
            }
        }
        Ok(last)
    }

    fn ask(&mut self, now: Instant) -> Result<(), Failure> {
        let since = |then: Option<Instant>| then.map_or(Duration::MAX, |then| now - then);
        let due = match (self.waits, self.shown) {
            (true, _) => AGAIN,
            (false, true) => ASK,
            (false, false) => AFTER_A_BYTE,
        };
        if since(self.sent) >= AFTER_A_BYTE && since(self.asked) >= due {
            self.port.send(b"?")?;
            self.asked = Some(now);
            self.waits = true;
        }
        Ok(())
    }

    /// One step toward these percents, if a report has shown what the last one did.
    fn step(&mut self, to: Overrides) -> Result<(), Failure> {
        let Some((feed, spindle)) = self.overrides.filter(|_| self.shown) else {
            return Ok(());
        };
        let mut bytes = Vec::new();
        let mut step = |[more, less]: [u8; 2], now: i32, to: f64| {
            let to = (100.0 * to.clamp(RANGE.0, RANGE.1)).round() as i32;
            let step = (to - now).signum();
            match step {
                1 => bytes.push(more),
                -1 => bytes.push(less),
                _ => {}
            }
            now + step
        };
        let spindle = step(SPINDLE, spindle, to.spindle);
        let feed = step(FEED, feed, to.feed);
        if !bytes.is_empty() {
            self.port.send(&bytes)?;
            self.sent = Some(Instant::now());
            self.expected = Some((feed, spindle));
            (self.reports, self.shown) = (0, false);
        }
        Ok(())
    }
}

impl Controller for Grbl {
    fn range(&self) -> Option<(f64, f64)> {
        Some(RANGE)
    }

    fn fastest_per_s(&self) -> Option<f64> {
        Some(FASTEST_PER_S)
    }

    fn read(&mut self) -> Result<Option<Reading>, Failure> {
        let now = Instant::now();
        let heard = self.heard()?;
        // A report that was asked for before the last byte does not show what it did; one after
        // it may still have been made before the byte was looked at, the next one cannot.
        let after = self
            .sent
            .is_none_or(|sent| self.asked.is_some_and(|asked| asked > sent));
        if let Some(report) = &heard {
            self.overrides = report.overrides.or(self.overrides);
            self.waits = false;
            self.reports += u32::from(after);
            let as_expected = after && self.overrides == self.expected;
            self.shown |= as_expected || self.reports >= 2;
        }
        self.ask(now)?;
        let Some(report) = heard else {
            return Ok(None);
        };
        let Some((feed, spindle)) = self.overrides else {
            return Ok(None);
        };
        let Some(rpm) = report.rpm else {
            if !std::mem::replace(&mut self.mute, true) {
                eprintln!(
                    "Warning: this Grbl reports no spindle speed (FS:), so nothing can be advised or ordered: build it with a variable spindle"
                );
            }
            return Ok(None);
        };
        let overrides = Overrides {
            spindle: f64::from(spindle) / 100.0,
            feed: f64::from(feed) / 100.0,
        };
        // What the program asks for is not reported. While an order stands it stays what it
        // was: a speed that does not follow is then seen to differ.
        if !self.orders && spindle > 0 {
            self.program_hz = rpm / 60.0 / overrides.spindle;
        }
        let state = report.state.split(':').next().unwrap_or_default();
        if matches!(state, "Run" | "Hold" | "Door") {
            self.ran = Some(now);
        }
        Ok(Some(Reading {
            program_hz: self.program_hz,
            actual_hz: Some(report.measured_rpm.unwrap_or(rpm) / 60.0),
            overrides,
            operator: None,
            running: self.ran.is_some_and(|ran| now - ran < IDLE),
            stopped: matches!(state, "Alarm" | "Door" | "Sleep"),
        }))
    }

    fn propose(&mut self, _: &[f64]) -> Result<(), Failure> {
        Ok(())
    }

    fn order(&mut self, order: ActOrder) -> Result<(), Failure> {
        self.orders = matches!(order, ActOrder::Set(_));
        match order {
            ActOrder::Set(to) | ActOrder::GiveBack(to) => self.step(to),
            ActOrder::Leave => Ok(()),
        }
    }

    fn believe(&mut self, _: f64) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_of_grbl_and_grblhal_are_read() {
        let run = report("<Run|MPos:1.000,0.000,-1.000|FS:900,11000|Ov:100,100,92|A:SF>\r");
        let run = run.expect("a report");
        assert_eq!((run.state.as_str(), run.rpm), ("Run", Some(11_000.0)));
        assert_eq!(run.overrides, Some((100, 92)));
        let hal = report("<Hold:0|WPos:0.000,0.000,0.000|Bf:35,1024|FS:0,8000,7950>");
        let hal = hal.expect("a report");
        assert_eq!((hal.measured_rpm, hal.overrides), (Some(7950.0), None));
        let no_speed = report("<Idle|MPos:0.000,0.000,0.000|F:0>").expect("a report");
        assert_eq!(no_speed.rpm, None);
        for none in [
            "ok",
            "[MSG:Reset to continue]",
            "<Run|FS:1",
            "<Run|Ov:1,2>",
            "<|Ov>",
            "Grbl 1.1h",
        ] {
            assert_eq!(report(none), None, "{none}");
        }
    }
}
