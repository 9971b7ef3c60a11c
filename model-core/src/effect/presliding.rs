//! `presliding`: elastic displacement before sliding.
//!
//! ```text
//! F = σ₀ z + σ₁ dz/dt,   dz/dt = ω − |ω| σ₀ z / g(ω)
//! g(ω) = F_C + (F_S − F_C) exp(−(ω/ω_S)²)
//! ```
//!
//! z is the mean deflection of the contact's bristles, g the friction that they tend to while
//! sliding: of the Coulomb level F_C, and of the breakaway level F_S in slow motion. The compliance
//! 1/σ₀ is the effect's strength; at 0 friction is rigid. Source: P. R. Dahl, *A solid friction
//! model*, 1968; with the damping and with g: C. Canudas de Wit, H. Olsson, K. J. Åström, P.
//! Lischinsky, *A new model for control of systems with friction*, 1995 (LuGre). The damping is that
//! of their example, half the critical one of the inertia on its bristles, σ₁ = √(σ₀ J).
//!
//! Over a step, z is a function of the displacement Δ alone, with p the bristles' force at its
//! beginning, both counted along the motion (g held):
//!
//! ```text
//! F(Δ) = g − (g − p) exp(−Δ σ₀/g)
//! ```
//!
//! and the step's displacement is that of the plant without friction less what the mean force takes
//! back, which is one equation in Δ with one root. Work of friction and what the bristles store agree
//! in every step, so that it is stable however stiff they are.
//!
//! Told from backlash by the force that it takes, from a softer shaft by what stays behind. It shows
//! where the machine turns or rests, over some times g/σ₀; a log whose sensor does not resolve that,
//! and without current, does not have it. What lies between small and large compliances is not
//! linear, so that it is screened at several. Replays carry the bristles' force from the last clear
//! motion on, behind which it was that of sliding.

use super::{Bounds, Chain, Description, Effect, MOST_PARAMETERS, Parameter, Role, Scope, Summary, padded};
use crate::numeric::exponential::decay;
use crate::plant::Directional;
use crate::plant::actuator::Load;
use crate::plant::lanes::Lanes;
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Compliances at which it is screened, as shares of stroke over friction, and speeds of the fall from
/// breakaway to Coulomb friction, as shares of the usual speed.
const COMPLIANCES: [f32; 4] = [3e-4, 1e-3, 3e-3, 1e-2];
const SPEEDS: [f32; 2] = [0.01, 0.05];

/// Least weight of the damping in a step: stiffer bristles than the step resolves would swing about
/// the rest from step to step.
const LEAST_DAMPING: f32 = 0.5;

/// Steps to the root, each of which at least halves what is left once it is near.
const MOST_STEPS: u32 = 12;

/// Share of the displacement at which a step to the root is the last: what is left behind it goes with
/// its square.
const FOUND: f32 = 1e-4;

/// Displacement, in shares of the length over which bristles bend, behind which the way to the level
/// counts no more.
const SATURATED: f32 = 1e6;

/// Share of the travel that a step to the root loses to rounding: no smaller one comes nearer.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

/// Most time of a radian of the swing, s: slower than any log, and what keeps the damping finite.
const MOST_TIME: f32 = 1e6;

/// Decay that leaves less than the rounding of what it is beside.
const FORGOTTEN: f32 = 17.5;

/// What a decay leaves, exp(−x): nothing where that is lost beside 1. Hardware is slow on numbers near
/// the smallest.
#[inline(always)]
fn left(x: f32) -> f32 {
    if x < FORGOTTEN { decay(x) } else { 0.0 }
}

/// Bristles between the moving part and what it slides on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bristles {
    /// 1/σ₀, rad/(N·m) or m/N.
    pub compliance: f32,
    /// One over ω_S, s/rad or s/m.
    pub inverse_velocity: f32,
    /// √(J/σ₀): the time of a radian of the inertia's swing on the bristles, s.
    pub time: f32,
}

/// A step of the plant without friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Free {
    /// Its displacement, rad or m.
    pub travel: f32,
    /// What a torque held over it adds to that, rad/(N·m) or m/N.
    pub give: f32,
    /// Its length, s.
    pub length: f32,
}

impl Bristles {
    /// Friction g that they tend to in each direction, between these levels.
    #[inline(always)]
    pub fn levels(&self, load: &Load, velocity: f32) -> Directional {
        let slow = velocity * self.inverse_velocity;
        let share = left(slow * slow);
        let level = |coulomb: f32, breakaway: f32| coulomb + (breakaway - coulomb).max(0.0) * share;
        Directional {
            forward: level(load.coulomb.forward, load.breakaway.forward),
            backward: level(load.coulomb.backward, load.breakaway.backward),
        }
    }

    /// Whether they slide at the Coulomb level: bent all the way towards a motion that is too fast for
    /// the breakaway level to count.
    #[inline(always)]
    pub fn slide(&self, force: f32, coulomb: Directional, velocity: f32) -> bool {
        let slow = velocity * self.inverse_velocity;
        let bent = if velocity > 0.0 {
            coulomb.forward - force
        } else {
            coulomb.backward + force
        };
        slow * slow >= FORGOTTEN && bent.abs() <= f32::EPSILON * force.abs()
    }

