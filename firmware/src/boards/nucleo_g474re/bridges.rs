//! Four coils on TIM1's half-bridges: currents, comparators, breaks, the current loop.
//!
//! One timer drives all four, so that whatever breaks it opens all switches at once:
//! its first break input is the emergency stop's pin, its second the four comparators,
//! and the core's lock-up, the supply's fall, a dead crystal and memory errors break it too.
//! The pin and the comparators are filtered; what the chip finds in itself is not.

use super::timing::{self, DEAD_TIME_NS, PWM_HZ, PWM_TOP};
use super::{injected, scaling};
use crate::board::{
    AdcCode, BoardError, BoardErrorKind, COILS, CoilAction, CoilBridge, CoilOrder, CoilReport,
    DacCode, GAPS,
};
use crate::current_loop::{CurrentLoop, Held, MainSide};
use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, Ordering};
use embassy_stm32::interrupt::typelevel::{self, Handler, Interrupt};
use embassy_stm32::pac::timer::vals::{FilterValue, Mms2, Ossi, Ossr};
use embassy_stm32::pac::{ADC3, ADC4, COMP1, COMP4, COMP5, COMP7, DBGMCU, SYSCFG, TIM1};
use embassy_stm32::peripherals;
use embassy_stm32::time::Hertz;
use embassy_stm32::timer::Channel;
use embassy_stm32::timer::complementary_pwm::{BreakInputPolarity, ComplementaryPwm};
use embassy_stm32::timer::low_level::CountingMode;
use rarma_rigs::cers::Source;

/// Comparators of the coils in their order.
const COMPARATORS: [u32; COILS] = [1, 4, 5, 7];

/// The emergency stop's pin breaks once it has been low for 256 ticks, 1.6 µs: a long wire beside
/// a power stage carries spikes. A coil's current rises by less than 20 mA meanwhile.
const STOP_FILTER: FilterValue = FilterValue::FDTS_DIV32_N8;
/// A comparator breaks once it has been high for 64 ticks, 0.39 µs: what a bridge's switching
/// leaves on the sensors is shorter; a comparator that is blanked then would protect nothing
/// then. The current of a coil that is dead-shorted rises by 5 A meanwhile (48 V, 4 µH of wire).
const TRIP_FILTER: FilterValue = FilterValue::FDTS_DIV8_N8;

/// Every flag of TIM1 (RM0440, TIMx_SR); the other bits are reserved, and stay 0.
const EVERY_FLAG: u32 = 0x00F3_3FFF;

/// The gate is closed: the timer may switch. Looked at before every closing.
static GATE: AtomicBool = AtomicBool::new(false);

/// The loop, shared by the interrupt and the main side.
struct SharedLoop(UnsafeCell<Option<CurrentLoop>>);

// SAFETY: only touched inside critical sections, which the interrupt's handler cannot
// interrupt, and by that handler, which nothing interrupts that touches it.
unsafe impl Sync for SharedLoop {}

static LOOP: SharedLoop = SharedLoop(UnsafeCell::new(None));

impl Held for &SharedLoop {
    fn hold<R>(&mut self, act: impl FnOnce(&mut CurrentLoop) -> R) -> Option<R> {
        critical_section::with(|_| {
            // SAFETY: see `Sync` above; the borrow ends with the section.
            unsafe { &mut *self.0.get() }.as_mut().map(act)
        })
    }
}

/// The end of a period's current conversions.
#[derive(Debug)]
pub(super) struct PeriodInterrupt;

impl Handler<typelevel::ADC3> for PeriodInterrupt {
    unsafe fn on_interrupt() {
        current_duty();
    }
}

/// The current loop's duty, once a PWM period. A function of its own, so that the linked
/// image can be searched for what it may call.
#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn current_duty() {
    (&LOOP).hold(|regulators| regulators.period(&mut Bridges));
}

/// Main side of the loop.
///
/// While nothing is to be done the interrupt is off, which leaves a fifth of the core to
/// listening; the loop then has one period here, in which it opens the switches.
pub(super) fn exchange(main_side: &mut MainSide, order: &CoilOrder) -> CoilReport {
    let in_use = order.action != CoilAction::Off;
    ADC3.ier().modify(|w| w.set_jeosie(in_use));
    let report = main_side.exchange(&mut &LOOP, order);
    if !in_use {
        (&LOOP).hold(|regulators| regulators.period(&mut Bridges));
    }
    report.unwrap_or_default()
}

/// Starts a signal in the loop.
pub(super) fn excite(signal: &Source) {
    (&LOOP).hold(|regulators| regulators.excite(signal));
}

/// Why the timer does not switch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BridgeError {
    /// A current was not converted in this period.
    NotConverted,
    /// A break holds the switches open.
    Broken,
}

impl BoardError for BridgeError {
    fn kind(&self) -> BoardErrorKind {
        match self {
            Self::NotConverted => BoardErrorKind::Converter,
            Self::Broken => BoardErrorKind::Refused,
        }
    }
}

/// The bridges. Has no content: the timer is the state.
#[derive(Debug)]
pub(super) struct Bridges;

impl CoilBridge for Bridges {
    type Error = BridgeError;

    fn currents(&mut self) -> Result<[AdcCode; COILS], BridgeError> {
        let both = injected::take(ADC3) & injected::take(ADC4);
        let code =
            |adc: embassy_stm32::pac::adc::Adc, rank| scaling::left_aligned(adc.jdr(rank).read().0);
        if !both {
            return Err(BridgeError::NotConverted);
        }
        Ok([code(ADC3, 0), code(ADC3, 1), code(ADC3, 2), code(ADC4, 0)])
    }

