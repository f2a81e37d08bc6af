//! The sensor box on a NUCLEO-G474RE: listens to the microphone, writes frames.
//!
//! On the host it prints the default settings of a monitor and the pins to wire.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("{:#?}", rarma_core::monitor::MonitorConfig::new(48_000.0));
    for pin in firmware::boards::nucleo_g474re::wiring::PINS {
        println!("{:5} {:22} {}", pin.pin, pin.connector, pin.signal);
    }
}

#[cfg(target_os = "none")]
mod target {
    use core::sync::atomic::{AtomicBool, Ordering};
    use defmt_rtt as _;
    use firmware::SensorBox;
    use firmware::board::{BoxBoard, Clock, Emergency};
    use firmware::boards::nucleo_g474re::{
        LastResort, MemoryError, Nucleo, crystal_has_failed, memory_failed,
    };
    use firmware::last_words::last_words;
    use rarma_box::guard::FaultCode;
    use static_cell::StaticCell;

    defmt::timestamp!("{=u64:us}", LastResort.now_us());

    /// Too large for the stack.
    static BOX: StaticCell<SensorBox> = StaticCell::new();

    /// The program has given up once; whatever fails after that changes nothing.
    static GIVEN_UP: AtomicBool = AtomicBool::new(false);

    /// Outputs off, the fault kept for after the reset, a line in the log, reset.
    fn give_up(code: FaultCode, value: f32, story: impl FnOnce()) -> ! {
        LastResort.drop_outputs();
        // The logger may be what failed, or be in use: the first fault is the one to keep.
        if !GIVEN_UP.swap(true, Ordering::Relaxed) {
            last_words(&mut LastResort, code, value);
            story();
        }
        cortex_m::peripheral::SCB::sys_reset()
    }

    #[panic_handler]
    fn panic(info: &core::panic::PanicInfo) -> ! {
        let line = info.location().map_or(0, core::panic::Location::line);
        give_up(FaultCode::Panic, line as f32, || {
            defmt::error!("panic: {}", defmt::Display2Format(info));
        })
    }

    #[cortex_m_rt::exception]
    unsafe fn HardFault(frame: &cortex_m_rt::ExceptionFrame) -> ! {
        // From the start of the flash: single precision holds that exactly.
        let at = frame.pc() & 0x00FF_FFFF;
        give_up(FaultCode::HardFault, at as f32, || {
            defmt::error!("hard fault at {=u32:#x}", frame.pc());
        })
    }

    /// A crystal that has stopped, or a double error of the flash; nothing else here raises it.
    #[cortex_m_rt::exception]
    unsafe fn NonMaskableInt() {
        LastResort.drop_outputs();
        if crystal_has_failed() {
            give_up(FaultCode::ClockFailed, 0.0, || {
                defmt::error!("the crystal has stopped");
            });
        }
        match memory_failed() {
            MemoryError::Settings => {}
            MemoryError::Program(at) => give_up(FaultCode::MemoryError, at as f32, || {
                defmt::error!("the flash has failed at {=u32:#x}", at);
            }),
            MemoryError::Other => give_up(FaultCode::HardFault, 0.0, || {
                defmt::error!("an exception that cannot be masked, and no error of the flash");
            }),
        }
    }

    /// An interrupt that nothing is bound to, or a fault that has its own exception.
    #[cortex_m_rt::exception]
    unsafe fn DefaultHandler(number: i16) -> ! {
        give_up(FaultCode::HardFault, f32::from(number), || {
            defmt::error!("unexpected interrupt {=i16}", number);
        })
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let mut board = Nucleo::set_up();
        let sensor_box = place();
        sensor_box.prepare(&mut board);
        // Made and loaded: from here on the stack is short.
        board.start_loop();
        sensor_box.open(&mut board);
        defmt::info!("listening at {=f64} Hz", Nucleo::SAMPLE_RATE_HZ);
        sensor_box.run(&mut board)
    }

    /// The box, made in its place; a function of its own, so that what it needs of the stack
    /// is given back.
    #[inline(never)]
    fn place() -> &'static mut SensorBox {
        let sensor_box = BOX.init_with(SensorBox::blank::<Nucleo>);
        // What lies at an address that the compiler knows takes it two or three instructions a
        // field to reach, what lies at one that it does not know, one.
        core::hint::black_box(sensor_box)
    }
}
