//! The same records give the same answers in SQLite, PostgreSQL and ClickHouse: in any order, with
//! repeats, in any portions, before and after thinning.

mod support;

use rand::seq::SliceRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rarma_fleet::plant::life::What;
use rarma_fleet::plant::{Fate, Plant, PlantConfig};
use rarma_fleet::record::{Record, from_line};
use rarma_fleet::store::{By, Span, Store};

fn records(seed: u64, machines: usize, days: u32) -> Vec<Record> {
    let start = "2025-11-20T00:00:00Z".parse().unwrap();
    let config = PlantConfig {
        machines,
        days,
        start,
        seed,
        fate: Fate::Usual,
        tests_only: false,
    };
    let mut plant = Plant::new(config);
    std::iter::from_fn(|| plant.next_day()).flatten().collect()
}

/// Everything that can be asked, as text with 10 digits: sums of floats come in another order.
fn answers(store: &mut Store) -> Vec<String> {
    let mut all = Vec::new();
    let mut put = |what: &str, rows: Vec<String>| {
        assert!(!rows.is_empty(), "{what}: nothing");
        all.extend(rows.into_iter().map(|row| format!("{what} {row}")));
    };
    let december = Span {
        from_month: Some(202_512),
        to_month: Some(202_512),
    };
    put("contents", text(store.contents().unwrap()));
    put("machines", text(store.machines().unwrap()));
    for by in [By::Machine, By::Tool, By::Operator, By::Speed, By::Month] {
        for span in [Span::default(), december] {
            let alarms = store.alarms(by, span).unwrap();
            put(
                "alarms",
                alarms
                    .iter()
                    .map(|a| format!("{} {} {:.6}", a.key, a.alarms, a.seconds))
                    .collect(),
            );
            put("advice", text(store.advice(by, span).unwrap()));
        }
    }
    let states = store.states(Span::default()).unwrap();
    put(
        "states",
        states
            .iter()
            .map(|s| format!("{} {} {} {:.6}", s.machine, s.month, s.state, s.seconds))
            .collect(),
    );
    // Bit by bit: these are not summed.
    put("readings", text(store.readings(None).unwrap()));
    put("lines", store.lines(None, None, None, 10_000).unwrap());
    all
}

fn text<T: std::fmt::Debug>(rows: Vec<T>) -> Vec<String> {
    rows.iter().map(|row| format!("{row:?}")).collect()
}

/// Adds in portions of chance.
fn add_all(store: &mut Store, records: &[Record], rng: &mut ChaCha8Rng) -> u64 {
    let (mut rest, mut new) = (records, 0);
    while !rest.is_empty() {
        let (now, later) = rest.split_at(rng.random_range(1..=rest.len().min(3000)));
        let taken = store.add(now).unwrap();
        assert_eq!(taken.different_count, 0);
        new += taken.new;
        rest = later;
    }
    new
}

#[test]
fn the_same_records_give_the_same_answers_in_any_order_everywhere() {
    let (postgres, clickhouse) = (support::postgres(), support::clickhouse());
    let folder = tempfile::tempdir().unwrap();
    for seed in 0..4 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let came = records(seed, 3, 45);
        let mut places = vec![
            folder
                .path()
                .join(format!("{seed}.db"))
                .display()
                .to_string(),
        ];
        places.push(
            folder
                .path()
                .join(format!("{seed}-shuffled.db"))
                .display()
                .to_string(),
        );
        let name = format!("s{seed}");
        places.extend(
            postgres
                .as_ref()
                .map(|server| support::postgres_database(server, &name)),
        );
        places.extend(
            clickhouse
                .as_ref()
                .map(|server| support::clickhouse_database(server, &name)),
        );
        let mut first: Option<(Vec<String>, Vec<String>)> = None;
        for (n, place) in places.iter().enumerate() {
            let mut order = came.clone();
            if n > 0 {
                order.shuffle(&mut rng);
                // And a tenth of them again.
                let again: Vec<Record> = order.iter().take(order.len() / 10).cloned().collect();
                order.extend(again);
            }
            let mut store = Store::open(place).unwrap();
            let new = add_all(&mut store, &order, &mut rng);
            let before = answers(&mut store);
            // Opened anew, and thinned twice.
            drop(store);
            let mut store = Store::open(place).unwrap();
            let day = came[0].time.day() + 20;
            let thinned = store.thin(day).unwrap();
            assert!(thinned.verdicts > 1000 && thinned.days > 0, "{thinned:?}");
            assert_eq!(store.thin(day).unwrap().verdicts, 0);
            let late = store.add(&came).unwrap();
            assert_eq!(late.new, 0, "what was thinned is not taken again");
            let after = answers(&mut store);
            let states = |all: &[String]| {
                all.iter()
                    .filter(|a| a.starts_with("states"))
                    .cloned()
                    .collect::<Vec<_>>()
            };
            assert_eq!(
                states(&before),
                states(&after),
                "{place}: thinning changes no answer"
            );
            match &first {
                None => {
                    assert!(new > 5000, "{new}");
                    first = Some((before, after));
                }
                Some(first) => {
                    same(&first.0, &before, place);
                    same(&first.1, &after, place);
                }
            }
        }
    }
}

