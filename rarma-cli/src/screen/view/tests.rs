//! What is to be seen, letter by letter. `RARMA_WRITE_PICTURES=1` writes what is expected anew: look
//! at it before it is kept.

use super::*;
use crate::collect::News;
use crate::record::{Alarm, Line};
use crate::screen::input_line::InputLine;
use crate::screen::model::Kind;
use crate::screen::spectrum::Row;
use proptest::prelude::*;
use rarma_box::guard::{FaultCode, FaultRecord, Mode, Stage};
use rarma_box::wire::{ControlMessage, Handed, Status, Telemetry};
use serde_json::json;
use std::path::Path;

fn line(t: f64, state: &str, modes: &[(f64, f64, f64, &str)]) -> Line {
    let modes: Vec<serde_json::Value> = modes
        .iter()
        .map(|(f, zeta, sd, label)| {
            json!({
                "f": f, "f_sd": 2.0, "zeta": zeta, "zeta_sd": sd, "amplitude": 0.1,
                "label": label, "harmonic": null, "origin": "free", "time_left": null,
            })
        })
        .collect();
    let line = json!({
        "t": t, "state": state, "reason": "none", "modes": modes,
        "spindle": {"rpm": 1656.0, "source": "told", "locked": true, "notch_hz": 1.5},
        "amplitude": {"f": 900.2, "s": 0.09, "z": -8.1, "verdict": "self-excited"},
    });
    serde_json::from_value(line).expect("a line")
}

fn alarm() -> Alarm {
    Alarm {
        on: 2.126,
        off: None,
        f: 899.7,
        zeta: 0.0004,
        zeta_median: None,
        zeta_deviation: None,
        advice: None,
    }
}

/// A ridge at 900 Hz over a slope.
fn spectra(model: &mut Model, rows: u32) {
    for _ in 0..rows {
        let level = |bin: i32| {
            if (68..72).contains(&bin) {
                0.0
            } else {
                -10.0 - bin as f32 * 0.2
            }
        };
        model.row(Row::Levels((0..256).map(level).collect()), 0.2);
    }
}

fn chattering() -> Model {
    let title = "standard input · 48000 Hz · band 300:2500 Hz · order 8,7";
    let mut model = Model::new(title.to_owned(), (300.0, 2500.0), 0.01);
    spectra(&mut model, 30);
    model.news(&News::On(alarm()));
    model.advice = vec![
        "Turn 10700 1/min instead of 9000, feed +19 %: stable with a chance of 71 %. Its pocket goes from 10500 to 10900 1/min.".to_owned(),
    ];
    let modes = [
        (512.3, 0.062, 0.011, "structural"),
        (900.2, 0.0059, 0.0023, "self-excited"),
        (1480.0, 0.21, 0.02, "structural"),
    ];
    model.news(&News::Line(line(4.0, "chatter", &modes)));
    model
}

fn at_a_box() -> (Model, Ui) {
    let mut model = Model::of_a_box("tcp:127.0.0.1:7000".to_owned());
    model.log(None, Kind::Said, "arm".to_owned());
    model.log(
        Some(3.0),
        Kind::Answer,
        "answer to 7: refused: the enable input is open: press it".to_owned(),
    );
    model.message(
        &Telemetry::Status(Status {
            now_us: 3_200_000,
            mode: Mode::Cers,
            stage: Stage::Faulted,
            energised: false,
            contacts: (true, true),
            fault: Some(FaultRecord {
                code: FaultCode::CoilOpen,
                place: 2,
                value: 0.1,
                at_us: 3_100_000,
            }),
            current_a: [0.8, 0.8, 0.0, 0.8],
            heat: 0.1,
            gap_m: [1.5e-4, 1.5e-4],
            pressure_pa: 0.0,
            gauge_m: 0.0,
            supply_v: 48.0,
            limiting: false,
            press_again: true,
            control: ControlMessage {
                turn: 1,
                by: 0xa1b2_c3d4,
                why: Handed::Taken,
                key: false,
            },
        }),
        false,
    );
    let mut ui = Ui::with_input();
    if let Some(input) = &mut ui.input {
        "set monitor.th".chars().for_each(|c| input.insert(c));
    }
    (model, ui)
}

fn drawn(model: &Model, ui: &Ui, (width, height): (u16, u16), silent_s: f64) -> (String, Buffer) {
    let area = Rect::new(0, 0, width, height);
    let mut buffer = Buffer::empty(area);
    let look = Look {
        palette: Palette::None,
        silent_s,
    };
    draw(model, ui, look, area, &mut buffer);
    let row = |y| {
        (0..width)
            .map(|x| buffer[(x, y)].symbol())
            .collect::<String>()
    };
    let text: String = (0..height)
        .map(|y| row(y).trim_end().to_owned() + "\n")
        .collect();
    (text, buffer)
}

