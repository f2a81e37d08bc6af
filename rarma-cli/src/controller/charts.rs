//! Charts of a machine that is told, one for each programmed speed: they take seconds, and are made on a thread of
//! their own while the listening goes on.

use crate::advice::machine::{Belief, Chart};
use rarma_core::act::ActConfig;
use rarma_core::advice::MOST_REACH;
use std::collections::VecDeque;
use std::sync::Arc;
use std::thread::{self, JoinHandle};

/// Of so many programmed speeds charts are kept, the last.
const KEPT: usize = 16;
/// Speeds that differ by less have one chart.
pub(super) const SAME_SPEED: f64 = 0.01;

/// Makes and keeps the charts.
#[derive(Debug)]
pub struct Charts {
    belief: Arc<Belief>,
    /// By the programmed speed, turns a second; none where it could not be made.
    made: VecDeque<(f64, Option<Arc<Chart>>)>,
    making: Option<(f64, JoinHandle<Chart>)>,
}

impl Charts {
    /// None yet.
    #[must_use]
    pub fn new(belief: Belief) -> Self {
        Self {
            belief: Arc::new(belief),
            made: VecDeque::new(),
            making: None,
        }
    }

    /// Begins that of a programmed speed, turns a second, if there is none and none is being made.
    pub(super) fn begin(&mut self, program_hz: f64, config: &ActConfig) {
        self.take();
        if program_hz > 0.0 && self.making.is_none() && self.find(program_hz).is_none() {
            let belief = Arc::clone(&self.belief);
            let reach_hz = reach_hz(config, program_hz);
            let make = move || on_few_cores(|| belief.chart(program_hz, reach_hz, || ()));
            match thread::Builder::new().spawn(make) {
                Ok(thread) => self.making = Some((program_hz, thread)),
                Err(_) => self.keep(program_hz, None),
            }
        }
    }

    /// Makes it now, on all cores: for who must have it before anything is heard. `done` is called
    /// [`Belief::CHARTED`] times at most.
    pub fn make(&mut self, program_hz: f64, config: &ActConfig, done: impl Fn() + Sync) {
        let chart = self
            .belief
            .chart(program_hz, reach_hz(config, program_hz), done);
        self.keep(program_hz, Some(Arc::new(chart)));
    }

    /// That of a programmed speed, where it is made.
    pub(super) fn of(&mut self, program_hz: f64) -> Option<Arc<Chart>> {
        self.take();
        self.find(program_hz)?.clone()
    }

    fn find(&self, program_hz: f64) -> Option<&Option<Arc<Chart>>> {
        let mut same = self.made.iter().rev();
        let off = |at: f64| (at / program_hz - 1.0).abs();
        let one = same.find(|(at, _)| off(*at) <= SAME_SPEED);
        one.map(|(_, chart)| chart)
    }

    fn take(&mut self) {
        if self.making.as_ref().is_some_and(|(_, t)| t.is_finished())
            && let Some((program_hz, thread)) = self.making.take()
        {
            self.keep(program_hz, thread.join().ok().map(Arc::new));
        }
    }

    fn keep(&mut self, program_hz: f64, chart: Option<Arc<Chart>>) {
        if self.made.len() == KEPT {
            self.made.pop_front();
        }
        self.made.push_back((program_hz, chart));
    }
}

/// What may be turned of a programmed speed, from and to, turns a second.
pub(super) fn reach_hz(config: &ActConfig, program_hz: f64) -> (f64, f64) {
    let most_hz = config.most * program_hz;
    let least_hz = config.least * program_hz;
    (least_hz.max(most_hz / MOST_REACH), most_hz)
}

/// The listening keeps a core.
fn on_few_cores<T: Send>(make: impl FnOnce() -> T + Send) -> T {
    let cores = thread::available_parallelism().map_or(1, |n| n.get());
    let few = rayon::ThreadPoolBuilder::new().num_threads((cores - 1).max(1));
    match few.build() {
        Ok(few) => few.install(make),
        Err(_) => make(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::advice::machine::{Machine, Spread};
    use rarma_core::advice::{AdviceConfig, HeardChatter};
    use std::time::{Duration, Instant};

    #[test]
    fn each_programmed_speed_has_its_own_and_no_more_than_some_are_kept() {
        let machine = Machine::load("turning-980", None).expect("shipped");
        let mut charts = Charts::new(Belief::new(machine, Spread::USUAL, 1));
        let limits = ActConfig::limits(false, 0.95, 1.05);
        let begun = Instant::now();
        for hz in [20.0, 30.0] {
            assert!(charts.of(hz).is_none());
            charts.begin(hz, &limits);
            while charts.of(hz).is_none() {
                assert!(begun.elapsed() < Duration::from_secs(120));
                thread::sleep(Duration::from_millis(5));
                // Asked for again it is not begun again.
                charts.begin(hz, &limits);
            }
        }
        // The first is still there, by another pointer than the second, and says what one made at once says.
        let first = charts.of(20.1).expect("within a percent");
        assert!(!Arc::ptr_eq(&first, &charts.of(30.0).expect("made")));
        charts.make(20.0, &limits, || ());
        let at_once = charts.of(20.0).expect("made");
        let heard = HeardChatter {
            f_hz: 1000.0,
            f_sd_hz: 3.0,
            spindle_hz: 20.0,
            spindle_sd_hz: 0.02,
            teeth: 1,
        };
        let (least_hz, most_hz) = reach_hz(&limits, 20.0);
        let config = AdviceConfig::reach(least_hz, most_hz);
        let said = [&first, &at_once].map(|c| c.advise(&config, &heard, &[]).expect("in range"));
        assert_eq!(said[0], said[1]);
        for _ in 0..2 * KEPT {
            charts.keep(50.0, None);
        }
        assert!(charts.of(50.0).is_none() && charts.made.len() == KEPT);
        // What could not be made is not begun again and again.
        charts.begin(50.0, &limits);
        assert!(charts.making.is_none() && charts.of(20.0).is_none());
    }
}
