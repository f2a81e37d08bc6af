//! The sensor box on a Raspberry Pi Pico 2: listens to the microphone, writes frames to USB.
//!
//! On the host it prints the default settings of a monitor and the pins to wire.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("{:#?}", rarma_core::monitor::MonitorConfig::new(48_000.0));
    for (microphone, pin, number) in firmware::boards::pico2::PINS {
        println!("{microphone:4} {pin:9} pin {number}");
    }
}

#[cfg(target_os = "none")]
mod target {
    use core::pin::pin;
    use core::sync::atomic::{AtomicBool, Ordering};
    use defmt_rtt as _;
    use firmware::board::{Clock, Emergency};
    use firmware::boards::pico2::{LastResort, Pico2, reset, serve};
    use firmware::last_words::last_words;
    use firmware::{ListeningBox, SensorBox};
    use rarma_box::guard::FaultCode;
    use static_cell::StaticCell;

    defmt::timestamp!("{=u64:us}", LastResort.now_us());

    /// Too large for the stack.
    static BOX: StaticCell<SensorBox> = StaticCell::new();

    /// The program has given up once; whatever fails after that changes nothing.
    static GIVEN_UP: AtomicBool = AtomicBool::new(false);

    /// The fault kept for after the reset, a line in the log, reset.
    fn give_up(code: FaultCode, value: f32, story: impl FnOnce()) -> ! {
        // The logger may be what failed, or be in use: the first fault is the one to keep.
        if !GIVEN_UP.swap(true, Ordering::Relaxed) {
            last_words(&mut LastResort, code, value);
            story();
        }
        reset()
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

    /// An interrupt that nothing is bound to, or a fault that has its own exception.
    #[cortex_m_rt::exception]
    unsafe fn DefaultHandler(number: i16) -> ! {
        give_up(FaultCode::HardFault, f32::from(number), || {
            defmt::error!("unexpected interrupt {=i16}", number);
        })
    }

    /// Ends a wait, and does nothing else.
    #[cortex_m_rt::exception]
    fn SysTick() {}

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let (mut pico, driver) = Pico2::prepare();
        let usb = pin!(serve(driver));
        pico.start(usb);
        let mut board = ListeningBox::new(pico);
        let sensor_box = BOX.init_with(SensorBox::blank::<ListeningBox<Pico2>>);
        sensor_box.prepare(&mut board);
        sensor_box.open(&mut board);
        defmt::info!("listening");
        sensor_box.run(&mut board)
    }
}
