//! The throttle at the pins of an engine control unit ([`crate::ecu`]): key-on, pedal and every fault, at several
//! frequencies of the PWM, each edge of which comes late by a random time.
//!
//! | of the ECU | through | of the throttle |
//! |---|---|---|
//! | PWM of its bridge, by its edges; direction | | PA0, PA1 |
//! | bridge off | | PA2 |
//! | both tracks, of 5 V, 12 bits | the op-amps' 5/3.3, a low-pass of 0.2 ms | PA4, PA5 |
//! | motor current, of 3.3 V, 12 bits | two low-passes of 0.15 ms | PB8 |
//!
//! The supply that the ECU reads is the 12 V that the throttle believes it has.

use std::collections::VecDeque;

use rigless::device::Level;
use serde::Serialize;

use super::ticks::INJECTIONS;
use super::{Call, Consoles, MILLISECOND};
use crate::chip::pins::{self, Pin};
use crate::ecu::data::Body;
use crate::ecu::diagnosis::Code;
use crate::ecu::{self, Ecu, Readings};
use crate::random::Random;
use crate::running::Running;

/// Frequencies of the PWM, Hz.
const FREQUENCIES: [f64; 4] = [400.0, 2e3, 20e3, 40e3];

/// Latest that an edge comes, of a period.
const JITTER: f64 = 0.01;

/// Shortest pulse and shortest pause that are commanded, ns: TIM2's filter passes none below 0.1 µs.
const SHORTEST: f64 = 200.0;

/// Time between two looks at the throttle's outputs, ns: one of its plant ticks.
const LOOK: u64 = 50_000;

/// Supply, V.
const SUPPLY: f64 = 12.0;

/// Time in which a fault has to be found, ms.
const PATIENCE: u64 = 3000;

/// Time from a cleared code to the next fault, ms: the plate comes back to the pedal.
const RECOVERY: u64 = 150;

/// A PWM output with edges that come late.
struct Pwm {
    period: f64,
    /// When the next period begins, ns.
    next: f64,
    random: Random,
    /// Edges that are planned, in their order.
    planned: VecDeque<(u64, Pin, Level)>,
    high: bool,
}

impl Pwm {
    fn new(frequency: f64, now: u64) -> Self {
        Self {
            period: 1e9 / frequency,
            next: now as f64,
            random: Random(0x9e37_79b9),
            planned: VecDeque::new(),
            high: false,
        }
    }

    /// How late an edge comes, ns.
    fn lateness(&mut self) -> f64 {
        JITTER * self.period * f64::from(self.random.bits()) / f64::from(u32::MAX)
    }

    fn plan(&mut self, at: f64, pin: Pin, high: bool) {
        self.planned.push_back((at as u64, pin, Level::from(high)));
    }

    /// What happens before an instant, with what is commanded now: it acts from the next period on.
    fn edges(&mut self, command: ecu::Command, until: u64) -> Vec<(u64, Pin, Level)> {
        while self.next < until as f64 {
            let begin = self.next;
            self.next += self.period;
            let share = command.unwrap_or(0.0);
            self.plan(begin, pins::DIRECTION, share >= 0.0);
            self.plan(begin, pins::DISABLE, command.is_none());
            let width = share.abs() * self.period;
            let least = SHORTEST + JITTER * self.period;
            let [rise, fall] = [self.lateness(), self.lateness()];
            let is_high = width >= least;
            if is_high != self.high {
                self.plan(begin + rise, pins::DUTY, is_high);
                self.high = is_high;
            }
            if is_high && width <= self.period - least {
                self.plan(
                    begin + fall.max(rise + SHORTEST - width) + width,
                    pins::DUTY,
                    false,
                );
                self.high = false;
            }
        }
        let due = self.planned.partition_point(|edge| edge.0 < until);
        self.planned.drain(..due).collect()
    }
}

/// What the pedal does.
#[derive(Clone, Copy)]
enum Pedal {
    At(f64),
    /// Between these, up and down in so many ms.
    Triangle(f64, f64, u64),
}

impl Pedal {
    /// After so many ms.
    fn at(self, time: u64) -> f64 {
        match self {
            Self::At(share) => share,
            Self::Triangle(lower, upper, period) => {
                let phase = (time % period) as f64 / period as f64;
                lower + (upper - lower) * (1.0 - (1.0 - 2.0 * phase).abs())
            }
        }
    }
}

/// The throttle and its ECU at their wires.
struct Bench {
    throttle: Running,
    ecu: Ecu,
    pwm: Pwm,
    command: ecu::Command,
    pedal: Pedal,
    /// ms since the pedal does that.
    time: u64,
    /// Behind the low-passes: tracks, and the current's two stages, V.
    tracks: [f64; 2],
    current: [f64; 2],
    /// Largest distance of the plate from where the ECU takes it, of the stroke, by its own readings.
    largest_error: f64,
}

