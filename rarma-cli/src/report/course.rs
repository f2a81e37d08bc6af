//! What a monitor said over a run, as the pictures and tables of its page need it, in
//! memory that does not grow.

use super::moment::{Moment, Moments};
use crate::collect::News;
use crate::record::{
    Alarm, Amplitude, AmplitudeRecord, HistogramRecord, Line, Reason, SpeedSource, State,
};
use std::collections::BTreeMap;

/// A mode within this part of a frequency is the one there.
const SAME: f64 = 0.05;

/// Alarms of which the page says more than that they were; the table ends there.
pub(super) const ROWS: usize = 500;
/// Frequencies of readings that are kept apart: a hundredth of their size.
const PER_E: f64 = 100.0;
/// What the amplitude may have said at how many frequencies during one alarm.
const MOST_VOTES: usize = 256;

/// What the page says of one alarm beside its record.
#[derive(Debug, Clone, Default)]
pub(super) struct Noted {
    /// Speed of the line nearest to its call, 1/min.
    pub(super) rpm: Option<f64>,
    /// What the amplitude said for most of it.
    pub(super) said: Option<Amplitude>,
}

/// An alarm that stands, or has just been released.
#[derive(Debug, Clone)]
struct Open {
    row: usize,
    on: f64,
    off: Option<f64>,
    f: f64,
    votes: Vec<(i32, f64, Amplitude, u32)>,
}

/// A histogram that may be shown, and what the amplitude said next to it.
#[derive(Debug, Clone)]
pub(super) struct Shown {
    pub(super) histogram: HistogramRecord,
    pub(super) reading: Option<AmplitudeRecord>,
    /// From the histogram to the reading, s.
    away: f64,
    /// A later reading is not wanted any more.
    settled: bool,
}

/// A run as it goes.
#[derive(Debug, Clone, Default)]
pub struct Course {
    /// Stretch of time that is drawn, s.
    within: Option<(f64, f64)>,
    moments: Moments,
    /// Lines that are drawn.
    lines: u64,
    /// The last line: when, what and why.
    last: Option<(f64, State, Reason)>,
    spent: Vec<(State, Reason, f64)>,
    end_s: f64,
    pub(super) highest_hz: f64,
    pub(super) first_hz: Option<f64>,
    pub(super) strongest: Option<f64>,
    pub(super) by_tacho: bool,
    noted: Vec<Noted>,
    alarms: usize,
    /// The last line whose speed was known, and rows that wait for the next one.
    speed: Option<(f64, f64)>,
    waiting: Vec<(usize, f64)>,
    standing: Vec<Open>,
    /// The last reading at each frequency.
    readings: BTreeMap<i32, (f64, AmplitudeRecord)>,
    newest: Option<Shown>,
    first_on: Option<(f64, Option<f64>)>,
    /// Of the first alarm, the last one at each frequency, and the last that fits.
    of_first: BTreeMap<i32, (Shown, Option<Shown>)>,
}

fn bin(f: f64) -> i32 {
    (f.max(1e-9).ln() * PER_E).floor() as i32
}

/// Whether two frequencies are those of one mode, the second being the known one.
fn same(f: f64, known: f64) -> bool {
    (f - known).abs() <= SAME * known
}

/// A line holds until the next one speaks.
fn spend(spent: &mut Vec<(State, Reason, f64)>, state: State, reason: Reason, passed: f64) {
    if !(passed > 0.0 && passed.is_finite()) {
        return;
    }
    match spent.iter_mut().find(|s| s.0 == state && s.1 == reason) {
        Some(row) => row.2 += passed,
        None => spent.push((state, reason, passed)),
    }
}

impl Course {
    /// Draws what lies between two instants, s, and nothing else; what is told in words is of
    /// all of the run.
    pub fn within(self, window_s: (f64, f64)) -> Self {
        Self {
            within: Some(window_s),
            ..self
        }
    }

    /// Takes what was said.
    pub fn take(&mut self, news: &News) {
        match news {
            News::None | News::Notice(_) => {}
            News::Line(line) => self.line(line),
            News::On(alarm) => self.on(alarm),
            News::Off(alarm) => self.off(alarm),
            News::Histogram(histogram) => self.histogram(histogram),
        }
    }

