//! Promise: receptances come in from universal files and tables alike, and what is wrong
//! with them is one line with exit code 3.
//!
//! `cargo test --release -p host-tests --test els_input -- --nocapture`

use host_tests::files::Folder;
use host_tests::process::{Ended, Rarma};
use host_tests::rarma;
use rarma_rigs::els::{Complex, Receptance};
use std::path::Path;

fn program() -> Rarma {
    rarma!()
}

fn g(f: f64) -> Receptance<f64> {
    let mode = |f0: f64, k: f64| {
        let r = f / f0;
        Complex::new(1.0 - r * r, 0.06 * r).scale(k).inverse()
    };
    Receptance::of_mode(mode(1074.0, 11e6), 0.4).plus(&Receptance::of_mode(mode(1500.0, 18e6), 2.2))
}

/// A table with all four; `unit` metres a unit of it.
fn table(unit: &str, scale: f64, grid: impl Fn(u32) -> f64) -> String {
    let mut out = String::from("freq_hz");
    for role in ["uu", "uv", "vu", "vv"] {
        out += &format!(",{role}_re_{unit}_per_N,{role}_im_{unit}_per_N");
    }
    for k in 0..1001 {
        let f = grid(k);
        let t = g(f);
        out += &format!("\n{f}");
        for z in [
            t.resp_u_exc_u,
            t.resp_u_exc_v,
            t.resp_v_exc_u,
            t.resp_v_exc_v,
        ] {
            out += &format!(",{:e},{:e}", z.re / scale, z.im / scale);
        }
    }
    out
}

fn even(k: u32) -> f64 {
    200.0 + 2.0 * f64::from(k)
}

fn limit(file: &Path, options: &str) -> Ended {
    let words = options.split_whitespace().map(std::ffi::OsStr::new);
    let start = ["els", "limit"].map(std::ffi::OsStr::new);
    program().run(start.into_iter().chain([file.as_os_str()]).chain(words))
}

fn refused(ended: &Ended, file: &Path, words: &[&str]) {
    assert_eq!(ended.code, Some(3), "{ended:?}");
    assert_eq!(ended.stdout, "", "{ended:?}");
    let lines: Vec<&str> = ended.stderr.lines().collect();
    let [line] = lines[..] else {
        panic!("not one line: {ended:?}")
    };
    println!("{line}");
    assert!(line.contains(&file.display().to_string()), "{line}");
    for word in words {
        assert!(line.contains(word), "{line} does not say `{word}`");
    }
}

#[test]
fn table_and_universal_file_say_the_same() {
    let folder = Folder::default();
    let csv = folder.file("a.csv", table("m", 1.0, even).as_bytes());
    let uff = folder.path().join("a.uff");
    let to = format!("--json --chip-angle 60 --uff {}", uff.display());
    let first = limit(&csv, &to).json();
    let second = limit(&uff, "--json --chip-angle 60").json();
    assert_eq!(first["measured"], second["measured"]);
    let um = folder.file("um.csv", table("um", 1e-6, even).as_bytes());
    let third = limit(&um, "--json --chip-angle 60").json();
    // An uneven grid is written line by line.
    let uneven = folder.file(
        "u.csv",
        table("m", 1.0, |k| even(k) + 1e-3 * f64::from(k * k)).as_bytes(),
    );
    let uneven_uff = folder.path().join("u.uff");
    let fourth = limit(&uneven, &format!("--json --uff {}", uneven_uff.display())).json();
    let fifth = limit(&uneven_uff, "--json").json();
    let width = |v: &serde_json::Value, k: usize| v["polar"][k]["width_mm"].as_f64();
    for k in 0..72 {
        let near = |a: Option<f64>, b: Option<f64>, within: f64| match (a, b) {
            (Some(a), Some(b)) => assert!((a / b - 1.0).abs() < within, "{k}: {a} {b}"),
            (a, b) => assert_eq!(a, b, "{k}"),
        };
        near(width(&first, k), width(&second, k), 1e-9);
        near(width(&first, k), width(&third, k), 1e-9);
        // The format keeps an uneven abscissa in six digits.
        near(width(&fourth, k), width(&fifth, k), 1e-4);
    }
    assert!(first["reciprocity"].as_f64().expect("both") < 1e-12);
}

