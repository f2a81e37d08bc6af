//! Pins that fail, and what becomes of the verb.

use super::*;
use crate::board::{AdcCode, Block, Clock, Contacts, DacCode, Lights};
use core::convert::Infallible;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{self, InputPin, OutputPin};
use embedded_hal::pwm::{self, SetDutyCycle};
use embedded_hal::spi::{self, Operation, SpiDevice};
use std::cell::Cell;
use std::collections::VecDeque;

/// A pin that reads this, or cannot be read.
struct In<'a>(&'a Cell<Option<bool>>);

impl digital::ErrorType for In<'_> {
    type Error = digital::ErrorKind;
}

impl InputPin for In<'_> {
    fn is_high(&mut self) -> Result<bool, Self::Error> {
        self.0.get().ok_or(digital::ErrorKind::Other)
    }

    fn is_low(&mut self) -> Result<bool, Self::Error> {
        self.is_high().map(|high| !high)
    }
}

/// A pin of the chip.
struct Out<'a>(&'a Cell<bool>);

impl digital::ErrorType for Out<'_> {
    type Error = Infallible;
}

impl OutputPin for Out<'_> {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.set(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.set(true);
        Ok(())
    }
}

/// Counts what it was to wait, and closes a contact after a time.
struct Delay<'a> {
    waited_us: u32,
    closes: Option<(u32, &'a Cell<Option<bool>>)>,
}

impl DelayNs for Delay<'_> {
    fn delay_ns(&mut self, ns: u32) {
        self.waited_us += ns / 1000;
        if let Some((after_us, contact)) = self.closes
            && self.waited_us >= after_us
        {
            contact.set(Some(true));
        }
    }
}

const CLOSED: Contacts = Contacts {
    enable: true,
    stop_chain: true,
};

#[test]
fn a_contact_that_cannot_be_read_is_open() {
    let (enable, stop) = (Cell::new(Some(true)), Cell::new(Some(true)));
    let mut contacts = ContactPins::new(In(&enable), In(&stop));
    assert_eq!(contacts.read(), CLOSED);
    enable.set(None);
    stop.set(Some(false));
    let open = Contacts {
        enable: false,
        stop_chain: false,
    };
    assert_eq!(contacts.read(), open);
    stop.set(None);
    assert_eq!(contacts.read(), open);
}

#[test]
fn the_gate_closes_only_where_it_is_seen_to_have_closed() {
    let (order, contact) = (Cell::new(true), Cell::new(Some(false)));
    let mut gate = Gate::new(Out(&order), In(&contact));
    assert!(!order.get(), "a new gate is open");
    let mut slow = Delay {
        waited_us: 0,
        closes: Some((5, &contact)),
    };
    assert_eq!(gate.close(CLOSED, &mut slow), Ok(()));
    assert!(order.get() && gate.is_closed() && slow.waited_us == 5);
    gate.open();
    assert!(!order.get());
    // The read-back still says closed: that is the box's fault of the gate.
    assert!(gate.is_closed());

    contact.set(Some(false));
    let mut never = Delay {
        waited_us: 0,
        closes: None,
    };
    assert_eq!(gate.close(CLOSED, &mut never), Err(PartFailed::Gate));
    assert!(!order.get() && never.waited_us == 20);
    contact.set(None);
    assert_eq!(gate.close(CLOSED, &mut never), Err(PartFailed::Gate));
    assert!(!order.get());
    let stopped = Contacts {
        stop_chain: false,
        ..CLOSED
    };
    assert_eq!(gate.close(stopped, &mut never), Err(PartFailed::StopChain));
    assert!(!order.get());
}

#[test]
fn a_read_back_that_cannot_be_read_is_not_as_ordered() {
    let (order, contact) = (Cell::new(false), Cell::new(Some(true)));
    let mut gate = Gate::new(Out(&order), In(&contact));
    let mut delay = Delay {
        waited_us: 0,
        closes: None,
    };
    assert_eq!(gate.close(CLOSED, &mut delay), Ok(()));
    contact.set(None);
    assert!(!gate.is_closed());
    gate.open();
    assert!(gate.is_closed());
}

/// A channel of 1000 steps.
struct Channel<'a> {
    duty: &'a Cell<u16>,
    refuses: &'a Cell<bool>,
}

impl pwm::ErrorType for Channel<'_> {
    type Error = pwm::ErrorKind;
}

