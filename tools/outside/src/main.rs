#![no_std]
#![no_main]
use rarma_core::prelude::*;
#[cortex_m_rt::entry]
fn main() -> ! {
    let mut model = Arma43::<f32>::new(RarmaConfig::default());
    let mut roots = FactorTracker::<f32, 4>::new();
    // Addresses of a converter and of a port.
    let (adc, port) = (0x5000_0040 as *const u16, 0x4000_4428 as *mut f32);
    loop {
        model.update(unsafe { adc.read_volatile() }.into());
        roots.track(model.a());
        let mode = modal(&roots.factors(4)[0], 6000.0);
        unsafe { port.write_volatile(mode.map_or(1.0, |mode| mode.damping)) };
    }
}
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {}
}
