//! What each reading should be, and how it changes with every parameter: the one place where physics meets data.

mod columns;
mod deflection;
mod effects;
mod single;
mod terms;

pub use deflection::{Deflected, Deflections};
pub use effects::effect_columns;
pub use single::{Seen, SingleError, SinglePredictor, SingleWork};
pub(crate) use terms::masses;
pub use terms::{Declared, Term, TermWork, Terms, declared, survey};

use nalgebra::{Point3, Rotation3, Vector3};
use rayon::prelude::*;

use crate::description::campaign::{Campaign, Reading};
use crate::elastics::Mechanism;
use crate::elements::Motion;
use crate::kinematics::{AssemblyError, Geometry, Placements, Rates, Transform};
use crate::model::Model;
use crate::observation::{MOST_ROWS, MeasuredPoint, PointDerivative, Rows, Twist};
use crate::parameter::Slot;
use columns::Columns;

/// Why readings cannot be predicted.
#[derive(Debug, Clone, thiserror::Error)]
pub enum PredictionError {
    /// A configuration cannot be assembled.
    #[error("row {row} (configuration `{pose}`): {source}")]
    Assembly {
        /// Row of the reading.
        row: usize,
        /// Its configuration.
        pose: String,
        /// Why.
        source: AssemblyError,
    },
    /// The model cannot be assembled at all.
    #[error(transparent)]
    Model(#[from] AssemblyError),
    /// The structure can move without any force.
    #[error("row {row} (configuration `{pose}`): {source}")]
    Mechanism {
        /// Row of the reading.
        row: usize,
        /// Its configuration.
        pose: String,
        /// What can move.
        source: Mechanism,
    },
    /// A load is beyond what statics can be computed with.
    #[error("row {row} (configuration `{pose}`): the deflection is not finite; the wrench is too great")]
    TooGreat {
        /// Row of the reading.
        row: usize,
        /// Its configuration.
        pose: String,
    },
    /// No readings.
    #[error("the campaign has no readings")]
    Empty,
}

/// Predictions of a campaign's readings by a model.
#[derive(Debug, Clone)]
pub struct Predictor<'a> {
    /// The model.
    pub model: &'a Model,
    /// The campaign.
    pub campaign: &'a Campaign,
    /// Parameters by which predictions are differentiated, in the order of columns.
    pub slots: Vec<Slot>,
    /// Whether derivatives by the geometry and the joints count what they change in the deflection.
    moves_deflection: bool,
    /// Runs of readings at one configuration.
    blocks: Vec<std::ops::Range<usize>>,
}

/// Residuals of a campaign (measured minus predicted), one after the other: 3, 6 or 1 a reading, m and rad, in the
/// measurement frame; and the derivatives of the predictions.
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

