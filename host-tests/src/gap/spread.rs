//! How surely the numbers of the answer are known.

use std::f64::consts::TAU;

use model_core::gap::covariance::{Covariance, Information};
use model_core::gap::current_sensor::Reading;
use model_core::gap::fit::{self, Effort, Target, Variable, Variables, variables};
use model_core::gap::lengths::half_and_twice;
use model_core::gap::model::{Base, Model};
use model_core::gap::replay::{self, Data, Fold};
use model_core::gap::verdict::Trace;
use model_core::gap::workbench::Options;
use model_core::unit::Dimension;

use super::engine::AllCores;
use crate::machine::Machine;

/// How far a number is moved to see what the others do with it, in its scales: far beyond what sensitivities are taken over,
/// and near enough for what it is the tangent of.
const MOVED: f64 = 0.1;

/// Effort of the fit of the others.
const EFFORT: Effort = Effort {
    steps: 30,
    converged: 1e-6,
};

/// Numbers of a winding, which give torques their scale.
pub(super) const WINDING: [Base; 2] = [Base::Resistance, Base::TorqueConstant];

/// What the final fit has moved, and how surely.
pub(super) struct Spread {
    variables: Variables,
    covariance: Covariance,
}

impl Spread {
    /// Of the final fit, with the data as the tracing weighed it in the end.
    pub fn new(trace: &Trace, data: &Data, declared: &Model, known: &Known) -> Option<Self> {
        let moved = (&trace.base[..], &trace.readings[..]);
        Self::of(&trace.after.model, moved, data, declared, known)
    }

    /// Of the fit that has moved these numbers to the model.
    pub fn of(
        model: &Model,
        moved: (&[Base], &[Reading]),
        data: &Data,
        declared: &Model,
        known: &Known,
    ) -> Option<Self> {
        let variables = variables(declared, model, moved, &known.options.scope);
        let mut information = informed(data, model, &variables)?;
        profile(
            &mut information,
            (data, model),
            (&variables, declared),
            known,
        )?;
        let covariance = information.covariance(&variables);
        Some(Self {
            variables,
            covariance,
        })
    }
}

/// What logs say of the variables of a fit, by the windows, by other restarts and over other lengths.
pub(super) fn informed(data: &Data, model: &Model, variables: &[Variable]) -> Option<Information> {
    let mut information = Information::default();
    information.gather(data, &AllCores, model, variables)?;
    for others in [data.with_neighbouring_restarts(), half_and_twice(data)] {
        information.allow_for_others(&others, &AllCores, model, variables)?;
    }
    Some(information)
}

/// What is known of the declared numbers.
pub(super) struct Known<'a> {
    /// Of those that are fitted.
    options: &'a Options<'a>,
    /// By what factor those of the winding may be off that are not, a standard deviation of their logarithm.
    held: Vec<(Base, f64)>,
}

impl<'a> Known<'a> {
    /// By the options of a tracing and by the tolerances of a machine file.
    pub fn of(machine: &Machine, options: &'a Options<'a>) -> Self {
        let held = WINDING.into_iter().filter_map(|base| {
            let tolerance = machine.tolerances.get(base.name())?;
            (!machine.fits(base.name())).then_some((base, 1.0 + tolerance))
        });
        Self {
            options,
            held: held.collect(),
        }
    }

    /// Names of the numbers of the winding that are not fitted and of which it is known how far they may be off.
    pub fn held(&self) -> Vec<&'static str> {
        self.held.iter().map(|(base, _)| base.name()).collect()
    }

    fn factor_of_held(&self, target: Target) -> Option<f64> {
        let mut held = self.held.iter();
        let own = held.find(|(own, _)| target == Target::Base(*own));
        own.map(|(_, factor)| *factor)
    }

    /// Standard deviation of what a variable is declared as, in its scales, beside what the model has.
    fn error(&self, variable: &Variable, model: &Model) -> f64 {
        match self.factor_of_held(variable.target) {
            Some(factor) => factor.ln(),
            None => self.options.error(variable, variable.get(model)),
        }
    }
}

