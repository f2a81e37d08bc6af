//! Promises of the page as a whole.

use super::*;
use crate::collect::News;
use crate::record::{
    Alarm, Amplitude, AmplitudeRecord, HistogramRecord, Label, Line, ModeRecord, Origin, Reason,
    Run, SpeedSource, SpindleRecord, SpindleSummary, State, Summary,
};
use rarma_core::decide::Histogram;

#[path = "long_tests.rs"]
mod long;

fn mode(f: f64, zeta: f64, label: Label) -> ModeRecord {
    ModeRecord {
        f,
        f_sd: 1.0,
        zeta,
        zeta_sd: 0.3 * zeta.abs(),
        amplitude: 0.1,
        label,
        harmonic: None,
        origin: Origin::Free,
        time_left: None,
        zeta_process: None,
        zeta_process_sd: None,
    }
}

/// A line that says nothing but this.
pub(super) fn line(t: f64, state: State, modes: &[(f64, f64, Label)]) -> Line {
    Line {
        t,
        state,
        reason: Reason::None,
        modes: modes
            .iter()
            .map(|(f, zeta, label)| mode(*f, *zeta, *label))
            .collect(),
        spindle: SpindleRecord {
            rpm: None,
            source: SpeedSource::Unknown,
            locked: false,
            notch_hz: 0.0,
        },
        amplitude: None,
        agreement: None,
        advice: None,
    }
}

/// An alarm that says nothing but this.
pub(super) fn alarm(on: f64, off: Option<f64>, f: f64) -> Alarm {
    Alarm {
        on,
        off,
        f,
        zeta: -0.001,
        zeta_median: None,
        zeta_deviation: None,
        advice: None,
    }
}

/// A summary of nothing.
pub(super) fn summary() -> Summary {
    empty().summary
}

fn empty() -> Run {
    Run {
        lines: Vec::new(),
        summary: Summary {
            fs: 5000.0,
            samples: 0,
            order: [4, 3],
            alarms: Vec::new(),
            alarms_left_out: 0,
            state_seconds: Default::default(),
            notices: Vec::new(),
            notices_left_out: 0,
            spindle: SpindleSummary {
                rpm_first: None,
                rpm_last: None,
                locked_s: 0.0,
                notch_hz: None,
            },
            removed_db: None,
            channels: None,
            notes: Default::default(),
        },
        histograms: Vec::new(),
    }
}

/// Stable, then chatter from 1 s on; `n` lines over 2 s.
fn chatter(n: usize) -> Run {
    let mut run = empty();
    for i in 0..n {
        let t = 2.0 * i as f64 / n as f64;
        let (state, zeta, label) = if t < 1.0 {
            (State::Stable, 0.03, Label::Structural)
        } else {
            (State::Chatter, -0.001, Label::SelfExcited)
        };
        run.lines.push(Line {
            t,
            state,
            reason: if t < 1.0 {
                Reason::ForcedOnly
            } else {
                Reason::None
            },
            spindle: SpindleRecord {
                rpm: Some(4500.0 + 20.0 * t),
                source: SpeedSource::Sound,
                locked: t > 0.3,
                notch_hz: 1.5,
            },
            amplitude: Some(AmplitudeRecord {
                f: 898.0,
                s: 0.05,
                verdict: Amplitude::SelfExcited,
                z: -9.0,
            }),
            modes: vec![mode(300.0, 0.001, Label::Forced), mode(898.0, zeta, label)],
            agreement: None,
            advice: None,
        });
    }
    run.histograms.push(HistogramRecord {
        t: 1.5,
        f: 898.0,
        counts: Histogram {
            counts: [0, 1, 3, 30, 60, 31, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0],
            beyond: 0,
            bin_width: 0.25,
        },
    });
    run.summary.alarms.push(alarm(1.0, None, 898.0));
    run.summary.state_seconds = [(State::Stable, 1.0), (State::Chatter, 1.0)].into();
    run
}

/// What a page of a run is made of.
struct Played {
    sound: Sound,
    course: Course,
    summary: Summary,
    provenance: Provenance,
}

/// Says all of a run again, in order of time.
fn tell(run: &Run, mut hear: impl FnMut(News)) {
    let mut histograms = run.histograms.iter().peekable();
    let mut on = run.summary.alarms.iter().peekable();
    let mut off = on.clone();
    let mut tell = |t: f64, hear: &mut dyn FnMut(News)| {
        loop {
            let next_on = on.peek().filter(|a| a.on <= t).map(|a| a.on);
            let next_off = off.peek().and_then(|a| a.off).filter(|at| *at < t);
            let at = histograms.peek().filter(|h| h.t <= t).map(|h| h.t);
            let first = [next_on, at, next_off].into_iter().flatten();
            let Some(first) = first.reduce(f64::min) else {
                break;
            };
            if next_on == Some(first) {
                hear(on.next().map_or(News::None, |a| News::On(a.clone())));
            } else if at == Some(first) {
                hear(
                    histograms
                        .next()
                        .map_or(News::None, |h| News::Histogram(h.clone())),
                );
            } else {
                hear(off.next().map_or(News::None, |a| News::Off(a.clone())));
            }
        }
    };
    for line in &run.lines {
        tell(line.t, &mut hear);
        hear(News::Line(line.clone()));
    }
    tell(f64::INFINITY, &mut hear);
}