struct Workspace {
    placements: Placements,
    rates: Rates,
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
        let mut blocks: Vec<std::ops::Range<usize>> = Vec::new();
        for reading in 0..campaign.readings.len() {
            match blocks.last_mut() {
                Some(block) if campaign.configuration(block.start) == campaign.configuration(reading) => block.end += 1,
                _ => blocks.push(reading..reading + 1),
            }
        }
        let is_loaded = campaign.readings.iter().any(|reading| reading.wrench != [0.0; 6]);
        let moves_deflection = is_loaded || campaign.observes.is_difference();
        Ok(Self { model, campaign, slots, moves_deflection, blocks })
    }

    /// With all that the geometry changes, the sag under own weight too.
    #[must_use]
    pub fn with_sag(self) -> Self {
        Self { moves_deflection: true, ..self }
    }

    /// Number of residuals.
    pub fn rows(&self) -> usize {
        self.campaign.readings.len() * self.campaign.components()
    }

    /// Residuals at `values` (all slots, SI) and, if asked, derivatives of the predictions.
    ///
    /// # Errors
    /// The first configuration (in the order of rows) that cannot be assembled.
    pub fn linearise(&self, values: &[f64], derivatives: bool, out: &mut Linearised) -> Result<(), PredictionError> {
        let Declared { terms: switched_on, amounts: amount_slots, shifts } = declared(self.model);
        let amounts = terms::amounts_of(&amount_slots, values);
        let shifted: Vec<f64>;
        let values = if shifts.is_empty() {
            values
        } else {
            let mut with = values.to_vec();
            shifts.iter().for_each(|&(slot, amount)| with[slot] += amount);
            shifted = with;
            &shifted
        };
        let geometry = Geometry::new(self.model, values)?;
        let components = self.campaign.components();
        let width = if derivatives { self.slots.len() } else { 0 };
        out.residual.resize(self.rows(), 0.0);
        out.predicted.resize(self.campaign.readings.len(), [0.0; MOST_ROWS]);
        out.jacobian.resize(self.rows() * width, 0.0);
        let pattern = Rates::new(self.model);
        let slots: &[Slot] = if derivatives { &self.slots } else { &[] };
        let deflections = Deflections::new(self.model, values, self.campaign, slots);
        let moves = self.moves_deflection && deflections.is_active();
        let columns = Columns::new(&geometry, &pattern, self.campaign, slots, moves);

        let terms = Terms::new(&geometry, &pattern, self.campaign, switched_on);
        // Which term's column is which asked parameter's.
        let by_amount: Vec<(usize, usize)> = (0..slots.len())
            .filter_map(|column| Some((column, amount_slots.iter().position(|own| *own == Some(slots[column]))?)))
            .collect();

        // Each task writes its own rows, so that the number of threads changes nothing.
        let mut tasks = Vec::new();
        let (mut residual, mut jacobian) = (out.residual.as_mut_slice(), out.jacobian.as_mut_slice());
        let mut values = out.predicted.as_mut_slice();
        for blocks in self.blocks.chunks(32) {
            let readings: usize = blocks.iter().map(std::ops::Range::len).sum();
            let (own, rest) = residual.split_at_mut(readings * components);
            let (own_rows, rest_rows) = jacobian.split_at_mut(readings * components * width);
            let (own_values, rest_values) = values.split_at_mut(readings);
            (residual, jacobian, values) = (rest, rest_rows, rest_values);
            tasks.push((blocks, own, own_rows, own_values));
        }
        let results: Vec<Result<(), PredictionError>> = tasks
            .into_par_iter()
            .map(|(blocks, residual, jacobian, values)| {
                let mut work = Workspace { placements: Placements::default(), rates: pattern.clone() };
                let mut loaded = deflections.work();
                let mut added = terms.work();
                let mut work_columns = columns.buffers();
                let mut row = 0;
                for block in blocks {
                    let q = self.campaign.configuration(block.start);
                    let placed = geometry.place(q, &mut work.placements);
                    placed.map_err(|source| self.assembly(block.start, source))?;
                    deflections
                        .place(&geometry, q, &work.placements, &mut loaded)
                        .map_err(|source| mechanism(self.campaign, block.start, source))?;
                    if terms.columns > 0 {
                        terms.place(&geometry, q, &work.placements, &mut work.rates, &mut added);
                    }
                    if derivatives {
                        columns.evaluate(&geometry, q, &work.placements, &mut work.rates, &mut work_columns);
                        if moves {
                            deflections.prepare_motion(&mut loaded);
                        }
                    }
                    for index in block.clone() {
                        let reading = &self.campaign.readings[index];
                        let point = rest(&geometry, &work.placements, reading);
                        let deflected = deflections.of(&loaded, reading, &point);
                        let mut predicted = predict(&geometry, self.campaign, &work.placements, reading, &deflected);
                        if terms.columns > 0 {
                            let applied = deflections.by_wrench(&loaded, reading, &point);
                            let (work, campaign) = (&work, self.campaign);
                            terms.evaluate(
                                &geometry,
                                campaign,
                                index,
                                reading,
                                q,
                                &work.placements,
                                &work.rates,
                                &applied,
                                &mut added,
                            );
                            predicted.add(&added.columns, &amounts);
                        }
                        if !predicted.point.position().norm().is_finite() {
                            return Err(PredictionError::TooGreat {
                                row: reading.row,
                                pose: self.campaign.poses[reading.pose].clone(),
                            });
                        }
                        let target = &mut residual[row * components..(row + 1) * components];
                        let own = self.campaign.observes.residual(&reading.measured, &predicted.point);
                        target.copy_from_slice(&own[..components]);
                        values[row] = self.campaign.observes.value(&predicted.point);
                        if derivatives {
                            let rows = &mut jacobian[row * components * width..(row + 1) * components * width];
                            let turning = if moves {
                                predicted
                            } else {
                                predict(&geometry, self.campaign, &work.placements, reading, &Deflected::default())
                            };
                            columns.rows(&geometry, &work.placements, &work_columns, reading, &turning, width, rows);
                            if moves {
                                let change = |moved: &Vector3<f64>, motion: Option<(usize, &Motion)>| {
                                    deflections.by_motion(&mut loaded, &work.placements, reading, &point, moved, motion)
                                };
                                columns.with_motion(
                                    &geometry,
                                    &work.placements,
                                    &work.rates,
                                    &work_columns,
                                    reading,
                                    &predicted,
                                    change,
                                    width,
                                    rows,
                                );
                            }
                            let by = deflections.derivatives(&mut loaded, &work.placements, reading, &point);
                            columns.deflected(&geometry, by, &predicted, width, rows);
                            for &(column, term) in &by_amount {
                                columns.put(column, &predicted.point, by_column(&added.columns[term]), width, rows);
                            }
                        }
                        row += 1;
                    }
                }
                Ok(())
            })
            .collect();
        results.into_iter().collect()
    }

    fn assembly(&self, reading: usize, source: AssemblyError) -> PredictionError {
        let reading = &self.campaign.readings[reading];
        PredictionError::Assembly { row: reading.row, pose: self.campaign.poses[reading.pose].clone(), source }
    }
}

