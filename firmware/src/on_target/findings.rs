//! What a check found.

/// Offset basis and prime of the 64-bit hash of Fowler, Noll and Vo (FNV-1a), fed word by word.
const BASIS: u64 = 0xcbf2_9ce4_8422_2325;
const PRIME: u64 = 0x0000_0100_0000_01b3;

/// The digest of a check's results, and the first of its claims that does not hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Findings {
    digest: u64,
    broken: Option<&'static str>,
}

impl Findings {
    pub(super) const fn new() -> Self {
        Self {
            digest: BASIS,
            broken: None,
        }
    }

    /// Stands for the bits of every result in its order.
    pub fn digest(&self) -> u64 {
        self.digest
    }

    /// The first claim that does not hold.
    pub fn broken(&self) -> Option<&'static str> {
        self.broken
    }

    pub(super) fn word(&mut self, word: u32) {
        self.digest = (self.digest ^ u64::from(word)).wrapping_mul(PRIME);
    }

    pub(super) fn single(&mut self, value: f32) {
        self.word(value.to_bits());
    }

    pub(super) fn double(&mut self, value: f64) {
        let bits = value.to_bits();
        self.word((bits >> 32) as u32);
        self.word(bits as u32);
    }

    pub(super) fn claim(&mut self, holds: bool, claim: &'static str) {
        if !holds && self.broken.is_none() {
            self.broken = Some(claim);
        }
    }

    /// Claims that something can be built or done, and gives it.
    pub(super) fn sound<T, E>(&mut self, result: Result<T, E>, claim: &'static str) -> Option<T> {
        self.claim(result.is_ok(), claim);
        result.ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_bit_makes_another_digest_and_so_does_the_order() {
        let digest = |values: [f32; 2]| {
            let mut findings = Findings::new();
            values.iter().for_each(|&value| findings.single(value));
            findings.digest()
        };
        assert_eq!(digest([1.0, 2.0]), digest([1.0, 2.0]));
        assert_ne!(digest([1.0, 2.0]), digest([1.0, 2.000_000_2]));
        assert_ne!(digest([1.0, 2.0]), digest([2.0, 1.0]));
        assert_ne!(digest([0.0, 0.0]), digest([0.0, -0.0]));
    }

    #[test]
    fn the_first_broken_claim_is_kept() {
        let mut findings = Findings::new();
        findings.claim(true, "a");
        assert_eq!(findings.broken(), None);
        findings.claim(false, "b");
        findings.claim(false, "c");
        assert_eq!(findings.broken(), Some("b"));
        assert_eq!(findings.sound(Err::<(), _>(()), "d"), None);
    }
}
