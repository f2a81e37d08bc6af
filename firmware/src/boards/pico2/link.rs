//! The link to the host: a serial port over USB. The stack is futures; the main loop polls them, once a pass
//! and after every interrupt, and needs no executor.

use core::cell::Cell;
use core::pin::Pin;
use core::task::{Context, Waker};
use critical_section::Mutex;
use embassy_futures::join::join3;
use embassy_rp::peripherals::USB;
use embassy_rp::usb::Driver;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::pipe::Pipe;
use embassy_usb::class::cdc_acm::{CdcAcmClass, State};
use embassy_usb::{Builder, Config};
use static_cell::{ConstStaticCell, StaticCell};

/// Test numbers of pid.codes, for devices that are not sold.
const VENDOR: u16 = 0x1209;
const PRODUCT: u16 = 0x0001;
/// Bytes of a packet at full speed.
const PACKET: usize = 64;
/// Bytes that may wait to be sent: what a verdict every 10 ms with raw samples beside it needs in some 40 ms.
const OUT: usize = 8192;
/// Bytes that may wait to be taken.
const IN: usize = 512;
/// What nobody has fetched for so long is of another time, µs.
const STALE_US: u64 = 1_000_000;

/// What waits on both ways, and when there was room for a frame last, µs.
static OUTGOING: Pipe<CriticalSectionRawMutex, OUT> = Pipe::new();
static INCOMING: Pipe<CriticalSectionRawMutex, IN> = Pipe::new();
static ROOM_US: Mutex<Cell<u64>> = Mutex::new(Cell::new(0));

/// Memory of the stack: descriptors, transfers of control, state of the class.
static BUFFERS: ConstStaticCell<[[u8; 128]; 3]> = ConstStaticCell::new([[0; 128]; 3]);
static STATE: StaticCell<State<'static>> = StaticCell::new();

/// Accepts a frame, or says that there is no room for the whole of it.
pub(super) fn send(frame: &[u8], now_us: u64) -> bool {
    if OUTGOING.free_capacity() < frame.len() {
        let since_us = critical_section::with(|cs| ROOM_US.borrow(cs).get());
        if now_us.saturating_sub(since_us) > STALE_US {
            OUTGOING.clear();
        }
        return false;
    }
    critical_section::with(|cs| ROOM_US.borrow(cs).set(now_us));
    let mut rest = frame;
    while let Ok(taken) = OUTGOING.try_write(rest)
        && taken < rest.len()
    {
        rest = rest.get(taken..).unwrap_or_default();
    }
    true
}

/// Takes bytes that have come.
pub(super) fn receive(bytes: &mut [u8]) -> usize {
    INCOMING.try_read(bytes).unwrap_or(0)
}

/// Serves USB for ever.
pub async fn serve(driver: Driver<'static, USB>) {
    let mut config = Config::new(VENDOR, PRODUCT);
    config.manufacturer = Some("rarma");
    config.product = Some("rarma box");
    let [configuration, capabilities, control] = BUFFERS.take();
    let mut builder = Builder::new(
        driver,
        config,
        configuration,
        capabilities,
        &mut [],
        control,
    );
    let class = CdcAcmClass::new(&mut builder, STATE.init(State::new()), PACKET as u16);
    let (mut sender, mut receiver) = class.split();
    let mut device = builder.build();
    let send = async {
        let mut packet = [0; PACKET];
        loop {
            sender.wait_connection().await;
            loop {
                let bytes = OUTGOING.read(&mut packet).await;
                if sender.write_packet(&packet[..bytes]).await.is_err() {
                    break;
                }
                // The host waits for more after a full packet, until an empty one comes.
                if bytes == PACKET && OUTGOING.is_empty() && sender.write_packet(&[]).await.is_err()
                {
                    break;
                }
            }
        }
    };
    let receive = async {
        let mut packet = [0; PACKET];
        loop {
            receiver.wait_connection().await;
            while let Ok(bytes) = receiver.read_packet(&mut packet).await {
                let mut rest = &packet[..bytes];
                while !rest.is_empty() {
                    rest = &rest[INCOMING.write(rest).await..];
                }
            }
        }
    };
    join3(device.run(), send, receive).await;
}

/// Goes on with what has come; none of the futures is woken, all of them look.
pub(super) fn poll(usb: Pin<&mut dyn Future<Output = ()>>) {
    let _ = usb.poll(&mut Context::from_waker(Waker::noop()));
}
