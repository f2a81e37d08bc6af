//! Scenario files: every field wrong in every way is refused in one line that says
//! where and what is allowed; the shipped ones are what they say.

use rarma_plants::cut::{Process, VirtualCut};
use rarma_scenarios::scenario::{self, SHIPPED};
use toml::de::{DeTable, DeValue};

/// A field of a text: its name, where name and value stand, and whether the value
/// is a table or list.
struct Field {
    name: String,
    key: std::ops::Range<usize>,
    value: std::ops::Range<usize>,
    plain: bool,
}

fn fields(table: &DeTable<'_>, out: &mut Vec<Field>) {
    for (key, value) in table {
        let plain = !matches!(value.get_ref(), DeValue::Table(_) | DeValue::Array(_));
        out.push(Field {
            name: key.get_ref().to_string(),
            key: key.span(),
            value: value.span(),
            plain,
        });
        match value.get_ref() {
            DeValue::Table(inner) => fields(inner, out),
            DeValue::Array(items) => {
                for item in items {
                    if let Some(inner) = item.get_ref().as_table() {
                        fields(inner, out);
                    }
                }
            }
            _ => {}
        }
    }
}

fn all(text: &str) -> Vec<Field> {
    let table = DeTable::parse(text).expect("TOML");
    let mut out = Vec::new();
    fields(table.get_ref(), &mut out);
    out
}

fn replaced(text: &str, at: &std::ops::Range<usize>, by: &str) -> String {
    format!("{}{by}{}", &text[..at.start], &text[at.end..])
}

/// The refusal, checked for its form.
fn refused(text: &str, line: usize, field: &str, what: &str) -> String {
    let said = match scenario::parse("bad.toml", text, None) {
        Ok(_) => panic!("{what}: {field} in line {line} was taken"),
        Err(why) => why.to_string(),
    };
    assert!(!said.contains('\n'), "{said}");
    assert!(said.starts_with("bad.toml: line "), "{what}: {said}");
    assert!(said.contains(field), "{what}: no `{field}` in: {said}");
    assert!(said.contains("(allowed: "), "{what}: {said}");
    said
}

fn line_of(text: &str, at: usize) -> usize {
    1 + text[..at].matches('\n').count()
}

#[test]
fn every_field_wrong_in_every_way_is_one_line() {
    let mut tried = 0;
    for (name, text) in SHIPPED {
        for f in all(text) {
            let line = line_of(text, f.key.start);
            // An unknown name, in its place.
            let unknown = replaced(text, &f.key, &format!("{}_x", f.name));
            let said = refused(&unknown, line, &f.name, "unknown name");
            assert!(
                said.contains(&format!("line {line}: ")) && said.contains("is no known name"),
                "{name}: {said}"
            );
            if f.plain {
                // The wrong type, out of range, not a number.
                let text_value = text[f.value.clone()].starts_with('"');
                let wrong = if text_value { "7" } else { "\"seven\"" };
                let said = refused(
                    &replaced(text, &f.value, wrong),
                    line,
                    &f.name,
                    "wrong type",
                );
                assert!(said.contains(&format!("line {line}: ")), "{name}: {said}");
                if !text_value && !text[f.value.clone()].starts_with(['t', 'f']) {
                    for bad in ["-1e300", "1e300", "nan", "inf"] {
                        let said = refused(&replaced(text, &f.value, bad), line, &f.name, bad);
                        assert!(said.contains(&format!("line {line}: ")), "{name}: {said}");
                        tried += 1;
                    }
                }
                tried += 2;
            }
        }
    }
    assert!(tried > 800, "{tried}");
}

#[test]
fn every_required_field_is_missed_by_name() {
    let mut tried = 0;
    for (_, text) in SHIPPED {
        for f in all(text).iter().filter(|f| f.plain) {
            // Only lines that hold this field alone can be taken out.
            let start = text[..f.key.start].rfind('\n').map_or(0, |i| i + 1);
            let end = text[f.value.end..]
                .find('\n')
                .map_or(text.len(), |i| f.value.end + i);
            if text[start..f.key.start].trim().is_empty()
                && text[start..end].matches('=').count() == 1
            {
                let without = format!("{}{}", &text[..start], &text[end..]);
                if let Err(why) = scenario::parse("bad.toml", &without, None) {
                    let said = why.to_string();
                    assert!(
                        said.contains(&f.name) && said.contains("is missing (allowed: "),
                        "{said}"
                    );
                    tried += 1;
                }
            }
        }
    }
    assert!(tried > 100, "{tried}");
}