    fn line(&mut self, line: &Line) {
        for mode in &line.modes {
            if mode.f.is_finite() {
                self.highest_hz = self.highest_hz.max(mode.f);
                if mode.f > 0.0 {
                    self.first_hz.get_or_insert(mode.f);
                }
            }
            if mode.amplitude.is_finite() {
                let most = self.strongest.unwrap_or(mode.amplitude);
                self.strongest = Some(most.max(mode.amplitude));
            }
        }
        self.by_tacho |= line.spindle.source == SpeedSource::Tacho;
        if let Some((t, state, reason)) = self.last {
            spend(&mut self.spent, state, reason, line.t - t);
        }
        self.last = Some((line.t, line.state, line.reason));
        if !line.t.is_finite() {
            return;
        }
        self.end_s = self.end_s.max(line.t);
        if let Some(rpm) = line.spindle.rpm {
            self.speed_at(line.t, rpm);
        }
        self.reading(line.t, line.amplitude);
        if self
            .within
            .is_none_or(|(from, to)| (from..to).contains(&line.t))
        {
            self.lines += 1;
            self.moments.push(Moment::of(line));
        }
    }

    fn speed_at(&mut self, t: f64, rpm: f64) {
        let before = self.speed;
        for (row, on) in self.waiting.drain(..) {
            let nearer = before.filter(|(at, _)| (on - at).abs() <= (t - on).abs());
            self.noted[row].rpm = Some(nearer.map_or(rpm, |(_, rpm)| rpm));
        }
        self.speed = Some((t, rpm));
    }

    fn reading(&mut self, t: f64, reading: Option<AmplitudeRecord>) {
        let noted = &mut self.noted;
        self.standing.retain(|open| {
            let over = open.off.is_some_and(|off| t > off);
            if over {
                noted[open.row].said = open.verdict();
            }
            !over
        });
        let Some(reading) = reading else {
            return;
        };
        for open in &mut self.standing {
            open.vote(t, &reading);
        }
        self.readings.insert(bin(reading.f), (t, reading));
        let of_first = self.of_first.values_mut();
        let shown = of_first.flat_map(|(last, inside)| [Some(last), inside.as_mut()]);
        for shown in shown.chain([self.newest.as_mut()]).flatten() {
            shown.after(t, &reading);
        }
    }

    fn on(&mut self, alarm: &Alarm) {
        if !alarm.on.is_finite() {
            return;
        }
        self.end_s = self.end_s.max(alarm.on);
        if self.alarms == 0 {
            self.first_on = Some((alarm.on, None));
            if let Some(newest) = self.newest.clone().filter(|s| s.histogram.t >= alarm.on) {
                self.keep_of_first(newest);
            }
        }
        self.alarms += 1;
        if self.noted.len() == ROWS {
            return;
        }
        let row = self.noted.len();
        self.noted.push(Noted {
            rpm: self.speed.map(|(_, rpm)| rpm),
            said: None,
        });
        self.waiting.push((row, alarm.on));
        let mut open = Open {
            row,
            on: alarm.on,
            off: None,
            f: alarm.f,
            votes: Vec::new(),
        };
        // The line of that very sample may have come before.
        for (t, reading) in self.readings.values() {
            open.vote(*t, reading);
        }
        self.standing.push(open);
    }

    fn off(&mut self, alarm: &Alarm) {
        if let Some((_, off @ None)) = &mut self.first_on {
            *off = alarm.off;
        }
        if let Some(at) = alarm.off.filter(|t| t.is_finite()) {
            self.end_s = self.end_s.max(at);
        }
        if let Some(open) = self.standing.iter_mut().find(|o| o.off.is_none()) {
            (open.off, open.f) = (alarm.off, alarm.f);
        }
    }

    fn histogram(&mut self, histogram: &HistogramRecord) {
        let drawable = histogram.counts.bin_width.is_finite()
            && histogram.counts.bin_width > 0.0
            && histogram.counts.total() > 0;
        if !drawable {
            return;
        }
        let near = self.readings.values().filter(|r| same(r.1.f, histogram.f));
        let before = near.max_by(|a, b| a.0.total_cmp(&b.0));
        let shown = Shown {
            reading: before.map(|(_, reading)| *reading),
            away: before.map_or(f64::INFINITY, |(t, _)| (histogram.t - t).abs()),
            histogram: histogram.clone(),
            settled: false,
        };
        let during = self
            .first_on
            .is_some_and(|(on, off)| histogram.t >= on && off.is_none_or(|off| histogram.t <= off));
        if during {
            self.keep_of_first(shown.clone());
        }
        self.newest = Some(shown);
    }

