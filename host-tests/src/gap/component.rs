//! What an effect does in a log: component-plus-residual data (partial residuals: Ezekiel 1924).
//!
//! The component is what the fitted effect adds, the partial residual that and what the whole model
//! leaves: what the data say of the effect once everything else is taken out of them.

use std::f32::consts::TAU;

use model_core::effect::Id;
use model_core::effect::learned_map::Kind;
use model_core::gap::model::Model;
use model_core::gap::replay::{Data, Row, Runner};
use model_core::plant::parameters::ParameterError;

use super::metrics::{differentiate, standstill, torque_balance};
use crate::page::series::{bulk, extent};

/// What an effect is shown over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variable {
    /// Measured velocity.
    Velocity,
    /// Measured position.
    Position,
    /// Where it is in a period of the effect, which the log passes several times.
    PositionInPeriod,
    /// Torque or force of the motor.
    MotorTorque,
    /// Its change a second: what a delay shifts.
    TorqueRate,
    /// Time.
    Time,
    /// Travel of the drive since it last turned.
    TravelSinceTurn,
    /// What follows the position and remembers where it has turned.
    Deflection,
    /// Acceleration of the drive.
    Acceleration,
}

/// What is shown of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Torque or force that it takes.
    Torque,
    /// As friction: positive against the motion.
    Friction,
    /// What the sensor reports beyond the true position.
    Reading,
    /// How far the sensor's side lags behind the drive, positive when trailing.
    LostMotion,
    /// How far it is ahead of the drive, in the direction of the coordinate.
    Twist,
}

/// One effect in one log, sample by sample.
#[derive(Debug, Clone)]
pub struct Component {
    /// The catalogue's id, or [`LEARNED`].
    pub id: String,
    /// What `x` is.
    pub variable: Variable,
    /// What the others are.
    pub quantity: Quantity,
    /// The variable, SI.
    pub x: Vec<f32>,
    /// What the fitted effect adds, SI.
    pub component: Vec<f32>,
    /// That and what the whole model leaves, SI.
    pub partial_residual: Vec<f32>,
}

/// Share of the samples that is shown on either axis: a few spikes would flatten the rest.
pub(super) const SHOWN: f64 = 0.99;

/// Travel behind a turn that is shown, in sizes of the lost motion.
const TRAVEL: f64 = 3.0;

impl Component {
    /// The ends of its variable between which it is shown: where the data are, without rare peaks.
    pub(super) fn ends(&self) -> Option<(f64, f64)> {
        let ends = match self.variable {
            Variable::TravelSinceTurn => {
                let (lowest, highest) = extent(self.component.iter().map(|&y| f64::from(y)))?;
                (0.0, TRAVEL * (highest - lowest))
            }
            _ => bulk(
                &self.x.iter().map(|&x| f64::from(x)).collect::<Vec<_>>(),
                SHOWN,
            )?,
        };
        Some(ends).filter(|(low, high)| high > low)
    }
}

/// What stands for an id where a map was learned.
pub const LEARNED: &str = "learned map";

/// Over what, and as what, an effect shows.
fn view(id: Id) -> (Variable, Quantity) {
    match id {
        Id::Stribeck
        | Id::AsymmetricCoulomb
        | Id::AsymmetricViscous
        | Id::Presliding
        | Id::QuadraticDrag => (Variable::Velocity, Quantity::Torque),
        Id::LoadDependentFriction => (Variable::MotorTorque, Quantity::Friction),
        Id::PositionDependentFriction => (Variable::Position, Quantity::Friction),
        Id::FrictionDrift => (Variable::Time, Quantity::Friction),
        Id::OffsetTorque | Id::Spring | Id::Gravity | Id::Cogging => {
            (Variable::Position, Quantity::Torque)
        }
        Id::ExternalLoad => (Variable::Time, Quantity::Torque),
        Id::SupplySag | Id::BrushDrop | Id::DeadTime | Id::TorqueSaturation | Id::ThermalDrift => {
            (Variable::MotorTorque, Quantity::Torque)
        }
        Id::InputDelay | Id::SensorDelay => (Variable::TorqueRate, Quantity::Torque),
        Id::EncoderEccentricity => (Variable::Position, Quantity::Reading),
        Id::Backlash => (Variable::TravelSinceTurn, Quantity::LostMotion),
        Id::Compliance => (Variable::Acceleration, Quantity::Twist),
        Id::Hysteresis => (Variable::Deflection, Quantity::Torque),
    }
}

