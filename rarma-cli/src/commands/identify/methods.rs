//! The same order by other methods, for comparison on one page.

use super::with_stack;
use crate::args::{IdentifyArgs, Method};
use crate::commands::band::Part;
use crate::commands::estimators::{self, IdentifiedMode, Memory};
use std::time::Instant;

/// Work above which the exact likelihood is left out: half a minute.
const LONG: f64 = 0.25 * estimators::MINUTES;
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
        let slow =
            method == Method::Ml && estimators::work(method, part.samples.len(), args.order) > LONG;
        if !(known || short || slow) {
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
        .map(|((method, order), memory)| reading(part, method, order, memory))
        .collect()
}

fn reading(part: &Part, method: Method, order: (usize, usize), memory: Memory) -> Reading {
    let begun = Instant::now();
    let modes =
        with_stack(|| estimators::fit(method, &part.samples, order, memory)).and_then(|model| {
            part.modes(&model)
                .ok_or("its roots were not found".to_owned())
        });
    Reading {
        name: format!("{} ({},{})", method.name(), order.0, order.1),
        modes,
        seconds: begun.elapsed().as_secs_f64(),
    }
}
