use super::phase::{load_of, phase_of, ratio_of};
use super::*;
use crate::decide::{StructuralMode, Structure};
use crate::real::Real;
use core::f64::consts::{PI, TAU};
use proptest::prelude::*;

fn mode(f_hz: f64, zeta: f64) -> StructuralMode<f64> {
    StructuralMode {
        f_hz,
        f_sd: 0.001 * f_hz,
        zeta,
        zeta_sd: 0.0,
    }
}

fn heard(f_hz: f64, spindle_hz: f64, teeth: u32) -> HeardChatter<f64> {
    HeardChatter {
        f_hz,
        f_sd_hz: 0.001 * f_hz,
        spindle_hz,
        spindle_sd_hz: 0.0,
        teeth,
    }
}

/// Real part of 1/(1 − r² + 2jζr) and its phase.
fn receptance(r: f64, zeta: f64) -> (f64, f64) {
    let (a, b) = (1.0 - r * r, -2.0 * zeta * r);
    (a / (a * a + b * b), b.atan2(a))
}

/// The textbook, by a scan: a chatter frequency, the limit load −1/(2·Re G)/2 and the speeds
/// f/(N·(j + ε/2π)), ε = 3π + 2ψ. The least limit at a speed over j, for one tooth.
fn limit_by_scan(natural_hz: f64, zeta: f64, spindle_hz: f64) -> f64 {
    let mut least = f64::INFINITY;
    let mut before: Option<(f64, f64)> = None;
    for i in 1..400_000 {
        let r = 1.0 + f64::from(i) * 2e-6;
        let (re, psi) = receptance(r, zeta);
        let load = -0.25 / re;
        let part = (3.0 * PI + 2.0 * psi) / TAU;
        // Waves less the fraction are a whole number where the two agree.
        let off = r * natural_hz / spindle_hz - part;
        if let Some((last, load_before)) = before
            && last.floor() < off.floor()
            && off.floor() >= 0.0
        {
            least = least.min(load.min(load_before));
        }
        before = Some((off, load));
    }
    least
}

#[test]
fn lobes_are_those_of_the_textbook() {
    let (natural, zeta) = (500.0, 0.02);
    for spindle in [60.0, 75.3, 101.0, 160.0, 240.0] {
        let limit = limit_by_scan(natural, zeta, spindle);
        let lobes = |load| Lobes::new(natural, zeta, load, Side::Above, 1);
        assert!(lobes(0.995 * limit).is_stable(spindle), "{spindle}");
        assert!(!lobes(1.005 * limit).is_stable(spindle), "{spindle}");
        let margin = lobes(0.4 * limit).margin(spindle);
        assert!((margin - 2.5).abs() < 0.02, "{spindle}: {margin}");
    }
}

#[test]
fn below_the_least_limit_everything_is_stable() {
    let zeta = 0.03;
    for (side, least) in [
        (Side::Above, zeta * (1.0 + zeta)),
        (Side::Below, zeta * (1.0 - zeta)),
    ] {
        let lobes = |load| Lobes::new(800.0, zeta, load, side, 2);
        assert_eq!(lobes(0.999 * least).most_waves(), None);
        assert!(lobes(1.001 * least).most_waves().is_some());
    }
}

#[test]
fn pockets_end_at_the_number_of_waves_that_is_said() {
    for side in [Side::Above, Side::Below] {
        for (zeta, depth) in [(0.01, 1.5), (0.01, 2.0), (0.02, 3.0)] {
            let lobes = Lobes::new(1000.0, zeta, depth * zeta, side, 1);
            let most = lobes.most_waves().unwrap();
            let any = |pocket: f64| {
                (0..4000).any(|i| {
                    let waves = pocket - 0.6 + 1.2 * f64::from(i) / 4000.0;
                    lobes.is_stable(1000.0 / waves)
                })
            };
            assert!(any((0.9 * most).floor()), "{side:?} {zeta} {depth}");
            assert!(!any((1.1 * most).ceil() + 1.0), "{side:?} {zeta} {depth}");
            // The rule of the module's header.
            let root = (depth * depth - 1.0_f64).sqrt();
            let rule = (0.5 + 2.0 / PI * (1.0 / (depth + root)).atan()) / (2.0 * zeta * root);
            assert!((most / rule - 1.0).abs() < 0.15, "{most} {rule}");
        }
    }
}

#[test]
fn at_the_limit_the_shift_is_that_of_the_phase() {
    for part in [0.15, 0.3, 0.45, 0.55, 0.75, 0.9] {
        let phase = phase_of(4.0 + part);
        assert_eq!(phase.side == Side::Above, part > 0.5);
        let shift = ratio_of(&phase, phase.limit_load(0.01), 0.01) - 1.0;
        assert!((shift + 0.01 * (PI * part).tan()).abs() < 1e-6, "{part}");
    }
}

