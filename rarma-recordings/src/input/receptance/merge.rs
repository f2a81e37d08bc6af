//! Functions of one plane on one grid.

use super::super::{InputError, Problem};
use super::Function;
use rarma_rigs::els::{Complex, Receptance};
use std::path::PathBuf;

/// Which of the four a function is: response first, excitation second.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Role {
    /// Direct, u.
    Uu,
    /// Response u, force v.
    Uv,
    /// Response v, force u.
    Vu,
    /// Direct, v.
    Vv,
}

impl Role {
    /// All four.
    pub const ALL: [Self; 4] = [Self::Uu, Self::Uv, Self::Vu, Self::Vv];

    /// As it is spelled.
    pub fn name(self) -> &'static str {
        match self {
            Self::Uu => "uu",
            Self::Uv => "uv",
            Self::Vu => "vu",
            Self::Vv => "vv",
        }
    }

    pub(super) fn of(name: &str) -> Option<Self> {
        let name = name.to_ascii_lowercase();
        Self::ALL
            .into_iter()
            .find(|r| r.name() == name)
            .or(match name.as_str() {
                "xx" => Some(Self::Uu),
                "xy" => Some(Self::Uv),
                "yx" => Some(Self::Vu),
                "yy" => Some(Self::Vv),
                _ => None,
            })
    }
}

/// The receptance tensor of a plane.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    /// Frequencies, Hz.
    pub f_hz: Vec<f64>,
    /// Tensor at each.
    pub g: Vec<Receptance<f64>>,
    /// The functions that were there.
    pub measured: Vec<Role>,
    /// What was assumed for the others.
    pub notices: Vec<String>,
}

/// Two frequencies are the same if they differ by less than this share of the spacing.
const SAME: f64 = 1e-3;

/// Puts the functions of a plane together. One that has no role is uu.
///
/// What is missing is assumed, and said: a cross receptance from its twin by reciprocity,
/// both as zero; vv as zero, which is a plane that moves in u only.
///
/// # Errors
/// Two functions with the same directions, different grids, or no uu.
pub fn merge(functions: &[Function]) -> Result<Plane, InputError> {
    let mut by_role: [Option<&Function>; 4] = [None; 4];
    for function in functions {
        let role = function.role.unwrap_or(Role::Uu);
        let slot = &mut by_role[role as usize];
        if let Some(other) = slot {
            return Err(refused(
                function,
                Problem::Header,
                format!(
                    "is {} like {} of {}",
                    role.name(),
                    other.place,
                    other.path.display()
                ),
                "say which is which with --uu, --uv, --vu, --vv",
            ));
        }
        *slot = Some(function);
    }
    let Some(first) = by_role[0] else {
        let path = functions.first().map_or(PathBuf::new(), |f| f.path.clone());
        return Err(InputError::new(
            Problem::Channel,
            "functions",
            "there is no direct receptance uu",
            "name it uu, or give it with --uu",
        )
        .in_file(&path));
    };
    for other in by_role.iter().flatten() {
        same_grid(first, other)?;
    }
    let n = first.f_hz.len();
    let zero = vec![Complex::ZERO; n];
    let of = |role: Role| by_role[role as usize].map(|f| f.g.clone());
    let mut notices: Vec<String> = functions.iter().flat_map(|f| f.notices.clone()).collect();
    let (uv, vu) = match (of(Role::Uv), of(Role::Vu)) {
        (Some(uv), Some(vu)) => (uv, vu),
        (Some(g), None) | (None, Some(g)) => {
            notices.push(
                "one cross receptance is missing: taken from the other, by reciprocity".to_owned(),
            );
            (g.clone(), g)
        }
        (None, None) => {
            notices.push(
                "no cross receptance: taken as zero, u and v as principal directions".to_owned(),
            );
            (zero.clone(), zero.clone())
        }
    };
    let vv = of(Role::Vv).unwrap_or_else(|| {
        notices.push(
            "no receptance vv: v is taken as rigid, only what u contributes is shown".to_owned(),
        );
        zero
    });
    let g = (0..n)
        .map(|k| Receptance {
            resp_u_exc_u: first.g[k],
            resp_u_exc_v: uv[k],
            resp_v_exc_u: vu[k],
            resp_v_exc_v: vv[k],
        })
        .collect();
    Ok(Plane {
        f_hz: first.f_hz.clone(),
        g,
        measured: Role::ALL
            .into_iter()
            .filter(|r| by_role[*r as usize].is_some())
            .collect(),
        notices,
    })
}

fn same_grid(a: &Function, b: &Function) -> Result<(), InputError> {
    let step = (a.f_hz[a.f_hz.len() - 1] - a.f_hz[0]) / (a.f_hz.len() - 1) as f64;
    let apart = a
        .f_hz
        .iter()
        .zip(&b.f_hz)
        .any(|(x, y)| (x - y).abs() > SAME * step);
    if a.f_hz.len() == b.f_hz.len() && !apart {
        return Ok(());
    }
    let grid = |f: &Function| {
        let last = f.f_hz[f.f_hz.len() - 1];
        format!("{} lines from {} to {last} Hz", f.f_hz.len(), f.f_hz[0])
    };
    Err(refused(
        b,
        Problem::Grid,
        format!(
            "another grid: {}, but {} of {} has {}",
            grid(b),
            a.place,
            a.path.display(),
            grid(a)
        ),
        "measure or export all functions on one grid",
    ))
}

fn refused(f: &Function, problem: Problem, what: String, remedy: &str) -> InputError {
    InputError::new(problem, f.place.clone(), what, remedy).in_file(&f.path)
}
