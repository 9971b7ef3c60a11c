//! The loop for ten minutes with nothing wrong.

use serde::Serialize;

use super::{Call, Consoles, Counted, MILLISECOND, Side, pair};
use crate::random::Random;

/// Virtual time that it is driven for, ns.
const DURATION: u64 = 600_000 * MILLISECOND;

/// What came of it.
#[derive(Debug, Serialize)]
pub(super) struct Healthy {
    /// Commands that it followed.
    commands: usize,
    /// Each `status` that did not say that nothing is latched, behind its command.
    unsound: Vec<String>,
    controller: Counted,
    throttle: Counted,
}

/// Drives the throttle by steps, sweeps and triangles anywhere within its stroke, captures sent in between.
pub(super) fn healthy(call: &Call) -> Result<Healthy, String> {
    let mut pair = pair::armed(call)?;
    let mut random = Random(0x9e37_79b9);
    let mut commands = 0;
    let mut unsound = Vec::new();
    let end = pair.controller.now() + DURATION;
    while pair.controller.now() < end {
        let command = command(&mut random);
        pair.order(Side::Controller, &command)?;
        commands += 1;
        if random.below(8) == 0 {
            pair::capture(&mut pair)?;
        } else {
            pair.run_for((200 + random.below(2000)) * MILLISECOND)?;
        }
        for side in [Side::Controller, Side::Throttle] {
            let status = pair.ask(side, "status")?;
            if !status.lines().any(|line| line == "latched: none") {
                unsound.push(format!("{command}: {status}"));
            }
        }
        if !unsound.is_empty() {
            break;
        }
    }
    let [controller, throttle] = [&pair.controller, &pair.throttle]
        .map(|running| Counted::new(&running.outputs.counts, running.now()));
    Ok(Healthy {
        commands,
        unsound,
        controller,
        throttle,
    })
}

/// A command within the stroke, which is −0.18 to 1.37 rad, and within what the winding bears for ever.
fn command(random: &mut Random) -> String {
    match random.below(3) {
        0 => {
            let target = random.between(-0.1, 1.25);
            format!("step {target:.2} {target:.2}")
        }
        1 => {
            let (middle, amplitude) = (random.between(0.3, 0.9), random.between(0.05, 0.3));
            format!("sweep {middle:.2} {amplitude:.2} 0.3 2 5")
        }
        _ => {
            let (middle, amplitude) = (random.between(0.3, 0.9), random.between(0.05, 0.35));
            let frequency = random.between(0.2, 1.2);
            format!("triangle {middle:.2} {amplitude:.2} {frequency:.2}")
        }
    }
}