    fn keep_of_first(&mut self, shown: Shown) {
        let counts = &shown.histogram.counts;
        let inside = u32::from(counts.beyond) * 10 <= counts.total();
        let key = bin(shown.histogram.f);
        let before = self.of_first.remove(&key).and_then(|(_, inside)| inside);
        let fits = if inside { Some(shown.clone()) } else { before };
        self.of_first.insert(key, (shown, fits));
    }

    /// Lines that are drawn.
    pub(super) fn lines(&self) -> u64 {
        self.lines
    }

    /// The lines, thinned.
    pub(super) fn moments(&self) -> impl Iterator<Item = &Moment> {
        self.moments.iter()
    }

    /// Time of the last thing that was said, s.
    pub(super) fn end_s(&self) -> f64 {
        self.end_s
    }

    /// What is noted of an alarm, the first ones only; the run ends at `end_s`.
    pub(super) fn noted(&self, row: usize, alarm: &Alarm) -> Option<Noted> {
        let mut noted = self.noted.get(row)?.clone();
        if let Some(open) = self.standing.iter().find(|open| open.row == row) {
            // The frequency of the record is the last one known.
            noted.said = Open {
                f: alarm.f,
                ..open.clone()
            }
            .verdict();
        }
        Some(noted)
    }

    /// How long the state was what it was for which reason, the longest first.
    pub(super) fn spent(&self, end_s: f64) -> Vec<(State, Reason, f64)> {
        let mut spent = self.spent.clone();
        if let Some((t, state, reason)) = self.last {
            spend(&mut spent, state, reason, end_s - t);
        }
        spent.sort_by(|a, b| b.2.total_cmp(&a.2));
        spent
    }

    /// The histogram to be shown: the last one of the first alarm, whose frequency is
    /// `f`, if there is one of which at most a tenth lies beyond the bins, such a one;
    /// else the last one of all.
    pub(super) fn shown(&self, f: Option<f64>) -> Option<&Shown> {
        let there = |s: &&Shown| f.is_some_and(|f| same(s.histogram.f, f));
        let latest = |a: &&Shown, b: &&Shown| a.histogram.t.total_cmp(&b.histogram.t);
        let inside = self.of_first.values().filter_map(|(_, s)| s.as_ref());
        let any = self.of_first.values().map(|(s, _)| s);
        inside
            .filter(there)
            .max_by(latest)
            .or_else(|| any.filter(there).max_by(latest))
            .or(self.newest.as_ref())
    }
}

impl Open {
    fn vote(&mut self, t: f64, reading: &AmplitudeRecord) {
        let inside = t >= self.on && self.off.is_none_or(|off| t <= off);
        if !inside || reading.verdict == Amplitude::TooShort {
            return;
        }
        let key = (reading.f.max(1e-9).ln() * 10.0 * PER_E).round() as i32;
        let like = |v: &&mut (i32, f64, Amplitude, u32)| v.0 == key && v.2 == reading.verdict;
        let room = self.votes.len() < MOST_VOTES;
        match self.votes.iter_mut().find(like) {
            Some(vote) => vote.3 = vote.3.saturating_add(1),
            None if room => {
                self.votes.push((key, reading.f, reading.verdict, 1));
            }
            None => {}
        }
    }

    /// What was said most often at the alarm's frequency.
    fn verdict(&self) -> Option<Amplitude> {
        let mut sums: Vec<(Amplitude, u64)> = Vec::new();
        for (_, f, verdict, n) in &self.votes {
            if !same(*f, self.f) {
                continue;
            }
            match sums.iter_mut().find(|(v, _)| v == verdict) {
                Some((_, sum)) => *sum += u64::from(*n),
                None => sums.push((*verdict, u64::from(*n))),
            }
        }
        sums.into_iter().max_by_key(|(_, n)| *n).map(|(v, _)| v)
    }
}

impl Shown {
    /// A reading that came later: the nearest one counts.
    fn after(&mut self, t: f64, reading: &AmplitudeRecord) {
        if self.settled || !same(reading.f, self.histogram.f) {
            return;
        }
        self.settled = true;
        let away = (t - self.histogram.t).abs();
        if away < self.away {
            (self.reading, self.away) = (Some(*reading), away);
        }
    }
}

#[cfg(test)]
#[path = "course_tests.rs"]
mod tests;
