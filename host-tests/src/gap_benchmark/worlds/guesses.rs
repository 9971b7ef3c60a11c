//! Whether an answer depends on what the machine file guesses of the numbers that `[fit]` names.

use rig::world::{Record, World};
use serde::Serialize;

use super::traced::{log_of, machine_of};
use crate::failure::Failure;
use crate::gap::engine;
use crate::gap_benchmark::judgement::Answer;

/// Other guesses for each world.
const TURNS: u64 = 2;

/// What is said of the same log with other guesses.
#[derive(Debug, Clone, Serialize)]
pub struct Guessed {
    /// Declared over true value of what is not declared as it is.
    pub factors: Vec<(&'static str, f64)>,
    /// The verdict; the refusal, if there is none.
    pub verdict: String,
    /// What was said.
    pub answer: Answer,
    /// Whether the verdict and all names are those of the first answer.
    pub same: bool,
}

/// Traces the log of a world with other guesses. `first`: the verdict and the answer with the world's own.
pub fn ask(world: &World, records: &[Record; 2], first: (&str, &Answer)) -> Vec<Guessed> {
    (0..TURNS)
        .map(|turn| {
            let guessed = world.guessed(turn);
            let (verdict, answer) = match trace(&guessed, records) {
                Ok(said) => said,
                Err(refused) => (refused.to_string(), Answer::default()),
            };
            Guessed {
                factors: guessed.declaration.factors,
                same: verdict == first.0 && sorted(&answer) == sorted(first.1),
                verdict,
                answer,
            }
        })
        .collect()
}

/// An answer, its names in alphabetical order: which of two that cannot be told apart comes first is no difference.
fn sorted(answer: &Answer) -> Answer {
    let mut sorted = answer.clone();
    for class in &mut sorted.named {
        class.sort_unstable();
    }
    sorted.named.sort_unstable();
    sorted.freed.sort_unstable();
    sorted
}

fn trace(world: &World, records: &[Record; 2]) -> Result<(String, Answer), Failure> {
    let train = [log_of(world, &records[0], 0)?];
    let machine = machine_of(world)?;
    let outcome = engine::run(&machine, &train, || Ok(Vec::new()), |_| ())?.outcome;
    Ok((outcome.verdict.name().to_owned(), Answer::of(&outcome)))
}
