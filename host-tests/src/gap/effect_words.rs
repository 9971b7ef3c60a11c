//! What each effect of the catalogue means to whoever stands beside the machine: one sentence each, its size
//! in the units of a workshop, with its 95 % interval.
//!
//! A size that the effect's own number does not have, such as the ohms of a supply that loses a share of its
//! voltage for each watt, is that at what the logs ask of the machine at most ([`Demand`]); the sentence says
//! at what.

use std::f64::consts::{PI, TAU};

use model_core::effect::Id;

use super::demand::Demand;
use super::outcome::{Estimate, FoundEffect, Report};
use crate::quantity::{Scale, significant};

/// Significant digits of a size.
const DIGITS: usize = 3;

/// Standard deviations on either side of a value that a 95 % interval of a normal distribution has.
pub(super) const DEVIATIONS: f64 = 1.96;

/// Share by which the resistance of copper rises with each kelvin.
const COPPER_PER_KELVIN: f64 = 0.0039;

/// What the sizes of effects are said in and at.
#[derive(Debug, Clone, Copy)]
pub struct Workshop<'a> {
    /// What the training logs ask of the machine.
    pub demand: &'a Demand,
    /// Whether positions are angles: degrees and rpm, else mm and mm/s.
    pub rotary: bool,
    /// `N·m` or `N`.
    pub load_unit: &'a str,
}

impl<'a> Workshop<'a> {
    /// That of a report.
    pub fn of(report: &'a Report) -> Self {
        Self {
            demand: &report.demand,
            rotary: report.coordinate == "rad",
            load_unit: &report.load_unit,
        }
    }
}

/// A number with its 95 % interval; the interval has no numbers where the logs do not determine it.
#[derive(Debug, Clone, Copy)]
struct Span {
    value: f64,
    low: f64,
    high: f64,
}

impl Span {
    fn new(value: f64, std: f64) -> Self {
        Self {
            value,
            low: value - DEVIATIONS * std,
            high: value + DEVIATIONS * std,
        }
    }

    /// The same of a quantity that rises or falls with this one throughout.
    fn map(self, of: impl Fn(f64) -> f64) -> Self {
        let (a, b) = (of(self.low), of(self.high));
        // Not `min` and `max`, which would hide an end that is no number.
        let (low, high) = if a <= b { (a, b) } else { (b, a) };
        Self {
            value: of(self.value),
            low,
            high,
        }
    }

    /// Multiplied by a number.
    fn times(self, factor: f64) -> Self {
        self.map(|value| factor * value)
    }

    /// Its magnitude; an interval that reaches beyond zero shows that it does.
    fn magnitude(self) -> Self {
        if self.value < 0.0 {
            self.times(-1.0)
        } else {
            self
        }
    }

    /// `2.86° (95 %: 2.80 to 2.92)`
    fn in_words(self, unit: &str) -> String {
        let value = with_unit(self.value, unit);
        if self.low.is_finite() && self.high.is_finite() {
            let ends = |digits| [self.low, self.high].map(|end| significant(end, digits));
            // As many as tell the ends apart; more than five are the log's rounding.
            let digits = (DIGITS..5).find(|digits| ends(*digits)[0] != ends(*digits)[1]);
            let [low, high] = ends(digits.unwrap_or(5));
            format!("{value} (95 %: {low} to {high})")
        } else {
            format!("{value} (the logs do not determine how much)")
        }
    }
}

/// `12.3 V`, `12.3°`
fn with_unit(value: f64, unit: &str) -> String {
    let space = if unit == "°" { "" } else { " " };
    format!("{}{space}{unit}", significant(value, DIGITS))
}

/// One effect in the words of one workshop.
struct Words<'a> {
    effect: &'a FoundEffect,
    workshop: &'a Workshop<'a>,
}

/// What a found effect is and how large, in one sentence.
pub fn sentence(effect: &FoundEffect, workshop: &Workshop) -> String {
    let words = Words { effect, workshop };
    match Id::from_id(&effect.id) {
        Some(id) => words.sentence(id),
        None => effect.id.clone(),
    }
}