#[test]
fn what_is_wrong_is_one_line() {
    let folder = Folder::default();
    let good = folder.file("good.csv", table("m", 1.0, even).as_bytes());
    let other = folder.file(
        "v.csv",
        b"freq_hz,re_m_per_N,im_m_per_N\n1,1e-8,0\n2,1e-8,0\n3,1e-8,0\n4,1e-8,0\n",
    );
    let u = folder.file(
        "u.csv",
        b"freq_hz,re_m_per_N,im_m_per_N\n1,1e-8,0\n3,1e-8,0\n5,1e-8,0\n7,1e-8,0\n",
    );
    let both = program().run([
        "els",
        "limit",
        "--uu",
        &u.display().to_string(),
        "--vv",
        &other.display().to_string(),
    ]);
    refused(&both, &other, &["another grid", "one grid"]);
    let mixed = folder.file(
        "mixed.csv",
        b"freq_hz,uu_re_m_per_N,uu_im_um_per_N\n1,1,1\n2,1,1\n3,1,1\n",
    );
    refused(&limit(&mixed, ""), &mixed, &["units disagree", "line 1"]);
    let text = table("m", 1.0, even).replace("uu_re_m_per_N", "uu_re_furlong_per_N");
    let strange = folder.file("strange.csv", text.as_bytes());
    refused(
        &limit(&strange, ""),
        &strange,
        &["furlong", "names no part and unit"],
    );
    let back = folder.file("back.csv", table("m", 1.0, |k| 3000.0 - even(k)).as_bytes());
    refused(&limit(&back, ""), &back, &["does not rise"]);
    let text = table("m", 1.0, even).replacen("1.", "x.", 1);
    let word = folder.file("word.csv", text.as_bytes());
    refused(&limit(&word, ""), &word, &["is not a number"]);
    // A universal file whose labels contradict its units dataset.
    let uff = folder.path().join("good.uff");
    assert_eq!(
        limit(&good, &format!("--uff {}", uff.display())).code,
        Some(0)
    );
    let text = std::fs::read_to_string(&uff).expect("written");
    let factor = "1.00000000000000000E+00";
    let wrong = folder.file(
        "units.uff",
        text.replacen(factor, "1.00000000000000000E+03", 1)
            .as_bytes(),
    );
    refused(
        &limit(&wrong, ""),
        &wrong,
        &["units disagree", "dataset 164"],
    );
    let cut = text[..text.len() / 3].rfind('\n').expect("a line") + 1;
    let half = folder.file("half.uff", &text.as_bytes()[..cut]);
    refused(&limit(&half, ""), &half, &["ends inside a dataset"]);
    let word = folder.file("word.uff", &text.as_bytes()[..cut + 17]);
    refused(&limit(&word, ""), &word, &["is not a number"]);
    let missing = folder.path().join("nowhere.uff");
    refused(&limit(&missing, ""), &missing, &["no such file"]);
    // No line where the static stiffness was asked for.
    refused(
        &limit(&good, "--static 20:150"),
        &good,
        &["too few lines: 6 are needed", "from 200 to 2200 Hz"],
    );
    // Usage.
    assert_eq!(limit(&good, "--overlap 1.5").code, Some(2));
    assert_eq!(program().run(["els", "limit"]).code, Some(2));
}

#[test]
fn systems_that_cannot_be_are_one_line() {
    let folder = Folder::default();
    let text = include_str!("../../rarma-scenarios/scenarios/els-load-bar.toml");
    let run = |name: &str, text: &str| {
        let file = folder.file(name, text.as_bytes());
        let shown = file.display().to_string();
        (program().run(["els", "model", &shown]), file)
    };
    let (ended, file) = run(
        "stiff.toml",
        &text.replacen("major_n_per_um = 90", "major_n_per_um = -90", 1),
    );
    refused(&ended, &file, &["major_n_per_um is -90", "from 0.000001"]);
    let (ended, file) = run("turns.toml", &text.replace("twist_n_m_per_mrad = 20\n", ""));
    refused(&ended, &file, &["singular assembly: 1 rigid motion"]);
    let (ended, file) = run("bore.toml", &text.replace("inner_mm = 40", "inner_mm = 90"));
    refused(&ended, &file, &["inner_mm is not below outer_mm"]);
    let (ended, file) = run("name.toml", &text.replace("outer_mm = 53", "outre_mm = 53"));
    refused(&ended, &file, &["outre_mm is no known name"]);
    let loads = folder.file(
        "loads.csv",
        b"angle_deg,load_n,deflection_um\n0,100,5\n0,200,10\n",
    );
    let fit = |unknown: &str| {
        let loads = loads.display().to_string();
        program().run([
            "els",
            "fit",
            "els-load-bar",
            "--unknown",
            unknown,
            "--loads",
            &loads,
        ])
    };
    refused(&fit("joint.0"), &loads, &["at least 3 in one"]);
    assert_eq!(fit("spring.0").code, Some(2));
}
