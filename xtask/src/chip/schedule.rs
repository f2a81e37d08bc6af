//! What must not take too long: passes of the main loop, stretches with interrupts masked, and the way
//! of one interrupt through whatever runs when it comes.
//!
//! The model of the chip serves interrupts where the program sleeps or stores to a register. Here the
//! same work is laid out in time again: each wake at its moment, each handler of the one interrupt as
//! soon as it is raised, masks and other handlers are through, caches as the others leave them. All
//! interrupts of the image have one priority: none breaks into another's handler.

use core::ops::Range;

use super::program::Program;
use super::timing::{Machine, Setup};
use super::trace::{Step, Trace};

/// The longest stretches of a run in which nothing is laid out anew, in cycles.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Longest {
    /// From a wake to the next sleep, handlers in it included.
    pub pass: u64,
    /// The program with interrupts masked; sleep ends such a stretch.
    pub masked: u64,
    /// A handler but that of the one interrupt, entry and return included.
    pub handler: u64,
}

/// The longest stretches, `interrupt` being the number of the exception that is not looked at.
pub fn longest(program: &Program, trace: &Trace, setup: Setup, interrupt: u32) -> Longest {
    let mut machine = Machine::new(program, setup);
    machine.mask(trace.masked);
    let mut found = Longest::default();
    let (mut woke, mut entered) = (None, None);
    let mut masked = trace.masked.then_some(0);
    for &step in &trace.steps {
        let before = machine.now();
        machine.step(step);
        let now = machine.now();
        match step {
            Step::Wake { .. } => {
                woke = Some(now);
                masked = machine.masked().then_some(now);
            }
            Step::Sleep => {
                if let Some(woke) = woke.take() {
                    found.pass = found.pass.max(now - woke);
                }
                if let Some(masked) = masked.take() {
                    found.masked = found.masked.max(now - masked);
                }
            }
            Step::Enter { number, .. } if machine.depth() == 1 => {
                entered = (number != interrupt).then_some(before);
            }
            Step::Leave if machine.depth() == 0 => {
                if let Some(entered) = entered.take() {
                    found.handler = found.handler.max(now - entered);
                }
            }
            _ if machine.depth() == 0 => match (machine.masked(), masked) {
                (true, None) => masked = Some(now),
                (false, Some(since)) => {
                    found.masked = found.masked.max(now - since);
                    masked = None;
                }
                _ => {}
            },
            _ => {}
        }
    }
    found
}

/// An interrupt among the rest of the program, in cycles.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Preempted {
    /// How often it came.
    pub periods: u64,
    /// From the interrupt's cause to the last store into the registers, the longest and the mean.
    pub worst: u64,
    /// See [`Self::worst`].
    pub mean: f64,
    /// How often the next one came before that store.
    pub late: u64,
    /// From cause to store with cold caches and nothing in its way, the longest.
    pub cold: u64,
    /// What all of it takes of the core, and this handler: 1 is all that there is.
    pub busy: f64,
    /// See [`Self::busy`].
    pub handler: f64,
    /// The longest from a wake's moment to the next sleep, this interrupt's handlers included.
    pub pass: u64,
}

/// Everything that one interrupt did: when it came, its steps.
struct Job<'a> {
    came: u64,
    steps: &'a [Step],
}

/// Takes the interrupt's handlers out of a trace. The rest is in its order.
fn split(trace: &Trace, interrupt: u32) -> (Vec<Step>, Vec<Job<'_>>) {
    let (mut rest, mut jobs) = (Vec::new(), Vec::new());
    let mut from = None;
    for (at, &step) in trace.steps.iter().enumerate() {
        match (step, from) {
            (Step::Enter { number, at: came }, None) if number == interrupt => {
                from = Some((at, came));
            }
            (Step::Leave, Some((first, came))) => {
                let steps = &trace.steps[first..=at];
                jobs.push(Job { came, steps });
                from = None;
            }
            (_, Some(_)) => {}
            _ => rest.push(step),
        }
    }
    (rest, jobs)
}

/// Runs a handler; the moment of its last store into the registers, if it has one.
fn handle(machine: &mut Machine<'_>, job: &Job<'_>, registers: &Range<u32>) -> Option<u64> {
    let mut stored = None;
    for &step in job.steps {
        machine.step(step);
        if matches!(step, Step::Store(at) if registers.contains(&at)) {
            stored = Some(machine.now());
        }
    }
    stored
}

