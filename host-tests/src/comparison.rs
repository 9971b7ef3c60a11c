//! The board against this host: the same experiments, run by the same code, compared to the last bit.

use firmware::app::check;
use firmware::app::experiment::{Evaluation, Experiment};
use firmware::app::memory::Memory;
use firmware::app::refit;

use crate::app_on_host::AppOnHost;
use crate::board_log::{BoardLog, Line, Recording, Sample};

/// One experiment on the board and on this host.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// The experiment's name.
    pub name: &'static str,
    /// Samples compared.
    pub samples: usize,
    /// Bits that differ in them: in time, input, measurements, command and the plant's state.
    pub differing_bits: u32,
    /// The first sample that differs: the board's and the host's.
    pub first: Option<(Sample, Sample)>,
    /// Lines of the evaluation that differ: the board's and the host's.
    pub lines: Vec<(String, String)>,
}

impl Comparison {
    /// Whether nothing differs.
    pub fn is_equal(&self) -> bool {
        self.differing_bits == 0 && self.lines.is_empty()
    }
}

/// Words that begin the lines in which the board says what it makes of a log.
const EVALUATION: [&str; 6] = [
    "refit",
    "check",
    "effect",
    "effect_parameter",
    "unknown",
    "fitted",
];

/// Compares a board's log with a run of the same experiments on this host.
///
/// # Errors
/// A log that is not whole, or that is of other experiments.
pub fn compare(log: &BoardLog, experiments: &[Experiment]) -> Result<Vec<Comparison>, String> {
    let recordings = log.recordings();
    let mut app = AppOnHost::new();
    experiments
        .iter()
        .map(|experiment| {
            let board = recordings
                .iter()
                .find(|recording| recording.name == experiment.name)
                .ok_or_else(|| format!("the board ran no experiment {:?}", experiment.name))?;
            compare_experiment(board, &mut app, experiment)
        })
        .collect()
}

fn compare_experiment(
    board: &Recording,
    app: &mut AppOnHost,
    experiment: &Experiment,
) -> Result<Comparison, String> {
    let name = experiment.name;
    let (samples, _) = app.run(experiment);
    let converters = &experiment.machine.converters;
    let host: Vec<Sample> = samples
        .iter()
        .map(|sample| Sample::new(sample, converters))
        .collect();
    if let Some((before, after)) = board.first_gap() {
        return Err(format!(
            "{name}: samples between {before} and {after} are missing"
        ));
    }
    let received = board.samples().count();
    if received != experiment.steps as usize || host.len() != received {
        return Err(format!(
            "{name}: {received} samples from the board and {} from the host, expected {}",
            host.len(),
            experiment.steps
        ));
    }
    let mut comparison = Comparison {
        name,
        samples: received,
        differing_bits: 0,
        first: None,
        lines: Vec::new(),
    };
    for (board, host) in board.samples().zip(&host) {
        let pairs = board.bits().into_iter().zip(host.bits());
        let differing: u32 = pairs.map(|(a, b)| (a ^ b).count_ones()).sum();
        if differing > 0 {
            comparison.differing_bits += differing;
            comparison.first.get_or_insert((*board, *host));
        }
    }
    let said: Vec<&Line> = board
        .lines
        .iter()
        .filter(|line| EVALUATION.contains(&line.message.split(' ').next().unwrap_or_default()))
        .collect();
    let expected = evaluation(experiment, &app.memory);
    for index in 0..said.len().max(expected.len()) {
        let board = said.get(index).map_or("", |line| &line.message);
        let host = expected.get(index).map_or("", String::as_str);
        if !same(board, host) {
            comparison.lines.push((board.to_owned(), host.to_owned()));
        }
    }
    Ok(comparison)
}

/// Whether two lines have the same words, numbers compared by their bits.
fn same(board: &str, host: &str) -> bool {
    let same_word = |(board, host): (&str, &str)| {
        let number = |word: &str| word.rsplit('=').next()?.parse::<f64>().ok();
        let name = |word: &str| word.split('=').next().map(str::to_owned);
        board == host
            || (name(board) == name(host)
                && number(board)
                    .zip(number(host))
                    .is_some_and(|(a, b)| a.to_bits() == b.to_bits()))
    };
    board.split(' ').count() == host.split(' ').count()
        && board.split(' ').zip(host.split(' ')).all(same_word)
}

/// What the board has to say about a log, in its own format.
fn evaluation(experiment: &Experiment, memory: &Memory) -> Vec<String> {
    let machine = &experiment.machine;
    let log = memory.log(&machine.converters);
    let samples = memory.samples();
    match experiment.evaluation {
        Evaluation::None => Vec::new(),
        Evaluation::Refit => match refit::refit(machine, log) {
            Ok(estimate) => vec![format!(
                "refit parameter=coulomb present={:?} estimate={:?} present_cost={:?} cost={:?} \
                 annealing_evaluations={} golden_section_evaluations={} samples={samples}",
                machine.plant.coulomb.forward,
                estimate.coulomb,
                estimate.present_cost,
                estimate.cost,
                estimate.annealing_evaluations,
                estimate.golden_section_evaluations,
            )],
            Err(_) => Vec::new(),
        },
        Evaluation::Check => match check::check(machine, log) {
            Ok(finding) => check_lines(&finding, samples),
            Err(_) => Vec::new(),
        },
    }
}

fn check_lines(finding: &check::Finding, samples: usize) -> Vec<String> {
    let mut lines = vec![format!(
        "check verdict={} position_rms_before={:?} position_rms_after={:?} simulations={} \
         samples={samples}",
        finding.verdict.name(),
        finding.before,
        finding.after,
        finding.simulations
    )];
    for found in &finding.effects {
        let description = found.effect.id.description();
        lines.push(format!(
            "effect id={} score={:?} p_value={:?}",
            description.id, found.score, found.p_value
        ));
        for ((name, _), value) in found.effect.reported().iter().zip(found.reported) {
            lines.push(format!("effect_parameter name={name} value={value:?}"));
        }
    }
    if let Some(variable) = finding.unknown {
        lines.push(format!("unknown depends_on={variable}"));
    }
    for (parameter, value) in &finding.fitted {
        lines.push(format!("fitted name={} value={value:?}", parameter.name()));
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_compared_by_their_bits() {
        assert!(same("fitted value=1e-7", "fitted value=0.0000001"));
        assert!(!same("fitted value=1e-7", "fitted value=1.0000001e-7"));
        assert!(!same("fitted value=0.0", "fitted value=-0.0"));
        assert!(!same("fitted value=1", "fitted other=1"));
        assert!(!same("effect id=a", "effect id=b"));
        assert!(!same("effect id=a", "effect id=a score=1"));
    }
}
