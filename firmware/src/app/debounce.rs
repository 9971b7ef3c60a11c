//! How often in a row something was bad.

/// Counts steps in which something was bad, one after the other.
///
/// ```
/// use firmware::app::debounce::Debounce;
///
/// let mut debounce = Debounce::default();
/// let seen = [true, true, false, true, true, true, true];
/// let said = seen.map(|bad| debounce.after(3, bad));
/// assert_eq!(said, [false, false, false, false, false, true, true]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Debounce(u32);

impl Debounce {
    /// Takes a step. True from the one on in which it has been bad `steps` times in a row.
    pub fn after(&mut self, steps: u32, bad: bool) -> bool {
        self.0 = if bad { self.0.saturating_add(1) } else { 0 };
        bad && self.0 >= steps
    }
}
