//! Promise: the page of a day is as large as that of a few minutes, and what happened for
//! an instant is still on it.

use rarma_cli::collect::News;
use rarma_cli::record::{
    Alarm, Label, Line, ModeRecord, Origin, Reason, SpeedSource, SpindleRecord, SpindleSummary,
    State, Summary,
};
use rarma_cli::report::{Course, Provenance, ReportInput, Sound, page};

const DAY_S: f64 = 86_400.0;
const EVERY_S: f64 = 0.01;
/// The one alarm of the day, s.
const ALARM_S: (f64, f64) = (46_800.0, 46_800.3);
const CHATTER_HZ: f64 = 1_234.0;

fn line(t: f64) -> Line {
    let chatter = (ALARM_S.0..ALARM_S.1).contains(&t);
    let mode = |f: f64, zeta: f64, label| ModeRecord {
        f,
        f_sd: 1.0,
        zeta,
        zeta_sd: 0.2 * zeta,
        amplitude: if chatter { 0.5 } else { 0.02 },
        label,
        harmonic: None,
        origin: Origin::Free,
        time_left: None,
        zeta_process: None,
        zeta_process_sd: None,
    };
    // Drifts a little, so that the lines are not all alike.
    let drift = 1.0 + 0.03 * (t / 3_000.0).sin() + 0.02 * (t * 7.3).sin();
    let mut modes = vec![
        mode(600.0 * drift, 0.04 * drift, Label::Structural),
        mode(900.0, 0.002, Label::Forced),
        mode(1_700.0 * drift, 0.03, Label::Structural),
    ];
    if chatter {
        modes.push(mode(CHATTER_HZ, 0.0008, Label::SelfExcited));
    }
    Line {
        t,
        state: if chatter {
            State::Chatter
        } else {
            State::Stable
        },
        reason: Reason::None,
        modes,
        spindle: SpindleRecord {
            rpm: Some(6_000.0),
            source: SpeedSource::Sound,
            locked: true,
            notch_hz: 1.0,
        },
        amplitude: None,
        agreement: None,
        advice: None,
    }
}

fn alarm(off: Option<f64>) -> Alarm {
    Alarm {
        on: ALARM_S.0,
        off,
        f: CHATTER_HZ,
        zeta: 0.0008,
        zeta_median: None,
        zeta_deviation: None,
        advice: None,
    }
}

fn summary(seconds: f64, alarms: Vec<Alarm>) -> Summary {
    Summary {
        fs: 1_000.0,
        samples: (seconds * 1_000.0) as u64,
        order: [8, 7],
        alarms,
        alarms_left_out: 0,
        state_seconds: [(State::Stable, seconds - 0.3), (State::Chatter, 0.3)].into(),
        notices: Vec::new(),
        notices_left_out: 0,
        spindle: SpindleSummary {
            rpm_first: Some(6_000.0),
            rpm_last: Some(6_000.0),
            locked_s: seconds,
            notch_hz: Some(1.0),
        },
        removed_db: None,
        channels: None,
        notes: Default::default(),
    }
}

/// Of a page that nothing is known of.
static NOTHING: Provenance = Provenance {
    recorded: None,
    made: None,
    command: None,
    notes: Vec::new(),
};

fn job<'a>(sound: &'a Sound, course: &'a Course, summary: &'a Summary) -> ReportInput<'a> {
    ReportInput {
        title: "day",
        source_name: "day.wav",
        sound,
        fs: 8_000.0,
        course,
        summary,
        threshold: 0.01,
        band_hz: (300.0, 2_500.0),
        rpm: None,
        teeth: None,
        truth_onset_s: None,
        truth_note: None,
        missing: None,
        window_s: None,
        provenance: &NOTHING,
        version: "test",
    }
}

/// Content of an attribute of the first element that begins so.
fn path<'a>(html: &'a str, begins: &str) -> &'a str {
    let at = html.find(begins).unwrap_or_else(|| panic!("no {begins}"));
    let rest = &html[at..];
    let d = &rest[rest.find(" d=\"").expect("a path") + 4..];
    &d[..d.find('"').expect("its end")]
}

