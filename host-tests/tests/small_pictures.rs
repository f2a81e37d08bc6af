//! Promise: the small pictures on top of README.md and in docs/act.md are what the program says today.
//!
//! They are drawn here, of what the commands say and by the charts of their pages, and compared
//! with the files: `RARMA_WRITE_TABLE=1 cargo test --release -p host-tests --test small_pictures`
//! writes them.

use host_tests::act_judge::{Kind, SEEDS, drawn};
use host_tests::act_loop::{Played, simulated};
use host_tests::files::Folder;
use host_tests::json::{number, word};
use host_tests::process::Rarma;
use host_tests::rarma;
use rarma_pictures::{Chart, Mark, Scale, Series, sheet};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use xtask::gallery::pictures::of_page;

/// The names of their files, in order, and the page that shows each.
const NAMES: [(&str, &str); 5] = [
    ("damping", "README.md"),
    ("lobes", "README.md"),
    ("stiffness", "README.md"),
    ("act-speed", "docs/act.md"),
    ("act-swing", "docs/act.md"),
];

const SCENARIO: &str = "chatter-onset";
/// What is told of it beside the sound.
const SPEED_AND_TEETH: [&str; 4] = ["--rpm", "1680", "--teeth", "6"];
const HEIGHT: f64 = 170.0;

/// So long at most, bytes: they are loaded with a page that is read for its words.
const SMALL: usize = 12_000;

#[test]
fn the_small_pictures_are_up_to_date_and_small() {
    let folder = Folder::default();
    let scratch = folder.path();
    let charts = [
        damping(rarma!(), scratch),
        lobes(rarma!()),
        stiffness(rarma!(), scratch),
    ];
    let charts = charts.into_iter().chain(act());
    let figures: String = charts.map(|chart| chart.small_figure()).collect();
    let drawn = of_page(&sheet("rarma", "Small pictures", &figures, "")).expect("pictures");
    assert_eq!(drawn.len(), NAMES.len());
    for (picture, (name, shown_in)) in drawn.iter().zip(NAMES) {
        let named = format!("docs/pictures/{name}.svg");
        let page = fs::read_to_string(root().join(shown_in)).expect("a page");
        let from_there = named
            .strip_prefix("docs/")
            .filter(|_| shown_in != "README.md");
        assert!(
            page.contains(&format!("]({})", from_there.unwrap_or(&named))),
            "{named} is not in {shown_in}"
        );
        assert!(
            picture.svg.len() < SMALL,
            "{named}: {} bytes",
            picture.svg.len()
        );
        let path = root().join(&named);
        if std::env::var_os("RARMA_WRITE_TABLE").is_some() {
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            fs::write(&path, &picture.svg).expect("written");
        }
        let kept = fs::read_to_string(&path).unwrap_or_default();
        assert!(
            alike(&picture.svg, &kept),
            "{named} is old; see the head of this file"
        );
    }
}

/// The same picture, to what another machine's arithmetic may move in it: two pixels.
fn alike(drawn: &str, kept: &str) -> bool {
    let is_of_number = |c: char| c.is_ascii_digit() || c == '.';
    let words = |svg: &str| svg.replace(is_of_number, "");
    let numbers = |svg: &str| -> Vec<f64> {
        let pieces = svg.split(|c| !is_of_number(c));
        pieces.filter_map(|piece| piece.parse().ok()).collect()
    };
    let (is, was) = (numbers(drawn), numbers(kept));
    let near = is.iter().zip(&was).all(|(a, b)| (a - b).abs() <= 2.0);
    words(drawn) == words(kept) && is.len() == was.len() && near
}

#[test]
fn a_curve_that_moved_or_another_word_is_noticed() {
    let picture = r#"<path d="M10 20.5L30 40"/><text x="3">old</text>"#;
    assert!(alike(picture, &picture.replace("20.5", "21")));
    for (was, is) in [("40", "44"), ("old", "new"), ("L30 40", "L30 40L50 60")] {
        assert!(!alike(picture, &picture.replace(was, is)), "{was}");
    }
}

fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().expect("the workspace").to_path_buf()
}

fn at(folder: &Path, name: &str) -> String {
    folder.join(name).display().to_string()
}

fn said(rarma: Rarma, words: &[&str]) -> String {
    let ended = rarma.run(words);
    assert!(matches!(ended.code, Some(0 | 1)), "{words:?}: {ended:?}");
    ended.stdout
}

/// The damping that is read of the mode that chatters, falling to nothing, and when it is called.
fn damping(rarma: Rarma, scratch: &Path) -> Chart {
    let (sound, truth) = (at(scratch, "cut.wav"), at(scratch, "cut.json"));
    said(
        rarma,
        &["simulate", SCENARIO, "--out", &sound, "--truth", &truth],
    );
    let mut words = vec!["monitor", &sound, "--json", "--every", "0.05"];
    words.extend(SPEED_AND_TEETH);
    let lines: Vec<Value> = said(rarma, &words)
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    let alarm = &lines.last().expect("a summary")["summary"]["alarms"][0];
    let (on_s, f_hz) = (number(alarm, "on"), number(alarm, "f"));
    let mut read = Vec::new();
    for line in &lines[..lines.len() - 1] {
        let modes = line["modes"].as_array().expect("modes");
        let near = modes
            .iter()
            .filter(|m| (number(m, "f") / f_hz - 1.0).abs() < 0.04);
        let nearest = near.min_by(|a, b| {
            let off = |m: &Value| (number(m, "f") - f_hz).abs();
            off(a).total_cmp(&off(b))
        });
        if let Some(mode) = nearest {
            read.push((number(line, "t"), 100.0 * number(mode, "zeta").max(1e-4)));
        }
    }
    let truth = fs::read_to_string(&truth).expect("the truth");
    let truth: Value = serde_json::from_str(&truth).expect("JSON");
    let onset_s = number(&truth, "onset_s");
    let upright = |t: f64| vec![(t, 0.01), (t, 20.0)];
    Chart {
        title: "A cut loses its damping".to_owned(),
        x: Scale::linear("time (s)", 0.0, 9.0),
        y: Scale::log("damping ratio ζ (%)", 0.01, 10.0),
        height: HEIGHT,
        series: vec![
            Series::new(
                &format!("read of the {f_hz:.0} Hz mode"),
                read,
                Mark::Dots,
                0,
            ),
            Series::new("truly unstable", upright(onset_s), Mark::Dashes, 5),
            Series::new("chatter called", upright(on_s), Mark::Line, 1),
        ],
        caption: "A virtual mill cuts deeper and deeper; the damping ratio is read of its sound."
            .to_owned(),
    }
}

