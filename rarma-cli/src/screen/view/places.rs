//! What goes where.

use super::big;
use ratatui::layout::{Constraint, Layout, Rect};

/// The smallest terminal on which there is room for it, columns and rows.
pub(super) const LEAST: (u16, u16) = (60, 18);
/// From this size on letters are twice as large, and the log stands beside the spectrum.
const ROOMY: (u16, u16) = (100, 36);
/// Rows of modes at most, and their heading.
const MODES: u16 = 5;
/// Lines of a box's own at most; with them, large letters need so many rows.
const AT_BOX: u16 = 4;
const LARGE_AT_A_BOX: u16 = 30;
/// Lines of advice, in a small and in a roomy terminal.
const ADVICE: (u16, u16) = (2, 4);

/// The parts of the screen.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Places {
    pub(super) header: Rect,
    /// The state in large letters, and why below it.
    pub(super) state: Rect,
    pub(super) size: big::Size,
    pub(super) speed: Rect,
    pub(super) at_box: Rect,
    pub(super) modes: Rect,
    pub(super) advice: Rect,
    pub(super) waterfall: Rect,
    pub(super) log: Rect,
    pub(super) input: Rect,
    pub(super) keys: Rect,
}

impl Places {
    /// In an area of at least [`LEAST`]; `at_box` and `advice`: lines of them that there are.
    pub(super) fn of(area: Rect, at_box: usize, input: bool, advice: usize) -> Self {
        let roomy = area.width >= ROOMY.0 && area.height >= ROOMY.1;
        let size = match at_box {
            1.. if area.height < LARGE_AT_A_BOX => big::Size::Small,
            _ => big::Size::within(area.width, area.height, roomy),
        };
        let at_most = |lines, most| u16::try_from(lines).unwrap_or(most).min(most);
        let advice = at_most(advice, if roomy { ADVICE.1 } else { ADVICE.0 });
        let heights = [
            1,
            size.rows() + 1,
            1,
            at_most(at_box, AT_BOX),
            MODES,
            advice + u16::from(advice > 0),
        ];
        let fixed = heights.map(Constraint::Length);
        let [
            header,
            state,
            speed,
            at_box,
            modes,
            advice,
            middle,
            input,
            keys,
        ] = Layout::vertical(fixed.into_iter().chain([
            Constraint::Fill(1),
            Constraint::Length(u16::from(input)),
            Constraint::Length(1),
        ]))
        .areas(area);
        let parts = [Constraint::Fill(3), Constraint::Fill(2)];
        let [waterfall, log] = if roomy {
            Layout::horizontal(parts).spacing(1).areas(middle)
        } else {
            Layout::vertical(parts).areas(middle)
        };
        Self {
            header,
            state,
            size,
            speed,
            at_box,
            modes,
            advice,
            waterfall,
            log,
            input,
            keys,
        }
    }
}
