//! What other commands print, in their form; that it is their form is held by the tests of the binary.

use super::*;
use crate::record::Kind;

fn head() -> Head {
    let name = |text| Name::new(text).unwrap();
    let time = "2026-03-01T12:00:00Z".parse().unwrap();
    Head {
        machine: name("M3"),
        time: Some(time),
        sender: name("file"),
        tool: None,
        operator: Some(name("ada")),
    }
}

const MONITOR: &str = r#"{"t":0.1,"state":"idle","reason":"level-at-idle","modes":[]}
{"summary":{"fs":8000.0,"samples":16000,"order":[2,1],"alarms":[
 {"on":1.0,"off":1.5,"f":980.0,"zeta":-0.01,"zeta_median":-0.005,"advice":{"rpm":4800.0,"mode":970.0,
  "speeds":[{"rpm":5200.0,"rpm_sd":40.0,"chance":0.8,"margin":2.0}],"helps":[]}},
 {"on":1.8,"off":null,"f":985.0,"zeta":-0.02}],
 "state_seconds":{"idle":0.5,"stable":0.5,"chatter":1.0},"spindle":{"rpm_last":null}}}"#;

#[test]
fn a_run_of_the_monitor_becomes_states_alarms_and_advice() {
    let made = records(MONITOR, &head()).unwrap();
    let kinds: Vec<Kind> = made.iter().map(|r| r.body.kind()).collect();
    use Kind::{Advice, AlarmCalled, AlarmReleased, Verdict};
    assert_eq!(
        kinds,
        [
            Verdict,
            Verdict,
            Verdict,
            AlarmCalled,
            Advice,
            AlarmReleased,
            AlarmCalled
        ]
    );
    let Body::AlarmReleased(released) = &made[5].body else {
        panic!()
    };
    assert_eq!(
        (released.called, released.seconds, released.rpm),
        (made[3].id.seq, 0.5, Some(4800.0))
    );
    assert_eq!(made[5].time.to_string(), "2026-03-01T12:00:01.500000Z");
    assert!(made.iter().all(|r| r.check().is_ok()));
}

#[test]
fn the_same_file_gives_the_same_names_and_another_machine_others() {
    let ids = |head: &Head| {
        records(MONITOR, head)
            .unwrap()
            .into_iter()
            .map(|r| r.id)
            .collect::<Vec<_>>()
    };
    assert_eq!(ids(&head()), ids(&head()));
    let other = Head {
        machine: Name::new("M4").unwrap(),
        ..head()
    };
    assert_ne!(ids(&head())[0], ids(&other)[0]);
}

#[test]
fn statistics_of_a_cut_do_not_take_neighbours_for_independent() {
    // Damping that wanders slowly: 1000 readings of a sine of two periods.
    let mut text = String::new();
    for n in 0..1000 {
        let zeta = 0.03 + 0.01 * (f64::from(n) / 1000.0 * 4.0 * std::f64::consts::PI).sin();
        text.push_str(&format!(
            r#"{{"t":{},"state":"stable","modes":[{{"f":900.0,"zeta":{zeta},"label":"structural"}},{{"f":300.0,"zeta":0.001,"label":"forced"}}],"spindle":{{"rpm":4800.0}}}}"#,
            f64::from(n) * 0.01
        ));
    }
    text.push_str(
        r#"{"summary":{"alarms":[],"state_seconds":{"stable":10.0},"spindle":{"rpm_last":null}}}"#,
    );
    let made = records(&text, &head()).unwrap();
    let Body::OdrStatistics(odr) = &made[1].body else {
        panic!("{made:?}")
    };
    assert_eq!((odr.f_hz, odr.count, odr.rpm), (900.0, 1000, 4800.0));
    assert!((odr.zeta_mean - 0.03).abs() < 1e-4, "{}", odr.zeta_mean);
    // The scatter of one is 0.0071: over the root of 1000 it would be 0.00022.
    assert!(
        (0.001..0.004).contains(&odr.zeta_mean_sd),
        "{}",
        odr.zeta_mean_sd
    );
}

