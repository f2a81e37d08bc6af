//! Promise: `rarma order` finds the order of a simulated model and gives every
//! candidate with its criteria; `rarma psd` gives densities that integrate to the
//! variance and peak where the modes are; every method of `rarma identify` finds
//! the mode of a series.

use host_tests::files::Folder;
use host_tests::process::Ended;
use host_tests::{rarma, signal};
use serde_json::Value;
use std::path::{Path, PathBuf};

const FS: f64 = 5000.0;
const F_HZ: f64 = 980.0;
const ZETA: f64 = 0.02;

fn one_mode(folder: &Folder, samples: usize) -> PathBuf {
    let x: Vec<f64> = signal::modes(&[(F_HZ, ZETA)], FS, 11)
        .take(samples)
        .collect();
    folder.raw("mode.f64", &x)
}

fn say(command: &str, file: &Path, options: &str) -> Ended {
    rarma!().on(command, file, &format!("--fs {FS} {options}"))
}

fn object(command: &str, file: &Path, options: &str) -> Value {
    let ended = say(command, file, &format!("{options} --json"));
    let mut lines = ended.json_lines();
    assert_eq!(lines.len(), 1, "{command} {options}: one object");
    lines.remove(0)
}

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().expect("a list");
    list.iter().map(|x| x.as_f64().expect("a number")).collect()
}

#[test]
fn order_of_a_sampled_mode_is_chosen() {
    let folder = Folder::default();
    let file = one_mode(&folder, 5000);
    for criterion in ["bic", "aic", "aicc", "fpe"] {
        let found = object("order", &file, &format!("--max 4 --criterion {criterion}"));
        assert_eq!(found["criterion"], criterion);
        let candidates = found["candidates"].as_array().expect("candidates");
        assert_eq!(candidates.len(), 8);
        // The choice is the least of what is printed.
        let least = candidates
            .iter()
            .min_by(|x, y| {
                let of = |c: &Value| c[criterion].as_f64().expect("a number");
                of(x).total_cmp(&of(y))
            })
            .expect("candidates");
        assert_eq!(found["choice"], least["order"]);
        if criterion == "bic" {
            assert_eq!(found["choice"], serde_json::json!([2, 1]));
        }
    }
}

#[test]
fn order_shows_the_modes_of_every_candidate() {
    let folder = Folder::default();
    let file = one_mode(&folder, 5000);
    let found = object("order", &file, "--max 4");
    let candidates = found["candidates"].as_array().expect("candidates");
    for candidate in candidates {
        let p = candidate["order"][0].as_u64().expect("p");
        let modes = candidate["modes"].as_array().expect("modes");
        assert!(modes.len() as u64 <= p / 2, "{candidate}");
        for mode in modes {
            assert!(
                mode["f"].is_number() && mode["zeta"].is_number(),
                "{candidate}"
            );
            assert!(mode["stable"].is_boolean() && mode["stable_f"].is_boolean());
        }
        let true_one = |m: &&Value| (m["f"].as_f64().expect("f") - F_HZ).abs() < 10.0;
        if p == 2 {
            assert!(
                modes
                    .iter()
                    .find(true_one)
                    .is_some_and(|m| m["stable"] == false)
            );
        }
        if candidate["order"] == serde_json::json!([3, 2]) {
            assert!(
                modes
                    .iter()
                    .find(true_one)
                    .is_some_and(|m| m["stable"] == true),
                "{candidate}"
            );
        }
    }
    let ended = say("order", &file, "--max 3");
    assert!(
        ended.stdout.contains("%**") && ended.stdout.contains("Choice by bic"),
        "{}",
        ended.stdout
    );
}

#[test]
fn densities_integrate_to_the_variance_and_peak_at_the_mode() {
    let folder = Folder::default();
    let file = one_mode(&folder, 20_000);
    let x: Vec<f64> = signal::modes(&[(F_HZ, ZETA)], FS, 11)
        .take(20_000)
        .collect();
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    let variance = x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / x.len() as f64;
    for (options, tolerance) in [
        ("--method periodogram", 1e-6),
        ("--method welch", 0.1),
        ("--method ar --order 8,0", 0.1),
        ("--method arma --order 2,1", 0.1),
    ] {
        let found = object("psd", &file, options);
        let (f, psd) = (numbers(&found["f"]), numbers(&found["psd"]));
        assert_eq!(f.len(), psd.len());
        let power: f64 = psd.iter().sum::<f64>() * (f[1] - f[0]);
        assert!(
            (power / variance - 1.0).abs() < tolerance,
            "{options}: {power} {variance}"
        );
        assert_eq!((f[0], *f.last().expect("not empty")), (0.0, FS / 2.0));
        if !options.contains("periodogram") {
            let top = (0..f.len()).max_by(|&i, &j| psd[i].total_cmp(&psd[j]));
            let peak = f[top.expect("not empty")];
            assert!((peak - F_HZ).abs() < 25.0, "{options}: peak at {peak} Hz");
        }
        // One frequency alone gives what the grid gives there.
        let k = f.len() / 3;
        let alone = object("psd", &file, &format!("{options} --at {}", f[k]));
        let value = numbers(&alone["psd"])[0];
        assert!((value / psd[k] - 1.0).abs() < 1e-6, "{options} at {}", f[k]);
    }
}

