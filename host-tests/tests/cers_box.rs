//! Promise: the box excites a spindle by itself, finds its response by stepped sine, and
//! refuses what it cannot reach before anything is energised. The firmware is the board's; the
//! magnets are those of the plant, with iron, eddy currents, wrong gaps and wrong gains.
//!
//! `cargo test --release -p host-tests --test cers_box -- --nocapture`

use hal_sim::rig::{FaultEvent, FaultKind};
use host_tests::cers_rig::{
    JOB, ask, calibrate, cers, ended, exciting, lines, magnets, real, run_until_ended,
};
use rarma_box::guard::{FaultCode, Mode, Stage};
use rarma_box::wire::{Answer, Command, Refused};
use rarma_rigs::cers::{Direction, ExcitationJob, JobField, OutOfReach, Signal};
use rarma_rigs::els::{Complex, Reading, agreed, fit_modes};

#[test]
fn stepped_sine_on_the_box_finds_the_modes() {
    for (spindle_hz, seconds) in [(0.0, 40.0), (100.0, 80.0)] {
        let started = std::time::Instant::now();
        let job = ExcitationJob { seconds, ..JOB };
        let mut all = cers(3, spindle_hz, Vec::new(), true);
        // Given with outputs off: starts by itself at the working point.
        assert_eq!(ask(&mut all, Command::Excite(job)), Answer::Done);
        assert_eq!(ask(&mut all, Command::Arm), Answer::Done);
        all.run_for(0.5);
        assert_eq!(all.app.supervisor().stage(), Stage::Exciting);
        let end = run_until_ended(&mut all, 1.05 * f64::from(seconds));
        all.run_for(0.1);
        assert_eq!(all.app.supervisor().stage(), Stage::Ready);
        assert_eq!(
            (end.early, end.limited, end.lines),
            (false, 0, JOB.lines),
            "{end:?}"
        );
        let lines = lines(&all);
        let truth = magnets().structure.at(spindle_hz);
        let exact = |f_hz: f64, to: usize| {
            truth.iter().fold(Complex::ZERO, |sum, m| {
                let r = f_hz / m.mode.f_hz;
                let h = Complex::new(1.0 - r * r, 2.0 * m.mode.zeta * r).inverse();
                let shape = m.x * if to == 0 { m.x } else { m.y };
                sum + h.scale(shape / m.mode.stiffness_n_per_m)
            })
        };
        assert!(f64::from(job.seconds) > 0.0);
        let (mut square, mut stated, mut worst) = (0.0, 0.0, 0.0f64);
        for line in &lines {
            assert!(line.trusted && line.axis == 0);
            let (re, im) = line.receptance[0];
            let h = Complex::new(f64::from(re), f64::from(im));
            let e = exact(f64::from(line.f_hz), 0);
            let off = (h - e).abs() / e.abs();
            worst = worst.max(off);
            square += off * off / lines.len() as f64;
            stated += (f64::from(line.sd[0]) / e.abs()).powi(2) * 2.0 / lines.len() as f64;
        }
        println!(
            "{:.0} 1/min: {} lines, receptance off by {:.2} % rms, {:.2} % at most; stated {:.2} %; force {:.1} to {:.1} N; {:.1} s",
            60.0 * spindle_hz,
            lines.len(),
            100.0 * square.sqrt(),
            100.0 * worst,
            100.0 * stated.sqrt(),
            lines.iter().map(|l| l.force_n).fold(f32::MAX, f32::min),
            lines.iter().map(|l| l.force_n).fold(0.0, f32::max),
            started.elapsed().as_secs_f64(),
        );
        // Lines that had to keep away from the spindle may have met.
        let mut lines = lines;
        lines.sort_by(|a, b| a.f_hz.total_cmp(&b.f_hz));
        lines.dedup_by(|a, b| a.f_hz <= b.f_hz + 0.1);
        let f: Vec<f64> = lines.iter().map(|l| f64::from(l.f_hz)).collect();
        let complex = |(re, im): (f32, f32)| Complex::new(f64::from(re), f64::from(im));
        let h: Vec<Complex<f64>> = lines.iter().map(|l| complex(l.receptance[0])).collect();
        let (mut readings, mut fits, mut found) = (Vec::new(), 0, Vec::new());
        for n in 7..=9 {
            if let Ok(fit) = fit_modes::<f64, 44>(&f, &h, n) {
                readings.extend(
                    fit.modes()
                        .iter()
                        .filter(|m| m.zeta < 0.2)
                        .map(|m| Reading {
                            f_hz: m.f_hz,
                            zeta: m.zeta,
                            fit: fits,
                        }),
                );
                fits += 1;
            }
        }
        agreed(&mut readings, fits, 0.01, |m| found.push(m));
        for m in truth.iter().take(7) {
            let near = found
                .iter()
                .min_by(|a, b| {
                    (a.f_hz - m.mode.f_hz)
                        .abs()
                        .total_cmp(&(b.f_hz - m.mode.f_hz).abs())
                })
                .expect("modes");
            let f_off = 100.0 * (near.f_hz / m.mode.f_hz - 1.0);
            let zeta_off = 100.0 * (near.zeta / m.mode.zeta - 1.0);
            println!(
                "  {:7.1} Hz {:5.2} %: {f_off:+.3} %, ζ {zeta_off:+.2} %",
                m.mode.f_hz,
                100.0 * m.mode.zeta,
            );
            assert!(f_off.abs() < 0.3 && zeta_off.abs() < 5.0);
        }
        // Scatter is small; what is left is the law's (gain, lag of the flux at the top).
        assert!((0.001..0.03).contains(&square.sqrt()) && (1e-4..0.01).contains(&stated.sqrt()));
    }
}

