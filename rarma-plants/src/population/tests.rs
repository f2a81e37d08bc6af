//! The draw itself: that it repeats, covers its ranges, and that its truth is true.

use super::before::Before;
use super::ranges as r;
use super::state::Cutting;
use super::*;
use crate::cut::Machine;
use crate::process::{Contact, ForceNoise, Schedule};
use crate::turning::Turning;

#[test]
fn a_seed_repeats_to_the_bit_and_another_is_another() {
    let hear = |seed| Cut::draw(seed).and_then(|cut| cut.hear()).expect("drawn");
    let (a, b, c) = (hear(3), hear(3), hear(4));
    assert_eq!(a.samples, b.samples);
    assert_ne!(a.samples, c.samples);
}

#[test]
fn rooms_and_sensors_come_as_often_as_the_ranges_say() {
    let draws = 4000;
    let (mut tones, mut mains, mut speech, mut folds, mut clips, mut slow) = (0, 0, 0, 0, 0, 0);
    for seed in 0..draws {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let room = Room::draw(&mut rng, 5.0);
        let sensor = Sensor::draw(&mut rng);
        tones += u32::from(!room.tones.is_empty());
        mains += u32::from(room.mains.is_some());
        speech += u32::from(room.speech.is_some());
        folds += u32::from(sensor.folds > 1);
        clips += u32::from(sensor.clips.is_some());
        slow += u32::from(sensor.fs_hz < 2000.0);
        for tone in &room.tones {
            assert!((r::TONES.2.low..=r::TONES.2.high).contains(&tone.f_hz));
        }
    }
    // From 44.1 kHz on a sampler is fast enough to fold nothing: four rates of seven are left.
    for (count, probability, what) in [
        (tones, r::TONES.0, "tones"),
        (mains, r::MAINS.0, "mains"),
        (speech, r::SPEECH.0, "speech"),
        (folds, r::UNFILTERED * 4.0 / 7.0, "folds"),
        (clips, r::CLIPPED.0, "clips"),
        (slow, 1.0 / 7.0, "slow"),
    ] {
        let n = draws as f64;
        let sd = (n * probability * (1.0 - probability)).sqrt();
        let off = (f64::from(count) - n * probability) / sd;
        assert!(
            off.abs() < 4.0,
            "{what}: {count}, {off:.1} standard deviations off"
        );
    }
}

#[test]
fn machines_and_courses_lie_in_their_ranges_and_reach_far_into_them() {
    let within = |span: r::Span, x: f64| (span.low * 0.999..=span.high * 1.001).contains(&x);
    let (mut turned, mut teeth, mut modes, mut courses) = (0, [0; 9], [0; 5], [0; 4]);
    let (mut slowest, mut fastest) = (f64::INFINITY, 0.0_f64);
    let (mut shallow, mut deep) = (f64::INFINITY, 0.0_f64);
    for seed in 0..60 {
        let cut = Cut::draw(seed).expect("drawn");
        let rpm = 60.0 * cut.spindle_hz();
        assert!(within(r::SPEED_RPM, rpm), "seed {seed}: {rpm}");
        let all = cut.process().modes();
        for shaped in &all {
            assert!(within(r::MODE_HZ, shaped.mode.f_hz), "seed {seed}");
            assert!(within(r::ZETA, shaped.mode.zeta), "seed {seed}");
        }
        if matches!(cut.process(), Process::Turning(_)) {
            assert!(within(r::TURNED_RPM, rpm), "seed {seed}: {rpm}");
            turned += 1;
        }
        for (_, hz) in cut.speeds() {
            let low = r::RUN_UP.1.low.min(1.0 - r::OVERRIDE.1.high);
            assert!((low..=1.0 + r::OVERRIDE.1.high).contains(&(hz / cut.spindle_hz())));
        }
        teeth[cut.teeth()] += 1;
        modes[all.len()] += 1;
        courses[cut.course() as usize] += 1;
        (slowest, fastest) = (slowest.min(rpm), fastest.max(rpm));
        let part = cut.limit_part();
        (shallow, deep) = (shallow.min(part), deep.max(part));
        assert!((r::SHALLOW.low..=r::DEEP.high).contains(&part));
        assert!(within(r::LENGTH_S, cut.length_s()));
        let stretches = cut.stretches();
        assert!(stretches[0].from_s <= 0.0);
        assert!(stretches.windows(2).all(|w| w[0].from_s < w[1].from_s));
    }
    assert!((4..24).contains(&turned), "{turned}");
    assert!(teeth[1..].iter().all(|n| *n > 0), "{teeth:?}");
    assert!(modes[1..].iter().all(|n| *n > 0), "{modes:?}");
    assert!(courses.iter().all(|n| *n > 5), "{courses:?}");
    assert!(slowest < 500.0 && fastest > 12_000.0, "{slowest} {fastest}");
    assert!(shallow < 0.2 && deep > 1.85, "{shallow} {deep}");
}

