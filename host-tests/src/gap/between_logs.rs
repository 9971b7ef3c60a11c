//! By what the logs of one machine differ among themselves: friction warms, an offset wanders, or a log is of another
//! machine. And what that costs a replay without restarts.

use model_core::effect::{Active, Id, Scope};
use model_core::gap::criterion::{LEAST_APART, LEAST_OFF};
use model_core::gap::fit::{self, Effort, Fit, Target, Variable, Variables};
use model_core::gap::log::Log;
use model_core::gap::model::{Base, Model};
use model_core::gap::replay::{self, Data, Fold};
use model_core::plant::parameters::ParameterError;

use super::answer::listed;
use super::engine::AllCores;
use super::metrics;
use super::outcome::{FreeRunCost, LogDifference, NumberDifference};
use super::spread::informed;
use crate::quantity::decimal;
use model_core::unit::Dimension;

/// What a day, the weather or the motion before may change. They are tried beside what only another machine, load or
/// supply changes.
const WANDERS: [Base; 3] = [Base::Coulomb, Base::Viscous, Base::Resistance];

/// What is the same in all logs of one machine.
const STAYS: [Base; 5] = [
    Base::TorqueConstant,
    Base::Inertia,
    Base::Spring,
    Base::SpringPreload,
    Base::GravityTorque,
];

/// Most numbers of one log that are said to differ: of more, each may stand for the others.
const MOST: usize = 2;

/// A change that a free run's error is told for, as a share of the friction.
const ONE_PERCENT: f32 = 0.01;

/// A step that lowers the cost by less than this share ends a fit: values are told to a tenth of their deviation.
const EFFORT: Effort = Effort {
    steps: 30,
    converged: 1e-5,
};

/// The numbers of a model that a log may have otherwise than the training logs.
pub(super) struct Numbers<'a> {
    /// Fitted to the training logs, with an offset torque among its effects: one of zero where it has none, so that it can be
    /// moved.
    model: Model,
    variables: Vec<Variable>,
    training: &'a Data<'a>,
    rotary: bool,
}

impl<'a> Numbers<'a> {
    /// Of the model that was fitted to the training logs, with what was found.
    pub fn of(model: &Model, training: &'a Data<'a>, scope: &Scope) -> Self {
        let mut model = model.clone();
        let is_offset = |effect: &Active| effect.id == Id::OffsetTorque;
        let there = model.effects.iter().position(is_offset);
        let slot = there.or_else(|| {
            let offset = Active::new(Id::OffsetTorque, [0.0; 3]);
            model.effects.push(offset).ok()?;
            Some(model.effects.len() - 1)
        });
        let base = WANDERS.into_iter().chain(STAYS);
        let mut variables: Vec<Variable> = base
            .filter(|&base| model.get(base) > 0.0)
            .map(|base| Variable::base(&model, base, scope))
            .collect();
        variables.extend(slot.map(|slot| {
            let value = model.effects[slot].values[0];
            Variable::effect(Id::OffsetTorque, slot, 0, value, scope)
        }));
        Self {
            model,
            variables,
            training,
            rotary: scope.rotary,
        }
    }

    /// What a log has otherwise than the training logs, surely and by more than a data sheet would say; `label` is its name, and
    /// `trained_on` whether it is one of them. `trained_rms`: the model's windowed position error on these, rms, rad or m.
    pub fn differences(
        &self,
        log: Log,
        (label, trained_on): (&str, bool),
        trained_rms: f64,
    ) -> Option<LogDifference> {
        let logs = [log];
        let data = Data {
            logs: &logs,
            settings: self.training.settings,
        };
        let mut moved = Variables::new();
        let mut found = None;
        while moved.len() < MOST {
            let Some(next) = self.next(&data, &moved) else {
                break;
            };
            let Some((fit, apart)) = self.apart(&data, &next) else {
                break;
            };
            let is_sure = |(variable, (apart, std)): (&Variable, &(f64, f64))| {
                let least = f64::from(LEAST_OFF) * self.size(variable);
                apart.abs() >= LEAST_APART * std && apart.abs() >= least
            };
            if !next.iter().zip(&apart).all(is_sure) {
                break;
            }
            moved = next;
            found = Some((fit, apart));
        }
        let (fit, apart) = found?;
        let position_rms = |model: &Model| {
            let simulator = model.build(log.period).ok()?;
            Some(replay::total_error(&data, &AllCores, &simulator).position_rms())
        };
        let (without, with) = (position_rms(&self.model)?, position_rms(&fit.model)?);
        // What leaves most of what this log has beyond the training logs is no explanation of it.
        let beyond = |rms: f64| rms * rms - trained_rms * trained_rms;
        if beyond(with) > 0.5 * beyond(without) {
            return None;
        }
        let told = moved.iter().zip(apart);
        let told = told.map(|(variable, (difference, std))| {
            let (name, dimension) = described(variable);
            NumberDifference {
                name: name.to_owned(),
                trained: decimal(variable.get(&self.model)),
                difference,
                std,
                unit: dimension.unit(self.rotary).to_owned(),
            }
        });
        Some(LogDifference {
            log: label.to_owned(),
            trained_on,
            position_rms: without,
            position_rms_with: with,
            numbers: told.collect(),
        })
    }

