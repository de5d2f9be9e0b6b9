//! Local springs: parametric models of one structure, each with compliances of its own, blended by the weights of rules over
//! the configuration.
//!
//! The springs are calibrated once for all configurations. About these values deflections are linear in the compliances, so
//! that a tree of rules is grown as for a compliance, each rule with all springs; then conclusions take Gauss-Newton steps
//! with the springs as they are at each configuration, since loops make deflections slightly nonlinear in them.
//!
//! Source: IR663 calibration paper, outlook (fuzzy rules between parametric models); Nelles and Isermann 1996.

use nalgebra::DVector;

use super::super::result::{Calibration, CalibrationError};
use super::super::settings::{Settings, What};
use super::super::statistics::{Errors, errors_of};
use super::super::weighing::calibrate;
use super::levels::{Level, levels};
use super::normal::Normal;
use super::task::FuzzyTask;
use super::tree::{GrownTree, TreeStep, grow_tree, refitted};
use crate::description::campaign::Reading;
use crate::description::fuzzy::{Premise, Rules};
use crate::fuzzy;
use crate::kinematics::{Geometry, Placements};
use crate::least_squares::Progress;
use crate::model::{LocalSprings, Model};
use crate::parameter::Slot;
use crate::prediction::{PredictionError, Predictor, residuals};

/// Most Gauss-Newton steps of the conclusions: the loops of robots bend deflections by per cents, and each step takes all
/// but a square of that.
const STEPS: usize = 6;
/// Relative reduction of the squares below which they end.
const SETTLED: f64 = 1e-9;

/// Fuzzy springs.
#[derive(Debug, Clone)]
pub struct LocalFit {
    /// The springs, the same at all configurations.
    pub parametric: Calibration,
    /// The model with fuzzy springs ([`Model::local_springs`]); with none where one rule for all does as well.
    pub model: Model,
    /// Weight of each rule, summed over the configurations.
    pub support: Vec<f64>,
    /// How the tree grew; the first is the same springs for all configurations.
    pub steps: Vec<TreeStep>,
    /// Errors of fitted readings and of those held out.
    pub errors: [Errors; 2],
    /// Residuals of all readings.
    pub residual: Vec<f64>,
    /// Whether deflections grow as the load does.
    pub levels: Vec<Level>,
}

/// Calibrates the springs by `settings`, then grows rules between local springs.
///
/// # Errors
/// [`CalibrationError::Malformed`] where no spring can be determined; see [`super::super::calibrate`].
pub fn fit_local(
    task: &FuzzyTask,
    settings: &Settings,
    progress: &mut dyn FnMut(&Progress),
    taken: &mut dyn FnMut(&TreeStep),
) -> Result<LocalFit, CalibrationError> {
    let settings = Settings { what: Some(What { geometric: false, elastic: true }), ..settings.clone() };
    let parametric = calibrate(task.model, task.campaign, task.held_out, &settings, progress)?;
    let kept = parametric.kept_slots().into_iter();
    let slots: Vec<Slot> = kept.filter(|&slot| LocalSprings::can_hold(&task.model.registry[slot])).collect();
    if slots.is_empty() {
        return Err(CalibrationError::Malformed("the readings determine no spring that rules could replace".into()));
    }
    let values = parametric.values.clone();
    let local = Local { task, values: &values, slots: &slots };
    let (mut normal, range) = local.normal(task.model, &values)?;
    normal.base = DVector::from_iterator(slots.len(), slots.iter().map(|&slot| values[slot]));
    let grown = grow_tree(&normal, &range, &task.settings, taken);
    let model = if grown.support.len() > 1 { local.settled(&grown)? } else { task.model.clone() };
    let residual = residuals(&model, task.campaign, &values)?;
    let errors = [false, true].map(|set| errors_of(task.campaign, &residual, |i| task.held_out[i] == set));
    let levels = levels(task.campaign, &residual);
    let GrownTree { support, steps, .. } = grown;
    Ok(LocalFit { parametric, model, support, steps, errors, residual, levels })
}

struct Local<'a> {
    task: &'a FuzzyTask<'a>,
    values: &'a [f64],
    slots: &'a [Slot],
}