/// What those numbers mean that an effect is declared by, where they are others than it is reported in.
pub fn declared_by(id: Id) -> Option<&'static str> {
    let periodic = "it is `sine` · sin(2π position/`period`) + `cosine` · cos(2π position/`period`), and the same of each \
                    harmonic with its own numbers";
    Some(match id {
        Id::AsymmetricCoulomb => {
            "`difference` is half of what dry friction is more forward than backward: it is `coulomb` + `difference` forward \
             and `coulomb` - `difference` backward"
        }
        Id::AsymmetricViscous => {
            "`difference` is half of what viscous friction is more forward than backward: it is `viscous` + `difference` \
             forward and `viscous` - `difference` backward"
        }
        Id::Spring => "the spring pulls with `torque` - `stiffness` · position",
        Id::Gravity => "the load pulls with -`sine` · sin(position) - `cosine` · cos(position)",
        Id::Cogging | Id::PositionDependentFriction | Id::EncoderEccentricity => periodic,
        Id::ExternalLoad => "it acts for `duration`, until `end`",
        _ => return None,
    })
}

impl Words<'_> {
    fn sentence(&self, id: Id) -> String {
        match id {
            Id::OffsetTorque => self.offset_torque(),
            Id::AsymmetricCoulomb => self.asymmetric_coulomb(),
            Id::AsymmetricViscous => self.asymmetric_viscous(),
            Id::QuadraticDrag => self.quadratic_drag(),
            Id::Stribeck => self.stribeck(),
            Id::LoadDependentFriction => self.load_dependent_friction(),
            Id::PositionDependentFriction => self.position_dependent_friction(),
            Id::FrictionDrift => self.friction_drift(),
            Id::Presliding => self.presliding(),
            Id::Spring => self.spring(),
            Id::Gravity => self.gravity(),
            Id::Cogging => self.cogging(),
            Id::ExternalLoad => self.external_load(),
            Id::TorqueSaturation => self.torque_saturation(),
            Id::SupplySag => self.supply_sag(),
            Id::BrushDrop => self.brush_drop(),
            Id::DeadTime => self.dead_time(),
            Id::ThermalDrift => self.thermal_drift(),
            Id::InputDelay => self.input_delay(),
            Id::SensorDelay => self.sensor_delay(),
            Id::Backlash => self.backlash(),
            Id::Compliance => self.compliance(),
            Id::EncoderEccentricity => self.encoder_eccentricity(),
            Id::Hysteresis => self.hysteresis(),
        }
    }

    fn parameter(&self, name: &str) -> Option<&Estimate> {
        let mut parameters = self.effect.parameters.iter();
        parameters.find(|parameter| parameter.name == name)
    }

    fn span(&self, name: &str) -> Span {
        let parameter = self.parameter(name);
        parameter.map_or(Span::new(f64::NAN, f64::NAN), |it| {
            Span::new(it.value, it.std)
        })
    }

    fn value(&self, name: &str) -> f64 {
        self.span(name).value
    }

    /// `torque` or `force`.
    fn load(&self) -> &'static str {
        if self.workshop.rotary {
            "torque"
        } else {
            "force"
        }
    }

    /// A torque or force with its interval, in the prefix that suits it.
    fn torque(&self, span: Span) -> String {
        let scale = Scale::of(self.workshop.load_unit, [span.value]);
        span.times(scale.factor).in_words(&scale.unit)
    }

    /// A torque or force alone.
    fn plain_torque(&self, value: f64) -> String {
        Scale::of(self.workshop.load_unit, [value]).quantity(value)
    }

    /// Factor and unit of angles and lengths.
    fn place_scale(&self) -> (f64, &'static str) {
        if self.workshop.rotary {
            (180.0 / PI, "°")
        } else {
            (1e3, "mm")
        }
    }

    fn place(&self, span: Span) -> String {
        let (factor, unit) = self.place_scale();
        span.times(factor).in_words(unit)
    }

    fn plain_place(&self, value: f64) -> String {
        let (factor, unit) = self.place_scale();
        with_unit(factor * value, unit)
    }

    /// A place that has no interval: with the digits that its deviation supports.
    fn known_place(&self, span: Span) -> String {
        let (factor, unit) = self.place_scale();
        let (value, std) = (
            factor * span.value,
            factor * (span.high - span.value) / DEVIATIONS,
        );
        if !(value.is_finite() && std.is_finite() && std > 0.0) {
            return with_unit(value, unit);
        }
        let power = std.log10().floor();
        let step = 10f64.powf(power);
        let rounded = (value / step).round() * step;
        if rounded != 0.0 && rounded.abs() >= 10f64.powi(DIGITS as i32) * step {
            return with_unit(value, unit);
        }
        let decimals = (-power).max(0.0) as usize;
        // No sign before a zero.
        let space = if unit == "°" { "" } else { " " };
        format!("{:.decimals$}{space}{unit}", rounded + 0.0)
    }

    fn speed(&self, value: f64) -> String {
        if self.workshop.rotary {
            with_unit(value * 60.0 / TAU, "rpm")
        } else {
            with_unit(1e3 * value, "mm/s")
        }
    }

    /// How often a period comes: `8.00 times a turn`, or `every 12.0 mm`.
    fn recurrence(&self, period: f64) -> String {
        if self.workshop.rotary {
            format!("{} times a turn", significant(TAU / period, 3))
        } else {
            format!("every {}", self.plain_place(period))
        }
    }

    /// The largest speed of the logs, or one unit where they have none.
    fn largest_speed(&self) -> f64 {
        or_one(self.workshop.demand.speed)
    }

    fn offset_torque(&self) -> String {
        let torque = self.span("torque");
        format!(
            "A constant {} of {} pushes {}, at rest too.",
            self.load(),
            self.torque(torque.magnitude()),
            towards(torque.value)
        )
    }

    /// By how much more acts in one direction than in the other, and in which. The two levels share their mean,
    /// so that their deviations are at worst one on top of the other.
    fn difference(&self, factor: f64) -> (Span, &'static str) {
        let (forward, backward) = (self.parameter("forward"), self.parameter("backward"));
        let (value, std) = match (forward, backward) {
            (Some(forward), Some(backward)) => {
                (forward.value - backward.value, forward.std + backward.std)
            }
            _ => (f64::NAN, f64::NAN),
        };
        let direction = if value < 0.0 { "backward" } else { "forward" };
        (Span::new(value, std).times(factor).magnitude(), direction)
    }

    fn asymmetric_coulomb(&self) -> String {
        let (more, direction) = self.difference(1.0);
        format!(
            "Dry friction depends on the direction: {} forward and {} backward, so {} more {direction}.",
            self.plain_torque(self.value("forward")),
            self.plain_torque(self.value("backward")),
            self.torque(more),
        )
    }

    fn asymmetric_viscous(&self) -> String {
        let speed = self.largest_speed();
        let (more, direction) = self.difference(speed);
        format!(
            "Friction that grows with speed depends on the direction: at {} it is {} forward and {} \
             backward, so {} more {direction}.",
            self.speed(speed),
            self.plain_torque(speed * self.value("forward")),
            self.plain_torque(speed * self.value("backward")),
            self.torque(more),
        )
    }

    fn quadratic_drag(&self) -> String {
        let speed = self.largest_speed();
        format!(
            "Drag grows with the square of the speed, as of a fan or of oil: {} at {}.",
            self.torque(self.span("coefficient").times(speed * speed)),
            self.speed(speed)
        )
    }

    fn stribeck(&self) -> String {
        format!(
            "Friction is {} higher at a crawl than in fast motion, so that slow motion jerks; 63 % of that is \
             gone at {}.",
            self.torque(self.span("drop")),
            self.speed(self.value("velocity"))
        )
    }

    fn load_dependent_friction(&self) -> String {
        format!(
            "Friction takes {} of the motor's {}, as a gear or a screw does under load.",
            self.span("share").times(100.0).in_words("%"),
            self.load()
        )
    }

    fn position_dependent_friction(&self) -> String {
        let period = self.value("period");
        // sin(2πx/P + phase) is largest a quarter of a period, less the phase's share of one, from zero on.
        let tightest = self
            .span("phase")
            .map(|phase| period * (0.25 - phase / TAU));
        let turns = (tightest.value / period).floor() * period;
        let tightest = tightest.map(|place| place - turns);
        format!(
            "Friction varies along the stroke, by {} either way: it is tightest at {}, with a period of {}.",
            self.torque(self.span("amplitude")),
            self.known_place(tightest),
            self.plain_place(period)
        )
    }

    fn friction_drift(&self) -> String {
        let seconds = or_one(self.workshop.demand.duration_s);
        let rate = self.span("rate");
        let (verb, most) = if rate.value < 0.0 {
            // Friction that falls ends at nothing.
            ("falls", 100.0)
        } else {
            ("grows", f64::INFINITY)
        };
        let change = rate
            .magnitude()
            .map(|rate| (100.0 * seconds * rate).min(most));
        format!(
            "Friction {verb} by {} over the {} of a log.",
            change.in_words("%"),
            with_unit(seconds, "s")
        )
    }

    fn presliding(&self) -> String {
        let friction = or_one(self.workshop.demand.friction);
        format!(
            "Before it slides the machine gives like rubber, by {} under {} of friction.",
            self.place(self.span("compliance").times(friction)),
            self.plain_torque(friction)
        )
    }

    fn spring(&self) -> String {
        let (each, unit) = if self.workshop.rotary {
            (PI / 180.0, "degree")
        } else {
            (1e-3, "millimetre")
        };
        format!(
            "A spring pulls towards {}, with {} more for each {unit} away from there.",
            self.known_place(self.span("rest")),
            self.torque(self.span("stiffness").times(each))
        )
    }

    fn gravity(&self) -> String {
        format!(
            "A load hangs off the axis: it pulls with up to {}, and hangs at {}.",
            self.torque(self.span("torque")),
            self.known_place(self.span("rest"))
        )
    }

    fn cogging(&self) -> String {
        let period = self.value("period");
        let recurrence = if self.workshop.rotary {
            format!("{} cycles a turn", significant(TAU / period, 3))
        } else {
            self.recurrence(period)
        };
        format!(
            "The drive cogs, as motor slots or gear teeth do: {} either way, {recurrence}{}.",
            self.torque(self.span("amplitude")),
            self.overtones()
        )
    }

    /// What a cogging has besides the first harmonic.
    fn overtones(&self) -> String {
        let of = |name: &str| self.parameter(name).map(|it| it.value);
        match (of("second_harmonic"), of("third_harmonic")) {
            (Some(second), Some(third)) => format!(
                ", with {} at twice and {} at three times that",
                self.plain_torque(second),
                self.plain_torque(third)
            ),
            _ => String::new(),
        }
    }

    fn external_load(&self) -> String {
        let (torque, begin) = (self.span("torque"), self.value("begin"));
        format!(
            "From {} to {} into the log something pushes {} with {}.",
            with_unit(begin, "s"),
            with_unit(begin + self.value("duration"), "s"),
            towards(torque.value),
            self.torque(torque.magnitude())
        )
    }

    fn torque_saturation(&self) -> String {
        let fall = self.span("fall");
        let largest = self.workshop.demand.torque;
        if largest <= 0.0 {
            return format!(
                "The motor saturates: asked for {}, it gives half of it.",
                self.plain_torque(1.0 / fall.value)
            );
        }
        let lost = fall.map(|fall| 100.0 * fall * largest / (1.0 + fall * largest));
        format!(
            "The motor saturates: asked for the logs' largest {}, {}, it gives {} less.",
            self.load(),
            self.plain_torque(largest),
            lost.in_words("%")
        )
    }

    fn supply_sag(&self) -> String {
        let share = self.span("share");
        let volts = self.workshop.demand.voltage;
        if volts <= 0.0 {
            return format!(
                "The supply sags under load, by {} for each watt drawn.",
                share.times(100.0).in_words("%")
            );
        }
        // s = R/U² by the effect's law, with the supply's voltage U.
        let ohms = share.times(volts * volts);
        if self.workshop.demand.is_of_supply {
            return format!(
                "The supply sags under load, as one of {} with {} in series.",
                with_unit(volts, "V"),
                ohms.in_words("Ω"),
            );
        }
        format!(
            "The supply sags under load: asked for {most} V, the most in the logs, it gives {} less for each ampere, as with {} Ω \
             in series; a supply of U volts has (U/{most})² times that.",
            ohms.in_words("V"),
            significant(ohms.value, DIGITS),
            most = significant(volts, DIGITS),
        )
    }

    fn brush_drop(&self) -> String {
        format!(
            "The brushes take {} from the voltage, whichever way the current flows.",
            self.span("drop").in_words("V")
        )
    }

    fn dead_time(&self) -> String {
        format!(
            "The bridge loses {} to its dead time: with less than that the drive does nothing.",
            self.span("loss").in_words("V")
        )
    }

    fn thermal_drift(&self) -> String {
        let current = or_one(self.workshop.demand.current_rms);
        let rate = self.span("rate").times(100.0 * current * current);
        format!(
            "The winding heats: at {} its resistance rises at first by {} a second, as of copper that warms by \
             {} a second, with a time constant of {}.",
            with_unit(current, "A"),
            rate.in_words("%"),
            with_unit(rate.value / (100.0 * COPPER_PER_KELVIN), "K"),
            with_unit(self.value("time_constant"), "s")
        )
    }

    fn delay(&self) -> String {
        self.span("delay").times(1e3).in_words("ms")
    }

    fn input_delay(&self) -> String {
        format!(
            "The drive acts {} after it is told to{}.",
            self.delay(),
            self.or_inductance()
        )
    }

    fn sensor_delay(&self) -> String {
        format!(
            "The position is reported {} late{}.",
            self.delay(),
            self.or_inductance()
        )
    }

    /// What a delay may be instead, where the machine file neglects the winding's inductance.
    fn or_inductance(&self) -> String {
        let neglected = self.effect.neglected_inductance;
        neglected.map_or(String::new(), |neglected| {
            format!(
                ", or it is the winding's inductance, which the machine file neglects: {}",
                as_inductance(self.value("delay"), neglected.resistance)
            )
        })
    }

    fn backlash(&self) -> String {
        format!(
            "There is {} of play between the drive and the position sensor.",
            self.place(self.span("width"))
        )
    }

    fn compliance(&self) -> String {
        let frequency = self
            .span("trailing")
            .map(|trailing| 1.0 / (TAU * trailing.sqrt()));
        format!(
            "A shaft, belt or coupling is soft: what is behind it, {} % of the inertia, swings at {} while the \
             drive is held.",
            significant(100.0 * self.value("share"), 3),
            frequency.in_words("Hz")
        )
    }

    fn hysteresis(&self) -> String {
        format!(
            "Something elastic that loses energy pulls back, as a rubber mount or a cable does: with up to {}, most of \
             it within {} from where the motion turned.",
            self.torque(self.span("torque")),
            self.place(self.span("reach"))
        )
    }

    fn encoder_eccentricity(&self) -> String {
        format!(
            "The position reading is up to {} off either way, {}, as of a disc that is off its centre.",
            self.place(self.span("amplitude")),
            self.recurrence(self.value("period"))
        )
    }
}

/// The inductance whose current is so late, in seconds, behind a resistance, in ohms: `a delay of 1.2 ms would be 1.2 mH at 1 Ω`.
pub(super) fn as_inductance(delay: f64, resistance: f64) -> String {
    let quantity = |value: f64, unit: &str| Scale::of(unit, [value]).quantity(value);
    format!(
        "a delay of {} would be {} at {}",
        quantity(delay, "s"),
        quantity(delay * resistance, "H"),
        with_unit(resistance, "Ω")
    )
}

/// A size of the logs, or one unit of it where they have none.
fn or_one(value: f64) -> f64 {
    if value > 0.0 { value } else { 1.0 }
}

fn towards(torque: f64) -> &'static str {
    if torque < 0.0 {
        "towards smaller positions"
    } else {
        "towards larger positions"
    }
}
