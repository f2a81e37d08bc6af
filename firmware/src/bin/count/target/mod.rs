//! The harness, and the list of kernels.

#[cfg(not(feature = "count-functions"))]
mod estimators;
#[cfg(feature = "count-functions")]
mod functions;
#[cfg(not(feature = "count-functions"))]
mod rigs;

use core::hint::black_box;
use core::str;

use cortex_m_semihosting::debug::{EXIT_FAILURE, EXIT_SUCCESS, exit};
use cortex_m_semihosting::{hprintln, nr, syscall};
#[cfg(not(feature = "count-functions"))]
use estimators::{
    ByLines, Chain21, Chain22, Chain43, Chain44, Chain65, Chain66, Chain87, Chain88, Finder, Lines,
    Roots21, Roots22, Roots43, Roots44, Roots65, Roots66, Roots87, Roots88, Update21, Update22,
    Update43, Update44, Update65, Update66, Update87, Update88,
};
#[cfg(feature = "count-functions")]
use functions::{
    AdviceAlone, AdviceByModes, Argument, Atan2Libm, Atan2Micromath, Atan2Ours, ExpLibm,
    ExpMicromath, ExpOurs, LnLibm, LnMicromath, LnOurs, ModeLibm, ModeMicromath, ModeOurs,
    SinCosLibm, SinCosMicromath, SinCosOurs, SqrtLibm, SqrtMicromath, SqrtOurs,
};
#[cfg(not(feature = "count-functions"))]
use rigs::{Bar, LoopBias, LoopNoise, LoopPrbs, LoopSteps, Plant};
use {cortex_m as _, defmt_semihosting as _};

/// Samples each kernel is given.
const SAMPLES: usize = 2000;

/// One thing to count.
pub trait Kernel {
    /// How the command line and the table call it.
    const NAME: &'static str;
    /// State at the first sample.
    fn new() -> Self;
    /// One sample in, something that depends on all work out.
    fn step(&mut self, y: f32) -> f32;
}

/// The empty loop, whose counts are subtracted from every other kernel's.
struct Nop;

impl Kernel for Nop {
    const NAME: &'static str = "nop";
    fn new() -> Self {
        Self
    }
    fn step(&mut self, y: f32) -> f32 {
        y
    }
}

/// Passes over the signal before counting: the start-up is over, the roots found.
const WARM_UP_PASSES: usize = 16;

macro_rules! kernels {
    ($($kernel:ty),* $(,)?) => {
        fn list() {
            $(hprintln!("kernel {}", <$kernel>::NAME);)*
        }
        fn run_named(name: &str, signal: &[f32; SAMPLES]) -> bool {
            $(if name == <$kernel>::NAME {
                run::<$kernel>(signal);
                return true;
            })*
            false
        }
    };
}

// Apart: what is in an image changes what the compiler makes of the rest.
#[cfg(feature = "count-functions")]
kernels![
    Nop,
    AdviceAlone,
    AdviceByModes,
    Argument,
    SqrtOurs,
    SqrtLibm,
    SqrtMicromath,
    LnOurs,
    LnLibm,
    LnMicromath,
    ExpOurs,
    ExpLibm,
    ExpMicromath,
    Atan2Ours,
    Atan2Libm,
    Atan2Micromath,
    SinCosOurs,
    SinCosLibm,
    SinCosMicromath,
    ModeOurs,
    ModeLibm,
    ModeMicromath,
];

#[cfg(not(feature = "count-functions"))]
kernels![
    Nop, Update21, Update22, Update43, Update44, Update65, Update66, Update87, Update88, Roots21,
    Roots22, Roots43, Roots44, Roots65, Roots66, Roots87, Roots88, Chain21, Chain22, Chain43,
    Chain44, Chain65, Chain66, Chain87, Chain88, Lines, Finder, ByLines, Bar, Plant, LoopBias,
    LoopNoise, LoopPrbs, LoopSteps,
];

