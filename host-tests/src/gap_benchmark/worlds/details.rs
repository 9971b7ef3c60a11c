//! One world by itself, in numbers, with its files.

use rig::world::{Record, World};

use super::directory;
use super::traced::{self, Judged, judge_world};
use crate::failure::Failure;
use crate::gap::outcome::Outcome;
use crate::outputs::write_own;
use crate::workspace::shown;

/// Traces a world, leaves its files, and says all that is known of it.
///
/// # Errors
/// Files that cannot be written.
pub(super) fn text(seed: u64, index: u64) -> Result<String, Failure> {
    let (world, records) = World::draw(seed, index);
    let directory = directory();
    let name = traced::name_of(&world);
    let write = |suffix: &str, text: String| {
        let path = directory.join(format!("{name}{suffix}"));
        write_own(&path, text)?;
        Ok::<_, Failure>(path)
    };
    let machine = write(".toml", world.to_toml())?;
    let train = write("-train.csv", records[0].to_csv())?;
    let other = write("-other.csv", records[1].to_csv())?;
    let (judged, found) = judge_world(&world, &records);

    let mut lines = of_world(&world, &records, &judged);
    if let Some(found) = &found {
        lines.extend(of_answer(&world, &judged, &found.report.outcome));
    }
    lines.push(("seconds", format!("{:.2}", judged.seconds)));
    lines.push((
        "try",
        format!(
            "cargo hil gap --machine {} --train {} --validate {}",
            shown(&machine),
            shown(&train),
            shown(&other)
        ),
    ));
    let lines = lines
        .iter()
        .map(|(head, body)| format!("{head:<12}{body}\n"));
    Ok(lines.collect())
}

/// Heads and bodies of lines.
type Lines = Vec<(&'static str, String)>;

/// What the world is, and how it was judged.
fn of_world(world: &World, records: &[Record; 2], judged: &Judged) -> Lines {
    let mut lines = vec![(
        "world",
        format!("{} of seed {}, {}", world.index, world.seed, judged.kind),
    )];
    for law in &world.laws {
        lines.push(("truth", format!("{law:?}")));
    }
    lines.extend([
        ("machine", format!("{:?}", world.machine)),
        ("declared", format!("{:?}", world.declaration)),
        ("drive", format!("{:?}", world.drives[0].kind)),
        ("sensors", format!("{:?}", world.quality)),
        ("logger", format!("{:?}", world.sins)),
        (
            "log",
            format!(
                "{} rows at {} Hz, {:.0} % of them at rest, drive at its limit in {:.1} %",
                world.rows,
                world.rate,
                100.0 * records[0].stuck,
                100.0 * records[0].saturated
            ),
        ),
        (
            "visible",
            format!("{}, told ratio {:?}", judged.visible, judged.told_ratio),
        ),
        ("verdict", judged.verdict.clone()),
        ("said", judged.said()),
        ("judged", format!("{:?}", judged.judgement)),
    ]);
    lines.extend(judged.refused.clone().map(|reason| ("refused", reason)));
    lines
}

/// What the tracing found, looked at, and left.
fn of_answer(world: &World, judged: &Judged, outcome: &Outcome) -> Lines {
    let mut lines = Lines::new();
    for effect in &outcome.effects {
        lines.push(("found", format!("{} {:?}", effect.id, effect.parameters)));
    }
    for fit in &outcome.fit {
        let truth = world.machine.number(&fit.name);
        lines.push(("fit", format!("{fit:?} true {truth:?}")));
    }
    for estimate in outcome.current_sensor.iter().chain(&outcome.input_lead) {
        lines.push(("channel", format!("{estimate:?}")));
    }
    let errors = &outcome.errors.train;
    lines.push((
        "error",
        format!(
            "declared {:.4e}, before {:.4e}, after {:.4e}, over that of the told fit {:?}",
            errors.declared.position_rms,
            errors.before.position_rms,
            errors.after.position_rms,
            judged.after_over_told
        ),
    ));
    for candidate in &outcome.candidates {
        lines.push((
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
        ));
    }
    lines
}
