//! What each reading should be, and how it changes with every parameter: the one place where physics meets data.

mod columns;
mod deflection;
mod effects;
mod single;
mod terms;

pub use deflection::{Deflected, Deflections};
pub use effects::effect_columns;
pub use single::{Seen, SingleError, SinglePredictor, SingleWork};
pub use terms::{Declared, Term, TermWork, Terms, declared, survey};

use nalgebra::{Point3, Rotation3, Vector3};
use rayon::prelude::*;

use crate::description::campaign::{Campaign, Observes, Reading};
use crate::elastics::Mechanism;
use crate::elements::Motion;
use crate::kinematics::{AssemblyError, Geometry, Placements, Rates, Transform, rotation_vector};
use crate::model::Model;
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
        let moves_deflection = is_loaded || campaign.observes == Observes::Deflection;
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
        for blocks in self.blocks.chunks(32) {
            let readings: usize = blocks.iter().map(std::ops::Range::len).sum();
            let (own, rest) = residual.split_at_mut(readings * components);
            let (own_rows, rest_rows) = jacobian.split_at_mut(readings * components * width);
            (residual, jacobian) = (rest, rest_rows);
            tasks.push((blocks, own, own_rows));
        }
        let results: Vec<Result<(), PredictionError>> = tasks
            .into_par_iter()
            .map(|(blocks, residual, jacobian)| {
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
                            predicted.add(campaign, reading, &added.columns, &amounts);
                        }
                        if !predicted.position.coords.norm().is_finite() {
                            return Err(PredictionError::TooGreat {
                                row: reading.row,
                                pose: self.campaign.poses[reading.pose].clone(),
                            });
                        }
                        let target = &mut residual[row * components..(row + 1) * components];
                        predicted.residual(self.campaign, reading, target);
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
                                let moved = &added.columns[term];
                                for component in 0..components {
                                    rows[component * width + column] = predicted.along(self.campaign, moved, component);
                                }
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
    /// Position (of a deflection: the deflection) in the measurement frame, m.
    pub position: Point3<f64>,
    /// Orientation of the tool in the measurement frame.
    pub rotation: Rotation3<f64>,
    /// Distance to the reading's anchor, m, and its direction.
    pub distance: (f64, Vector3<f64>),
    /// Rotation vector by which load turns the tool, measurement frame; zero where orientations are not observed.
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
    let moved = base.rotation * deflected.displacement;
    let position =
        if campaign.observes == Observes::Deflection { Point3::from(moved) } else { in_frame * point + moved };
    let (rotation, turned) = match campaign.observes {
        Observes::Pose => {
            let turned = base.rotation * deflected.rotation;
            (Rotation3::new(turned) * in_frame.rotation * geometry.tool().rotation, turned)
        }
        _ => (Rotation3::identity(), Vector3::zeros()),
    };
    let distance = match campaign.anchors.get_index(reading.anchor) {
        Some((_, anchor)) if campaign.observes == Observes::Distance => {
            let arm = position.coords - anchor;
            let length = arm.norm();
            (length, arm / length.max(f64::MIN_POSITIVE))
        }
        _ => (0.0, Vector3::zeros()),
    };
    Predicted { position, rotation, distance, turned }
}

fn measured_point(geometry: &Geometry, reading: &Reading) -> (usize, Point3<f64>) {
    match reading.marker {
        Some(marker) => (geometry.model.markers[marker].frame, geometry.marker(marker)),
        None => (geometry.model.tool.0, geometry.tool().translation.vector.into()),
    }
}

impl Predicted {
    /// Adds amounts of displacements and rotations (measurement frame).
    fn add(&mut self, campaign: &Campaign, reading: &Reading, columns: &[[f64; 6]], amounts: &[f64]) {
        let mut sum = [0.0; 6];
        for (column, amount) in columns.iter().zip(amounts) {
            (0..6).for_each(|k| sum[k] += column[k] * amount);
        }
        self.position += Vector3::new(sum[0], sum[1], sum[2]);
        self.rotation = Rotation3::new(Vector3::new(sum[3], sum[4], sum[5])) * self.rotation;
        if let Some((_, anchor)) = campaign.anchors.get_index(reading.anchor)
            && campaign.observes == Observes::Distance
        {
            let arm = self.position.coords - anchor;
            self.distance = (arm.norm(), arm / arm.norm().max(f64::MIN_POSITIVE));
        }
    }

    /// A component of a reading by a displacement and rotation of it, measurement frame.
    fn along(&self, campaign: &Campaign, moved: &[f64; 6], component: usize) -> f64 {
        match campaign.observes {
            Observes::Distance => self.distance.1.dot(&Vector3::new(moved[0], moved[1], moved[2])),
            _ => moved[component],
        }
    }

    /// Measured minus predicted.
    fn residual(&self, campaign: &Campaign, reading: &Reading, out: &mut [f64]) {
        let measured = &reading.measured;
        if campaign.observes == Observes::Distance {
            out[0] = measured[0] - self.distance.0;
            return;
        }
        for k in 0..3 {
            out[k] = measured[k] - self.position[k];
        }
        if campaign.observes == Observes::Pose {
            let rotation = Rotation3::new(Vector3::new(measured[3], measured[4], measured[5]));
            out[3..6].copy_from_slice(rotation_vector(&(rotation * self.rotation.inverse())).as_slice());
        }
    }

    /// The reading an ideal instrument would give, as [`Reading::measured`].
    pub fn measured(&self, campaign: &Campaign) -> [f64; 6] {
        if campaign.observes == Observes::Distance {
            return [self.distance.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        }
        let turn = if campaign.observes == Observes::Pose { rotation_vector(&self.rotation) } else { Vector3::zeros() };
        [self.position.x, self.position.y, self.position.z, turn.x, turn.y, turn.z]
    }
}
