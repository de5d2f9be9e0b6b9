//! One competition: calibration, evidence, search, and which readings are wrong beside what was found.

use nalgebra::{DMatrix, DVector};

use super::algebra::solve;
use super::evidence::{Evidence, Hypothesis};
use super::figures::design;
use super::fit::Fit;
use super::report::Cause;
use super::search::{Fitted, Ground};
use super::verdict::Settings;
use crate::description::campaign::Campaign;
use crate::effects::Form;
use crate::estimation::{self, CalibrationError, calibrate};
use crate::kinematics::Geometry;
use crate::math::median;
use crate::model::Model;
use crate::parameter::Slot;
use crate::prediction::{PredictionError, Term, effect_columns, survey};

/// A reading further off than this many robust sigmas, beside all causes, is wrong.
const WRONG: f64 = 6.0;
/// Most readings that can be wrong.
const MOST_WRONG: f64 = 0.12;

/// One competition, on the readings that are not wrong.
pub struct Round {
    pub campaign: Campaign,
    pub aside: Vec<bool>,
    /// What is re-fitted whatever is tried, and what of it the readings tell.
    known: Vec<Slot>,
    pub kept: Vec<Slot>,
    pub values: Vec<f64>,
    pub evidence: Evidence,
    pub path: Vec<Fitted>,
    /// Noise over the stated sigma, if one is stated: 1.
    pub noise: Option<f64>,
    pub registration: f64,
    /// All readings, with their rows in the campaign.
    rows: Vec<usize>,
}

impl Round {
    pub fn new(
        model: &Model,
        campaign: &Campaign,
        aside: &[bool],
        settings: &Settings,
        known: &[Slot],
        wrong: &[bool],
        progress: &mut dyn FnMut(&str),
    ) -> Result<Self, CalibrationError> {
        let rows: Vec<usize> = (0..campaign.readings.len()).filter(|&i| !wrong[i]).collect();
        let own = campaign.select(|i, _| !wrong[i]);
        let aside: Vec<bool> = rows.iter().map(|&i| aside[i]).collect();
        progress("calibrating");
        let asked = estimation::Settings { only: Some(known.to_vec()), ..estimation::Settings::default() };
        let (values, kept, registration) = if known.is_empty() && !own.estimate_base && !own.estimate_tool {
            (model.registry.nominal(), Vec::new(), f64::NAN)
        } else {
            let all = vec![false; own.readings.len()];
            let found = calibrate(model, &own, &all, &asked, &mut |_| {})?;
            let kept = found.identifiability.kept.iter().map(|&column| found.slots[column]).collect();
            (found.values, kept, found.registration.fit.distance[1])
        };
        progress("gathering columns");
        let geometry = Geometry::new(model, &values).map_err(PredictionError::from)?;
        let offered = survey(&geometry, &own).map_err(PredictionError::from)?;
        let mut evidence = Evidence::gather(model, &own, &values, &kept, &offered, settings)?;
        let noise = own.sigma.map(|_| 1.0);
        // The competition is held on what is to be fitted; the rest only judges.
        progress("competing");
        let training = training(&evidence, &aside);
        let path = Ground::new(&training).search(noise);
        let path = refine(model, &own, &values, &aside, &mut evidence, path)?;
        Ok(Self {
            campaign: own,
            aside,
            known: known.to_vec(),
            kept,
            values,
            evidence,
            path,
            noise,
            registration,
            rows,
        })
    }

    pub fn members(&self) -> Vec<usize> {
        self.path.last().map(|fit| fit.members.clone()).unwrap_or_default()
    }

    /// Weighted residual of all rows with nuisance and members fitted to all.
    fn left(&self, members: &[usize]) -> DVector<f64> {
        let design = design(&self.evidence, members);
        let x = solve(&design, &self.evidence.residual);
        &self.evidence.residual - design * x
    }

    /// Which readings are wrong, by their distance from the best explanation in robust sigmas.
    pub fn wrong(&self, before: &[bool]) -> Vec<bool> {
        let left = self.left(&self.members());
        let mut sizes: Vec<f64> = left.iter().map(|v| v.abs()).collect();
        let sigma = (1.4826 * median(&mut sizes)).max(self.noise.unwrap_or(0.0));
        let mut marked = before.to_vec();
        let mut worst: Vec<(f64, usize)> = Vec::new();
        for (row, value) in left.iter().enumerate() {
            if value.abs() > WRONG * sigma {
                worst.push((value.abs(), self.rows[self.evidence.reading[row]]));
            }
        }
        worst.sort_by(|a, b| b.0.total_cmp(&a.0));
        let most = (MOST_WRONG * before.len() as f64) as usize;
        let distinct: std::collections::BTreeSet<usize> = worst.iter().map(|w| w.1).collect();
        if distinct.len() + before.iter().filter(|w| **w).count() > most {
            return before.to_vec();
        }
        // The worst half at a time: what they pull along is judged again without them.
        let greatest = worst.first().map_or(0.0, |w| w.0);
        for &(size, reading) in &worst {
            if size > 0.4 * greatest {
                marked[reading] = true;
            }
        }
        marked
    }

