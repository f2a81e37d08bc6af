//! The table of results: as markdown, back from it, one row put into it.

use std::fmt::Write as _;

use crate::page::Part;

/// Where the table is in the page that holds it.
const PART: Part = Part("long");

const HEADER: &str = "| long form | result | s | on | commit |\n|---|---|---:|---|---|\n";

/// What became of a long form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Became {
    /// It passed when it ran last.
    Passed,
    /// It failed when it ran last.
    Failed,
    /// It has not been run yet: written by hand when it was made, and said by every
    /// `cargo verify` until it is run.
    NotRun,
}

impl Became {
    const ALL: [Self; 3] = [Self::Passed, Self::Failed, Self::NotRun];

    const fn word(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Failed => "**failed**",
            Self::NotRun => "not run yet",
        }
    }
}

/// The last result of one long form.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Test file and test, or `fuzzing` and target.
    pub name: String,
    /// How it ended.
    pub became: Became,
    /// How long it took.
    pub seconds: f64,
    /// The day, e.g. `2026-11-22`.
    pub date: String,
    /// The commit; with a `+` where the sources differed from it.
    pub commit: String,
}

/// The last results.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    /// Ordered by name.
    pub rows: Vec<Row>,
}

impl Table {
    /// Puts a result in the place of the last one of that name.
    pub fn put(&mut self, row: Row) {
        self.rows.retain(|old| old.name != row.name);
        self.rows.push(row);
        self.rows.sort_by(|a, b| a.name.cmp(&b.name));
    }

    /// Whether that long form passed when it ran last.
    pub fn passed(&self, name: &str) -> bool {
        self.rows
            .iter()
            .any(|row| row.name == name && row.became == Became::Passed)
    }

    /// Those that have not been run yet.
    pub fn not_run(&self) -> impl Iterator<Item = &str> {
        let waiting = self.rows.iter().filter(|row| row.became == Became::NotRun);
        waiting.map(|row| row.name.as_str())
    }

    /// The table as text.
    pub fn markdown(&self) -> String {
        let mut text = HEADER.to_owned();
        for row in &self.rows {
            // Writing to a String cannot fail.
            let _ = writeln!(
                text,
                "| {} | {} | {:.0} | {} | {} |",
                row.name,
                row.became.word(),
                row.seconds,
                row.date,
                row.commit
            );
        }
        text
    }

    /// `document` with this table between its markers.
    ///
    /// # Errors
    /// When a marker is missing.
    pub fn written_into(&self, document: &str) -> Result<String, String> {
        PART.written_into(document, &self.markdown())
    }

    /// The table between the markers of `document`.
    ///
    /// # Errors
    /// When a marker is missing or a row is not understood.
    pub fn found_in(document: &str) -> Result<Self, String> {
        let (_, text, _) = PART.split(document)?;
        let rows = text.lines().filter(|line| !HEADER.contains(line));
        let rows =
            rows.map(|line| row(line).ok_or_else(|| format!("row `{line}` is not understood")));
        Ok(Self {
            rows: rows.collect::<Result<_, _>>()?,
        })
    }

    /// What is wrong with this table if these are all the long forms: a line for each that
    /// has no row, that failed when it ran last, or that is there no more.
    pub fn objections(&self, forms: &[String]) -> Vec<String> {
        let find = |name: &String| self.rows.iter().find(|row| row.name == *name);
        let of_forms = forms.iter().filter_map(|name| match find(name) {
            None => Some(format!("{name}: has no result")),
            Some(row) if row.became == Became::Failed => {
                Some(format!("{name}: failed on {} at {}", row.date, row.commit))
            }
            Some(_) => None,
        });
        let gone = self.rows.iter().filter(|row| !forms.contains(&row.name));
        of_forms
            .chain(gone.map(|row| format!("{}: in the table, but no long form", row.name)))
            .collect()
    }
}

fn row(line: &str) -> Option<Row> {
    let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
    let [name, result, seconds, date, commit] = cells.as_slice() else {
        return None;
    };
    Some(Row {
        name: (*name).to_owned(),
        became: Became::ALL.into_iter().find(|b| b.word() == *result)?,
        seconds: seconds.parse().ok()?,
        date: (*date).to_owned(),
        commit: (*commit).to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn result(name: &str, became: Became) -> Row {
        Row {
            name: name.to_owned(),
            became,
            seconds: 404.0,
            date: "2026-11-22".to_owned(),
            commit: "41c6dbb".to_owned(),
        }
    }

    fn table() -> Table {
        let mut table = Table::default();
        table.put(result("b::y_long", Became::Failed));
        table.put(result("a::x_long", Became::Passed));
        table
    }

    #[test]
    fn survives_being_written_and_read_back() {
        let empty = "before\n<!-- long:begin -->\n<!-- long:end -->\nafter\n";
        let page = table().written_into(empty).expect("has markers");
        assert_eq!(Table::found_in(&page), Ok(table()));
        assert!(page.contains("\n| a::x_long | passed | 404 | 2026-11-22 | 41c6dbb |\n| b::y"));
        assert_eq!(Table::found_in(empty), Ok(Table::default()));
        let strange = empty.replace("begin -->\n", "begin -->\n| a | well | 1 | 2 | 3 |\n");
        assert!(Table::found_in(&strange).is_err_and(|why| why.contains("| a | well")));
    }

    #[test]
    fn a_new_result_takes_the_place_of_the_last() {
        let mut table = table();
        table.put(result("b::y_long", Became::Passed));
        assert_eq!(
            table.rows,
            [
                result("a::x_long", Became::Passed),
                result("b::y_long", Became::Passed)
            ]
        );
    }

    #[test]
    fn what_never_ran_failed_or_is_gone_is_told() {
        let forms = ["a::x_long", "b::y_long", "c::z_long"].map(str::to_owned);
        let told = table().objections(&forms);
        assert_eq!(told.len(), 2, "{told:?}");
        assert!(told[0].contains("b::y_long: failed on 2026-11-22"));
        assert!(told[1].contains("c::z_long: has no result"));
        assert!(table().passed("a::x_long"));
        assert!(!table().passed("b::y_long") && !table().passed("c::z_long"));
        let mut waiting = table();
        waiting.put(result("c::z_long", Became::NotRun));
        assert_eq!(waiting.objections(&forms).len(), 1);
        assert_eq!(waiting.not_run().collect::<Vec<_>>(), ["c::z_long"]);
        let told = table().objections(&forms[1..2]);
        assert!(
            told[1].contains("a::x_long: in the table, but no"),
            "{told:?}"
        );
    }
}
