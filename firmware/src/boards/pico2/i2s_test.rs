//! The program, instruction by instruction as RP2350's data sheet tells them, on one side of the wire, and
//! the microphone as its own data sheet tells it on the other.

use super::*;

/// What the state machine can be seen to do in one step.
struct Step {
    sck: bool,
    ws: bool,
    pushed: Option<u32>,
}

/// A state machine (RP2350 data sheet, chapter 11.4: encodings of JMP, IN, MOV and SET), with its input
/// shifting left and pushing by itself at 24 bits.
struct Machine {
    code: Vec<u16>,
    wrap: (usize, usize),
    at: usize,
    x: u32,
    shifted: u32,
    count: u32,
    pins: u16,
}

impl Machine {
    fn new() -> Self {
        let program = program();
        assert_eq!(program.side_set.bits(), 2);
        assert!(!program.side_set.optional() && !program.side_set.pindirs());
        Self {
            code: program.code.to_vec(),
            wrap: (program.wrap.target.into(), program.wrap.source.into()),
            at: 0,
            x: 0,
            shifted: 0,
            count: 0,
            pins: 0,
        }
    }

    /// One instruction; `sd` is what the wire holds when it begins. The pins change at once, what
    /// is read has been there before.
    fn step(&mut self, sd: bool) -> Step {
        let word = self.code[self.at];
        // Two bits of side-set leave three of delay.
        self.pins = word >> 11 & 0b11;
        assert_eq!(word >> 8 & 0b111, 0, "no delays here");
        let argument = u32::from(word & 0x1F);
        let mut next = if self.at == self.wrap.1 {
            self.wrap.0
        } else {
            self.at + 1
        };
        let mut pushed = None;
        match (word >> 13, word >> 5 & 0b111) {
            // JMP X--: taken while X is not 0 yet.
            (0b000, 0b010) => {
                if self.x != 0 {
                    next = argument as usize;
                }
                self.x = self.x.wrapping_sub(1);
            }
            // IN PINS.
            (0b010, 0b000) => {
                assert_eq!(argument, 1, "one pin");
                self.shifted = self.shifted << 1 | u32::from(sd);
                self.count += 1;
                if self.count == SAMPLE_BITS {
                    pushed = Some(self.shifted);
                    (self.shifted, self.count) = (0, 0);
                }
            }
            // MOV Y, Y: nothing.
            (0b101, 0b010) => assert_eq!(word & 0x1F, 0b010),
            // SET X.
            (0b111, 0b001) => self.x = argument,
            other => panic!("{other:?} of {word:#06x} is not in this model"),
        }
        self.at = next;
        Step {
            sck: self.pins & 1 == 1,
            ws: self.pins & 2 == 2,
            pushed,
        }
    }
}

/// The microphone: it looks at WS where SCK rises; the first bit of a word is put out where SCK falls
/// next but one after WS has changed, one bit late. What nobody drives is `loose`.
struct Microphone {
    is_left: bool,
    sck: bool,
    seen_ws: bool,
    bit: u32,
    word: u32,
    sd: Option<bool>,
    loose: bool,
}

impl Microphone {
    fn new(is_left: bool) -> Self {
        Self {
            is_left,
            sck: false,
            seen_ws: true,
            bit: u32::MAX,
            word: 0,
            sd: None,
            loose: false,
        }
    }

    /// The wire.
    fn wire(&mut self) -> bool {
        self.loose = !self.loose;
        self.sd.unwrap_or(self.loose)
    }

    fn clock(&mut self, sck: bool, ws: bool, sound: &mut impl FnMut() -> u32) {
        let (fell, rose) = (self.sck && !sck, !self.sck && sck);
        self.sck = sck;
        if rose && ws != self.seen_ws {
            self.seen_ws = ws;
            // Low is left.
            if ws != self.is_left {
                self.word = sound();
                self.bit = 0;
            }
        } else if fell {
            self.sd = (self.bit < SAMPLE_BITS)
                .then(|| self.word >> (SAMPLE_BITS - 1 - self.bit.min(SAMPLE_BITS - 1)) & 1 == 1);
            self.bit = self.bit.saturating_add(1);
        }
    }
}

