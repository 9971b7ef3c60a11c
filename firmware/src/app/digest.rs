//! A number that stands for many: equal digests are equal bits in equal order.

/// Offset basis and prime of the 64-bit hash of Fowler, Noll and Vo (FNV-1a), fed word by word.
const BASIS: u64 = 0xcbf2_9ce4_8422_2325;
const PRIME: u64 = 0x0000_0100_0000_01b3;

/// The digest of the words so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Digest(u64);

impl Digest {
    /// Of nothing.
    pub const fn new() -> Self {
        Self(BASIS)
    }

    /// Takes a word.
    pub fn word(&mut self, word: u32) {
        self.0 = (self.0 ^ u64::from(word)).wrapping_mul(PRIME);
    }

    /// Takes the bits of a number.
    pub fn single(&mut self, value: f32) {
        self.word(value.to_bits());
    }

    /// The number.
    pub const fn value(&self) -> u64 {
        self.0
    }
}

impl Default for Digest {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_bit_makes_another_digest_and_so_does_the_order() {
        let digest = |values: [f32; 2]| {
            let mut digest = Digest::new();
            values.iter().for_each(|&value| digest.single(value));
            digest.value()
        };
        assert_eq!(digest([1.0, 2.0]), digest([1.0, 2.0]));
        assert_ne!(digest([1.0, 2.0]), digest([1.0, 2.000_000_2]));
        assert_ne!(digest([1.0, 2.0]), digest([2.0, 1.0]));
        assert_ne!(digest([0.0, 0.0]), digest([0.0, -0.0]));
    }
}