fn same(a: &[String], b: &[String], place: &str) {
    let other = a.iter().zip(b).find(|(a, b)| a != b);
    assert!(other.is_none(), "{place}: {other:#?}");
    assert_eq!(a.len(), b.len(), "{place}");
}

#[test]
fn another_record_of_the_same_name_is_told_and_the_first_stays() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path().join("a.db").to_str().unwrap()).unwrap();
    let first = records(1, 1, 3)[0].clone();
    let mut other = first.clone();
    other.tool = Some("T99".parse().unwrap());
    assert_eq!(store.add(std::slice::from_ref(&first)).unwrap().new, 1);
    let taken = store.add(&[other, first.clone()]).unwrap();
    assert_eq!(
        (taken.new, taken.same, taken.different),
        (0, 1, vec![first.id.clone()])
    );
    let kept = store.lines(None, None, None, 10).unwrap();
    assert_eq!(from_line(&kept[0]).unwrap(), first);
}

#[test]
fn a_line_is_kept_with_what_this_program_does_not_know() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path().join("a.db").to_str().unwrap()).unwrap();
    let line = r#"{"schema":1,"box":"b","session":1,"seq":1,"machine":"M","mood":"good","time":"2026-01-01T00:00:00Z","kind":"alarm-called","body":{"f_hz":1.0,"zeta":0.0}}"#;
    let lines = [line, "nonsense", r#"{"schema":2}"#, r#"{"a":1}"#];
    let mut refused = Vec::new();
    let taken = store
        .add_lines(lines, |place, why| refused.push((place, why.to_string())))
        .unwrap();
    assert_eq!(taken.new, 1);
    assert_eq!(refused.iter().map(|r| r.0).collect::<Vec<_>>(), [1, 2, 3]);
    assert!(refused[1].1.contains("schema 2"), "{}", refused[1].1);
    assert_eq!(store.lines(None, None, None, 10).unwrap(), [line]);
}

#[test]
fn lines_go_on_where_they_ended() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path().join("a.db").to_str().unwrap()).unwrap();
    store.add(&records(2, 2, 12)).unwrap();
    let all = store.lines(None, None, None, 100_000).unwrap();
    let mut paged = Vec::new();
    let mut after = None;
    loop {
        let page = store.lines(None, None, after.as_ref(), 97).unwrap();
        let Some(last) = page.last() else { break };
        let last = from_line(last).unwrap();
        after = Some((last.time, last.id));
        paged.extend(page);
    }
    assert_eq!(paged, all);
}

