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
    use firmware::board::{Block, BoxBoard, Emergency, Lights};
    use firmware::boards::nucleo_g474re::{LastResort, Nucleo};
    use firmware::current_loop::CoilOrder;
    use firmware::last_words::last_words;
    use firmware::monitor::MonitorDuty;
    use rarma_core::guard::FaultCode;
    use rarma_core::monitor::MonitorConfig;
    use rarma_core::wire::{MAX_FRAME, MonitorJob, Telemetry, encode};
    use static_cell::StaticCell;

    defmt::timestamp!("{=u64:us}", LastResort.now_us());

    /// A verdict is sent this often, s.
    const EVERY_S: f64 = 0.1;
    /// Samples taken at a time.
    const BLOCK: usize = 64;

    /// 21 KB that must not lie on the stack.
    static DUTY: StaticCell<MonitorDuty> = StaticCell::new();

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
        let job = MonitorJob {
            monitor: MonitorConfig::new(Nucleo::SAMPLE_RATE_HZ),
            channel: 0,
            every_s: EVERY_S,
        };
        let mut listening = Listening {
            duty: idle(),
            sequence: 0,
        };
        if let Err(error) = listening.duty.begin(&job) {
            defmt::panic!("settings: {}", defmt::Debug2Format(&error));
        }
        defmt::info!("listening at {=f64} Hz", Nucleo::SAMPLE_RATE_HZ);
        let started = listening.duty.started();
        send(&mut board, &mut listening.sequence, &started);
        let mut passes = 0u32;
        loop {
            sample_duty(&mut listening, &mut board);
            board.coils(&CoilOrder::default());
            board.feed_watchdog();
            passes = passes.wrapping_add(1);
            board.lights(Lights {
                alive: passes & 512 != 0,
                ..Lights::default()
            });
            board.wait();
        }
    }

    /// The duty in its place; a function of its own, so that what it needs of the stack is
    /// given back.
    #[inline(never)]
    fn idle() -> &'static mut MonitorDuty {
        DUTY.init_with(MonitorDuty::idle)
    }

    struct Listening {
        duty: &'static mut MonitorDuty,
        sequence: u16,
    }

    /// All samples there are.
    #[inline(never)]
    fn sample_duty(listening: &mut Listening, board: &mut Nucleo) {
        let mut block = [0.0; BLOCK];
        while let Ok(Block { samples, missing }) = board.samples(&mut block)
            && samples > 0
        {
            if missing > 0 {
                listening.duty.missing(missing);
            }
            for &x in block.iter().take(samples) {
                let sequence = &mut listening.sequence;
                listening
                    .duty
                    .sample(x, &mut |message| send(board, sequence, message));
            }
        }
    }

    /// Sends a message, or leaves it behind where the gap in the numbers tells the host.
    fn send(board: &mut Nucleo, sequence: &mut u16, message: &Telemetry) {
        let mut buffer = [0; MAX_FRAME];
        if let Ok(frame) = encode(message, *sequence, &mut buffer) {
            let _ = board.send(frame);
        }
        *sequence = sequence.wrapping_add(1);
    }
}
