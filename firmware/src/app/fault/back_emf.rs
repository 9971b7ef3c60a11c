//! The encoder against the winding: a motor that turns says so in its back-EMF.
//!
//! Kirchhoff's law of the winding is u = R i + L di/dt + k ω. The current is measured as its mean over a control
//! period *h*, as the voltage is told and the encoder's way taken over one. The law's mean over a period that
//! slides from the last one to this, 0 to 1, is
//!
//! (u₀ + u₁)/2 = R (i₀ + i₁)/2 + L (i₁ − i₀)/h + k (Δθ₀ + Δθ₁)/2h,
//!
//! in which no measurement is differentiated. What is left of it, e, is 0 V for exact numbers and a motion
//! whose rates are even. Three numbers of a sound drive are not known: the shares ρ and κ by which its resistance and its
//! torque constant are off, and the share δ that its bridge's dead time takes of the supply U, against the current, whose sign is σ. So
//!
//! e − σ b/2 = ρ R (i₀ + i₁)/2 + δ U σ + κ k (Δθ₀ + Δθ₁)/2h + n.
//!
//! For a current and a speed that are monotone |n| stays below
//!
//! m = R |i₁ − i₀|/2 + δL L |i₁ − i₀|/h + k |Δθ₁ − Δθ₀|/2h + l |u₁ − u₀|/h + (s₀ + s₁)/8,
//!
//! and b/2, for what the brushes take comes and goes between 0 and b. The first and the third term of m are the trapezoidal rule's worst,
//! the fourth one is that of a voltage that acts by *l* later than it was told. Where the current is limited the voltage changes within
//! a period, by *s*: the period that slides weighs a triangle's half, which is off from the mean by a quarter in all, of at most s/2. A
//! current or a speed that turns round within a period changed before it by as much, so the bound N has the m of the period before too.
//! Near no current its sign is not known; there σ is 0, and N has all that brushes and dead time may take.
//!
//! All of this goes through one first-order filter with the time constant *τ*. Its response is positive, so |n| ≤ N in every period keeps
//! the filtered |n| below the filtered N. Reading in steps of *r* rad is wrong by half a step at most however long it
//! moves, which the filter makes k r/τ of; twice that covers what it hides of N too.
//!
//! Hence each filtered balance is a strip between two planes in the space of ρ, δ and κ, and a sound drive lies in all strips. At first only
//! the tolerances are known, which are a box. A balance whose strip does not touch what is known, or does not touch the tolerances,
//! is the fault: no drive explains it beside those before, so the encoder, the current sensor or one of the declared tolerances
//! is wrong. That takes no debounce, and no number that was tried out. A strip that touches what is known narrows it, after Vicino and
//! Zappa, IEEE Transactions on Automatic Control 41 (1996) 774. What is known widens by what a winding may warm or cool, and the tolerances narrow it again. It
//! begins anew with the bridge off. What a fault taught before it was found may be wrong; the tolerances are not.
//!
//! A motor at ω whose encoder claims ω' is found within three time constants from where
//! k |ω − ω'| exceeds b + δu U + δR R |i| + δk k |ω'|, and from less where the winding is known. A motor that is held tells the winding
//! nothing about its encoder: what ends that is the monitor of its [torque](super::following), and where it is held by an
//! end stop that it may be at, [`Fault::Overload`].

use model_core::numeric::invalid_parameter::InvalidParameter;
use model_core::plant::parameters::{Drive, Parameters};

use super::Fault;
use super::monitor::{CURRENT_SHARE, Limits};
use super::observer::{Reading, TIME_CONSTANT, Tolerances, check_encoder};
use crate::app::operation::current_offset;
use crate::app::timing::PLANT_PERIOD;

/// How much later than told a voltage acts at most, s: the bridge's timer takes it over with the second tick.
const LATENCY: f32 = 2.0 * PLANT_PERIOD;

/// Of a current whose sign is known, A: more than what the sensor's zero may be off by.
const SIGNED: f32 = current_offset::MOST;

/// By which share a kelvin changes copper's resistance, of that at 20 °C (*Industrial Power Engineering and Applications Handbook*,
/// p. 970, "standard copper"), and a sintered hard ferrite's remanence (Modelica Standard Library 4.0,
/// `Magnetic.FluxTubes.Material.HardMagnetic.HardFerrite`). No magnet warms faster than its winding.
const COPPER: f32 = 3.93e-3;
const MAGNETS: f32 = 2e-3;

