//! A calibration as a least-squares problem.

use std::cell::{Cell, RefCell};

use nalgebra::{DMatrix, DVector};

use crate::description::campaign::{Campaign, Reading};
use crate::least_squares::{Bounds, EvaluationError, Problem};
use crate::model::Model;
use crate::parameter::{Group, Kind, Slot};
use crate::prediction::{Linearised, Predictor};

/// One sigma of each residual row (m, rad), as its reading says.
pub fn row_sigmas(campaign: &Campaign) -> Vec<f64> {
    let of_reading =
        |reading: &Reading| reading.observes.sigmas(&reading.noise).into_iter().take(reading.observes.rows());
    let of_constraints = campaign.constraints.iter().map(|constraint| constraint.sigma);
    campaign.readings.iter().flat_map(of_reading).chain(of_constraints).collect()
}

/// Of each row of a reading, whether it is a length (0), an angle (1) or a torque (2).
pub fn row_kinds(reading: &Reading) -> impl Iterator<Item = usize> {
    let (lengths, is_load) = (reading.observes.length_rows(), reading.observes.by_variable().is_some());
    (0..reading.observes.rows()).map(move |row| if is_load { 2 } else { usize::from(row >= lengths) })
}

/// Least standard deviation (m, rad) that weights are made of: below the resolution of any instrument, so that simulated
/// readings without noise, whose residuals are rounding, have finite weights.
pub const LEAST_SIGMA: f64 = 1e-9;

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
    /// Parameters whose logarithm is fitted.
    logarithms: Vec<bool>,
    /// By row of a reading.
    kinds: Vec<usize>,
    /// Robust standard deviations of lengths, of angles and of torques, in stated ones.
    scales: Cell<[f64; 3]>,
    /// Norm of the rounding errors of the residuals.
    rounding: f64,
    buffer: RefCell<Linearised>,
}

impl<'a> CampaignProblem<'a> {
    /// `start` are all values by slot, `sigmas` the standard deviation of each row of the predictor (m, rad).
    pub fn new(predictor: Predictor<'a>, start: &[f64], sigmas: Vec<f64>, priors: Vec<Prior>) -> Self {
        Self {
            kinds: predictor.campaign.readings.iter().flat_map(row_kinds).collect(),
            logarithms: vec![false; predictor.slots.len()],
            rounding: rounding(&predictor, start, &sigmas),
            predictor,
            start: start.to_vec(),
            sigmas,
            priors,
            scales: Cell::new([1.0; 3]),
            buffer: RefCell::default(),
        }
    }

    /// The same with the logarithms of those springs fitted that start above 0, and bounds of these: the change of such a
    /// parameter is that of its logarithm.
    #[must_use]
    pub fn in_logarithms(mut self, bounds: &mut Bounds) -> Self {
        for (k, &slot) in self.predictor.slots.iter().enumerate() {
            let parameter = &self.predictor.model.registry[slot];
            let start = self.start[slot];
            if !(parameter.group == Group::Elastic && parameter.kind.is_spring() && start > 0.0 && start.is_finite()) {
                continue;
            }
            self.logarithms[k] = true;
            for limit in [&mut bounds.lower[k], &mut bounds.upper[k]] {
                *limit = (1.0 + *limit / start).max(0.0).ln();
            }
        }
        self
    }

    /// The same with derivatives that count the sag; `None` where they do already.
    pub fn with_sag(&self) -> Option<Self> {
        let predictor = (!self.predictor.counts_sag()).then(|| self.predictor.clone().with_sag())?;
        Some(Self {
            predictor,
            start: self.start.clone(),
            sigmas: self.sigmas.clone(),
            priors: self.priors.clone(),
            logarithms: self.logarithms.clone(),
            kinds: self.kinds.clone(),
            scales: self.scales.clone(),
            rounding: self.rounding,
            buffer: RefCell::default(),
        })
    }

    /// Which parameters are fitted by their logarithms.
    pub fn logarithms(&self) -> &[bool] {
        &self.logarithms
    }

    /// Derivative of each parameter by what is fitted of it: the value itself of one whose logarithm is.
    pub fn scales(&self, x: &[f64]) -> Vec<f64> {
        let values = self.values(x);
        let slots = self.slots().iter().zip(&self.logarithms);
        slots.map(|(&slot, logarithm)| if *logarithm { values[slot] } else { 1.0 }).collect()
    }

