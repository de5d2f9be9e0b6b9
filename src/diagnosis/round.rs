//! One competition: calibration, evidence, search, and which readings are wrong beside what was found.

use nalgebra::{DMatrix, DVector};

use super::algebra::solve;
use super::evidence::{Evidence, Hypothesis};
use super::figures::design;
use super::fit::{Fit, entry};
use super::repeats::repeatability;
use super::report::CauseParameter;
use super::search::{Fitted, Ground};
use super::verdict::Settings;
use crate::description::campaign::Campaign;
use crate::effects::Nonlinear;
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
/// Most passes over the readings.
const MOST_PASSES: usize = 20;
/// Beside what is not explained, readings are wrong only this many times further off than all others.
const APART: f64 = 1.8;

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
    /// Noise over the sigmas of the rows: 1 where the campaign states them, else what repeats show, if there are any.
    pub noise: Option<f64>,
    pub registration: f64,
    /// Evidence of all readings, the wrong ones too.
    all: Evidence,
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
        let own = campaign.select(|i, _| !wrong[i]);
        progress("calibrating");
        let asked = estimation::Settings { only: Some(known.to_vec()), ..estimation::Settings::default() };
        let (values, kept, registration) = if known.is_empty() && !own.estimate_base && !own.estimate_tool {
            (model.registry.nominal(), Vec::new(), f64::NAN)
        } else {
            let found = calibrate(model, &own, &kept_aside(aside, wrong), &asked, &mut |_| {})?;
            let kept = found.identifiability.kept.iter().map(|&column| found.slots[column]).collect();
            (found.values, kept, found.registration.fit.distance[1])
        };
        progress("gathering columns");
        let geometry = Geometry::new(model, &values).map_err(PredictionError::from)?;
        let offered = survey(&geometry, &own).map_err(PredictionError::from)?;
        let mut all = Evidence::gather(model, campaign, &values, &kept, &offered, settings)?;
        let noise = own.sigma.map(|_| 1.0).or_else(|| repeatability(&own));
        // The competition is held on what is to be fitted; the rest only judges.
        progress("competing");
        let unused: Vec<bool> = aside.iter().zip(wrong).map(|(aside, wrong)| *aside || *wrong).collect();
        let path = Ground::new(&training(&all, &unused)).search(noise);
        let path = refine(model, campaign, &values, &unused, &mut all, path)?;
        let evidence = training(&all, wrong);
        let aside = kept_aside(aside, wrong);
        Ok(Self { campaign: own, aside, known: known.to_vec(), kept, values, evidence, path, noise, registration, all })
    }

    pub fn members(&self) -> Vec<usize> {
        self.path.last().map(|fit| fit.members.clone()).unwrap_or_default()
    }

    /// Configurations that differ.
    pub fn poses(&self) -> usize {
        let mut poses = self.evidence.pose.clone();
        poses.sort_unstable();
        poses.dedup();
        poses.len()
    }

    /// Which readings are wrong: those that lie many robust sigmas from the best explanation when it is fitted without
    /// them. `marked` were left out of the competition.
    pub fn wrong(&self, marked: &[bool]) -> Vec<bool> {
        let mut marked = marked.to_vec();
        let most = (MOST_WRONG * marked.len() as f64) as usize;
        for _ in 0..MOST_PASSES {
            let (sizes, sigma) = self.distances(&marked);
            let greatest = (0..sizes.len()).filter(|&i| !marked[i]).map(|i| sizes[i]).fold(0.0, f64::max);
            // The worst ones first: what they pull along is judged again without them.
            let is_wrong = |i: usize| sizes[i] > WRONG * sigma && (marked[i] || sizes[i] > 0.7 * greatest);
            let found: Vec<bool> = (0..sizes.len()).map(is_wrong).collect();
            if found == marked || found.iter().filter(|w| **w).count() > most {
                break;
            }
            marked = found;
        }
        marked
    }

    /// Whether the marked readings stand apart from all others: a tail of what is not explained does not.
    pub fn stand_apart(&self, marked: &[bool]) -> bool {
        let (sizes, _) = self.distances(marked);
        let of = |wrong: bool| (0..sizes.len()).filter(move |&i| marked[i] == wrong).map(|i| sizes[i]);
        of(true).fold(f64::INFINITY, f64::min) > APART * of(false).fold(0.0, f64::max)
    }

    /// Greatest weighted residual of each reading beside nuisance and members fitted to those that are not marked; and
    /// the robust sigma of these.
    fn distances(&self, marked: &[bool]) -> (Vec<f64>, f64) {
        let design = design(&self.all, &self.members());
        let rows: Vec<usize> = (0..self.all.rows()).filter(|&row| !marked[self.all.reading[row]]).collect();
        let x = solve(&design.select_rows(&rows), &self.all.residual.select_rows(&rows));
        let left: DVector<f64> = &self.all.residual - design * x;
        let mut used: Vec<f64> = rows.iter().map(|&row| left[row].abs()).collect();
        let sigma = (1.4826 * median(&mut used)).max(self.noise.unwrap_or(0.0));
        let mut sizes = vec![0.0_f64; marked.len()];
        for (row, value) in left.iter().enumerate() {
            let size = &mut sizes[self.all.reading[row]];
            *size = size.max(value.abs());
        }
        (sizes, sigma)
    }

    /// Everything fitted again at once: what is calibrated and the members' parameters, not to first order only. The
    /// values of the model without the members, and the members' parameters; none if the fit cannot be made.
    pub fn refit(
        &self,
        model: &Model,
        members: &[usize],
        linear: &Fit,
    ) -> Option<(Vec<f64>, Vec<Vec<CauseParameter>>)> {
        let mut with = model.clone();
        let mut slots: Vec<Vec<Slot>> = Vec::new();
        for (step, &member) in members.iter().enumerate() {
            let hypothesis = &self.evidence.hypotheses[member];
            if hypothesis.constants.is_empty() {
                with.switch_on(entry(hypothesis, &linear.parameters(&self.evidence, members, step)));
                let own = with.effects.last().map(|effect| effect.slots.clone()).unwrap_or_default();
                slots.push(own.into_iter().flatten().collect());
            } else {
                slots.push(hypothesis.constants.clone());
            }
        }
        let mut only = [self.known.clone(), slots.concat()].concat();
        only.sort_unstable();
        only.dedup();
        if only.is_empty() {
            return None;
        }
        let asked = estimation::Settings { only: Some(only), ..estimation::Settings::default() };
        let found = calibrate(&with, &self.campaign, &self.aside, &asked, &mut |_| {}).ok()?;
        let mut values = found.values.clone();
        let mut parameters = Vec::new();
        for (step, &member) in members.iter().enumerate() {
            let hypothesis = &self.evidence.hypotheses[member];
            let mut own = linear.parameters(&self.evidence, members, step);
            for (parameter, &slot) in own.iter_mut().zip(&slots[step]) {
                let before = if hypothesis.constants.is_empty() { 0.0 } else { self.values[slot] };
                parameter.value = found.values[slot] - before;
                if !hypothesis.constants.is_empty() {
                    values[slot] = before;
                }
            }
            parameters.push(own);
        }
        values.truncate(model.registry.all().len());
        Some((values, parameters))
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

/// Which of the readings that are not wrong are set aside; none where all are.
fn kept_aside(aside: &[bool], wrong: &[bool]) -> Vec<bool> {
    let kept: Vec<bool> = (0..wrong.len()).filter(|&i| !wrong[i]).map(|i| aside[i]).collect();
    if kept.iter().all(|aside| *aside) { vec![false; kept.len()] } else { kept }
}

/// The rows that are not set aside.
pub fn training(evidence: &Evidence, aside: &[bool]) -> Evidence {
    let rows: Vec<usize> = (0..evidence.rows()).filter(|&row| !aside[evidence.reading[row]]).collect();
    if rows.len() == evidence.rows() || rows.is_empty() {
        return evidence.clone();
    }
    let hypotheses =
        evidence.hypotheses.iter().map(|h| Hypothesis { columns: h.columns.select_rows(&rows), ..h.clone() }).collect();
    // Readings are counted anew.
    let before: Vec<usize> = (0..aside.len())
        .scan(0, |kept, i| {
            let own = *kept;
            *kept += usize::from(!aside[i]);
            Some(own)
        })
        .collect();
    Evidence {
        residual: evidence.residual.select_rows(&rows),
        nuisance: evidence.nuisance.select_rows(&rows),
        sigmas: rows.iter().map(|&row| evidence.sigmas[row]).collect(),
        pose: rows.iter().map(|&row| evidence.pose[row]).collect(),
        reading: rows.iter().map(|&row| before[evidence.reading[row]]).collect(),
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
    let continuous: Vec<usize> =
        members.iter().copied().filter(|&h| evidence.hypotheses[h].nonlinear.continuous().is_some()).collect();
    if continuous.is_empty() {
        return Ok(path);
    }
    for h in continuous {
        let hypothesis = &evidence.hypotheses[h];
        let Some(center) = hypothesis.nonlinear.continuous() else { continue };
        let forms: Vec<Nonlinear> =
            (-6..=6).map(|k| hypothesis.nonlinear.clone().with_continuous(center * 1.12_f64.powi(k))).collect();
        let terms = forms.iter().map(|form| Term::new(model, &hypothesis.effect, &hypothesis.site, form)).collect();
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
                best = (squares, Some((form.clone(), columns)));
            }
        }
        if let Some((form, columns)) = best.1 {
            evidence.hypotheses[h].nonlinear = form;
            evidence.hypotheses[h].columns = columns;
        }
    }
    let training = training(evidence, aside);
    let ground = Ground::new(&training);
    Ok(path.iter().map(|fit| ground.fit(&fit.members)).collect())
}