/// Copper's resistivity at 105 °C, the hottest of a winding within its tolerances, Ω·m: 1/58 Ω·mm²/m at 20 °C (the same page).
const RESISTIVITY: f32 = 1e-6 / 58.0 * (1.0 + 85.0 * COPPER);

/// Copper's heat capacity, J/(K·m³): 385 J/(K·kg) and 8.89 g/cm³ (*Encyclopedia of Metalloproteins*, Springer 2013, "Copper, Physical and Chemical
/// Properties").
const HEAT_CAPACITY: f32 = 385.0 * 8.89e3;

/// Density of the continuous current, A/m². An assumption: a winding that bears more for ever warms faster than is reckoned with here.
const DENSITY: f32 = 15e6;

/// Most of a bridge's supply, V: beyond it the supply's sensor saturates.
const VOLTS: f32 = 36.0;

/// Least half width of a strip, V: a thousand times what a sum of five terms of so many volts is rounded by, 5 · 36 V · 2⁻²⁴, so that
/// rounding is at most a thousandth of what a strip says.
const ROUNDING: f32 = 0.01;

/// Control steps from one balance that is learned to the next: one for the balance, one for the widening and three for the
/// tolerances. The filter's time constant is four, so that a balance between two of them says little that these do not.
const TURNS: u8 = 5;

/// The observer's numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    resistance: f32,
    /// L/h.
    inductance: f32,
    /// k/h.
    back_emf: f32,
    tolerances: Tolerances,
    /// The middle of ρ, δ and κ, and how far the tolerances let them be from it.
    tolerated: [[f32; 3]; 2],
    /// 2 k r/τ, V.
    quantisation: f32,
    /// l/h.
    latency: f32,
    /// h/τ.
    gain: f32,
    /// By how much ρ, δ and κ change over [`TURNS`] at most: no more than the tolerances. A dead time stays.
    drift: [f32; 3],
}

/// A balance: the three unknown numbers, times these factors, make the middle, to within the width either way.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Strip {
    /// Of ρ, δ and κ, V: R i, U σ, and k ω by the encoder.
    factors: [f32; 3],
    /// e − σ b/2, V.
    middle: f32,
    /// N, V.
    width: f32,
}

impl Strip {
    fn follow(&mut self, other: &Self, gain: f32) {
        let follow = |value: &mut f32, other: f32| *value += gain * (other - *value);
        for (factor, other) in self.factors.iter_mut().zip(other.factors) {
            follow(factor, other);
        }
        follow(&mut self.middle, other.middle);
        follow(&mut self.width, other.width);
    }
}

fn dot([a, b, c]: [f32; 3], [d, e, f]: [f32; 3]) -> f32 {
    a * d + b * e + c * f
}

/// Adds a share of a vector.
fn add(to: &mut [f32; 3], share: f32, vector: [f32; 3]) {
    for (to, entry) in to.iter_mut().zip(vector) {
        *to += share * entry;
    }
}

fn scaled(vector: [f32; 3], factor: f32) -> [f32; 3] {
    vector.map(|entry| factor * entry)
}

/// What is known of a winding: ρ, δ and κ lie in a parallelotope. Each of its points is the middle and of each of the three edges
/// some share from −1 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Known {
    middle: [f32; 3],
    edges: [[f32; 3]; 3],
    /// The inverse of the edges: each row, times a distance from the middle, gives its edge's share of it.
    shares: [[f32; 3]; 3],
}

impl Known {
    /// As far from a middle as this.
    fn within(middle: [f32; 3], most: [f32; 3]) -> Self {
        let diagonal = |[a, b, c]: [f32; 3]| [[a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, c]];
        Self {
            middle,
            edges: diagonal(most),
            shares: diagonal(most.map(|most| 1.0 / most)),
        }
    }

    /// How far the strip's middle is from this one's, and how far each edge reaches towards it, V.
    fn apart(&self, strip: &Strip) -> (f32, [f32; 3]) {
        let off = strip.middle - dot(strip.factors, self.middle);
        (off, self.edges.map(|edge| dot(strip.factors, edge)))
    }

    /// Whether the strip touches it. One that is not a number does not.
    fn explains(&self, strip: &Strip) -> bool {
        let (off, reaches) = self.apart(strip);
        let most: f32 = reaches.iter().map(|reach| reach.abs()).sum();
        off.abs() <= most + strip.width
    }