pub(crate) fn mechanism(campaign: &Campaign, reading: usize, source: Mechanism) -> PredictionError {
    let reading = &campaign.readings[reading];
    PredictionError::Mechanism { row: reading.row, pose: campaign.poses[reading.pose].clone(), source }
}

/// What a reading should be.
#[derive(Debug, Clone, Copy)]
pub struct Predicted {
    /// The measured point, measurement frame.
    pub point: MeasuredPoint,
    /// Rotation vector by which load turns the tool, measurement frame.
    pub turned: Vector3<f64>,
}

/// The measured point with nothing deflected, m, base frame.
pub fn rest(geometry: &Geometry, placements: &Placements, reading: &Reading) -> Point3<f64> {
    let (frame, point) = measured_point(geometry, reading);
    placements.frames[frame] * point
}

/// Prediction of one reading at placed frames, with what load does to it.
pub fn predict(
    geometry: &Geometry,
    campaign: &Campaign,
    placements: &Placements,
    reading: &Reading,
    deflected: &Deflected,
) -> Predicted {
    let base = geometry.base();
    let (frame, point) = measured_point(geometry, reading);
    let in_frame: Transform = base * placements.frames[frame];
    let turned = base.rotation * deflected.rotation;
    let point = MeasuredPoint {
        undeflected: (in_frame * point).coords,
        displacement: base.rotation * deflected.displacement,
        orientation: Rotation3::new(turned) * in_frame.rotation * geometry.tool().rotation,
        anchor: campaign.anchor(reading),
    };
    Predicted { point, turned }
}

fn measured_point(geometry: &Geometry, reading: &Reading) -> (usize, Point3<f64>) {
    match reading.marker {
        Some(marker) => (geometry.model.markers[marker].frame, geometry.marker(marker)),
        None => (geometry.model.tool.0, geometry.tool().translation.vector.into()),
    }
}

/// Displacement and rotation of a column, `[x, y, z, rx, ry, rz]`, as a change of what is added to the undeflected point.
pub(crate) fn by_column(column: &[f64; 6]) -> PointDerivative {
    let [x, y, z, rx, ry, rz] = *column;
    PointDerivative::of_deflection(Twist::new(Vector3::new(x, y, z), Vector3::new(rx, ry, rz)))
}

impl Predicted {
    /// Adds amounts of displacements and rotations (measurement frame).
    fn add(&mut self, columns: &[[f64; 6]], amounts: &[f64]) {
        let mut sum = [0.0; 6];
        for (column, amount) in columns.iter().zip(amounts) {
            (0..6).for_each(|k| sum[k] += column[k] * amount);
        }
        self.point.displacement += Vector3::new(sum[0], sum[1], sum[2]);
        self.point.orientation = Rotation3::new(Vector3::new(sum[3], sum[4], sum[5])) * self.point.orientation;
    }
}
