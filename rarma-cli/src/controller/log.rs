//! What was ordered, and why: as a record for JSON, and in words.

use crate::failure::Failure;
use crate::output::failed;
use rarma_core::act::{Overrides, Said, Why};
use serde::Serialize;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Something that happened between listening and controller.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ActRecord {
    /// Since the listening began, s.
    pub t: f64,
    /// What.
    #[serde(flatten)]
    pub what: What,
}

/// Overrides, percent of what is programmed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Percent {
    /// Of the speed.
    pub spindle: f64,
    /// Of the feed.
    pub feed: f64,
}

/// See [`ActRecord`].
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "act", rename_all = "kebab-case")]
pub enum What {
    /// The run begins.
    Begins {
        /// In words.
        controller: String,
        /// It may order.
        orders: bool,
        /// Of the override, percent.
        limits: [f64; 2],
    },
    /// What comes next is proposed without the machine that is told: it is not worked out for the programmed speed,
    /// yet or at all.
    WithoutMachine,
    /// Speeds are proposed for a chatter.
    Proposed {
        /// Of the chatter, Hz.
        f: f64,
        /// That turns, 1/min.
        rpm: f64,
        /// 1/min, the best first; none: no stable one within the limits.
        speeds: Vec<f64>,
    },
    /// See [`Said::Would`].
    WouldOrder {
        /// In force.
        from: Percent,
        /// What would be ordered.
        to: Percent,
    },
    /// See [`Said::Ordered`].
    Ordered {
        /// In force.
        from: Percent,
        /// What is ordered.
        to: Percent,
    },
    /// See [`Said::Arrived`].
    Arrived {
        /// In force.
        at: Percent,
    },
    /// See [`Said::Quiet`].
    Quiet,
    /// See [`Said::NoSpeed`].
    NoSpeed,
    /// See [`Said::NotBelieved`].
    NotBelieved,
    /// See [`Said::OutOfLimits`].
    OutOfLimits {
        /// The override in force, percent.
        at: f64,
    },
    /// See [`Said::Ends`].
    Ends {
        /// A word for [`Why`].
        why: &'static str,
        /// Of an override that was refused: in force, percent; of a speed that is off: measured
        /// over commanded, percent.
        #[serde(skip_serializing_if = "Option::is_none")]
        got: Option<f64>,
    },
    /// See [`Said::Returned`].
    Returned,
    /// See [`Said::NotReturned`].
    NotReturned {
        /// The override in force, percent, where it is known.
        at: Option<f64>,
    },
    /// The controller cannot be reached any more.
    Gone {
        /// In one line.
        error: String,
    },
}

fn percent(x: f64) -> f64 {
    (1e4 * x).round() / 100.0
}

impl From<Overrides> for Percent {
    fn from(o: Overrides) -> Self {
        Self {
            spindle: percent(o.spindle),
            feed: percent(o.feed),
        }
    }
}

impl From<Said> for What {
    fn from(said: Said) -> Self {
        match said {
            Said::Would(from, to) => Self::WouldOrder {
                from: from.into(),
                to: to.into(),
            },
            Said::Ordered(from, to) => Self::Ordered {
                from: from.into(),
                to: to.into(),
            },
            Said::Arrived(at) => Self::Arrived { at: at.into() },
            Said::Quiet => Self::Quiet,
            Said::NoSpeed => Self::NoSpeed,
            Said::NotBelieved => Self::NotBelieved,
            Said::OutOfLimits(at) => Self::OutOfLimits { at: percent(at) },
            Said::Ends(why) => {
                let (why, got) = match why {
                    Why::Operator => ("operator", None),
                    Why::ProgramEnd => ("program-end", None),
                    Why::NewSpeed => ("new-speed", None),
                    Why::Stopped => ("stopped", None),
                    Why::Link => ("link", None),
                    Why::Deaf => ("deaf", None),
                    Why::Refused(got) => ("refused", Some(percent(got))),
                    Why::Speed(ratio) => ("speed", Some(percent(ratio))),
                    Why::NotStable => ("not-stable", None),
                    Why::Ended => ("ended", None),
                };
                Self::Ends { why, got }
            }
            Said::Returned => Self::Returned,
            Said::NotReturned(at) => Self::NotReturned {
                at: at.is_finite().then(|| percent(at)),
            },
        }
    }
}

