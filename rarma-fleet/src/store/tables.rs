//! The tables, described once, and spelled for each kind of database.

/// How a database spells things.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    /// SQLite.
    Sqlite,
    /// PostgreSQL.
    Postgres,
    /// ClickHouse.
    ClickHouse,
}

/// Type of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Type {
    /// Text.
    Text,
    /// 64-bit whole number.
    Int,
    /// 64-bit float.
    Real,
}

/// A column.
#[derive(Debug, Clone, Copy)]
pub struct Column {
    /// Its name.
    pub name: &'static str,
    /// Its type.
    pub kind: Type,
    /// May it be empty?
    pub null: bool,
}

/// A table.
#[derive(Debug, Clone, Copy)]
pub struct Table {
    /// Its name.
    pub name: &'static str,
    /// Its columns; the first `key` of them are the primary key.
    pub columns: &'static [Column],
    /// How many columns name a row.
    pub key: usize,
    /// Further indices: name, columns, and of which rows.
    pub indices: &'static [(&'static str, &'static str, Option<&'static str>)],
    /// Rows that are new in it are counted in `sums` as they come.
    pub summed: bool,
}

impl Dialect {
    /// Several statements take effect together or not at all. Without it there can be no `sums`: what was
    /// cut off and comes again would count twice.
    #[must_use]
    pub fn has_transactions(self) -> bool {
        self != Self::ClickHouse
    }

    /// Ranges of names that one question may ask for. Of a database by columns each question reads much, and each is a
    /// request of its own: 50 boxes and their tests are two of them and not 70 (a year of 50 machines in 136 s; one by one
    /// it was not in after six minutes). Half of it is four requests, double of it one; the parameters are a part of the
    /// address, of which ClickHouse takes 1 MB.
    pub(super) fn ranges_together(self) -> usize {
        if self == Self::ClickHouse { 50 } else { 1 }
    }
}

const fn text(name: &'static str) -> Column {
    Column {
        name,
        kind: Type::Text,
        null: false,
    }
}
const fn int(name: &'static str) -> Column {
    Column {
        name,
        kind: Type::Int,
        null: false,
    }
}
const fn real(name: &'static str) -> Column {
    Column {
        name,
        kind: Type::Real,
        null: false,
    }
}
const fn or_null(column: Column) -> Column {
    Column {
        null: true,
        ..column
    }
}

/// Of which rows `records_asked` is an index; a question that says so, too, may use it.
pub(super) const NOT_VERDICTS: &str = "kind <> 'verdict'";

/// All tables. Docs of the columns: docs/plant.md.
pub const TABLES: &[Table] = &[
    // A record: its head, what questions ask for, and the line as it came.
    Table {
        name: "records",
        key: 3,
        columns: &[
            text("sender"),
            int("session"),
            int("seq"),
            text("machine"),
            text("kind"),
            int("time_us"),
            int("month"),
            int("day"),
            or_null(text("tool")),
            or_null(text("operator")),
            or_null(text("settings")),
            or_null(text("firmware")),
            or_null(text("state")),
            or_null(int("of_seq")),
            or_null(real("f_hz")),
            or_null(real("zeta")),
            or_null(real("rpm")),
            or_null(int("rpm_step")),
            or_null(real("seconds")),
            or_null(int("speeds")),
            or_null(int("followed")),
            or_null(int("helped")),
            int("hash"),
            text("line"),
        ],
        indices: &[
            ("records_time", "time_us, sender, session, seq", None),
            // Four fifths of a store are verdicts, and `sums` answers what is asked of them.
            (
                "records_asked",
                "kind, machine, month, tool, operator, rpm_step, seconds, speeds, followed, helped",
                Some(NOT_VERDICTS),
            ),
        ],
        summed: true,
    },
    // The numbers of a capability.
    Table {
        name: "readings",
        key: 4,
        columns: &[
            text("sender"),
            int("session"),
            int("seq"),
            int("n"),
            text("machine"),
            text("quantity"),
            text("place"),
            real("at"),
            int("time_us"),
            or_null(text("tool")),
            or_null(text("operator")),
            real("value"),
            real("sd"),
        ],
        indices: &[(
            "readings_machine",
            "machine, quantity, place, time_us",
            None,
        )],
        summed: false,
    },
    // Verdicts that were thinned: seconds in each state by machine and day.
    Table {
        name: "days",
        key: 4,
        columns: &[
            text("machine"),
            int("day"),
            text("state"),
            int("thinned_us"),
            int("month"),
            int("verdicts"),
            real("seconds"),
        ],
        indices: &[],
        summed: false,
    },
    // How many records there are, and their seconds: what is asked of all of them, without reading them.
    Table {
        name: "sums",
        key: 4,
        columns: &[
            text("machine"),
            text("kind"),
            int("month"),
            text("state"),
            int("records"),
            real("seconds"),
            int("first_us"),
            int("last_us"),
        ],
        indices: &[],
        summed: false,
    },
    // What the store knows of itself.
    Table {
        name: "meta",
        key: 1,
        columns: &[text("name"), int("value")],
        indices: &[],
        summed: false,
    },
];