#[test]
fn what_no_single_field_shows_is_refused_too() {
    let base = SHIPPED
        .iter()
        .find(|s| s.0 == "helix-run-up")
        .expect("shipped")
        .1;
    let cases = [
        (
            "pitch_deg = [88, 92, 88, 92]",
            "pitch_deg = [88, 92, 88, 91]",
            "add up to 360",
        ),
        (
            "pitch_deg = [88, 92, 88, 92]",
            "pitch_deg = [180, 180]",
            "one for each of the 4 teeth",
        ),
        (
            "{ t_s = 1.0, speed_rpm = 4500 }",
            "{ t_s = 9.0, speed_rpm = 4500 }",
            "times that increase",
        ),
        ("speed_rpm = 7500", "speed_rpm = 75000", "half to twice"),
        ("cut = \"down\"", "cut = \"slot\"", "in a slot"),
        (
            "depth_mm = 5.0",
            "depth_mm = 5.0\ndepth = [{ t_s = 0, depth_mm = 1 }]",
            "one of the two",
        ),
        ("depth_mm = 5.0", "", "depth_mm is missing"),
        (
            "depth_mm = 5.0",
            "depth_mm = { at = 5.0 }",
            "depth_mm is a value of type",
        ),
        (
            "depth_mm = 5.0",
            "depth_mm = 5.0\nworkpiece = { from_mm = 0, to_mm = 9, slot = [{ from_mm = 1, to_mm = 2, y_from_mm = 3, y_to_mm = 3 }] }",
            "workpiece.slot[0].y_to_mm is 3 (allowed: more than y_from_mm)",
        ),
        (
            "depth_mm = 5.0",
            "depth_mm = 5.0\nworkpiece = { from_mm = 0, to_mm = 9, slot = [{ from_mm = 2, to_mm = 1 }] }",
            "workpiece.slot[0].to_mm is 1 (allowed: more than from_mm)",
        ),
        (
            "turn_rad_per_m = 60",
            "",
            "milling.mode[2].x is missing (allowed: one of x, y and turn_rad_per_m",
        ),
        ("turn_rad_per_m = 60", "x = 0", "milling.mode[2].x is 0"),
        ("[milling]", "[milling", "not TOML"),
        ("[milling.", "[grinding.", "grinding"),
    ];
    for (from, to, want) in cases {
        assert!(base.contains(from), "{from}");
        let said = scenario::parse("bad.toml", &base.replacen(from, to, 1), None)
            .expect_err(want)
            .to_string();
        assert!(
            said.contains(want) && !said.contains('\n'),
            "{want}: {said}"
        );
        assert!(said.starts_with("bad.toml: line "), "{said}");
    }
    let said = scenario::load("no-such-thing", None)
        .expect_err("none")
        .to_string();
    assert!(
        said.contains("no-such-thing: open: ") && said.contains("chatter-onset"),
        "{said}"
    );
}

#[test]
fn the_schema_describes_every_field_that_is_used() {
    let schema = scenario::schema();
    // The largest of any sample rate, not of the default one.
    let enclosure = &schema["properties"]["microphone"]["properties"]["enclosure"];
    let highest = enclosure["properties"]["f_hz"]["maximum"].as_f64();
    assert!(highest.is_some_and(|f| (f - 0.499 * 384_000.0).abs() < 1e-6));
    fn walk<'a>(schema: &'a serde_json::Value, table: &DeTable<'_>, path: &str) {
        for (key, value) in table {
            let mut entry: &'a serde_json::Value = &schema["properties"][key.get_ref().as_ref()];
            assert!(
                entry["description"].is_string(),
                "{path}.{key:?} is not described"
            );
            if entry["type"] == "array" {
                entry = &entry["items"];
            }
            match value.get_ref() {
                DeValue::Table(inner) => walk(entry, inner, key.get_ref()),
                DeValue::Array(items) => {
                    for item in items {
                        if let Some(inner) = item.get_ref().as_table() {
                            walk(entry, inner, key.get_ref());
                        }
                    }
                }
                _ => {}
            }
        }
    }
    for (_, text) in SHIPPED {
        walk(&schema, DeTable::parse(text).expect("TOML").get_ref(), "");
    }
    // The file beside the scenarios, for editors, is this one.
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/schema.json");
    let kept: serde_json::Value =
        serde_json::from_slice(&std::fs::read(path).expect(path)).expect("JSON");
    assert!(
        kept == schema,
        "write it again: rarma simulate --schema > {path}"
    );
}

