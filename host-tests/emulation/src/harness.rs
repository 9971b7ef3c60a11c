//! The wires between a `controller` and a `throttle`: what a loop of the two boards is wired with.
//!
//! | from the controller | through | to the throttle |
//! |---|---|---|
//! | TIM1's half bridges, 20 kHz | the difference of their duties, as the winding sees it: its size as a PWM of 20 kHz, its sign as a level | PA0, PA1 |
//! | bridge enable, and TIM1's master enable | inverted | PA2, disable |
//!
//! | from the throttle | through | to the controller |
//! |---|---|---|
//! | PA4, PA5, position tracks | their difference, which doubles the slope, a low-pass of first order, and a converter to a quadrature encoder | PC6, PC7 |
//! | PB8, PWM of the motor current | its mean over a step: both sides have 66 mV/A about 1.65 V | PC0 |
//! | the stroke's ends, from the tracks | limit switches, closed to ground unless reached | PC10, PC11 |
//!
//! Beside them 12 V of supply behind a divider by eleven at PC1, and the strap that stands for an emergency stop at PB15. Both chips stop each 50 µs, exchange what
//! is on their wires, and go on: what one does reaches the other in the step behind, 50 to 100 µs later.

use rigless::device::Level;

use crate::chip::pins;
use crate::running::{Outputs, Running};

/// Time between two exchanges, and period of the PWM, ns.
pub const STEP: u64 = 50_000;

/// Edges come no closer to a step's ends, ns: TIM2's filter passes none that is shorter than 0.1 µs.
const SHORTEST: u64 = 200;

/// Supply of the loop, V.
pub const SUPPLY: f64 = 12.0;

/// Divider at the supply's input.
const SUPPLY_DIVIDER: f64 = 11.0;

/// One count of the encoder, rad: `resolution` of the loop's machine file and the controller's
/// `position_unit`.
pub const POSITION_UNIT: f64 = 4.0e-4;

/// Stroke of the throttle, rad: its `lower_stop` and `upper_stop`.
const STROKE: [f64; 2] = [0.02, 1.57];

/// Share of full scale that a track moves by over the stroke.
const TRACK_SPAN: f64 = 0.8;

/// Codes of full scale.
const FULL_SCALE: f64 = 4095.0;

/// Time constant of the low-pass behind the tracks, s: it leaves a tenth of a milliradian of the tracks'
/// noise.
const LOW_PASS: f64 = 2.0e-3;

/// How near to a stop a limit switch opens, rad.
const SWITCH: f64 = 5.0e-3;

/// Most counts that the encoder moves by in a step: 40 rad/s.
const MOST_COUNTS: i64 = 5;

/// What is broken at the wires to the controller.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Broken {
    /// Nothing.
    #[default]
    Nothing,
    /// The driver of the bridge pulls its fault line.
    Bridge,
    /// The contact of the emergency stop is open.
    EmergencyStop,
    /// The current sensor's output is at its upper end.
    CurrentSensor,
    /// There is no supply.
    Supply,
    /// The limit switches' cable is cut: both are open.
    Switches,
}

/// The wires.
#[derive(Debug, Default)]
pub struct Harness {
    /// What is broken at them.
    pub broken: Broken,
    /// Position behind the low-pass, rad; none before the tracks are there.
    position: Option<f64>,
    /// Counts that the encoder has given.
    counts: i64,
    /// Counts at the first position.
    origin: i64,
}

/// Position from both tracks, rad; none while they are at ground, as with a fault.
fn position(tracks: [u16; 2]) -> Option<f64> {
    if tracks == [0, 0] {
        return None;
    }
    let [first, second] = tracks.map(f64::from);
    // From −0.8 at the lower stop to 0.8 at the upper one.
    let difference = (first - second) / FULL_SCALE;
    let share = 0.5 + difference / (2.0 * TRACK_SPAN);
    Some(STROKE[0] + share * (STROKE[1] - STROKE[0]))
}

fn level(high: bool) -> Level {
    Level::from(high)
}

/// Levels of A and B at a count.
pub fn quadrature(count: i64) -> [bool; 2] {
    match count.rem_euclid(4) {
        0 => [false, false],
        1 => [true, false],
        2 => [true, true],
        _ => [false, true],
    }
}

impl Harness {
    /// Position of the throttle behind the low-pass, rad.
    pub fn position(&self) -> Option<f64> {
        self.position
    }

