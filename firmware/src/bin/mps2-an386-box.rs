//! The whole box on the emulated board, its link on the first UART.
//!
//! On the host it prints the default settings of a monitor.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("{:#?}", rarma_core::monitor::MonitorConfig::new(8000.0));
}

#[cfg(target_os = "none")]
mod target {
    use firmware::boards::mps2_an386::Mps2Box;
    use firmware::{ListeningBox, SensorBox};
    use {cortex_m as _, defmt_semihosting as _};

    defmt::timestamp!("{=u32}", 0);

    firmware::emulated_handlers!();

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let mut board = ListeningBox::new(Mps2Box::set_up());
        // The emulated board has memory enough for the box on the stack.
        let mut sensor_box = SensorBox::start(&mut board);
        sensor_box.run(&mut board)
    }
}
