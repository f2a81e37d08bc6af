//! LinuxCNC, through the component `rarma_override.py` (tools/linuxcnc) that HAL loads.
//!
//! One JSON object a line over a socket. Dead man, limits and rate stand in HAL, on the
//! controller's real-time side: where this program, the socket or the component ends, HAL
//! goes back to the operator's own speed by itself.

use super::Controller;
use crate::failure::Failure;
use crate::port::Port;
use rarma_core::act::{Order, Overrides, Reading};
use serde::{Deserialize, Serialize};

/// Where the component listens, if nobody says so.
pub const USUAL_ADDRESS: &str = "127.0.0.1:9871";
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

/// A LinuxCNC at the other end of a socket.
pub struct LinuxCnc {
    port: Port,
    line: Vec<u8>,
    range: Option<(f64, f64)>,
    last: Option<Reading>,
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
            program_hz: program / 60.0,
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

    fn order(&mut self, order: Order) -> Result<(), Failure> {
        match order {
            Order::Set(to) => {
                let operator = self.last.and_then(|r| r.operator).filter(|x| *x > 0.0);
                let factor = to.spindle / operator.unwrap_or(1.0);
                self.say(&Say::Factor {
                    spindle: factor,
                    feed: self.feed_follows,
                })
            }
            Order::GiveBack(_) | Order::Leave => self.say(&Say::Leave(true)),
        }
    }

    fn believe(&mut self, _: f64) {}
}
