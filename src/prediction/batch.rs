//! Predictions of all readings of a campaign, and their derivatives.

use nalgebra::{DMatrix, DVector, Vector3};
use rayon::prelude::*;

use super::columns::{Columns, ReadingRows, elastic};
use super::error::PredictionError;
use super::measured_loads::LoadMotions;
use super::reading::{Predicted, ReadingAt, by_column, target_values};
use super::terms::{Declared, TermWorkspace, Terms, amounts_of, declared, measured_frames};
use crate::description::campaign::{Campaign, Reading};
use crate::model::Model;
use crate::observation::{MOST_ROWS, Rows, Twist};
use crate::parameter::Slot;
use crate::state::{FrameTwists, LoadedPoint, Loads, Mechanics, State};

/// Predictions of a campaign's readings by a model.
#[derive(Debug, Clone)]
pub struct Predictor<'a> {
    /// The model.
    pub model: &'a Model,
    /// The campaign.
    pub campaign: &'a Campaign,
    /// Parameters by which predictions are differentiated, in the order of columns.
    pub slots: Vec<Slot>,
    /// Where derivatives by the geometry and the joints count what they change in the deflection.
    changes: DeflectionChanges,
    /// Runs of readings at one configuration.
    pub(super) blocks: Vec<Block>,
}

/// Readings in which what moves the frames also changes the deflection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum DeflectionChanges {
    LeftOut,
    /// Differences, and absolute readings under an applied load.
    UnderLoad,
    Counted,
}

/// Readings at one configuration.
pub(super) type Block = std::ops::Range<usize>;

/// Residuals of a campaign (measured minus predicted), one after the other: as many a reading as its kind has, m and rad, in
/// the measurement frame, then one for each constraint; and the derivatives of the predictions.
#[derive(Debug, Clone, Default)]
pub struct Linearised {
    /// Residuals.
    pub residual: Vec<f64>,
    /// What an ideal instrument would read, one a reading, in the order of the columns of the kind of readings.
    pub predicted: Vec<Rows>,
    /// Derivatives of the predictions, row-major, rows as `residual`, a column for each of [`Predictor::slots`];
    /// empty if not asked for.
    pub jacobian: Vec<f64>,
}

impl Linearised {
    /// Derivatives (rows x columns) and residuals over the standard deviations of the rows (m, rad).
    pub fn whitened(&self, sigmas: &[f64]) -> (DMatrix<f64>, DVector<f64>) {
        let width = self.jacobian.len() / self.residual.len().max(1);
        let columns = DMatrix::from_fn(sigmas.len(), width, |row, k| self.jacobian[row * width + k] / sigmas[row]);
        (columns, DVector::from_fn(sigmas.len(), |row, _| self.residual[row] / sigmas[row]))
    }
}

impl<'a> Predictor<'a> {
    /// Predictions of `campaign` by `model`, differentiated by `slots`. Where only own weight loads an absolute reading,
    /// derivatives by the geometry leave out what they change in the sag: a thousandth of the column, which would make
    /// frames that markers take up entirely look identifiable ([`Predictor::with_sag`] counts it).
    ///
    /// # Errors
    /// [`PredictionError::Empty`].
    pub fn new(model: &'a Model, campaign: &'a Campaign, slots: Vec<Slot>) -> Result<Self, PredictionError> {
        if campaign.readings.is_empty() {
            return Err(PredictionError::Empty);
        }
        let mut blocks: Vec<Block> = Vec::new();
        for reading in 0..campaign.readings.len() {
            match blocks.last_mut() {
                Some(block) if campaign.configuration(block.start) == campaign.configuration(reading) => block.end += 1,
                _ => blocks.push(reading..reading + 1),
            }
        }
        let changes = match (campaign.is_difference(), campaign.holds_differences()) {
            (false, true) => DeflectionChanges::UnderLoad,
            (true, _) => DeflectionChanges::Counted,
            (false, false) if loads(campaign).wrench => DeflectionChanges::Counted,
            (false, false) => DeflectionChanges::LeftOut,
        };
        Ok(Self { model, campaign, slots, changes, blocks })
    }

    /// With all that the geometry changes, the sag under own weight too.
    #[must_use]
    pub fn with_sag(self) -> Self {
        Self { changes: DeflectionChanges::Counted, ..self }
    }

