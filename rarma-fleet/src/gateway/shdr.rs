//! SHDR, the text that agents of MTConnect read from an adapter: one line a change,
//! `time|key|value`; `* PING` is answered with `* PONG`.
//!
//! ```text
//! 2026-03-01T12:00:00.000000Z|box-07_state|CHATTER
//! 2026-03-01T12:00:00.000000Z|box-07_chatter|FAULT|chatter|||976.4 Hz, damping -0.3 %
//! ```

use super::boxes::Shared;
use super::metrics::OfBox;
use super::notices::Notices;
use super::value::Value;
use crate::record::{Name, Utc};
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How often changes are looked for.
const EVERY: Duration = Duration::from_millis(100);
/// An agent hears something at least this often, ms: what `* PONG` says.
const HEARTBEAT_MS: u32 = 10_000;
/// Agents at a time.
const MOST_AGENTS: usize = 8;
/// Longest line of an agent, bytes.
const LONGEST: usize = 256;

/// The items of a box as they are told: key and what follows it.
pub fn items(name: &Name, live: &super::metrics::Live) -> Vec<(String, String)> {
    let key = |item: &str| format!("{name}_{item}").replace([' ', '|'], "-");
    let gone = || "UNAVAILABLE".to_owned();
    let text = |metric| match live.get(metric) {
        Some(Value::Text(text)) if live.here => plain(text).to_uppercase(),
        _ => gone(),
    };
    let number = |metric, digits: usize| match live.get(metric) {
        Some(Value::Number(x)) if live.here => format!("{x:.digits$}"),
        _ => gone(),
    };
    let available = if live.here {
        "AVAILABLE"
    } else {
        "UNAVAILABLE"
    };
    vec![
        (key("avail"), available.to_owned()),
        (key("state"), text(OfBox::State)),
        (key("reason"), text(OfBox::Reason)),
        (key("speed"), number(OfBox::Speed, 1)),
        (key("frequency"), number(OfBox::ModeFrequency, 1)),
        (key("damping"), number(OfBox::ModeDamping, 5)),
        (key("chatter"), condition(live)),
    ]
}

/// `level|native code|native severity|qualifier|text`.
fn condition(live: &super::metrics::Live) -> String {
    let state = match live.get(OfBox::State) {
        Some(Value::Text(state)) if live.here => state.as_str(),
        _ => "",
    };
    let number = |metric| match live.get(metric) {
        Some(Value::Number(x)) => *x,
        _ => 0.0,
    };
    let (level, f_hz, zeta) = match state {
        "chatter" => ("FAULT", OfBox::AlarmFrequency, OfBox::AlarmDamping),
        "warning" => ("WARNING", OfBox::ModeFrequency, OfBox::ModeDamping),
        "idle" | "stable" | "starting" => return "NORMAL||||".to_owned(),
        _ => return "UNAVAILABLE||||".to_owned(),
    };
    format!(
        "{level}|{state}|||{:.1} Hz, damping {:.1} %",
        number(f_hz),
        100.0 * number(zeta)
    )
}

/// A text without what parts lines and fields.
fn plain(text: &str) -> String {
    text.chars()
        .map(|c| if c == '|' || c.is_control() { ' ' } else { c })
        .collect()
}

struct Agent {
    socket: TcpStream,
    line: Vec<u8>,
    last: Instant,
}

/// The place where agents come in.
pub(super) struct Server {
    listener: TcpListener,
    agents: Vec<Agent>,
    told: Vec<Vec<(String, String)>>,
}

impl Server {
    pub fn open(address: &str) -> Result<Self, String> {
        let opened = TcpListener::bind(address).and_then(|listener| {
            listener.set_nonblocking(true)?;
            Ok(listener)
        });
        let listener = opened
            .map_err(|why| format!("shdr: {address}: {} (another address or port)", why.kind()))?;
        Ok(Self {
            listener,
            agents: Vec::new(),
            told: Vec::new(),
        })
    }

