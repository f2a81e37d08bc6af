//! Promise: the computational model behaves as the thesis' figures 7, 9, 10 and 12 do,
//! and measured load steps and receptances give its joints back.
//!
//! `cargo test --release -p host-tests --test els_model -- --nocapture`

use host_tests::rarma;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rarma_plants::els::fit::{Line, LoadStep, Unknown, compliances, fit_joints};
use rarma_plants::els::{Clamping, ElsModel, ElsModelError, Place};
use rarma_scenarios::scenario::{SHIPPED_ELS, els_schema, load_els};
use serde_json::Value;

fn model(name: &str) -> Value {
    rarma!().run(["els", "model", name, "--json"]).json()
}

fn numbers(v: &Value) -> Vec<f64> {
    v.as_array()
        .expect("a list")
        .iter()
        .map(|x| x.as_f64().expect("a number"))
        .collect()
}

fn ends(x: &[f64]) -> (f64, f64) {
    x.iter()
        .fold((f64::INFINITY, 0.0), |(a, b), v| (a.min(*v), b.max(*v)))
}

#[test]
fn bending_rises_and_torsion_stays() {
    let answer = model("els-holder");
    let cases = answer["loads"].as_array().expect("cases");
    let of = |case: &Value, shape: &str| -> Vec<f64> {
        let modes = case["modes"].as_array().expect("modes");
        let those = modes.iter().filter(|m| m["shape"] == shape);
        those.map(|m| m["f"].as_f64().expect("Hz")).collect()
    };
    let torsion = of(&cases[0], "torsion");
    assert!(!torsion.is_empty());
    for pair in cases.windows(2) {
        let (before, now) = (of(&pair[0], "bending"), of(&pair[1], "bending"));
        for (k, (a, b)) in before.iter().zip(&now).enumerate() {
            assert!(b > a, "bending {k}: {a} to {b} at {} N", pair[1]["load_n"]);
        }
        for (a, b) in of(&pair[1], "torsion").iter().zip(&torsion) {
            assert!((a / b - 1.0).abs() < 1e-9);
        }
    }
    let last = cases.last().expect("one");
    assert_eq!(last["load_n"], 1000.0);
    let rise = of(last, "bending")[0] / of(&cases[0], "bending")[0];
    let link = last["link_n_per_um"].as_f64().expect("N/µm");
    println!(
        "first bending mode times {rise:.2} at 1 kN, link {link:.1} N/µm, torsion {torsion:.0?} Hz"
    );
    assert!((2.2..2.44).contains(&rise) && (90.0..95.0).contains(&link));
    // Figure 9: grounded, the tip stands still; free, it moves most.
    let tip = |which: &str| {
        let shapes = answer[which].as_array().expect("shapes");
        let bending = shapes.iter().find(|s| s["shape"] == "bending");
        let n = numbers(&bending.expect("one")["holder"][0]);
        n[1].hypot(n[2])
    };
    println!(
        "tip of the first shape: free {:.3}, grounded {:.5}",
        tip("free"),
        tip("grounded")
    );
    assert!(tip("free") > 0.99 && tip("grounded") < 0.01);
}

#[test]
fn deflection_all_round() {
    let answer = model("els-load-bar");
    let cases = answer["deflections"].as_array().expect("cases");
    assert_eq!(cases.len(), 3);
    let mut largest = Vec::new();
    for case in cases {
        let [tool, middle, bearing] =
            ["tool_joint_um", "middle_um", "bearing_um"].map(|name| ends(&numbers(&case[name])));
        println!(
            "{} N: {tool:.1?} {middle:.1?} {bearing:.1?} µm",
            case["load_n"]
        );
        assert!(bearing.1 < 0.25 * tool.0 && bearing.1 < middle.0 && middle.1 < tool.0);
        largest.push(tool.1);
        // The ellipse shows, and most at the bearing.
        let uneven = |(low, high): (f64, f64)| high / low - 1.0;
        assert!(uneven(bearing) > uneven(tool) && uneven(tool) > 0.01);
    }
    assert!((largest[2] / largest[0] - 3.0).abs() < 1e-9, "linear");
    assert!((110.0..170.0).contains(&largest[2]), "{largest:?}");
}

#[test]
fn the_limit_varies_around_the_circle() {
    let answer = model("els-short-tool");
    let widths: Vec<f64> = answer["limits"]["polar"]
        .as_array()
        .expect("directions")
        .iter()
        .map(|d| d["width_mm"].as_f64().unwrap_or(f64::INFINITY))
        .collect();
    let (least, most) = ends(&widths);
    println!("limit {least:.2} to {most:.2} mm");
    assert_eq!(widths.len(), 72);
    assert!((2.92..3.22).contains(&least) && (10.1..11.1).contains(&most));
    for k in 0..36 {
        assert!((widths[k] / widths[k + 36] - 1.0).abs() < 1e-9, "period π");
    }
    assert!(answer["limits"]["reciprocity"].as_f64().expect("both") < 1e-9);
}