#[test]
fn depth_comes_back_from_the_frequency() {
    for part in [0.2, 0.35, 0.6, 0.75, 0.92] {
        for depth in [1.05, 1.5, 3.0] {
            let phase = phase_of(6.0 + part);
            let load = depth * phase.limit_load(0.02);
            let found = load_of(&phase, ratio_of(&phase, load, 0.02), 0.02).unwrap();
            assert!((found / load - 1.0).abs() < 1e-4, "{part} {depth}");
            // The wrong side of the mode.
            let mirrored = 2.0 - ratio_of(&phase, load, 0.02);
            assert_eq!(load_of(&phase, mirrored, 0.02), None);
        }
    }
}

#[test]
fn a_speed_of_the_right_pocket_is_proposed() {
    // 1.5 times the limit of its phase, at 3.75 waves.
    let (natural, zeta, teeth) = (1100.0, 0.015, 4);
    let phase = phase_of(3.75);
    let load = 1.5 * phase.limit_load(zeta);
    let f = natural * ratio_of(&phase, load, zeta);
    let heard = heard(f, f / (3.75 * 4.0), teeth);
    let reach = AdviceConfig::reach(0.5 * heard.spindle_hz, 1.5 * heard.spindle_hz);
    let truth = Lobes::new(natural, zeta, load, Side::Above, teeth);
    assert!(!truth.is_stable(heard.spindle_hz));
    let structure = Structure::new(&[mode(natural, zeta)]).unwrap();
    for structure in [Some(&structure), None] {
        let advice = advise(&reach, &heard, structure, &[]).unwrap();
        let best = advice.first().unwrap();
        assert!(truth.is_stable(best.spindle_hz), "{best:?}");
        assert!((2..=4).contains(&best.pocket));
        assert_eq!(best.feed_ratio, best.ratio);
        assert_eq!(advice.of_structure, structure.is_some());
        // Pockets lie below the speeds of the plain rule.
        assert!(best.spindle_hz < f / f64::from(4 * best.pocket));
        let chances: Vec<f64> = advice
            .proposals
            .iter()
            .flatten()
            .map(|p| p.chance)
            .collect();
        assert!(
            chances.windows(2).all(|w| w[0] > w[1] - 0.05),
            "{chances:?}"
        );
    }
}

#[test]
fn many_waves_have_no_pocket_and_what_helps_is_said() {
    let heard = heard(1000.0, 5.0, 1);
    let reach = AdviceConfig::reach(2.5, 7.5);
    let structure = Structure::new(&[mode(980.0, 0.03)]).unwrap();
    let advice = advise(&reach, &heard, Some(&structure), &[]).unwrap();
    assert_eq!(advice.first(), None);
    assert!(advice.waves > advice.most_waves && advice.beyond_hz.is_none());
    assert_eq!(advice.helps[1], Help::SpeedVariation);
}

#[test]
fn a_pocket_above_the_reach_is_told() {
    let heard = heard(1015.0, 100.0, 4);
    let reach = AdviceConfig::reach(98.0, 104.0);
    let structure = Structure::new(&[mode(1000.0, 0.01)]).unwrap();
    let advice = advise(&reach, &heard, Some(&structure), &[]).unwrap();
    assert_eq!(advice.first(), None, "{advice:?}");
    assert!((advice.beyond_hz.unwrap() - 125.0).abs() < 1e-9);
}

#[test]
fn power_ends_the_reach_where_the_feed_of_a_tooth_is_kept() {
    let heard = heard(1128.0, 150.0, 2);
    let mut reach = AdviceConfig::reach(75.0, 225.0);
    reach.most_power = Some(1.05);
    let highest = |reach: &AdviceConfig<f64>| {
        let advice = advise(reach, &heard, None, &[]).unwrap();
        let all = advice.proposals.iter().flatten();
        all.map(|p| p.to_hz).fold(0.0, f64::max)
    };
    assert!(highest(&reach) <= 1.0501 * 150.0);
    reach.keeps_feed = false;
    assert!(highest(&reach) > 1.1 * 150.0);
    reach.keeps_feed = true;
    reach.most_power = Some(0.4);
    assert_eq!(advise(&reach, &heard, None, &[]), Err(AdviceError::Reach));
}

