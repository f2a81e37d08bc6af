//! Unit tests of the beam model; closed forms stand in the host tests.

use super::beam::{Material, Segment, Theory};
use super::link::{Link, LinkLaw};
use super::ring::{Elliptic, Ring};
use super::{Clamping, ElsConfig, ElsModel, ElsModelError, Place};

fn segment(length_m: f64, outer_m: f64, elements: usize) -> Segment {
    Segment {
        length_m,
        outer_m,
        inner_m: 0.0,
        elements,
        material: Material {
            loss: 0.01,
            ..Material::STEEL
        },
    }
}

fn ring(n_per_m: f64, twist: f64) -> Ring {
    Ring {
        springs: 4,
        first_rad: 0.3,
        radial: Elliptic {
            major_n_per_m: 1.2 * n_per_m,
            minor_n_per_m: n_per_m,
            angle_rad: 0.4,
        },
        tilt_n_m_per_rad: 1e5,
        twist_n_m_per_rad: twist,
        loss: 0.05,
    }
}

fn system(twist: f64) -> ElsConfig {
    ElsConfig {
        holder: vec![segment(0.08, 0.02, 6), segment(0.1, 0.05, 4)],
        clamping: Clamping::Spindle {
            segments: vec![segment(0.3, 0.07, 8)],
            joints: vec![(0.13, 0.02, ring(2e8, 1e5))],
            bearings: vec![(0.06, ring(8e7, twist)), (0.25, ring(9e7, 0.0))],
        },
        link: Link {
            law: LinkLaw::Constant(1e7),
            across: 0.0,
            angle_rad: 0.2,
            loss: 0.1,
        },
        tool_joint_n_per_m: 1e8,
        theory: Theory::Timoshenko,
    }
}

#[test]
fn receptance_by_modes_is_that_of_the_whole_matrix() {
    let model = ElsModel::new(&system(1e5)).expect("valid");
    for place in [
        Place::Holder(0.0),
        Place::Holder(0.13),
        Place::Spindle(0.06),
    ] {
        let f = [0.0, 150.0, 700.0, 1500.0, 2400.0];
        let by_modes = model.receptance(300.0, place, &f).expect("lines");
        for (f, g) in f.iter().zip(by_modes) {
            let whole = model.receptance_direct(300.0, place, *f).expect("a line");
            let d = (g.resp_u_exc_u - whole.resp_u_exc_u).abs()
                + (g.resp_u_exc_v - whole.resp_u_exc_v).abs();
            assert!(d < 3e-3 * whole.resp_u_exc_u.abs(), "{place:?} {f}: {d:e}");
            assert!((g.resp_u_exc_v - g.resp_v_exc_u).abs() < 1e-9 * g.resp_u_exc_u.abs());
        }
    }
}

#[test]
fn mass_and_static_answer() {
    let config = system(1e5);
    let model = ElsModel::new(&config).expect("valid");
    let steel: f64 =
        config.holder.iter().map(Segment::mass_kg).sum::<f64>() + segment(0.3, 0.07, 1).mass_kg();
    assert!((model.mass_kg() / steel - 1.0).abs() < 1e-12);
    // The receptance at 0 Hz without loss and link is the compliance.
    let mut plain = config;
    plain.link.law = LinkLaw::Constant(0.0);
    let model = ElsModel::new(&plain).expect("valid");
    let c = model.compliances(&[Place::Holder(0.0)]).expect("held")[0];
    let g = model
        .receptance(0.0, Place::Holder(0.0), &[0.0])
        .expect("a line")[0];
    assert!((g.resp_u_exc_u.re / c[(0, 0)] - 1.0).abs() < 5e-3);
}

#[test]
fn what_nothing_holds_is_named() {
    let model = ElsModel::new(&system(0.0)).expect("valid");
    let why = model.compliances(&[Place::Holder(0.0)]).expect_err("turns");
    assert_eq!(why, ElsModelError::Singular { free: 1 });
    assert!(why.to_string().contains("singular assembly"));
    let mut bad = system(1e5);
    bad.holder[1].outer_m = -1.0;
    let why = ElsModel::new(&bad).expect_err("no diameter");
    assert_eq!(why.to_string(), "holder[1].outer_m is out of its range");
    let mut bad = system(1e5);
    if let Clamping::Spindle { bearings, .. } = &mut bad.clamping {
        bearings[1].1.radial.minor_n_per_m = 0.0;
    }
    let why = ElsModel::new(&bad).expect_err("no stiffness");
    assert_eq!(
        why.to_string(),
        "bearing[1].radial stiffness is out of its range"
    );
}