impl Local<'_> {
    /// Normal equations of the fitted readings by the springs, about those of the model; and the range of each input.
    fn normal(&self, model: &Model, values: &[f64]) -> Result<(Normal, Vec<[f64; 2]>), CalibrationError> {
        let FuzzyTask { campaign, held_out, inputs, .. } = *self.task;
        let found = Predictor::new(model, campaign, self.slots.to_vec())?.linearised(values)?;
        let geometry = Geometry::new(model, values).map_err(PredictionError::from)?;
        let (width, m) = (campaign.observes.rows(), self.slots.len());
        let turning = turning(campaign.readings.iter().zip(held_out).filter(|(_, out)| !**out).map(|(r, _)| r), width);
        let mut normal = Normal::new(vec![0.0; m]);
        let mut range = vec![[f64::INFINITY, f64::NEG_INFINITY]; inputs.len()];
        let (mut placements, mut x) = (Placements::default(), Vec::new());
        for (index, reading) in campaign.readings.iter().enumerate().filter(|(index, _)| !held_out[*index]) {
            geometry.place(campaign.configuration(index), &mut placements).map_err(PredictionError::from)?;
            fuzzy::inputs(inputs, &placements, &mut x);
            for (range, x) in range.iter_mut().zip(&x) {
                *range = [range[0].min(*x), range[1].max(*x)];
            }
            for k in 0..width {
                let row = index * width + k;
                let coefficients = DVector::from_column_slice(&found.jacobian[row * m..(row + 1) * m]);
                let weight = if k < 3 { 1.0 } else { turning };
                normal.add(reading.pose, &x, &coefficients, found.residual[row], weight);
            }
        }
        Ok((normal, range))
    }

    /// The model with fuzzy springs, their conclusions settled by Gauss-Newton steps.
    fn settled(&self, grown: &GrownTree) -> Result<Model, CalibrationError> {
        let with = |conclusions: &[Vec<f64>]| {
            let mut model = self.task.model.clone();
            let springs = self.slots.iter().zip(conclusions).map(|(&slot, conclusions)| {
                model.registry.all_mut()[slot].free = false;
                (slot, Rules { premise: Premise::Tree(grown.tree.clone()), conclusions: conclusions.clone() })
            });
            let springs = springs.collect();
            model.local_springs = Some(LocalSprings { inputs: self.task.inputs.to_vec(), springs });
            model
        };
        let mut conclusions = grown.conclusions.clone();
        let mut model = with(&conclusions);
        let (mut normal, _) = self.normal(&model, self.values)?;
        for _ in 0..STEPS {
            let before: f64 = normal.square.iter().sum();
            let Some(steps) = refitted(&normal, &grown.tree, &self.task.settings) else { break };
            let mut moved = conclusions.clone();
            for (own, steps) in moved.iter_mut().zip(&steps) {
                own.iter_mut().zip(steps).for_each(|(conclusion, step)| *conclusion = (*conclusion + step).max(0.0));
            }
            let tried = with(&moved);
            let (own, _) = self.normal(&tried, self.values)?;
            let after: f64 = own.square.iter().sum();
            if after >= (1.0 - SETTLED) * before {
                break;
            }
            (conclusions, model, normal) = (moved, tried, own);
        }
        // Inputs of which no split makes use have no influence.
        let used: Vec<usize> = (0..self.task.inputs.len())
            .filter(|&input| grown.tree.splits.iter().any(|split| split.input == input))
            .collect();
        if let Some(local) = &mut model.local_springs {
            local.inputs = used.iter().map(|&k| self.task.inputs[k]).collect();
            local.springs.iter_mut().for_each(|(_, rules)| *rules = rules.over(&used));
        }
        Ok(model)
    }
}

/// What a squared rotation (rad) counts in squared displacements (m): each relative to the size of its own kind.
fn turning<'r>(readings: impl Iterator<Item = &'r Reading>, width: usize) -> f64 {
    let (mut moved, mut turned) = (0.0, 0.0);
    for reading in readings {
        moved += reading.measured[..3].iter().map(|v| v * v).sum::<f64>();
        turned += reading.measured[3..width.max(3)].iter().map(|v| v * v).sum::<f64>();
    }
    if turned > 0.0 { moved / turned } else { 1.0 }
}