impl SetDutyCycle for Channel<'_> {
    fn max_duty_cycle(&self) -> u16 {
        1000
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Self::Error> {
        // Only what would drive it is refused.
        if self.refuses.get() && duty > 0 {
            return Err(pwm::ErrorKind::Other);
        }
        self.duty.set(duty);
        Ok(())
    }
}

#[test]
fn the_valve_is_shut_without_the_gate_and_where_it_refuses() {
    let (duty, refuses) = (Cell::new(700), Cell::new(false));
    let mut valve = PwmValve::new(Channel {
        duty: &duty,
        refuses: &refuses,
    });
    assert_eq!(duty.get(), 0);
    assert_eq!(valve.set(DacCode::from_fraction(0.5), true), Ok(()));
    assert_eq!(duty.get(), 500);
    assert_eq!(valve.set(DacCode(u16::MAX), true), Ok(()));
    assert_eq!(duty.get(), 1000);
    assert_eq!(valve.set(DacCode(u16::MAX), false), Ok(()));
    assert_eq!(duty.get(), 0);
    valve.set(DacCode(30_000), true).unwrap();
    refuses.set(true);
    assert_eq!(
        valve.set(DacCode(40_000), true),
        Err(PartFailed::Valve),
        "named"
    );
    assert_eq!(duty.get(), 0);
}

/// Answers each transfer with these bytes.
struct Bus(Option<[u8; 3]>);

impl spi::ErrorType for Bus {
    type Error = spi::ErrorKind;
}

impl SpiDevice for Bus {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Self::Error> {
        let answer = self.0.ok_or(spi::ErrorKind::Other)?;
        for operation in operations {
            if let Operation::TransferInPlace(bytes) = operation {
                bytes.copy_from_slice(&answer);
            }
        }
        Ok(())
    }
}

#[test]
fn codes_of_every_width_fill_the_range() {
    let code = |answer, bits, after| {
        let mut converter = SpiConverter::new(Bus(answer), bits, after).expect("fits");
        converter.code([6, 0, 0])
    };
    assert_eq!(code(Some([0xFF, 0xEF, 0xFF]), 12, 0), Ok(AdcCode::FULL));
    assert_eq!(code(Some([0xFF, 0xF0, 0x00]), 12, 0), Ok(AdcCode(0)));
    assert_eq!(code(Some([0, 0x08, 0x00]), 12, 0), Ok(AdcCode(0x8008)));
    // 16 bits after four others, and 10 in the middle.
    assert_eq!(code(Some([0xF1, 0x23, 0x45]), 16, 4), Ok(AdcCode(0x1234)));
    assert_eq!(code(Some([0, 0x1F, 0xF8]), 10, 3), Ok(AdcCode::FULL));
    assert_eq!(code(Some([0xAB, 0xCD, 0xEF]), 8, 16), Ok(AdcCode(0xABAB)));
    assert_eq!(code(None, 12, 0), Err(PartFailed::Converter));
    for (bits, after) in [(7, 0), (17, 0), (12, 13), (16, 9)] {
        assert!(SpiConverter::new(Bus(None), bits, after).is_none());
    }
}

/// A clock that the delay and the driver move.
#[derive(Clone, Copy)]
struct Time<'a>(&'a Cell<u64>);

impl Clock for Time<'_> {
    fn now_us(&mut self) -> u64 {
        self.0.get()
    }
}

impl DelayNs for Time<'_> {
    fn delay_ns(&mut self, ns: u32) {
        self.0.set(self.0.get() + u64::from(ns / 1000));
    }
}

#[test]
fn samples_come_at_their_rate_and_late_ones_are_counted() {
    let now = Cell::new(5_000);
    let time = Time(&now);
    let broken = Cell::new(false);
    let read = || {
        let at = now.get();
        now.set(at + 40);
        if broken.get() { Err(()) } else { Ok(at as f32) }
    };
    let mut source = Polled::new(3000, time, time, read);
    let mut block = [0.0; 4];
    let one = |missing| {
        Ok(Block {
            samples: 1,
            missing,
        })
    };
    for at in [5_000.0, 5_333.0, 5_666.0, 6_000.0] {
        assert_eq!(source.samples(&mut block), one(0));
        assert_eq!(block[0], at);
    }
    // 1 ms away: three samples did not happen, the next is due at 7333.
    now.set(7_340);
    assert_eq!(source.samples(&mut block), one(3));
    assert_eq!(block[0], 7_340.0);
    assert_eq!(source.samples(&mut block), one(0));
    assert_eq!(block[0], 7_666.0);
    let nothing = Block {
        samples: 0,
        missing: 0,
    };
    assert_eq!(source.samples(&mut []), Ok(nothing));
    broken.set(true);
    assert_eq!(source.samples(&mut block), Err(PartFailed::Converter));
    broken.set(false);
    assert_eq!(
        source.samples(&mut block),
        Err(PartFailed::Converter),
        "once an error, always one"
    );
}