fn assert_seen(name: &str, text: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("src/screen/view/pictures")
        .join(name);
    if std::env::var_os("RARMA_WRITE_PICTURES").is_some() {
        crate::output::write(&path, text).expect("written");
    }
    let expected = std::fs::read_to_string(&path).expect("what is expected");
    assert!(
        text == expected,
        "{name}: this is seen:\n{text}\nand not:\n{expected}"
    );
}

#[test]
fn a_monitor_that_hears_chatter_on_a_usual_terminal() {
    let (text, _) = drawn(&chattering(), &Ui::default(), (80, 24), 0.0);
    assert_seen("chatter-80x24.txt", &text);
}

#[test]
fn a_monitor_that_hears_chatter_on_a_roomy_terminal() {
    let (text, _) = drawn(&chattering(), &Ui::default(), (160, 50), 0.0);
    assert_seen("chatter-160x50.txt", &text);
}

#[test]
fn a_box_with_a_fault_and_a_command_half_typed() {
    let (model, ui) = at_a_box();
    let (text, _) = drawn(&model, &ui, (80, 24), 0.0);
    assert_seen("box-80x24.txt", &text);
}

#[test]
fn a_terminal_that_is_too_small_tells_the_state_and_what_to_do() {
    let (text, _) = drawn(&chattering(), &Ui::default(), (40, 10), 0.0);
    assert_seen("small-40x10.txt", &text);
}

#[test]
fn the_help_has_every_key_and_every_command() {
    let (_, ui) = at_a_box();
    let ui = Ui { help: true, ..ui };
    let (text, _) = drawn(&chattering(), &ui, (80, 24), 0.0);
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains(rarma_scenarios::speech::WORDS), "{text}");
    for (_, what, _) in crate::screen::keys::KEYS {
        assert!(words.contains(what), "{what}:\n{text}");
    }
}

#[test]
fn a_source_that_says_nothing_is_no_stable_one() {
    let mut model = chattering();
    model.news(&News::Line(line(5.0, "stable", &[])));
    let (text, _) = drawn(&model, &Ui::default(), (80, 24), 0.5);
    assert!(text.contains("stable: every mode is damped"), "{text}");
    let (text, _) = drawn(&model, &Ui::default(), (80, 24), 7.2);
    assert!(
        text.contains("no samples: nothing has come for 7 s") && !text.contains("stable:"),
        "{text}"
    );
}

#[test]
fn the_state_is_told_without_colour() {
    for (state, sign) in [
        ("chatter", "▲"),
        ("warning", "◆"),
        ("stable", "●"),
        ("idle", "○"),
    ] {
        let mut model = chattering();
        model.news(&News::Line(line(5.0, state, &[])));
        for size in [(60, 18), (80, 24), (160, 50), (30, 5)] {
            let (text, _) = drawn(&model, &Ui::default(), size, 0.0);
            let words = text.to_lowercase();
            assert!(
                words.contains(&format!("{sign} {state}:")),
                "{size:?}:\n{text}"
            );
        }
    }
}

#[test]
fn a_text_from_outside_does_not_leave_its_line() {
    let mut model = chattering();
    model.log(None, Kind::Notice, "a\u{1b}[2Jb\nc".to_owned());
    let (text, _) = drawn(&model, &Ui::default(), (80, 24), 0.0);
    assert!(!text.contains('\u{1b}'), "{text}");
}

proptest! {
    #[test]
    fn whatever_is_to_be_shown_it_fits(
        width in 0..200_u16, height in 0..70_u16, zeta in prop::num::f64::ANY, f in prop::num::f64::ANY,
        words in "\\PC{0,300}", scroll in any::<usize>(), help in any::<bool>(), boxed in any::<bool>(), many in any::<bool>(),
    ) {
        let (mut model, mut ui) = if boxed { at_a_box() } else { (chattering(), Ui::default()) };
        if let Some(line) = &mut model.line {
            line.modes[0].zeta = zeta;
            line.modes[1].f = f;
        }
        model.advice = vec![words.clone()];
        model.log(Some(zeta), Kind::Answer, words.clone());
        if let Some(input) = &mut ui.input {
            words.chars().for_each(|c| InputLine::insert(input, c));
        }
        (ui.scroll, ui.help) = (scroll, help);
        let area = Rect::new(0, 0, width, height);
        let palette = if many { Palette::Many } else { Palette::Basic };
        let look = Look { palette, silent_s: 0.0 };
        let mut buffer = Buffer::empty(area);
        let cursor = draw(&model, &ui, look, area, &mut buffer);
        if let Some(place) = cursor {
            prop_assert!(area.contains(place.into()), "{place:?} in {area:?}");
        }
    }
}