fn played(run: &Run, samples: &[f64]) -> Played {
    let mut course = Course::default();
    tell(run, |news| course.take(&news));
    Played {
        sound: Sound::of(samples, 5000.0, (200.0, 2000.0)),
        course,
        summary: run.summary.clone(),
        provenance: Provenance::default(),
    }
}

fn job(played: &Played) -> ReportInput<'_> {
    ReportInput {
        title: "job",
        source_name: "cut.wav",
        sound: &played.sound,
        fs: 5000.0,
        course: &played.course,
        summary: &played.summary,
        threshold: 0.01,
        band_hz: (200.0, 2000.0),
        rpm: Some(4500.0),
        teeth: Some(4),
        truth_onset_s: Some(0.9),
        truth_note: None,
        missing: None,
        window_s: None,
        provenance: &played.provenance,
        version: "0.1.0",
    }
}

fn tone(n: usize) -> Vec<f64> {
    (0..n).map(|i| (i as f64).sin()).collect()
}

/// What holds for every page, whatever is on it.
fn sound(page: &str) {
    for word in ["http", "NaN", "nan\"", "inf\"", "inf ", "<script", "src="] {
        assert!(!page.contains(word), "{word}");
    }
    let figures = page.matches("<figure>").count();
    assert_eq!(figures, 6);
    assert_eq!(page.matches("role=\"img\" aria-label=\"").count(), figures);
    assert_eq!(page.matches("<figcaption>").count(), figures);
    assert!(!page.contains("aria-label=\"\""));
    for tag in [
        "svg", "figure", "table", "section", "g", "div", "text", "main", "tr", "td", "th",
    ] {
        let opened =
            page.matches(&format!("<{tag} ")).count() + page.matches(&format!("<{tag}>")).count();
        assert_eq!(opened, page.matches(&format!("</{tag}>")).count(), "{tag}");
    }
}

#[test]
fn a_chatter_page_says_so() {
    let (run, samples) = (chatter(200), tone(10_000));
    let page = page(&job(&played(&run, &samples)));
    sound(&page);
    assert!(page.contains("Chatter at 898\u{a0}Hz from 1\u{a0}s to the end</h1>"));
    assert!(page.contains("the alarm came 0.1\u{a0}s later"));
    assert!(page.contains("data:image/png;base64,"));
    assert!(page.contains("still on at the end"));
    // Both at the speed of that moment, 4520 1/min: 898/(4·4520/60) and 898 − 12·4520/60 = −6 Hz.
    assert!(page.contains("2.98\u{a0}×"), "multiples of tooth passing");
    assert!(page.contains("6\u{a0}Hz below 12 × 75.3\u{a0}Hz"));
    assert!(page.contains("<td>limit cycle</td>"));
    assert!(page.contains("S = Var V / (mean V)² = 0.05"));
    assert!(page.contains("undamped, but something else explains it"));
    assert!(page.contains("300\u{a0}Hz to 303\u{a0}Hz"));
}

#[test]
fn nothing_to_show_is_no_reason_to_panic() {
    let run = empty();
    for samples in [
        vec![],
        vec![0.0],
        tone(20),
        vec![0.0; 5000],
        vec![f64::NAN; 5000],
    ] {
        let page = page(&job(&played(&run, &samples)));
        sound(&page);
        assert!(page.contains("No verdict"));
    }
    let mut run = chatter(100);
    for line in &mut run.lines {
        line.modes.clear();
    }
    sound(&page(&job(&played(&run, &tone(10_000)))));
}

#[test]
fn broken_numbers_do_not_reach_the_page() {
    let mut run = chatter(50);
    for (i, line) in run.lines.iter_mut().enumerate() {
        let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300][i % 4];
        line.modes[0].f = bad;
        line.modes[1].zeta = bad;
        line.modes[1].zeta_sd = bad;
        line.modes[1].amplitude = bad;
    }
    run.lines[3].t = f64::NAN;
    run.summary.alarms[0].off = Some(f64::NAN);
    run.summary.alarms[0].zeta = f64::NAN;
    let samples = tone(1000);
    let played = played(&run, &samples);
    let mut job = job(&played);
    sound(&page(&job));
    (job.fs, job.band_hz, job.threshold) = (f64::NAN, (f64::NAN, f64::INFINITY), f64::NAN);
    (job.rpm, job.truth_onset_s) = (Some(f64::INFINITY), Some(f64::NAN));
    sound(&page(&job));
    (job.fs, job.band_hz, job.rpm) = (0.0, (0.0, 0.0), Some(0.0));
    sound(&page(&job));
}