impl Bench {
    fn press(&mut self, pedal: Pedal) {
        (self.pedal, self.time, self.largest_error) = (pedal, 0, 0.0);
    }

    /// Takes the low-passes over the time that the throttle's outputs were as they are.
    fn settle(&mut self) {
        let outputs = &self.throttle.outputs;
        let passed = |time: f64| 1.0 - (-(LOOK as f64) * 1e-9 / time).exp();
        for (track, code) in self.tracks.iter_mut().zip(outputs.tracks) {
            let volts = f64::from(code) / 4095.0 * ecu::TRACK_FULL_SCALE;
            *track += passed(ecu::TRACK_LOW_PASS) * (volts - *track);
        }
        let mut volts = outputs.current * ecu::CURRENT_FULL_SCALE;
        for stage in &mut self.current {
            *stage += passed(ecu::CURRENT_LOW_PASS) * (volts - *stage);
            volts = *stage;
        }
    }

    fn millisecond(&mut self) -> Result<(), String> {
        let readings = Readings {
            tracks: self
                .tracks
                .map(|volts| ecu::convert(volts, ecu::TRACK_FULL_SCALE)),
            current: ecu::convert(self.current[1], ecu::CURRENT_FULL_SCALE),
            supply: ecu::convert(SUPPLY, ecu::SUPPLY_FULL_SCALE),
        };
        self.command = self.ecu.step(&readings, self.pedal.at(self.time));
        self.time += 1;
        let error = (self.ecu.set_point() - self.ecu.share()).abs();
        self.largest_error = self.largest_error.max(error);
        let end = self.throttle.now() + MILLISECOND;
        while self.throttle.now() < end {
            let until = self.throttle.now() + LOOK;
            self.throttle
                .next
                .levels
                .extend(self.pwm.edges(self.command, until));
            self.throttle.run_for(LOOK)?;
            self.settle();
        }
        Ok(())
    }

    fn wait(&mut self, milliseconds: u64) -> Result<(), String> {
        self.run_for(milliseconds * MILLISECOND)
    }

    /// Refuses a code where nothing is wrong.
    fn require_sound(&self, when: &str) -> Result<(), String> {
        self.ecu.code().map_or(Ok(()), |code| {
            Err(format!("{when} the ECU finds {code:?} in a sound throttle"))
        })
    }
}

impl Consoles for Bench {
    type Which = ();

    fn console(&mut self, (): ()) -> &mut Running {
        &mut self.throttle
    }

    fn run_for(&mut self, time: u64) -> Result<(), String> {
        for _ in 0..time.div_ceil(MILLISECOND) {
            self.millisecond()?;
        }
        Ok(())
    }
}

/// What came of a fault.
#[derive(Debug, Serialize)]
pub(super) struct Found {
    fault: &'static str,
    code: Option<Code>,
    /// From the first byte of its line on the console, ms.
    after_ms: u64,
}

/// What came of it at a frequency.
#[derive(Debug, Serialize)]
pub(super) struct Engine {
    pwm_hz: f64,
    /// Each track at limp-home, closed and open stop as it was learned, V.
    learned: [[f64; 3]; 2],
    /// Time that the learning took, s.
    learned_after_s: f64,
    /// The position loop's gain, V/rad.
    proportional: f64,
    /// Distance of the plate from the pedal half a second behind steps, of the stroke.
    settled: Vec<f64>,
    /// Largest distance from the set point along a triangle, of the stroke.
    following: f64,
    found: Vec<Found>,
    /// The throttle's `status` at the end.
    status: String,
}

pub(super) fn engine(call: &Call) -> Result<Vec<Engine>, String> {
    let body = Body::read()?;
    let mut bench = Bench {
        throttle: Running::start(&call.throttle)?,
        ecu: Ecu::new(body, FREQUENCIES[0]),
        pwm: Pwm::new(FREQUENCIES[0], 1),
        command: None,
        pedal: Pedal::At(0.0),
        time: 0,
        tracks: [0.0; 2],
        current: [0.0; 2],
        largest_error: 0.0,
    };
    bench.wait(100)?;
    bench.order((), "arm")?;
    FREQUENCIES
        .into_iter()
        .map(|frequency| {
            at(&mut bench, body, frequency).map_err(|e| format!("{frequency} Hz: {e}"))
        })
        .collect()
}

/// Longest that the learning may take, ms.
const LEARNING: u64 = 5000;

/// Where the pedal steps to.
const STEPS: [f64; 4] = [0.3, 0.8, 0.5, 0.07];