#[test]
fn a_file_that_is_not_ours_is_refused_and_not_touched() {
    let folder = tempfile::tempdir().unwrap();
    let text = folder.path().join("notes.txt");
    std::fs::write(&text, "not a database, but a text of more than a few words").unwrap();
    let said = Store::open(text.to_str().unwrap())
        .err()
        .unwrap()
        .to_string();
    assert!(said.contains("not a database"), "{said}");
    assert_eq!(std::fs::read_to_string(&text).unwrap().len(), 51);

    let other = folder.path().join("other.db");
    rusqlite::Connection::open(&other)
        .unwrap()
        .execute_batch("CREATE TABLE mine (a)")
        .unwrap();
    let before = std::fs::read(&other).unwrap();
    let said = Store::open(other.to_str().unwrap())
        .err()
        .unwrap()
        .to_string();
    assert!(said.contains("another program"), "{said}");
    assert_eq!(std::fs::read(&other).unwrap(), before);
    assert_eq!(
        std::fs::read_dir(folder.path()).unwrap().count(),
        2,
        "no journal beside it"
    );

    let later = folder.path().join("later.db");
    drop(Store::open(later.to_str().unwrap()).unwrap());
    rusqlite::Connection::open(&later)
        .unwrap()
        .execute_batch("UPDATE meta SET value = 9")
        .unwrap();
    let said = Store::open(later.to_str().unwrap())
        .err()
        .unwrap()
        .to_string();
    assert!(said.contains("version 9"), "{said}");
}

#[test]
fn a_file_that_was_cut_off_loses_nothing_that_was_there_before() {
    // The log beside the file, cut at many places: as if the power went while it was written.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.db");
    let came = records(3, 1, 20);
    let (early, late) = came.split_at(came.len() / 2);
    let mut store = Store::open(path.to_str().unwrap()).unwrap();
    store.add(early).unwrap();
    // What is in the file itself from now on.
    rusqlite::Connection::open(&path)
        .unwrap()
        .pragma_query(None, "wal_checkpoint", |_| Ok(()))
        .unwrap();
    let sound = std::fs::read(&path).unwrap();
    let before = store.contents().unwrap();
    store.add(late).unwrap();
    let log = std::fs::read(folder.path().join("a.db-wal")).unwrap();
    assert!(log.len() > 10_000);
    let after = store.contents().unwrap();
    for n in 0..40 {
        let cut = folder.path().join(format!("cut-{n}.db"));
        std::fs::write(&cut, &sound).unwrap();
        std::fs::write(
            folder.path().join(format!("cut-{n}.db-wal")),
            &log[..log.len() * n / 40],
        )
        .unwrap();
        let mut store = Store::open(cut.to_str().unwrap()).unwrap();
        let found = store.contents().unwrap();
        assert!(
            found == before || found == after,
            "cut at {n}/40: {found:?}"
        );
        assert_eq!(store.add(&came).map(|t| t.different_count).unwrap(), 0);
        assert_eq!(store.contents().unwrap(), after);
    }
}

/// Three programs at once, each with all records in its own order: what is kept beside them counts each once.
#[test]
fn writers_at_once_count_each_record_once() {
    let came = records(5, 2, 40);
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let mut alone = Store::open(&at("alone.db")).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let once = add_all(&mut alone, &came, &mut rng);
    let expected = answers(&mut alone);
    let postgres = support::postgres();
    let mut places = vec![at("all.db")];
    places.extend((postgres.as_ref()).map(|s| support::postgres_database(s, "writers")));
    for place in places {
        drop(Store::open(&place).unwrap());
        let new: u64 = std::thread::scope(|scope| {
            let writers: Vec<_> = (0..3)
                .map(|n| {
                    let (place, mut order) = (&place, came.clone());
                    scope.spawn(move || {
                        let mut rng = ChaCha8Rng::seed_from_u64(n);
                        order.shuffle(&mut rng);
                        add_all(&mut Store::open(place).unwrap(), &order, &mut rng)
                    })
                })
                .collect();
            writers.into_iter().map(|w| w.join().unwrap()).sum()
        });
        // Two that come with the same record at the same moment may both say that it is new.
        assert!(new >= once, "{new} of {once}");
        same(
            &expected,
            &answers(&mut Store::open(&place).unwrap()),
            &place,
        );
    }
}

