//! The linear problem that hypotheses compete on: residuals of a calibration, the columns of what was calibrated, and
//! the columns of every hypothesis. Rows are divided by their sigma (m or rad, measurement frame).

use nalgebra::{DMatrix, DVector, Vector3};

use super::hypothesis::Hypothesis;
use super::joint_compliance::add_compliances;
use crate::description::campaign::{Campaign, Reading};
use crate::estimation::row_sigmas;
use crate::math::{distinct, least_squares, orthonormal};
use crate::model::Model;
use crate::parameter::{Group, Slot};
use crate::prediction::{PredictionError, Predictor, Term, effect_columns};

/// Weighted rows of all readings.
#[derive(Debug, Clone)]
pub struct LinearProblem {
    /// Residuals over their sigmas.
    pub residual: DVector<f64>,
    /// Derivatives by the parameters that are fitted with every hypothesis.
    pub nuisance: DMatrix<f64>,
    /// Of each of these: how far calibration moved it from the description, and one standard deviation of that by the description's
    /// tolerances; infinite where it has none.
    pub moved: Vec<[f64; 2]>,
    /// Sigma of each row, m or rad.
    pub sigmas: Vec<f64>,
    /// Configuration of each row.
    pub pose: Vec<usize>,
    /// Marker of each row, counted from 1; 0 of the tool centre point and of constraints.
    pub marker: Vec<usize>,
    /// Reading of each row.
    pub reading: Vec<usize>,
    /// Number of readings; what is known of the arrangement counts behind them.
    pub readings: usize,
    /// Hypotheses.
    pub hypotheses: Vec<Hypothesis>,
}

/// What each row belongs to.
struct Numbers {
    pose: Vec<usize>,
    reading: Vec<usize>,
    marker: Vec<usize>,
}

impl Numbers {
    /// Of the rows of a campaign; each constraint counts as a reading at a configuration of its own.
    fn of(campaign: &Campaign) -> Self {
        let configurations = campaign.neighbourhoods();
        let readings = campaign.readings.iter().enumerate();
        let of_rows = readings
            .flat_map(|(k, reading)| std::iter::repeat_n((configurations[reading.pose], k), reading.observes.rows()));
        let (poses, count) = (campaign.poses.len(), campaign.readings.len());
        let of_constraints = (0..campaign.constraints.len()).map(|k| (poses + k, count + k));
        let marker_of = |reading: &Reading| reading.marker.map_or(0, |marker| marker + 1);
        let markers = campaign.readings.iter().flat_map(|own| std::iter::repeat_n(marker_of(own), own.observes.rows()));
        let (pose, reading) = of_rows.chain(of_constraints).unzip();
        Self { pose, reading, marker: markers.chain(campaign.constraints.iter().map(|_| 0)).collect() }
    }
}

impl LinearProblem {
    /// Linearises the predictions of a campaign at calibrated `values`.
    ///
    /// # Errors
    /// A configuration that cannot be assembled.
    pub fn new(
        model: &Model,
        campaign: &Campaign,
        values: &[f64],
        nuisance: &[Slot],
        mut hypotheses: Vec<Hypothesis>,
    ) -> Result<Self, PredictionError> {
        let mut slots: Vec<Slot> = nuisance.to_vec();
        slots.extend(hypotheses.iter().flat_map(|hypothesis| &hypothesis.constants));
        slots.sort_unstable();
        slots.dedup();
        let found = Predictor::new(model, campaign, slots.clone())?.linearised(values)?;
        let sigmas = row_sigmas(campaign);
        let rows = sigmas.len();
        // Every slot asked for is among the sorted ones.
        let columns_of = |own: &[Slot]| {
            let at: Vec<usize> = own.iter().map(|slot| slots.partition_point(|known| known < slot)).collect();
            DMatrix::from_fn(rows, at.len(), |row, k| found.jacobian[row * slots.len() + at[k]] / sigmas[row])
        };
        let mut laws: Vec<&mut Hypothesis> = Vec::new();
        for hypothesis in &mut hypotheses {
            if hypothesis.constants.is_empty() {
                laws.push(hypothesis);
            } else {
                hypothesis.columns = columns_of(&hypothesis.constants);
            }
        }
        let terms = laws.iter().map(|law| Term::new(model, &law.effect, &law.site, &law.nonlinear)).collect();
        let (all, width) = effect_columns(model, campaign, values, terms)?;
        let mut first = 0;
        for law in laws {
            let count = law.parameters.len();
            law.columns = DMatrix::from_fn(rows, count, |row, k| all[row * width + first + k] / sigmas[row]);
            first += count;
        }
        add_compliances(model, campaign, values, nuisance, &mut hypotheses)?;
        let moved = nuisance.iter().map(|&slot| {
            let parameter = &model.registry[slot];
            let is_stated = parameter.group == Group::Geometry && parameter.tolerance > 0.0;
            [values[slot] - parameter.nominal, if is_stated { parameter.tolerance } else { f64::INFINITY }]
        });
        let Numbers { pose, reading, marker } = Numbers::of(campaign);
        Ok(Self {
            moved: moved.collect(),
            residual: DVector::from_iterator(rows, found.residual.iter().zip(&sigmas).map(|(r, s)| r / s)),
            nuisance: columns_of(nuisance),
            sigmas,
            pose,
            marker,
            reading,
            readings: campaign.readings.len(),
            hypotheses,
        })
    }

