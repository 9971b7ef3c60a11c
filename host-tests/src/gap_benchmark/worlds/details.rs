//! One world by itself, in numbers, with its files.

use std::fmt::Write;
use std::fs;

use rig::world::World;

use super::directory;
use super::traced::{self, judge_world};
use crate::failure::Failure;
use crate::workspace::shown;

/// Traces a world, leaves its files, and says all that is known of it.
///
/// # Errors
/// Files that cannot be written.
pub(super) fn text(seed: u64, index: u64) -> Result<String, Failure> {
    let (world, records) = World::draw(seed, index);
    let directory = directory()?;
    let name = traced::name_of(&world);
    let write = |suffix: &str, text: String| {
        let path = directory.join(format!("{name}{suffix}"));
        fs::write(&path, text).map_err(|error| Failure::system(path.display(), &error))?;
        Ok::<_, Failure>(path)
    };
    let machine = write(".toml", world.to_toml())?;
    let train = write("-train.csv", records[0].to_csv())?;
    let other = write("-other.csv", records[1].to_csv())?;
    let (judged, found) = judge_world(&world, &records);

    let mut text = String::new();
    let mut line = |head: &str, body: String| {
        writeln!(text, "{head:<12}{body}").expect("a String takes any text");
    };
    line("world", format!("{index} of seed {seed}, {}", judged.kind));
    for law in &world.laws {
        line("truth", format!("{law:?}"));
    }
    line("machine", format!("{:?}", world.machine));
    line("declared", format!("{:?}", world.declaration));
    line("drive", format!("{:?}", world.drives[0].kind));
    line("sensors", format!("{:?}", world.quality));
    line("logger", format!("{:?}", world.sins));
    line(
        "log",
        format!(
            "{} rows at {} Hz, {:.0} % of them at rest, drive at its limit in {:.1} %",
            world.rows,
            world.rate,
            100.0 * records[0].stuck,
            100.0 * records[0].saturated
        ),
    );
    line(
        "visible",
        format!("{}, told ratio {:?}", judged.visible, judged.told_ratio),
    );
    line("verdict", judged.verdict.clone());
    line("said", judged.said());
    line("judged", format!("{:?}", judged.judgement));
    if let Some(reason) = &judged.refused {
        line("refused", reason.clone());
    }
    if let Some(found) = found {
        let outcome = &found.report.outcome;
        for effect in &outcome.effects {
            line("found", format!("{} {:?}", effect.id, effect.parameters));
        }
        for fit in &outcome.fit {
            line(
                "fit",
                format!("{fit:?} true {:?}", world.machine.number(&fit.name)),
            );
        }
        let errors = &outcome.errors.train;
        line(
            "error",
            format!(
                "declared {:.4e}, before {:.4e}, after {:.4e}, over that of the told fit {:?}",
                errors.declared.position_rms,
                errors.before.position_rms,
                errors.after.position_rms,
                judged.after_over_told
            ),
        );
        for candidate in &outcome.candidates {
            line(
                "candidate",
                format!(
                    "round {} {:<28} score {:.3} identifiability {:.3} ratio {:?} p {:?}: {}",
                    candidate.round,
                    candidate.id,
                    candidate.score,
                    candidate.identifiability,
                    candidate.held_out_ratio,
                    candidate.p_value,
                    candidate.reason
                ),
            );
        }
    }
    line("seconds", format!("{:.2}", judged.seconds));
    line(
        "try",
        format!(
            "cargo hil gap --machine {} --train {} --validate {}",
            shown(&machine),
            shown(&train),
            shown(&other)
        ),
    );
    Ok(text)
}
