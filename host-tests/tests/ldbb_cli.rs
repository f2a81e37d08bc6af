//! Promise: `rarma ldbb` reads what it writes, and what is wrong with readings is one line
//! with exit code 3.
//!
//! `cargo test --release -p host-tests --test ldbb_cli -- --nocapture`

use host_tests::files::Folder;
use host_tests::process::{Ended, Rarma};
use host_tests::rarma;
use rarma_scenarios::scenario::{SHIPPED_LDBB, ldbb_schema, parse_ldbb};
use serde_json::Value;
use std::ffi::OsStr;
use std::fmt::Write as _;
use std::path::Path;

/// A file of text in a folder.
trait Text {
    fn text(&self, name: &str, text: &str) -> std::path::PathBuf;
}

impl Text for Folder {
    fn text(&self, name: &str, text: &str) -> std::path::PathBuf {
        self.file(name, text.as_bytes())
    }
}

fn program() -> Rarma {
    rarma!()
}

fn ldbb(words: &[&OsStr]) -> Ended {
    program().run(
        [OsStr::new("ldbb")]
            .into_iter()
            .chain(words.iter().copied()),
    )
}

fn json(ended: &Ended) -> Value {
    assert_eq!(ended.code, Some(0), "{ended:?}");
    ended.json()
}

fn number(value: &Value, pointer: &str) -> f64 {
    value
        .pointer(pointer)
        .and_then(Value::as_f64)
        .unwrap_or_else(|| panic!("no {pointer}"))
}

fn refused(ended: &Ended, file: &Path, words: &[&str]) {
    assert_eq!(ended.code, Some(3), "{ended:?}");
    assert_eq!(ended.stdout, "", "{ended:?}");
    let lines: Vec<&str> = ended.stderr.lines().collect();
    let [line] = lines[..] else {
        panic!("not one line: {ended:?}")
    };
    println!("{line}");
    let name = file.file_name().and_then(OsStr::to_str).expect("a name");
    assert!(line.contains(name), "{line}");
    for word in words {
        assert!(line.contains(word), "no `{word}` in: {line}");
    }
}

const HEAD: &str = "# machine = T1\n# feed_mm_min = 1000\nangle_deg,dr_um,dir,way,run,p_bar,F_N";

/// Circles of a machine of 10 N/µm, one reading a degree.
fn table(runs: &[(&str, f64)]) -> String {
    let mut out = HEAD.to_owned();
    for (k, (dir, force)) in runs.iter().enumerate() {
        let p = (force + 14.0) / 126.0;
        for i in 0..360 {
            let deg = if *dir == "ccw" { i } else { 360 - i };
            let theta = f64::from(deg).to_radians();
            let dr = 0.1 * force + 2.0 * (2.0 * theta).cos();
            let _ = write!(out, "\n{deg},{dr:.4},{dir},up,{k},{p:.4},{force}");
        }
    }
    out
}

const SOUND: [(&str, f64); 6] = [
    ("ccw", 36.0),
    ("cw", 36.0),
    ("ccw", 364.0),
    ("cw", 364.0),
    ("ccw", 868.0),
    ("cw", 868.0),
];

#[test]
fn a_table_by_hand() {
    let folder = Folder::default();
    let file = folder.text("t1.csv", &table(&SOUND));
    let all = json(&ldbb(&[
        OsStr::new("analyse"),
        file.as_os_str(),
        OsStr::new("--json"),
    ]));
    assert_eq!(all["machine"], "T1");
    let mean = number(&all, "/findings/stiffness/mean_n_per_um");
    assert!((mean - 10.0).abs() < 1e-3, "{mean}");
    // 2 µm of cos 2θ: 8 µm of travel.
    let mismatch = number(&all, "/findings/errors/0/scale_mismatch_um/value");
    assert!((mismatch - 8.0).abs() < 1e-2, "{mismatch}");
    let g = number(&all, "/findings/errors/0/circular_um");
    assert!((g - 4.0).abs() < 0.01, "{g}");
    // Half a newton a micrometre less in the bar.
    let words = ["analyse", "--json", "--bar-compliance", "0.005"].map(OsStr::new);
    let bare = json(&ldbb(&[&words[..], &[file.as_os_str()]].concat()));
    let mean = number(&bare, "/findings/stiffness/mean_n_per_um");
    assert!((mean - 1.0 / 0.095).abs() < 1e-3, "{mean}");
}