    fn gaps(&mut self) -> [AdcCode; GAPS] {
        let code = |rank| scaling::left_aligned(ADC4.jdr(rank).read().0);
        // Each rank by itself: its check is then made by the compiler.
        [code(1), code(2)]
    }

    fn set_duty(&mut self, duty: [f32; COILS]) -> Result<(), BridgeError> {
        if is_broken() {
            self.off();
            return Err(BridgeError::Broken);
        }
        let [x1, x2, y1, y2] = duty.map(timing::compare);
        TIM1.ccr(0).write(|w| w.set_ccr(x1));
        TIM1.ccr(1).write(|w| w.set_ccr(x2));
        TIM1.ccr(2).write(|w| w.set_ccr(y1));
        TIM1.ccr(3).write(|w| w.set_ccr(y2));
        if GATE.load(Ordering::Acquire) {
            TIM1.bdtr().modify(|w| w.set_moe(true));
        }
        Ok(())
    }

    fn off(&mut self) {
        open_switches();
    }

    fn broken(&mut self) -> Option<u8> {
        if !TIM1.sr().read().bif(1) {
            return None;
        }
        let high = [COMP1, COMP4, COMP5, COMP7].map(|comparator| comparator.csr().read().value());
        // The current falls as soon as the switches are open: where no comparator is high
        // any more, the first coil is named for all.
        let coil = high.iter().position(|&is_high| is_high).unwrap_or(0);
        Some(coil as u8)
    }

    fn rearm(&mut self) {
        TIM1.sr().write(|w| {
            // Writing 1 leaves a flag as it is.
            w.0 = EVERY_FLAG;
            w.set_bif(0, false);
            w.set_bif(1, false);
            w.set_sbif(false);
        });
    }
}

/// A break has come and has not been taken back.
pub(super) fn is_broken() -> bool {
    let flags = TIM1.sr().read();
    flags.bif(0) || flags.bif(1) || flags.sbif()
}

/// All switches open, by one register.
pub(super) fn open_switches() {
    TIM1.bdtr().modify(|w| w.set_moe(false));
}

/// Lets the loop close switches, or not.
pub(super) fn set_gate(closed: bool) {
    GATE.store(closed, Ordering::Release);
}

/// Whether the loop may close switches.
pub(super) fn gate() -> bool {
    GATE.load(Ordering::Acquire)
}

/// Prepares the timer, outputs off; the comparators and the converters are set up already.
pub(super) fn start(mut pwm: ComplementaryPwm<'static, peripherals::TIM1>) {
    // The driver has left the outputs enabled with no channel on.
    pwm.set_master_output_enable(false);
    pwm.set_dead_time(timing::ticks_up(DEAD_TIME_NS) as u16);
    // Off means driven low, not floating, whether by a break or by software.
    pwm.set_off_state_selection_idle(Ossi::IDLE_LEVEL);
    pwm.set_off_state_selection_run(Ossr::IDLE_LEVEL);
    pwm.set_automatic_output_enable(false);
    pwm.set_break_polarity(BreakInputPolarity::ACTIVE_LOW);
    pwm.set_break_input_pin_enable(true);
    pwm.set_break2_polarity(BreakInputPolarity::ACTIVE_HIGH);
    // The accessors of the HAL end at the fourth comparator; the seventh is bit 7. None is
    // inverted, as after a reset.
    TIM1.af2()
        .modify(|w| w.0 |= COMPARATORS.iter().fold(0, |bits, n| bits | 1 << n));
    pwm.set_break_filter(STOP_FILTER);
    pwm.set_break2_filter(TRIP_FILTER);
    pwm.set_break_enable(true);
    pwm.set_break2_enable(true);
    for channel in [Channel::Ch1, Channel::Ch2, Channel::Ch3, Channel::Ch4] {
        pwm.set_duty(channel, 0);
        pwm.enable(channel);
    }
    // One update, and so one trigger of the converters, a period; where the ripple passes
    // through its mean.
    TIM1.arr().write(|w| w.set_arr(PWM_TOP));
    TIM1.rcr().write(|w| w.set_rep(1));
    TIM1.cr2().modify(|w| w.set_mms2(Mms2::UPDATE));
    // The core's lock-up, the supply's fall, parity and double errors of the memories.
    SYSCFG.cfgr2().modify(|w| {
        w.set_cll(true);
        w.set_spl(true);
        w.set_pvdl(true);
        w.set_eccl(true);
    });
    // A core that a debugger halts regulates nothing: the timer stops with it, which opens the
    // switches; the watchdog does not, and its reset takes down the rest.
    DBGMCU.apb2fzr().modify(|w| w.set_tim1(true));
    DBGMCU.apb1lfzr().modify(|w| w.set_iwdg(false));
    open_switches();
    core::mem::forget(pwm);
}

/// Starts the loop: from here on its interrupt comes once a period of those in use.
pub(super) fn start_loop() {
    critical_section::with(|_| {
        // SAFETY: see `SharedLoop`.
        unsafe { *LOOP.0.get() = Some(CurrentLoop::new()) };
    });
    // SAFETY: the handler is bound in this board, and the loop is there.
    unsafe { typelevel::ADC3::enable() };
}

/// Rate and counting of the driver that [`start`] takes.
pub(super) const RATE: (Hertz, CountingMode) =
    (Hertz(PWM_HZ), CountingMode::CenterAlignedBothInterrupts);

/// Code of the comparators' threshold.
pub(super) fn trip_code() -> u16 {
    scaling::dac_12_bits(DacCode::from_fraction(scaling::TRIP_SHARE))
}
