//! A calibration as a least-squares problem.

use std::cell::RefCell;

use nalgebra::{DMatrix, DVector};

use crate::description::campaign::Campaign;
use crate::least_squares::{EvaluationError, Problem};
use crate::parameter::Slot;
use crate::prediction::{Linearised, Predictor};

/// One sigma of each residual row (m, rad), as [`Campaign::noise`] says.
pub fn row_sigmas(campaign: &Campaign) -> Vec<f64> {
    let rows = campaign.components();
    let sigmas = campaign.observes.sigmas(&campaign.noise());
    sigmas[..rows].iter().copied().cycle().take(rows * campaign.readings.len()).collect()
}

/// Residuals over their sigmas as a function of the changes of some parameters from a start.
pub struct CampaignProblem<'a> {
    predictor: Predictor<'a>,
    start: Vec<f64>,
    sigmas: Vec<f64>,
    /// Prior of each parameter: where it is expected, as a change from the start, and one sigma.
    priors: Vec<(f64, f64)>,
    buffer: RefCell<Linearised>,
}

impl<'a> CampaignProblem<'a> {
    /// The parameters are those of the predictor's slots; `priors` is empty or has one for each.
    pub fn new(predictor: Predictor<'a>, start: &[f64], sigmas: Vec<f64>, priors: Vec<(f64, f64)>) -> Self {
        Self { predictor, start: start.to_vec(), sigmas, priors, buffer: RefCell::default() }
    }

    /// All values at the changes `x`.
    pub fn values(&self, x: &[f64]) -> Vec<f64> {
        let mut values = self.start.clone();
        for (&slot, change) in self.slots().iter().zip(x) {
            values[slot] += change;
        }
        values
    }

    pub fn slots(&self) -> &[Slot] {
        &self.predictor.slots
    }
}

impl Problem for CampaignProblem<'_> {
    fn parameters(&self) -> usize {
        self.predictor.slots.len()
    }

    fn residuals(&self) -> usize {
        self.predictor.rows() + self.priors.len()
    }

    fn evaluate(
        &self,
        x: &[f64],
        residual: &mut DVector<f64>,
        jacobian: Option<&mut DMatrix<f64>>,
    ) -> Result<(), EvaluationError> {
        let values = self.values(x);
        let mut found = self.buffer.borrow_mut();
        let predicted = self.predictor.linearise(&values, jacobian.is_some(), &mut found);
        predicted.map_err(|error| EvaluationError(error.to_string()))?;
        let rows = self.predictor.rows();
        for (row, sigma) in self.sigmas.iter().enumerate() {
            residual[row] = found.residual[row] / sigma;
        }
        for (k, (expected, sigma)) in self.priors.iter().enumerate() {
            residual[rows + k] = (expected - x[k]) / sigma;
        }
        if let Some(jacobian) = jacobian {
            let width = self.parameters();
            jacobian.fill(0.0);
            for (row, sigma) in self.sigmas.iter().enumerate() {
                for (column, value) in found.jacobian[row * width..(row + 1) * width].iter().enumerate() {
                    jacobian[(row, column)] = -value / sigma;
                }
            }
            for (k, (_, sigma)) in self.priors.iter().enumerate() {
                jacobian[(rows + k, k)] = -1.0 / sigma;
            }
        }
        Ok(())
    }
}
