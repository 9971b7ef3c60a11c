//! Numbers at random, the same ones each time.

/// A shift register of 32 bits: G. Marsaglia's xorshift. It begins with any number but 0.
#[derive(Debug, Clone, Copy)]
pub struct Random(pub u32);

impl Random {
    /// The next 32 bits, never all 0.
    pub fn bits(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }

    /// Any number below this one.
    pub fn below(&mut self, bound: u64) -> u64 {
        u64::from(self.bits()) % bound
    }

    /// Any hundredth from one to another.
    pub fn between(&mut self, least: f64, most: f64) -> f64 {
        let hundredths = ((most - least) * 100.0) as u64;
        least + self.below(hundredths + 1) as f64 / 100.0
    }
}
