//! Tests that run on the emulated Cortex-M4F: `cargo fw test`.
//!
//! On the host this file is an empty program, so that host test runners pass it by.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod runtime {
    use {cortex_m as _, cortex_m_rt as _, defmt_semihosting as _};

    use cortex_m_semihosting::debug::{EXIT_FAILURE, exit};

    defmt::timestamp!("{=u32}", 0u32);

    #[panic_handler]
    fn panic(info: &core::panic::PanicInfo) -> ! {
        defmt::error!("{}", defmt::Display2Format(info));
        loop {
            exit(EXIT_FAILURE);
        }
    }
}

#[cfg(target_os = "none")]
#[defmt_test::tests]
mod tests {
    use core::hint::black_box;

    use defmt::assert_eq;

    /// One multiplication and one addition round twice, whatever the optimiser does.
    #[test]
    fn multiply_add_is_not_fused() {
        let (a, b) = (
            black_box(1.0_f32 + f32::EPSILON),
            black_box(1.0_f32 - f32::EPSILON),
        );
        assert_eq!(a * b - 1.0, 0.0);
    }
}
