//! A year of a plant in the stores: how large, how fast. Prints figures, for a time is a property of the computer; asserts
//! that the answers are the same, and the bar of SQLite's questions, which leaves room for any computer.
//!
//! `RARMA_MACHINES=5,50 RARMA_STORES=SQLite cargo test --release -p rarma-fleet --test year -- --ignored --nocapture`;
//! without either 5 and 50 machines, and all three stores.

mod support;

use rarma_fleet::plant::{Fate, Plant, PlantConfig};
use rarma_fleet::store::{By, Span, Store};
use rarma_fleet::trends::{TrendsConfig, trends};
use std::time::Instant;

/// No question to SQLite may take longer, s, of as many machines at most.
const QUESTION_S: f64 = 1.0;
const OF_MACHINES: usize = 50;

/// Not a question to the store: worked out of its answer.
const TRENDS: &str = "trends";

/// What was asked, and how long it took, s.
type Asked = Vec<(String, f64)>;

/// Asks one thing, and notes how long it took.
fn asked<T>(said: &mut Asked, what: &str, ask: impl FnOnce() -> T) -> T {
    let begin = Instant::now();
    let answer = ask();
    said.push((what.to_owned(), begin.elapsed().as_secs_f64()));
    answer
}

fn year(machines: usize, days: u32, place: &str) -> (u64, f64, Asked, String) {
    let start = "2025-01-01T00:00:00Z".parse().unwrap();
    let config = PlantConfig {
        machines,
        days,
        start,
        seed: 11,
        fate: Fate::Usual,
        tests_only: false,
    };
    let mut plant = Plant::new(config);
    let mut store = Store::open(place).unwrap();
    let (mut records, mut took) = (0, 0.0);
    let mut block = Vec::new();
    loop {
        let day = plant.next_day();
        let end = day.is_none();
        block.extend(day.into_iter().flatten());
        if end || block.len() > 20_000 {
            let begin = Instant::now();
            records += store.add(&block).unwrap().new;
            took += begin.elapsed().as_secs_f64();
            block.clear();
        }
        if end {
            break;
        }
    }
    let mut said = Vec::new();
    let all = Span::default();
    let contents = asked(&mut said, "contents", || store.contents().unwrap());
    let counts = asked(&mut said, "machines", || store.machines().unwrap());
    let mut text = format!("{contents:?}{counts:?}");
    for by in [By::Machine, By::Tool, By::Operator, By::Speed, By::Month] {
        let alarms = asked(&mut said, &format!("alarms/{by:?}"), || {
            store.alarms(by, all).unwrap()
        });
        text += &alarms
            .iter()
            .map(|a| format!("{} {} {:.5}", a.key, a.alarms, a.seconds))
            .collect::<String>();
        text += &format!(
            "{:?}",
            asked(&mut said, &format!("advice/{by:?}"), || store
                .advice(by, all)
                .unwrap())
        );
    }
    let states = asked(&mut said, "states", || store.states(all).unwrap());
    text += &states
        .iter()
        .map(|s| format!("{}{}{}{:.3}", s.machine, s.month, s.state, s.seconds))
        .collect::<String>();
    let readings = asked(&mut said, "readings", || store.readings(None).unwrap());
    let one = "M001".parse().unwrap();
    text += &format!(
        "{:?}",
        asked(&mut said, "readings of one", || store
            .readings(Some(&one))
            .unwrap())
    );
    let found = asked(&mut said, TRENDS, || {
        trends(&readings, &TrendsConfig::default()).0
    });
    text += &format!("{:?}", found.machines);
    (records, took, said, text)
}

/// The stores that are wanted (`RARMA_STORES=SQLite,PostgreSQL`), or all.
fn wanted_store(kind: &str) -> bool {
    std::env::var("RARMA_STORES").map_or(true, |wanted| wanted.split(',').any(|w| w == kind))
}

fn years(wanted: &str, days: u32) {
    let postgres = wanted_store("PostgreSQL").then(support::postgres).flatten();
    let clickhouse = wanted_store("ClickHouse")
        .then(support::clickhouse)
        .flatten();
    for machines in wanted.split(',').map(|n| n.parse::<usize>().unwrap()) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("year.db");
        let name = format!("y{machines}");
        let mut places = Vec::new();
        if wanted_store("SQLite") {
            places.push(("SQLite", file.display().to_string(), folder.path()));
        }
        if let Some(server) = &postgres {
            let place = support::postgres_database(server, &name);
            places.push(("PostgreSQL", place, server.folder()));
        }
        if let Some(server) = &clickhouse {
            let place = support::clickhouse_database(server, &name);
            places.push(("ClickHouse", place, server.folder()));
        }
        let mut first = None;
        for (kind, place, within) in places {
            let before = support::bytes(within);
            let (records, took, said, text) = year(machines, days, &place);
            let questions = said.iter().filter(|(what, _)| what != TRENDS);
            let slowest = questions.map(|(_, s)| *s).fold(0.0, f64::max);
            let times: Vec<String> = said
                .iter()
                .map(|(what, s)| format!("{what} {s:.2}"))
                .collect();
            println!(
                "{machines} machines, {kind}: {records} records in {took:.1} s, {:.0} MB; slowest question {slowest:.2} s; s: {}",
                support::bytes(within).saturating_sub(before) as f64 / 1e6,
                times.join(", ")
            );
            assert!(
                kind != "SQLite" || machines > OF_MACHINES || slowest <= QUESTION_S,
                "{slowest} s of {machines} machines"
            );
            let first = first.get_or_insert_with(|| text.clone());
            assert!(*first == text, "{kind} answers otherwise");
        }
    }
}

#[test]
fn a_plant_gives_the_same_answers_from_all_stores() {
    years("3", 120);
}

#[test]
#[ignore = "minutes, and gigabytes"]
fn a_plant_gives_the_same_answers_from_all_stores_long() {
    years(
        &std::env::var("RARMA_MACHINES").unwrap_or_else(|_| "5,50".to_owned()),
        365,
    );
}
