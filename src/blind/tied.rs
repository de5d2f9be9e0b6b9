//! Whether an effect is tied with a true cause on the readings: what the true cause shows there, calibration taken off, is
//! reproduced by the effect to less than could be noticed. Rows are divided by the noise.

use nalgebra::{DMatrix, DVector};

use super::truth::Truth;
use crate::description::campaign::Campaign;
use crate::effects::{Site, Survey};
use crate::estimation::{CalibrationError, Settings, calibrate};
use crate::kinematics::Geometry;
use crate::math::{least_squares, orthonormal, project_off};
use crate::model::Model;
use crate::model::nuisance;
use crate::parameter::Slot;
use crate::prediction::{PredictionError, Predictor, Term, effect_columns, survey};

/// Root mean square difference over the noise, a coordinate, below which two causes are tied.
const TIED: f64 = 0.3;

/// What the true causes show in the readings of a campaign, linear about its calibration.
pub struct Signals<'a> {
    model: &'a Model,
    /// The campaign without outliers.
    campaign: Campaign,
    values: Vec<f64>,
    survey: Survey,
    noise: f64,
    /// Orthonormal columns of what is calibrated.
    basis: DMatrix<f64>,
    /// Of each true cause.
    shown: Vec<DVector<f64>>,
}

impl<'a> Signals<'a> {
    /// Signals of the true causes: what they add where that was recorded, else their effects fitted to the readings.
    ///
    /// # Errors
    /// As [`calibrate`].
    pub fn new(model: &'a Model, campaign: &Campaign, truth: &Truth) -> Result<Self, CalibrationError> {
        let is_kept = |row: usize| !truth.outliers.contains(&row);
        let kept = campaign.select(|_, reading| is_kept(reading.row));
        let fitted = nuisance(model, &kept, &kept.calibrate);
        let (mut values, mut slots) = (model.registry.nominal(), Vec::new());
        if !fitted.is_empty() || kept.estimate_base || kept.estimate_tool {
            let asked = Settings { only: Some(fitted), ..Settings::default() };
            let found = calibrate(model, &kept, &vec![false; kept.readings.len()], &asked, &mut |_| {})?;
            slots.extend(found.kept_slots());
            values = found.values;
        }
        let geometry = Geometry::new(model, &values).map_err(PredictionError::from)?;
        let survey = survey(&geometry, &kept)?;
        let mut of = Self {
            model,
            campaign: kept,
            values,
            survey,
            noise: truth.noise,
            basis: DMatrix::zeros(0, 0),
            shown: Vec::new(),
        };
        let (columns, residual) = of.derivatives(&slots)?;
        of.basis = orthonormal(&columns, None);
        let recorded: Vec<&Vec<f64>> = truth.causes.iter().map(|cause| &cause.adds).filter(|a| !a.is_empty()).collect();
        of.shown = if recorded.is_empty() {
            of.fitted(&project_off(&residual, &of.basis), truth)?
        } else {
            let rows = |k: usize| campaign.readings[k].observes.rows();
            let kept = (0..campaign.readings.len()).flat_map(|k| vec![is_kept(campaign.readings[k].row); rows(k)]);
            let kept: Vec<bool> = kept.collect();
            let shown = |adds: &&Vec<f64>| {
                let own: Vec<f64> =
                    adds.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(a, _)| a / of.noise).collect();
                (own.len() == of.basis.nrows()).then(|| project_off(&DVector::from_vec(own), &of.basis))
            };
            recorded.iter().filter_map(shown).collect()
        };
        Ok(of)
    }

    /// Whether an effect at a site, with the best of its nonlinear values, reproduces what one of the true causes shows.
    ///
    /// # Errors
    /// A configuration that cannot be assembled.
    pub fn are_reproduced_by(&self, effect: &str, site: &str) -> Result<bool, PredictionError> {
        let candidates = self.candidates(effect, site)?;
        let rms = |rows: &DVector<f64>| rows.norm() / (rows.len().max(1) as f64).sqrt();
        let reproduces = |columns: &DMatrix<f64>, shown: &DVector<f64>| {
            rms(shown) > TIED && rms(&project_off(shown, &orthonormal(columns, Some(&self.basis)))) < TIED
        };
        Ok(self.shown.iter().any(|shown| candidates.iter().any(|columns| reproduces(columns, shown))))
    }

    /// The true effects fitted together, each with the best of its nonlinear values given those before it.
    fn fitted(&self, residual: &DVector<f64>, truth: &Truth) -> Result<Vec<DVector<f64>>, PredictionError> {
        let mut all: Vec<DMatrix<f64>> = Vec::new();
        for cause in &truth.causes {
            let with = |columns: &DMatrix<f64>| {
                let columns: Vec<_> = all.iter().chain([columns]).flat_map(|own| own.column_iter()).collect();
                project_off(residual, &orthonormal(&DMatrix::from_columns(&columns), None)).norm()
            };
            let candidates = self.candidates(&cause.effect, &cause.site)?.into_iter();
            let best = candidates.map(|own| orthonormal(&own, Some(&self.basis))).filter(|own| own.ncols() > 0);
            all.extend(best.min_by(|a, b| with(a).total_cmp(&with(b))));
        }
        let columns: Vec<_> = all.iter().flat_map(|own| own.column_iter()).collect();
        if columns.is_empty() {
            return Ok(Vec::new());
        }
        let amounts = least_squares(&DMatrix::from_columns(&columns), residual);
        let mut first = 0;
        let shown = |own: &DMatrix<f64>| {
            let shown = own * amounts.rows(first, own.ncols());
            first += own.ncols();
            shown
        };
        Ok(all.iter().map(shown).collect())
    }

    /// Columns of an effect at a site for each of its nonlinear values; none where the robot has no such.
    fn candidates(&self, effect: &str, site: &str) -> Result<Vec<DMatrix<f64>>, PredictionError> {
        let model = self.model;
        let Some(effect) = model.catalogue.get(effect) else { return Ok(Vec::new()) };
        let Some(site) = effect.sites(model).into_iter().find(|known: &Site| known.name == site) else {
            return Ok(Vec::new());
        };
        let mut found = Vec::new();
        for nonlinear in effect.candidates(model, &site, &self.survey) {
            let constants = effect.constants(model, &site, &nonlinear);
            if !constants.is_empty() {
                found.push(self.derivatives(&constants)?.0);
                continue;
            }
            let term = Term::new(model, effect, &site, &nonlinear);
            let (all, width) = effect_columns(model, &self.campaign, &self.values, vec![term])?;
            found.push(DMatrix::from_row_slice(self.campaign.rows(), width, &all) / self.noise);
        }
        Ok(found)
    }

    /// Derivatives of the predictions, and what they leave of the readings.
    fn derivatives(&self, slots: &[Slot]) -> Result<(DMatrix<f64>, DVector<f64>), PredictionError> {
        let predictor = Predictor::new(self.model, &self.campaign, slots.to_vec())?;
        let found = predictor.linearised(&self.values)?;
        let columns = DMatrix::from_row_slice(predictor.rows(), slots.len(), &found.jacobian);
        Ok((columns / self.noise, DVector::from_vec(found.residual) / self.noise))
    }
}
