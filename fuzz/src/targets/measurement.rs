//! Measurements: receptances, readings of a ball bar, load steps, modes of a structure.

use crate::{Target, check, scratch};
use rarma_recordings::input::{
    Circles, Function, circle_file, merge, read_circles, read_load_steps, read_receptances,
    read_structure, write_uff,
};
use std::path::Path;

pub(super) const RECEPTANCES: Target = Target {
    name: "receptances",
    reads: "receptances, CSV",
    run: |bytes| receptances("case.csv", bytes),
    words: || {
        [
            "freq_hz",
            "uu_re_m_per_N",
            "uu_im_m_per_N",
            "vv_re_um_per_kN",
            "vv_im_um_per_kN",
            "uv_",
            "vu_",
            "re_m_per_s_per_N",
            "im_m_per_s_per_N",
            "re_m_per_s2_per_N",
            "im_m_per_s2_per_N",
            "nan",
            "1e308",
            "-0",
        ]
        .map(str::to_owned)
        .to_vec()
    },
};

pub(super) const UNIVERSAL: Target = Target {
    name: "uff",
    reads: "receptances, universal files",
    run: |bytes| receptances("case.uff", bytes),
    words: || {
        [
            "    -1\n",
            "    58\n",
            "   58b     1     2",
            "   164\n",
            "NONE",
            "1D+05",
            "um",
            "lbf",
        ]
        .map(str::to_owned)
        .to_vec()
    },
};

pub(super) const CIRCLES: Target = Target {
    name: "circles",
    reads: "readings of a ball bar",
    run: |bytes| {
        let path = scratch::file("case.csv", bytes);
        match read_circles(&[&path]) {
            Ok(circles) => circles_again(&circles),
            Err(why) => check::refusal(&path, &why),
        }
    },
    words: || {
        [
            "# machine = ",
            "# plane = YZ",
            "# radius_mm = ",
            "# feed_mm_min = ",
            "# inclination_deg = ",
            "angle_deg",
            "dr_um",
            "dr_mm",
            "dir",
            "way",
            "run",
            "p_bar",
            "p_Pa",
            "F_N",
            "F_kN",
            "ccw",
            "cw",
            "static",
            "up",
            "down",
            "-1",
            "1e30",
        ]
        .map(str::to_owned)
        .to_vec()
    },
};

pub(super) const LOAD_STEPS: Target = Target {
    name: "load-steps",
    reads: "load steps",
    run: |bytes| {
        let path = scratch::file("case.csv", bytes);
        match read_load_steps(&path) {
            Ok(steps) => assert!(steps.iter().all(|s| {
                s.angle_rad.is_finite() && s.load_n.is_finite() && s.deflection_m.is_finite()
            })),
            Err(why) => check::refusal(&path, &why),
        }
    },
    words: || {
        ["angle_deg", "load_n", "deflection_um", "1e308"]
            .map(str::to_owned)
            .to_vec()
    },
};

pub(super) const STRUCTURE: Target = Target {
    name: "structure",
    reads: "modes of a structure, JSON and CSV",
    run: |bytes| {
        for name in ["case.json", "case.csv"] {
            let path = scratch::file(name, bytes);
            match read_structure(&path) {
                Ok(structure) => assert!(!structure.modes().is_empty()),
                Err(why) => check::refusal(&path, &why),
            }
        }
    },
    words: || {
        [
            "{\"modes\": [",
            "\"f\": ",
            "\"f_sd\": ",
            "\"zeta\": ",
            "\"zeta_sd\": ",
            "null",
            "1e999",
        ]
        .map(str::to_owned)
        .to_vec()
    },
};

/// Reads functions; puts them together; writes them and reads them again.
fn receptances(name: &str, bytes: &[u8]) {
    let path = scratch::file(name, bytes);
    let functions = match read_receptances(&path) {
        Ok(functions) => functions,
        Err(why) => return check::refusal(&path, &why),
    };
    for f in &functions {
        assert_eq!(f.f_hz.len(), f.g.len());
        assert!(f.g.iter().all(|g| g.is_finite()) && f.f_hz.iter().all(|x| x.is_finite()));
        f.notices.iter().for_each(|n| check::one_line(n));
    }
    let plane = match merge(&functions) {
        Ok(plane) => plane,
        Err(why) => return check::refusal(&path, &why),
    };
    plane.notices.iter().for_each(|n| check::one_line(n));
    let written = write_uff(&plane, "case");
    let again = scratch::file("again.uff", written.as_bytes());
    match read_receptances(&again) {
        Ok(read) => same(&functions, &read, &plane.measured),
        // The format has two digits of exponent and frequencies in single precision: what
        // they cannot hold may be refused, in the usual words.
        Err(why) => check::refusal(&again, &why),
    }
}

/// As many functions, and numbers, as were written.
fn same(before: &[Function], after: &[Function], measured: &[rarma_recordings::input::Role]) {
    assert_eq!(after.len(), measured.len());
    for (f, role) in after.iter().zip(measured) {
        assert_eq!(f.role, Some(*role));
        let was = before
            .iter()
            .find(|b| b.role.unwrap_or(rarma_recordings::input::Role::Uu) == *role)
            .expect("what was written was read");
        for (a, b) in was.g.iter().zip(&f.g) {
            let size = a.re.abs().max(a.im.abs());
            // Outside, two digits of exponent are not enough.
            let held = (1e-90..1e90).contains(&size);
            let near = (a.re - b.re).abs().max((a.im - b.im).abs()) <= 1e-10 * size;
            assert!(!held || near, "{a:?} became {b:?}");
        }
    }
}

/// A table that was read can be written, and holds as many readings.
fn circles_again(circles: &Circles) {
    for run in &circles.runs {
        assert_eq!(run.points.len(), run.forces_n.len());
        let text = circle_file(&circles.conditions, Some(run), &[]);
        again(&text, |c| {
            assert_eq!(c.runs.len(), 1);
            assert_eq!(c.runs[0].points.len(), run.points.len());
            assert_eq!((c.runs[0].number, c.runs[0].sense), (run.number, run.sense));
        });
    }
    if !circles.readings.is_empty() {
        let text = circle_file(&circles.conditions, None, &circles.readings);
        again(&text, |c| {
            assert_eq!(c.readings.len(), circles.readings.len())
        });
    }
}

fn again(text: &str, holds: impl FnOnce(&Circles)) {
    let path = scratch::file("again.csv", text.as_bytes());
    match read_circles(&[&path]) {
        Ok(circles) => holds(&circles),
        Err(why) => panic!(
            "written and not read: {}: {why}",
            Path::new(&path).display()
        ),
    }
}