#[test]
fn a_loud_tone_that_comes_with_the_cut_is_undecidable_and_one_heard_before_is_not() {
    let first = |course| {
        (0..80)
            .map(|seed| Cut::draw(seed).expect("drawn"))
            .find(|cut| cut.course() == course && cut.sensor.fs_hz > 6000.0)
            .expect("each comes in four")
    };
    let with = |mut cut: Cut, level_db, f_hz| {
        cut.room.neighbour = None;
        cut.room.tones = vec![room::Tone {
            f_hz,
            level_db,
            wander: 1e-4,
            on_s: (f64::NEG_INFINITY, f64::INFINITY),
        }];
        cut.undecidable()
    };
    let (at_first, entry) = (first(Course::AtFirst), first(Course::Entry));
    assert!(with(at_first.clone(), -3.0, 700.0));
    assert!(!with(at_first.clone(), -12.0, 700.0));
    assert!(!with(at_first, -3.0, 100.0), "out of the band");
    assert!(!with(entry, -3.0, 700.0), "heard in air");
}

/// A stable cut has no chatter, however much its forced lines are changed by regeneration.
#[test]
fn in_stable_cuts_there_is_no_chatter() {
    let mut quiet = 0;
    for seed in 0..24 {
        let cut = Cut::draw(seed).expect("drawn");
        let unstable = cut
            .stretches()
            .iter()
            .any(|s| s.cutting == Cutting::Unstable);
        if unstable {
            continue;
        }
        let heard = cut.hear().expect("heard");
        assert!(heard.chatter_s.is_empty() && heard.chatter_hz.is_none());
        quiet += 1;
    }
    assert!(quiet > 4, "{quiet}");
}

