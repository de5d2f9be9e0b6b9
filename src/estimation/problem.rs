//! A calibration as a least-squares problem.

use std::cell::RefCell;

use nalgebra::{DMatrix, DVector};

use crate::description::campaign::Campaign;
use crate::least_squares::{EvaluationError, Problem};
use crate::model::Model;
use crate::parameter::Slot;
use crate::prediction::{Linearised, Predictor};

/// One sigma of each residual row (m, rad), as [`Campaign::noise`] says.
pub fn row_sigmas(campaign: &Campaign) -> Vec<f64> {
    let rows = campaign.components();
    let sigmas = campaign.observes.sigmas(&campaign.noise());
    sigmas[..rows].iter().copied().cycle().take(rows * campaign.readings.len()).collect()
}

/// What is known of a parameter before any reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prior {
    /// Position of the parameter among those that are fitted.
    pub column: usize,
    /// Where it is expected, as a change from the start.
    pub expected: f64,
    /// One standard deviation, in the parameter's unit.
    pub sigma: f64,
}

/// Residuals of a campaign in standard deviations, then of the priors, as a function of changes of some parameters (those
/// of the predictor's slots) from a start.
pub struct CampaignProblem<'a> {
    predictor: Predictor<'a>,
    start: Vec<f64>,
    sigmas: Vec<f64>,
    priors: Vec<Prior>,
    buffer: RefCell<Linearised>,
}

impl<'a> CampaignProblem<'a> {
    /// `start` are all values by slot, `sigmas` the standard deviation of each row of the predictor (m, rad).
    pub fn new(predictor: Predictor<'a>, start: &[f64], sigmas: Vec<f64>, priors: Vec<Prior>) -> Self {
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

    pub fn model(&self) -> &Model {
        self.predictor.model
    }

    /// Number of priors, whose rows are the last ones.
    pub fn priors(&self) -> usize {
        self.priors.len()
    }

    /// Rows of the priors, then of each configuration, in their order; none is empty.
    pub fn blocks(&self) -> Vec<Vec<usize>> {
        let campaign = self.predictor.campaign;
        let components = campaign.components();
        let mut blocks: Vec<Vec<usize>> = vec![Vec::new(); 1 + campaign.poses.len()];
        blocks[0].extend(self.predictor.rows()..self.residuals());
        for (index, reading) in campaign.readings.iter().enumerate() {
            blocks[1 + reading.pose].extend(index * components..(index + 1) * components);
        }
        blocks.retain(|rows| !rows.is_empty());
        blocks
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
        for (k, prior) in self.priors.iter().enumerate() {
            residual[rows + k] = (prior.expected - x[prior.column]) / prior.sigma;
        }
        let Some(jacobian) = jacobian else { return Ok(()) };
        jacobian.fill(0.0);
        let width = self.parameters().max(1);
        for (row, (derivatives, sigma)) in found.jacobian.chunks(width).zip(&self.sigmas).enumerate() {
            for (column, derivative) in derivatives.iter().enumerate() {
                jacobian[(row, column)] = -derivative / sigma;
            }
        }
        for (k, prior) in self.priors.iter().enumerate() {
            jacobian[(rows + k, prior.column)] = -1.0 / prior.sigma;
        }
        Ok(())
    }
}
