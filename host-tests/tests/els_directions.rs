//! Promise: a receptance is turned into any direction exactly, and not as the thesis
//! prints it.
//!
//! `cargo test --release -p host-tests --test els_directions -- --nocapture`

use proptest::prelude::*;
use rarma_plants::modal::Mode;
use rarma_rigs::els::{Complex, CutConfig, Limit, PolarPoint, Receptance, extremes, polar_limits};
use std::f64::consts::TAU;

/// Two modes at any angle to u: frequency, damping, stiffness, direction.
type Modes = [(Mode, f64); 2];

fn direct(mode: &Mode, f: f64) -> Complex<f64> {
    let (re, im) = mode.receptance(TAU * f);
    Complex::new(re, im)
}

/// What an exciter along u and v and a sensor along u and v would measure.
fn tensor(modes: &Modes, f: f64) -> Receptance<f64> {
    let shape = |angle: f64| (angle.cos(), angle.sin());
    let sum = |response: fn((f64, f64)) -> f64, force: fn((f64, f64)) -> f64| {
        modes.iter().fold(Complex::ZERO, |sum, (m, angle)| {
            let e = shape(*angle);
            sum + direct(m, f).scale(response(e) * force(e))
        })
    };
    Receptance {
        resp_u_exc_u: sum(|e| e.0, |e| e.0),
        resp_u_exc_v: sum(|e| e.0, |e| e.1),
        resp_v_exc_u: sum(|e| e.1, |e| e.0),
        resp_v_exc_v: sum(|e| e.1, |e| e.1),
    }
}

/// The same without a tensor: the force onto each mode, the mode onto the response.
fn projected(modes: &Modes, f: f64, alpha: f64, beta: f64) -> Complex<f64> {
    modes.iter().fold(Complex::ZERO, |sum, (m, angle)| {
        sum + direct(m, f).scale((alpha - angle).cos() * (beta - angle).cos())
    })
}

/// Eq (63) with eq (64), as printed; its Guv is our `resp_v_exc_u`.
fn printed(g: &Receptance<f64>, alpha: f64, theta: f64) -> Complex<f64> {
    g.resp_u_exc_u.scale(alpha.cos() * (alpha + theta).cos())
        + g.resp_v_exc_v.scale(alpha.sin() * (alpha + theta).sin())
        + g.resp_v_exc_u.scale(theta.cos())
}

fn machine() -> Modes {
    [
        (Mode::from_stiffness(980.0, 0.02, 11.8e6), 0.6),
        (Mode::from_stiffness(1210.0, 0.035, 16e6), 2.3),
    ]
}

#[test]
fn direct_projection_to_twelve_digits() {
    let modes = machine();
    let (mut worst, mut as_printed) = (0.0f64, 0.0f64);
    for i in 0..300 {
        let f = 5.0 + 10.0 * f64::from(i);
        let g = tensor(&modes, f);
        let size = projected(&modes, f, 0.6, 0.6).abs() + projected(&modes, f, 2.3, 2.3).abs();
        for k in 0..36 {
            for l in 0..36 {
                let alpha = f64::from(10 * k).to_radians();
                let theta = f64::from(10 * l).to_radians();
                let want = projected(&modes, f, alpha, alpha + theta);
                let got = g.directional(alpha, alpha + theta);
                worst = worst.max((got - want).abs() / size);
                as_printed = as_printed.max((printed(&g, alpha, theta) - want).abs() / size);
            }
        }
    }
    println!("largest difference {worst:.1e}; the printed form {as_printed:.2}");
    assert!(worst < 1e-12);
    assert!(as_printed > 0.1, "the printed form is another one");
}

proptest! {
    #[test]
    fn any_two_modes_in_any_direction(
        f1 in 100.0..3000.0f64, f2 in 100.0..3000.0f64,
        z1 in 0.001..0.2f64, z2 in 0.001..0.2f64,
        k1 in 1e6..1e9f64, k2 in 1e6..1e9f64,
        a1 in 0.0..6.3f64, a2 in 0.0..6.3f64,
        f in 1.0..4000.0f64, alpha in -7.0..7.0f64, beta in -7.0..7.0f64,
    ) {
        let modes = [
            (Mode::from_stiffness(f1, z1, k1), a1),
            (Mode::from_stiffness(f2, z2, k2), a2),
        ];
        let size: f64 = modes.iter().map(|(m, _)| direct(m, f).abs()).sum();
        let g = tensor(&modes, f);
        let want = projected(&modes, f, alpha, beta);
        prop_assert!((g.directional(alpha, beta) - want).abs() < 1e-12 * size);
        // Reciprocity: force and response change places.
        prop_assert!((g.directional(beta, alpha) - want).abs() < 1e-12 * size);
        let single = Receptance {
            resp_u_exc_u: narrow(g.resp_u_exc_u),
            resp_u_exc_v: narrow(g.resp_u_exc_v),
            resp_v_exc_u: narrow(g.resp_v_exc_u),
            resp_v_exc_v: narrow(g.resp_v_exc_v),
        };
        let small = single.directional(alpha as f32, beta as f32);
        let wide = Complex::new(f64::from(small.re), f64::from(small.im));
        prop_assert!((wide - want).abs() < 3e-6 * size);
    }
}

fn narrow(z: Complex<f64>) -> Complex<f32> {
    Complex::new(z.re as f32, z.im as f32)
}

#[test]
fn limits_all_round_are_those_of_each_direction() {
    // Alike modes in x and y: the same limit everywhere, the closed form.
    let mode = Mode::from_stiffness(980.0, 0.02, 11.8e6);
    let f: Vec<f64> = (0..3000).map(|k| 500.0 + 0.5 * f64::from(k)).collect();
    let round = |modes: &Modes| -> Vec<_> { f.iter().map(|f| tensor(modes, *f)).collect() };
    let cut = CutConfig::orthogonal(2e9);
    let polar = |modes: &Modes, chip: f64| {
        let mut out = [PolarPoint::default(); 72];
        polar_limits(&f, &round(modes), cut, chip, &mut out).expect("a diagram");
        out
    };
    let want = 2.0 * 11.8e6 * 0.02 * 1.02 / 2e9;
    let alike = [(mode, 0.0), (mode, TAU / 4.0)];
    for p in polar(&alike, 0.0) {
        assert!((p.limit.width_m() / want - 1.0).abs() < 1e-4);
    }
    // Force and chip thickness across each other: nothing regenerates.
    for p in polar(&alike, TAU / 4.0) {
        assert_eq!(p.limit, Limit::Unlimited);
    }
    // One mode: b ∝ 1/cos², nothing across it.
    let stiff = Mode::from_stiffness(980.0, 0.02, 1e30);
    let one = polar(&[(mode, 0.0), (stiff, TAU / 4.0)], 0.0);
    for p in one {
        let c = p.angle.cos().powi(2);
        if c > 1e-3 {
            assert!((p.limit.width_m() * c / want - 1.0).abs() < 1e-4, "{p:?}");
        }
    }
    let ends = extremes(&one).expect("points");
    assert_eq!(ends.worst.angle % (TAU / 2.0), 0.0);
    assert_eq!(ends.best.limit, Limit::Unlimited);
    // Overdamped: Re G ≥ 0 up to far above the band, so there is no limit.
    let soft = Mode::from_stiffness(1e6, 0.9, 11.8e6);
    for p in polar(&[(soft, 0.0), (soft, 1.0)], 0.0) {
        assert_eq!(p.limit, Limit::Unlimited);
    }
}