#[test]
fn what_is_nothing_of_ours_is_named() {
    assert_eq!(records(r#"{"a":1}"#, &head()), Err(ConvertError::Unknown));
    assert!(matches!(records("{", &head()), Err(ConvertError::Json(_))));
    let sweep = r#"{"rpm":[0,9000],"sweep":{"tracks":[{"axis":"x","band_hz":[4,8],"method":"arx","points":[
        {"rpm":510,"f":5.0,"f_sd":0.1,"zeta":0.02,"zeta_sd":0.01,"believed":false}]}]}}"#;
    assert!(matches!(
        records(sweep, &head()),
        Err(ConvertError::Nothing(_))
    ));
    let when = Head {
        time: None,
        ..head()
    };
    assert_eq!(records(MONITOR, &when), Err(ConvertError::NoTime));
    // What it repeats of a file stays one line.
    let state = r#"{"summary":{"alarms":[],"state_seconds":{"id\nle":1.0},"spindle":{}}}"#;
    let why = records(state, &head()).unwrap_err().to_string();
    assert!(why.contains(r#""id\nle""#) && !why.contains('\n'), "{why}");
    // A speed that was ordered from none is no number, and no record.
    let stood = ORDERED.replace("100.0", "0.0").replace("90.0", "0.0");
    let from_0 = [
        BEGINS,
        (1.5, PROPOSED),
        (1.6, &stood),
        (1.9, ARRIVED),
        (2.2, r#""act":"quiet""#),
    ];
    assert!(
        records(&log(0.0, &from_0), &head())
            .unwrap_err()
            .to_string()
            .contains("\"rpm\"")
    );
    let none = r#"{"findings":{"stiffness":null},"radius_mm":150}"#;
    assert!(
        records(none, &head())
            .unwrap_err()
            .to_string()
            .contains("three forces")
    );
}

#[test]
fn a_sweep_is_a_record_a_speed() {
    let point = |rpm: f64, f: f64, believed: bool| {
        format!(
            r#"{{"t":1,"rpm":{rpm},"f":{f},"f_sd":0.5,"zeta":0.02,"zeta_sd":0.001,"crossing":null,"believed":{believed}}}"#
        )
    };
    let track = |axis: &str, low: u32, method: &str, points: &[String]| {
        let points = points.join(",");
        format!(
            r#"{{"axis":"{axis}","band_hz":[{low},900.0],"method":"{method}","points":[{points}]}}"#
        )
    };
    let tracks = [
        // Nearest to 1000 that is believed: 1040. To 1500: 1420, by the force, not 1500 without it.
        track(
            "x",
            400,
            "arx",
            &[
                point(1010.0, 501.0, false),
                point(1040.0, 502.0, true),
                point(1100.0, 503.0, true),
                point(1420.0, 504.0, true),
            ],
        ),
        track(
            "x",
            400,
            "rarma",
            &[point(1500.0, 510.0, true), point(2000.0, 511.0, true)],
        ),
        track("y", 600, "arx", &[point(2010.0, 700.0, true)]),
    ]
    .join(",");
    let text = format!(r#"{{"rpm":[1000,2000],"sweep":{{"tracks":[{tracks}]}}}}"#);
    let made = records(&text, &head()).unwrap();
    let found: Vec<(f64, Vec<(String, f64)>)> = (made.iter())
        .map(|r| match &r.body {
            Body::Modes(m) => {
                let modes = m.modes.iter().map(|m| (m.axis.to_string(), m.f_hz));
                (m.rpm, modes.collect())
            }
            other => panic!("{other:?}"),
        })
        .collect();
    let x = |f| ("X".to_owned(), f);
    assert_eq!(
        found,
        [
            (1000.0, vec![x(502.0)]),
            (1500.0, vec![x(504.0)]),
            (2000.0, vec![x(511.0), ("Y".to_owned(), 700.0)])
        ]
    );
}

/// A log, a line each, of a run that began at 2026-03-01T12:00:00Z.
fn log(begin_s: f64, lines: &[(f64, &str)]) -> String {
    let line = |(t, rest): &(f64, &str)| {
        let utc = 1_772_366_400.0 + begin_s + t;
        format!("{{\"utc\":{utc},\"t\":{t},{rest}}}\n")
    };
    lines.iter().map(line).collect()
}

const BEGINS: (f64, &str) = (
    0.0,
    r#""act":"begins","controller":"Grbl","orders":true,"limits":[80.0,120.0]"#,
);
const PROPOSED: &str = r#""act":"proposed","f":981.2,"rpm":9000.0,"speeds":[8100.0,7650.5]"#;
const ORDERED: &str =
    r#""act":"ordered","from":{"spindle":100.0,"feed":100.0},"to":{"spindle":90.0,"feed":90.0}"#;
const ARRIVED: &str = r#""act":"arrived","at":{"spindle":90.0,"feed":90.0}"#;

/// Of which advice, followed, speed, helped, why.
type Came = (u64, bool, Option<f64>, Option<bool>, Option<String>);

fn outcomes(text: &str) -> Vec<Came> {
    let made = records(text, &head()).unwrap();
    assert!(made.iter().all(|r| r.check().is_ok()));
    (made.iter())
        .filter_map(|r| match &r.body {
            Body::Outcome(o) => {
                let why = o.why.as_ref().map(ToString::to_string);
                Some((o.advice, o.followed, o.rpm, o.helped, why))
            }
            _ => None,
        })
        .collect()
}

#[test]
fn a_log_of_orders_becomes_advice_and_what_came_of_it() {
    let quiet = log(
        0.0,
        &[
            BEGINS,
            (1.5, PROPOSED),
            (1.6, ORDERED),
            (1.9, ARRIVED),
            (2.2, r#""act":"quiet""#),
            (9.0, r#""act":"ends","why":"program-end""#),
            (9.1, r#""act":"returned""#),
        ],
    );
    let made = records(&quiet, &head()).unwrap();
    let Body::Advice(advice) = &made[0].body else {
        panic!("{made:?}")
    };
    assert_eq!(
        (advice.called, advice.rpm, advice.f_hz),
        (None, 9000.0, 981.2)
    );
    assert_eq!(advice.speeds[1], crate::record::Speed::of_rpm(7650.5));
    assert_eq!(made[1].time.to_string(), "2026-03-01T12:00:02.200000Z");
    assert_eq!(
        outcomes(&quiet),
        [(0, true, Some(8100.0), Some(true), None)]
    );

    // The first speed chatters on, the second, too; then the operator takes it, before the third is there.
    let tried = log(
        0.0,
        &[
            BEGINS,
            (1.5, PROPOSED),
            (1.6, ORDERED),
            (1.9, ARRIVED),
            (3.2, PROPOSED),
            (3.3, ORDERED),
            (3.5, ARRIVED),
            (4.8, PROPOSED),
            (4.9, ORDERED),
            (5.0, r#""act":"ends","why":"operator""#),
        ],
    );
    let why = |w: &str| Some(w.to_owned());
    assert_eq!(
        outcomes(&tried),
        [
            (0, true, Some(8100.0), Some(false), None),
            (2, true, Some(8100.0), Some(false), None),
            (4, false, Some(9000.0), None, why("operator")),
        ]
    );

    // Nobody turned it; of the last nothing is known yet, and of the run before the same is said as without it.
    let dry = log(
        0.0,
        &[
            BEGINS,
            (1.5, PROPOSED),
            (
                1.5,
                r#""act":"would-order","from":{"spindle":100.0,"feed":100.0},"to":{"spindle":90.0,"feed":90.0}"#,
            ),
        ],
    );
    assert_eq!(
        outcomes(&dry),
        [(0, false, Some(9000.0), None, why("would-order"))]
    );
    // The call was not believed: nothing was turned, either.
    let doubted = [BEGINS, (1.5, PROPOSED), (1.5, r#""act":"not-believed""#)];
    assert_eq!(
        outcomes(&log(0.0, &doubted)),
        [(0, false, Some(9000.0), None, why("not-believed"))]
    );
    let grown = format!("{dry}{}", log(60.0, &[BEGINS, (2.0, PROPOSED)]));
    let (short, long) = (records(&dry, &head()), records(&grown, &head()));
    let (short, long) = (short.unwrap(), long.unwrap());
    assert_eq!(long[..2], short[..]);
    assert_eq!(long.len(), 3);
    assert_eq!(long[2].time.to_string(), "2026-03-01T12:01:02.000000Z");
    assert_ne!(long[2].id.session, long[0].id.session);
}