    /// Takes off what lies beside a strip that touches it: its planes take the place of those of the edge that reaches farthest
    /// across them, if that leaves less.
    fn narrow(&mut self, strip: &Strip) {
        let (off, reaches) = self.apart(strip);
        let (mut most, mut longest) = (0.0, 0);
        for (edge, reach) in reaches.iter().enumerate() {
            most += reach.abs();
            if reach.abs() > reaches[longest].abs() {
                longest = edge;
            }
        }
        let low = if off - strip.width > -most {
            off - strip.width
        } else {
            -most
        };
        let high = if off + strip.width < most {
            off + strip.width
        } else {
            most
        };
        let left = 0.5 * (high - low);
        let left = if left > ROUNDING { left } else { ROUNDING };
        let reach = reaches[longest];
        if left < reach.abs() {
            let along = scaled(self.edges[longest], 1.0 / reach);
            add(&mut self.middle, 0.5 * (low + high), along);
            for (edge, reach) in self.edges.iter_mut().zip(reaches) {
                add(edge, -reach, along);
            }
            self.edges[longest] = scaled(along, left);
            self.shares[longest] = scaled(strip.factors, 1.0 / left);
        }
    }

    /// Makes room for numbers that change by this much.
    fn widen(&mut self, drift: [f32; 3]) {
        for (edge, shares) in self.edges.iter_mut().zip(&mut self.shares) {
            let longer = 1.0 + dot(drift, shares.map(f32::abs));
            *edge = scaled(*edge, longer);
            *shares = scaled(*shares, 1.0 / longer);
        }
    }
}

/// What is remembered of a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Before {
    current: f32,
    /// The period that it ended, as far as the bridge drove.
    period: Option<Period>,
}

/// A period in which the bridge drove.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Period {
    /// Mean voltage, V.
    voltage: f32,
    /// Most less least voltage, V.
    spread: f32,
    /// The encoder's way.
    moved: f32,
}

/// What the observer remembers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    before: Option<Before>,
    /// The filtered balance.
    balance: Strip,
    /// m of the last balance, V.
    rest: f32,
    known: Option<Known>,
    /// Whether the last balance is one to learn from.
    learns: bool,
    turn: u8,
}

impl State {
    /// The same for other numbers: what is known and what the filter has was told in the old ones.
    #[must_use]
    pub fn of_other_numbers(self) -> Self {
        Self {
            before: self.before,
            ..Self::default()
        }
    }
}

/// How fast a winding warms or cools at most, K/s: copper that keeps all the heat of the most current that is ever let flow. It cools by no
/// more than what its surface takes, which is the heat of the continuous current.
fn warming(limits: &Limits) -> f32 {
    let density = DENSITY * CURRENT_SHARE * limits.peak_current / limits.continuous_current;
    RESISTIVITY * density * density / HEAT_CAPACITY
}

impl Coefficients {
    /// For an actuator within these limits, an encoder with steps of `resolution`, rad or m, and a control period, s.
    /// Lost motion between motor and encoder adds to the resolution.
    ///
    /// # Errors
    /// The drive is no voltage, or a number is out of its range.
    pub fn new(
        plant: &Parameters,
        limits: &Limits,
        tolerances: Tolerances,
        resolution: f32,
        period: f32,
    ) -> Result<Self, InvalidParameter> {
        let Drive::Voltage {
            resistance,
            inductance,
            torque_constant,
        } = plant.drive
        else {
            return Err(InvalidParameter {
                name: "drive",
                requirement: "must be a voltage",
            });
        };
        check_encoder(resolution, period)?;
        tolerances.check()?;
        let warmer = warming(limits) * f32::from(TURNS) * period;
        let middle = 0.5 * tolerances.dead_time;
        let most = [tolerances.resistance, middle, tolerances.torque_constant];
        Ok(Self {
            resistance,
            inductance: inductance / period,
            back_emf: torque_constant / period,
            tolerances,
            tolerated: [
                [0.0, middle, 0.0],
                most.map(|most| most.max(ROUNDING / VOLTS)),
            ],
            quantisation: 2.0 * torque_constant * resolution / TIME_CONSTANT,
            latency: LATENCY / period,
            gain: period / TIME_CONSTANT,
            drift: [
                (COPPER * warmer).min(tolerances.resistance),
                0.0,
                (MAGNETS * warmer).min(tolerances.torque_constant),
            ],
        })
    }