    /// Without the columns, and the hypotheses, that the nuisance reproduces entirely.
    pub fn pruned(mut self) -> Self {
        let basis = orthonormal(&self.nuisance, None);
        self.hypotheses.iter_mut().for_each(|hypothesis| hypothesis.prune(&basis));
        self.hypotheses.retain(|hypothesis| !hypothesis.parameters.is_empty());
        self
    }

    /// The problem without some readings; all of it where none would be left. Readings are numbered anew.
    pub fn without(&self, excluded: &[bool]) -> Self {
        let rows: Vec<usize> = (0..self.rows()).filter(|&row| excluded.get(self.reading[row]) != Some(&true)).collect();
        if rows.len() == self.rows() || rows.is_empty() {
            return self.clone();
        }
        let mut number = Vec::with_capacity(excluded.len());
        let mut next = 0;
        for reading in 0..self.reading.last().map_or(0, |last| last + 1) {
            number.push(next);
            next += usize::from(excluded.get(reading) != Some(&true));
        }
        let select = |h: &Hypothesis| Hypothesis { columns: h.columns.select_rows(&rows), ..h.clone() };
        Self {
            residual: self.residual.select_rows(&rows),
            nuisance: self.nuisance.select_rows(&rows),
            moved: self.moved.clone(),
            sigmas: rows.iter().map(|&row| self.sigmas[row]).collect(),
            pose: rows.iter().map(|&row| self.pose[row]).collect(),
            marker: rows.iter().map(|&row| self.marker[row]).collect(),
            reading: rows.iter().map(|&row| number[self.reading[row]]).collect(),
            readings: (0..self.readings).filter(|&reading| excluded.get(reading) != Some(&true)).count(),
            hypotheses: self.hypotheses.iter().map(select).collect(),
        }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.residual.len()
    }

    /// Number of hypotheses with a law.
    pub fn named(&self) -> usize {
        self.hypotheses.iter().filter(|hypothesis| !hypothesis.is_free()).count()
    }

    /// Different configurations, ascending.
    pub fn poses(&self) -> Vec<usize> {
        distinct(self.pose.iter().copied())
    }

    /// Configuration of each row as counted by [`Self::poses`], and their number.
    pub fn numbered(&self) -> (Vec<usize>, usize) {
        let poses = self.poses();
        (self.pose.iter().map(|own| poses.partition_point(|pose| pose < own)).collect(), poses.len())
    }

    /// Columns of the nuisance and of some hypotheses.
    pub fn design(&self, members: &[usize]) -> DMatrix<f64> {
        let parts = std::iter::once(&self.nuisance).chain(members.iter().map(|&h| &self.hypotheses[h].columns));
        let columns: Vec<_> = parts.flat_map(|part| part.column_iter()).collect();
        if columns.is_empty() { DMatrix::zeros(self.rows(), 0) } else { DMatrix::from_columns(&columns) }
    }

    /// Of the members in question, those that are never negative and of which nothing positive is left when all are fitted together, the
    /// most negative one.
    pub fn negative(&self, members: &[usize], is_asked: impl Fn(usize) -> bool) -> Option<usize> {
        let is_asked = |h: &usize| self.hypotheses[*h].is_never_negative() && is_asked(*h);
        if !members.iter().any(is_asked) {
            return None;
        }
        let x = least_squares(&self.design(members), &self.residual);
        let mut first = self.nuisance.ncols();
        let greatest = members.iter().map(|&h| {
            let own = &self.hypotheses[h];
            let amounts = x.iter().skip(first).zip(&own.parameters).map(|(amount, own)| amount / own.scale);
            first += own.columns.ncols();
            (h, amounts.fold(f64::NEG_INFINITY, f64::max))
        });
        let negative = greatest.filter(|(h, amount)| is_asked(h) && *amount <= 0.0);
        negative.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(h, _)| h)
    }

    /// Error of each reading (m): of its position, or in x that of a distance.
    pub fn errors(&self, residual: &DVector<f64>) -> Vec<Vector3<f64>> {
        let rows: Vec<usize> = (0..self.rows()).collect();
        let of =
            |own: &[usize]| Vector3::from_fn(|k, _| own.get(k).map_or(0.0, |&row| residual[row] * self.sigmas[row]));
        rows.chunk_by(|&a, &b| self.reading[a] == self.reading[b]).map(of).take(self.readings).collect()
    }

    /// Root mean square error (m) of readings whose weighted residuals are all of root mean square 1.
    pub fn error_of_one_sigma(&self) -> f64 {
        let errors = self.errors(&DVector::from_element(self.rows(), 1.0));
        crate::math::mean_rms_max(errors.iter().map(|error| error.norm()))[1]
    }
}
