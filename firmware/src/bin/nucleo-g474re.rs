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
    use defmt_rtt as _;
    use firmware::board::{BoxBoard, Emergency};
    use firmware::boards::nucleo_g474re::{LastResort, Nucleo};
    use firmware::last_words::last_words;
    use firmware::{Opening, SensorBox};
    use rarma_core::guard::FaultCode;
    use static_cell::StaticCell;

    defmt::timestamp!("{=u64:us}", LastResort.now_us());

    /// Too large for the stack.
    static BOX: StaticCell<SensorBox> = StaticCell::new();

    #[panic_handler]
    fn panic(info: &core::panic::PanicInfo) -> ! {
        let line = info.location().map_or(0, core::panic::Location::line);
        last_words(&mut LastResort, FaultCode::Panic, line as f32);
        defmt::error!("panic: {}", defmt::Display2Format(info));
        cortex_m::peripheral::SCB::sys_reset()
    }

    #[cortex_m_rt::exception]
    unsafe fn HardFault(frame: &cortex_m_rt::ExceptionFrame) -> ! {
        last_words(&mut LastResort, FaultCode::HardFault, frame.pc() as f32);
        defmt::error!("hard fault at {=u32:#x}", frame.pc());
        cortex_m::peripheral::SCB::sys_reset()
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let mut board = Nucleo::set_up();
        let (sensor_box, opening) = place(&mut board);
        sensor_box.open(&mut board, opening);
        defmt::info!("listening at {=f64} Hz", Nucleo::SAMPLE_RATE_HZ);
        sensor_box.run(&mut board)
    }

    /// The box in its place; a function of its own, so that what it needs of the stack is
    /// given back.
    #[inline(never)]
    fn place(board: &mut Nucleo) -> (&'static mut SensorBox, Opening) {
        let (sensor_box, opening) = SensorBox::prepare(board);
        (BOX.init(sensor_box), opening)
    }
}