    /// Whether derivatives by the geometry count what it changes in the deflection.
    pub fn counts_sag(&self) -> bool {
        self.changes == DeflectionChanges::Counted
    }

    /// Number of residuals.
    pub fn rows(&self) -> usize {
        self.campaign.rows()
    }

    /// Residuals at `values` (all slots, SI), and derivatives of the predictions by the slots.
    ///
    /// # Errors
    /// As [`Self::linearise`].
    pub fn linearised(&self, values: &[f64]) -> Result<Linearised, PredictionError> {
        let mut found = Linearised::default();
        self.linearise(values, true, &mut found)?;
        Ok(found)
    }

    /// Residuals at `values` (all slots, SI) and, if asked, derivatives of the predictions.
    ///
    /// # Errors
    /// The first configuration (in the order of rows) that cannot be assembled.
    ///
    /// ```
    /// use elastogeo::prediction::{Linearised, Predictor};
    ///
    /// let loaded = elastogeo::files::load_campaign("ir663-paper-poses", None)?;
    /// let model = &loaded.robot.model;
    /// let slot = model.registry.slot("3.d").expect("a length");
    /// let predictor = Predictor::new(model, &loaded.campaign, vec![slot])?.with_sag();
    /// let mut values = model.registry.nominal();
    /// let (at, mut moved) = (predictor.linearised(&values)?, Linearised::default());
    /// values[slot] += 1e-6; // m
    /// predictor.linearise(&values, false, &mut moved)?;
    /// // Residuals are measurement less prediction.
    /// let difference = (at.residual[0] - moved.residual[0]) / 1e-6;
    /// assert!((difference - at.jacobian[0]).abs() < 1e-4);
    /// # Ok::<(), elastogeo::Error>(())
    /// ```
    pub fn linearise(&self, values: &[f64], derivatives: bool, out: &mut Linearised) -> Result<(), PredictionError> {
        let slots: &[Slot] = if derivatives { &self.slots } else { &[] };
        let batch = Batch::new(self, values, slots)?;
        out.residual.resize(self.rows(), 0.0);
        out.predicted.resize(self.campaign.readings.len(), [0.0; MOST_ROWS]);
        out.jacobian.resize(self.rows() * slots.len(), 0.0);
        let results: Vec<Result<(), PredictionError>> =
            batch.tasks(out).into_par_iter().map(|task| batch.run(task)).collect();
        results.into_iter().collect::<Result<(), _>>()?;
        self.constrain(values, slots, out);
        Ok(())
    }

    /// Rows of the constraints, behind those of the readings.
    fn constrain(&self, values: &[f64], slots: &[Slot], out: &mut Linearised) {
        let (campaign, width) = (self.campaign, slots.len());
        let first = self.rows() - campaign.constraints.len();
        for (row, constraint) in (first..).zip(&campaign.constraints) {
            let own = constraint.targets.map(|target| self.model.target_values(target));
            let [a, b] = constraint.targets.map(|target| target_values(self.model, campaign, target, values));
            let length =
                constraint.length.and_then(|length| self.model.target_values(length).first().copied().flatten());
            let expected = length.map_or(constraint.value, |slot| values[slot]);
            let (found, direction) = constraint.of([&a, &b], expected);
            out.residual[row] = expected - found;
            for (column, slot) in slots.iter().enumerate() {
                let by = |own: &[Option<Slot>]| own.iter().take(4).position(|known| *known == Some(*slot));
                let of = |k: usize| by(own[k]).map_or(0.0, |axis| direction[k][axis]);
                let derivative = of(0) + of(1);
                let of_length = if length == Some(*slot) { 1.0 } else { 0.0 };
                out.jacobian[row * width + column] = derivative - of_length;
            }
        }
    }
}

/// Residuals (measured minus predicted, as [`Linearised::residual`]) of a campaign at `values` (all slots, SI).
///
/// # Errors
/// [`PredictionError::Empty`], and the first configuration that cannot be assembled.
pub fn residuals(model: &Model, campaign: &Campaign, values: &[f64]) -> Result<Vec<f64>, PredictionError> {
    Ok(Predictor::new(model, campaign, Vec::new())?.linearised(values)?.residual)
}

/// What loads a campaign's readings.
pub(super) fn loads(campaign: &Campaign) -> Loads {
    let wrench = campaign.readings.iter().any(Reading::is_loaded);
    Loads { weight: !campaign.is_difference(), wrench }
}