    /// Until it is told to stop.
    pub fn run(mut self, boxes: &[(Name, Arc<Shared>)], notices: &Notices, stop: &AtomicBool) {
        while !stop.load(Ordering::Relaxed) {
            let now: Vec<_> = boxes
                .iter()
                .map(|(name, shared)| items(name, &shared.live()))
                .collect();
            let time = Utc::now().map_or_else(|why| why.to_string(), |t| t.to_string());
            let lines = |of: &mut dyn FnMut(usize, usize) -> bool| {
                let mut text = String::new();
                for (b, items) in now.iter().enumerate() {
                    for (k, (key, value)) in items.iter().enumerate() {
                        if of(b, k) {
                            text.push_str(&format!("{time}|{key}|{value}\n"));
                        }
                    }
                }
                text
            };
            let changed =
                lines(&mut |b, k| self.told.get(b).is_none_or(|before| before[k] != now[b][k]));
            self.agents.retain_mut(|agent| agent.serve(&changed));
            let all = lines(&mut |_, _| true);
            while let Ok((socket, from)) = self.listener.accept() {
                if self.agents.len() >= MOST_AGENTS {
                    notices.say(format!(
                        "shdr: an agent at {from} is one too many and is let go"
                    ));
                    continue;
                }
                let mut agent = Agent {
                    socket,
                    line: Vec::new(),
                    last: Instant::now(),
                };
                if agent.socket.set_nonblocking(true).is_ok() && agent.say(&all) {
                    self.agents.push(agent);
                }
            }
            self.told = now;
            std::thread::sleep(EVERY);
        }
    }

    /// Where agents come in.
    pub fn address(&self) -> std::io::Result<std::net::SocketAddr> {
        self.listener.local_addr()
    }
}

impl Agent {
    /// An agent that does not read is let go.
    fn say(&mut self, text: &str) -> bool {
        if !text.is_empty() {
            self.last = Instant::now();
        }
        self.socket.write_all(text.as_bytes()).is_ok()
    }

    fn serve(&mut self, changed: &str) -> bool {
        let mut bytes = [0; LONGEST];
        loop {
            match self.socket.read(&mut bytes) {
                Ok(0) => return false,
                Ok(n) => {
                    for &byte in &bytes[..n] {
                        if byte == b'\n' {
                            let asked = self.line.trim_ascii() == b"* PING";
                            self.line.clear();
                            if asked && !self.say(&format!("* PONG {HEARTBEAT_MS}\n")) {
                                return false;
                            }
                        } else if self.line.len() < LONGEST {
                            self.line.push(byte);
                        }
                    }
                }
                Err(why) if why.kind() == ErrorKind::WouldBlock => break,
                Err(_) => return false,
            }
        }
        changed.is_empty() || self.say(changed)
    }
}

#[cfg(test)]
mod tests {
    use super::super::metrics::Live;
    use super::*;

    fn of(state: &str) -> Vec<(String, String)> {
        let mut live = Live::default();
        live.here = true;
        live.set(OfBox::State, Some(Value::Text(state.to_owned())));
        live.set(OfBox::AlarmFrequency, Some(Value::Number(976.4)));
        live.set(OfBox::AlarmDamping, Some(Value::Number(-0.003)));
        items(&Name::new("box 7").unwrap(), &live)
    }

    #[test]
    fn states_are_conditions() {
        let chatter = |state| of(state).pop().unwrap();
        assert_eq!(
            chatter("chatter"),
            (
                "box-7_chatter".into(),
                "FAULT|chatter|||976.4 Hz, damping -0.3 %".into()
            )
        );
        assert_eq!(chatter("stable").1, "NORMAL||||");
        assert_eq!(chatter("invalid").1, "UNAVAILABLE||||");
        assert!(chatter("warning").1.starts_with("WARNING|warning|||"));
        // A line of a condition has seven fields, and text cannot add one.
        assert_eq!(chatter("chatter").1.matches('|').count(), 4);
        assert_eq!(of("a|b\nc")[1].1, "A B C");
    }

    #[test]
    fn a_box_that_is_not_heard_is_unavailable() {
        let items = items(&Name::new("b").unwrap(), &Live::default());
        assert!(
            items
                .iter()
                .all(|(_, value)| value.starts_with("UNAVAILABLE"))
        );
    }
}
