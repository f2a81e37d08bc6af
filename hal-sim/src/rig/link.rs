//! A byte link that drops, doubles, changes and blocks.

use firmware::board::Origin;
use rand::Rng;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::collections::VecDeque;

/// How bad the link is, as probabilities per byte.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Noise {
    /// Dropped.
    pub drop: f64,
    /// Doubled.
    pub double: f64,
    /// One bit changed.
    pub change: f64,
}

impl Noise {
    /// No byte is touched.
    pub fn is_none(&self) -> bool {
        self.drop <= 0.0 && self.double <= 0.0 && self.change <= 0.0
    }
}

/// Both directions of a link.
#[derive(Debug)]
pub struct RigLink {
    rng: ChaCha8Rng,
    to_box: VecDeque<u8>,
    to_host: Vec<u8>,
    /// What happens to bytes, both ways.
    pub noise: Noise,
    /// In its place for a while.
    pub burst: Option<Noise>,
    /// Probability that a whole frame to the host is lost.
    pub frame_loss: f64,
    /// Where the host is.
    pub origin: Origin,
    /// Bytes waiting for the host before the box's frames are refused.
    pub room: usize,
    /// Frames handed over by the box, and of them lost whole.
    pub frames: u64,
    /// See [`Self::frames`].
    pub frames_lost: u64,
}

impl RigLink {
    /// A good link.
    pub fn new(seed: u64) -> Self {
        Self {
            rng: ChaCha8Rng::seed_from_u64(seed),
            to_box: VecDeque::new(),
            to_host: Vec::new(),
            noise: Noise::default(),
            burst: None,
            frame_loss: 0.0,
            origin: Origin::OwnPort,
            room: 1 << 16,
            frames: 0,
            frames_lost: 0,
        }
    }

    /// The host sends bytes.
    pub fn host_sends(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            let (count, byte) = self.spoil(byte);
            for _ in 0..count {
                self.to_box.push_back(byte);
            }
        }
    }

    /// The host takes what there is.
    pub fn host_takes(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.to_host)
    }

    /// What the host has not taken yet.
    pub(super) fn waiting_for_host(&self) -> &[u8] {
        &self.to_host
    }

    /// Bytes the box has not taken yet.
    pub fn waiting(&self) -> usize {
        self.to_box.len()
    }

    /// Nothing is on its way any more: a reset, a cut.
    pub fn clear(&mut self) {
        self.to_box.clear();
    }

    pub(super) fn box_takes(&mut self, bytes: &mut [u8]) -> usize {
        let mut taken = 0;
        for place in bytes {
            let Some(byte) = self.to_box.pop_front() else {
                break;
            };
            *place = byte;
            taken += 1;
        }
        taken
    }

    pub(super) fn box_sends(&mut self, frame: &[u8], blocked: bool) -> bool {
        if blocked || self.to_host.len() + frame.len() > self.room {
            return false;
        }
        self.frames += 1;
        if self.frame_loss > 0.0 && self.rng.random::<f64>() < self.frame_loss {
            self.frames_lost += 1;
            return true;
        }
        for &byte in frame {
            let (count, byte) = self.spoil(byte);
            self.to_host.extend(std::iter::repeat_n(byte, count));
        }
        true
    }

    fn spoil(&mut self, byte: u8) -> (usize, u8) {
        let noise = self.burst.unwrap_or(self.noise);
        if noise.is_none() {
            return (1, byte);
        }
        let x: f64 = self.rng.random();
        let Noise {
            drop,
            double,
            change,
        } = noise;
        if x < drop {
            (0, byte)
        } else if x < drop + double {
            (2, byte)
        } else if x < drop + double + change {
            (1, byte ^ (1 << self.rng.random_range(0..8)))
        } else {
            (1, byte)
        }
    }

    pub(super) fn garbage(&mut self, bytes: usize) {
        for _ in 0..bytes {
            let byte = self.rng.random();
            self.to_box.push_back(byte);
        }
    }
}