/// Over what a learned map shows, and as what.
fn view_of_map(kind: Kind) -> (Variable, Quantity) {
    let variable = match kind {
        Kind::PositionTorque | Kind::PositionFriction => Variable::Position,
        Kind::VelocityTorque | Kind::SpeedFriction => Variable::Velocity,
        Kind::CurrentTorque | Kind::LoadFriction => Variable::MotorTorque,
        Kind::TimeTorque | Kind::TimeFriction => Variable::Time,
    };
    let quantity = if kind.is_friction() {
        Quantity::Friction
    } else {
        Quantity::Torque
    };
    (variable, quantity)
}

/// Periods in the stroke from which they are laid over each other.
const FOLDED: f64 = 2.0;

/// Entries of the torque balance on either side of a turn or a standstill that are left out: there its
/// filters smear friction, which changes its sign, over what the effect does.
const SMEARED: usize = 2;

/// Every effect of a model that the declared one has not, and what was learned, in one log.
///
/// # Errors
/// A parameter of the model outside its range.
pub(super) fn components(
    data: &Data,
    log: usize,
    declared: &Model,
    model: &Model,
) -> Result<Vec<Component>, ParameterError> {
    let found = model.effects.iter().map(|effect| effect.id);
    let effects = found.filter(|&id| !declared.has(id)).map(|id| {
        let (mut variable, quantity) = view(id);
        let (mut x, component, partial_residual) = match quantity {
            Quantity::Torque | Quantity::Friction => {
                let mut without = model.clone();
                without.effects.retain(|effect| effect.id != id);
                of_torque(data, log, [model, &without], (variable, quantity))?
            }
            Quantity::Reading | Quantity::LostMotion | Quantity::Twist => {
                of_position(data, log, model, quantity)?
            }
        };
        let period = period_of(model, id).filter(|_| variable == Variable::Position);
        let ends = extent(x.iter().map(|&x| f64::from(x))).unwrap_or_default();
        let passes = |period: &f32| ends.1 - ends.0 > FOLDED * f64::from(*period);
        if let Some(period) = period.filter(passes) {
            variable = Variable::PositionInPeriod;
            for x in &mut x {
                *x = x.rem_euclid(period);
            }
        }
        Ok(Component {
            id: id.description().id.to_owned(),
            variable,
            quantity,
            x,
            component,
            partial_residual,
        })
    });
    let learned = model.map.map(|map| {
        let (variable, quantity) = view_of_map(map.kind);
        let without = Model {
            map: None,
            current_sensor: Default::default(),
            input_lead: 0.0,
            ..model.clone()
        };
        let (x, component, partial_residual) =
            of_torque(data, log, [model, &without], (variable, quantity))?;
        Ok(Component {
            id: LEARNED.to_owned(),
            variable,
            quantity,
            x,
            component,
            partial_residual,
        })
    });
    effects.chain(learned).collect()
}

/// Period of an effect that is periodic in position, rad or m.
fn period_of(model: &Model, id: Id) -> Option<f32> {
    if id == Id::Gravity {
        return Some(TAU);
    }
    let parameters = id.description().parameters;
    let index = parameters.iter().position(|it| it.name == "period")?;
    let effect = model.effects.iter().find(|effect| effect.id == id)?;
    effect.values.get(index).copied()
}

/// Variable, component and partial residual.
type Columns = (Vec<f32>, Vec<f32>, Vec<f32>);

