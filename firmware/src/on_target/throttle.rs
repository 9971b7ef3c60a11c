//! The throttle body: every state of its bridge, every fault, and how fast it rises.

use model_core::plant::bridge::Bridge;
use model_core::plant::potentiometer::TrackFault;
use model_core::plant::rise_time;
use model_core::plant::throttle::{Fault, Side, Throttle};

use super::Findings;
use crate::app::ecu::loopback;
use crate::app::machine::THROTTLE;
use crate::app::timing::PLANT_PERIOD;

/// Supply of the bridge, V.
const SUPPLY: f32 = 12.0;

/// One after the other, each for as long.
const BRIDGES: [Bridge; 6] = [
    Bridge::Drive { duty: 1.0 },
    Bridge::Freewheel,
    Bridge::Drive { duty: -0.7 },
    Bridge::Brake,
    Bridge::Drive { duty: 0.6 },
    Bridge::Freewheel,
];

/// One after the other.
const FAULTS: [Fault; 9] = [
    Fault::Track(Side::First, TrackFault::Open),
    Fault::Track(Side::Second, TrackFault::Stuck),
    Fault::Track(Side::First, TrackFault::Offset(0.3)),
    Fault::Track(Side::Second, TrackFault::Noisy(0.05)),
    Fault::PlateJammed,
    Fault::SpringBroken,
    Fault::FrictionRaised(1.8),
    Fault::MotorOpen,
    Fault::MotorShorted(0.2),
];

/// Steps for which the bridge stays in a state.
const HOLD: usize = 600;

pub(super) fn body(findings: &mut Findings) {
    let settings = loopback::complementary(THROTTLE.plant, loopback::SEED);
    let built = Throttle::build(&settings, PLANT_PERIOD);
    let Some(mut throttle) = findings.sound(built, "the throttle is taken") else {
        return;
    };
    let drive = |throttle: &mut Throttle, findings: &mut Findings| {
        for tick in 0..BRIDGES.len() * HOLD {
            let taken = throttle.step(BRIDGES[tick / HOLD], SUPPLY).is_ok();
            findings.claim(taken, "the bridge's states are taken");
            let state = throttle.state();
            findings.single(state.velocity.value());
            findings.single(state.position.value());
            findings.single(throttle.current());
            for share in throttle.shares() {
                findings.single(share);
            }
        }
    };
    drive(&mut throttle, findings);
    for fault in FAULTS {
        findings.claim(throttle.inject(fault).is_ok(), "the faults are taken");
        drive(&mut throttle, findings);
        throttle.heal();
    }
    for _ in 0..20_000 {
        let taken = throttle.step(Bridge::Freewheel, SUPPLY).is_ok();
        findings.claim(taken, "the bridge is switched off");
    }
    let rest = throttle.state().position.value();
    let is_home = rest == THROTTLE.plant.spring_rest;
    findings.claim(is_home, "without power the plate is at limp-home");
}

pub(super) fn rise(findings: &mut Findings) {
    let plant = &THROTTLE.plant;
    let rise = rise_time::rise_time(plant, SUPPLY, PLANT_PERIOD);
    if let Some(seconds) = findings.sound(rise, "the plate rises") {
        findings.single(seconds);
    }
}
