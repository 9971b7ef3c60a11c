//! What a check found.

use crate::app::digest::Digest;

/// The digest of a check's results, and the first of its claims that does not hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Findings {
    digest: Digest,
    broken: Option<&'static str>,
}

impl Findings {
    pub(super) const fn new() -> Self {
        Self {
            digest: Digest::new(),
            broken: None,
        }
    }

    /// Stands for the bits of every result in its order.
    pub fn digest(&self) -> u64 {
        self.digest.value()
    }

    /// The first claim that does not hold.
    pub fn broken(&self) -> Option<&'static str> {
        self.broken
    }

    pub(super) fn word(&mut self, word: u32) {
        self.digest.word(word);
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