    /// What a free run of the model on these logs is moved by, rms, where the friction is one percent more, and by an offset of
    /// as much. None without friction.
    ///
    /// # Errors
    /// A parameter of the model outside its range.
    pub fn free_run_costs(&self, data: &Data) -> Result<Vec<FreeRunCost>, ParameterError> {
        let change = ONE_PERCENT * self.model.get(Base::Coulomb);
        let is_told = |variable: &&Variable| match variable.target {
            Target::Base(base) => base == Base::Coulomb,
            _ => true,
        };
        let told = self.variables.iter().filter(|_| change > 0.0);
        told.filter(is_told)
            .map(|variable| {
                let mut moved = self.model.clone();
                variable.set(&mut moved, variable.get(&self.model) + change);
                let (name, dimension) = described(variable);
                Ok(FreeRunCost {
                    name: name.to_owned(),
                    change: decimal(change),
                    unit: dimension.unit(self.rotary).to_owned(),
                    position_rms: metrics::free_runs_apart(data, [&self.model, &moved])?,
                })
            })
            .collect()
    }

    /// The one number that a log follows best with, beside those that are moved already.
    fn next(&self, data: &Data, moved: &Variables) -> Option<Variables> {
        let others = self.variables.iter().filter(|it| !moved.contains(it));
        let tried = others.filter_map(|variable| {
            let mut moved = moved.clone();
            moved.push(*variable).ok()?;
            Some((self.fit(data, &moved)?.cost, moved))
        });
        let best = tried.min_by(|a, b| a.0.total_cmp(&b.0));
        best.map(|(_, moved)| moved)
    }

    /// The fit of these numbers to a log; by how much it has more of each than the training logs, and the standard deviation of
    /// that.
    fn apart(&self, data: &Data, moved: &[Variable]) -> Option<(Fit, Vec<(f64, f64)>)> {
        let here = self.fit(data, moved)?;
        let there = self.fit(self.training, moved)?;
        let own = informed(data, &here.model, moved)?.covariance(moved);
        let trained = informed(self.training, &there.model, moved)?.covariance(moved);
        let apart = moved.iter().enumerate().map(|(place, variable)| {
            let [here, there] = [&here, &there].map(|fit| decimal(variable.get(&fit.model)));
            let variance = own.at(place, place) + trained.at(place, place);
            (here - there, variance.sqrt())
        });
        let apart = apart.collect();
        Some((here, apart))
    }

    /// The model with these numbers fitted to these logs.
    fn fit(&self, data: &Data, moved: &[Variable]) -> Option<Fit> {
        fit::fit(data, &AllCores, (Fold::All, 1), &self.model, moved, EFFORT)
    }

    /// What a share of a difference is one of: of an offset the friction.
    fn size(&self, variable: &Variable) -> f64 {
        f64::from(match variable.target {
            Target::Base(base) => self.model.get(base),
            _ => self.model.get(Base::Coulomb),
        })
    }
}

/// Whether a number is the same in all logs of one machine under one load and supply.
pub(super) fn stays(name: &str) -> bool {
    STAYS.iter().any(|base| base.name() == name)
}

/// Which logs differ, with the verb, and from what: `log b.csv differs from the other training logs`. Of training logs of which none
/// stands out, `the training logs differ among themselves`. `trained`: how many there are.
pub(super) fn who_differs(logs: &[LogDifference], trained: usize) -> Vec<String> {
    let named = |trained_on: bool| -> Vec<&str> {
        let logs = logs.iter().filter(|log| log.trained_on == trained_on);
        logs.map(|log| log.log.as_str()).collect()
    };
    let sentence = |names: &[&str], others: &str| match names.len() {
        0 => None,
        1 => Some(format!("log {} differs from the {others}", names[0])),
        _ => Some(format!("logs {} differ from the {others}", listed(names))),
    };
    let own = odd(logs, trained);
    let among = if own.is_empty() && !named(true).is_empty() {
        Some("the training logs differ among themselves".to_owned())
    } else {
        sentence(&own, "other training logs")
    };
    let others = sentence(&named(false), "training logs");
    among.into_iter().chain(others).collect()
}

/// The training logs that stand out among all of them: those that differ, where they are less than half. The numbers that they are
/// held against are fitted to all logs, so that one odd log makes the others differ too; then those that are off the median of all.
/// None where no log stands out.
pub(super) fn odd(logs: &[LogDifference], trained: usize) -> Vec<&str> {
    let own = || logs.iter().filter(|log| log.trained_on);
    let is_few = |names: &[&str]| !names.is_empty() && 2 * names.len() < trained;
    let differing: Vec<&str> = own().map(|log| log.log.as_str()).collect();
    if is_few(&differing) {
        return differing;
    }
    let Some(first) = own().next().and_then(|log| log.numbers.first()) else {
        return Vec::new();
    };
    let of = |log: &'_ LogDifference| {
        let mut numbers = log.numbers.iter();
        let number = numbers.find(|number| number.name == first.name)?;
        Some((number.difference, number.std))
    };
    // A log that does not differ has what all have together.
    let mut differences: Vec<f64> = own().filter_map(|log| Some(of(log)?.0)).collect();
    differences.resize(trained.max(differences.len()), 0.0);
    differences.sort_by(f64::total_cmp);
    let median = differences[differences.len() / 2];
    let least = f64::from(LEAST_OFF) * first.trained.abs();
    let is_off = |log: &&LogDifference| {
        of(log).is_some_and(|(difference, std)| {
            (difference - median).abs() >= (LEAST_APART * std).max(least)
        })
    };
    let off: Vec<&str> = own().filter(is_off).map(|log| log.log.as_str()).collect();
    if is_few(&off) { off } else { Vec::new() }
}

/// The name of what a variable moves, and what that measures.
fn described(variable: &Variable) -> (&'static str, Dimension) {
    match variable.target {
        Target::Base(base) => (base.name(), base.dimension()),
        _ => (Id::OffsetTorque.description().id, Dimension::Torque),
    }
}