    /// Takes both boards one step further.
    ///
    /// # Errors
    /// One of them has ended.
    pub fn step(&mut self, controller: &mut Running, throttle: &mut Running) -> Result<(), String> {
        let at = controller.now();
        drive_throttle(&controller.outputs, throttle, throttle.now());
        self.drive_controller(&throttle.outputs, controller, at);
        controller.begin_step(at + STEP)?;
        throttle.begin_step(throttle.now() + STEP)?;
        controller.finish_step()?;
        throttle.finish_step()
    }

    fn drive_controller(&mut self, throttle: &Outputs, controller: &mut Running, at: u64) {
        if let Some(position) = position(throttle.tracks) {
            let before = self.position.unwrap_or(position);
            let passed = STEP as f64 * 1e-9 / LOW_PASS;
            let filtered = before + passed * (position - before);
            let counts = (filtered / POSITION_UNIT).round() as i64;
            if self.position.is_none() {
                self.origin = counts;
            }
            self.position = Some(filtered);
            self.turn_encoder(counts - self.origin, controller, at);
        }
        let next = &mut controller.next;
        let share = if throttle.current > 0.0 {
            throttle.current
        } else {
            // Ground stands for no current at all: the throttle is not up yet.
            0.5
        };
        let broken = |what| self.broken == what;
        let share = if broken(Broken::CurrentSensor) {
            1.0
        } else {
            share
        };
        let supply = if broken(Broken::Supply) {
            0.0
        } else {
            SUPPLY * 1000.0 / SUPPLY_DIVIDER
        };
        next.analogue = vec![
            (pins::CURRENT_CHANNEL, (share * 3300.0).round() as u32),
            (pins::SUPPLY_CHANNEL, supply.round() as u32),
        ];
        let at_stops = self.position.map_or([false; 2], |position| {
            [position < STROKE[0] + SWITCH, position > STROKE[1] - SWITCH]
        });
        let switches = [pins::LOWER_SWITCH, pins::UPPER_SWITCH];
        for (pin, reached) in switches.into_iter().zip(at_stops) {
            next.levels
                .push((at, pin, level(reached || broken(Broken::Switches))));
        }
        let driver = level(!broken(Broken::Bridge));
        next.levels.push((at, pins::BRIDGE_BREAK, driver));
        let stop = level(broken(Broken::EmergencyStop));
        next.levels.push((at, pins::EMERGENCY_STOP, stop));
        next.levels.sort_by_key(|&(instant, ..)| instant);
    }

    /// Edges evenly over the step. What is faster than the encoder follows later.
    fn turn_encoder(&mut self, wanted: i64, controller: &mut Running, at: u64) {
        let moved = (wanted - self.counts).clamp(-MOST_COUNTS, MOST_COUNTS);
        let steps = moved.unsigned_abs();
        for number in 0..steps.max(1) {
            if steps > 0 {
                self.counts += moved.signum();
            }
            let instant = at + number * STEP / steps.max(1);
            let [a, b] = quadrature(self.counts);
            let levels = &mut controller.next.levels;
            levels.push((instant, pins::ENCODER_A, level(a)));
            levels.push((instant, pins::ENCODER_B, level(b)));
        }
    }
}

fn drive_throttle(controller: &Outputs, throttle: &mut Running, at: u64) {
    let levels = &mut throttle.next.levels;
    let driven = controller.driven();
    levels.push((at, pins::DISABLE, level(driven.is_none())));
    let share = driven.unwrap_or(0.0);
    levels.push((at, pins::DIRECTION, level(share >= 0.0)));
    let width = (share.abs().min(1.0) * STEP as f64).round() as u64;
    if width < SHORTEST {
        levels.push((at, pins::DUTY, Level::Low));
    } else {
        levels.push((at, pins::DUTY, Level::High));
        if width + SHORTEST <= STEP {
            levels.push((at + width, pins::DUTY, Level::Low));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tracks_give_the_stroke() {
        let near = |tracks, expected: f64| {
            let position = position(tracks).unwrap();
            assert!((position - expected).abs() < 5e-4, "{position}");
        };
        near([410, 3686], 0.02);
        near([3686, 410], 1.57);
        near([2048, 2048], 0.795);
        assert_eq!(position([0, 0]), None);
    }

    #[test]
    fn one_line_of_the_encoder_changes_at_a_count() {
        for count in -5..5 {
            let [before, after] = [count, count + 1].map(quadrature);
            let changed = before.iter().zip(after).filter(|(b, a)| **b != *a).count();
            assert_eq!(changed, 1, "{count}");
        }
    }
}