/// A server ends the connection, as one does that is started anew: what is asked then fails, what is asked next is
/// answered over a new one, and what comes again is there once.
#[test]
fn a_database_that_was_away_is_connected_again() {
    let came = records(7, 1, 10);
    let (early, late) = came.split_at(came.len() / 2);
    if let Some(server) = support::postgres() {
        let place = support::postgres_database(&server, "away");
        let mut store = Store::open(&place).unwrap();
        let first = store.add(early).unwrap().new;
        for round in 0..3 {
            support::postgres_ends_connections(&server, "away");
            let said = store.add(late).unwrap_err().to_string();
            assert!(said.contains("PostgreSQL"), "{said}");
            let taken = store.add(late).unwrap();
            assert_eq!(taken.new == 0, round > 0, "{taken:?}");
        }
        assert_eq!(store.add(&came).unwrap().new, 0);
        let records: i64 = store.contents().unwrap().iter().map(|c| c.records).sum();
        assert!(records > i64::try_from(first).unwrap());
        // Away for good: each question says so, and none hangs.
        drop(server);
        for _ in 0..3 {
            assert!(store.contents().is_err());
        }
    }
    if let Some(server) = support::clickhouse() {
        let place = support::clickhouse_database(&server, "away");
        let mut store = Store::open(&place).unwrap();
        store.add(early).unwrap();
        let all = |store: &mut Store| store.lines(None, None, None, 10_000).unwrap();
        let before = all(&mut store);
        // The same place, another server: nothing is kept of a connection.
        let server = support::clickhouse_again(server);
        let said = (0..2).find_map(|_| store.contents().ok());
        assert!(said.is_some(), "ClickHouse is not asked again");
        same(&before, &all(&mut store), &place);
        assert!(store.add(&came).unwrap().new > 0);
        drop(server);
    }
}

/// Version 1 had no sums and other indices, and a thinning that was killed left rows behind.
#[test]
fn a_store_of_version_1_is_taken_over() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.db");
    let place = path.to_str().unwrap();
    let came = records(6, 2, 40);
    let mut store = Store::open(place).unwrap();
    store.add(&came).unwrap();
    store.thin(came[0].time.day() + 10).unwrap();
    let before = answers(&mut store);
    drop(store);
    let raw = rusqlite::Connection::open(&path).unwrap();
    let closed: i64 = raw
        .query_row(
            "SELECT value FROM meta WHERE name = 'thinned_before_us'",
            [],
            |row| row.get(0),
        )
        .unwrap();
    raw.execute_batch(&format!(
        "DROP TABLE sums; DROP INDEX records_time; DROP INDEX records_asked; DROP INDEX readings_machine;
         CREATE INDEX records_0 ON records (machine, time_us);
         CREATE INDEX records_1 ON records (kind, machine, month);
         CREATE INDEX records_2 ON records (kind, machine, month, state, seconds, time_us);
         CREATE INDEX readings_0 ON readings (machine, quantity, place, time_us);
         UPDATE meta SET value = 1 WHERE name = 'tables';
         INSERT INTO days VALUES ('M001', 1, 'stable', {closed} + 1, 202511, 5, 1000.0);"
    ))
    .unwrap();
    let mut store = Store::open(place).unwrap();
    same(&before, &answers(&mut store), "version 1");
    let names: Vec<String> = raw
        .prepare(
            "SELECT name FROM sqlite_master WHERE type = 'index' AND sql IS NOT NULL ORDER BY name",
        )
        .unwrap()
        .query_map([], |row| row.get(0))
        .unwrap()
        .map(Result::unwrap)
        .collect();
    assert_eq!(names, ["readings_machine", "records_asked", "records_time"]);
    assert_eq!(store.add(&came).unwrap().new, 0);
}

#[test]
fn the_plant_has_events() {
    let start = "2025-01-01T00:00:00Z".parse().unwrap();
    let plant = Plant::new(PlantConfig {
        machines: 50,
        days: 365,
        start,
        seed: 1,
        fate: Fate::Usual,
        tests_only: true,
    });
    let truth = plant.truth();
    let crashes = truth
        .iter()
        .flat_map(|m| &m.events)
        .filter(|e| matches!(e.what, What::Crash { .. }))
        .count();
    assert!((5..30).contains(&crashes), "{crashes}");
}
