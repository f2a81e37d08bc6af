//! Normal noise from a seed.

/// xorshift64* and Box and Muller.
pub struct Noise {
    state: u64,
    kept: Option<f64>,
}

impl Noise {
    pub fn new(seed: u64) -> Self {
        let state = 0x9E37_79B9_7F4A_7C15 ^ (seed + 1).wrapping_mul(0xD134_2543_DE82_EF95);
        let mut this = Self { state, kept: None };
        for _ in 0..20 {
            this.uniform();
        }
        this
    }

    fn uniform(&mut self) -> f64 {
        self.state ^= self.state >> 12;
        self.state ^= self.state << 25;
        self.state ^= self.state >> 27;
        (self.state.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn normal(&mut self) -> f64 {
        if let Some(x) = self.kept.take() {
            return x;
        }
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        let angle = std::f64::consts::TAU * self.uniform();
        self.kept = Some(radius * angle.sin());
        radius * angle.cos()
    }
}
