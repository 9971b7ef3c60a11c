//! Worlds as a whole: the draw, and what a log of one is.

use super::dice::seed_of;
use super::{CATALOGUE, InputKind, Kind, Machine, OUTSIDE, World};
use crate::random::Random;

mod logs;
mod plant;

#[test]
fn a_world_follows_from_its_seed_and_index_alone() {
    let (world, records) = World::draw(3, 5);
    assert_eq!((world.clone(), records), World::draw(3, 5));
    assert_ne!(world.machine, World::draw(3, 6).0.machine);
    assert_ne!(world.machine, World::draw(4, 5).0.machine);
}

#[test]
fn worlds_are_of_every_kind_and_sane() {
    let worlds: Vec<World> = (0..60).map(|index| World::draw(11, index).0).collect();
    for (kind, share) in Kind::ALL {
        let count = worlds.iter().filter(|world| world.kind == kind).count();
        let expected = 60.0 * share;
        // Four standard deviations of a binomial count.
        assert!(
            (count as f64 - expected).abs() < 4.0 * expected.sqrt(),
            "{}: {count}",
            kind.name()
        );
    }
    let sane = worlds.iter().filter(|world| world.sane).count();
    assert!(sane >= 58, "{sane}");
    for world in &worlds {
        assert_eq!(
            world.laws.len(),
            match world.kind {
                Kind::OneEffect | Kind::Outside => 1,
                Kind::TwoEffects => 2,
                _ => 0,
            }
        );
        assert!((2_000..=24_000).contains(&world.rows), "{}", world.rows);
        assert_eq!(
            world.kind == Kind::NoneWithSins,
            world.laws.is_empty() && world.sins.any()
        );
        let wrong_outside = |(name, _): &&(&str, f64)| !world.declaration.fit.contains(name);
        let factors = world.declaration.factors.iter();
        let wrong: Vec<f64> = factors
            .filter(wrong_outside)
            .map(|(_, factor)| *factor)
            .collect();
        assert_eq!(wrong.len(), usize::from(world.kind == Kind::Misdeclared));
        for factor in wrong {
            assert!((0.15..=0.6).contains(&f64::abs(factor - 1.0)), "{factor}");
        }
    }
}

#[test]
fn machines_cover_the_ranges_that_they_are_drawn_from() {
    let mut random = Random::new(seed_of(&[1]));
    let machines: Vec<Machine> = (0..3000)
        .map(|_| Machine::draw(&mut random, 1e3, 8000, 150.0))
        .collect();
    let range = |of: &dyn Fn(&Machine) -> f64, which: &dyn Fn(&Machine) -> bool| {
        let values = machines.iter().filter(|it| which(it)).map(of);
        values.fold((f64::INFINITY, 0.0_f64), |(low, high), value| {
            (low.min(value), high.max(value))
        })
    };
    let (light, heavy) = range(&|it| it.inertia, &|it| !it.linear);
    assert!(heavy / light > 5e3, "{light} to {heavy}");
    let (little, much) = range(&|it| it.coulomb / it.torque, &|_| true);
    assert!((0.01..0.012).contains(&little) && (0.75..=0.8).contains(&much));
    let share = |of: &dyn Fn(&Machine) -> bool| {
        machines.iter().filter(|it| of(it)).count() as f64 / machines.len() as f64
    };
    for (what, low, high) in [
        (share(&|it| it.linear), 0.15, 0.25),
        (share(&|it| it.input == InputKind::Voltage), 0.55, 0.65),
        (share(&|it| it.spring > 0.0), 0.2, 0.3),
        (share(&|it| it.gravity > 0.0), 0.12, 0.2),
        (share(&|it| it.stops.is_some()), 0.25, 0.35),
        (share(&|it| it.gear > 1.0), 0.4, 0.6),
    ] {
        assert!((low..high).contains(&what), "{what} of {low} to {high}");
    }
    for machine in &machines {
        // At its top speed the motor still carries friction, viscous friction and loads.
        let drag = machine.damping() * machine.speed();
        assert!(machine.coulomb + drag + machine.gravity < 1.05 * machine.torque);
        assert!(machine.breakaway >= machine.coulomb);
        // From a watch's motor to a servo of three kilowatts.
        let power = machine.torque * machine.speed();
        assert!((0.019..3.01e3).contains(&power), "{power} W");
        if machine.input == InputKind::Voltage {
            let stall = machine.limit / machine.resistance;
            assert!(stall < 200.0, "{stall} A");
        }
        assert!(2.0 * machine.amplitude / machine.resolution >= 199.0);
    }
}

#[test]
fn every_effect_can_be_drawn() {
    let mut seen = Vec::new();
    for index in 0..400 {
        let mut random = Random::new(seed_of(&[2, index]));
        for kind in [Kind::OneEffect, Kind::TwoEffects, Kind::Outside] {
            seen.extend(super::strength::kinds(&mut random, kind));
        }
    }
    for effect in CATALOGUE.iter().chain(&OUTSIDE) {
        assert!(seen.contains(effect), "{effect}");
    }
}

#[test]
fn numbers_outside_fit_are_declared_as_they_are() {
    for index in 0..30 {
        let (world, _) = World::draw(12, index);
        let text = world.to_toml();
        for name in ["inertia", "viscous", "coulomb", "static"] {
            let line = text
                .lines()
                .find(|line| line.starts_with(&format!("{name} = ")));
            let declared: Option<f64> = line.and_then(|line| line[name.len() + 3..].parse().ok());
            let truth = world.machine.number(name);
            let ratio = declared.zip(truth).map_or(0.0, |(said, is)| said / is);
            if world.misdeclares(name) {
                assert!((0.35..=2.8).contains(&ratio), "{index} {name} {ratio}");
            } else {
                assert_eq!(ratio, 1.0, "{index} {name}");
            }
        }
    }
}