/// Lays a trace out in time. Nothing where the interrupt never came, or never stored.
pub fn preempted(
    program: &Program,
    trace: &Trace,
    setup: Setup,
    interrupt: u32,
    registers: Range<u32>,
) -> Option<Preempted> {
    let (rest, jobs) = split(trace, interrupt);
    let start = jobs.first()?.came;
    let mut seen = Preempted::default();
    for job in &jobs {
        let mut cold = Machine::new(program, setup);
        let stored = handle(&mut cold, job, &registers);
        seen.cold = seen.cold.max(stored.unwrap_or_default());
    }
    let mut machine = Machine::new(program, setup);
    machine.mask(trace.masked);
    machine.sleep_until(start);
    let (mut sum, mut stores, mut in_handler, mut next) = (0, 0u64, 0, 0);
    // Serves what has come by now.
    let mut serve = |machine: &mut Machine<'_>, seen: &mut Preempted| {
        while let Some(job) = jobs.get(next).filter(|job| job.came <= machine.now()) {
            let entered = machine.now();
            next += 1;
            seen.periods += 1;
            if let Some(stored) = handle(machine, job, &registers) {
                let took = stored - job.came;
                (sum, stores) = (sum + took, stores + 1);
                seen.worst = seen.worst.max(took);
                seen.late += u64::from(jobs.get(next).is_some_and(|next| next.came < stored));
            }
            in_handler += machine.now() - entered;
        }
    };
    let mut woke = None;
    for step in rest {
        match step {
            Step::Sleep => {
                if let Some(woke) = woke.take() {
                    seen.pass = seen.pass.max(machine.now().saturating_sub(woke));
                }
            }
            // What comes in sleep wakes the core, and is served where masks end.
            Step::Wake { at } => {
                machine.sleep_until(at);
                woke = Some(at);
            }
            _ => {}
        }
        if machine.depth() == 0 && !machine.masked() {
            serve(&mut machine, &mut seen);
        }
        machine.step(step);
    }
    // The time that the periods had, not that which everything took.
    let last = jobs.last()?.came;
    let span = (last - start) as f64 * jobs.len() as f64 / (jobs.len() as f64 - 1.0);
    seen.busy = machine.taken().cycles as f64 / span;
    seen.handler = in_handler as f64 / span;
    seen.mean = sum as f64 / stores as f64;
    (stores > 0).then_some(seen)
}

#[cfg(test)]
mod tests {
    use super::super::timing::Form;
    use super::*;

    const AT: u32 = 0x1000_0000;
    const LOOP: u32 = 63;
    const DUTY: Range<u32> = 0x4001_2C34..0x4001_2C44;
    const SETUP: Setup = Setup {
        prefetch: true,
        form: Form::Least,
    };

    /// Ten that do nothing, mask, unmask.
    fn program() -> Program {
        Program::of_halfwords(AT, &[[0xBF00; 10].as_slice(), &[0xB672, 0xB662]].concat())
    }

    fn nops(count: u32) -> Vec<Step> {
        (0..count).map(|n| Step::Run(AT + 2 * n)).collect()
    }

    /// A handler that came at a moment: three instructions, the second one stores.
    fn handler(number: u32, at: u64) -> Vec<Step> {
        let body = [Step::Run(AT), Step::Run(AT + 2), Step::Store(0x4001_2C40)];
        let enter = Step::Enter { number, at };
        [&[enter], &body[..], &[Step::Run(AT + 4), Step::Leave]].concat()
    }

    fn trace(parts: &[Vec<Step>]) -> Trace {
        Trace {
            steps: parts.concat(),
            masked: false,
        }
    }

    #[test]
    fn passes_masks_and_handlers_are_told_apart() {
        let masked = vec![Step::Run(AT + 20), Step::Run(AT), Step::Run(AT + 22)];
        let pass = [
            vec![Step::Wake { at: 0 }],
            nops(4),
            masked,
            handler(28, 5),
            handler(LOOP, 6),
            vec![Step::Sleep],
        ];
        let found = longest(&program(), &trace(&pass), SETUP, LOOP);
        // Jumps to the mask, to an instruction, back: a cycle more each; the mask itself is none.
        assert_eq!(found.masked, 1 + 1 + 1 + 1);
        assert_eq!(found.handler, 12 + 3 + 10);
        assert_eq!(found.pass, 4 + 2 + 4 + 2 * 25);
    }

    #[test]
    fn an_interrupt_breaks_into_what_runs_then_and_waits_for_masks() {
        let wake = |at| vec![Step::Wake { at }];
        let sleep = || vec![Step::Sleep];
        // It comes first at 1000, asleep; then at 2003, while ten instructions run from 2000 on,
        // though the model of the chip has served it after them.
        let quiet = [wake(1000), handler(LOOP, 1000), sleep()];
        let busy = [wake(2000), nops(10), handler(LOOP, 2003), sleep()];
        let of = |parts: &[Vec<Step>]| preempted(&program(), &trace(parts), SETUP, LOOP, DUTY);
        let seen = of(&[quiet.concat(), busy.concat(), wake(3000), nops(1)]).unwrap();
        assert_eq!((seen.periods, seen.late), (2, 0));
        // Entry, two instructions.
        assert_eq!((seen.worst, seen.cold), (14, 14));
        // A mask of twelve cycles at 2000, at 2003 the interrupt: it waits for its end.
        let masked = [
            wake(2000),
            vec![Step::Run(AT + 20)],
            nops(10),
            vec![Step::Run(AT + 22)],
            nops(1),
            handler(LOOP, 2003),
            sleep(),
        ];
        let seen = of(&[quiet.concat(), masked.concat(), wake(3000), nops(1)]).unwrap();
        let unmasked = 2000 + 1 + 1 + 10 + 1 + 1;
        assert_eq!(seen.worst, unmasked - 2003 + 14);
        assert_eq!(seen.pass, 1 + 1 + 10 + 1 + 1 + 25 + 1 + 1);
        assert!(of(&[nops(3)]).is_none());
    }

    #[test]
    fn the_next_one_before_the_store_is_late() {
        let parts = [handler(LOOP, 100), handler(LOOP, 105), nops(1)];
        let seen = preempted(&program(), &trace(&parts), SETUP, LOOP, DUTY).unwrap();
        assert_eq!((seen.periods, seen.late), (2, 1));
        assert_eq!(seen.worst, 25 - 5 + 14);
        // Two of 25 cycles where there were 5 a period.
        assert_eq!((seen.busy, seen.handler), (51.0 / 10.0, 50.0 / 10.0));
    }
}
