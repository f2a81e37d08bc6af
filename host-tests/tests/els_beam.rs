//! Promise: the beam model has the closed-form frequencies, converges with the fourth
//! order, and its link goes from free to grounded.
//!
//! `cargo test --release -p host-tests --test els_beam -- --nocapture`

use rarma_plants::els::beam::{Material, Segment, Theory};
use rarma_plants::els::link::{Link, LinkLaw};
use rarma_plants::els::{Clamping, ElsConfig, ElsModel, NaturalMode, Shape};
use std::f64::consts::{PI, TAU};

const LENGTH_M: f64 = 1.0;
const OUTER_M: f64 = 0.02;

/// Roots of the frequency equations, by their textbook digits.
const CANTILEVER: [f64; 5] = [
    1.875_104_069,
    4.694_091_133,
    7.854_757_438,
    10.995_540_735,
    14.137_168_391,
];
const FREE: [f64; 5] = [
    4.730_040_745,
    7.853_204_624,
    10.995_607_838,
    14.137_165_491,
    17.278_759_657,
];
const PROPPED: [f64; 5] = [
    3.926_602_312,
    7.068_582_746,
    10.210_176_123,
    13.351_768_778,
    16.493_361_431,
];

fn beam(clamping: Clamping, elements: usize, theory: Theory, link: LinkLaw) -> ElsModel {
    ElsModel::new(&ElsConfig {
        holder: vec![Segment {
            length_m: LENGTH_M,
            outer_m: OUTER_M,
            inner_m: 0.0,
            elements,
            material: Material::STEEL,
        }],
        clamping,
        link: Link {
            law: link,
            across: 1.0,
            angle_rad: 0.0,
            loss: 0.0,
        },
        tool_joint_n_per_m: f64::INFINITY,
        theory,
    })
    .expect("a beam")
}

/// Bending frequencies of one plane, Hz, without rigid motions.
fn bending(model: &ElsModel) -> Vec<f64> {
    let modes = model.natural_modes(0.0, 30).expect("modes");
    let found = modes
        .iter()
        .filter(|m: &&NaturalMode| m.shape == Shape::Bending && m.f_hz > 0.1);
    // Both planes have each; they come in pairs.
    found.map(|m| m.f_hz).step_by(2).take(5).collect()
}

fn closed(kl: f64) -> f64 {
    let m = Material::STEEL;
    let gyration = OUTER_M / 4.0;
    (kl / LENGTH_M).powi(2) * gyration * (m.e_pa / m.density_kg_per_m3).sqrt() / TAU
}

#[test]
fn first_five_frequencies_of_three_supports() {
    let pinned: [f64; 5] = core::array::from_fn(|k| PI * (k + 1) as f64);
    for (name, clamping, roots) in [
        ("cantilever", Clamping::Fixed, CANTILEVER),
        ("pinned", Clamping::Pinned, pinned),
        ("free-free", Clamping::Free, FREE),
    ] {
        let model = beam(clamping, 16, Theory::EulerBernoulli, LinkLaw::Constant(0.0));
        let found = bending(&model);
        let worst = found
            .iter()
            .zip(roots)
            .map(|(f, kl)| (f / closed(kl) - 1.0).abs())
            .fold(0.0, f64::max);
        println!("{name:10} worst of five {:.5} %", 100.0 * worst);
        assert_eq!(found.len(), 5);
        assert!(worst < 0.005 && worst > 1e-12, "{name}: {found:?}");
        // From above: Ritz.
        assert!(
            found
                .iter()
                .zip(roots)
                .all(|(f, kl)| *f > closed(kl) * (1.0 - 1e-6))
        );
    }
}

#[test]
fn error_falls_with_the_fourth_power() {
    for (k, kl) in CANTILEVER.into_iter().enumerate().skip(1) {
        let error = |elements: usize| {
            let model = beam(
                Clamping::Fixed,
                elements,
                Theory::EulerBernoulli,
                LinkLaw::Constant(0.0),
            );
            bending(&model)[k] / closed(kl) - 1.0
        };
        let order = (error(8) / error(16)).log2();
        println!("mode {}: order {order:.2}", k + 1);
        assert!((3.7..4.3).contains(&order), "mode {}: {order}", k + 1);
    }
}

#[test]
fn torsion_and_the_pull_of_shear() {
    let model = beam(
        Clamping::Fixed,
        20,
        Theory::Timoshenko,
        LinkLaw::Constant(0.0),
    );
    let m = Material::STEEL;
    let wave = (m.e_pa / (2.0 * (1.0 + m.poisson) * m.density_kg_per_m3)).sqrt();
    let torsion = model
        .natural_modes(0.0, 60)
        .expect("modes")
        .into_iter()
        .find(|x| x.shape == Shape::Torsion)
        .expect("one");
    assert!((torsion.f_hz / (wave / (4.0 * LENGTH_M)) - 1.0).abs() < 1e-3);
    // Shear and rotary inertia lower every mode, the fifth of this slender beam by about
    // ½(kr)²(1 + E/κG) = 1.0 %.
    for (f, kl) in bending(&model).iter().zip(CANTILEVER) {
        let off = f / closed(kl) - 1.0;
        assert!((-0.012..0.0).contains(&off), "{off}");
    }
}

#[test]
fn link_from_free_to_grounded() {
    let first = |k: f64| {
        bending(&beam(
            Clamping::Fixed,
            16,
            Theory::EulerBernoulli,
            LinkLaw::Constant(k),
        ))
    };
    let tip = 3.0 * 2.1e11 * PI / 64.0 * OUTER_M.powi(4) / LENGTH_M.powi(3);
    for (share, roots) in [(1e-9, CANTILEVER), (1e9, PROPPED)] {
        let found = first(share * tip);
        for (f, kl) in found.iter().zip(roots) {
            assert!((f / closed(kl) - 1.0).abs() < 0.005, "{share}: {found:?}");
        }
    }
    // In between every bending mode rises with the link, without a jump.
    let mut before = first(0.0);
    for k in 0..12 {
        let now = first(tip * 10_f64.powf(f64::from(k) / 2.0 - 2.0));
        assert!(now.iter().zip(&before).all(|(a, b)| *a > b * (1.0 - 1e-9)));
        before = now;
    }
}
