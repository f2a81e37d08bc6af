//! How SQLite goes about what is asked: the very statements, not copies of them.

use super::super::sqlite::Sqlite;
use super::super::tables::{Dialect, Table};
use super::super::{Backend, Store};
use super::*;
use std::sync::{Arc, Mutex};

/// Plans of what was asked, a line each.
type Plans = Arc<Mutex<Vec<String>>>;

/// Asks how a question would be answered before it asks it.
struct Explained {
    inner: Sqlite,
    plans: Plans,
}

impl Backend for Explained {
    fn dialect(&self) -> Dialect {
        self.inner.dialect()
    }

    fn execute(&mut self, sql: &str) -> Result<(), StoreError> {
        self.inner.execute(sql)
    }

    fn execute_all(&mut self, statements: &[String]) -> Result<(), StoreError> {
        self.inner.execute_all(statements)
    }

    fn query(&mut self, sql: &str, parameters: &[Value]) -> Result<Rows, StoreError> {
        let plan = self
            .inner
            .query(&format!("EXPLAIN QUERY PLAN {sql}"), parameters)?;
        let steps: Vec<String> = plan.iter().map(|row| row[3].text().unwrap()).collect();
        self.plans.lock().unwrap().push(steps.join("; "));
        self.inner.query(sql, parameters)
    }

    fn insert(&mut self, rows: &[(&'static Table, Rows)]) -> Result<(), StoreError> {
        self.inner.insert(rows)
    }

    fn put_meta(&mut self, name: &str, value: i64) -> Result<(), StoreError> {
        self.inner.put_meta(name, value)
    }
}

/// What is asked is answered out of `sums` and of indices, not of all records.
#[test]
fn no_question_reads_all_records() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.db");
    drop(Store::open(path.to_str().unwrap()).unwrap());
    let plans = Plans::default();
    let explained = Explained {
        inner: Sqlite::open(&path).unwrap(),
        plans: Arc::clone(&plans),
    };
    let mut store = Store {
        backend: Box::new(explained),
    };
    let asked = || {
        plans
            .lock()
            .unwrap()
            .drain(..)
            .collect::<Vec<_>>()
            .join("; ")
    };
    let all = Span::default();
    for by in [By::Machine, By::Tool, By::Operator, By::Speed, By::Month] {
        store.alarms(by, all).unwrap();
        store.advice(by, all).unwrap();
        let found = asked();
        assert_eq!(
            found.matches("USING COVERING INDEX records_asked").count(),
            2,
            "{found}"
        );
    }
    store.contents().unwrap();
    store.machines().unwrap();
    store.states(all).unwrap();
    let found = asked();
    assert!(
        found.contains("sums") && !found.contains("records"),
        "{found}"
    );
    let (machine, id) = (
        "M1".parse::<Name>().unwrap(),
        Id {
            sender: "b".parse().unwrap(),
            session: 1,
            seq: 1,
        },
    );
    store.readings(Some(&machine)).unwrap();
    let found = asked();
    assert!(found.contains("INDEX readings_machine"), "{found}");
    let after = ("2026-01-01T00:00:00Z".parse().unwrap(), id);
    for after in [None, Some(&after)] {
        store.lines(None, None, after, 10).unwrap();
        let found = asked();
        assert!(
            found.contains("records_time") && !found.contains("TEMP B-TREE"),
            "{found}"
        );
    }
}
