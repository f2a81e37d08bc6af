//! The line in which commands are typed: editing, history, completion.

use rarma_scenarios::speech;

/// Lines that are remembered.
const HISTORY: usize = 200;
/// Letters of a line at most: no command comes near.
const LETTERS: usize = 400;

/// A line that is being typed.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct InputLine {
    text: Vec<char>,
    /// Before which letter the next one comes.
    cursor: usize,
    history: Vec<String>,
    /// Place in the history; none: a new line.
    at: Option<usize>,
    /// The new line, while the history is looked at.
    new: Vec<char>,
    /// What could stand where Tab was pressed.
    pub(super) offers: Vec<String>,
}

impl InputLine {
    pub(super) fn text(&self) -> String {
        self.text.iter().collect()
    }

    pub(super) fn cursor(&self) -> usize {
        self.cursor
    }

    pub(super) fn is_empty(&self) -> bool {
        self.text.is_empty()
    }

    /// What the command that is being typed still needs, such as `NAME VALUE`.
    pub(super) fn hint(&self) -> Option<&'static str> {
        speech::form(&self.text())
    }

    pub(super) fn insert(&mut self, letter: char) {
        if !letter.is_control() && self.text.len() < LETTERS {
            self.text.insert(self.cursor, letter);
            self.cursor += 1;
            self.offers.clear();
        }
    }

    /// Takes the letter before the cursor away.
    pub(super) fn back(&mut self) {
        if self.cursor > 0 {
            self.cursor -= 1;
            self.delete();
        }
    }

    /// Takes the letter at the cursor away.
    pub(super) fn delete(&mut self) {
        if self.cursor < self.text.len() {
            self.text.remove(self.cursor);
        }
        self.offers.clear();
    }

    /// Takes away the word before the cursor.
    pub(super) fn back_word(&mut self) {
        let before = &self.text[..self.cursor];
        let word = before.iter().rposition(|c| !c.is_whitespace());
        let blank = before[..word.unwrap_or(0)]
            .iter()
            .rposition(|c| c.is_whitespace());
        let from = blank.map_or(0, |blank| blank + 1);
        self.text.drain(from..self.cursor);
        self.cursor = from;
        self.offers.clear();
    }

    /// Takes away all before the cursor.
    pub(super) fn back_all(&mut self) {
        self.text.drain(..self.cursor);
        self.cursor = 0;
        self.offers.clear();
    }

    /// Moves by so many letters.
    pub(super) fn go(&mut self, letters: isize) {
        let to = self.cursor.saturating_add_signed(letters);
        self.cursor = to.min(self.text.len());
    }

    /// A line of the history: `back` to the one before.
    pub(super) fn recall(&mut self, back: bool) {
        let end = self.history.len();
        let now = self.at.unwrap_or(end);
        let next = if back {
            now.saturating_sub(1)
        } else {
            (now + 1).min(end)
        };
        if next == now {
            return;
        }
        if self.at.is_none() {
            self.new = std::mem::take(&mut self.text);
        }
        self.at = (next < end).then_some(next);
        self.text = match self.at {
            Some(at) => self.history[at].chars().collect(),
            None => std::mem::take(&mut self.new),
        };
        self.cursor = self.text.len();
        self.offers.clear();
    }

    /// Puts in what must come next; where several words could, they are offered.
    pub(super) fn complete(&mut self) {
        let before: String = self.text[..self.cursor].iter().collect();
        // Words end at any blank, as for who reads the line: some keyboards type one that is not the plain one.
        let begun = before.rsplit(char::is_whitespace).next();
        let begun = begun.unwrap_or_default();
        let all = speech::completions(&before);
        let Some(first) = all.first() else {
            self.offers.clear();
            return;
        };
        let shared = all.iter().skip(1).fold(*first, |shared, other| {
            let same = shared
                .bytes()
                .zip(other.bytes())
                .take_while(|(a, b)| a == b);
            &shared[..same.count()]
        });
        let mut rest = shared[begun.len()..].to_owned();
        if all.len() == 1 {
            rest.push(' ');
        }
        rest.chars().for_each(|letter| self.insert(letter));
        self.offers = match all.len() {
            1 => Vec::new(),
            _ => all.into_iter().map(str::to_owned).collect(),
        };
    }

    /// Takes the line out, and remembers it.
    pub(super) fn enter(&mut self) -> String {
        let line = self.text().trim().to_owned();
        if !line.is_empty() && self.history.last() != Some(&line) {
            self.history.push(line.clone());
            if self.history.len() > HISTORY {
                self.history.remove(0);
            }
        }
        *self = Self {
            history: std::mem::take(&mut self.history),
            ..Self::default()
        };
        line
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn typed(text: &str) -> InputLine {
        let mut line = InputLine::default();
        text.chars().for_each(|c| line.insert(c));
        line
    }

    #[test]
    fn letters_and_words_are_put_in_and_taken_out_where_the_cursor_stands() {
        let mut line = typed("set monitor.threshold 0.02");
        line.back_word();
        assert_eq!(line.text(), "set monitor.threshold ");
        line.back_word();
        assert_eq!(line.text(), "set ");
        line.go(-100);
        line.delete();
        line.insert('g');
        assert_eq!((line.text().as_str(), line.cursor()), ("get ", 1));
        line.go(1);
        line.back_all();
        assert_eq!(line.text(), "t ");
    }

    #[test]
    fn the_history_goes_back_and_forth_and_the_new_line_is_kept() {
        let mut line = InputLine::default();
        for said in ["arm", "stop", "stop"] {
            said.chars().for_each(|c| line.insert(c));
            assert_eq!(line.enter(), said);
        }
        line.insert('x');
        line.recall(true);
        assert_eq!(line.text(), "stop");
        line.recall(true);
        line.recall(true);
        assert_eq!(line.text(), "arm", "twice the same is kept once");
        line.recall(false);
        line.recall(false);
        line.recall(false);
        assert_eq!(line.text(), "x");
    }

    #[test]
    fn tab_goes_as_far_as_it_is_certain_and_offers_the_rest() {
        let mut line = typed("id");
        line.complete();
        assert_eq!(line.text(), "identify ");
        let mut line = typed("set mon");
        line.complete();
        assert_eq!(line.text(), "set monitor.");
        assert!(line.offers.contains(&"monitor.threshold".to_owned()));
        "th".chars().for_each(|c| line.insert(c));
        line.complete();
        assert_eq!(line.text(), "set monitor.threshold ");
        assert!(line.offers.is_empty());
        let mut line = typed("nothing ");
        line.complete();
        assert_eq!(line.text(), "nothing ");
        for blank in ['\u{a0}', '\u{3000}'] {
            let mut line = typed(&format!("start{blank}mon"));
            line.complete();
            assert_eq!(line.text(), format!("start{blank}monitor "));
            line.back_word();
            assert_eq!(line.text(), format!("start{blank}"));
        }
    }

    /// Letters of any writing, and those that words of commands begin with, with blanks of all sorts.
    fn letter() -> impl Strategy<Value = char> {
        let usual: Vec<char> = "aehioprst.  \u{a0}\u{3000}".chars().collect();
        prop_oneof![any::<char>(), prop::sample::select(usual)]
    }

    proptest! {
        #[test]
        fn whatever_is_pressed_the_cursor_stays_in_the_line(keys in prop::collection::vec((0..12_u8, letter()), 0..80)) {
            let mut line = InputLine::default();
            for (key, letter) in keys {
                match key {
                    0 => line.back(),
                    1 => line.delete(),
                    2 => line.back_word(),
                    3 => line.go(-3),
                    4 => line.recall(true),
                    5 => line.recall(false),
                    6 => line.complete(),
                    7 => drop(line.enter()),
                    _ => line.insert(letter),
                }
                prop_assert!(line.cursor() <= line.text().chars().count());
                prop_assert!(!line.text().contains(char::is_control));
            }
        }
    }
}