/// The truth of the delay equation against the time simulation, which shares nothing with
/// it but the parameters: without any noise, a disturbance dies away or grows.
#[test]
fn what_is_called_unstable_grows_and_what_is_called_stable_dies_away() {
    let (mut grown, mut died) = (0, 0);
    for seed in 0..60 {
        let cut = Cut::draw(seed).expect("drawn");
        let steady = cut.course() == Course::AtFirst && cut.stretches().len() == 1;
        let (f_hz, zeta) = cut.operational();
        // Near the limit it would take long; a changing speed has no one answer.
        if !steady || zeta.abs() < 0.003 || cut.speeds().len() > 1 {
            continue;
        }
        let mut process = cut.process().clone();
        match &mut process {
            Process::Milling(c) => {
                c.contact = Contact::Linear;
                c.noise = ForceNoise::default();
                c.feed_per_tooth_m = 0.0;
                c.runout_m = Vec::new();
                c.min_step_rate_hz *= 2.0;
            }
            Process::Turning(c) => {
                c.contact = Contact::Linear;
                c.noise = ForceNoise::default();
                c.feed_m = 0.0;
                c.min_step_rate_hz *= 2.0;
            }
        }
        let mut machine = Machine::new(&process).expect("valid");
        match &mut machine {
            Machine::Milling(m) => {
                let others = m.config().modes_other.len();
                (0..others).for_each(|i| m.disturb(2, i, 1e-7, 0.0));
            }
            Machine::Turning(m) => {
                let modes = m.config().modes.len();
                (0..modes).for_each(|i| m.disturb(i, 1e-7, 0.0));
            }
        }
        // A fixed number of e-foldings of the dominant root, between two whole windows.
        let e_folding_s = 1.0 / (zeta.abs() * core::f64::consts::TAU * f_hz);
        let window_s = (4.0 / cut.spindle_hz()).max(4.0 / f_hz);
        let mut level = |until_s: f64| {
            let (mut sum, mut count, mut t) = (0.0, 0, 0.0);
            while t < until_s {
                let s = machine.step();
                t = s.t;
                if t > until_s - window_s {
                    sum += s.position_m[0].powi(2) + s.position_m[1].powi(2);
                    count += 1;
                }
            }
            (sum / f64::from(count.max(1))).sqrt()
        };
        let begun_s = 2.0 * window_s + e_folding_s;
        let before = level(begun_s);
        let after = level(begun_s + 3.0 * e_folding_s + window_s);
        let rate = (after / before).ln();
        match cut.stretches()[0].cutting {
            Cutting::Unstable => {
                assert!(rate > 1.0, "seed {seed}: unstable, but {rate:.2}");
                grown += 1;
            }
            _ => {
                assert!(rate < -1.0, "seed {seed}: stable, but {rate:.2}");
                died += 1;
            }
        }
    }
    assert!(grown >= 2 && died >= 2, "{grown} {died}");
}

#[test]
fn chatter_is_heard_in_unstable_cuts_only_and_mostly_there() {
    let (mut deep, mut heard_deep) = (0, 0);
    for seed in 100..140 {
        let cut = Cut::draw(seed).expect("drawn");
        let heard = cut.hear().expect("heard");
        let length = heard.samples.len() as f64 / heard.fs_hz;
        assert!((length - cut.length_s()).abs() < 0.01);
        assert!(heard.samples.iter().all(|x| x.abs() <= 1.0));
        let unstable = cut
            .stretches()
            .iter()
            .any(|s| s.cutting == Cutting::Unstable);
        assert!(unstable || heard.chatter_s.is_empty(), "seed {seed}");
        let chatter: f64 = heard.chatter_s.iter().map(|c| c.1 - c.0).sum();
        let quiet = cut.quiet_s(&heard, 0.0, length);
        assert!(chatter + quiet <= length + 0.02, "seed {seed}");
        // Of those in the band of a fast sampler nearly all are heard.
        let (f_hz, zeta) = cut.operational();
        if unstable && zeta < -0.002 && (350.0..2300.0).contains(&f_hz) && heard.fs_hz > 6000.0 {
            deep += 1;
            heard_deep += u32::from(!heard.chatter_s.is_empty());
        }
    }
    assert!(
        deep >= 3 && heard_deep + 1 >= deep,
        "{heard_deep} of {deep}"
    );
}

/// Modes of these machines feed each other, so that they swing up without any regeneration: a
/// tool that met a rigid tool's surface at every pass swung 1800 to 10¹⁰ times as hard in power as in the
/// cut itself, and chatter was said where nothing could be heard. The forces of a rigid tool
/// make nothing grow.
#[test]
fn forced_vibration_does_not_grow_where_modes_feed_each_other() {
    for seed in [20022, 20034, 20122, 20423, 20466] {
        let cut = Cut::draw(seed).expect("drawn");
        let length_s = cut.planned.lead_s + cut.planned.length_s;
        let power = |contact| {
            let mut process = cut.process().clone();
            match &mut process {
                Process::Milling(c) => c.contact = contact,
                Process::Turning(c) => c.contact = contact,
            }
            let mut machine = Machine::new(&process).expect("valid");
            let mut sum = 0.0;
            loop {
                let sample = machine.step();
                sum += sample.sensor[1].iter().map(|v| v * v).sum::<f64>();
                if sample.t >= length_s {
                    return sum;
                }
            }
        };
        let ratio = power(Contact::Rigid) / power(Contact::Real);
        assert!((1e-6..10.0).contains(&ratio), "seed {seed}: {ratio}");
    }
}