#[test]
fn what_was_tried_counts() {
    let heard = heard(1128.0, 150.0, 2);
    let reach = AdviceConfig::reach(75.0, 225.0);
    let before = *advise(&reach, &heard, None, &[]).unwrap().first().unwrap();
    let tried = |stable| {
        let cut = if stable {
            KnownCut::stable(before.spindle_hz)
        } else {
            KnownCut::chattered(before.spindle_hz, None)
        };
        *advise(&reach, &heard, None, &[cut])
            .unwrap()
            .first()
            .unwrap()
    };
    assert!(tried(true).chance > before.chance);
    let other = tried(false);
    assert!((other.spindle_hz / before.spindle_hz - 1.0).abs() > 0.01);
}

/// Where a mode of 1085 Hz and 3 % chatters at a load of 0.05, by the waves that fit its own frequency.
fn chatter_at(spindle_hz: f64, teeth: u32) -> f64 {
    let mut f = 1085.0;
    for _ in 0..200 {
        let phase = phase_of(f / (spindle_hz * f64::from(teeth)));
        f += 0.1 * (1085.0 * ratio_of(&phase, 0.05, 0.03) - f);
    }
    f
}

#[test]
fn frequencies_at_other_speeds_tell_the_mode() {
    let reach = AdviceConfig::reach(75.0, 225.0);
    let first = heard(chatter_at(150.0, 2), 150.0, 2);
    let known = [161.0, 120.0, 118.0].map(|hz| {
        let f = chatter_at(hz, 2);
        KnownCut::chattered(hz, Some((f, 0.002 * f)))
    });
    let alone = advise(&reach, &first, None, &[]).unwrap();
    let learnt = advise(&reach, &first, None, &known).unwrap();
    let off = |advice: &Advice<f64>| (advice.natural_hz / 1085.0 - 1.0).abs();
    let (before, after) = (off(&alone), off(&learnt));
    assert!(before > 0.01 && after < 0.005, "{before} {after}");
}

#[test]
fn a_chatter_of_another_mode_is_told_apart() {
    let reach = AdviceConfig::reach(75.0, 225.0);
    let first = heard(1128.0, 150.0, 2);
    let alone = *advise(&reach, &first, None, &[]).unwrap().first().unwrap();
    // At the proposed speed another mode is heard, and one like it a little faster.
    let other = |ratio: f64| {
        KnownCut::chattered(ratio * alone.spindle_hz, Some((1790.0, 3.0))).of_depth(1.2)
    };
    let learnt = advise(&reach, &first, None, &[other(1.0), other(1.01)]).unwrap();
    // The mode that is asked about is what it was; the speed is not so good any more.
    assert!(
        (learnt.natural_hz / advise(&reach, &first, None, &[]).unwrap().natural_hz - 1.0).abs()
            < 1e-9
    );
    let still = learnt
        .proposals
        .iter()
        .flatten()
        .find(|p| (p.spindle_hz / alone.spindle_hz - 1.0).abs() < 0.005);
    assert!(
        still.is_none_or(|p| p.chance < 0.8 * alone.chance),
        "{still:?} {alone:?}"
    );
}

#[test]
fn of_speeds_alike_the_quieter_goes_first() {
    let config = AdviceConfig::reach(75.0, 225.0);
    let chance = |hz: f64| match hz {
        100.0..110.0 => 0.9,
        180.0..190.0 => 0.95,
        200.0..210.0 => 0.1,
        _ => 0.0,
    };
    let advise = |vibration: fn(f64) -> f64| {
        let heard = heard(1000.0, 150.0, 2);
        let advice = advise_by(&config, &heard, None, &[], chance, vibration).unwrap();
        let proposals = advice.proposals.into_iter().flatten();
        proposals.collect::<Vec<Proposal<f64>>>()
    };
    let is = |p: &Proposal<f64>, from: f64| (from..from + 10.0).contains(&p.spindle_hz);
    let alike = advise(|_| 1e-6);
    assert!(is(&alike[0], 180.0) && is(&alike[1], 100.0), "{alike:?}");
    // Louder by far: it goes last, with the same chance; what is not likely does not go first however quiet.
    let loud = advise(|hz| {
        if hz < 150.0 {
            1e-6
        } else if hz < 195.0 {
            1e-5
        } else {
            1e-12
        }
    });
    assert!(is(&loud[0], 100.0) && is(&loud[1], 180.0), "{loud:?}");
    assert_eq!(loud[0].chance, alike[1].chance);
    // Within a pocket its quiet side.
    let sided = advise(|hz| if hz < 185.0 { 1e-5 } else { 1e-6 });
    let upper = sided.iter().find(|p| is(p, 180.0)).expect("still there");
    assert!(
        upper.spindle_hz > 185.0 && upper.from_hz < 182.0,
        "{upper:?}"
    );
}

