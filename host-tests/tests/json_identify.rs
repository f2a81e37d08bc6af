//! Promise: `rarma identify --json` says what docs/interfaces.md lists, field by field,
//! and nothing else, and its figures are as sure as it says.

use host_tests::bound::Bound;
use host_tests::files::Folder;
use host_tests::json::{keys, number, numbers, word};
use host_tests::{rarma, signal};

#[test]
fn identify_says_every_field_at_every_kind_of_order() {
    let folder = Folder::default();
    let x: Vec<f64> = signal::modes(&[(980.0, 0.02), (1700.0, 0.03)], 5000.0, 3)
        .map(|x| 7.0 + x)
        .take(10_000)
        .collect();
    let file = folder.raw("modes.f64", &x);
    for (p, q) in [
        (0usize, 3usize),
        (5, 0),
        (30, 29),
        (2, 1),
        (4, 3),
        (1, 2),
        (0, 0),
        (3, 7),
    ] {
        for method in ["rpem", "rplr", "gradient", "riv"] {
            let options = format!("--fs 5000 --order {p},{q} --method {method} --json");
            let ended = rarma!().on("identify", &file, &options);
            if method == "riv" && p == 0 && q > 0 {
                // Instruments are for A: without one there is nothing to estimate.
                assert_eq!(
                    (ended.code, ended.stdout.as_str()),
                    (Some(3), ""),
                    "{options}"
                );
                assert!(ended.stderr.contains("riv"), "{options}: {ended:?}");
                continue;
            }
            assert_eq!(
                (ended.code, ended.stderr.as_str()),
                (Some(0), ""),
                "{options}"
            );
            let lines = ended.json_lines();
            let [model] = &lines[..] else {
                panic!("{options}: {} lines", lines.len());
            };
            assert_eq!(
                keys(model),
                [
                    "a",
                    "aic",
                    "band",
                    "bic",
                    "c",
                    "fpe",
                    "fs",
                    "mean",
                    "method",
                    "modes",
                    "n",
                    "order",
                    "sigma2",
                    "whiteness_p"
                ]
            );
            assert_eq!(word(model, "method"), method);
            assert_eq!(model["order"], serde_json::json!([p, q]));
            assert_eq!(
                (numbers(&model["a"]).len(), numbers(&model["c"]).len()),
                (p, q)
            );
            assert_eq!(
                (number(model, "fs"), number(model, "n")),
                (5000.0, 10_000.0)
            );
            assert!(model["band"].is_null());
            assert!((number(model, "mean") - 7.0).abs() < 0.2);
            assert!(number(model, "sigma2") > 0.0 && number(model, "fpe") > 0.0);
            assert!(number(model, "bic") >= number(model, "aic"));
            assert!((0.0..=1.0).contains(&number(model, "whiteness_p")));
            let modes = model["modes"].as_array().expect("modes");
            assert!(modes.len() <= p / 2);
            let f: Vec<f64> = modes.iter().map(|m| number(m, "f")).collect();
            assert!(f.is_sorted(), "{options}: {f:?}");
            for mode in modes {
                assert_eq!(keys(mode), ["f", "f_sd", "zeta", "zeta_sd"]);
                // Instruments at an order that is not the signal's may end in a model that
                // has no bound (roots on or outside the unit circle): null, both.
                let has_bound = method != "riv" || (p, q) == (4, 3);
                if !has_bound && mode["f_sd"].is_null() {
                    assert!(mode["zeta_sd"].is_null(), "{options}: {mode}");
                } else {
                    assert!(number(mode, "f_sd") >= 0.0 && number(mode, "zeta_sd") >= 0.0);
                }
                number(mode, "zeta");
            }
        }
    }
}

#[test]
fn identify_recovers_a_known_model_within_its_uncertainty() {
    let folder = Folder::default();
    let modes = [(700.0, 0.05), (1500.0, 0.04)];
    let a = signal::polynomial(&modes, 5000.0);
    let c = [0.5, -0.3, 0.1];
    let n = 50_000;
    let file = folder.raw("arma.f64", &signal::arma(&a, &c, n, 11));
    let ended = rarma!().on("identify", &file, "--fs 5000 --order 4,3 --json");
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let model = &ended.json_lines()[0];
    let bound = Bound::of(&a, &c);
    let found = [numbers(&model["a"]), numbers(&model["c"])].concat();
    for (i, (found, truth)) in found.iter().zip(a.iter().chain(&c)).enumerate() {
        let sd = bound.parameter(i, n as f64);
        let off = (found - truth) / sd;
        println!("parameter {i}: {found:.5} for {truth:.5}, {off:+.2} sd");
        assert!(
            off.abs() < 4.0,
            "parameter {i} is {found}, not {truth} ± {sd}"
        );
    }
    assert!((number(model, "sigma2") - 1.0).abs() < 4.0 * (2.0 / n as f64).sqrt());
    assert!(number(model, "whiteness_p") > 1e-4);
    for (mode, (f, zeta)) in model["modes"].as_array().expect("modes").iter().zip(modes) {
        let limit = bound.mode(f, zeta, 5000.0);
        let root_n = (n as f64).sqrt();
        assert!((number(mode, "f") - f).abs() < 4.0 * limit.frequency / root_n);
        assert!((number(mode, "zeta") - zeta).abs() < 4.0 * limit.damping / root_n);
        // The stated uncertainty is the true one.
        let stated = number(mode, "zeta_sd") / (limit.damping / root_n);
        assert!(
            (0.8..1.25).contains(&stated),
            "zeta_sd is {stated} of the bound"
        );
        let stated = number(mode, "f_sd") / (limit.frequency / root_n);
        assert!(
            (0.8..1.25).contains(&stated),
            "f_sd is {stated} of the bound"
        );
    }
}