/// A rigid tool's force only bends the machine: q = -K·b·f/k, however deep.
#[test]
fn driven_by_a_rigid_tool_a_turned_cut_far_beyond_its_limit_stands_still() {
    let mut process = None;
    for seed in 0..400 {
        let cut = Cut::draw(seed).expect("drawn");
        if let Process::Turning(c) = cut.process()
            && c.modes.len() == 1
        {
            process = Some(c.clone());
            break;
        }
    }
    let mut c = process.expect("one lathe with one mode in 400 cuts");
    c.contact = Contact::Rigid;
    c.noise = ForceNoise::default();
    c.edge_n_per_m = 0.0;
    let depth_m = 3.0 * c.width.largest();
    c.width = Schedule::constant(depth_m);
    let stiffness = c.ks_n_per_m2 * depth_m;
    let want = -stiffness * c.feed_m / c.modes[0].stiffness_n_per_m;
    let settle_s = 12.0 / (c.modes[0].zeta * c.modes[0].omega());
    let mut lathe = Turning::new(*c).expect("valid");
    let mut last = lathe.step();
    while last.t < settle_s {
        last = lathe.step();
    }
    assert!(
        (last.position_m / want - 1.0).abs() < 1e-3,
        "{} {want}",
        last.position_m
    );
}

/// What was heard before: as loud as it says, over the forced vibration of the cut.
#[test]
fn what_was_heard_before_has_its_level() {
    let rms =
        |x: &[f32]| (x.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>() / x.len() as f64).sqrt();
    let mut loud = 0;
    for seed in 0..6 {
        let cut = Cut::draw(seed).expect("drawn");
        let heard = cut.hear().expect("heard");
        // What is hit may ring above half the rate of a slow one.
        if heard.fs_hz < 8000.0 {
            continue;
        }
        let before = |before: Before| before.samples(&cut, &heard).expect("heard");
        let s = |x: f64| (x * heard.fs_hz) as usize;
        let air = before(Before::Air);
        assert_eq!(air.len(), (4.0 * heard.fs_hz).round() as usize);
        let (knock, jet, night) = (
            before(Before::Knock),
            before(Before::Jet),
            before(Before::Night),
        );
        // As before until it is hit, at its loudest then, and quiet at the end.
        let peak = |x: &[f32]| x.iter().fold(0.0, |m: f32, x| m.max(x.abs()));
        let hit = f64::from(peak(&knock[s(1.0)..]));
        let clips = hit > 0.99;
        assert!(peak(&knock[..s(0.99)]) < 0.99 * peak(&knock[s(1.0)..]) || clips);
        // It rings at up to 3 kHz with up to a tenth of damping: 14 % of its peak are lost at its first crest.
        let wanted = 31.6 * heard.reference;
        assert!(
            clips || hit > 0.7 * wanted && hit < 1.6 * wanted,
            "{seed}: {hit} {wanted}"
        );
        loud += u32::from(!clips);
        assert!(rms(&jet[s(1.2)..s(3.8)]) > 3.0 * rms(&jet[s(4.2)..]) || clips);
        // As far as the converter tells them apart.
        let step = 0.5f64.powi(cut.sensor.bits as i32 - 1);
        let day = rms(&night[s(5.1)..]);
        assert!(rms(&night[..s(4.9)]) < 0.2 * day + step, "{seed}");
        let again = before(Before::Cut);
        assert_eq!(again[..heard.samples.len()], heard.samples[..]);
        assert_eq!(
            again.len(),
            heard.samples.len() + (2.0 * heard.fs_hz).round() as usize
        );
    }
    assert!(loud > 0);
}
