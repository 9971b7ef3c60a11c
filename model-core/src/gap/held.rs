//! What a model holds over a step next to the motor: laws of its effects, and a learned map.

use super::model::MOST_EFFECTS;
use crate::effect::learned_map::LearnedMap;
use crate::effect::thermal_drift::ThermalDrift;
use crate::effect::{Law, Middle};
use crate::plant::actuator::Load;
use crate::plant::parameters::ParameterError;
use heapless::Vec;

/// What acts over a step.
pub trait Acting {
    /// Whether nothing does.
    fn is_nothing(&self) -> bool;

    /// Whether something adds to the winding's voltage.
    fn is_electric(&self) -> bool;

    /// Adds it to what is held over a step.
    fn hold(&self, middle: &Middle, load: &mut Load);

    /// How it heats the winding, if it does.
    fn heating(&self) -> Option<ThermalDrift>;

    /// The voltage that it adds to the input's over a step.
    fn voltage(&self, middle: &Middle) -> f32;

    /// Its laws, in the order in which they act.
    fn laws(&self) -> impl Iterator<Item = &Law>;

    /// The map behind them.
    fn map(&self) -> Option<LearnedMap>;
}

/// Laws, and a map behind them.
#[derive(Debug, Clone, PartialEq)]
pub struct Held {
    laws: Vec<Law, MOST_EFFECTS>,
    map: Option<LearnedMap>,
}

impl Held {
    /// Takes laws in the order in which they are to act.
    ///
    /// # Errors
    /// More laws than there is room for.
    pub(super) fn new(
        laws: impl Iterator<Item = Law>,
        map: Option<LearnedMap>,
    ) -> Result<Self, ParameterError> {
        let mut held = Self {
            laws: Vec::new(),
            map,
        };
        for law in laws {
            held.laws.push(law).map_err(|_| ParameterError {
                parameter: "effects",
                requirement: "at most 8 in one model",
            })?;
        }
        Ok(held)
    }
}

impl Acting for Held {
    #[inline]
    fn is_nothing(&self) -> bool {
        self.laws.is_empty() && self.map.is_none()
    }

    #[inline]
    fn hold(&self, middle: &Middle, load: &mut Load) {
        for law in &self.laws {
            law.hold(middle, load);
        }
        if let Some(map) = &self.map {
            map.hold(middle, load);
        }
    }

    fn is_electric(&self) -> bool {
        self.laws.iter().any(Law::is_electric)
    }

    fn heating(&self) -> Option<ThermalDrift> {
        self.laws.iter().find_map(heating_of)
    }

    fn voltage(&self, middle: &Middle) -> f32 {
        voltage_of(self.laws.iter(), middle)
    }

    fn laws(&self) -> impl Iterator<Item = &Law> {
        self.laws.iter()
    }

    fn map(&self) -> Option<LearnedMap> {
        self.map
    }
}

fn heating_of(law: &Law) -> Option<ThermalDrift> {
    match law {
        Law::ThermalDrift(heating) => Some(*heating),
        _ => None,
    }
}

/// The voltage that laws add to the input's, each to what those before it have left.
fn voltage_of<'l>(laws: impl Iterator<Item = &'l Law>, middle: &Middle) -> f32 {
    let mut left = *middle;
    let mut sum = 0.0;
    for law in laws {
        let voltage = law.voltage(&left);
        left.excess += voltage;
        sum += voltage;
    }
    sum
}

/// What another model holds, but for one law or one knot of the map.
#[derive(Debug, Clone)]
pub struct Varied<'m> {
    common: &'m Held,
    /// Where the laws differ.
    place: u8,
    /// Whether the law there is left out.
    without: bool,
    /// The law that stands there.
    own: Option<Law>,
    /// The knot that differs, and its value.
    knot: Option<(u8, f32)>,
}

impl<'m> Varied<'m> {
    /// `own` told by what it has in common with another.
    ///
    /// # Errors
    /// If they differ in more than one law or knot.
    pub(super) fn new(common: &'m Held, own: &Held) -> Result<Self, ParameterError> {
        let equal = common.laws.iter().zip(&own.laws);
        let place = equal.take_while(|(common, own)| common == own).count();
        let (theirs, ours) = (&common.laws[place..], &own.laws[place..]);
        let without = !theirs.is_empty() && theirs.len() >= ours.len();
        let with = !ours.is_empty() && ours.len() >= theirs.len();
        let varied = Self {
            common,
            place: place as u8,
            without,
            own: ours.first().copied().filter(|_| with),
            knot: different_knot(common.map.as_ref(), own.map.as_ref()),
        };
        if theirs[usize::from(without)..] == ours[usize::from(with)..] && varied.map() == own.map {
            Ok(varied)
        } else {
            Err(ParameterError {
                parameter: "effects",
                requirement: "the same in all copies of a model but for one value",
            })
        }
    }
}

/// The first knot in which two maps differ, with its value in the second.
fn different_knot(first: Option<&LearnedMap>, second: Option<&LearnedMap>) -> Option<(u8, f32)> {
    let mut pairs = first?.knots.iter().zip(second?.knots).enumerate();
    pairs.find_map(|(index, (first, second))| (*first != second).then_some((index as u8, second)))
}

impl Acting for Varied<'_> {
    #[inline]
    fn is_nothing(&self) -> bool {
        self.own.is_none()
            && self.common.laws.len() == usize::from(self.without)
            && self.common.map.is_none()
    }

    #[inline]
    fn hold(&self, middle: &Middle, load: &mut Load) {
        let (before, behind) = self.common.laws.split_at(usize::from(self.place));
        for law in before {
            law.hold(middle, load);
        }
        if let Some(law) = &self.own {
            law.hold(middle, load);
        }
        for law in &behind[usize::from(self.without)..] {
            law.hold(middle, load);
        }
        match (&self.common.map, self.knot) {
            (Some(map), None) => map.hold(middle, load),
            (Some(_), Some(_)) => {
                if let Some(map) = self.map() {
                    map.hold(middle, load);
                }
            }
            (None, _) => {}
        }
    }

    fn is_electric(&self) -> bool {
        self.laws().any(Law::is_electric)
    }

    fn heating(&self) -> Option<ThermalDrift> {
        self.laws().find_map(heating_of)
    }

    fn voltage(&self, middle: &Middle) -> f32 {
        voltage_of(self.laws(), middle)
    }

    fn laws(&self) -> impl Iterator<Item = &Law> {
        let (before, behind) = self.common.laws.split_at(usize::from(self.place));
        let behind = &behind[usize::from(self.without)..];
        before.iter().chain(&self.own).chain(behind)
    }

    fn map(&self) -> Option<LearnedMap> {
        let mut map = self.common.map?;
        if let Some((index, value)) = self.knot {
            map.knots[usize::from(index)] = value;
        }
        Some(map)
    }
}