#[test]
fn bad_input_is_one_line() {
    let folder = Folder::default();
    let check = |name: &str, text: String, words: &[&str]| {
        let file = folder.text(name, &text);
        refused(
            &ldbb(&[OsStr::new("analyse"), file.as_os_str()]),
            &file,
            words,
        );
    };
    let sound = || table(&SOUND);
    check(
        "gap.csv",
        sound()
            .replacen("\n90,", "\n#90,", 1)
            .replacen("\n91,", "\n#", 1)
            .replacen("\n92,", "\n#", 1)
            .replacen("\n93,", "\n#", 1)
            .replacen("\n94,", "\n#", 1)
            .replacen("\n95,", "\n#", 1),
        &["line ", "a gap of 7.0°", "run 0"],
    );
    check(
        "hole.csv",
        sound().replacen("\n13,", "\n13", 1),
        &["line 17", "column 7"],
    );
    check(
        "empty-line.csv",
        sound().replacen("\n40,", "\n\n40,", 1),
        &["an empty line in the middle"],
    );
    check(
        "units.csv",
        sound().replace("dr_um", "dr_inch"),
        &["line 3, column 2", "unknown unit in dr_inch", "dr_um"],
    );
    check(
        "pressure.csv",
        sound().replace("p_bar", "p_psi"),
        &["unknown unit in p_psi", "p_bar"],
    );
    check(
        "columns.csv",
        sound().replace("F_N", "load"),
        &["there is no column F_N"],
    );
    check(
        "order.csv",
        sound()
            .replacen("\n50,", "\n49.5,", 1)
            .replacen("\n49,", "\n50.2,", 1),
        &["angles out of order", "49.50° after 50.20°", "run 0"],
    );
    check(
        "turned.csv",
        sound().replacen(",ccw,up,0,", ",cw,up,0,", 1),
        &["run 0 changes its direction"],
    );
    let equal = [("ccw", 364.0), ("cw", 364.5), ("ccw", 364.2), ("cw", 364.1)];
    check("equal.csv", table(&equal), &["forces are all equal"]);
    check(
        "missing.csv",
        table(&SOUND[..5]),
        &["a missing direction", "868 N", "no cw"],
    );
    let half: String = table(&SOUND)
        .lines()
        .filter(|l| {
            let angle = l.split(',').next().and_then(|a| a.parse::<f64>().ok());
            angle.is_none_or(|a| (20.0..150.0).contains(&a))
        })
        .fold(String::new(), |mut s, l| {
            let _ = writeln!(s, "{l}");
            s
        });
    check(
        "arc.csv",
        half,
        &["the readings cover 13", "180° are needed"],
    );
    check(
        "word.csv",
        sound().replacen("\n5,", "\nfive,", 1),
        &["line 9", "'five'", "not a number"],
    );
    check("nothing.csv", HEAD.to_owned(), &["no line with numbers"]);
    check(
        "plane.csv",
        sound().replace("# machine = T1", "# plane = XX"),
        &["line 1", "plane XX", "XY, YZ or ZX"],
    );
    let twice = folder.text("twice.csv", &table(&SOUND));
    let words = [OsStr::new("analyse"), twice.as_os_str(), twice.as_os_str()];
    refused(&ldbb(&words), &twice, &["run 0", "twice"]);
    let other = folder.text("other.csv", &sound().replace("= T1", "= T2"));
    let words = [OsStr::new("analyse"), twice.as_os_str(), other.as_os_str()];
    refused(&ldbb(&words), &other, &["machine", "differs"]);
}