/// Counting starts when this executes.
#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn roi_begin() {
    // Two different bodies, or the linker would fold the two functions into one.
    // SAFETY: does nothing.
    unsafe { core::arch::asm!("nop") }
}

/// Counting ends when this executes.
#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn roi_end() {
    // SAFETY: does nothing.
    unsafe { core::arch::asm!("nop", "nop") }
}

/// The counted loop. The state lies in the caller's frame, so that this frame and what
/// is below it is the kernel's own stack.
#[inline(never)]
fn measure<K: Kernel>(kernel: &mut K, signal: &[f32; SAMPLES]) {
    roi_begin();
    for y in signal {
        black_box(kernel.step(*y));
    }
    roi_end();
}

#[inline(never)]
fn run<K: Kernel>(signal: &[f32; SAMPLES]) {
    let mut kernel = K::new();
    for _ in 0..WARM_UP_PASSES {
        for y in signal {
            black_box(kernel.step(*y));
        }
    }
    black_box(&mut kernel);
    let top = stack::paint();
    measure(&mut kernel, signal);
    let stack_bytes = stack::used_below(top);
    black_box(&mut kernel);
    hprintln!(
        "samples {} state_bytes {} stack_bytes {}",
        SAMPLES,
        size_of::<K>(),
        stack_bytes
    );
}

/// Deepest use of the stack, by painting what is free and seeing what was overwritten.
mod stack {
    use core::arch::asm;

    /// Bytes painted below the stack pointer.
    const DEPTH: usize = 64 * 1024;
    const PAINT: u32 = 0xA5A5_5A5A;

    /// Paints the free stack and returns the stack pointer above it.
    #[inline(always)]
    pub fn paint() -> usize {
        let top: usize;
        // SAFETY: reads a register.
        unsafe { asm!("mov {}, sp", out(reg) top) };
        for address in (top - DEPTH..top).step_by(4) {
            // SAFETY: below the stack pointer and inside RAM: in use by nothing.
            unsafe { (address as *mut u32).write_volatile(PAINT) };
        }
        top
    }

    /// Bytes between `top` and the lowest word that lost its paint.
    #[inline(always)]
    pub fn used_below(top: usize) -> usize {
        (top - DEPTH..top)
            .step_by(4)
            // SAFETY: as in `paint`; the words were written there.
            .find(|address| unsafe { (*address as *const u32).read_volatile() } != PAINT)
            .map_or(0, |lowest| top - lowest)
    }
}

/// Coloured noise, always the same: a resonance at a sixth of the sampling rate.
fn signal() -> [f32; SAMPLES] {
    let mut random = 1_u32;
    let mut past = [0.0_f32; 2];
    core::array::from_fn(|_| {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = (random >> 8) as f32 / 8_388_608.0 - 1.0;
        let y = noise + 0.95 * past[0] - 0.9 * past[1];
        past = [y, past[0]];
        y
    })
}

/// The command line that the emulator was given.
fn command_line(buffer: &mut [u8; 64]) -> &str {
    let mut block = [buffer.as_mut_ptr() as usize, buffer.len()];
    // SAFETY: the block names a buffer and its true length.
    unsafe { syscall(nr::GET_CMDLINE, &mut block) };
    let length = buffer.iter().position(|byte| *byte == 0).unwrap_or(0);
    str::from_utf8(&buffer[..length]).unwrap_or("").trim()
}

#[cortex_m_rt::entry]
fn main() -> ! {
    let mut buffer = [0; 64];
    let name = command_line(&mut buffer);
    let known = if name == "--list" {
        list();
        true
    } else {
        run_named(name, &signal())
    };
    if !known {
        hprintln!("no kernel `{}`", name);
    }
    loop {
        exit(if known { EXIT_SUCCESS } else { EXIT_FAILURE });
    }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    hprintln!("{}", info);
    loop {
        exit(EXIT_FAILURE);
    }
}

defmt::timestamp!("{=u32}", 0_u32);