/// What predictions at one vector of values share; shared between threads.
struct Batch<'a> {
    campaign: &'a Campaign,
    blocks: &'a [Block],
    mechanics: Mechanics<'a>,
    columns: Columns,
    terms: Terms,
    /// Where loads of joints were measured.
    load_motions: Option<LoadMotions>,
    /// Amounts of the terms' parameters.
    amounts: Vec<f64>,
    /// Columns of asked parameters that are amounts, and which of the terms' columns each is.
    by_amount: Vec<(usize, usize)>,
    /// Of which readings the deflection changes with what moves the frames.
    changes: DeflectionChanges,
    width: usize,
}

/// Blocks of one task, and where their results go: each task has its own rows, so that the number of threads changes
/// nothing.
struct Task<'t> {
    blocks: &'t [Block],
    residual: &'t mut [f64],
    jacobian: &'t mut [f64],
    predicted: &'t mut [Rows],
}

/// Blocks of a task: long enough that its workspace costs nothing.
const BLOCKS: usize = 32;

struct Workspace {
    state: State,
    terms: TermWorkspace,
    twists: FrameTwists,
    /// Motions of the frames by joints whose loads were measured.
    by_loads: FrameTwists,
    /// What they turn in the reading at hand.
    turned: Vector3<f64>,
}

impl<'a> Batch<'a> {
    fn new(of: &'a Predictor, values: &[f64], slots: &[Slot]) -> Result<Self, PredictionError> {
        let Declared { terms, amounts: amount_slots, shifts } = declared(of.model);
        let amounts = amounts_of(&amount_slots, values);
        let mut values = values.to_vec();
        shifts.iter().for_each(|&(slot, amount)| values[slot] += amount);
        let elastic: Vec<Slot> = elastic(of.model, slots).into_iter().map(|column| slots[column]).collect();
        let mechanics = Mechanics::new(of.model, &values, loads(of.campaign), &elastic)?;
        let changes = if mechanics.deflects() { of.changes } else { DeflectionChanges::LeftOut };
        let columns = Columns::new(&mechanics, of.campaign, slots, changes != DeflectionChanges::LeftOut);
        let terms = Terms::new(&mechanics, of.campaign, terms);
        let load_motions = LoadMotions::new(&mechanics, of.campaign, measured_frames(of.model, of.campaign), slots);
        let amount_of = |slot: Slot| amount_slots.iter().position(|own| *own == Some(slot));
        let by_amount = slots.iter().enumerate().filter_map(|(column, &slot)| Some((column, amount_of(slot)?)));
        let by_amount = by_amount.collect();
        let (campaign, blocks, width) = (of.campaign, of.blocks.as_slice(), slots.len());
        Ok(Self { campaign, blocks, mechanics, columns, terms, load_motions, amounts, by_amount, changes, width })
    }

    fn tasks<'t>(&'t self, out: &'t mut Linearised) -> Vec<Task<'t>> {
        let (mut residual, mut jacobian) = (out.residual.as_mut_slice(), out.jacobian.as_mut_slice());
        let mut predicted = out.predicted.as_mut_slice();
        let mut tasks = Vec::new();
        for blocks in self.blocks.chunks(BLOCKS) {
            let readings: usize = blocks.iter().map(Block::len).sum();
            let own = blocks.iter().flat_map(Clone::clone);
            let rows: usize = own.map(|index| self.campaign.readings[index].observes.rows()).sum();
            let (own_residual, residual_left) = residual.split_at_mut(rows);
            let (own_jacobian, jacobian_left) = jacobian.split_at_mut(rows * self.width);
            let (own_predicted, predicted_left) = predicted.split_at_mut(readings);
            (residual, jacobian, predicted) = (residual_left, jacobian_left, predicted_left);
            tasks.push(Task { blocks, residual: own_residual, jacobian: own_jacobian, predicted: own_predicted });
        }
        tasks
    }

