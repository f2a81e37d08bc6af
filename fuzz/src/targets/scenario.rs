//! Scenarios: TOML files of every kind, and records of the exciter.

use crate::{Target, check, scratch};
use rarma_scenarios::{ScenarioError, scenario};
use serde_json::Value;

pub(super) const CUT: Target = Target {
    name: "cut",
    reads: "scenarios of the virtual machine tool",
    run: |bytes| toml(bytes, |name| scenario::load(name, None)),
    words: || names(&[scenario::schema()]),
};

pub(super) const BOX: Target = Target {
    name: "box",
    reads: "scenarios of the box",
    run: |bytes| toml(bytes, |name| scenario::load_box(name, None)),
    words: || {
        let mut all = names(&[scenario::box_schema()]);
        all.extend(super::words::said());
        all
    },
};

pub(super) const RIGS: Target = Target {
    name: "rigs",
    reads: "scenarios of cers, ldbb and els",
    run: |bytes| {
        toml(bytes, scenario::load_cers);
        toml(bytes, scenario::load_ldbb);
        toml(bytes, scenario::load_els);
    },
    words: || {
        names(&[
            scenario::cers_schema(),
            scenario::ldbb_schema(),
            scenario::els_schema(),
        ])
    },
};

pub(super) const EXCITER_RECORD: Target = Target {
    name: "exciter-record",
    reads: "records of the exciter: notes and signals",
    run: |bytes| {
        // The notes, and from the first RIFF on the signals.
        let at = bytes.windows(4).position(|w| w == b"RIFF");
        let (notes, signals) = bytes.split_at(at.unwrap_or(bytes.len()));
        scratch::file("record.toml", notes);
        scratch::file("signals.wav", signals);
        notes_again(notes);
        let folder = scratch::folder();
        if let Err(why) = scenario::read_cers(&folder) {
            let line = why.to_string();
            let file = ["record.toml", "signals.wav"]
                .map(|name| folder.join(name))
                .into_iter()
                .find(|path| line.starts_with(&format!("{}: ", path.display())));
            check::refusal(&file.unwrap_or(folder), &why);
        }
    },
    words: || {
        let mut all = names(&[scenario::record_schema()]);
        all.extend(["RIFF", "WAVE", "fmt ", "data"].map(str::to_owned));
        all
    },
};

/// Notes that are read can be written, and say the same.
fn notes_again(notes: &[u8]) {
    let Ok(text) = std::str::from_utf8(notes) else {
        return;
    };
    if let Ok(setup) = scenario::parse_record("record.toml", text) {
        let again = scenario::parse_record("record.toml", &setup.text());
        assert_eq!(again.as_ref(), Ok(&setup), "{}", setup.text());
    }
}

fn toml<V>(bytes: &[u8], load: impl Fn(&str) -> Result<V, ScenarioError>) {
    let path = scratch::file("case.toml", bytes);
    let name = path.to_str().expect("a temporary folder's name is text");
    if let Err(why) = load(name) {
        check::refusal(&path, &why);
    }
}

/// Every name and every word of a choice in schemas.
fn names(schemas: &[Value]) -> Vec<String> {
    let mut out: Vec<String> = ["inf", "nan", "1e308", "-0.0", "[[", "]]\n", "true", "0x7f"]
        .map(str::to_owned)
        .to_vec();
    schemas.iter().for_each(|schema| collect(schema, &mut out));
    out
}

fn collect(schema: &Value, out: &mut Vec<String>) {
    if let Some(properties) = schema["properties"].as_object() {
        for (name, inner) in properties {
            out.push(format!("{name} = "));
            out.push(format!("{name}]\n"));
            collect(inner, out);
        }
    }
    if let Some(words) = schema["enum"].as_array() {
        out.extend(words.iter().map(|word| format!("{word}\n")));
    }
    if schema["items"].is_object() {
        collect(&schema["items"], out);
    }
}