#[test]
fn single_precision_says_the_same() {
    let narrow = |x: f64| x as f32;
    for (f, n, teeth) in [(1128.0, 150.0, 2), (700.0, 61.0, 3), (2010.0, 210.0, 6)] {
        let wide = heard(f, n, teeth);
        let single = HeardChatter {
            f_hz: narrow(wide.f_hz),
            f_sd_hz: narrow(wide.f_sd_hz),
            spindle_hz: narrow(wide.spindle_hz),
            spindle_sd_hz: 0.0,
            teeth,
        };
        let a = advise(&AdviceConfig::reach(0.5 * n, 1.5 * n), &wide, None, &[]).unwrap();
        let reach = AdviceConfig::reach(narrow(0.5 * n), narrow(1.5 * n));
        let b = advise(&reach, &single, None, &[]).unwrap();
        assert!((a.best_chance - b.best_chance.to_f64()).abs() < 0.02);
        let (a, b) = (a.first().unwrap(), b.first().unwrap());
        assert!((a.spindle_hz / b.spindle_hz.to_f64() - 1.0).abs() < 0.01);
    }
}

#[test]
fn what_is_out_of_range_is_named() {
    let good = heard(1000.0, 100.0, 2);
    let reach = AdviceConfig::reach(50.0, 150.0);
    let says = |reach: &AdviceConfig<f64>, heard: &HeardChatter<f64>| {
        advise(reach, heard, None, &[]).unwrap_err()
    };
    for (low, high) in [
        (0.0, 1.0),
        (2.0, 1.0),
        (1.0, 4.1),
        (f64::NAN, 1.0),
        (1.0, f64::NAN),
    ] {
        let bad = AdviceConfig::reach(low, high);
        assert_eq!(says(&bad, &good), AdviceError::Reach);
    }
    let with = |f: fn(&mut AdviceConfig<f64>)| {
        let mut bad = reach;
        f(&mut bad);
        says(&bad, &good)
    };
    assert_eq!(with(|c| c.most_power = Some(0.0)), AdviceError::Power);
    assert_eq!(with(|c| c.least_chance = 1.0), AdviceError::Chance);
    assert_eq!(with(|c| c.hold = f64::NAN), AdviceError::Hold);
    let of = |f: fn(&mut HeardChatter<f64>)| {
        let mut bad = good;
        f(&mut bad);
        says(&reach, &bad)
    };
    assert_eq!(of(|h| h.f_hz = f64::INFINITY), AdviceError::Frequency);
    assert_eq!(of(|h| h.f_sd_hz = -1.0), AdviceError::Deviation);
    assert_eq!(of(|h| h.spindle_hz = 0.0), AdviceError::Speed);
    assert_eq!(of(|h| h.teeth = 0), AdviceError::Teeth);
    let odd = KnownCut::stable(f64::NAN);
    assert_eq!(advise(&reach, &good, None, &[odd]), Err(AdviceError::Speed));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever is heard, what is said is a number within reach.
    #[test]
    fn whatever_is_heard_the_answer_is_sound(
        f in 1.0f32..30_000.0, n in 0.01f32..2000.0, teeth in 1u32..1000,
        low in 0.3f32..0.99, natural in 1.0f32..30_000.0, zeta in -0.9f32..0.9,
        f_sd in 0.0f32..1e4, known in any::<bool>(),
    ) {
        let heard = HeardChatter { f_hz: f, f_sd_hz: f_sd, spindle_hz: n, spindle_sd_hz: f_sd, teeth };
        let reach = AdviceConfig::reach(low * n, 1.1 * n);
        let at_rest = StructuralMode { f_hz: natural, f_sd, zeta, zeta_sd: 0.0 };
        let structure = Structure::new(&[at_rest; 3]).unwrap();
        let one = if known { KnownCut::stable(0.9 * n) } else { KnownCut::chattered(0.9 * n, Some((1.01 * f, 0.1))) };
        let tried = [one.of_depth(low); 40];
        let advice = advise(&reach, &heard, known.then_some(&structure), &tried).unwrap();
        prop_assert!((0.0..=1.001).contains(&advice.best_chance));
        for p in advice.proposals.iter().flatten() {
            prop_assert!(p.spindle_hz >= 0.999 * reach.least_hz && p.spindle_hz <= 1.001 * reach.most_hz);
            prop_assert!(p.chance.is_finite() && p.margin >= 1.0 && p.spindle_sd_hz.is_finite());
            prop_assert!(p.from_hz <= p.spindle_hz && p.spindle_hz <= p.to_hz);
        }
    }
}