#[test]
fn joints_come_back_from_load_steps_and_receptances() {
    let start = load_els("els-load-bar").expect("shipped").config;
    let mut truth = start.clone();
    let Clamping::Spindle {
        joints, bearings, ..
    } = &mut truth.clamping
    else {
        panic!("a spindle")
    };
    joints[0].2.radial = joints[0].2.radial.scaled(0.7);
    joints[0].2.tilt_n_m_per_rad *= 1.5;
    bearings[0].1.radial.major_n_per_m *= 1.3;
    let (radial, tilt) = (
        joints[0].2.radial.major_n_per_m,
        joints[0].2.tilt_n_m_per_rad,
    );
    let major = bearings[0].1.radial.major_n_per_m;
    let machine = ElsModel::new(&truth).expect("valid");
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut noise = || -> f64 { random.sample(StandardNormal) };
    // The load bar: eight pressures, 36 directions, 0.5 µm.
    let c = machine.tool_joint_compliance().expect("held");
    let mut steps = Vec::new();
    for k in 0..36 {
        let angle_rad = f64::from(10 * k).to_radians();
        for load_n in [36.0, 112.0, 238.0, 364.0, 490.0, 616.0, 742.0, 868.0] {
            let d = ElsModel::deflection(&c, load_n, angle_rad).expect("finite");
            let along = d.x_m * angle_rad.cos() + d.y_m * angle_rad.sin();
            steps.push(LoadStep {
                angle_rad,
                load_n,
                deflection_m: along + 0.5e-6 * noise() + 3e-6,
            });
        }
    }
    let statics = compliances(&steps).expect("slopes");
    // An exciter: 100 to 2500 Hz, 1 % of the largest.
    let f: Vec<f64> = (0..120).map(|k| 100.0 + 20.0 * f64::from(k)).collect();
    let g = machine
        .receptance(0.0, Place::Holder(0.0), &f)
        .expect("lines");
    let sd = 0.01 * g.iter().fold(0.0, |m: f64, g| m.max(g.resp_u_exc_u.abs()));
    let lines: Vec<Line> = f
        .iter()
        .zip(&g)
        .map(|(&f_hz, g)| {
            let mut g = *g;
            for z in [
                &mut g.resp_u_exc_u,
                &mut g.resp_u_exc_v,
                &mut g.resp_v_exc_u,
                &mut g.resp_v_exc_v,
            ] {
                z.re += sd * noise();
                z.im += sd * noise();
            }
            Line { f_hz, g, sd }
        })
        .collect();
    let unknowns = [
        Unknown::Joint(0),
        Unknown::JointTilt(0),
        Unknown::BearingMajor(0),
    ];
    let fit = fit_joints(&start, &unknowns, &statics, &lines).expect("a fit");
    println!("misfit {:.3} after {} rounds", fit.misfit, fit.rounds);
    assert!((0.9..1.1).contains(&fit.misfit));
    for (found, want) in fit.found.iter().zip([radial, tilt, major]) {
        let off = (found.value - want) / found.sd;
        println!(
            "{}: {:.3e} for {want:.3e}, sd {:.1e}, {off:+.1} sd",
            found.unknown, found.value, found.sd
        );
        assert!(off.abs() < 4.0 && (found.value / want - 1.0).abs() < 0.05);
    }
    // The load bar alone cannot tell five springs in series apart.
    let many = [
        Unknown::Joint(0),
        Unknown::JointTilt(0),
        Unknown::BearingMajor(0),
        Unknown::BearingMinor(0),
        Unknown::BearingMajor(1),
        Unknown::BearingMajor(2),
    ];
    let why = fit_joints(&start, &many, &statics, &[]);
    assert!(
        matches!(why, Err(ElsModelError::Singular { .. })),
        "{why:?}"
    );
}

#[test]
fn the_schema_is_kept() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../rarma-scenarios/scenarios/els-schema.json"
    );
    let text = std::fs::read_to_string(path).expect("the schema beside the systems");
    let kept: Value = serde_json::from_str(&text).expect("JSON");
    assert!(
        kept == els_schema(),
        "write it again: rarma els model --schema > {path}"
    );
    for (name, _) in SHIPPED_ELS {
        assert_eq!(load_els(name).expect("shipped").name, name);
    }
}
