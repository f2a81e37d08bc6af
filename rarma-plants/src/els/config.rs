//! The whole system as it is described.

use super::beam::{Segment, Theory};
use super::error::{ElsModelError, check};
use super::link::Link;
use super::ring::Ring;

/// A place on the structure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// On the tool and holder, m from the tool joint.
    Holder(f64),
    /// On the spindle, m from its nose.
    Spindle(f64),
}

/// What holds the holder in the spindle.
#[derive(Clone, Debug, PartialEq)]
pub enum Clamping {
    /// The holder's upper end is fixed in space: no spindle.
    Fixed,
    /// Nothing holds it: for tests, and for a body alone.
    Free,
    /// Deflection is held, slopes and twist are free: for tests.
    Pinned,
    /// By rings of springs to a spindle in bearings.
    Spindle {
        /// The spindle from its nose upward.
        segments: Vec<Segment>,
        /// Rings between holder and spindle: place on the holder, m from the tool joint,
        /// on the spindle, m from the nose, and the ring.
        joints: Vec<(f64, f64, Ring)>,
        /// Bearings: place on the spindle, m from the nose, and the ring.
        bearings: Vec<(f64, Ring)>,
    },
}

/// The elastic linked system.
#[derive(Clone, Debug, PartialEq)]
pub struct ElsConfig {
    /// Tool and holder from the tool joint upward.
    pub holder: Vec<Segment>,
    /// How it is held.
    pub clamping: Clamping,
    /// Elastic link at the tip.
    pub link: Link,
    /// Stiffness of the tool joint itself, N/m, > 0: it lies between the load and the tip
    /// and adds F/k to the deflection that the load sees. Infinite for none.
    pub tool_joint_n_per_m: f64,
    /// Beam theory.
    pub theory: Theory,
}

impl ElsConfig {
    /// Checks every documented range.
    ///
    /// # Errors
    /// The first field out of its range.
    pub fn validate(&self) -> Result<(), ElsModelError> {
        let length = body("holder", &self.holder)?;
        self.link.validate()?;
        check(self.tool_joint_n_per_m > 0.0, "tool_joint_n_per_m")?;
        let Clamping::Spindle {
            segments,
            joints,
            bearings,
        } = &self.clamping
        else {
            return Ok(());
        };
        let reach = body("spindle", segments)?;
        for (k, (on_holder, on_spindle, r)) in joints.iter().enumerate() {
            let name = format!("joint[{k}]");
            check((0.0..=length).contains(on_holder), &format!("{name}.at_m"))?;
            check(
                (0.0..=reach).contains(on_spindle),
                &format!("{name}.spindle_at_m"),
            )?;
            ring(&name, r)?;
        }
        for (k, (at, r)) in bearings.iter().enumerate() {
            let name = format!("bearing[{k}]");
            check((0.0..=reach).contains(at), &format!("{name}.at_m"))?;
            ring(&name, r)?;
        }
        Ok(())
    }
}

fn ring(name: &str, r: &Ring) -> Result<(), ElsModelError> {
    let not_negative = |x: f64| x.is_finite() && x >= 0.0;
    let positive = |x: f64| x.is_finite() && x > 0.0;
    check(r.springs >= 3, &format!("{name}.springs"))?;
    check(r.first_rad.is_finite(), &format!("{name}.first_rad"))?;
    let stiff = positive(r.radial.minor_n_per_m) && positive(r.radial.major_n_per_m);
    check(stiff, &format!("{name}.radial stiffness"))?;
    check(
        r.radial.major_n_per_m >= r.radial.minor_n_per_m,
        &format!("{name}.radial stiffness"),
    )?;
    check(r.radial.angle_rad.is_finite(), &format!("{name}.angle_rad"))?;
    check(
        not_negative(r.tilt_n_m_per_rad),
        &format!("{name}.tilt_n_m_per_rad"),
    )?;
    check(
        not_negative(r.twist_n_m_per_rad),
        &format!("{name}.twist_n_m_per_rad"),
    )?;
    check(not_negative(r.loss), &format!("{name}.loss"))
}

/// Length of a body, m.
fn body(name: &str, segments: &[Segment]) -> Result<f64, ElsModelError> {
    check(!segments.is_empty(), name)?;
    for (k, s) in segments.iter().enumerate() {
        let name = |field: &str| format!("{name}[{k}].{field}");
        let positive = |x: f64| x.is_finite() && x > 0.0;
        check(positive(s.length_m), &name("length_m"))?;
        check(positive(s.outer_m), &name("outer_m"))?;
        check((0.0..s.outer_m).contains(&s.inner_m), &name("inner_m"))?;
        check((1..=200).contains(&s.elements), &name("elements"))?;
        check(positive(s.material.e_pa), &name("e_pa"))?;
        check((0.0..=0.5).contains(&s.material.poisson), &name("poisson"))?;
        check(
            positive(s.material.density_kg_per_m3),
            &name("density_kg_per_m3"),
        )?;
        check(
            s.material.loss.is_finite() && s.material.loss >= 0.0,
            &name("loss"),
        )?;
    }
    Ok(segments.iter().map(|s| s.length_m).sum())
}
