//! The same order by other methods, for comparison on one page.

use super::with_stack;
use crate::args::{IdentifyArgs, Method};
use crate::commands::band::Part;
use crate::commands::estimators::{self, IdentifiedMode, Memory};
use std::time::Instant;

/// Work above which the exact likelihood is left out: half a minute.
const LONG: f64 = 0.08 * estimators::MINUTES;
/// An autoregression stands in for an ARMA model by so many times its order.
const STANDS_IN: usize = 4;

/// What a method made of the series.
pub(super) struct Reading {
    /// Name and order.
    pub name: String,
    /// Its modes in the band; or why there are none.
    pub modes: Result<Vec<IdentifiedMode>, String>,
    /// Seconds that the fit took.
    pub seconds: f64,
}

/// All methods that make sense for the order, the one that was asked for first, with the memory that
/// was asked for; the others forget nothing.
pub(super) fn readings(part: &Part, args: &IdentifyArgs) -> Vec<Reading> {
    let (p, q) = args.order;
    let long = (STANDS_IN * (p + q), 0);
    let mut all = vec![(args.method, args.order)];
    let others = [
        (Method::Pem, args.order),
        (Method::Ml, args.order),
        (Method::Rpem, args.order),
        (Method::Rplr, args.order),
        (Method::Iv, args.order),
        (Method::Burg, (long.0.min(estimators::N), 0)),
    ];
    for (method, order) in others {
        let known = all.iter().any(|(other, _)| *other == method);
        let short = (p, q) == (0, 0) || p > estimators::MAX_ORDER;
        if !(known || short) {
            all.push((method, order));
        }
    }
    let asked = Memory {
        forgetting: args.forgetting,
        random_walk: args.random_walk,
    };
    let memories = std::iter::once(asked).chain(std::iter::repeat(Memory::WHOLE));
    all.into_iter()
        .zip(memories)
        .enumerate()
        .map(|(k, ((method, order), memory))| {
            // The one that was asked for has been fitted already, however long it took.
            let slow =
                method == Method::Ml && estimators::work(method, part.samples.len(), order) > LONG;
            if slow && k > 0 {
                return Reading {
                    name: name(method, order),
                    modes: Err("left out: it would take more than half a minute".to_owned()),
                    seconds: 0.0,
                };
            }
            reading(part, method, order, memory)
        })
        .collect()
}

fn name(method: Method, (p, q): (usize, usize)) -> String {
    format!("{} ({p},{q})", method.name())
}

fn reading(part: &Part, method: Method, order: (usize, usize), memory: Memory) -> Reading {
    let begun = Instant::now();
    let modes =
        with_stack(|| estimators::fit(method, &part.samples, order, memory)).and_then(|model| {
            part.modes(&model)
                .ok_or("its roots were not found".to_owned())
        });
    Reading {
        name: name(method, order),
        modes,
        seconds: begun.elapsed().as_secs_f64(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Cli, Command, Detrend};
    use clap::Parser as _;

    #[test]
    fn a_slow_likelihood_is_left_out_and_it_is_said() {
        let cli = Cli::try_parse_from("rarma identify x.wav --order 30,0 --method burg".split(' '));
        let Command::Identify(args) = cli.expect("valid").command else {
            panic!("another command");
        };
        let said = |samples: usize| {
            let mut x = 1u32;
            let noise = |_| {
                x = x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(x >> 8)
            };
            let series: Vec<f64> = (0..samples).map(noise).collect();
            let part = Part::whole(&series, 8000.0, Detrend::Mean);
            let all = readings(&part, &args);
            let ml = all.into_iter().find(|reading| reading.name == "ml (30,0)");
            ml.expect("told of").modes.err()
        };
        assert!(said(20_000).is_some_and(|why| why.contains("half a minute")));
        assert_eq!(said(400), None);
    }
}
