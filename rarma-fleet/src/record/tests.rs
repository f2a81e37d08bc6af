//! Round trips, and lines that are none.

use super::*;
use proptest::prelude::*;

pub(crate) fn any_name() -> impl Strategy<Value = Name> {
    "[A-Za-z0-9äµ_.-]{1,12}".prop_map(|t| Name::new(&t).unwrap())
}

fn any_body() -> impl Strategy<Value = Body> {
    let f = || 0.0..1e4;
    let zeta = || -0.5..0.5;
    prop_oneof![
        (
            any_name(),
            f(),
            proptest::collection::vec((f(), zeta()), 0..8)
        )
            .prop_map(|(reason, seconds, modes)| Body::Verdict(Verdict {
                state: State::Warning,
                reason,
                seconds,
                level: Some(seconds),
                rpm: None,
                modes: modes
                    .into_iter()
                    .map(|(f_hz, zeta)| Mode {
                        f_hz,
                        f_sd_hz: 1.0,
                        zeta,
                        zeta_sd: 0.001,
                        amplitude: 0.5,
                        label: Label::SelfExcited,
                    })
                    .collect(),
            })),
        (f(), zeta(), proptest::option::of(f())).prop_map(|(f_hz, zeta, rpm)| Body::AlarmCalled(
            AlarmCalled {
                f_hz,
                zeta,
                rpm,
                teeth: Some(4)
            }
        )),
        (0..MOST_NUMBER, f(), zeta()).prop_map(|(called, f_hz, zeta_lowest)| Body::AlarmReleased(
            AlarmReleased {
                called,
                seconds: 1.5,
                f_hz,
                zeta_lowest,
                zeta_median: None,
                rpm: None
            }
        )),
        (0..MOST_NUMBER, proptest::option::of(any::<bool>())).prop_map(|(advice, helped)| {
            Body::Outcome(Outcome {
                advice,
                followed: true,
                rpm: Some(5000.0),
                helped,
                why: None,
            })
        }),
        (
            any_name(),
            proptest::collection::vec((0.0..360.0, 1.0..100.0), 0..40)
        )
            .prop_map(|(plane, rays)| Body::Stiffness(Stiffness {
                plane,
                radius_mm: 150.0,
                inclination_deg: 0.0,
                directions: rays
                    .into_iter()
                    .map(|(angle_deg, n_per_um)| DirectionStiffness {
                        angle_deg,
                        n_per_um,
                        sd_n_per_um: 0.1
                    })
                    .collect(),
                scale_sd: 0.01,
                hysteresis: vec![],
                errors: vec![],
            })),
    ]
}

prop_compose! {
    pub(crate) fn any_record()(
        sender in any_name(), session in 0..=MOST_NUMBER, seq in 0..=MOST_NUMBER, machine in any_name(),
        us in 946_684_800_000_000_i64..7_258_118_400_000_000, tool in proptest::option::of(any_name()),
        box_s in proptest::option::of(-1e6..1e6), body in any_body(),
    ) -> Record {
        Record {
            schema: SCHEMA, id: Id { sender, session, seq }, machine, time: Utc::from_micros(us).unwrap(),
            clock: box_s.map(|box_s| Clock { box_s, drift_ppm: Some(-12.5), drift_sd_ppm: None, time_sd_s: Some(0.01) }),
            tool, operator: None, settings: Some(settings_hash(b"x")), firmware: None, body,
        }
    }
}

proptest! {
    #[test]
    fn a_record_comes_back_as_it_was(record in any_record()) {
        let line = to_line(&record).unwrap();
        prop_assert!(!line.contains('\n'));
        prop_assert_eq!(from_line(&line).unwrap(), record);
    }

    #[test]
    fn any_line_is_answered(line in "\\PC{0,200}") {
        let _ = from_line(&line);
    }

    #[test]
    fn a_cut_line_is_refused(record in any_record(), part in 0.0..1.0_f64) {
        let line = to_line(&record).unwrap();
        let at = (0..line.len()).filter(|&i| line.is_char_boundary(i)).nth((part * 100.0) as usize).unwrap();
        prop_assert!(from_line(&line[..at]).is_err());
    }
}

const LINE: &str = r#"{"schema":1,"box":"box-07","session":291,"seq":17,"machine":"M3","time":"2026-03-01T13:00:00+01:00","tool":"T12","kind":"alarm-called","body":{"f_hz":980.5,"zeta":-0.012,"rpm":4800.0}}"#;

#[test]
fn a_line_written_by_hand_is_read() {
    let record = from_line(LINE).unwrap();
    assert_eq!(record.id.sender.as_str(), "box-07");
    assert_eq!(record.time.to_string(), "2026-03-01T12:00:00.000000Z");
    assert_eq!(record.body.kind(), Kind::AlarmCalled);
}

#[test]
fn a_later_schema_is_refused_by_its_number_whatever_else_it_holds() {
    let line = r#"{"schema":7,"who":{"is":"this"}}"#;
    assert_eq!(from_line(line), Err(RecordError::Future { found: 7 }));
}

#[test]
fn what_is_no_record_is_named() {
    assert_eq!(
        from_line(r#"{"temperature":21}"#),
        Err(RecordError::Foreign)
    );
    assert!(matches!(from_line("not json"), Err(RecordError::Form(_))));
    let zero = LINE.replace("\"schema\":1", "\"schema\":0");
    assert!(matches!(
        from_line(&zero),
        Err(RecordError::Value {
            field: "schema",
            ..
        })
    ));
    let unset = LINE.replace("2026-03-01", "1970-01-02");
    assert!(
        from_line(&unset)
            .unwrap_err()
            .to_string()
            .contains("never set")
    );
    let slash = LINE.replace("box-07", "a/b");
    assert!(from_line(&slash).unwrap_err().to_string().contains("'/'"));
}

#[test]
fn an_unknown_field_is_passed_over() {
    let more = LINE.replace("\"zeta\"", "\"humour\":3,\"zeta\"");
    assert_eq!(from_line(&more), from_line(LINE));
}

#[test]
fn no_nan_is_written() {
    let mut record = from_line(LINE).unwrap();
    record.body = Body::AlarmCalled(AlarmCalled {
        f_hz: f64::NAN,
        zeta: 0.0,
        rpm: None,
        teeth: None,
    });
    assert!(matches!(
        to_line(&record),
        Err(RecordError::Value { field: "f_hz", .. })
    ));
}

#[test]
fn every_kind_has_the_name_that_json_spells() {
    let bodies = [
        Body::AlarmCalled(AlarmCalled {
            f_hz: 1.0,
            zeta: 0.0,
            rpm: None,
            teeth: None,
        }),
        Body::Modes(Modes {
            rpm: 0.0,
            modes: vec![],
        }),
        Body::Limits(Limits {
            ks_n_per_mm2: 1.0,
            directions: vec![],
        }),
    ];
    for body in bodies {
        let json = serde_json::to_value(&body).unwrap();
        assert_eq!(json["kind"], body.kind().name());
    }
}
