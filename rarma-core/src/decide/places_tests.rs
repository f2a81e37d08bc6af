//! Where modes with damping have been.

use super::*;

const PERIOD_S: f64 = 0.002;

fn watch(places: &mut Places<f64>, f: f64, zeta: f64, share: f64, seconds: f64) {
    let config = AlarmConfig::default();
    for _ in 0..(seconds / PERIOD_S) as usize {
        places.age(PERIOD_S);
        let sight = Sight {
            share,
            part: share,
            power: 1.0,
            is_steady: false,
        };
        places.see(f, zeta, &sight, &config, PERIOD_S);
    }
}

#[test]
fn a_mode_is_known_by_the_damping_it_had() {
    let config = AlarmConfig::default();
    let mut places = Places::default();
    watch(&mut places, 980.0, 0.04, 0.5, 0.1);
    assert!(!places.has_grown(980.0, 9.0), "too short");
    watch(&mut places, 980.0, 0.04, 0.5, 1.0);
    assert!(places.has_grown(1000.0, 4.1) && !places.has_grown(1000.0, 3.9));
    assert!(!places.has_grown(1030.0, 9.0), "another place");
    assert!((places.usual_damping(975.0, &config) - 0.04).abs() < 1e-9);
    assert_eq!(places.usual_damping(700.0, &config), 0.02);
    // Undamped it is remembered as it was, for a while.
    watch(&mut places, 980.0, 0.001, 0.9, 4.0);
    assert!(places.has_grown(980.0, 9.0));
    watch(&mut places, 980.0, 0.001, 0.9, 2.0);
    assert!(!places.has_grown(980.0, 9.0));
}

#[test]
fn a_mode_of_low_damping_is_undamped_at_a_third_of_it() {
    let config = AlarmConfig::default();
    let mut places = Places::default();
    assert_eq!(places.threshold(980.0, &config), 0.01);
    watch(&mut places, 980.0, 0.009, 0.5, 0.4);
    assert_eq!(places.threshold(980.0, &config), 0.01, "too short");
    watch(&mut places, 980.0, 0.009, 0.5, 1.0);
    assert!((places.threshold(990.0, &config) - 0.003).abs() < 1e-9);
    assert!((places.usual_damping(990.0, &config) - 0.009).abs() < 1e-9);
    // What reads like a chatter does not make it lower, however long it lasts.
    watch(&mut places, 980.0, 0.0005, 0.9, 4.0);
    assert!((places.threshold(980.0, &config) - 0.003).abs() < 1e-9);
    // A mode with damping keeps the setting.
    watch(&mut places, 500.0, 0.04, 0.5, 1.0);
    assert_eq!(places.threshold(500.0, &config), 0.01);
}

#[test]
fn lines_ghosts_and_whispers_are_no_modes() {
    let mut places = Places::default();
    watch(&mut places, 500.0, 0.001, 0.9, 2.0);
    watch(&mut places, 700.0, 0.5, 0.9, 2.0);
    watch(&mut places, 900.0, 0.03, 0.01, 2.0);
    watch(&mut places, f64::NAN, f64::NAN, f64::NAN, 2.0);
    for f in [500.0, 700.0, 900.0, f64::NAN] {
        assert!(!places.has_grown(f, 1e9));
    }
    // More modes than places: the one unseen for longest goes.
    for k in 0..12 {
        watch(&mut places, 300.0 * 1.1f64.powi(k), 0.03, 0.5, 0.3);
    }
    assert!(!places.has_grown(300.0, 9.0));
    assert!(places.has_grown(300.0 * 1.1f64.powi(11), 9.0));
}

#[test]
fn a_line_that_rose_is_remembered_for_a_second() {
    let mut places = Places::<f64>::default();
    places.rose(900.0, true, &AlarmConfig::default());
    assert!(places.has_risen(905.0) && !places.has_risen(950.0));
    assert!(!places.has_grown(900.0, 1e9), "it was never damped");
    for _ in 0..520 {
        places.age(PERIOD_S);
    }
    assert!(!places.has_risen(905.0));
}

#[test]
fn what_may_always_have_been_is_no_news() {
    let config = AlarmConfig::default();
    let mut places = Places::default();
    assert!(
        !places.is_news(980.0, 9.0, false, &config),
        "nothing is known"
    );
    assert!(
        places.is_news(980.0, 9.0, true, &config),
        "idle was without it"
    );
    watch(&mut places, 980.0, 0.04, 0.5, 0.4);
    assert!(
        !places.is_news(980.0, 1.9, false, &config),
        "damped, for too short"
    );
    assert!(places.is_news(980.0, 2.1, false, &config), "and louder");
    watch(&mut places, 980.0, 0.04, 0.5, 0.5);
    assert!(
        places.is_news(980.0, 0.1, false, &config),
        "it has lost its damping"
    );
    // One of low damping is loud now and then.
    watch(&mut places, 500.0, 0.006, 0.5, 2.0);
    assert!(!places.is_news(500.0, 13.0, false, &config));
    assert!(!places.is_news(500.0, 13.0, true, &config));
    assert!(places.is_news(500.0, 15.0, false, &config));
    places.rose(500.0, true, &config);
    assert!(!places.is_news(500.0, 13.0, false, &config));
    // A line that rose where nothing was known.
    places.rose(1400.0, false, &config);
    assert!(!places.is_news(1400.0, 1.0, false, &config) && places.has_risen(1400.0));
    places.rose(1400.0, true, &config);
    assert!(places.is_news(1400.0, 1.0, false, &config));
}

#[test]
fn what_was_learnt_beside_lines_is_forgotten_with_them() {
    let config = AlarmConfig::default();
    let mut places = Places::default();
    watch(&mut places, 980.0, 0.04, 0.5, 2.0);
    places.begin_anew();
    assert!(!places.is_news(980.0, 9.0, false, &config));
    watch(&mut places, 980.0, 0.04, 0.5, 0.45);
    assert!(
        !places.is_news(980.0, 9.0, false, &config),
        "the model follows"
    );
    watch(&mut places, 980.0, 0.04, 0.5, 1.0);
    assert!(places.is_news(980.0, 9.0, false, &config));
}

#[test]
fn damping_is_lost_at_the_same_loudness_or_a_line_has_come() {
    let config = AlarmConfig::default();
    let mut places = Places::default();
    watch(&mut places, 980.0, 0.04, 0.5, 1.0);
    assert!(!places.keeps_its_power(980.0, 1.0), "damped a moment ago");
    watch(&mut places, 980.0, 0.001, 0.5, 0.1);
    assert!(places.keeps_its_power(985.0, 1.9) && !places.keeps_its_power(980.0, 2.1));
    assert!(!places.keeps_its_power(1100.0, 0.1), "another place");
    // Two pole pairs at one place: one of them is the mode.
    for _ in 0..100 {
        watch(&mut places, 980.0, 0.04, 0.5, 0.004);
        watch(&mut places, 982.0, 0.001, 0.5, 0.004);
        assert!(!places.keeps_its_power(982.0, 1.0));
    }
    // A line reads damped beside another one, but its amplitude stays.
    let line = Sight {
        share: 0.5,
        part: 0.5,
        power: 1.0,
        is_steady: true,
    };
    for _ in 0..1000 {
        places.age(PERIOD_S);
        places.see(500.0, 0.03, &line, &config, PERIOD_S);
    }
    assert!(!places.keeps_its_power(500.0, 1.0));
}