#[test]
fn every_method_finds_the_mode() {
    let folder = Folder::default();
    let file = one_mode(&folder, 20_000);
    for (method, order, tolerance) in [
        ("pem", "2,1", 0.25),
        ("ml", "2,1", 0.25),
        ("rpem", "2,1", 0.25),
        ("rplr", "2,1", 0.25),
        ("gradient", "2,1", 0.25),
        ("riv", "2,1", 0.25),
        ("iv", "2,1", 0.5),
        ("burg", "20,0", 0.5),
        ("yule-walker", "20,0", 0.8),
        ("least-squares", "20,0", 0.5),
        ("lattice", "20,0", 0.5),
    ] {
        let found = object(
            "identify",
            &file,
            &format!("--order {order} --method {method}"),
        );
        assert_eq!(found["method"], method);
        let modes = found["modes"].as_array().expect("modes");
        // A long autoregressive model has strongly damped modes everywhere besides.
        let of = |m: &Value, key: &str| m[key].as_f64().expect("a number");
        let near = modes
            .iter()
            .filter(|m| (of(m, "f") - F_HZ).abs() < 10.0)
            .min_by(|x, y| of(x, "zeta").total_cmp(&of(y, "zeta")))
            .unwrap_or_else(|| panic!("{method}: no mode near {F_HZ} Hz in {found}"));
        let zeta = near["zeta"].as_f64().expect("zeta");
        assert!(
            (zeta / ZETA - 1.0).abs() < tolerance,
            "{method}: ζ = {zeta}"
        );
        let sd = near["zeta_sd"].as_f64().expect("zeta_sd");
        assert!((1e-4..0.02).contains(&sd), "{method}: sd = {sd}");
    }
}

#[test]
fn wrong_use_is_refused() {
    let folder = Folder::default();
    let file = one_mode(&folder, 2000);
    for (command, options) in [
        ("identify", "--order 4,2 --method burg"),
        ("identify", "--order 31,0"),
        ("psd", "--method arma"),
        ("psd", "--method ar --order 4,1"),
        ("psd", "--method welch --at 4000"),
        ("psd", ""),
        ("order", "--max 0"),
        ("order", "--criterion none"),
    ] {
        let ended = say(command, &file, options);
        assert_eq!(ended.code, Some(2), "{command} {options}: {ended:?}");
        assert!(ended.stdout.is_empty());
    }
    let short = folder.raw("short.f64", &[1.0, 2.0, 1.5, 0.5, 1.0, 2.0, 0.0]);
    for (command, options) in [("identify", "--order 8,7"), ("order", "--max 4")] {
        let ended = say(command, &short, options);
        assert_eq!(ended.code, Some(3), "{command} {options}: {ended:?}");
        assert!(ended.stderr.contains("too few"), "{ended:?}");
    }
}

/// The pages hold what they promise, every number in their pictures is one, and the method that was
/// asked for stands among the others as in the table of modes.
#[test]
fn pages_of_order_and_identify() {
    let folder = Folder::default();
    let file = one_mode(&folder, 5000);
    let page = |command: &str, options: &str| -> String {
        let out = folder.path().join("page");
        let words = format!("{options} --report {}", out.display());
        let ended = say(command, &file, &words);
        assert_eq!(ended.code, Some(0), "{ended:?}");
        let html = std::fs::read_to_string(out.join("index.html")).expect("a page");
        for path in html.split(" d=\"").skip(1) {
            let path = path.split('"').next().expect("a path");
            assert!(!path.contains("NaN") && !path.contains("inf"), "{path}");
        }
        html
    };
    let common = ["Stabilisation diagram", "Power spectral density"];
    let residuals = "Autocorrelation of the residuals";
    let of_order = page("order", "--max 6");
    for title in common.iter().chain(&["Criteria over orders", residuals]) {
        assert!(of_order.contains(title), "{title}");
    }
    // The column at the mode: one upright dashed stroke at least, and its row in the table.
    assert!(of_order.contains("column that orders agree on"));
    assert!(of_order.contains("stable in"));

    let memory = "--order 2,1 --method rpem --forgetting 0.999";
    let of_identify = page("identify", memory);
    for title in common.iter().chain(&["Damping by method", residuals]) {
        assert!(of_identify.contains(title), "{title}");
    }
    let zeta_sd = |options: &str| {
        let found = object("identify", &file, options);
        found["modes"][0]["zeta_sd"].as_f64().expect("a deviation")
    };
    // Its row among the methods has the deviation of a memory of 1000 samples, not of all 5000.
    let (asked, whole) = (zeta_sd(memory), zeta_sd("--order 2,1 --method rpem"));
    assert!(asked > 1.4 * whole, "{asked} {whole}");
    let row = of_identify.split("<td>rpem (2,1)").nth(1).expect("a row");
    let row = row.split("</tr>").next().expect("its end");
    let told = format!("± {:.2} %", 100.0 * asked);
    assert!(row.contains(&told), "{told}: {row}");
}
