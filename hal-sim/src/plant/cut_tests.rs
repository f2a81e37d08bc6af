use super::*;
use core::f64::consts::TAU;

const FS: f64 = 48_000.0;

/// Amplitude of a line between two times, Hann window.
fn line(y: &[f64], from: f64, to: f64, f_hz: f64) -> f64 {
    let part = &y[(from * FS) as usize..(to * FS) as usize];
    let n = part.len() as f64;
    let (mut re, mut im) = (0.0, 0.0);
    for (i, v) in part.iter().enumerate() {
        let i = i as f64;
        let window = 1.0 - (TAU * i / n).cos();
        let (s, c) = (TAU * f_hz * i / FS).sin_cos();
        re += v * window * c;
        im += v * window * s;
    }
    2.0 * re.hypot(im) / n
}

/// Frequency of the strongest line between two frequencies, in steps of 1 Hz.
fn strongest(y: &[f64], from: f64, to: f64, low: u32, high: u32) -> (f64, f64) {
    (low..=high)
        .map(|f| (f64::from(f), line(y, from, to, f64::from(f))))
        .fold(
            (0.0, 0.0),
            |best, now| if now.1 > best.1 { now } else { best },
        )
}

fn rms(y: &[f64], from: f64, to: f64) -> f64 {
    let part = &y[(from * FS) as usize..(to * FS) as usize];
    (part.iter().map(|v| v * v).sum::<f64>() / part.len() as f64).sqrt()
}

#[test]
fn the_demonstration_is_what_it_says() {
    let mut cut = VirtualCut::new(Scenario::chatter_onset(1)).expect("valid");
    let truth = cut.truth().clone();
    let (onset, end) = (truth.onset_s.expect("onset"), truth.end_s.expect("end"));
    let chatter = truth.chatter_hz.expect("chatter frequency");
    assert!(onset > 3.0 && onset < 6.0 && end > 8.0, "{onset} {end}");
    assert_eq!(truth.cut_s, Some((1.0, 8.1)));
    let order = chatter / truth.spindle_hz;
    assert!(
        (order - order.round()).abs() * truth.spindle_hz > 8.0,
        "{order}"
    );

    let mut y = Vec::with_capacity(cut.len());
    let mut swing = [0.0_f64; 9];
    while let Some(reading) = cut.next() {
        y.push(f64::from(reading.value));
        let m = cut.machine();
        let size = m.position_m[0].hypot(m.position_m[1]);
        let second = &mut swing[(m.t as usize).min(8)];
        *second = second.max(size);
    }
    assert_eq!(y.len(), 9 * 48_000);
    assert_eq!(cut.microphone().clipped(), 0);

    // Three teeth are always in a slot: the mean force is steady, and the stable
    // cut is heard as broadband noise ...
    assert!(rms(&y, 2.0, 3.0) > 2.0 * rms(&y, 0.0, 1.0));
    // ... with a displacement of micrometres, in chatter of tens of them and no more.
    assert!(swing[2] > 2e-6 && swing[2] < 40e-6, "{swing:?}");
    assert!(swing[7] > 2.0 * swing[2] && swing[7] < 300e-6, "{swing:?}");
    assert!(rms(&y, 7.0, 7.9) > 5.0 * rms(&y, 2.0, 3.0));
    let (early, late) = (rms(&y, 6.6, 7.2), rms(&y, 7.3, 7.9));
    assert!(
        (late / early - 1.0).abs() < 0.15,
        "not limited: {early} {late}"
    );
    assert!(rms(&y, 8.5, 9.0) < 0.5 * rms(&y, 2.0, 3.0));
    let peak = y.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    assert!(peak > 0.15 && peak < 0.7, "peak {peak}");

    // The chatter frequency is the predicted one, at growth and at full size.
    for (from, to) in [(onset + 0.5, onset + 1.0), (7.0, 7.9)] {
        let (f, _) = strongest(&y, from, to, 850, 1250);
        assert!((f / chatter - 1.0).abs() < 0.02, "{f} {chatter}");
    }
    let before = line(&y, 2.0, 3.0, chatter);
    assert!(line(&y, 7.0, 7.9, chatter.round() + 10.0) > before);
}

#[test]
fn the_limit_agrees_with_the_zero_order_method() {
    let scenario = Scenario::chatter_onset(1);
    let truth = Truth::of(&scenario.milling).expect("valid");
    let zero_order = milling_limit(&scenario.milling).expect("limit").depth_m;
    let limit = truth.limit_depth_m.expect("limit");
    assert!(
        (limit / zero_order - 1.0).abs() < 0.04,
        "{limit} {zero_order}"
    );
    let documented = 1.094e-3;
    assert!((limit / documented - 1.0).abs() < 0.005, "{limit}");
}

#[test]
fn seeds_repeat_to_the_bit_and_differ() {
    let run = |seed| -> Vec<i32> {
        let mut scenario = Scenario::shipped("chatter-onset", seed).expect("shipped");
        scenario.milling.depth = Schedule::constant(1e-3);
        scenario.duration_s = 0.1;
        VirtualCut::new(scenario)
            .expect("valid")
            .map(|r| r.code)
            .collect()
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
    assert!(Scenario::shipped("nothing", 1).is_none());
}

#[test]
fn a_scenario_without_a_limit_has_none() {
    let mut config = Scenario::chatter_onset(1).milling;
    config.modes_x.clear();
    config.modes_y.clear();
    let truth = Truth::of(&config).expect("valid");
    assert_eq!(
        (truth.limit_depth_m, truth.onset_s, truth.chatter_hz),
        (None, None, None)
    );
}
