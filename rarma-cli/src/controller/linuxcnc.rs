//! LinuxCNC, through the component `rarma_override.py` (tools/linuxcnc) that HAL loads.
//!
//! One JSON object a line over a socket. Dead man, limits and rate stand in HAL, on the
//! controller's real-time side: where this program, the socket or the component ends, HAL
//! goes back to the operator's own speed by itself.

use super::Controller;
use crate::failure::Failure;
use crate::port::Port;
use rarma_core::act::{ActOrder, Overrides, Reading};
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

/// Where the component listens, if nobody says so.
pub const USUAL_ADDRESS: &str = "127.0.0.1:9871";
/// The commanded speed and the operator's override come from two parts of LinuxCNC that look at
/// each other every 20 ms: for so long they may not fit, and a turn of the override looks like
/// another programmed speed. Twice what was seen of a busy computer.
const SETTLES: Duration = Duration::from_millis(150);
/// Two programmed speeds this near are one, as a part.
const SAME_SPEED: f64 = 0.005;
/// No line is longer, bytes.
const LONGEST: usize = 4096;

/// What the component says, fifty times a second.
#[derive(Debug, Clone, PartialEq, Deserialize)]
struct Status {
    /// Commanded by LinuxCNC, the operator's override included, 1/min.
    commanded_rpm: f64,
    /// Measured, 1/min.
    actual_rpm: f64,
    /// The operator's own overrides.
    operator: f64,
    operator_feed: f64,
    /// Ours, as HAL has them at this moment.
    factor: f64,
    feed_factor: f64,
    running: bool,
    stopped: bool,
    /// The limits of the factor in HAL.
    range: [f64; 2],
}

/// What is said to it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Say<'a> {
    /// Our factor of the speed, and whether the feed follows it; said again and again.
    Factor { spindle: f64, feed: bool },
    /// Factor 1, at the rate of HAL.
    Leave(bool),
    /// Speeds that are proposed, 1/min, the best first.
    Propose(&'a [f64]),
}

/// The programmed speed, worked out of two numbers that are not of the same moment.
#[derive(Debug, Default)]
struct Program {
    hz: f64,
    /// Another one, and since when it has been seen.
    other: Option<(f64, Instant)>,
}

impl Program {
    /// Takes what commanded speed and override give now; another speed counts once it stays.
    fn take(&mut self, hz: f64, now: Instant) -> f64 {
        let near = |of: f64| (hz - of).abs() <= SAME_SPEED * of;
        if near(self.hz) || self.hz == 0.0 {
            (self.hz, self.other) = (hz, None);
            return self.hz;
        }
        match self.other {
            Some((other, since)) if near(other) => {
                if now - since >= SETTLES {
                    (self.hz, self.other) = (hz, None);
                }
            }
            _ => self.other = Some((hz, now)),
        }
        self.hz
    }
}

/// A LinuxCNC at the other end of a socket.
pub struct LinuxCnc {
    port: Port,
    line: Vec<u8>,
    range: Option<(f64, f64)>,
    last: Option<Reading>,
    program: Program,
    feed_follows: bool,
}

impl LinuxCnc {
    /// Connects to the component at HOST:PORT. Where the feed follows the speed it does so up
    /// to 100 %: LinuxCNC's adaptive feed goes no further.
    ///
    /// # Errors
    /// As [`Port::open`].
    pub fn open(address: &str, feed_follows: bool) -> Result<Self, Failure> {
        let opened = Port::open(&format!("tcp:{address}"), 0);
        let port = opened.map_err(|why| {
            why.kept("the component rarma_override.py of tools/linuxcnc must be loaded there")
        })?;
        Ok(Self {
            port: port.impatient()?,
            line: Vec::new(),
            range: None,
            last: None,
            program: Program::default(),
            feed_follows,
        })
    }

    fn say(&mut self, say: &Say<'_>) -> Result<(), Failure> {
        let mut line = serde_json::to_string(say).map_err(std::io::Error::from)?;
        line.push('\n');
        self.port.send(line.as_bytes())
    }

