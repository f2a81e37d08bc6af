//! One beam element, and a body of segments.
//!
//! Two nodes, cubic shape functions that solve the static equation exactly (those of
//! Friedman and Kosmatka with shear, Hermite's without), consistent mass by Gauss
//! quadrature of the same functions. Natural frequencies converge from above with the
//! fourth power of the element length.

use nalgebra::{Matrix2, Matrix4, Vector4};

/// What a segment is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Young's modulus, Pa, > 0.
    pub e_pa: f64,
    /// Poisson's ratio, 0 to 0.5.
    pub poisson: f64,
    /// Density, kg/m³, > 0.
    pub density_kg_per_m3: f64,
    /// Loss factor η, 0 or more.
    pub loss: f64,
}

impl Material {
    /// Tool steel.
    pub const STEEL: Self = Self {
        e_pa: 2.1e11,
        poisson: 0.3,
        density_kg_per_m3: 7850.0,
        loss: 0.002,
    };
    /// Cemented carbide.
    pub const CARBIDE: Self = Self {
        e_pa: 5.8e11,
        poisson: 0.22,
        density_kg_per_m3: 14_400.0,
        loss: 0.001,
    };

    fn shear_pa(&self) -> f64 {
        self.e_pa / (2.0 * (1.0 + self.poisson))
    }
}

/// Which beam theory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Theory {
    /// Bending only: for slender beams and closed-form comparison.
    EulerBernoulli,
    /// With shear and rotary inertia: for holders and spindles.
    #[default]
    Timoshenko,
}

/// A round stretch of constant section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Length, m, > 0.
    pub length_m: f64,
    /// Outer diameter, m, > 0.
    pub outer_m: f64,
    /// Bore, m, 0 or more and below the outer diameter.
    pub inner_m: f64,
    /// Elements, at least 1.
    pub elements: usize,
    /// Material.
    pub material: Material,
}

impl Segment {
    /// Area, m².
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        core::f64::consts::FRAC_PI_4 * (self.outer_m.powi(2) - self.inner_m.powi(2))
    }

    /// Second moment of area about a diameter, m⁴.
    #[must_use]
    pub fn inertia_m4(&self) -> f64 {
        core::f64::consts::PI / 64.0 * (self.outer_m.powi(4) - self.inner_m.powi(4))
    }

    /// Mass, kg.
    #[must_use]
    pub fn mass_kg(&self) -> f64 {
        self.material.density_kg_per_m3 * self.area_m2() * self.length_m
    }

    /// Shear coefficient of a hollow round section (Cowper).
    fn shear_coefficient(&self) -> f64 {
        let (nu, m) = (self.material.poisson, self.inner_m / self.outer_m);
        let q = (1.0 + m * m).powi(2);
        6.0 * (1.0 + nu) * q / ((7.0 + 6.0 * nu) * q + (20.0 + 12.0 * nu) * m * m)
    }

    /// Matrices of an element of this section and the length `l`, m.
    #[must_use]
    pub fn element(&self, l: f64, theory: Theory) -> Element {
        let (area, inertia) = (self.area_m2(), self.inertia_m4());
        let (m, ei) = (&self.material, self.material.e_pa * inertia);
        let (phi, rotary) = match theory {
            Theory::EulerBernoulli => (0.0, 0.0),
            Theory::Timoshenko => (
                12.0 * ei / (self.shear_coefficient() * m.shear_pa() * area * l * l),
                m.density_kg_per_m3 * inertia,
            ),
        };
        let polar = 2.0 * inertia;
        let twist = m.shear_pa() * polar / l;
        let turning = m.density_kg_per_m3 * polar * l / 6.0;
        Element {
            stiffness: bending_stiffness(ei, l, phi),
            mass: bending_mass(m.density_kg_per_m3 * area, rotary, l, phi),
            twist_stiffness: Matrix2::new(twist, -twist, -twist, twist),
            twist_mass: Matrix2::new(2.0 * turning, turning, turning, 2.0 * turning),
        }
    }
}

/// Matrices of one element: a bending plane (deflection and slope at either end), and
/// torsion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Element {
    /// Bending stiffness, N/m, N, N·m.
    pub stiffness: Matrix4<f64>,
    /// Bending mass, kg, kg·m, kg·m².
    pub mass: Matrix4<f64>,
    /// Torsional stiffness, N·m/rad.
    pub twist_stiffness: Matrix2<f64>,
    /// Torsional inertia, kg·m².
    pub twist_mass: Matrix2<f64>,
}

fn bending_stiffness(ei: f64, l: f64, phi: f64) -> Matrix4<f64> {
    let (six, stay, carry) = (6.0 * l, (4.0 + phi) * l * l, (2.0 - phi) * l * l);
    #[rustfmt::skip]
    let shape = Matrix4::new(
        12.0,  six, -12.0,   six,
         six, stay,  -six, carry,
       -12.0, -six,  12.0,  -six,
         six, carry, -six,  stay,
    );
    shape * (ei / (l.powi(3) * (1.0 + phi)))
}

/// Nodes and weights of Gauss' rule with four points on 0 to 1, exact to degree 7.
fn gauss() -> [(f64, f64); 4] {
    let root = (6.0_f64 / 5.0).sqrt();
    let (near, far) = (
        (3.0 / 7.0 - 2.0 / 7.0 * root).sqrt(),
        (3.0 / 7.0 + 2.0 / 7.0 * root).sqrt(),
    );
    let (heavy, light) = (
        (18.0 + 30.0_f64.sqrt()) / 72.0,
        (18.0 - 30.0_f64.sqrt()) / 72.0,
    );
    [(-far, light), (-near, heavy), (near, heavy), (far, light)].map(|(x, w)| (0.5 * (1.0 + x), w))
}

fn bending_mass(per_m: f64, rotary: f64, l: f64, phi: f64) -> Matrix4<f64> {
    let mut sum = Matrix4::zeros();
    for (x, weight) in gauss() {
        let (deflection, slope) = shapes(x, l, phi);
        sum += (deflection * deflection.transpose() * per_m + slope * slope.transpose() * rotary)
            * (weight * l);
    }
    sum
}

/// Deflection and slope at `x` (0 to 1) for a unit of each end coordinate.
fn shapes(x: f64, l: f64, phi: f64) -> (Vector4<f64>, Vector4<f64>) {
    let (x2, x3) = (x * x, x * x * x);
    let deflection = Vector4::new(
        1.0 - 3.0 * x2 + 2.0 * x3 + phi * (1.0 - x),
        l * (x - 2.0 * x2 + x3 + 0.5 * phi * (x - x2)),
        3.0 * x2 - 2.0 * x3 + phi * x,
        l * (x3 - x2 + 0.5 * phi * (x2 - x)),
    );
    let slope = Vector4::new(
        6.0 / l * (x2 - x),
        1.0 - 4.0 * x + 3.0 * x2 + phi * (1.0 - x),
        -6.0 / l * (x2 - x),
        3.0 * x2 - 2.0 * x + phi * x,
    );
    (deflection / (1.0 + phi), slope / (1.0 + phi))
}