/// Lets the numbers be as uncertain as the common scale of all torques is, which of a voltage without a current only the
/// winding gives them, fitted or held.
fn profile(
    information: &mut Information,
    logs: (&Data, &Model),
    (variables, declared): (&Variables, &Model),
    known: &Known,
) -> Option<()> {
    let inflation = information.inflation(variables.len());
    for winding in WINDING {
        let target = Target::Base(winding);
        let is_held = known.factor_of_held(target).is_some();
        let mut all = variables.clone();
        let place = match variables.iter().position(|it| it.target == target) {
            Some(place) => place,
            None if is_held => {
                let held = Variable::base(declared, winding, &known.options.scope);
                if all.push(held).is_err() {
                    continue;
                }
                variables.len()
            }
            None => continue,
        };
        let direction = scale_of_torques(logs.1, &all, winding);
        let along = (&all, (place, &direction[..]));
        allow_for_direction(
            (information, inflation, variables.len()),
            logs,
            along,
            known,
        )?;
    }
    Some(())
}

/// By what each variable goes with a number of the winding, as a share of itself: the motor's torque is in proportion to the
/// torque constant, and to one over the resistance.
fn scale_of_torques(model: &Model, variables: &Variables, winding: Base) -> Vec<f64> {
    let torques = match winding {
        Base::Resistance => -1.0,
        _ => 1.0,
    };
    let share = |variable: &Variable| match variable.target {
        Target::Base(base) if base == winding => 1.0,
        Target::Base(Base::Resistance | Base::TorqueConstant) => 0.0,
        Target::Base(base) if base == Base::Inertia || base.dimension().has_torque() => torques,
        _ => 0.0,
    };
    let moved = |variable: &Variable| share(variable) * value(variable, model);
    variables.iter().map(moved).collect()
}

/// A number in its scales.
fn value(variable: &Variable, model: &Model) -> f64 {
    f64::from(variable.get(model)) / f64::from(variable.scale)
}

/// Lets the numbers be as uncertain as this direction is.
///
/// Of a voltage without a current, torque constant, inertia and friction have a common scale that the log hardly shows. Then
/// sensitivities, which are taken over a percent of a number, are off by more than what determines that scale, and the
/// covariance from them knows it a thousand times too well. So one number is moved by a tenth, the others are fitted anew, and
/// the cost of that, with what is known of the declared values, says how far it may be off: the profile of the likelihood
/// (W. Q. Meeker, L. A. Escobar, *Teaching about approximate confidence regions based on maximum likelihood estimation*,
/// The American Statistician 49 (1995) 48–53).
fn allow_for_direction(
    (information, inflation, fitted): (&mut Information, f64, usize),
    (data, model): (&Data, &Model),
    (variables, (place, direction)): (&Variables, (usize, &[f64])),
    known: &Known,
) -> Option<()> {
    let errors: Vec<f64> = variables.iter().map(|it| known.error(it, model)).collect();
    let mut others = variables.clone();
    others.remove(place);
    let all = (Fold::All, 1);
    let cost = |model: &Model| {
        let simulator = model.build(data.logs.first()?.period).ok()?;
        Some(replay::cost(data, &AllCores, all, &simulator).0)
    };
    let least = cost(model)?;
    // Either way, for on one side of it another number may be at its bound.
    let beside = [MOVED, -MOVED].into_iter().filter_map(|step| {
        let mut start = model.clone();
        for (variable, along) in variables.iter().zip(direction) {
            let moved = (value(variable, model) + step * along / direction[place]) as f32;
            variable.set(&mut start, variable.within_bounds(moved * variable.scale));
        }
        // One that leaves the plant's range says nothing.
        let beside = fit::fit(data, &AllCores, all, &start, &others, EFFORT)?.model;
        Some((cost(&beside)? - least, beside))
    });
    let Some((cost, beside)) = beside.min_by(|a, b| a.0.total_cmp(&b.0)) else {
        return Some(());
    };
    let gone = |variable: &Variable| value(variable, &beside) - value(variable, model);
    let moved = gone(&variables[place]);
    let with: Vec<f64> = variables.iter().map(|it| gone(it) / moved).collect();
    let by_log = cost.max(0.0) / (moved * moved) / inflation;
    let known = with.iter().zip(&errors).filter(|(_, error)| **error > 0.0);
    let by_declaration: f64 = known.map(|(with, error)| (with / error).powi(2)).sum();
    // What the sensitivities know of a fitted one is in the covariance already.
    let before = if place < fitted {
        information.variance(place)
    } else {
        0.0
    };
    let variance = 1.0 / (by_log + by_declaration);
    information.allow_for(&with[..fitted], variance - before);
    Some(())
}

