//! Capabilities as a table of numbers: what a store keeps beside the lines, and trends read.

use super::{Body, DirectionLimit, Limits, Modes, OdrStatistics, Stiffness};

/// What is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Quantity {
    /// Compliance in a direction of a plane, µm/N; place: the plane, `at`: the direction in degrees.
    Compliance,
    /// Width of a loop, µm; place: the plane, `at`: the direction in degrees.
    Hysteresis,
    /// An error of the machine, in the unit of its name; place: the plane and the name, `at`: force in N.
    Error,
    /// Natural frequency, Hz; place: axis and speed, `at`: the same frequency, which tells modes apart.
    Frequency,
    /// Damping ratio, 1; place: axis and speed, `at`: the frequency of the mode, Hz.
    Damping,
    /// Modal stiffness, N/µm; place: axis and speed, `at`: the frequency of the mode, Hz.
    ModalStiffness,
    /// Widest stable cut, mm; place: the specific cutting force, `at`: the direction in degrees.
    LimitWidth,
    /// Frequency of the chatter beyond it, Hz; place and `at` as of the width.
    ChatterFrequency,
    /// Operational damping in cuts, 1; place: the speed (the tool is the record's), `at`: the frequency, Hz.
    CutDamping,
}

impl serde::Serialize for Quantity {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(self.name())
    }
}

impl Quantity {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Compliance,
        Self::Hysteresis,
        Self::Error,
        Self::Frequency,
        Self::Damping,
        Self::ModalStiffness,
        Self::LimitWidth,
        Self::ChatterFrequency,
        Self::CutDamping,
    ];

    /// As the store's table and JSON spell it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Compliance => "compliance",
            Self::Hysteresis => "hysteresis",
            Self::Error => "error",
            Self::Frequency => "frequency",
            Self::Damping => "damping",
            Self::ModalStiffness => "modal-stiffness",
            Self::LimitWidth => "limit-width",
            Self::ChatterFrequency => "chatter-frequency",
            Self::CutDamping => "cut-damping",
        }
    }

    /// The one of that name.
    #[must_use]
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|q| q.name() == name)
    }
}

/// One number of a capability.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// What.
    pub quantity: Quantity,
    /// Where, see [`Quantity`].
    pub place: String,
    /// Where along the place, see [`Quantity`].
    pub at: f64,
    /// The number.
    pub value: f64,
    /// Its standard deviation, same unit.
    pub sd: f64,
}

/// Directions into which a whole circle of rays is gathered: twelve sectors of 30°. A bar reads 360
/// rays, a tensor has three numbers: twelve keep all that is used and are a thirtieth of the rows.
const SECTORS: usize = 12;

impl Body {
    /// Its numbers; none of a verdict, an alarm, an advice or an outcome.
    #[must_use]
    pub fn readings(&self) -> Vec<Reading> {
        let mut all = match self {
            Self::Stiffness(s) => of_stiffness(s),
            Self::Modes(m) => of_modes(m),
            Self::Limits(l) => of_limits(l),
            Self::OdrStatistics(o) => vec![of_odr(o)],
            Self::Verdict(_)
            | Self::AlarmCalled(_)
            | Self::AlarmReleased(_)
            | Self::Advice(_)
            | Self::Outcome(_) => Vec::new(),
        };
        // Of a stiffness next to 0 the compliance is no number.
        all.retain(|r| r.value.is_finite() && r.sd.is_finite());
        all
    }
}

fn of_stiffness(s: &Stiffness) -> Vec<Reading> {
    let plane = s.plane.as_str();
    let mut all = sectors(s);
    for reading in &mut all {
        plane.clone_into(&mut reading.place);
    }
    all.extend(s.hysteresis.iter().map(|h| Reading {
        quantity: Quantity::Hysteresis,
        place: plane.to_owned(),
        at: h.angle_deg,
        value: h.um,
        sd: h.sd_um,
    }));
    all.extend(s.errors.iter().map(|e| Reading {
        quantity: Quantity::Error,
        place: format!("{plane} {}", e.name),
        at: e.force_n,
        value: e.value,
        sd: e.sd,
    }));
    all
}

/// Compliance 1/k with sd/k² of each direction; of more than [`SECTORS`] directions the mean of each
/// sector at its middle, with the deviation of the mean of independent rays.
fn sectors(s: &Stiffness) -> Vec<Reading> {
    let one = |at: f64, value: f64, sd: f64| Reading {
        quantity: Quantity::Compliance,
        place: String::new(),
        at,
        value,
        sd,
    };
    let rays = s.directions.iter().map(|d| {
        let c = 1.0 / d.n_per_um;
        (d.angle_deg.rem_euclid(360.0), c, d.sd_n_per_um * c * c)
    });
    if s.directions.len() <= SECTORS {
        return rays.map(|(at, c, sd)| one(at, c, sd)).collect();
    }
    let width = 360.0 / SECTORS as f64;
    let mut sums = [(0.0, 0.0, 0.0); SECTORS];
    for (at, c, sd) in rays {
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 to 12"
        )]
        let sector = ((at / width + 0.5) as usize) % SECTORS;
        let sum = &mut sums[sector];
        *sum = (sum.0 + 1.0, sum.1 + c, sum.2 + sd * sd);
    }
    let mean = |(sector, (n, c, v)): (usize, (f64, f64, f64))| {
        one(sector as f64 * width, c / n, v.sqrt() / n)
    };
    sums.into_iter()
        .enumerate()
        .filter(|(_, sum)| sum.0 > 0.0)
        .map(mean)
        .collect()
}

fn of_modes(m: &Modes) -> Vec<Reading> {
    let mut all = Vec::new();
    for mode in &m.modes {
        let mut put = |quantity, value, sd| {
            let place = format!("{} {:.0}", mode.axis, m.rpm);
            all.push(Reading {
                quantity,
                place,
                at: mode.f_hz,
                value,
                sd,
            });
        };
        put(Quantity::Frequency, mode.f_hz, mode.f_sd_hz);
        put(Quantity::Damping, mode.zeta, mode.zeta_sd);
        if let Some(k) = mode.n_per_um {
            put(Quantity::ModalStiffness, k, 0.0);
        }
    }
    all
}

fn of_limits(l: &Limits) -> Vec<Reading> {
    let place = format!("{:.0}", l.ks_n_per_mm2);
    let one = |quantity, at, value, sd| Reading {
        quantity,
        place: place.clone(),
        at,
        value,
        sd,
    };
    let width = |d: &DirectionLimit| one(Quantity::LimitWidth, d.angle_deg, d.width_mm, d.sd_mm);
    let chatter = |d: &DirectionLimit| {
        (d.chatter_hz).map(|f| one(Quantity::ChatterFrequency, d.angle_deg, f, 0.0))
    };
    let directions = l.directions.iter();
    directions
        .clone()
        .map(width)
        .chain(directions.filter_map(chatter))
        .collect()
}

fn of_odr(o: &OdrStatistics) -> Reading {
    Reading {
        quantity: Quantity::CutDamping,
        place: format!("{:.0}", o.rpm),
        at: o.f_hz,
        value: o.zeta_mean,
        sd: o.zeta_mean_sd,
    }
}
