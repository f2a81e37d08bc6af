//! The dashboards' SQL runs against the tables of a store, and finds something in each panel.

mod support;

use rarma_fleet::plant::{Fate, Plant, PlantConfig};
use rarma_fleet::store::Store;

#[test]
fn every_panel_of_every_dashboard_finds_something() {
    let Some(server) = support::postgres() else {
        return;
    };
    let place = support::postgres_database(&server, "grafana");
    let start = "2025-01-01T00:00:00Z".parse().unwrap();
    let config = PlantConfig {
        machines: 2,
        days: 60,
        start,
        seed: 4,
        fate: Fate::Usual,
        tests_only: false,
    };
    let mut plant = Plant::new(config);
    let records: Vec<_> = std::iter::from_fn(|| plant.next_day()).flatten().collect();
    Store::open(&place).unwrap().add(&records).unwrap();
    let mut client = postgres::Client::connect(&place, postgres::NoTls).unwrap();
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("grafana");
    let mut panels = 0;
    for file in std::fs::read_dir(folder).unwrap() {
        let text = std::fs::read_to_string(file.unwrap().path()).unwrap();
        let board: serde_json::Value = serde_json::from_str(&text).unwrap();
        for panel in board["panels"].as_array().unwrap() {
            // What Grafana puts in the place of its words.
            let sql = panel["targets"][0]["rawSql"].as_str().unwrap();
            let sql = sql
                .replace("$__unixEpochFrom()", "1735689600")
                .replace("$__unixEpochTo()", "1798761600")
                .replace("$machine", "'M001', 'M002'");
            assert!(!sql.contains('$'), "{sql}");
            let rows = client
                .simple_query(&sql)
                .unwrap_or_else(|why| panic!("{sql}: {why:?}"));
            // The answer ends with a count.
            assert!(rows.len() > 2, "{}: nothing", panel["title"]);
            panels += 1;
        }
    }
    assert_eq!(panels, 10);
}