#[test]
fn what_is_out_of_reach_is_refused_before_anything_is_energised() {
    let refused = |why| Answer::Refused(Refused::OutOfReach(why));
    let excite = Command::Excite;
    // Not calibrated.
    let mut all = cers(1, 0.0, Vec::new(), false);
    assert_eq!(
        ask(&mut all, excite(JOB)),
        refused(OutOfReach::Uncalibrated)
    );
    calibrate(&mut all, 100);
    all.run_for(0.1);
    assert_eq!(ask(&mut all, excite(JOB)), Answer::Done);
    // Beyond bias, supply, band.
    let noise = ExcitationJob {
        signal: Signal::Noise,
        ..JOB
    };
    let loud = ExcitationJob {
        rms_a: 0.3,
        ..noise
    };
    let why = ask(&mut all, excite(loud));
    assert!(
        matches!(why, Answer::Refused(Refused::OutOfReach(OutOfReach::Current { peak, allowed })) if peak > 0.89 && allowed == 0.8),
        "{why:?}"
    );
    let fast = ExcitationJob {
        high_hz: 8e3,
        rms_a: 0.25,
        ..JOB
    };
    let why = ask(&mut all, excite(fast));
    assert!(
        matches!(why, Answer::Refused(Refused::OutOfReach(OutOfReach::Voltage { needed, there })) if needed > 70.0 && (40.0..42.0).contains(&there)),
        "{why:?}"
    );
    let why = ask(&mut all, excite(ExcitationJob { lines: 1, ..JOB }));
    assert_eq!(why, refused(OutOfReach::Field(JobField::Lines)));
    // A bias that the supply cannot hold: at arming, and the job with it.
    real(&mut all, "cers.resistance", 30.0);
    real(&mut all, "cers.bias", 1.6);
    all.run_for(0.05);
    let why = ask(&mut all, Command::Arm);
    assert!(
        matches!(why, Answer::Refused(Refused::OutOfReach(OutOfReach::Bias { needed, there })) if needed == 48.0 && there < 46.0),
        "{why:?}"
    );
    assert_eq!(all.app.supervisor().stage(), Stage::Off);
    assert_eq!(all.rig.last_on_us(), None);
    // The wrong mode.
    let mut all = cers(1, 0.0, Vec::new(), true);
    all.send(&Command::Start(Mode::Monitor));
    all.run_for(0.05);
    assert!(matches!(
        ask(&mut all, excite(JOB)),
        Answer::Refused(Refused::Denied(_))
    ));
}

#[test]
fn a_sensor_that_is_absent_or_a_spindle_too_fast_keeps_outputs_off() {
    let for_ever = |kind, place| {
        vec![FaultEvent {
            kind,
            place,
            from_us: 0,
            to_us: u64::MAX,
        }]
    };
    for (faults, spindle_hz, code) in [
        (
            for_ever(FaultKind::GapLost, 1),
            0.0,
            FaultCode::GapSensorLost,
        ),
        (Vec::new(), 320.0, FaultCode::Overspeed),
        (
            for_ever(FaultKind::CurrentSensorLost, 2),
            0.0,
            FaultCode::CurrentSensorOffset,
        ),
    ] {
        let mut all = cers(2, spindle_hz, faults, true);
        ask(
            &mut all,
            Command::Excite(ExcitationJob {
                direction: Direction::Y,
                ..JOB
            }),
        );
        ask(&mut all, Command::Arm);
        all.run_for(0.5);
        let fault = all.app.supervisor().fault().map(|f| f.code);
        println!("{code:?}: {fault:?}, on {:?}", all.rig.last_on_us());
        assert_eq!(fault, Some(code));
        assert_eq!(all.rig.last_on_us(), None, "{code:?}");
        assert_eq!(all.app.supervisor().stage(), Stage::Faulted);
    }
}

#[test]
fn a_signal_ends_in_its_time_when_it_is_told_to_and_with_the_outputs() {
    let mut all = exciting(Vec::new());
    // Set points stay where they are while it runs.
    let no = ask(&mut all, Command::Current { a: 1.0 });
    assert!(matches!(no, Answer::Refused(Refused::Denied(_))), "{no:?}");
    let end = run_until_ended(&mut all, 4.0);
    assert_eq!((end.early, end.lines), (false, 0));
    assert!((119_900..=120_200).contains(&end.periods), "{end:?}");
    let part = f64::from(end.limited) / f64::from(end.periods);
    println!(
        "noise of {} A: {:.2} % of the periods held back",
        JOB.rms_a,
        100.0 * part
    );
    assert!(part < 0.01);
    // Told to, from the working point.
    let sweep = ExcitationJob {
        signal: Signal::Sweep,
        ..JOB
    };
    assert_eq!(ask(&mut all, Command::Excite(sweep)), Answer::Done);
    all.run_for(0.5);
    ask(&mut all, Command::Quiet);
    all.run_for(0.05);
    let end = ended(&all).expect("ended");
    assert!(
        end.early && (20_000..23_000).contains(&end.periods),
        "{end:?}"
    );
    assert_eq!(all.app.supervisor().stage(), Stage::Ready);
    // Going down ends it first, softly.
    let prbs = ExcitationJob {
        signal: Signal::Prbs,
        rms_a: 0.1,
        ..JOB
    };
    assert_eq!(ask(&mut all, Command::Excite(prbs)), Answer::Done);
    all.run_for(0.3);
    ask(&mut all, Command::Stop);
    all.run_for(0.3);
    assert_eq!(all.app.supervisor().stage(), Stage::Off);
    assert!(ended(&all).is_some_and(|e| e.early) && all.app.supervisor().fault().is_none());
    assert!(all.rig.plant().current_a.iter().all(|i| *i == 0.0));
}
