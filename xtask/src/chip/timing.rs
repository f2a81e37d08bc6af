//! The time of what was executed: the cycles of each instruction by ARM's tables for the Cortex-M4 and
//! its floating-point unit (DDI 0439, 3.3 and 7.2), the flash behind its accelerator, exceptions.
//!
//! Where the manual gives a range, or rules that depend on what it does not say, there are two forms.
//! Neither is a chip: bus conflicts with the DMA and the wait states of peripherals are in none.

use super::accelerator::Flash;
use super::instruction::{Float, Instruction, Kind, Operation};
use super::program::{FLASH, Program};
use super::trace::{Step, Trace};

/// Which end of the manual's ranges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// The pipeline refills in one cycle, divisions take 2, a load or store right behind a load takes
    /// 1, a store 1, `it` none; what does not need a quotient goes on beside it.
    Least,
    /// It refills in three, divisions take 12 (in the unit 14, and everything waits), a load or store
    /// always 2; a sum of products that is used as the next addend costs one more.
    Most,
}

/// The exception's entry and return with memory that never waits, and the words of the
/// floating-point unit: they are kept lazily, when the handler uses it first, and given back.
const ENTRY: u64 = 12;
const RETURN: u64 = 10;
const FLOAT_WORDS: u64 = 17;

/// How a program is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Setup {
    /// The flash reads ahead.
    pub prefetch: bool,
    /// Which end of the ranges.
    pub form: Form,
}

/// What a program took, in cycles but for the first.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Taken {
    /// Instructions.
    pub instructions: u64,
    /// All cycles.
    pub cycles: u64,
    /// Of these, waiting for instructions.
    pub waited: u64,
    /// Waiting for data in the flash.
    pub waited_for_data: u64,
    /// Entries of exceptions, returns, registers kept.
    pub exceptions: u64,
}

/// Where the program was when an exception came.
#[derive(Debug, Clone, Copy, Default)]
struct Place {
    /// The last instruction, and where the one behind it lies.
    last: Option<(Instruction, u32)>,
    /// Registers of the floating-point unit are to be kept before it is used.
    keeps: bool,
    /// They were.
    kept: bool,
}

/// The core, as far as its time goes.
#[derive(Debug, Clone)]
pub struct Machine<'a> {
    program: &'a Program,
    form: Form,
    flash: Flash,
    now: u64,
    /// Until when the floating-point unit divides.
    divides: u64,
    place: Place,
    outer: Vec<Place>,
    masked: bool,
    taken: Taken,
}

impl<'a> Machine<'a> {
    /// With cold caches.
    pub fn new(program: &'a Program, setup: Setup) -> Self {
        Self {
            program,
            form: setup.form,
            flash: Flash::new(setup.prefetch),
            now: 0,
            divides: 0,
            place: Place::default(),
            outer: Vec::new(),
            masked: false,
            taken: Taken::default(),
        }
    }

    /// Cycles since the beginning, sleep included.
    pub fn now(&self) -> u64 {
        self.now
    }

    /// Whether interrupts are masked.
    pub fn masked(&self) -> bool {
        self.masked
    }

    /// Masks them or not, as a trace begins.
    pub fn mask(&mut self, masked: bool) {
        self.masked = masked;
    }

    /// Handlers under way.
    pub fn depth(&self) -> usize {
        self.outer.len()
    }

    /// Sleeps until a moment, if that is to come.
    pub fn sleep_until(&mut self, moment: u64) {
        self.now = self.now.max(moment);
    }

    /// What it took until now, sleep not included.
    pub fn taken(&self) -> Taken {
        self.taken
    }

    /// Takes one step of the program.
    pub fn step(&mut self, step: Step) {
        match step {
            Step::Run(at) => self.run(at),
            Step::Load(from) => {
                let waited = self.flash.load(from, self.now);
                self.taken.waited_for_data += waited;
                self.pass(waited);
            }
            Step::Enter { .. } => {
                self.outer.push(self.place);
                self.place = Place {
                    keeps: true,
                    ..Place::default()
                };
                self.except(ENTRY);
            }
            Step::Leave => {
                let kept = self.place.kept;
                self.except(RETURN + if kept { FLOAT_WORDS } else { 0 });
                self.place = self.outer.pop().unwrap_or_default();
            }
            Step::Store(_) | Step::Sleep | Step::Wake { .. } => {}
        }
    }

    fn pass(&mut self, cycles: u64) {
        self.now += cycles;
        self.taken.cycles += cycles;
    }

    fn except(&mut self, cycles: u64) {
        self.taken.exceptions += cycles;
        self.pass(cycles);
    }