    fn run(&self, task: Task) -> Result<(), PredictionError> {
        let mut workspace = Workspace {
            state: self.mechanics.state(),
            terms: self.terms.workspace(),
            twists: self.columns.twists(),
            by_loads: self.load_motions.as_ref().map(LoadMotions::twists).unwrap_or_default(),
            turned: Vector3::zeros(),
        };
        let Task { blocks, mut residual, mut jacobian, predicted } = task;
        let readings = blocks.iter().flat_map(|block| block.clone().map(move |index| (index, index == block.start)));
        for ((index, is_first), value) in readings.zip(predicted) {
            if is_first {
                self.place(index, &mut workspace)?;
            }
            let (point, predicted) = self.predict(index, &mut workspace)?;
            let reading = &self.campaign.readings[index];
            let (observes, count) = (reading.observes, reading.observes.rows());
            let (own, left) = residual.split_at_mut(count);
            residual = left;
            own.copy_from_slice(&observes.residual(&reading.measured, &predicted.point)[..count]);
            *value = observes.value(&predicted.point);
            if self.width > 0 {
                let (rows, left) = jacobian.split_at_mut(count * self.width);
                jacobian = left;
                rows.fill(0.0);
                self.differentiate(index, &point, &predicted, &mut workspace, rows);
            }
        }
        Ok(())
    }

    /// Places the configuration of a reading.
    fn place(&self, index: usize, workspace: &mut Workspace) -> Result<(), PredictionError> {
        let Workspace { state, terms, twists, by_loads, .. } = workspace;
        let placed = self.mechanics.place(self.campaign.configuration(index), state);
        placed.map_err(|source| PredictionError::at(self.campaign, index, source))?;
        if self.terms.columns > 0 {
            self.terms.place(&self.mechanics, state, terms);
        }
        if let Some(motions) = &self.load_motions {
            motions.evaluate(&self.mechanics, state, by_loads);
        }
        if self.width > 0 {
            self.columns.evaluate(&self.mechanics, state, twists);
        }
        Ok(())
    }

    fn predict(&self, index: usize, workspace: &mut Workspace) -> Result<(LoadedPoint, Predicted), PredictionError> {
        let Workspace { state, terms, by_loads, turned, .. } = workspace;
        let reading = &self.campaign.readings[index];
        let point = self.mechanics.point(state, reading, &reading.wrench);
        let at = self.reading(index, state, &point);
        let mut predicted = at.predict(&self.mechanics.deflection(state, &point));
        if self.terms.columns > 0 {
            self.terms.evaluate(&at, terms);
            predicted.add(&terms.columns, &self.amounts);
        }
        if let Some(motions) = &self.load_motions {
            *turned = motions.add(&at, by_loads, &mut predicted);
        }
        if predicted.point.position().norm().is_finite() {
            Ok((point, predicted))
        } else {
            let pose = self.campaign.poses[reading.pose].clone();
            Err(PredictionError::TooGreat { at: self.campaign.address(reading), pose })
        }
    }

    fn reading<'s>(&'s self, index: usize, state: &'s State, point: &'s LoadedPoint) -> ReadingAt<'s> {
        ReadingAt { mechanics: &self.mechanics, state, campaign: self.campaign, index, point }
    }

    fn differentiate(
        &self,
        index: usize,
        point: &LoadedPoint,
        predicted: &Predicted,
        workspace: &mut Workspace,
        rows: &mut [f64],
    ) {
        let Workspace { state, terms, twists, by_loads, turned } = workspace;
        let at = self.reading(index, state, point);
        let observes = self.campaign.readings[index].observes;
        let mut rows = ReadingRows { observes, scale: at.scale(), width: self.width, rows };
        if let Some(motions) = &self.load_motions {
            motions.differentiate(&at, by_loads, predicted, turned, &mut rows);
        }
        let moves_deflection = match self.changes {
            DeflectionChanges::LeftOut => false,
            DeflectionChanges::UnderLoad => observes.is_difference() || self.campaign.readings[index].is_loaded(),
            DeflectionChanges::Counted => true,
        };
        if moves_deflection {
            self.columns.by_frames(&at, twists, predicted, &mut rows);
            self.columns.by_motion(&self.mechanics, state, point, twists, predicted, &mut rows);
        } else {
            self.columns.by_frames(&at, twists, &at.predict(&Twist::zero()), &mut rows);
        }
        self.columns.by_elastic(&self.mechanics, state, point, predicted, &mut rows);
        for &(column, term) in &self.by_amount {
            rows.add(column, &predicted.point, by_column(&terms.columns[term]));
        }
    }
}
