//! Worlds as a whole; the plant against closed forms is in [`plant`].

use super::{CATALOGUE, Kind, OUTSIDE, World};

#[test]
#[ignore = "a look at many worlds"]
fn look() {
    for index in 0..200 {
        let started = std::time::Instant::now();
        let (world, [log, _]) = World::draw(1, index);
        println!(
            "{index:3} {:14} {:?} {:?} {:?} rate {} rows {} T {:.1} attempts {} sane {} stroke {:.2} sat {:.2} stuck {:.2} {:?} {:.2} s",
            world.kind.name(),
            world.laws.iter().map(|law| law.label()).collect::<Vec<_>>(),
            world.machine.input,
            world.drives[0].kind,
            world.rate,
            world.rows,
            world.rows as f64 / world.rate,
            world.attempts,
            world.sane,
            log.stroke() / (2.0 * world.machine.amplitude),
            log.saturated,
            log.stuck,
            world.sins.names(),
            started.elapsed().as_secs_f64()
        );
    }
    let _ = (CATALOGUE, OUTSIDE, Kind::ALL);
}