/// Limit depth over speed.
fn lobes(rarma: Rarma) -> Chart {
    let said = said(
        rarma,
        &[
            "lobes",
            "two-tooth-up",
            "--rpm",
            "5000:25000",
            "--speeds",
            "61",
            "--max-depth-mm",
            "3",
            "--json",
        ],
    );
    let said: Value = serde_json::from_str(&said).expect("JSON");
    let points = said["scenarios"][0]["points"].as_array().expect("points");
    let limit: Vec<(f64, f64)> = points
        .iter()
        .map(|p| {
            (
                1e-3 * number(p, "speed_rpm"),
                p["depth_mm"].as_f64().unwrap_or(f64::NAN),
            )
        })
        .collect();
    Chart {
        title: "Which depth and speed are stable".to_owned(),
        x: Scale::linear("spindle speed (1000/min)", 5.0, 25.0),
        y: Scale::linear("depth of cut (mm)", 0.0, 3.0),
        height: HEIGHT,
        series: vec![
            Series::new("chatters", limit.clone(), Mark::Above, 1),
            Series::new("limit", limit, Mark::Line, 0),
        ],
        caption: "Stability lobes of a virtual mill with two teeth.".to_owned(),
    }
}

/// A cut that is turned to a stable speed: what turns, and how the tool swings, beside the same cut
/// without orders.
fn act() -> [Chart; 2] {
    let case = drawn(SEEDS + 9, Kind::Pocket, &(0.0..1e9)).expect("the first such cut");
    let [turned, left] = [true, false].map(|act| simulated(&case, act, case.about()));
    let (on_s, off_s) = turned.alarms[0];
    let off_s = off_s.expect("released");
    let x = || Scale::linear("time (s)", 0.5, 3.0);
    let rpm = |played: &Played| {
        let all = played.speeds.iter();
        all.map(|(t, hz)| (*t, 0.06 * hz)).collect::<Vec<_>>()
    };
    let um = |played: &Played| {
        let all = played.swing_m.iter();
        all.map(|(t, m)| (*t, (1e6 * m).max(0.1)))
            .collect::<Vec<_>>()
    };
    let upright = |t: f64, low: f64, high: f64| vec![(t, low), (t, high)];
    [
        Chart {
            title: "Chatter is called, and the speed is turned".to_owned(),
            x: x(),
            y: Scale::linear("spindle speed (1000/min)", 6.0, 10.0),
            height: HEIGHT,
            series: vec![
                Series::new("speed that turns", rpm(&turned), Mark::Line, 0),
                Series::new("chatter called", upright(on_s, 6.0, 10.0), Mark::Line, 1),
                Series::new("released", upright(off_s, 6.0, 10.0), Mark::Dashes, 2),
            ],
            caption: "A virtual mill with seven teeth enters at 0.8 s; rarma hears chatter and orders 73 % of its speed."
                .to_owned(),
        },
        Chart {
            title: "What becomes of the tool's swing".to_owned(),
            x: x(),
            y: Scale::log("swing (µm)", 1.0, 1000.0),
            height: HEIGHT,
            series: vec![
                Series::new("without orders", um(&left), Mark::Line, 5),
                Series::new("turned", um(&turned), Mark::Line, 0),
                Series::new("chatter called", upright(on_s, 1.0, 1000.0), Mark::Line, 1),
            ],
            caption: "The same cut with orders and without: what the teeth force stays, what chatters dies."
                .to_owned(),
        },
    ]
}

/// Stiffness all round of two machines under the loaded ball bar.
fn stiffness(rarma: Rarma, scratch: &Path) -> Chart {
    let series = [("ldbb-m3", 0), ("ldbb-m5", 1)].map(|(scenario, colour)| {
        let folder = at(scratch, scenario);
        said(rarma, &["ldbb", "run", scenario, "--out", &folder]);
        let analysis = fs::read_to_string(Path::new(&folder).join("analysis.json"));
        let analysis: Value = serde_json::from_str(&analysis.expect("an analysis")).expect("JSON");
        let rays = analysis["findings"]["stiffness"]["rays"].as_array();
        let rays = rays.expect("stiffness all round").iter().step_by(5);
        let points = rays
            .map(|ray| (number(ray, "angle_deg"), number(ray, "n_per_um")))
            .collect();
        Series::new(word(&analysis, "machine"), points, Mark::Line, colour)
    });
    Chart {
        title: "Where a machine is soft under load".to_owned(),
        x: Scale::linear("direction (°)", 0.0, 360.0),
        y: Scale::linear("static stiffness (N/µm)", 8.0, 15.0),
        height: HEIGHT,
        series: series.to_vec(),
        caption: "Static stiffness by direction of two virtual machines, measured with the loaded ball bar.".to_owned(),
    }
}
