//! The test rigs: the ball bar's millisecond, the current loop's period.

use super::Kernel;
use core::hint::black_box;
use firmware::bar::BarDuty;
use firmware::board::{
    AdcCode, BoardError, BoardErrorKind, COILS, CoilAction, CoilBridge, CoilLimits, CoilOrder,
    ForceScale, GAPS,
};
use firmware::current_loop::{CurrentLoop, MainSide};
use rarma_box::guard::RigState;
use rarma_box::settings::Settings;
use rarma_box::wire::CircleJob;
use rarma_rigs::cers::{
    AxisForce, Direction, ExcitationJob, Geometry, RegulatorConfig, Signal, Source,
};
use rarma_rigs::ldbb::ValveConfig;

/// One millisecond of the ball bar during a capture: valve loop, sequence, readings.
pub struct Bar(BarDuty, ValveConfig, RigState);

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

/// Bridges and four chokes of 4.19 mH and 4 Ω at 48 V, 40 kHz, in codes of a sensor of 8 A,
/// with a little noise.
pub struct Chokes {
    current: [f32; COILS],
    duty: [f32; COILS],
    noise: u16,
}

impl CoilBridge for Chokes {
    type Error = Never;

    fn currents(&mut self) -> Result<[AdcCode; COILS], Never> {
        // SAFETY: between 0 and 12 A by the clamps of duty and current.
        let code = |i: f32| unsafe { i.to_int_unchecked::<i32>() };
        Ok(self
            .current
            .map(|i| AdcCode(32_768 + self.noise + code(i) as u16)))
    }

    fn gaps(&mut self) -> [AdcCode; GAPS] {
        [AdcCode(24_576), AdcCode(24_500)]
    }

    fn set_duty(&mut self, duty: [f32; COILS]) -> Result<(), Never> {
        for (i, d) in self.current.iter_mut().zip(self.duty) {
            *i = *i * 0.976 + d * 2342.0;
        }
        self.duty = duty;
        Ok(())
    }

    fn off(&mut self) {}

    fn broken(&mut self) -> Option<u8> {
        None
    }

    fn rearm(&mut self) {}
}

#[derive(Debug)]
pub struct Never;

impl BoardError for Never {
    fn kind(&self) -> BoardErrorKind {
        BoardErrorKind::Refused
    }
}

/// The current loop of all four coils, and what runs on top of the bias. The chokes are
/// counted too: some forty instructions.
struct Loop {
    coils: CurrentLoop,
    main_side: MainSide,
    bridge: Chokes,
    order: CoilOrder,
    n: u32,
}

impl Loop {
    fn new(signal: Option<Signal>) -> Self {
        let tuning = RegulatorConfig {
            inductance_h: 4.19e-3,
            resistance_ohm: 4.0,
            rate_hz: 40e3,
            crossover: 1.0 / 18.0,
            most_duty: 0.95,
        };
        let magnet = Geometry::textbook().magnet();
        let law = AxisForce::new(magnet, magnet, 150e-6, 0.3927);
        let job = signal.map(|signal| ExcitationJob {
            signal,
            direction: Direction::Both,
            rms_a: 0.15,
            low_hz: 250.0,
            high_hz: 3000.0,
            seconds: 3000.0,
            lines: 150,
        });
        let order = CoilOrder {
            action: CoilAction::Regulate,
            target_a: [0.8; COILS],
            per_volt: 1.0 / 48.0,
            tuning: [tuning.tuning().unwrap_or_default(); COILS],
            limits: CoilLimits {
                span_a: 8.0,
                most_target_a: 2.5,
                trip_a: 3.0,
                lease_periods: 120,
                periods_per_ms: 40,
            },
            force: Some(ForceScale {
                laws: [law; 2],
                gap_span_m: 400e-6,
            }),
            ..CoilOrder::default()
        };
        let mut this = Self {
            coils: CurrentLoop::new(),
            main_side: MainSide::default(),
            bridge: Chokes {
                current: [0.0; COILS],
                duty: [0.0; COILS],
                noise: 0,
            },
            order,
            n: 0,
        };
        this.exchange();
        if let Some(signal) = job.and_then(|job| Source::new(&job, 40e3, 0.0).ok()) {
            this.coils.excite(&signal);
        }
        this
    }

    fn exchange(&mut self) {
        // A trip would show: the duty would be 0.
        black_box(self.main_side.exchange(&mut self.coils, &self.order));
    }

    fn step(&mut self, y: f32) -> f32 {
        self.bridge.noise = (y.to_bits() >> 20) as u16 & 7;
        self.coils.period(&mut self.bridge);
        self.n += 1;
        if self.n >= 40 {
            self.n = 0;
            self.exchange();
        }
        self.bridge.duty[0]
    }
}

/// The chokes by themselves: what the kernels of the loop have to be without.
pub struct Plant(Chokes);

impl Kernel for Plant {
    const NAME: &'static str = "four chokes, in each loop below";
    fn new() -> Self {
        Self(Chokes {
            current: [0.0; COILS],
            duty: [0.0; COILS],
            noise: 0,
        })
    }
    fn step(&mut self, y: f32) -> f32 {
        self.0.noise = (y.to_bits() >> 20) as u16 & 7;
        let codes = black_box(self.0.currents());
        let _ = self.0.set_duty(black_box([0.07; COILS]));
        codes.map_or(0.0, |c| f32::from(c[0].0))
    }
}

macro_rules! loops {
    ($($kernel:ident, $signal:expr, $name:literal;)*) => {
        $(
            pub struct $kernel(Loop);

            impl Kernel for $kernel {
                const NAME: &'static str = $name;
                fn new() -> Self {
                    Self(Loop::new($signal))
                }
                fn step(&mut self, y: f32) -> f32 {
                    self.0.step(y)
                }
            }
        )*
    };
}

loops! {
    LoopBias, None, "current loop, four coils, per period";
    LoopNoise, Some(Signal::Noise), "current loop, noise in x and y";
    LoopPrbs, Some(Signal::Prbs), "current loop, binary sequences in x and y";
    LoopSteps, Some(Signal::Steps), "current loop, stepped sine with its lock-in";
}