    /// Values calibrated anew with the causes switched on. A step from what was calibrated without them would not do:
    /// along what readings hardly tell, they drive that far off.
    pub fn values_beside(&self, model: &Model, causes: &[Cause]) -> Option<Vec<f64>> {
        if self.kept.is_empty() {
            return None;
        }
        let mut with = model.clone();
        for cause in causes.iter().filter(|cause| cause.effect != "outliers") {
            with.effects.push(cause.entry.clone());
            with.effects.extend(cause.further.iter().cloned());
        }
        let asked = estimation::Settings { only: Some(self.known.clone()), ..estimation::Settings::default() };
        let all = vec![false; self.campaign.readings.len()];
        calibrate(&with, &self.campaign, &all, &asked, &mut |_| {}).ok().map(|found| found.values)
    }

    /// Values with the nuisance re-fitted beside the members; what the members change stands in their entries.
    pub fn values_with(&self, fitted: &Fit) -> Vec<f64> {
        let mut values = self.values.clone();
        for (k, &slot) in self.kept.iter().enumerate() {
            values[slot] += fitted.x[k];
        }
        values
    }
}

/// The rows that are not set aside.
pub fn training(evidence: &Evidence, aside: &[bool]) -> Evidence {
    let rows: Vec<usize> = (0..evidence.rows()).filter(|&row| !aside[evidence.reading[row]]).collect();
    if rows.len() == evidence.rows() || rows.is_empty() {
        return evidence.clone();
    }
    let hypotheses =
        evidence.hypotheses.iter().map(|h| Hypothesis { columns: h.columns.select_rows(&rows), ..h.clone() }).collect();
    Evidence {
        residual: evidence.residual.select_rows(&rows),
        nuisance: evidence.nuisance.select_rows(&rows),
        sigmas: rows.iter().map(|&row| evidence.sigmas[row]).collect(),
        pose: rows.iter().map(|&row| evidence.pose[row]).collect(),
        reading: rows.iter().map(|&row| evidence.reading[row]).collect(),
        hypotheses,
    }
}

/// Forms between those offered, for members whose form is a continuous number.
fn refine(
    model: &Model,
    campaign: &Campaign,
    values: &[f64],
    aside: &[bool],
    evidence: &mut Evidence,
    path: Vec<Fitted>,
) -> Result<Vec<Fitted>, CalibrationError> {
    let members = path.last().map(|fit| fit.members.clone()).unwrap_or_default();
    let continuous: Vec<usize> = members.iter().copied().filter(|&h| evidence.hypotheses[h].form.continuous).collect();
    if continuous.is_empty() {
        return Ok(path);
    }
    for h in continuous {
        let center = evidence.hypotheses[h].form.value;
        let forms: Vec<Form> =
            (-6..=6).map(|k| Form { value: center * 1.12_f64.powi(k), ..evidence.hypotheses[h].form }).collect();
        let terms = forms
            .iter()
            .map(|form| Term::new(model, evidence.hypotheses[h].effect, evidence.hypotheses[h].site.clone(), *form))
            .collect();
        let (all, width) = effect_columns(model, campaign, values, terms)?;
        let count = evidence.hypotheses[h].parameters.len();
        let mut best = (f64::INFINITY, None);
        for (k, form) in forms.iter().enumerate() {
            let columns = DMatrix::from_fn(evidence.rows(), count, |row, c| {
                all[row * width + k * count + c] / evidence.sigmas[row]
            });
            evidence.hypotheses[h].columns = columns.clone();
            let squares = Ground::new(&training(evidence, aside)).fit(&members).squares;
            if squares < best.0 {
                best = (squares, Some((*form, columns)));
            }
        }
        if let Some((form, columns)) = best.1 {
            evidence.hypotheses[h].form = form;
            evidence.hypotheses[h].columns = columns;
        }
    }
    let training = training(evidence, aside);
    let ground = Ground::new(&training);
    Ok(path.iter().map(|fit| ground.fit(&fit.members)).collect())
}
