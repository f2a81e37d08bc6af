//! Promise: the page of the box's settings is the table that the firmware checks with, and so
//! is the schema.

use rarma_box::settings::{Kind, SETTINGS, SettingValue, Settings, markdown, write_schema};
use rarma_core::verdict::VerdictConfig;
use std::path::Path;

#[test]
fn page_holds_the_table() {
    let mut table = String::new();
    markdown(&mut table).expect("a table");
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/box.md");
    let text = std::fs::read_to_string(&page).expect("docs/box.md");
    let (head, rest) = text.split_once("<!-- settings -->\n").expect("a marker");
    let (old, tail) = rest.split_once("<!-- end -->").expect("a marker");
    if std::env::var_os("RARMA_WRITE_TABLE").is_some() {
        let new = format!("{head}<!-- settings -->\n{table}<!-- end -->{tail}");
        std::fs::write(&page, new).expect("docs/box.md");
        return;
    }
    assert_eq!(old, table, "RARMA_WRITE_TABLE=1 writes it");
}

#[test]
fn schema_is_json_and_holds_every_range() {
    let mut text = String::new();
    write_schema(&mut text).expect("a schema");
    let schema: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let properties = schema["properties"].as_object().expect("an object");
    assert_eq!(properties.len(), SETTINGS.len());
    for s in &SETTINGS {
        let p = &properties[s.name];
        let (low, high, default) = match s.kind {
            Kind::Real { low, high, default } => {
                (f64::from(low), f64::from(high), f64::from(default))
            }
            Kind::Whole { low, high, default } => {
                (f64::from(low), f64::from(high), f64::from(default))
            }
            Kind::Key => {
                assert_eq!(
                    (&p["type"], &p["writeOnly"]),
                    (&"string".into(), &true.into())
                );
                assert_eq!(p["default"], serde_json::Value::Null);
                continue;
            }
        };
        let close = |name: &str, x: f64| {
            let y = p[name].as_f64().expect(name);
            (x - y).abs() <= 1e-6 * x.abs()
        };
        assert!(
            close("minimum", low) && close("maximum", high) && close("default", default),
            "{}",
            s.name
        );
        assert!(low <= default && default <= high, "{}", s.name);
        assert_eq!(p["unit"], s.unit);
    }
}

#[test]
fn numbers_and_names_are_unique() {
    for (k, a) in SETTINGS.iter().enumerate() {
        for b in &SETTINGS[k + 1..] {
            assert!(
                a.number != b.number && a.name != b.name,
                "{} {}",
                a.name,
                b.name
            );
        }
    }
}

#[test]
fn the_numbers_of_the_verdict_reach_the_monitor() {
    let mut settings = Settings::default();
    let usual = firmware::listen::job(&settings, 48_000.0).monitor;
    let of_a_box = VerdictConfig {
        unheard_idle_db: 10.0,
        ..VerdictConfig::default()
    };
    assert_eq!(usual.verdict, of_a_box);
    for number in VerdictConfig::NUMBERS {
        let name = format!("verdict.{}", number.name.replace('_', "-"));
        let row = SETTINGS.iter().find(|s| s.name == name).expect("a row");
        for end in [number.least, number.most] {
            let value = SettingValue::Real(end as f32);
            settings.set(row.number, value).expect("in range");
            let monitor = firmware::listen::job(&settings, 48_000.0).monitor;
            assert_eq!(monitor.check(), Ok(()), "{name}");
            let got = monitor.verdict.get(number.name).expect("a number");
            assert!((got - end).abs() <= 1e-6 * end.abs(), "{name}: {got}");
        }
    }
}
