//! Kernels to count: `cargo xtask count` runs each over the same signal and counts the
//! instructions between `roi_begin` and `roi_end`.
//!
//! The semihosting command line is `--list` (answer: `kernel NAME` lines) or a kernel's
//! name (answer: `samples N state_bytes X stack_bytes Y`). Every kernel is warmed up first,
//! so that what is counted is the steady state. To add a kernel, implement
//! `Kernel` and name it in `kernels!`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("this image counts instructions on the target: cargo xtask count");
}

#[cfg(target_os = "none")]
mod target {
    use core::hint::black_box;
    use core::str;

    use cortex_m_semihosting::debug::{EXIT_FAILURE, EXIT_SUCCESS, exit};
    use cortex_m_semihosting::{hprintln, nr, syscall};
    use firmware::bar::BarDuty;
    use rarma_core::condition::{
        Band, SpeedFinder, SpeedFinderConfig, SpindleLines, SpindleLinesConfig,
    };
    use rarma_core::estimate::{RarmaConfig, RecursiveArma};
    use rarma_core::guard::RigState;
    use rarma_core::ldbb::ValveConfig;
    use rarma_core::monitor::{Monitor, MonitorConfig};
    use rarma_core::settings::Settings;
    use rarma_core::spectrum::{FactorTracker, modal};
    use rarma_core::wire::CircleJob;
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

    macro_rules! order_kernels {
        ($($update:ident, $roots:ident, $chain:ident, $p:literal, $q:literal, $n:literal;)*) => {
            $(
                /// Parameters, covariance and gradient of one model.
                struct $update(RecursiveArma<f32, $p, $q, $n>);

                impl Kernel for $update {
                    const NAME: &'static str =
                        concat!("update (", $p, ",", $q, ")");
                    fn new() -> Self {
                        Self(RecursiveArma::new(forgetting()))
                    }
                    fn step(&mut self, y: f32) -> f32 {
                        self.0.update(y).innovation
                    }
                }

                /// The same, and the roots of A, and frequency and damping of each mode.
                struct $roots {
                    model: RecursiveArma<f32, $p, $q, $n>,
                    roots: FactorTracker<f32, $p>,
                }

                impl Kernel for $roots {
                    const NAME: &'static str =
                        concat!("update, roots, damping (", $p, ",", $q, ")");
                    fn new() -> Self {
                        Self {
                            model: RecursiveArma::new(forgetting()),
                            roots: FactorTracker::new(),
                        }
                    }
                    fn step(&mut self, y: f32) -> f32 {
                        self.model.update(y);
                        self.roots.track(self.model.a());
                        let mut sum = 0.0;
                        for factor in self.roots.factors($p) {
                            if let Some(mode) = modal(factor, 6000.0) {
                                sum += mode.damping;
                            }
                        }
                        sum
                    }
                }

                /// The whole chain from a 48 kHz sample to the verdict, per input sample.
                struct $chain(Monitor<f32, $p, $q, $n>);

                impl Kernel for $chain {
                    const NAME: &'static str =
                        concat!("whole chain per 48 kHz sample (", $p, ",", $q, ")");
                    fn new() -> Self {
                        match Monitor::new(&MonitorConfig::new(48_000.0)) {
                            Ok(monitor) => Self(monitor),
                            Err(_) => panic!("the default settings are in range"),
                        }
                    }
                    fn step(&mut self, y: f32) -> f32 {
                        self.0.push(y).map_or(0.0, |report| report.level)
                    }
                }
            )*
        };
    }

    order_kernels! {
        Update21, Roots21, Chain21, 2, 1, 3;
        Update22, Roots22, Chain22, 2, 2, 4;
        Update43, Roots43, Chain43, 4, 3, 7;
        Update44, Roots44, Chain44, 4, 4, 8;
        Update65, Roots65, Chain65, 6, 5, 11;
        Update66, Roots66, Chain66, 6, 6, 12;
        Update87, Roots87, Chain87, 8, 7, 15;
        Update88, Roots88, Chain88, 8, 8, 16;
    }

