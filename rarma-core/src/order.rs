//! The model orders the box offers.

/// ARMA order (p, q): p/2 modes, with q = p − 1 for vibration sampled without
/// noise and q = p where the sensor adds white noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Order {
    /// (2,1)
    O21,
    /// (2,2)
    O22,
    /// (4,3)
    O43,
    /// (4,4)
    O44,
    /// (6,5)
    O65,
    /// (6,6)
    O66,
    /// (8,7)
    O87,
    /// (8,8)
    O88,
}

impl Order {
    /// Every order, small ones first.
    pub const ALL: [Self; 8] = [
        Self::O21,
        Self::O22,
        Self::O43,
        Self::O44,
        Self::O65,
        Self::O66,
        Self::O87,
        Self::O88,
    ];

    /// The order with these p and q, if the box has it.
    pub fn new(p: usize, q: usize) -> Option<Self> {
        Self::ALL.into_iter().find(|o| o.p() == p && o.q() == q)
    }

    /// Order of A.
    pub fn p(self) -> usize {
        match self {
            Self::O21 | Self::O22 => 2,
            Self::O43 | Self::O44 => 4,
            Self::O65 | Self::O66 => 6,
            Self::O87 | Self::O88 => 8,
        }
    }

    /// Order of C.
    pub fn q(self) -> usize {
        match self {
            Self::O22 | Self::O44 | Self::O66 | Self::O88 => self.p(),
            Self::O21 | Self::O43 | Self::O65 | Self::O87 => self.p() - 1,
        }
    }
}