const FS: f64 = 48_000.0;

fn rms(y: &[f64], from: f64, to: f64) -> f64 {
    let part = &y[(from * FS) as usize..(to * FS) as usize];
    (part.iter().map(|v| v * v).sum::<f64>() / part.len() as f64).sqrt()
}

#[test]
fn the_demonstration_is_what_it_says() {
    let scenario = scenario::load("chatter-onset", Some(1))
        .expect("shipped")
        .scenario;
    let truth = scenario.truth().expect("a truth");
    let (onset, end) = (truth.onset_s.expect("onset"), truth.end_s.expect("end"));
    let limit = truth.limit_depth_m().expect("limit");
    assert!((limit / 1.094e-3 - 1.0).abs() < 0.005, "{limit}");
    // Three teeth of six are always in: the force is nearly its mean.
    assert!((limit / truth.zero_order_m.expect("limit") - 1.0).abs() < 0.005);
    assert!((onset - 5.335).abs() < 0.02 && end > 8.0, "{onset} {end}");
    assert_eq!(truth.cut_s, Some((1.0, 8.1)));
    let order = truth.chatter_hz().expect("limit") / truth.spindle_hz;
    assert!(
        (order - order.round()).abs() * truth.spindle_hz > 8.0,
        "{order}"
    );

    let mut cut = VirtualCut::new(&scenario).expect("valid");
    let mut y = Vec::with_capacity(cut.len());
    let mut swing = [0.0_f64; 9];
    while let Some(reading) = cut.next() {
        y.push(f64::from(reading.value));
        let m = cut.machine();
        let second = &mut swing[(m.t as usize).min(8)];
        *second = second.max(m.position_m[0].hypot(m.position_m[1]));
    }
    assert_eq!((y.len(), cut.microphone().clipped()), (9 * 48_000, 0));
    // The stable cut is heard as broadband noise, micrometres of motion ...
    assert!(rms(&y, 2.0, 3.0) > 2.0 * rms(&y, 0.0, 1.0));
    assert!(swing[2] > 2e-6 && swing[2] < 40e-6, "{swing:?}");
    // ... chatter is tens of them, and no more.
    assert!(swing[7] > 2.0 * swing[2] && swing[7] < 300e-6, "{swing:?}");
    assert!(rms(&y, 7.0, 7.9) > 5.0 * rms(&y, 2.0, 3.0));
    let (early, late) = (rms(&y, 6.6, 7.2), rms(&y, 7.3, 7.9));
    assert!(
        (late / early - 1.0).abs() < 0.15,
        "not limited: {early} {late}"
    );
    assert!(rms(&y, 8.5, 9.0) < 0.5 * rms(&y, 2.0, 3.0));
    let peak = y.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    assert!(peak > 0.15 && peak < 0.7, "peak {peak}");
}

#[test]
fn units_arrive_as_si() {
    let scenario = scenario::load("helix-run-up", Some(3))
        .expect("shipped")
        .scenario;
    let Process::Milling(c) = &scenario.process else {
        panic!("a milling cut")
    };
    assert!((c.spindle_hz - 100.0).abs() < 1e-9 && (c.spindle_at(5.0) - 125.0).abs() < 1e-9);
    assert!((c.diameter_m - 0.016).abs() < 1e-12 && (c.feed_per_tooth_m - 8e-5).abs() < 1e-15);
    assert!((c.kt_n_per_m2 - 8e8).abs() < 1.0 && (c.kt_edge_n_per_m - 1e4).abs() < 1e-6);
    assert!((c.helix_rad - 30f64.to_radians()).abs() < 1e-12 && c.pitch_rad.len() == 4);
    assert!((c.modes_x[0].stiffness_n_per_m - 8e6).abs() < 1e-3);
    assert_eq!(
        (c.modes_x.len(), c.modes_y.len(), c.modes_other.len()),
        (1, 1, 1)
    );
    assert_eq!((c.seed, scenario.microphone.seed), (3, 4));
}