/// The table of a name.
pub(super) fn table(name: &str) -> &'static Table {
    TABLES
        .iter()
        .find(|t| t.name == name)
        .expect("a table of ours")
}

impl Column {
    fn spelled(&self, dialect: Dialect) -> String {
        let name = self.name;
        let kind = match (dialect, self.kind) {
            (Dialect::Sqlite | Dialect::Postgres, Type::Text) => "TEXT",
            (Dialect::Sqlite, Type::Int) => "INTEGER",
            (Dialect::Sqlite, Type::Real) => "REAL",
            (Dialect::Postgres, Type::Int) => "BIGINT",
            (Dialect::Postgres, Type::Real) => "DOUBLE PRECISION",
            (Dialect::ClickHouse, Type::Text) => "String",
            (Dialect::ClickHouse, Type::Int) => "Int64",
            (Dialect::ClickHouse, Type::Real) => "Float64",
        };
        match (dialect, self.null) {
            (Dialect::ClickHouse, true) => format!("{name} Nullable({kind})"),
            (Dialect::ClickHouse, false) | (_, true) => format!("{name} {kind}"),
            (_, false) => format!("{name} {kind} NOT NULL"),
        }
    }
}

/// What makes the tables where they are not there.
#[must_use]
pub fn statements(dialect: Dialect) -> Vec<String> {
    let mut all = Vec::new();
    for table in TABLES {
        if table.name == "sums" && !dialect.has_transactions() {
            continue;
        }
        let columns: Vec<String> = table.columns.iter().map(|c| c.spelled(dialect)).collect();
        let key: Vec<&str> = table.columns[..table.key].iter().map(|c| c.name).collect();
        let (columns, key, name) = (columns.join(", "), key.join(", "), table.name);
        all.push(match dialect {
            // Without a second copy of the key.
            Dialect::Sqlite => format!(
                "CREATE TABLE IF NOT EXISTS {name} ({columns}, PRIMARY KEY ({key})) WITHOUT ROWID"
            ),
            Dialect::Postgres => {
                format!("CREATE TABLE IF NOT EXISTS {name} ({columns}, PRIMARY KEY ({key}))")
            }
            // Rows of the same key become one when parts are merged, and count as one with FINAL.
            Dialect::ClickHouse => format!(
                "CREATE TABLE IF NOT EXISTS {name} ({columns}) ENGINE = ReplacingMergeTree ORDER BY ({key})"
            ),
        });
        if dialect != Dialect::ClickHouse {
            for (index, columns, of) in table.indices {
                let of = of.map_or(String::new(), |of| format!(" WHERE {of}"));
                all.push(format!(
                    "CREATE INDEX IF NOT EXISTS {index} ON {name} ({columns}){of}"
                ));
            }
        }
    }
    all
}
