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
    use cortex_m::peripheral::SCB;
    use defmt_rtt as _;
    use firmware::SensorBox;
    use firmware::board::{BoxBoard, Clock, Emergency};
    use firmware::boards::nucleo_g474re::{
        LastResort, MemoryError, Nucleo, crystal_has_failed, memory_failed,
    };
    use rarma_box::guard::FaultCode;
    use static_cell::StaticCell;

    defmt::timestamp!("{=u64:us}", LastResort.now_us());

    /// Too large for the stack.
    static BOX: StaticCell<SensorBox> = StaticCell::new();

    firmware::handlers!(LastResort, SCB::sys_reset);

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