#[test]
fn an_instant_in_a_day_is_on_its_page() {
    let mut course = Course::default();
    let lines = (DAY_S / EVERY_S) as u64;
    for n in 1..=lines {
        let t = n as f64 * EVERY_S;
        if (t - ALARM_S.0).abs() < 0.5 * EVERY_S {
            course.take(&News::On(alarm(None)));
        }
        course.take(&News::Line(line(t)));
        if (t - ALARM_S.1).abs() < 0.5 * EVERY_S {
            course.take(&News::Off(alarm(Some(ALARM_S.1))));
        }
    }
    // A day of samples at 8 kHz: quiet, with one knock.
    let mut sound = Sound::new(8_000.0, (300.0, 2_500.0));
    let samples = (DAY_S * 8_000.0) as u64;
    let knock = samples / 3;
    for n in 0..samples {
        let x = if n == knock {
            -7.5
        } else {
            [0.01, -0.01][(n % 2) as usize]
        };
        sound.push(x);
    }
    let summary = summary(DAY_S, vec![alarm(Some(ALARM_S.1))]);
    let html = page(&job(&sound, &course, &summary));
    eprintln!("page of a day: {:.2} MB", 1e-6 * html.len() as f64);
    assert!((50_000..2_500_000).contains(&html.len()), "{}", html.len());

    // A third of the way along, one stroke goes down to the knock.
    let strokes = path(&html, "<path class=\"envelope\"");
    let columns = strokes.matches('M').count();
    assert_eq!(columns, 840);
    let tall: Vec<f64> = strokes
        .split('M')
        .skip(1)
        .filter_map(|stroke| {
            let (x, rest) = stroke.split_once(' ')?;
            let (bottom, top) = rest.split_once('V')?;
            let height = bottom.parse::<f64>().ok()? - top.parse::<f64>().ok()?;
            (height > 60.0).then(|| x.parse().ok())?
        })
        .collect();
    let wanted = 84.0 + 840.0 / 3.0;
    assert_eq!(tall.len(), 1, "{tall:?}");
    assert!((tall[0] - wanted).abs() < 2.0, "{tall:?}");
    assert!(
        html.contains("7.5 and 0.01 input units"),
        "the ends are told"
    );

    // 30 of 8.6 million lines: in the strip of states, and as a mark in both pictures.
    let chatter = path(&html, "<path class=\"state state-chatter\"");
    assert_eq!(chatter.matches('M').count(), 1, "{chatter}");
    let x: f64 = chatter[1..chatter.find(' ').expect("x")]
        .parse()
        .expect("x");
    assert!((x - (84.0 + 840.0 * ALARM_S.0 / DAY_S)).abs() < 1.0, "{x}");
    assert!(!path(&html, "<path class=\"self\" d=\"M").is_empty());
    let marks = html.matches("<path class=\"self\" d=\"M").count();
    // One of them is the legend's, in each picture.
    assert!(marks >= 3, "{marks}");
    assert!(html.contains("Chatter at"), "the headline");
    // The reasons add up to the day: nothing was dropped from the sums.
    assert!(html.contains("every mode is damped"));
}

#[test]
fn thousands_of_alarms_are_a_short_table_and_a_word() {
    let mut course = Course::default();
    let mut alarms = Vec::new();
    for n in 0..5_000 {
        let on = f64::from(n) * 10.0;
        let mut one = Alarm {
            on,
            off: None,
            ..alarm(None)
        };
        course.take(&News::On(one.clone()));
        course.take(&News::Line(line(on + 0.5)));
        one.off = Some(on + 1.0);
        course.take(&News::Off(one.clone()));
        alarms.push(one);
    }
    let sound = Sound::of(&[0.1; 1_000], 8_000.0, (300.0, 2_500.0));
    let mut summary = summary(50_000.0, alarms);
    summary.alarms_left_out = 7;
    let html = page(&job(&sound, &course, &summary));
    let table = &html[html.find("<h2>Alarms</h2>").expect("alarms")..];
    let table = &table[..table.find("</section>").expect("its end")];
    assert_eq!(table.matches("<tr>").count(), 501);
    assert!(table.contains("507 alarms more are not listed"), "{table}");
    assert!(html.contains("Chatter 5007 times"));
    assert!(html.len() < 1_500_000, "{}", html.len());
    assert!(html.matches("class=\"span\"").count() < 6 * 1_100);
}