/// A port that takes so many bytes at a time while it is ready.
struct Port<'a> {
    ready: &'a Cell<usize>,
    down: &'a Cell<bool>,
    out: Vec<u8>,
    to_come: VecDeque<u8>,
}

impl embedded_io::ErrorType for Port<'_> {
    type Error = embedded_io::ErrorKind;
}

impl Port<'_> {
    fn up(&self) -> Result<(), embedded_io::ErrorKind> {
        if self.down.get() {
            return Err(embedded_io::ErrorKind::NotConnected);
        }
        Ok(())
    }
}

impl embedded_io::Read for Port<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Self::Error> {
        self.up()?;
        let n = bytes.len().min(self.to_come.len());
        for (place, byte) in bytes.iter_mut().zip(self.to_come.drain(..n)) {
            *place = byte;
        }
        Ok(n)
    }
}

impl embedded_io::ReadReady for Port<'_> {
    fn read_ready(&mut self) -> Result<bool, Self::Error> {
        self.up().map(|()| !self.to_come.is_empty())
    }
}

impl embedded_io::Write for Port<'_> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
        self.up()?;
        let n = bytes.len().min(self.ready.get());
        self.ready.set(self.ready.get() - n);
        self.out.extend_from_slice(&bytes[..n]);
        Ok(n)
    }

    fn flush(&mut self) -> Result<(), Self::Error> {
        Ok(())
    }
}

impl embedded_io::WriteReady for Port<'_> {
    fn write_ready(&mut self) -> Result<bool, Self::Error> {
        self.up().map(|()| self.ready.get() > 0)
    }
}

#[test]
fn a_frame_is_taken_whole_or_not_at_all() {
    let (ready, down) = (Cell::new(3), Cell::new(false));
    let mut link = PortLink::<_, 8>::new(Port {
        ready: &ready,
        down: &down,
        out: Vec::new(),
        to_come: VecDeque::from([7, 8, 9]),
    });
    assert_eq!(link.send(&[1, 2, 3, 4, 5]), Ok(()));
    assert_eq!(link.port.out, [1, 2, 3]);
    // Two wait, so that six have room and seven have not.
    assert_eq!(link.send(&[0; 7]), Err(PartFailed::Busy));
    assert_eq!(link.send(&[6; 6]), Ok(()));
    down.set(true);
    assert_eq!(link.send(&[0; 1]), Err(PartFailed::Link));
    assert_eq!(link.receive(&mut [0; 4]), Err(PartFailed::Link));
    down.set(false);
    ready.set(100);
    assert_eq!(link.pump(), Ok(()));
    assert_eq!(link.port.out, [1, 2, 3, 4, 5, 6, 6, 6, 6, 6, 6]);
    let mut bytes = [0; 2];
    assert_eq!((link.receive(&mut bytes), bytes), (Ok(2), [7, 8]));
    assert_eq!((link.receive(&mut bytes), bytes[0]), (Ok(1), 9));
    assert_eq!(link.receive(&mut bytes), Ok(0));
}

#[test]
fn lights_as_they_are_shown() {
    let pins = [Cell::new(false), Cell::new(false)];
    let mut lights = LightPins::new(Out(&pins[0]), NoPin, Out(&pins[1]));
    lights.show(Lights {
        alive: true,
        energised: true,
        warning: false,
    });
    assert_eq!(pins.each_ref().map(Cell::get), [true, false]);
    let mut one = OneLight(Out(&pins[1]));
    for (alive, warning) in [(false, false), (false, true), (true, false), (true, true)] {
        one.show(Lights {
            alive,
            energised: true,
            warning,
        });
        assert_eq!(pins[1].get(), alive || warning);
    }
}