#[test]
fn strings_from_outside_stay_text() {
    let (run, samples) = (chatter(10), tone(1000));
    let played = played(&run, &samples);
    let mut job = job(&played);
    let evil = "\"><script>x</script>&'";
    (job.title, job.source_name, job.version) = (evil, evil, evil);
    job.truth_note = Some(evil.into());
    let page = page(&job);
    sound(&page);
    let escaped = "&quot;&gt;&lt;script&gt;x&lt;/script&gt;&amp;&#39;";
    assert!(page.matches(escaped).count() >= 5);
}

#[test]
fn a_minute_stays_small() {
    let samples: Vec<f64> = (0..60 * 8000)
        .map(|i| f64::from(i % 7919 * 31 % 1009) - 504.0)
        .collect();
    let mut run = chatter(6000);
    for (i, line) in run.lines.iter_mut().enumerate() {
        line.t *= 30.0;
        for k in 1..15_u32 {
            let zeta = 0.2 / (1.0 + f64::from((i as u32 * 31 * k) % 97));
            line.modes.push(mode(
                130.0 * f64::from(k) + (i % 50) as f64,
                zeta,
                Label::Structural,
            ));
        }
    }
    let played = played(&run, &samples);
    let mut job = job(&played);
    job.fs = 8000.0;
    let size = page(&job).len();
    assert!(size < 2_000_000, "{size} bytes");
}

#[test]
fn the_page_says_where_it_comes_from_and_how_damped_an_alarm_was() {
    let (mut run, samples) = (chatter(200), tone(10_000));
    let alarm = &mut run.summary.alarms[0];
    (alarm.zeta_median, alarm.zeta_deviation) = (Some(0.0011), Some(0.0024));
    let mut played = played(&run, &samples);
    let at = |s| std::time::UNIX_EPOCH + std::time::Duration::from_secs(s);
    played.provenance = Provenance {
        recorded: Some(at(1_000_000_000)),
        made: Some(at(951_782_400)),
        command: Some("rarma monitor 'a b.wav'".into()),
        notes: vec![("machine".into(), "M<3>\u{1b}".into())],
    };
    let page = page(&job(&played));
    sound(&page);
    for text in [
        "<b>machine</b> M&lt;3&gt;\u{fffd}",
        "<b>file written</b> 2001-09-09 01:46 UTC",
        "<th scope=\"row\">Page made</th><td>2000-02-29 00:00 UTC</td>",
        "<code>rarma monitor &#39;a b.wav&#39;</code>",
        "<td>0.1 ± 0.2\u{a0}%</td>",
        "was 0.1 ± 0.2\u{a0}% (median of the readings and their deviation)",
        "above 4\u{a0}% an alarm may be released",
    ] {
        assert!(page.contains(text), "{text}");
    }
    // Both thresholds, each with its line and its name.
    for (class, name) in [("release", "release"), ("threshold", "undamped")] {
        assert_eq!(page.matches(&format!("<path class=\"{class}\"")).count(), 1);
        assert!(page.contains(&format!(">{name}</text>")), "{name}");
    }
    assert!(
        !page.contains("--window"),
        "a short run is drawn closely already"
    );
}

#[test]
fn verdicts() {
    let headline = |seconds: &[(State, f64)]| {
        let mut run = empty();
        run.summary.state_seconds = seconds.iter().copied().collect();
        let played = played(&run, &[]);
        let job = job(&played);
        words::verdict(&Scene::new(&job)).headline
    };
    for (seconds, want) in [
        (&[(State::Stable, 1.0)][..], "No chatter"),
        (&[(State::Idle, 1.0)], "No chatter: nothing was being cut"),
        (
            &[(State::Stable, 1.0), (State::Warning, 0.5)],
            "No chatter, but warnings for 0.5\u{a0}s",
        ),
        (
            &[(State::Stable, 1.0), (State::Invalid, 2.0)],
            "No verdict: the samples could not be trusted for 2\u{a0}s",
        ),
        (
            &[(State::Starting, 1.0)],
            "No verdict: the recording ended before the monitor was ready",
        ),
        (&[], "No verdict: nothing was analysed"),
    ] {
        assert_eq!(headline(seconds), want);
    }
}

#[test]
fn the_file_is_written_where_asked() {
    let dir = tempfile::tempdir().unwrap();
    let (run, samples) = (chatter(10), tone(1000));
    let path = write(&dir.path().join("a/b"), &job(&played(&run, &samples))).unwrap();
    assert!(path.ends_with("a/b/index.html"));
    assert!(
        std::fs::read_to_string(path)
            .unwrap()
            .starts_with("<!doctype html>")
    );
}
