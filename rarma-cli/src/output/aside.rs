//! Lines that would spoil a screen: kept while one is up, written when it is gone.
//!
//! A line for a stream that is no terminal spoils nothing, and is written at once.

use std::collections::VecDeque;
use std::io::{self, IsTerminal};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Lines that are kept, the last ones; those before them are counted.
const MOST: usize = 1000;

static ASIDE: Mutex<Option<Aside>> = Mutex::new(None);

/// Where a line is to go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    Output,
    Error,
}

#[derive(Debug, Default)]
struct Aside {
    lines: VecDeque<(Way, String)>,
    left_out: u64,
    /// Not shown yet.
    news: VecDeque<String>,
}

impl Aside {
    fn keep(&mut self, way: Way, line: String) {
        self.lines.push_back((way, line));
        if self.lines.len() > MOST {
            self.lines.pop_front();
            self.left_out += 1;
        }
    }
}

fn aside() -> MutexGuard<'static, Option<Aside>> {
    ASIDE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Keeps a line while a screen is up; false: it is to be written now.
pub(super) fn keeps(way: Way, text: std::fmt::Arguments<'_>) -> bool {
    let mut aside = aside();
    let Some(aside) = &mut *aside else {
        return false;
    };
    let spoils = match way {
        Way::Output => io::stdout().is_terminal(),
        Way::Error => io::stderr().is_terminal(),
    };
    let line = text.to_string();
    aside.news.push_back(line.clone());
    if aside.news.len() > MOST {
        aside.news.pop_front();
    }
    if spoils {
        aside.keep(way, line);
    }
    spoils
}

/// A screen is up: from now on lines are kept.
pub(crate) fn begin() {
    aside().get_or_insert_default();
}

/// Lines since the last call, for the screen to show.
pub(crate) fn news() -> Vec<String> {
    let mut aside = aside();
    let news = aside.as_mut().map(|aside| aside.news.drain(..).collect());
    news.unwrap_or_default()
}

/// The screen is gone: what was kept, and how many lines before it were left out.
pub(super) fn end() -> (u64, VecDeque<(Way, String)>) {
    let kept = aside().take().unwrap_or_default();
    (kept.left_out, kept.lines)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_lines_are_kept_and_the_others_counted() {
        let mut aside = Aside::default();
        for n in 0..MOST + 3 {
            aside.keep(Way::Error, n.to_string());
        }
        assert_eq!((aside.lines.len(), aside.left_out), (MOST, 3));
        assert_eq!(aside.lines[0].1, "3");
    }
}