    /// The signal with lines of a five-tooth cutter at 76.4 Hz in it, made as it runs.
    struct Cut(u32);

    impl Cut {
        fn next(&mut self, y: f32) -> f32 {
            // 26 turns in 2042 samples of 6 kHz: teeth in 15.7 samples.
            self.0 = (self.0 + 130) % 2042;
            y + if self.0 < 130 { 60.0 } else { -4.0 }
        }
    }

    /// Removal of all lines of one spindle in the band, per decimated sample.
    struct Lines(SpindleLines<f32, 32>, Cut);

    impl Kernel for Lines {
        const NAME: &'static str = "spindle lines (32)";
        fn new() -> Self {
            let band = Band::usual(6000.0);
            match SpindleLines::new(&SpindleLinesConfig::new(6000.0, band)) {
                Ok(mut lines) => {
                    lines.start(76.4, 0.05);
                    Self(lines, Cut(0))
                }
                Err(_) => panic!("the settings are in range"),
            }
        }
        fn step(&mut self, y: f32) -> f32 {
            let y = self.1.next(y);
            self.0.process(y)
        }
    }

    /// Search for the speed in the sound, per decimated sample.
    struct Finder(SpeedFinder<f32>, Cut);

    impl Kernel for Finder {
        const NAME: &'static str = "speed from the sound";
        fn new() -> Self {
            match SpeedFinder::new(&SpeedFinderConfig {
                fs_hz: 6000.0,
                band: Band::usual(6000.0),
                told_hz: None,
                teeth: None,
            }) {
                Ok(finder) => Self(finder, Cut(0)),
                Err(_) => panic!("the settings are in range"),
            }
        }
        fn step(&mut self, y: f32) -> f32 {
            let y = self.1.next(y);
            f32::from(u8::from(self.0.push(y).is_some()))
        }
    }

    fn forgetting() -> RarmaConfig<f32> {
        RarmaConfig {
            forgetting: 0.998,
            variance_gain: 0.002,
            ..RarmaConfig::default()
        }
    }

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

    /// One millisecond of the ball bar during a capture: valve loop, sequence, readings.
    struct Bar(BarDuty, ValveConfig, RigState);

    impl Kernel for Bar {
        const NAME: &'static str = "ball bar, capture";
        fn new() -> Self {
            let mut bar = BarDuty::default();
            let job = CircleJob {
                pressures_pa: [4e4, 1e5, 2e5, 0.0, 0.0, 0.0, 0.0, 0.0],
                feed_m_s: 1.0 / 60.0,
                radius_m: 0.15,
                both: true,
                down: false,
            };
            let _ = bar.want(&job, &firmware::rig::bar(&Settings::default()));
            let mut this = Self(bar, ValveConfig::default(), RigState::default());
            this.2.pressure_pa = 4e4;
            // Outside the circle until the pressure has settled, then in.
            this.2.gauge_m = 5e-4;
            for _ in 0..5000 {
                this.step(0.0);
            }
            this.2.gauge_m = 0.0;
            this
        }
        fn step(&mut self, y: f32) -> f32 {
            self.2.gauge_m += 1e-9 * y;
            self.2.gauge_m *= 0.9;
            let (_, command) = self.0.step(&self.1, 4e4, true, &self.2);
            // What there is to say is taken, as the slow duty does.
            let said = self.0.news().is_some();
            command + f32::from(u8::from(said))
        }
    }

    kernels![
        Nop, Update21, Update22, Update43, Update44, Update65, Update66, Update87, Update88,
        Roots21, Roots22, Roots43, Roots44, Roots65, Roots66, Roots87, Roots88, Chain21, Chain22,
        Chain43, Chain44, Chain65, Chain66, Chain87, Chain88, Lines, Finder, Bar,
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
}