    /// Whether the strip touches the tolerances. One that is not a number does not.
    fn tolerates(&self, strip: &Strip) -> bool {
        let [middle, most] = self.tolerated;
        let off = strip.middle - dot(strip.factors, middle);
        off.abs() <= dot(strip.factors.map(f32::abs), most) + strip.width
    }

    /// Takes a reading and the supply, V: [`Fault::EncoderLost`] or [`Fault::EncoderImplausible`] as long as the encoder
    /// is not to be believed. A reading that is not finite is none, and the observer begins anew; so it
    /// does with the bridge off.
    pub fn step(&self, state: &mut State, reading: &Reading, supply: f32) -> Option<Fault> {
        let &Reading {
            moved,
            current,
            spread,
            ..
        } = reading;
        let finite = [moved, current, spread, supply]
            .into_iter()
            .all(f32::is_finite);
        let mut now = Before {
            current,
            period: None,
        };
        let voltage = reading.voltage.filter(|volts| volts.is_finite() && finite);
        let (Some(voltage), Some(before)) = (voltage, state.before) else {
            *state = State {
                before: finite.then_some(now),
                ..State::default()
            };
            return None;
        };
        now.period = Some(Period {
            voltage,
            spread,
            moved,
        });
        state.before = Some(now);
        let Period {
            voltage: voltage_before,
            spread: spread_before,
            moved: moved_before,
        } = before.period?;
        let mean = |before: f32, now: f32| 0.5 * (before + now);
        let change = current - before.current;
        let ohmic = self.resistance * mean(before.current, current);
        let claimed = self.back_emf * mean(moved_before, moved);
        let rest = (0.5 * self.resistance + self.tolerances.inductance * self.inductance)
            * change.abs()
            + 0.5 * self.back_emf * (moved - moved_before).abs()
            + self.latency * (voltage - voltage_before).abs()
            + 0.125 * (spread_before + spread);
        let Tolerances {
            brushes, dead_time, ..
        } = self.tolerances;
        let (sign, lost) = if before.current > SIGNED && current > SIGNED {
            (1.0, 0.5 * brushes)
        } else if before.current < -SIGNED && current < -SIGNED {
            (-1.0, 0.5 * brushes)
        } else {
            (0.0, brushes + dead_time * supply.abs())
        };
        let balance = Strip {
            factors: [ohmic, sign * supply, claimed],
            middle: mean(voltage_before, voltage)
                - ohmic
                - self.inductance * change
                - claimed
                - 0.5 * sign * brushes,
            width: rest + state.rest + lost,
        };
        state.rest = rest;
        state.balance.follow(&balance, self.gain);
        let known = state.known.get_or_insert_with(|| {
            let [middle, most] = self.tolerated;
            Known::within(middle, most)
        });
        let [_, _, claimed] = state.balance.factors;
        let strip = self.with_steps(&state.balance);
        let explained = known.explains(&strip) && self.tolerates(&strip);
        state.learns = explained;
        if explained {
            None
        } else if claimed.abs() <= self.quantisation {
            Some(Fault::EncoderLost)
        } else {
            Some(Fault::EncoderImplausible)
        }
    }

    /// A balance with what the encoder's steps may make of it.
    fn with_steps(&self, balance: &Strip) -> Strip {
        Strip {
            width: balance.width + self.quantisation,
            ..*balance
        }
    }

    /// Learns the winding from the last reading, unless that was a fault. It is called once behind each [step](Self::step), when there
    /// is time: nothing is made of it before the next one.
    pub fn learn(&self, state: &mut State) {
        let (Some(known), true) = (&mut state.known, state.learns) else {
            return;
        };
        state.turn = (state.turn + 1) % TURNS;
        match state.turn {
            0 => {
                let mut strip = self.with_steps(&state.balance);
                // It has to hold until the next widening.
                strip.width += dot(self.drift, strip.factors.map(f32::abs));
                known.narrow(&strip);
            }
            1 => known.widen(self.drift),
            turn => {
                let number = usize::from(turn) - 2;
                let [middle, most] = self.tolerated;
                let mut strip = Strip {
                    middle: VOLTS * middle[number],
                    width: VOLTS * most[number],
                    ..Strip::default()
                };
                strip.factors[number] = VOLTS;
                known.narrow(&strip);
            }
        }
    }
}