    /// Their force after a displacement, from `force` on; positive against forward motion.
    ///
    /// ```
    /// use model_core::effect::presliding::Bristles;
    /// let bristles = Bristles { compliance: 0.01, inverse_velocity: 1.0, time: 1e-3 };
    /// // 0.01 rad/(N·m) and 2 N·m: 0.02 rad is the length over which the force comes to its level.
    /// let (pushed, level) = (bristles.after(0.0, 0.02, 2.0), 2.0);
    /// assert!((pushed - 2.0 * (1.0 - (-1.0_f32).exp())).abs() < 1e-6);
    /// // Turned, it falls as if it had further to go: that is the hysteresis.
    /// let back = bristles.after(pushed, -0.02, level);
    /// assert!((back + 2.0 - (pushed + 2.0) * (-1.0_f32).exp()).abs() < 1e-6);
    /// ```
    #[inline(always)]
    pub fn after(&self, force: f32, displacement: f32, level: f32) -> f32 {
        let sign = if displacement < 0.0 { -1.0 } else { 1.0 };
        let force = force.max(-level).min(level);
        let left = left(displacement.abs() / self.length(level));
        sign * level - (sign * level - force) * left
    }

    /// Displacement over which the force comes to its level.
    #[inline(always)]
    fn length(&self, level: f32) -> f32 {
        (level * self.compliance).max(f32::MIN_POSITIVE)
    }

    /// The force to be held over a step, from `force` on.
    pub fn held(&self, force: f32, free: &Free, levels: &Directional) -> f32 {
        let (search, mut place) = self.search(force, free, levels);
        for _ in 0..MOST_STEPS {
            if place.found {
                break;
            }
            place = search.step(&place);
        }
        search.sign * place.held
    }

    /// Where the search for the force to be held over a step begins.
    #[inline(always)]
    fn search(&self, force: f32, free: &Free, levels: &Directional) -> (Search, Place) {
        let forward = free.travel > free.give * force;
        let (sign, level) = if forward {
            (1.0, levels.forward)
        } else {
            (-1.0, levels.backward)
        };
        // Where the level has fallen below the force, bristles let go.
        let start = (sign * force).max(-level).min(level);
        let lets_go = level - start <= f32::EPSILON * level;
        let bend = level - start;
        let damping = (self.time / free.length).max(LEAST_DAMPING);
        // The force is concave in the displacement: Newton's method comes from below and stays there. It
        // starts from the nearer of two that are below: what the largest force leaves, and where the
        // slope at no displacement leads.
        let target = sign * free.travel;
        let length = self.length(level);
        let most = level + damping * bend;
        let slope = bend * (0.5 + damping);
        let rough = (target - free.give * start) / (length + free.give * slope);
        let share = rough.max((target - free.give * most) / length).max(0.0);
        let saturated = share >= SATURATED;
        let search = Search {
            sign,
            level,
            bend,
            damping,
            target,
            length,
            give: free.give,
            rounding: ROUNDING * target.abs() / length,
        };
        let place = Place {
            share,
            held: if lets_go {
                level
            } else if saturated {
                most
            } else {
                start
            },
            found: lets_go | saturated,
        };
        (search, place)
    }

    /// As [`Bristles::held`], in all lanes but those that nobody asks for.
    #[inline(always)]
    pub(crate) fn all_held<const N: usize>(
        &self,
        (forces, unasked): (&Lanes<N>, &[bool; N]),
        free: impl Fn(usize) -> Free,
        levels: impl Fn(usize) -> Directional,
    ) -> Lanes<N> {
        let mut searches = Searches::<N>::NOTHING;
        let mut places = Places::<N>::NOTHING;
        for lane in 0..N {
            let (search, mut place) = self.search(forces[lane], &free(lane), &levels(lane));
            place.found |= unasked[lane];
            searches.put(lane, &search);
            places.put(lane, &place);
        }
        for _ in 0..MOST_STEPS {
            if places.found.iter().fold(true, |all, &found| all & found) {
                break;
            }
            for lane in 0..N {
                let place = places.at(lane);
                let next = searches.at(lane).step(&place);
                let chosen = |next: f32, last: f32| if place.found { last } else { next };
                let place = Place {
                    share: chosen(next.share, place.share),
                    held: chosen(next.held, place.held),
                    found: place.found | next.found,
                };
                places.put(lane, &place);
            }
        }
        let mut held = [0.0; N];
        for lane in 0..N {
            held[lane] = searches.sign[lane] * places.held[lane];
        }
        held
    }
}

/// What the search for a force does not change: all along the motion.
#[derive(Clone, Copy)]
struct Search {
    sign: f32,
    level: f32,
    /// What the force lacks to its level.
    bend: f32,
    damping: f32,
    /// Displacement of the plant without friction.
    target: f32,
    /// Displacement over which bristles bend.
    length: f32,
    give: f32,
    rounding: f32,
}