    fn status(&mut self) -> Result<Option<Status>, Failure> {
        let mut bytes = [0; LONGEST];
        let mut last = None;
        while let Some(n) = self.port.read(&mut bytes)? {
            if n == 0 {
                return Err(self.port.closed());
            }
            for byte in &bytes[..n] {
                if *byte != b'\n' {
                    self.line.push(*byte);
                    if self.line.len() > LONGEST {
                        return Err(not_ours("a line without end"));
                    }
                    continue;
                }
                let status = serde_json::from_slice(&self.line);
                last = Some(status.map_err(|why| not_ours(&why.to_string()))?);
                self.line.clear();
            }
        }
        Ok(last)
    }
}

fn not_ours(what: &str) -> Failure {
    Failure::Input(format!(
        "linuxcnc: status: {what} (see that rarma_override.py of the same version listens there, and nothing else)"
    ))
}

impl Controller for LinuxCnc {
    fn range(&self) -> Option<(f64, f64)> {
        self.range
    }

    fn read(&mut self) -> Result<Option<Reading>, Failure> {
        let Some(s) = self.status()? else {
            return Ok(None);
        };
        self.range = Some((s.range[0], s.range[1]));
        let program = if s.operator > 0.0 {
            s.commanded_rpm.abs() / s.operator
        } else {
            0.0
        };
        let reading = Reading {
            program_hz: self.program.take(program / 60.0, Instant::now()),
            actual_hz: Some(s.actual_rpm.abs() / 60.0),
            overrides: Overrides {
                spindle: s.operator * s.factor,
                feed: s.operator_feed * s.feed_factor,
            },
            operator: Some(s.operator),
            running: s.running,
            stopped: s.stopped,
        };
        self.last = Some(reading);
        Ok(Some(reading))
    }

    fn propose(&mut self, overrides: &[f64]) -> Result<(), Failure> {
        let program_rpm = self.last.map_or(0.0, |r| 60.0 * r.program_hz);
        let rpm: Vec<f64> = overrides.iter().map(|x| x * program_rpm).collect();
        self.say(&Say::Propose(&rpm))
    }

    fn order(&mut self, order: ActOrder) -> Result<(), Failure> {
        match order {
            ActOrder::Set(to) => {
                let operator = self.last.and_then(|r| r.operator).filter(|x| *x > 0.0);
                let factor = to.spindle / operator.unwrap_or(1.0);
                self.say(&Say::Factor {
                    spindle: factor,
                    feed: self.feed_follows,
                })
            }
            ActOrder::GiveBack(_) | ActOrder::Leave => self.say(&Say::Leave(true)),
        }
    }

    fn believe(&mut self, _: f64) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_of_the_override_is_no_other_programmed_speed() {
        let begun = Instant::now();
        let at = |ms: u64| begun + Duration::from_millis(ms);
        let mut program = Program::default();
        assert_eq!(program.take(100.0, at(0)), 100.0);
        // The speed has followed a turn to 105 %, its override is not told yet.
        assert_eq!(program.take(105.0, at(20)), 100.0);
        assert_eq!(program.take(105.0, at(40)), 100.0);
        assert_eq!(program.take(100.0, at(60)), 100.0);
        // Another speed of the program stays, also where the two jump about before.
        assert_eq!(program.take(90.0, at(80)), 100.0);
        assert_eq!(program.take(120.0, at(100)), 100.0);
        assert_eq!(program.take(120.0, at(240)), 100.0);
        assert_eq!(program.take(120.0, at(250)), 120.0);
        // The spindle stops.
        assert_eq!(program.take(0.0, at(300)), 120.0);
        assert_eq!(program.take(0.0, at(450)), 0.0);
        assert_eq!(program.take(80.0, at(470)), 80.0);
    }

    #[test]
    fn lines_are_as_the_component_has_them() {
        let line = br#"{"commanded_rpm": 11000.0, "actual_rpm": 10990.1, "operator": 1.0, "operator_feed": 1.0, "factor": 0.9, "feed_factor": 0.9, "running": true, "stopped": false, "range": [0.8, 1.2]}"#;
        let status: Status = serde_json::from_slice(line).expect("a status");
        assert_eq!((status.factor, status.running), (0.9, true));
        let text = |say: &Say<'_>| serde_json::to_string(say).expect("a line");
        let factor = Say::Factor {
            spindle: 0.9,
            feed: true,
        };
        assert_eq!(text(&factor), r#"{"factor":{"spindle":0.9,"feed":true}}"#);
        assert_eq!(text(&Say::Leave(true)), r#"{"leave":true}"#);
        assert_eq!(text(&Say::Propose(&[9.0])), r#"{"propose":[9.0]}"#);
    }
}