/// What is pushed in so many frames of a microphone that says `sounds` round and round.
fn heard(is_left: bool, sounds: &[u32], frames: u32) -> Vec<u32> {
    let (mut machine, mut microphone) = (Machine::new(), Microphone::new(is_left));
    let mut sounds = sounds.iter().copied().cycle();
    let mut pushed = Vec::new();
    for _ in 0..frames * BITS_PER_FRAME * STEPS_PER_BIT {
        let sd = microphone.wire();
        let step = machine.step(sd);
        pushed.extend(step.pushed);
        microphone.clock(step.sck, step.ws, &mut || sounds.next().expect("endless"));
    }
    pushed
}

#[test]
fn every_bit_of_the_left_channel_arrives_in_its_place() {
    let ones: Vec<u32> = (0..24).map(|bit| 1 << bit).collect();
    assert_eq!(heard(true, &ones, 24), ones);
    let mixed = [0x80_0000, 0x7F_FFFF, 0, 0xFF_FFFF, 0x55_AA33, 0xAA_55CC];
    assert_eq!(heard(true, &mixed, 6), mixed);
}

#[test]
fn a_microphone_wired_to_the_right_channel_is_not_heard() {
    let pushed = heard(false, &[0x55_AA33], 6);
    assert_eq!(pushed.len(), 6);
    // What nobody drives is neither of its bits nor silence.
    assert!(pushed.iter().all(|word| *word != 0x55_AA33), "{pushed:x?}");
}

#[test]
fn a_frame_is_64_even_bits_and_ws_changes_where_sck_falls() {
    let mut machine = Machine::new();
    let steps: Vec<Step> = (0..256).map(|_| machine.step(false)).collect();
    for (k, step) in steps.iter().enumerate() {
        assert_eq!(step.sck, k % 2 == 1, "{k}");
        assert_eq!(step.ws, k % 128 >= 64, "{k}");
    }
    let pushes = steps.iter().filter(|step| step.pushed.is_some());
    assert_eq!(pushes.count(), 2);
}

#[test]
fn the_clock_is_within_the_microphones_limits_and_exact() {
    // Data sheet, table 3: SCK 0.5 to 3.2 MHz, period of 312 ns at least, 50 ns high and low; WS 7.8 to 50 kHz, still
    // for 20 ns after SCK has risen: it changes where SCK falls.
    let tick_ns = 1e9 / f64::from(TICK_HZ);
    let (mut phase, mut ticks, mut shortest) = (0u32, 0u32, u32::MAX);
    for _ in 0..BITS_PER_FRAME {
        let mut bit = 0;
        for _ in 0..STEPS_PER_BIT {
            phase += DIVIDER_256 % 256;
            let step = DIVIDER_256 / 256 + phase / 256;
            phase %= 256;
            assert!(f64::from(step) * tick_ns >= 50.0);
            bit += step;
        }
        shortest = shortest.min(bit);
        ticks += bit;
    }
    assert!(f64::from(shortest) * tick_ns >= 312.0, "{shortest}");
    assert_eq!((ticks, phase), (3125, 0), "every frame is like the first");
    assert_eq!(f64::from(TICK_HZ) / f64::from(ticks), 48_000.0);
    assert!((85_300..85_400).contains(&START_UP_US), "{START_UP_US}");
}

#[test]
fn words_are_signed_and_of_full_scale_one() {
    let of = [
        (0, 0.0),
        (1, 1.192_092_9e-7),
        (0x7F_FFFF, 0.999_999_9),
        (0x80_0000, -1.0),
        (0xFF_FFFF, -1.192_092_9e-7),
        (0xC0_0000, -0.5),
        (0x40_0000, 0.5),
        // What is above the 24 bits is none of the sample's.
        (0xFF40_0000, 0.5),
    ];
    for (word, expected) in of {
        assert_eq!(sample(word), expected, "{word:#x}");
    }
}

#[test]
fn the_clock_counts_samples_for_ever() {
    for (us, samples) in [(0, 0), (20, 0), (21, 1), (125, 6), (1_000_000, 48_000)] {
        assert_eq!(expected(us), samples, "{us}");
    }
    let century = 100 * 365 * 86_400;
    assert_eq!(expected(century * 1_000_000 + 1_000), century * 48_000 + 48);
    assert!(expected(u64::MAX) > u64::MAX / 21);
}
