//! Promise: a reader of universal files that is not ours finds in the export what is in the
//! table beside it.

use host_tests::files::Folder;
use host_tests::rarma;
use host_tests::resources::python_packages_or_skip;
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// Rows of the table of one response: Hz, m/N.
fn table(text: &str, force: &str, motion: &str) -> Vec<[f64; 3]> {
    text.lines()
        .skip(1)
        .map(|line| line.split(',').collect::<Vec<_>>())
        .filter(|cells| cells[..3] == [force, motion, "displacement"])
        .map(|cells| [3, 4, 5].map(|k| cells[k].parse().expect("a number")))
        .collect()
}

#[test]
fn pyuff_reads_the_responses_that_the_table_holds() {
    let Some(packages) = python_packages_or_skip("cers_uff") else {
        return;
    };
    let folder = Folder::default();
    let at = |name: &str| folder.path().join(name);
    let text = |path: &Path| path.to_str().expect("a path").to_owned();
    let (uff, csv) = (at("r.uff"), at("r.csv"));
    let words = ["cers", "run", "cers-rest", "--quick", "--json"].map(str::to_owned);
    let words = words.into_iter().chain([
        "--uff".to_owned(),
        text(&uff),
        "--csv".to_owned(),
        text(&csv),
    ]);
    let ended = rarma!().run(words);
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/read_uff.py");
    let read = Command::new("python3")
        .env("PYTHONPATH", packages)
        .arg(script)
        .arg(&uff)
        .output()
        .expect("python3");
    assert!(read.status.success(), "{read:?}");
    let sets: Vec<Value> = serde_json::from_slice(&read.stdout).expect("JSON");
    assert_eq!(sets.len(), 4);
    let csv = std::fs::read_to_string(&csv).expect("a table");
    let mut largest = 0.0f64;
    for set in &sets {
        // Frequency response, displacement over excitation force.
        let kind = ["func_type", "numerator", "denominator"].map(|k| set[k].as_i64());
        assert_eq!(kind, [Some(4), Some(8), Some(13)]);
        let axis = |key: &str| match set[key].as_i64() {
            Some(1) => "x",
            Some(2) => "y",
            other => panic!("{key}: {other:?}"),
        };
        let rows = table(&csv, axis("ref_dir"), axis("rsp_dir"));
        let list = |key: &str| -> Vec<f64> {
            let list = set[key].as_array().expect("a list");
            list.iter().filter_map(Value::as_f64).collect()
        };
        let (f, re, im) = (list("f"), list("re"), list("im"));
        assert!(rows.len() > 100 && rows.len() == f.len());
        for (k, [hz, real, imaginary]) in rows.iter().enumerate() {
            // The format gives five decimals to the first frequency and to the step.
            assert!((f[k] / hz - 1.0).abs() < 5e-6, "{} {hz}", f[k]);
            let off = (re[k] - real).hypot(im[k] - imaginary) / real.hypot(*imaginary);
            largest = largest.max(off);
            assert!(off < 1e-9, "{hz} Hz: {off}");
        }
    }
    println!("{} sets, largest difference {largest:.1e}", sets.len());
}
