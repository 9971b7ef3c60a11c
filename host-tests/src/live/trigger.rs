//! What freezes the picture.

use firmware::app::operation::live::Live;

/// What freezes the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Trigger {
    /// Nothing but the button.
    Off,
    /// A fault that is latched.
    Fault,
    /// The position crosses a level upward, rad.
    Above(f32),
    /// The position crosses a level downward, rad.
    Below(f32),
}

impl Trigger {
    /// From `off`, `fault`, `above 0.3` or `below 0.3`.
    pub fn read(text: &str) -> Option<Self> {
        let level = |text: &str| text.parse().ok().filter(|level: &f32| level.is_finite());
        match text.split_once(' ') {
            None if text == "off" => Some(Self::Off),
            None if text == "fault" => Some(Self::Fault),
            Some(("above", rest)) => level(rest).map(Self::Above),
            Some(("below", rest)) => level(rest).map(Self::Below),
            _ => None,
        }
    }

    /// Whether it comes between two lines.
    pub fn comes(self, before: &Live, now: &Live) -> bool {
        match self {
            Self::Off => false,
            Self::Fault => before.latched.is_empty() && !now.latched.is_empty(),
            Self::Above(level) => before.position < level && now.position >= level,
            Self::Below(level) => before.position > level && now.position <= level,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trigger_comes_where_its_condition_begins() {
        let at = |position| Live {
            position,
            ..Live::default()
        };
        let above = Trigger::read("above 0.3").unwrap();
        assert!(above.comes(&at(0.2), &at(0.3)));
        assert!(!above.comes(&at(0.3), &at(0.4)));
        let below = Trigger::read("below -0.1").unwrap();
        assert!(below.comes(&at(0.0), &at(-0.2)));
        assert!(!below.comes(&at(-0.2), &at(-0.3)));
        for refused in ["", "above", "above x", "above NaN", "sideways 1"] {
            assert_eq!(Trigger::read(refused), None, "{refused}");
        }
    }
}
