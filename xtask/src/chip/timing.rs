//! The time of what was executed: the cycles of each instruction by ARM's tables for the Cortex-M4 and
//! its floating-point unit (DDI 0439, 3.3 and 7.2), the flash behind its accelerator, exceptions.
//!
//! Where the manual gives a range, or rules that depend on what it does not say, there are two forms.
//! Neither is a chip: bus conflicts with the DMA and the wait states of peripherals are in none.

use std::ops::{Add, Sub};

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

impl Add for Taken {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.each(other, u64::wrapping_add)
    }
}

impl Sub for Taken {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.each(other, u64::wrapping_sub)
    }
}

impl Taken {
    fn each(self, other: Self, joined: impl Fn(u64, u64) -> u64) -> Self {
        Self {
            instructions: joined(self.instructions, other.instructions),
            cycles: joined(self.cycles, other.cycles),
            waited: joined(self.waited, other.waited),
            waited_for_data: joined(self.waited_for_data, other.waited_for_data),
            exceptions: joined(self.exceptions, other.exceptions),
        }
    }
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