/// Where a search is.
#[derive(Clone, Copy)]
struct Place {
    /// Displacement, in shares of the length over which bristles bend.
    share: f32,
    /// The force there.
    held: f32,
    found: bool,
}

impl Search {
    /// Mean force and damping after a displacement, and their slope.
    #[inline(always)]
    fn law(&self, share: f32) -> (f32, f32) {
        let left = left(share);
        let inverse = 1.0 / share;
        let far = (1.0 - left) * inverse;
        let (way, rise) = if share > 1e-2 {
            (far, (far - left) * inverse)
        } else {
            (1.0 - 0.5 * share, 0.5 * left)
        };
        (
            self.level - self.bend * way + self.damping * self.bend * (1.0 - left),
            self.bend * (rise + self.damping * left),
        )
    }

    /// A step of Newton's method.
    #[inline(always)]
    fn step(&self, place: &Place) -> Place {
        let (force, slope) = self.law(place.share);
        let missing = self.target - self.give * force - place.share * self.length;
        let step = (missing / (self.length + self.give * slope)).max(-place.share);
        let share = place.share + step;
        Place {
            share,
            held: force + slope * step,
            found: step.abs() <= FOUND * share + self.rounding,
        }
    }
}

/// Searches side by side.
struct Searches<const N: usize> {
    sign: Lanes<N>,
    level: Lanes<N>,
    bend: Lanes<N>,
    damping: Lanes<N>,
    target: Lanes<N>,
    length: Lanes<N>,
    give: Lanes<N>,
    rounding: Lanes<N>,
}

impl<const N: usize> Searches<N> {
    const NOTHING: Self = Self {
        sign: [0.0; N],
        level: [0.0; N],
        bend: [0.0; N],
        damping: [0.0; N],
        target: [0.0; N],
        length: [0.0; N],
        give: [0.0; N],
        rounding: [0.0; N],
    };

    #[inline(always)]
    fn at(&self, lane: usize) -> Search {
        Search {
            sign: self.sign[lane],
            level: self.level[lane],
            bend: self.bend[lane],
            damping: self.damping[lane],
            target: self.target[lane],
            length: self.length[lane],
            give: self.give[lane],
            rounding: self.rounding[lane],
        }
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, search: &Search) {
        self.sign[lane] = search.sign;
        self.level[lane] = search.level;
        self.bend[lane] = search.bend;
        self.damping[lane] = search.damping;
        self.target[lane] = search.target;
        self.length[lane] = search.length;
        self.give[lane] = search.give;
        self.rounding[lane] = search.rounding;
    }
}

/// Places side by side.
struct Places<const N: usize> {
    share: Lanes<N>,
    held: Lanes<N>,
    found: [bool; N],
}

impl<const N: usize> Places<N> {
    const NOTHING: Self = Self {
        share: [0.0; N],
        held: [0.0; N],
        found: [false; N],
    };

    #[inline(always)]
    fn at(&self, lane: usize) -> Place {
        Place {
            share: self.share[lane],
            held: self.held[lane],
            found: self.found[lane],
        }
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, place: &Place) {
        self.share[lane] = place.share;
        self.held[lane] = place.held;
        self.found[lane] = place.found;
    }
}

/// What friction yields to before it slides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Presliding {
    compliance: f32,
    velocity: f32,
}

impl Effect for Presliding {
    const DESCRIPTION: Description = Description {
        id: "presliding",
        summary: Summary::Same("elastic displacement before sliding"),
        source: "Dahl 1968; Canudas de Wit et al. 1995",
        parameters: &[
            Parameter {
                name: "compliance",
                dimension: Dimension::PositionPerTorque,
                role: Role::Strength,
                bounds: Bounds::NotNegative,
            },
            Parameter {
                name: "velocity",
                dimension: Dimension::Velocity,
                role: Role::Shape,
                bounds: Bounds::Positive,
            },
        ],
        reported: &[
            ("compliance", Dimension::PositionPerTorque),
            ("velocity", Dimension::Velocity),
        ],
        rotary_only: false,
    };
    const STATEFUL: bool = true;

    fn new([compliance, velocity, ..]: [f32; MOST_PARAMETERS]) -> Self {
        Self {
            compliance,
            velocity,
        }
    }

    fn scale(scope: &Scope, _index: usize) -> f32 {
        1e-3 * scope.stroke / scope.friction
    }

    fn trial(scope: &Scope, index: usize) -> Option<[f32; MOST_PARAMETERS]> {
        let compliance = COMPLIANCES.get(index / SPEEDS.len())?;
        let speed = SPEEDS[index % SPEEDS.len()];
        let unit = scope.stroke / scope.friction;
        Some(padded([compliance * unit, speed * scope.speed]))
    }

    fn bind(&self, plant: &mut Parameters, chain: &mut Chain) {
        chain.bristles = Some(Bristles {
            compliance: self.compliance,
            inverse_velocity: 1.0 / self.velocity.max(f32::MIN_POSITIVE),
            time: libm::sqrtf(plant.inertia * self.compliance).min(MOST_TIME),
        });
    }

    fn report(&self, _plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        padded([self.compliance, self.velocity])
    }
}