    fn run(&mut self, at: u32) {
        let instruction = self.program.at(at);
        let last = self.place.last;
        if last.is_some_and(|(_, next)| next != at) {
            self.pass(self.refill());
        }
        if FLASH.contains(&at) {
            for byte in [at, at + u32::from(instruction.bytes) - 1] {
                let waited = self.flash.fetch(byte, self.now);
                self.taken.waited += waited;
                self.pass(waited);
            }
        }
        match instruction.kind {
            Kind::Mask => self.masked = true,
            Kind::Unmask => self.masked = false,
            Kind::Float(_) if self.place.keeps => {
                self.except(FLOAT_WORDS);
                (self.place.keeps, self.place.kept) = (false, true);
            }
            _ => {}
        }
        let cycles = self.own(instruction, last.map(|(before, _)| before));
        self.pass(cycles);
        self.taken.instructions += 1;
        self.place.last = Some((instruction, at + u32::from(instruction.bytes)));
    }

    fn refill(&self) -> u64 {
        match self.form {
            Form::Least => 1,
            Form::Most => 3,
        }
    }

    /// The one or the other.
    fn either(&self, least: u64, most: u64) -> u64 {
        match self.form {
            Form::Least => least,
            Form::Most => most,
        }
    }

    /// Cycles of an instruction behind another, with memory that never waits and no jump.
    fn own(&mut self, instruction: Instruction, before: Option<Instruction>) -> u64 {
        let before = before.map(|before| before.kind);
        match instruction.kind {
            Kind::Plain | Kind::Jump | Kind::JumpRegister => 1,
            Kind::MultiplyAdd | Kind::LoadPc | Kind::Table => 2,
            Kind::Divide => self.either(2, 12),
            Kind::If => self.either(0, 1),
            Kind::Mask | Kind::Unmask => self.either(1, 2),
            Kind::Special => self.either(1, 4),
            Kind::Many { words, .. } => 1 + u64::from(words),
            Kind::Memory { words: 2, .. } => 3,
            Kind::Memory { load, base, .. } => self.access(load, Some(base), before),
            Kind::Float(float) => self.float(float, before),
        }
    }

    /// A load or store of one register.
    fn access(&self, load: bool, base: Option<u8>, before: Option<Kind>) -> u64 {
        let behind = match before {
            // Unless its address is only being loaded.
            Some(Kind::Memory {
                load: true,
                written,
                ..
            }) => base.is_none() || written != base,
            Some(Kind::Float(float)) => {
                matches!(float.operation, Operation::Memory { load: true, .. })
            }
            _ => false,
        };
        self.either(if behind || !load { 1 } else { 2 }, 2)
    }

    fn float(&mut self, float: Float, before: Option<Kind>) -> u64 {
        let own = match float.operation {
            Operation::Arithmetic | Operation::Move => 1,
            Operation::MultiplyAdd => 3,
            Operation::Long => self.either(1, 14),
            Operation::MoveTwo => 2,
            Operation::Memory { words: 2, .. } => 3,
            Operation::Memory { load, .. } => self.access(load, None, before),
            Operation::Many { words } => 1 + u64::from(words),
        };
        let late = match before {
            Some(Kind::Float(Float {
                operation: Operation::Arithmetic | Operation::MultiplyAdd | Operation::Long,
                result: Some(result),
                ..
            })) => {
                let read = float.reads.contains(&Some(result));
                let added = float.addend == Some(result);
                u64::from(read || added && self.form == Form::Most)
            }
            _ => 0,
        };
        let busy = self.divides.saturating_sub(self.now);
        if float.operation == Operation::Long && self.form == Form::Least {
            self.divides = self.now + busy + 14;
        }
        own + late.max(busy)
    }
}

/// Runs a whole trace, without its sleep.
pub fn run(program: &Program, trace: &Trace, setup: Setup) -> Taken {
    let mut machine = Machine::new(program, setup);
    for &step in &trace.steps {
        machine.step(step);
    }
    machine.taken()
}

#[cfg(test)]
mod tests {
    use super::*;

    const AT: u32 = 0x0800_0000;
    const COUPLED: u32 = 0x1000_0000;

    fn taken(from: u32, halfwords: &[u16], order: &[u32], setup: Setup) -> Taken {
        let program = Program::of_halfwords(from, halfwords);
        let steps = order.iter().map(|at| Step::Run(from + at)).collect();
        let trace = Trace {
            steps,
            masked: false,
        };
        run(&program, &trace, setup)
    }

    fn flash(bytes: u32, times: u32, prefetch: bool) -> Taken {
        let nops = vec![0xBF00; bytes as usize / 2];
        let once = (0..bytes / 2).map(|n| 2 * n);
        let order: Vec<u32> = (0..times).flat_map(|_| once.clone()).collect();
        let setup = Setup {
            prefetch,
            form: Form::Least,
        };
        taken(AT, &nops, &order, setup)
    }

    /// Four instructions a read: each read waits four cycles; with prefetch the next one is on its
    /// way meanwhile, and one cycle is left to wait.
    #[test]
    fn a_straight_line_waits_for_every_read() {
        let bare = flash(8 * 100, 1, false);
        assert_eq!((bare.instructions, bare.waited), (400, 400));
        let ahead = flash(8 * 100, 1, true);
        assert_eq!(ahead.waited, 4 + 99);
        assert_eq!(ahead.cycles, 400 + 103);
    }