/// Standard deviations of functions of the fitted model, by linear propagation of the covariance.
/// `dimensions`: what the functions measure.
pub(super) fn propagate<const N: usize>(
    model: &Model,
    spread: &Spread,
    dimensions: &[Dimension],
    quantity: impl Fn(&Model) -> [f32; N],
) -> [f64; N] {
    let start = quantity(model);
    let slopes: Vec<[f64; N]> = spread
        .variables
        .iter()
        .map(|variable| {
            let mut moved = model.clone();
            let step = 0.01 * variable.scale;
            variable.set(&mut moved, variable.get(model) + step);
            let end = quantity(&moved);
            std::array::from_fn(|index| {
                let mut change = f64::from(end[index] - start[index]);
                if dimensions.get(index) == Some(&Dimension::Phase) {
                    // A phase may step across ±π.
                    change -= TAU * (change / TAU).round();
                }
                change / f64::from(step)
            })
        })
        .collect();
    std::array::from_fn(|index| {
        let mut variance = 0.0;
        for (row, a) in slopes.iter().enumerate() {
            for (column, b) in slopes.iter().enumerate() {
                let product = a[index] * b[index];
                if product != 0.0 {
                    variance += product * spread.covariance.at(row, column);
                }
            }
        }
        variance.max(0.0).sqrt()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::declared;
    use crate::workspace;
    use model_core::effect::{Active, Id, Scope};

    /// A cogging of amplitude A whose two components have independent errors of standard deviation
    /// σ has σ of its amplitude and σ/A of its phase, wherever the phase lies.
    #[test]
    fn a_phase_is_as_certain_at_pi_as_elsewhere() {
        let file = workspace::root().join("host-tests/machines/emps.toml");
        let declared = declared::model(&Machine::read(&file).unwrap()).unwrap();
        let mut model = declared.clone();
        let scope = Scope {
            friction: 20.0,
            torque: 30.0,
            voltage: 1.0,
            current: 30.0,
            speed: 0.1,
            stroke: 0.2,
            period: 1e-3,
            seconds: 10.0,
            rotary: false,
            encoder_turn: f32::INFINITY,
        };
        let amplitude = 40.0_f32;
        for phase in [-3.139, -1.0, 0.0, 2.0, 3.139_f32] {
            let values = [amplitude * phase.cos(), amplitude * phase.sin(), 0.05];
            model.effects = [Active::new(Id::Cogging, values)].into_iter().collect();
            let dimensions = [Dimension::Torque, Dimension::Phase, Dimension::Position];
            let report = |model: &Model| model.effects[0].report(&model.plant);
            let variables = variables(&declared, &model, (&[], &[]), &scope);
            // A variable's standard deviation is its scale: here the friction.
            let mut covariance = Covariance::default();
            for (index, variable) in variables.iter().enumerate() {
                covariance.row_mut(index)[index] = f64::from(variable.scale * variable.scale);
            }
            let spread = Spread {
                variables,
                covariance,
            };
            let [of_amplitude, of_phase, ..] = propagate(&model, &spread, &dimensions, report);
            assert!(
                (of_amplitude / 20.0 - 1.0).abs() < 0.02,
                "{phase}: {of_amplitude} N"
            );
            assert!(
                (of_phase / 0.5 - 1.0).abs() < 0.02,
                "{phase}: {of_phase} rad"
            );
        }
    }
}