#[test]
fn scenarios_and_their_schema() {
    for (name, text) in SHIPPED_LDBB {
        let s = parse_ldbb(name, text).unwrap_or_else(|e| panic!("{e}"));
        assert!(s.procedure.is_sound() && s.settings.len() == 8, "{name}");
    }
    let folder = Folder::default();
    let (_, m3) = SHIPPED_LDBB[0];
    let check = |name: &str, text: String, words: &[&str]| {
        let file = folder.text(name, &text);
        refused(&ldbb(&[OsStr::new("run"), file.as_os_str()]), &file, words);
    };
    check(
        "steep.toml",
        m3.replace(
            "feed_mm_min = 1000",
            "feed_mm_min = 1000\ninclination_deg = 45",
        ),
        &["inclination_deg", "9.85 bar", "9.00 bar"],
    );
    check(
        "stiff.toml",
        m3.replace("[13.4, 120.2]", "[9.4, 120.2]"),
        &["machine.most", "extremes"],
    );
    check(
        "name.toml",
        m3.replace("seal", "sael").replace("[machine]", "[machin]"),
        &["is no known name"],
    );
    check(
        "forces.toml",
        m3.replace("feed_mm_min", "forces_n = [100, 50]\nfeed_mm_min"),
        &["forces_n", "does not rise"],
    );
    check(
        "weak.toml",
        m3.replace("feed_mm_min", "forces_n = [25, 50]\nfeed_mm_min"),
        &["25.0 N do not hold the bar"],
    );
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../rarma-scenarios/scenarios/ldbb-schema.json"
    );
    let text = std::fs::read_to_string(path).expect("the schema beside the tests");
    let kept: Value = serde_json::from_str(&text).expect("JSON");
    assert!(
        kept == serde_json::from_str::<Value>(&ldbb_schema().to_string()).expect("JSON"),
        "write it again: rarma ldbb run --schema > {path}"
    );
}

/// Written, read again, compared: the same findings.
#[test]
fn run_analyse_compare() {
    let folder = Folder::default();
    let (m5, weak) = (folder.path().join("m5"), folder.path().join("weak"));
    let mut direct = Vec::new();
    for (name, dir) in [("ldbb-m5", &m5), ("ldbb-weak", &weak)] {
        let words = ["run", name, "--json", "--out"].map(OsStr::new);
        direct.push(json(&ldbb(&[&words[..], &[dir.as_os_str()]].concat())));
    }
    let page = folder.path().join("page");
    let words = ["analyse", "--json", "--report"].map(OsStr::new);
    let again = json(&ldbb(
        &[&words[..], &[page.as_os_str(), m5.as_os_str()]].concat(),
    ));
    for pointer in [
        "/findings/stiffness/mean_n_per_um",
        "/findings/stiffness/most/angle_deg",
        "/findings/errors/7/scale_mismatch_um/value",
        "/findings/errors/7/servo_mismatch_ms/value",
    ] {
        let (a, b) = (number(&direct[0], pointer), number(&again, pointer));
        println!("{pointer}: {a} written, {b} read");
        assert!(
            (a - b).abs() < 1e-3 * a.abs().max(1.0),
            "{pointer}: {a} {b}"
        );
    }
    let html = std::fs::read_to_string(page.join("index.html")).expect("a page");
    for word in [
        "Deflection by direction",
        "Static stiffness by direction",
        "Machine errors against load",
        "largest: ",
    ] {
        assert!(html.contains(word), "{word}");
    }
    // One direction says so.
    assert_eq!(
        direct[1]["findings"]["errors"][0]["squareness_includes_servo"],
        true
    );
    assert!(
        direct[1]["notes"][0]
            .as_str()
            .is_some_and(|n| n.contains("servo mismatch"))
    );
    // M1's bar gives way as well: 8.4 N/µm in series with 1000 N/µm.
    let mean = number(&direct[1], "/findings/stiffness/mean_n_per_um");
    assert!((mean - 8.33).abs() < 0.03, "{mean}");
    let words = [
        OsStr::new("compare"),
        weak.as_os_str(),
        m5.as_os_str(),
        OsStr::new("--json"),
    ];
    let both = json(&ldbb(&words));
    assert_eq!(both["machines"][0]["name"], "M5");
    assert_eq!(both["machines"][1]["name"], "M1");
    let spread = number(&both, "/spread");
    let [m5_mean, m1_mean] = [0, 1].map(|k| number(&both, &format!("/machines/{k}/mean")));
    let want = 2.0 * (m5_mean - m1_mean) / (m5_mean + m1_mean);
    assert!((spread - want).abs() < 1e-9, "{spread}");
    // M5 11.10, M1 8.33 N/µm.
    assert!((0.27..0.30).contains(&spread), "{spread}");
    let bad = folder.text("bad.json", "{\"machine\": \"X\"}");
    let words = [OsStr::new("compare"), weak.as_os_str(), bad.as_os_str()];
    refused(&ldbb(&words), &bad, &["no "]);
}
