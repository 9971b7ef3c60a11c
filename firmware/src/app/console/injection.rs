//! The faults of the emulated throttle body, by name.

use model_core::plant::potentiometer::TrackFault;
use model_core::plant::throttle::{Fault, Side};

/// A fault that can be injected.
#[derive(Debug)]
pub struct Injection {
    /// What it is called.
    pub name: &'static str,
    /// The number that goes with it.
    pub value: Option<Bounds>,
    /// The fault; the number counts where there is one.
    pub fault: fn(f32) -> Fault,
}

/// Of the number that goes with a fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Its unit.
    pub unit: &'static str,
    /// Least.
    pub lower: f32,
    /// Most.
    pub upper: f32,
}

const fn bounds(unit: &'static str, lower: f32, upper: f32) -> Option<Bounds> {
    Some(Bounds { unit, lower, upper })
}

const fn injection(
    name: &'static str,
    value: Option<Bounds>,
    fault: fn(f32) -> Fault,
) -> Injection {
    Injection { name, value, fault }
}

/// Off by up to the tracks' reference, 5 V, to either side.
const OFFSET: Option<Bounds> = bounds("V", -5.0, 5.0);

const NOISE: Option<Bounds> = bounds("V", 0.0, 5.0);

/// All of them.
pub static INJECTIONS: [Injection; 17] = [
    injection("plate_jammed", None, |_| Fault::PlateJammed),
    injection("spring_broken", None, |_| Fault::SpringBroken),
    injection(
        "friction_raised",
        bounds("times", 0.0, 1e3),
        Fault::FrictionRaised,
    ),
    injection("motor_open", None, |_| Fault::MotorOpen),
    injection(
        "motor_shorted",
        bounds("ohm", 1e-3, 1.0),
        Fault::MotorShorted,
    ),
    injection("first_track_open", None, |_| first(TrackFault::Open)),
    injection("first_track_shorted_high", None, |_| {
        first(TrackFault::ShortedHigh)
    }),
    injection("first_track_shorted_low", None, |_| {
        first(TrackFault::ShortedLow)
    }),
    injection("first_track_stuck", None, |_| first(TrackFault::Stuck)),
    injection("first_track_offset", OFFSET, |volts| {
        first(TrackFault::Offset(volts))
    }),
    injection("first_track_noisy", NOISE, |volts| {
        first(TrackFault::Noisy(volts))
    }),
    injection("second_track_open", None, |_| second(TrackFault::Open)),
    injection("second_track_shorted_high", None, |_| {
        second(TrackFault::ShortedHigh)
    }),
    injection("second_track_shorted_low", None, |_| {
        second(TrackFault::ShortedLow)
    }),
    injection("second_track_stuck", None, |_| second(TrackFault::Stuck)),
    injection("second_track_offset", OFFSET, |volts| {
        second(TrackFault::Offset(volts))
    }),
    injection("second_track_noisy", NOISE, |volts| {
        second(TrackFault::Noisy(volts))
    }),
];

fn first(fault: TrackFault) -> Fault {
    Fault::Track(Side::First, fault)
}

fn second(fault: TrackFault) -> Fault {
    Fault::Track(Side::Second, fault)
}
