//! What other commands print, in their form; that it is their form is held by the tests of the binary.

use super::*;
use crate::record::Kind;

fn head() -> Head {
    let name = |text| Name::new(text).unwrap();
    let time = "2026-03-01T12:00:00Z".parse().unwrap();
    Head {
        machine: name("M3"),
        time,
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
    let sweep = r#"{"rpm":[0,9000],"principal_deg":1,"modes":[]}"#;
    assert!(matches!(
        records(sweep, &head()),
        Err(ConvertError::Nothing(_))
    ));
    let none = r#"{"findings":{"stiffness":null},"radius_mm":150}"#;
    assert!(
        records(none, &head())
            .unwrap_err()
            .to_string()
            .contains("three forces")
    );
}
