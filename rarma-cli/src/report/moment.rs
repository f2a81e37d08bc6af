//! Lines of a run as its pictures draw them: kept one by one as long as there are few, then
//! in stretches of two, four, …

use super::sound::halve;
use crate::record::{Label, Line, ModeRecord, State};

/// Moments at most; half as many at least. A picture is 840 pixels wide.
const MOMENTS: usize = 8192;
/// Modes of each label of a moment beside those of its line, at most.
const MORE: usize = 8;
/// Labels there are.
const LABELS: usize = 3;

/// One or several lines in a row.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Moment {
    /// Time of the first, s.
    pub(super) t: f64,
    /// The states among them, a bit for each.
    states: u8,
    /// How many lines.
    pub(super) lines: u32,
    /// Speed, 1/min, where one is known.
    pub(super) rpm: Option<f64>,
    /// Modes of one of the lines.
    modes: Vec<Seen>,
    /// Some of the others'.
    more: Vec<Mark>,
}

/// A mode, as far as it is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Seen {
    pub(super) t: f64,
    pub(super) f: f64,
    pub(super) zeta: f64,
    pub(super) zeta_sd: f64,
    pub(super) label: Label,
    /// Modes that lie here in a picture of damping.
    pub(super) n: u32,
    cells: Cells,
}

/// A mode that is a mark in the pictures and nothing else; time since its moment's.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Mark {
    t: f32,
    f: f32,
    zeta: f32,
    label: Label,
    n: u32,
    cells: Cells,
}

/// Places of damping and frequency on a grid that is as fine as that of the pictures.
type Cells = (i16, i16);

fn cells(zeta: f64, f: f64) -> Cells {
    let fine = |x: f64, per_e: f64| (x.max(1e-6).ln() * per_e).round() as i16;
    (fine(zeta, 9.0), fine(f, 60.0))
}

impl Moment {
    /// Of one line.
    pub(super) fn of(line: &Line) -> Self {
        let seen = |m: &ModeRecord| Seen {
            t: line.t,
            f: m.f,
            zeta: m.zeta,
            zeta_sd: m.zeta_sd,
            label: m.label,
            n: 1,
            cells: cells(m.zeta, m.f),
        };
        Self {
            t: line.t,
            states: 1 << line.state as u8,
            lines: 1,
            rpm: line.spindle.rpm,
            modes: line.modes.iter().map(seen).collect(),
            more: Vec::new(),
        }
    }

    /// Whether it was in a state.
    pub(super) fn has(&self, state: State) -> bool {
        self.states & (1 << state as u8) != 0
    }

    /// Modes of one of its lines.
    pub(super) fn modes(&self) -> &[Seen] {
        &self.modes
    }

    /// Modes of all its lines, those left out that would lie on others in a picture.
    pub(super) fn all_modes(&self) -> impl Iterator<Item = Seen> {
        let more = self.more.iter().map(|m| Seen {
            t: self.t + f64::from(m.t),
            f: f64::from(m.f),
            zeta: f64::from(m.zeta),
            zeta_sd: f64::NAN,
            label: m.label,
            n: m.n,
            cells: m.cells,
        });
        self.modes.iter().copied().chain(more)
    }

    /// Takes in the moment that follows.
    fn join(&mut self, mut next: Self) {
        self.states |= next.states;
        self.lines = self.lines.saturating_add(next.lines);
        self.rpm = self.rpm.or(next.rpm);
        if self.modes.is_empty() {
            core::mem::swap(&mut self.modes, &mut next.modes);
        }
        let later = (next.t - self.t) as f32;
        for seen in &next.modes {
            self.add(Mark {
                t: (seen.t - self.t) as f32,
                f: seen.f as f32,
                zeta: seen.zeta as f32,
                label: seen.label,
                n: seen.n,
                cells: seen.cells,
            });
        }
        for mark in next.more {
            self.add(Mark {
                t: mark.t + later,
                ..mark
            });
        }
    }

    /// Adds a mode of another line, if it is not drawn already.
    fn add(&mut self, new: Mark) {
        if !(new.f.is_finite() && new.zeta.is_finite()) {
            return;
        }
        let like = |label: Label, cells: Cells| {
            let ours = label == new.label;
            (
                ours && cells.0 == new.cells.0,
                ours && cells.1 == new.cells.1,
            )
        };
        let (mut same, mut zeta, mut f) = (0, false, false);
        for mark in &self.more {
            let (by_zeta, by_f) = like(mark.label, mark.cells);
            same += usize::from(mark.label == new.label);
            (zeta, f) = (zeta | by_zeta, f | by_f);
        }
        for seen in &self.modes {
            let (by_zeta, by_f) = like(seen.label, seen.cells);
            (zeta, f) = (zeta | by_zeta, f | by_f);
        }
        if zeta && f {
            self.count(new);
            return;
        }
        if same < MORE {
            if self.more.capacity() == 0 {
                // All at once: memory does not depend on what comes.
                self.more.reserve_exact(LABELS * MORE);
            }
            self.more.push(new);
            return;
        }
        // Of those that are too many, the ends are kept.
        let ends: [fn(&Mark) -> f32; 4] = [|m| m.zeta, |m| -m.zeta, |m| m.f, |m| -m.f];
        for of in ends {
            let same = self.more.iter_mut().filter(|m| m.label == new.label);
            let end = same.min_by(|a, b| of(a).total_cmp(&of(b)));
            if let Some(end) = end
                && of(&new) < of(end)
            {
                let old = core::mem::replace(end, new);
                self.count(old);
                return;
            }
        }
        self.count(new);
    }

    /// Counts a mode that is not drawn with the one whose damping is nearest to its own.
    fn count(&mut self, new: Mark) {
        let away = |cells: Cells| (i32::from(cells.0) - i32::from(new.cells.0)).abs();
        let ours = self.modes.iter_mut().filter(|m| m.label == new.label);
        let ours = ours.map(|m| (away(m.cells), &mut m.n));
        let more = self.more.iter_mut().filter(|m| m.label == new.label);
        let more = more.map(|m| (away(m.cells), &mut m.n));
        if let Some((_, n)) = ours.chain(more).min_by_key(|(away, _)| *away) {
            *n = n.saturating_add(new.n);
        }
    }
}

/// The lines of a run, thinned.
#[derive(Debug, Clone, Default)]
pub(super) struct Moments {
    kept: Vec<Moment>,
    /// Lines in a moment are two to this power.
    doubled: u32,
    /// The moment that is open, and lines in it.
    open: Option<(Moment, u64)>,
}

impl Moments {
    /// Adds a line.
    pub(super) fn push(&mut self, new: Moment) {
        let (moment, lines) = match self.open.take() {
            Some((mut open, lines)) => {
                open.join(new);
                (open, lines + 1)
            }
            None => (new, 1),
        };
        if lines < 1 << self.doubled {
            self.open = Some((moment, lines));
            return;
        }
        if self.kept.len() == MOMENTS {
            halve(&mut self.kept, Moment::join);
            self.doubled += 1;
            self.open = Some((moment, lines));
            return;
        }
        self.kept.push(moment);
    }

    /// All there are, in their order.
    pub(super) fn iter(&self) -> impl Iterator<Item = &Moment> {
        self.kept
            .iter()
            .chain(self.open.iter().map(|(open, _)| open))
    }
}

#[cfg(test)]
#[path = "moment_tests.rs"]
mod tests;