/// From the torque balance of the model with and without what is shown.
fn of_torque(
    data: &Data,
    log: usize,
    [model, without]: [&Model; 2],
    (variable, quantity): (Variable, Quantity),
) -> Result<Columns, ParameterError> {
    let (log, resolution) = (&data.logs[log], f64::from(data.settings.resolution));
    let whole = torque_balance(log, model, resolution)?;
    let partial = torque_balance(log, without, resolution)?;
    let period = f64::from(log.period);
    let standstill = standstill(log, resolution);
    let time = |entry: usize| whole.sample[entry] as f64 * period;
    let entries = whole.sample.len();
    let rate = if entries > 1 {
        differentiate(&whole.torque, time(1) - time(0))
    } else {
        vec![0.0; entries]
    };
    let moves = |entry: usize| {
        let direction = whole.velocity[entry].signum();
        let near = entry.saturating_sub(SMEARED)..(entry + SMEARED + 1).min(entries);
        whole.velocity[near]
            .iter()
            .all(|velocity| velocity * direction > standstill)
    };
    let moving: Vec<usize> = (0..entries).filter(|&entry| moves(entry)).collect();
    let sign = |entry: usize| match quantity {
        Quantity::Friction => whole.velocity[entry].signum(),
        _ => 1.0,
    };
    let column = |value: &dyn Fn(usize) -> f64| -> Vec<f32> {
        moving.iter().map(|&entry| value(entry) as f32).collect()
    };
    let x = column(&|entry| match variable {
        Variable::Velocity => whole.velocity[entry],
        Variable::Position
        | Variable::PositionInPeriod
        | Variable::TravelSinceTurn
        | Variable::Acceleration => whole.position[entry],
        Variable::Deflection => whole.deflection[entry],
        Variable::MotorTorque => whole.torque[entry],
        Variable::TorqueRate => rate[entry],
        Variable::Time => time(entry),
    });
    let component =
        column(&|entry| sign(entry) * (partial.residual[entry] - whole.residual[entry]));
    let partial_residual = column(&|entry| sign(entry) * partial.residual[entry]);
    Ok((x, component, partial_residual))
}

/// From the windowed replay, whose drive's position stands for the true one.
fn of_position(
    data: &Data,
    log: usize,
    model: &Model,
    quantity: Quantity,
) -> Result<Columns, ParameterError> {
    let series = &data.logs[log];
    let simulator = model.build(series.period)?;
    let (mut x, mut component, mut partial_residual) = (Vec::new(), Vec::new(), Vec::new());
    let windows = (0..data.windows()).filter_map(|number| data.window(number));
    for window in windows.filter(|window| window.log == log) {
        let mut runner = Runner::new(&simulator, series, window.start, &data.settings);
        let mut since_turn: Option<f32> = None;
        let (mut direction, mut last) = (0.0, runner.drive());
        let mut speed = runner.drive_velocity();
        for index in window.start..window.start + data.settings.window {
            runner.advance(&Row::new(series, index));
            let (drive, measured) = (runner.drive(), series.position.at(index + 1));
            let step = drive - last;
            last = drive;
            match quantity {
                Quantity::LostMotion => {
                    if step * direction < 0.0 {
                        since_turn = Some(0.0);
                    }
                    if step != 0.0 {
                        direction = step.signum();
                    }
                    if let Some(travel) = &mut since_turn {
                        *travel += step.abs();
                        x.push(*travel);
                        component.push(direction * (drive - runner.reported()));
                        partial_residual.push(direction * (drive - measured));
                    }
                }
                Quantity::Twist => {
                    let before = std::mem::replace(&mut speed, runner.drive_velocity());
                    x.push((speed - before) / series.period);
                    component.push(runner.reported() - drive);
                    partial_residual.push(measured - drive);
                }
                _ => {
                    x.push(drive);
                    component.push(runner.reported() - drive);
                    partial_residual.push(measured - drive);
                }
            }
        }
    }
    Ok((x, component, partial_residual))
}
