//! The sensor box on the emulated board: reads a recording, writes frames.
//!
//! On the host it prints the default settings of a monitor.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("{:#?}", rarma_core::monitor::MonitorConfig::new(48_000.0));
}

#[cfg(target_os = "none")]
mod target {
    use cortex_m_semihosting::debug::{EXIT_SUCCESS, exit};
    use firmware::boards::mps2_an386::{Mps2, SetUpError};
    use firmware::{Job, Outcome};
    use {cortex_m as _, defmt_semihosting as _};

    defmt::timestamp!("{=u32}", 0);

    firmware::emulated_handlers!();

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let (mut board, job) = match Mps2::set_up() {
            Ok(ready) => ready,
            Err(error) => {
                match error {
                    SetUpError::Job => {
                        defmt::error!("job.bin: missing, or not a job of this version")
                    }
                    SetUpError::Output => defmt::error!("out.bin: cannot be written"),
                    SetUpError::Input => defmt::error!("in.wav: cannot be opened"),
                    SetUpError::Wav(wav) => {
                        defmt::error!("in.wav: {}", defmt::Debug2Format(&wav));
                    }
                }
                fail()
            }
        };
        let outcome = match Job::start(&mut board, &job) {
            Ok(mut job) => job.run(),
            Err(refusal) => Outcome::Refused(refusal),
        };
        match outcome {
            Outcome::Ended => {
                exit(EXIT_SUCCESS);
                loop {}
            }
            Outcome::Refused(why) => {
                defmt::error!("refused: {}", defmt::Debug2Format(&why));
                fail()
            }
        }
    }
}
