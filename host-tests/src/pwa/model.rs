//! The model in double precision, as the identification changes it.

use model_core::numeric::invalid_parameter::InvalidParameter;
use model_core::plant::piecewise_affine::{self as core_model, PiecewiseAffine};

use super::sampled::Sampled;

/// Numbers of a regressor and of an affine function of it: position, its change, input, one.
pub const REGRESSORS: usize = 4;

/// An affine function of the regressor.
pub type Affine = [f64; REGRESSORS];

/// Its value.
pub fn value(affine: &Affine, regressor: &Affine) -> f64 {
    affine.iter().zip(regressor).map(|(a, x)| a * x).sum()
}

/// A model: cell `i` is where `partition[i]` is largest, and there the position grows by
/// `submodels[i]` in a period.
#[derive(Debug, Clone, PartialEq)]
pub struct Cells {
    /// A function a cell.
    pub partition: Vec<Affine>,
    /// Change of the position in a period, a function a cell.
    pub submodels: Vec<Affine>,
    /// Lower and upper limit of the position.
    pub limits: (f64, f64),
}

impl Cells {
    /// The cell that a regressor lies in, the first of equals.
    pub fn cell(&self, regressor: &Affine) -> usize {
        let mut best = (0, f64::NEG_INFINITY);
        for (index, affine) in self.partition.iter().enumerate() {
            let value = value(affine, regressor);
            if value > best.1 {
                best = (index, value);
            }
        }
        best.0
    }

    /// Free run from the first position at rest: a position for each of the log's. `observe` gets
    /// regressor, cell and whether the position is held at a limit, at each period.
    pub fn run(&self, log: &Sampled, mut observe: impl FnMut(f64, &Affine, usize, bool)) {
        let (lower, upper) = self.limits;
        let mut position = log.position[0];
        let mut before = position;
        for &input in &log.input {
            let regressor = [position, position - before, input, 1.0];
            let cell = self.cell(&regressor);
            let free = position + value(&self.submodels[cell], &regressor);
            before = position;
            position = free.clamp(lower, upper);
            observe(position, &regressor, cell, position != free);
        }
    }

    /// Sum of the squared errors of a free run over the logs.
    pub fn cost(&self, logs: &[Sampled]) -> f64 {
        let mut sum = 0.0;
        for log in logs {
            let mut measured = log.position[1..].iter();
            self.run(log, |position, _, _, _| {
                let error = position - measured.next().expect("as many as inputs");
                sum += error * error;
            });
        }
        sum
    }

    /// As the core evaluates it, at this period in s.
    ///
    /// Only differences of the partition's functions count, and only their signs: their mean is
    /// taken off and the largest coefficient made 1, so that single precision holds them well.
    ///
    /// # Errors
    /// A number that the core does not take.
    pub fn build(&self, period: f64) -> Result<PiecewiseAffine, InvalidParameter> {
        let count = self.partition.len() as f64;
        let mut partition = self.partition.clone();
        for i in 0..REGRESSORS {
            let mean = partition.iter().map(|region| region[i]).sum::<f64>() / count;
            for region in &mut partition {
                region[i] -= mean;
            }
        }
        let coefficients = partition.iter().flatten();
        let largest = coefficients.fold(0.0_f64, |most, c| most.max(c.abs()));
        let largest = if largest > 0.0 { largest } else { 1.0 };
        let core = |affine: &Affine| core_model::Affine {
            position: affine[0] as f32,
            change: affine[1] as f32,
            input: affine[2] as f32,
            constant: affine[3] as f32,
        };
        let cells = partition.iter().zip(&self.submodels);
        let cells = cells.map(|(region, growth)| core_model::Cell {
            region: core(&region.map(|coefficient| coefficient / largest)),
            growth: core(growth),
        });
        PiecewiseAffine::build(core_model::Parameters {
            period: period as f32,
            lower_limit: self.limits.0 as f32,
            upper_limit: self.limits.1 as f32,
            cells: cells.collect(),
        })
    }
}