    /// What fits the cache waits once; one line more than fits, used in turn, always.
    #[test]
    fn a_loop_that_fits_the_cache_waits_once() {
        assert_eq!(flash(1024, 50, false).waited, 4 * 128);
        assert_eq!(flash(1024 + 32, 50, false).waited, 4 * 132 * 50);
    }

    /// Cycles in the coupled memory, which never waits: at the least, at the most.
    fn both(halfwords: &[u16], order: &[u32]) -> (u64, u64) {
        let of = |form| {
            let setup = Setup {
                prefetch: true,
                form,
            };
            let taken = taken(COUPLED, halfwords, order, setup);
            assert_eq!(taken.waited, 0);
            taken.cycles
        };
        (of(Form::Least), of(Form::Most))
    }

    #[test]
    fn loads_in_a_row_overlap_unless_one_gives_the_address_of_the_next() {
        // ldr r0, [r1]; ldr r2, [r3]
        assert_eq!(both(&[0x6808, 0x681A], &[0, 2]), (3, 4));
        // ldr r0, [r1]; ldr r2, [r0]
        assert_eq!(both(&[0x6808, 0x6802], &[0, 2]), (4, 4));
        // str r0, [r1]; str r0, [r1]
        assert_eq!(both(&[0x6008, 0x6008], &[0, 2]), (2, 4));
        // push {r4, lr}
        assert_eq!(both(&[0xB510], &[0]), (3, 3));
    }

    #[test]
    fn a_jump_refills_the_pipeline_where_it_is_taken() {
        // bne back; nop
        assert_eq!(both(&[0xD1FD, 0xBF00], &[0, 2]), (2, 2));
        assert_eq!(both(&[0xD1FD, 0xBF00], &[0, 0]), (3, 5));
    }

    #[test]
    fn a_result_of_the_floating_point_unit_is_a_cycle_late() {
        // vadd.f32 s3, s3, s0 twice; vfma.f32 s0, s1, s2 twice
        assert_eq!(both(&[0xEE71, 0x1A80, 0xEE71, 0x1A80], &[0, 4]), (3, 3));
        assert_eq!(both(&[0xEEA0, 0x0A81, 0xEEA0, 0x0A81], &[0, 4]), (6, 7));
    }

    #[test]
    fn a_division_goes_on_beside_what_does_not_need_the_unit() {
        // vdiv.f32 s0, s1, s2; nop
        assert_eq!(both(&[0xEE80, 0x0A81, 0xBF00], &[0, 4]), (2, 15));
        // vdiv.f32 s0, s1, s2; vadd.f32 s3, s3, s0
        assert_eq!(both(&[0xEE80, 0x0A81, 0xEE71, 0x1A80], &[0, 4]), (15, 16));
        // udiv r0, r0, r1
        assert_eq!(both(&[0xFBB0, 0xF0F1], &[0]), (2, 12));
    }

    #[test]
    fn exceptions_take_their_time_and_keep_the_registers_that_they_use() {
        // nop; vadd.f32 s3, s3, s0
        let program = Program::of_halfwords(COUPLED, &[0xBF00, 0xEE71, 0x1A80]);
        let enter = Step::Enter { number: 28, at: 0 };
        let of = |steps: &[Step]| {
            let trace = Trace {
                steps: steps.to_vec(),
                masked: false,
            };
            let setup = Setup {
                prefetch: true,
                form: Form::Least,
            };
            run(&program, &trace, setup)
        };
        let bare = of(&[enter, Step::Run(COUPLED), Step::Leave]);
        assert_eq!((bare.cycles, bare.exceptions), (12 + 1 + 10, 22));
        let float = of(&[enter, Step::Run(COUPLED + 2), Step::Leave]);
        assert_eq!((float.cycles, float.exceptions), (12 + 17 + 1 + 27, 56));
        // Where the program was is known again after it: no jump.
        let around = of(&[
            Step::Run(COUPLED),
            enter,
            Step::Run(COUPLED),
            Step::Leave,
            Step::Run(COUPLED + 2),
        ]);
        assert_eq!(around.cycles, 1 + 23 + 1);
    }

    /// The caches of instructions and of data are apart; the flash ends the read of the one before
    /// it begins that of the other.
    #[test]
    fn data_in_the_flash_wait_too() {
        let program = Program::of_halfwords(AT, &[0x4801, 0xBF00]);
        let steps = [Step::Run(AT), Step::Load(AT + 8)].repeat(2);
        let trace = Trace {
            steps,
            masked: false,
        };
        let setup = Setup {
            prefetch: false,
            form: Form::Most,
        };
        let seen = run(&program, &trace, setup);
        assert_eq!((seen.waited, seen.waited_for_data), (4, 4));
    }
}
