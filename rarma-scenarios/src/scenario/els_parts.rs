//! The parts of a system: stretches, rings, the link, the cut.

use super::reader::{Allowed, Refusal, Section};
use super::shared::{LENGTH_MM, MM, N_PER_MM2, N_PER_UM};
use rarma_plants::els::beam::{Material, Segment};
use rarma_plants::els::link::{Link, LinkLaw};
use rarma_plants::els::ring::{Elliptic, Ring};
use rarma_rigs::els::CutConfig;

pub(super) const STIFFNESS: Allowed = Allowed::within(1e-6, 1e6);
const LOSS: Allowed = Allowed::within(0.0, 1.0);
const ANGLE_DEG: Allowed = Allowed::within(-360.0, 360.0);
const ROTARY: Allowed = Allowed::within(0.0, 1e7);

pub(super) fn segment(s: &mut Section<'_>) -> Result<Segment, Refusal> {
    let length = s.number("length_mm", LENGTH_MM, None, "Length, mm")?;
    let outer = s.number("outer_mm", LENGTH_MM, None, "Outer diameter, mm")?;
    let inner = s.number(
        "inner_mm",
        Allowed::within(0.0, 1000.0),
        Some(0.0),
        "Bore, mm",
    )?;
    let elements = s.whole("elements", (1, 200), Some(4), "Finite elements")?;
    let material = match s.choice("material", &["steel", "carbide"], false, "Material")? {
        1 => Material::CARBIDE,
        _ => Material::STEEL,
    };
    let loss = s.number("loss", LOSS, Some(material.loss), "Loss factor, 1")?;
    if inner >= outer && !s.describes() {
        return Err(s.refuse(
            "inner_mm",
            "is not below outer_mm (allowed: a bore inside the diameter)",
        ));
    }
    Ok(Segment {
        length_m: length * MM,
        outer_m: outer * MM,
        inner_m: inner * MM,
        elements: elements as usize,
        material: Material { loss, ..material },
    })
}

pub(super) fn ring(s: &mut Section<'_>) -> Result<Ring, Refusal> {
    let springs = s.whole(
        "springs",
        (3, 360),
        Some(4),
        "Springs around the circle; 3 for a polygonal taper, many for a distributed stiffness",
    )?;
    let first = s.number(
        "first_deg",
        ANGLE_DEG,
        Some(0.0),
        "Angle of the first, degrees",
    )?;
    let major = s.number(
        "major_n_per_um",
        STIFFNESS,
        None,
        "Largest radial stiffness of the ring, N/µm",
    )?;
    let minor = s.number(
        "minor_n_per_um",
        STIFFNESS,
        Some(major),
        "Smallest, N/µm; like the largest if not given",
    )?;
    let angle = s.number(
        "angle_deg",
        ANGLE_DEG,
        Some(0.0),
        "Direction of the largest from x, degrees",
    )?;
    let tilt = s.number(
        "tilt_n_m_per_mrad",
        ROTARY,
        Some(0.0),
        "Stiffness against tilting, N·m/mrad",
    )?;
    let twist = s.number(
        "twist_n_m_per_mrad",
        ROTARY,
        Some(0.0),
        "Stiffness against turning about the axis, N·m/mrad",
    )?;
    let loss = s.number("loss", LOSS, Some(0.0), "Loss factor, 1")?;
    if minor > major && !s.describes() {
        return Err(s.refuse(
            "minor_n_per_um",
            format!("is {minor} (allowed: up to major_n_per_um)"),
        ));
    }
    Ok(Ring {
        springs: springs as usize,
        first_rad: first.to_radians(),
        radial: Elliptic {
            major_n_per_m: major * N_PER_UM,
            minor_n_per_m: minor * N_PER_UM,
            angle_rad: angle.to_radians(),
        },
        tilt_n_m_per_rad: 1e3 * tilt,
        twist_n_m_per_rad: 1e3 * twist,
        loss,
    })
}

pub(super) fn link(s: &mut Section<'_>) -> Result<Link, Refusal> {
    let hertz = s.choice(
        "law",
        &["hertz", "constant"],
        false,
        "How its stiffness follows the load",
    )? == 0;
    let constant = s.number(
        "n_per_um",
        Allowed::within(0.0, 1e9),
        Some(0.0),
        "Stiffness of a constant link, N/µm",
    )?;
    let radius = s.number(
        "radius_mm",
        LENGTH_MM,
        Some(10.0),
        "Radius of contact of ball and seat, mm",
    )?;
    let modulus = s.number(
        "modulus_gpa",
        Allowed::within(1e-3, 2000.0),
        Some(115.0),
        "Modulus of contact E*, GPa",
    )?;
    let across = s.number(
        "across",
        Allowed::within(0.0, 10.0),
        Some(0.82),
        "Stiffness across over along, 1",
    )?;
    let angle = s.number(
        "angle_deg",
        ANGLE_DEG,
        Some(0.0),
        "Direction from x, degrees",
    )?;
    let loss = s.number("loss", LOSS, Some(0.0), "Loss factor, 1")?;
    Ok(Link {
        law: if hertz {
            LinkLaw::Hertz {
                radius_m: radius * MM,
                modulus_pa: 1e9 * modulus,
            }
        } else {
            LinkLaw::Constant(constant * N_PER_UM)
        },
        across,
        angle_rad: angle.to_radians(),
        loss,
    })
}

pub(super) fn cut(s: &mut Section<'_>) -> Result<(CutConfig<f64>, f64), Refusal> {
    let ks = s.number(
        "ks_n_per_mm2",
        Allowed::within(1e-3, 1e5),
        Some(2000.0),
        "Specific cutting stiffness, N/mm²",
    )?;
    let teeth = s.number(
        "teeth_in_cut",
        Allowed::within(1e-3, 100.0),
        Some(1.0),
        "Teeth in the cut on average",
    )?;
    let overlap = s.number(
        "overlap",
        Allowed::within(0.0, 1.0),
        Some(1.0),
        "Share of the last wave that is cut again, 1",
    )?;
    let angle = s.number(
        "chip_angle_deg",
        ANGLE_DEG,
        Some(0.0),
        "From the cutting force to the direction of the chip thickness, degrees",
    )?;
    Ok((
        CutConfig {
            ks_n_per_m2: ks * N_PER_MM2,
            teeth_in_cut: teeth,
            overlap,
        },
        angle.to_radians(),
    ))
}
