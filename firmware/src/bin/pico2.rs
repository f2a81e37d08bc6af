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
    use defmt_rtt as _;
    use firmware::board::Clock;
    use firmware::boards::pico2::{LastResort, Pico2, reset, serve};
    use firmware::{ListeningBox, SensorBox};
    use static_cell::StaticCell;

    defmt::timestamp!("{=u64:us}", LastResort.now_us());

    /// Too large for the stack.
    static BOX: StaticCell<SensorBox> = StaticCell::new();

    firmware::handlers!(LastResort, reset);

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