    /// All values at the changes `x`.
    pub fn values(&self, x: &[f64]) -> Vec<f64> {
        let mut values = self.start.clone();
        for ((&slot, change), logarithm) in self.slots().iter().zip(x).zip(&self.logarithms) {
            if *logarithm {
                values[slot] *= change.exp();
            } else {
                values[slot] += change;
            }
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

    /// Robust standard deviations with which a loss is scaled: of lengths, of angles and of torques, in stated ones.
    pub fn tuned(&self) -> [f64; 3] {
        self.scales.get()
    }

    /// Sets them.
    pub fn tune(&self, scales: [f64; 3]) {
        self.scales.set(scales);
    }

    /// Of each row of a reading, whether it is a length (0), an angle (1) or a torque (2).
    pub fn kinds(&self) -> &[usize] {
        &self.kinds
    }

    /// Least robust standard deviations, of lengths, angles and torques: the stated ones; where none is, no instrument's resolution.
    pub fn least_scales(&self) -> [f64; 3] {
        let campaign = self.predictor.campaign;
        let (noise, stated) =
            (campaign.noise(), [campaign.sigma.is_some(), campaign.sigma_orientation.is_some(), false]);
        let sigmas = [noise.position[0], noise.orientation, noise.load];
        std::array::from_fn(|kind| if stated[kind] { 1.0 } else { LEAST_SIGMA / sigmas[kind] })
    }

    /// Rows of constraints and priors, then of each configuration, in their order; none is empty.
    pub fn blocks(&self) -> Vec<Vec<usize>> {
        let campaign = self.predictor.campaign;
        let mut blocks: Vec<Vec<usize>> = vec![Vec::new(); 1 + campaign.poses.len()];
        let known = self.predictor.rows() - campaign.constraints.len();
        blocks[0].extend(known..self.residuals());
        for (first, reading) in campaign.first_rows().into_iter().zip(&campaign.readings) {
            blocks[1 + reading.pose].extend(first..first + reading.observes.rows());
        }
        blocks.retain(|rows| !rows.is_empty());
        blocks
    }
}

/// Norm of the rounding errors of all residuals, in standard deviations: positions are sums of terms as long as the longest
/// constant at `start` or as what was measured, orientations of a radian.
fn rounding(predictor: &Predictor, start: &[f64], sigmas: &[f64]) -> f64 {
    let (registry, campaign) = (&predictor.model.registry, predictor.campaign);
    let lengths = start.iter().enumerate().filter(|(slot, _)| registry[*slot].kind == Kind::Length);
    let longest = if campaign.is_difference() { 0.0 } else { lengths.map(|(_, l)| l.abs()).fold(0.0, f64::max) };
    let of_reading = |reading: &Reading| {
        let measured = reading.measured;
        let lengths = reading.observes.length_rows().min(measured.len());
        let length = measured[..lengths].iter().map(|l| l.abs()).fold(longest, f64::max);
        let size = move |(row, kind)| match kind {
            0 => length,
            1 => 1.0,
            _ => measured.get(row).map_or(0.0, |load: &f64| load.abs()),
        };
        row_kinds(reading).enumerate().map(size).collect::<Vec<_>>()
    };
    let sizes = campaign.readings.iter().flat_map(of_reading).chain(campaign.constraints.iter().map(|_| longest));
    f64::EPSILON * sizes.zip(sigmas).map(|(size, sigma)| (size / sigma).powi(2)).sum::<f64>().sqrt()
}

impl Problem for CampaignProblem<'_> {
    fn parameters(&self) -> usize {
        self.predictor.slots.len()
    }

    fn rounding(&self) -> f64 {
        self.rounding
    }

    fn residuals(&self) -> usize {
        self.predictor.rows() + self.priors.len()
    }

    fn tuning(&self, residual: usize) -> f64 {
        // What is known is never an outlier.
        self.kinds.get(residual).map_or(f64::INFINITY, |&kind| self.scales.get()[kind])
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
        predicted.map_err(EvaluationError::new)?;
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
        for (column, &slot) in self.slots().iter().enumerate().filter(|(column, _)| self.logarithms[*column]) {
            jacobian.column_mut(column).scale_mut(values[slot]);
        }
        for (k, prior) in self.priors.iter().enumerate() {
            jacobian[(rows + k, prior.column)] = -1.0 / prior.sigma;
        }
        Ok(())
    }
}