/// The ramp: across the middle of the stroke in 0.25 s.
const RAMP: Pedal = Pedal::Triangle(0.25, 0.75, 500);

fn at(bench: &mut Bench, body: Body, frequency: f64) -> Result<Engine, String> {
    bench.ecu = Ecu::new(body, frequency);
    bench.pwm = Pwm::new(frequency, bench.throttle.now());
    bench.press(Pedal::At(0.3));
    bench.wait(100)?;
    bench.ecu.turn_key_on();
    bench.press(Pedal::At(0.3));
    let learned = loop {
        bench.wait(1)?;
        bench.require_sound("at key-on")?;
        if let Some(learned) = bench.ecu.learned() {
            break *learned;
        }
        if bench.time > LEARNING {
            return Err("nothing is learned".to_owned());
        }
    };
    let learned_after_s = bench.time as f64 * 1e-3;
    let mut settled = Vec::new();
    for share in STEPS {
        bench.press(Pedal::At(share));
        bench.wait(500)?;
        bench.require_sound("behind a step")?;
        settled.push(bench.ecu.share() - share);
    }
    bench.press(RAMP);
    // To its beginning first.
    bench.wait(500)?;
    bench.largest_error = 0.0;
    bench.wait(1000)?;
    bench.require_sound("on a ramp")?;
    let following = bench.largest_error;
    let mut found = Vec::new();
    for fault in INJECTIONS {
        bench.require_sound(&format!("before {fault}"))?;
        found.push(suffer(bench, fault)?);
    }
    let status = bench.ask((), "status")?;
    Ok(Engine {
        pwm_hz: frequency,
        learned: [0, 1].map(|side| {
            let [closed, open] = learned.ends[side];
            [learned.limp_home[0][side], closed, open]
        }),
        learned_after_s,
        proportional: bench.ecu.proportional(),
        settled,
        following,
        found,
        status,
    })
}

/// Has the throttle suffer a fault on the ramp, waits for a code, and takes both away.
fn suffer(bench: &mut Bench, fault: &'static str) -> Result<Found, String> {
    bench.throttle.type_line(&format!("inject {fault}"));
    let mut after_ms = 0;
    while bench.ecu.code().is_none() && after_ms < PATIENCE {
        bench.wait(1)?;
        after_ms += 1;
    }
    let code = bench.ecu.code();
    bench.order((), "heal")?;
    // The plate comes to lie at limp-home, and the filters behind the tracks.
    bench.wait(RECOVERY)?;
    bench.ecu.clear();
    bench.press(RAMP);
    bench.wait(RECOVERY)?;
    Ok(Found {
        fault,
        code,
        after_ms,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pwm_has_its_duty_and_late_edges_in_their_order() {
        for frequency in FREQUENCIES {
            let period = 1e9 / frequency;
            let mut pwm = Pwm::new(frequency, 0);
            let end = (100.0 * period) as u64;
            let mut edges = Vec::new();
            for until in (0..=end).step_by(LOOK as usize) {
                edges.extend(pwm.edges(Some(-0.3), until));
            }
            assert!(edges.is_sorted_by_key(|edge| edge.0));
            let levels = |pin| edges.iter().filter(move |edge| edge.1 == pin);
            assert!(levels(pins::DIRECTION).all(|edge| edge.2 == Level::Low));
            assert!(levels(pins::DISABLE).all(|edge| edge.2 == Level::Low));
            let duty: Vec<_> = levels(pins::DUTY).collect();
            assert!(duty.len() > 190, "{frequency}: {}", duty.len());
            for pulse in duty.chunks_exact(2) {
                assert_eq!([pulse[0].2, pulse[1].2], [Level::High, Level::Low]);
                let late = (pulse[0].0 as f64).rem_euclid(period).min(period);
                assert!(late <= JITTER * period + 1.0, "{frequency}: {late}");
                let width = (pulse[1].0 - pulse[0].0) as f64;
                assert!((width / period - 0.3).abs() <= JITTER + 1e-3);
            }
        }
    }

    #[test]
    fn a_full_duty_and_none_have_no_edges() {
        let mut pwm = Pwm::new(2e3, 0);
        let levels = |pwm: &mut Pwm, command, until| {
            let edges = pwm.edges(command, until);
            let duty = edges.into_iter().filter(|edge| edge.1 == pins::DUTY);
            duty.map(|edge| edge.2).collect::<Vec<_>>()
        };
        assert_eq!(levels(&mut pwm, Some(1.0), 5_000_000), [Level::High]);
        assert_eq!(levels(&mut pwm, Some(0.0), 10_000_000), [Level::Low]);
        assert_eq!(levels(&mut pwm, None, 15_000_000), []);
    }
}
