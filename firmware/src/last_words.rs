//! What a panic or an exception does: outputs first, then the record, then nothing.

use crate::board::Emergency;
use rarma_box::guard::{FaultCode, FaultRecord};

/// Drops the outputs, then keeps the fault for the host to read after the reset. A board's
/// panic and exception handlers call this first, log after it, and then reset.
///
/// `value` is whatever the handler knows (a line number, a status word).
#[inline(never)]
pub fn last_words<E: Emergency>(board: &mut E, code: FaultCode, value: f32) {
    board.drop_outputs();
    let record = FaultRecord {
        code,
        place: 0,
        value,
        at_us: board.now_us(),
    };
    board.keep(&record.to_kept());
}

/// The handlers of a board's image, each for all that is left to be done: outputs off, last words, a line in
/// the log, reset. `$last_resort` is an [`Emergency`](crate::board::Emergency), `$reset` a function that does not return. A board's own
/// exceptions call the `give_up` that stands beside them.
#[macro_export]
macro_rules! handlers {
    ($last_resort:expr, $reset:path) => {
        /// The program has given up once; whatever fails after that changes nothing.
        static GIVEN_UP: core::sync::atomic::AtomicBool =
            core::sync::atomic::AtomicBool::new(false);

        /// Outputs off, the fault kept for after the reset, a line in the log, reset.
        fn give_up(code: rarma_box::guard::FaultCode, value: f32, story: impl FnOnce()) -> ! {
            $crate::board::Emergency::drop_outputs(&mut $last_resort);
            // The logger may be what failed, or be in use: the first fault is the one to keep.
            if !GIVEN_UP.swap(true, core::sync::atomic::Ordering::Relaxed) {
                $crate::last_words(&mut $last_resort, code, value);
                story();
            }
            $reset()
        }

        #[panic_handler]
        fn panic(info: &core::panic::PanicInfo) -> ! {
            let line = info.location().map_or(0, core::panic::Location::line);
            give_up(rarma_box::guard::FaultCode::Panic, line as f32, || {
                defmt::error!("panic: {}", defmt::Display2Format(info));
            })
        }

        #[cortex_m_rt::exception]
        unsafe fn HardFault(frame: &cortex_m_rt::ExceptionFrame) -> ! {
            // From the start of the flash: single precision holds that exactly.
            let at = frame.pc() & 0x00FF_FFFF;
            give_up(rarma_box::guard::FaultCode::HardFault, at as f32, || {
                defmt::error!("hard fault at {=u32:#x}", frame.pc());
            })
        }

        /// An interrupt that nothing is bound to, or a fault that has its own exception.
        #[cortex_m_rt::exception]
        unsafe fn DefaultHandler(number: i16) -> ! {
            let code = rarma_box::guard::FaultCode::HardFault;
            give_up(code, f32::from(number), || {
                defmt::error!("unexpected interrupt {=i16}", number);
            })
        }
    };
}

/// The handler of an emulated image: a line in the log, and the emulator ends with a failure (`fail`).
#[macro_export]
macro_rules! emulated_handlers {
    () => {
        #[panic_handler]
        fn panic(info: &core::panic::PanicInfo) -> ! {
            defmt::error!("panic: {}", defmt::Display2Format(info));
            fail()
        }

        fn fail() -> ! {
            loop {
                cortex_m_semihosting::debug::exit(cortex_m_semihosting::debug::EXIT_FAILURE);
            }
        }
    };
}