/// A record as a person reads it.
pub fn words(record: &ActRecord) -> String {
    let to = |from: &Percent, to: &Percent| {
        format!(
            "the spindle's override from {:.0} to {:.1} %, the feed's from {:.0} to {:.1} %",
            from.spindle, to.spindle, from.feed, to.feed
        )
    };
    let what = match &record.what {
        What::Begins {
            controller,
            orders: true,
            limits: [least, most],
        } => format!("may order an override of {least:.0} to {most:.0} % of {controller}"),
        What::Begins { controller, .. } => {
            format!("only says what it would order; controller: {controller}")
        }
        What::WithoutMachine => {
            "without the machine that is told: it is not worked out for the programmed speed, yet or at all".to_owned()
        }
        What::Proposed { speeds, .. } if speeds.is_empty() => {
            "no stable speed within the limits".to_owned()
        }
        What::Proposed { rpm, speeds, .. } => {
            let list: Vec<String> = speeds.iter().map(|s| format!("{s:.0}")).collect();
            format!("proposed instead of {rpm:.0} 1/min: {}", list.join(", "))
        }
        What::WouldOrder { from, to: end } => format!("would order {}", to(from, end)),
        What::Ordered { from, to: end } => format!("ORDERED {}", to(from, end)),
        What::Arrived { at } => format!("the controller has it: {:.1} %", at.spindle),
        What::Quiet => "the chatter has ended".to_owned(),
        What::NotBelieved => {
            "nothing is ordered: by the machine that is told the cut is stable at this speed, or chatters at another frequency; the call is false, or the file is of another tool, cut or set-up".to_owned()
        }
        What::NoSpeed => "nothing is ordered: less depth of cut helps".to_owned(),
        What::OutOfLimits { at } => format!(
            "nothing is ordered: the override is {at:.0} %, outside the limits, and that is the operator's"
        ),
        What::Ends { why, got } => ends(why, *got),
        What::Returned => "what was before is in force again".to_owned(),
        What::NotReturned { at: Some(at) } => {
            format!("NOT given back: the override is {at:.1} %: set it by hand")
        }
        What::NotReturned { at: None } => {
            "NOT known to be given back: look at the controller, set the override by hand"
                .to_owned()
        }
        What::Gone { error } => format!("{error}; from now on it is only listened"),
    };
    format!("{:8.3} s  {what}", record.t)
}

fn ends(why: &str, got: Option<f64>) -> String {
    let got = got.unwrap_or(f64::NAN);
    let until = "nothing is ordered until the next program";
    match why {
        "operator" => {
            format!("the operator has turned an override: it is left to him, and {until}")
        }
        "program-end" => "the program has ended: given back".to_owned(),
        "new-speed" => "the program asks for another speed: given back".to_owned(),
        "stopped" => format!("the controller has stopped: given back, and {until}"),
        "link" => format!("the controller does not report any more: given back, and {until}"),
        "deaf" => format!("no sound comes any more: given back, and {until}"),
        "refused" => format!("the controller stays at {got:.1} %: given back, and {until}"),
        "speed" => {
            format!("the spindle turns at {got:.1} % of what is commanded: given back, and {until}")
        }
        "not-stable" => {
            format!("it chatters at every speed that was tried: given back, and {until}")
        }
        _ => "the listening ends: given back".to_owned(),
    }
}

/// The file of what was ordered: lines of JSON, added to what is there.
#[derive(Debug)]
pub struct ActLog {
    path: PathBuf,
    file: File,
}

#[derive(Serialize)]
struct Stamped<'a> {
    /// Seconds since 1970.
    utc: f64,
    #[serde(flatten)]
    record: &'a ActRecord,
}

impl ActLog {
    /// Opens it to append; one that is not there is made.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        let file = OpenOptions::new().append(true).create(true).open(path);
        Ok(Self {
            file: file.map_err(|why| failed(path, "open", &why))?,
            path: path.to_path_buf(),
        })
    }

    /// Adds a line; it is with the system before the call returns.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn add(&mut self, record: &ActRecord) -> Result<(), Failure> {
        let since = SystemTime::UNIX_EPOCH.elapsed().unwrap_or_default();
        let utc = (since.as_secs_f64() * 1e3).round() / 1e3;
        let mut line =
            serde_json::to_vec(&Stamped { utc, record }).map_err(std::io::Error::from)?;
        line.push(b'\n');
        let written = self.file.write_all(&line);
        Ok(written.map_err(|why| failed(&self.path, "write", &why))?)
    }
}
