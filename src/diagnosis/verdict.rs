//! The diagnosis from beginning to end.

use indexmap::IndexMap;
use nalgebra::{DMatrix, DVector, Vector3};

use super::algebra::{rest, solve};
use super::evidence::{Evidence, Hypothesis};
use super::figures::{bootstrap, design, folds, held_out, reading_errors, rms_max};
use super::location::{Location, conditions, sites};
use super::next::next_poses;
use super::report::{Cause, CauseParameter, Diagnosis, Gap, Rejected, Shrinkage, Verdict};
use super::search::{Fitted, Ground};
use crate::description::campaign::{Campaign, Observes};
use crate::description::raw::RawEffect;
use crate::effects::{Effect, Form, catalogue};
use crate::estimation::{self, CalibrationError, calibrate};
use crate::kinematics::Geometry;
use crate::math::median;
use crate::model::Model;
use crate::parameter::{Group, Slot};
use crate::prediction::survey;

/// What is asked of a diagnosis.
#[derive(Clone)]
pub struct Settings {
    /// Effects that compete.
    pub effects: Vec<&'static dyn Effect>,
    /// Names of effects that are re-fitted whatever is tried; by default what the campaign lists.
    pub known: Vec<String>,
    /// Seed of folds, draws and proposals.
    pub seed: u64,
    /// Draws of the intervals.
    pub draws: usize,
    /// Whether next configurations are proposed.
    pub propose: bool,
}

impl Settings {
    /// The catalogue against a campaign.
    pub fn new(campaign: &Campaign, seed: u64) -> Self {
        Self { effects: catalogue(), known: campaign.calibrate.clone(), seed, draws: 1000, propose: true }
    }
}

/// A reading further off than this many robust sigmas, beside all causes, is wrong.
const WRONG: f64 = 6.0;
/// Most readings that can be wrong.
const MOST_WRONG: f64 = 0.12;
/// Merit within which another hypothesis is no worse.
const RIVAL: f64 = 9.0;
/// What is left above the noise, of what was there, when a gap counts as explained (of squares).
const EXPLAINED: f64 = 0.15;
/// A cause must leave less than this share of the error of unseen readings.
const HELPS: f64 = 0.995;
/// Squares left above the noise's, of the noise's, beyond which nothing counts as explained (1.5 times the noise).
const NEAR: f64 = 1.25;
/// What the causes must take away of the squares above the noise to be named at all.
const NAMED: f64 = 0.5;

/// Parameters that are re-fitted whatever is tried: those of the known effects, at all their sites.
pub fn nuisance(model: &Model, campaign: &Campaign, known: &[String]) -> Vec<Slot> {
    let mut slots = Vec::new();
    for effect in known.iter().filter_map(|name| crate::effects::by_name(name)) {
        let mut own: Vec<Slot> =
            effect.sites(model).iter().flat_map(|site| effect.constants(model, site, &Form::ONLY)).collect();
        // Where a description declares some of them to give, those are meant.
        let declared = |slot: &Slot| model.registry[*slot].nominal != 0.0;
        if own.iter().any(|slot| model.registry[*slot].group == Group::Elastic && declared(slot)) {
            own.retain(declared);
        }
        slots.extend(own);
    }
    if known.iter().any(|name| name == "geometry") {
        slots.extend(model.free_slots().into_iter().filter(|slot| model.registry[*slot].group == Group::Geometry));
    }
    if campaign.observes == Observes::Deflection {
        slots.retain(|slot| model.registry[*slot].group == Group::Elastic);
    }
    slots.sort_unstable();
    slots.dedup();
    slots
}

/// Diagnoses a campaign against a model. `aside` marks readings to check by.
///
/// # Errors
/// As [`calibrate`]: readings that cannot be predicted, or too few of them.
pub fn diagnose(
    model: &Model,
    campaign: &Campaign,
    aside: &[bool],
    settings: &Settings,
    progress: &mut dyn FnMut(&str),
) -> Result<Diagnosis, CalibrationError> {
    let known = nuisance(model, campaign, &settings.known);
    let mut wrong: Vec<bool> = vec![false; campaign.readings.len()];
    let mut round = Round::new(model, campaign, aside, settings, &known, &wrong, progress)?;
    // Wrong readings are found beside what explains the others, and left out of what comes next.
    for _ in 0..3 {
        let found = round.wrong(&wrong);
        if found == wrong {
            break;
        }
        wrong = found;
        progress("wrong readings set aside");
        round = Round::new(model, campaign, aside, settings, &known, &wrong, progress)?;
    }
    round.conclude(model, campaign, aside, settings, &wrong, progress)
}

/// One competition, on the readings that are not wrong.
struct Round {
    campaign: Campaign,
    aside: Vec<bool>,
    /// What is re-fitted whatever is tried, and what of it the readings tell.
    known: Vec<Slot>,
    kept: Vec<Slot>,
    values: Vec<f64>,
    evidence: Evidence,
    path: Vec<Fitted>,
    /// Noise over the stated sigma, if one is stated: 1.
    noise: Option<f64>,
    registration: f64,
    /// All readings, with their rows in the campaign.
    rows: Vec<usize>,
}

impl Round {
    fn new(
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
        let geometry = Geometry::new(model, &values).map_err(crate::prediction::PredictionError::from)?;
        let offered = survey(&geometry, &own).map_err(crate::prediction::PredictionError::from)?;
        let mut evidence = Evidence::gather(model, &own, &values, &kept, &offered, settings)?;
        let noise = own.sigma.map(|_| 1.0);
        // The competition is held on what is to be fitted; the rest only judges.
        progress("competing");
        let training = training(&evidence, &aside);
        let path = Ground::new(&training).search(noise);
        let path = refine(model, &own, &values, &aside, settings, &mut evidence, path, noise)?;
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

    fn members(&self) -> Vec<usize> {
        self.path.last().map(|fit| fit.members.clone()).unwrap_or_default()
    }

    /// Weighted residual of all rows with nuisance and members fitted to all.
    fn left(&self, members: &[usize]) -> DVector<f64> {
        let design = design(&self.evidence, members);
        let x = solve(&design, &self.evidence.residual);
        &self.evidence.residual - design * x
    }

    /// Which readings are wrong, by their distance from the best explanation in robust sigmas.
    fn wrong(&self, before: &[bool]) -> Vec<bool> {
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

    fn conclude(
        self,
        model: &Model,
        campaign: &Campaign,
        aside: &[bool],
        settings: &Settings,
        wrong: &[bool],
        progress: &mut dyn FnMut(&str),
    ) -> Result<Diagnosis, CalibrationError> {
        progress("judging");
        let evidence = &self.evidence;
        let training = training(evidence, &self.aside);
        let ground = Ground::new(&training);
        let folds = folds(evidence, &self.aside, settings.seed);
        let error = |fit: &Fitted| reading_errors(evidence, &held_out(evidence, &fit.members, &folds));
        let mut steps: Vec<Vec<(usize, Vector3<f64>)>> = vec![error(&ground.fit(&[]))];
        let mut path = vec![ground.fit(&[])];
        // What does not help readings that it was not fitted to is no cause.
        for &member in self.members().iter() {
            let last = path.last().map(|fit| fit.members.clone()).unwrap_or_default();
            let fit = ground.fit(&[last, vec![member]].concat());
            let after = error(&fit);
            if rms_max(&after)[0] < HELPS * steps.last().map_or(f64::INFINITY, |before| rms_max(before)[0]) {
                path.push(fit);
                steps.push(after);
            }
        }
        let empty = ground.fit(&[]);
        let best = path.last().cloned().unwrap_or_else(|| empty.clone());
        let variance = |fit: &Fitted| fit.squares / (ground.freedom() - fit.directions as f64).max(1.0);
        // Noise: as stated; else what repeats and markers show; else what the best explanation leaves.
        let noise = self.noise.unwrap_or_else(|| variance(&best).sqrt());
        let freedom = ground.freedom();
        let excess = |fit: &Fitted| variance(fit) / (noise * noise) - 1.0;
        let limit = 3.5 * (2.0 / freedom).sqrt() + 0.03;
        let shown = path.len() > 1;
        let mut explained = shown;
        let (before, after) = (excess(&empty), excess(&best));
        if shown && before > 0.0 && (before - after.max(0.0)) / before < NAMED {
            // Most of the gap stays: what was found is a crutch, not the cause.
            path.truncate(1);
            explained = false;
        }
        let is_significant = before > limit || shown;
        let verdict = match (path.len() > 1, explained) {
            (false, _) if !is_significant => Verdict::NoGap,
            (false, _) => Verdict::Unexplained,
            (true, _) if after <= limit || after < NEAR && after / before.max(1e-9) < EXPLAINED => Verdict::Explained,
            _ => Verdict::PartlyExplained,
        };
        let [rms, max] = rms_max(&steps[0]);
        let per_reading = self.campaign.components().min(3);
        let spread: f64 = evidence.sigmas.iter().take(per_reading).map(|s| s * s).sum::<f64>();
        let noise_length = noise * spread.sqrt();
        let gap = Gap {
            rms,
            max,
            noise: noise_length,
            closable: (rms * rms - noise_length * noise_length).max(0.0).sqrt(),
            is_significant,
            registration: self.registration,
        };
        progress("locating");
        let left = rest(&evidence.residual, &super::algebra::orthonormal(&evidence.nuisance, None));
        let shares = if is_significant {
            sites(model, &self.campaign, &self.values, evidence, &left, noise, settings.seed)?
        } else {
            Vec::new()
        };
        let in_place = reading_errors(evidence, &left);
        let directions = std::array::from_fn(|k| crate::math::mean_rms_max(in_place.iter().map(|(_, e)| e[k]))[1]);
        let regions = if is_significant { conditions(model, &self.campaign, &in_place) } else { Vec::new() };
        let location = Location { sites: shares, conditions: regions, directions };

        let members = path.last().map(|fit| fit.members.clone()).unwrap_or_default();
        let fitted = Fit::of(evidence, &members, noise);
        let mut causes = Vec::new();
        let mut rivals_of = Vec::new();
        for (step, &member) in members.iter().enumerate() {
            let hypothesis = &evidence.hypotheses[member];
            let best = &path[path.len() - 1];
            let rivals: Vec<(usize, f64)> =
                ground.rivals(best, step).into_iter().filter(|(_, loss)| *loss < RIVAL).take(8).collect();
            let weights: f64 = 1.0 + rivals.iter().map(|(_, loss)| (-0.5 * loss).exp()).sum::<f64>();
            let of = |step: usize| rms_max(&steps[step])[0];
            let (interval, _) = bootstrap(&steps[step], &steps[step + 1], settings.draws, settings.seed);
            let parameters = fitted.parameters(evidence, &members, step);
            causes.push(Cause {
                effect: hypothesis.effect.name().into(),
                site: hypothesis.site.name.clone(),
                probability: 1.0 / weights,
                entry: entry(hypothesis, &parameters),
                parameters: with_form(hypothesis, parameters),
                rms: [of(step), of(step + 1)],
                shrinkage: Shrinkage { value: 1.0 - of(step + 1) / of(step), ci95: interval },
                rivals: rivals
                    .iter()
                    .map(|(h, _)| {
                        let rival = &evidence.hypotheses[*h];
                        (rival.effect.name().to_string(), rival.site.name.clone())
                    })
                    .collect(),
                words: [hypothesis.effect.signature(), hypothesis.effect.remedy()],
                further: Vec::new(),
            });
            rivals_of.push((member, rivals));
        }
        let causes = merged(causes);
        let mut causes = causes;
        let last = path.len() - 1;
        let (interval, rms_interval) = bootstrap(&steps[0], &steps[last], settings.draws, settings.seed);
        let rms_after = rms_max(&steps[last])[0];
        let shrinkage = Shrinkage { value: 1.0 - rms_after / rms, ci95: interval };
        let outliers: Vec<usize> =
            campaign.readings.iter().zip(wrong).filter(|(_, wrong)| **wrong).map(|(r, _)| r.row).collect();
        if !outliers.is_empty() {
            causes.push(self.outliers(model, campaign, &members, wrong, rms_after)?);
        }
        let verdict = match verdict {
            Verdict::NoGap if !outliers.is_empty() => Verdict::Explained,
            other => other,
        };
        let rejected = rejected(&ground, &members, evidence);
        let values = self.values_beside(model, &causes).unwrap_or_else(|| self.values_with(&fitted));
        let next = if settings.propose && verdict != Verdict::NoGap {
            progress("proposing configurations");
            next_poses(model, &self.campaign, &values_of(&self.values), evidence, &self.kept, &rivals_of, settings.seed)
        } else {
            Vec::new()
        };
        let _ = aside;
        let mut notes = IndexMap::new();
        notes.insert(
            "noise",
            if self.noise.is_some() {
                "as the campaign states".to_string()
            } else {
                "from what the best explanation leaves".to_string()
            },
        );
        Ok(Diagnosis {
            gap,
            location,
            verdict,
            causes,
            rejected,
            after: (rms_after, rms_interval),
            shrinkage,
            next_poses: next,
            outliers,
            values,
            hypotheses: evidence.hypotheses.len(),
            notes,
        })
    }

    /// The cause `outliers`: errors with the wrong readings in, and without them.
    fn outliers(
        &self,
        model: &Model,
        campaign: &Campaign,
        members: &[usize],
        wrong: &[bool],
        after: f64,
    ) -> Result<Cause, CalibrationError> {
        let fitted = Fit::of(&self.evidence, members, 1.0);
        let values = self.values_with(&fitted);
        let mut with = model.clone();
        with.effects.extend(members.iter().enumerate().map(|(step, &member)| {
            let hypothesis = &self.evidence.hypotheses[member];
            let parameters = fitted.parameters(&self.evidence, members, step);
            entry(hypothesis, &parameters)
        }));
        let mut found = crate::prediction::Linearised::default();
        crate::prediction::Predictor::new(&with, campaign, Vec::new())?.linearise(&values, false, &mut found)?;
        let errors = estimation::errors_of(campaign, &found.residual, |_| true);
        let count = wrong.iter().filter(|w| **w).count() as f64;
        let effect = crate::effects::by_name("outliers");
        let before = errors.distance[1].max(after);
        Ok(Cause {
            effect: "outliers".into(),
            site: "instrument".into(),
            probability: 0.99,
            parameters: vec![CauseParameter { name: "count".into(), unit: "1", value: count, ci95: 0.0 }],
            rms: [before, after],
            shrinkage: Shrinkage { value: 1.0 - after / before, ci95: [1.0 - after / before; 2] },
            rivals: Vec::new(),
            words: effect.map_or(["", ""], |effect| [effect.signature(), effect.remedy()]),
            entry: RawEffect {
                effect: Some("outliers".into()),
                site: Some("instrument".into()),
                parameters: IndexMap::new(),
            },
            further: Vec::new(),
        })
    }

    /// Values calibrated anew with the causes switched on. A step from what was calibrated without them would not do:
    /// along what readings hardly tell, they drive that far off.
    fn values_beside(&self, model: &Model, causes: &[Cause]) -> Option<Vec<f64>> {
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
    fn values_with(&self, fitted: &Fit) -> Vec<f64> {
        let mut values = self.values.clone();
        for (k, &slot) in self.kept.iter().enumerate() {
            values[slot] += fitted.x[k];
        }
        values
    }
}

fn values_of(values: &[f64]) -> Vec<f64> {
    values.to_vec()
}

/// Forms of one effect at one site that were found together are one cause.
fn merged(causes: Vec<Cause>) -> Vec<Cause> {
    let mut out: Vec<Cause> = Vec::new();
    for cause in causes {
        match out.iter_mut().find(|known| known.effect == cause.effect && known.site == cause.site) {
            Some(known) => {
                known.parameters.extend(cause.parameters);
                known.further.push(cause.entry);
                known.rms[1] = cause.rms[1];
                known.shrinkage.value = 1.0 - known.rms[1] / known.rms[0];
                known.shrinkage.ci95[1] = known.shrinkage.ci95[1].max(known.shrinkage.value);
            }
            None => out.push(cause),
        }
    }
    for cause in &mut out {
        let own = (cause.effect.clone(), cause.site.clone());
        cause.rivals.retain(|rival| *rival != own);
    }
    out
}

/// The rows that are not set aside.
fn training(evidence: &Evidence, aside: &[bool]) -> Evidence {
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
#[allow(clippy::too_many_arguments)] // one step of the competition
fn refine(
    model: &Model,
    campaign: &Campaign,
    values: &[f64],
    aside: &[bool],
    _settings: &Settings,
    evidence: &mut Evidence,
    path: Vec<Fitted>,
    _noise: Option<f64>,
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
            .map(|form| {
                crate::prediction::Term::new(
                    model,
                    evidence.hypotheses[h].effect,
                    evidence.hypotheses[h].site.clone(),
                    *form,
                )
            })
            .collect();
        let (all, width) = crate::prediction::effect_columns(model, campaign, values, terms)?;
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

/// Nuisance and members fitted to all readings.
struct Fit {
    x: DVector<f64>,
    widths: DVector<f64>,
    nuisance: usize,
}

impl Fit {
    fn of(evidence: &Evidence, members: &[usize], noise: f64) -> Self {
        let design = design(evidence, members);
        let x = solve(&design, &evidence.residual);
        let left = &evidence.residual - &design * &x;
        let freedom = (evidence.rows() as f64 - design.ncols() as f64).max(1.0);
        let scale = (left.norm_squared() / freedom).sqrt().max(noise);
        let lengths: Vec<f64> = design.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
        let n = design.ncols();
        let normal = DMatrix::from_fn(n, n, |i, j| design.column(i).dot(&design.column(j)) / (lengths[i] * lengths[j]))
            + DMatrix::identity(n, n) * 1e-11;
        let inverse = normal.cholesky().map(|factor| factor.inverse());
        let widths = DVector::from_fn(n, |k, _| {
            inverse.as_ref().map_or(f64::NAN, |inverse| 1.96 * scale * inverse[(k, k)].max(0.0).sqrt() / lengths[k])
        });
        Self { x, widths, nuisance: evidence.nuisance.ncols() }
    }

    fn parameters(&self, evidence: &Evidence, members: &[usize], step: usize) -> Vec<CauseParameter> {
        let before: usize = members[..step].iter().map(|&m| evidence.hypotheses[m].columns.ncols()).sum();
        let hypothesis = &evidence.hypotheses[members[step]];
        hypothesis
            .parameters
            .iter()
            .enumerate()
            .map(|(k, parameter)| CauseParameter {
                name: parameter.symbol.clone(),
                unit: parameter.unit,
                value: self.x[self.nuisance + before + k],
                ci95: self.widths[self.nuisance + before + k],
            })
            .collect()
    }
}

/// The parameters and, beside them, what is not linear in the effect.
fn with_form(hypothesis: &Hypothesis, mut parameters: Vec<CauseParameter>) -> Vec<CauseParameter> {
    if !hypothesis.form.symbol.is_empty() {
        let (name, value) = (hypothesis.form.symbol.to_string(), hypothesis.form.value);
        parameters.push(CauseParameter { name, unit: "", value, ci95: f64::NAN });
    }
    parameters
}

/// As it is written into a description.
fn entry(hypothesis: &Hypothesis, parameters: &[CauseParameter]) -> RawEffect {
    let mut all: IndexMap<String, f64> =
        parameters.iter().map(|parameter| (parameter.name.clone(), parameter.value)).collect();
    if !hypothesis.form.symbol.is_empty() {
        all.insert(hypothesis.form.symbol.into(), hypothesis.form.value);
    }
    RawEffect {
        effect: Some(hypothesis.effect.name().into()),
        site: Some(hypothesis.site.name.clone()),
        parameters: all,
    }
}

/// What was not taken, each effect at each site in its best form, with it alone beside the causes.
fn rejected(ground: &Ground, members: &[usize], evidence: &Evidence) -> Vec<Rejected> {
    let gains = ground.gains(&[]);
    let empty = ground.fit(&[]);
    let mut best: Vec<(usize, f64)> = Vec::new();
    for (h, &(gain, _)) in gains.iter().enumerate() {
        if members.iter().any(|&m| evidence.hypotheses[m].is_same(&evidence.hypotheses[h])) {
            continue;
        }
        match best.iter_mut().find(|(known, _)| evidence.hypotheses[*known].is_same(&evidence.hypotheses[h])) {
            Some(known) if known.1 < gain => *known = (h, gain),
            Some(_) => {}
            None => best.push((h, gain)),
        }
    }
    best.sort_by(|a, b| b.1.total_cmp(&a.1));
    let size = evidence.sigmas.first().copied().unwrap_or(1.0) * 3.0_f64.sqrt();
    best.into_iter()
        .map(|(h, gain)| Rejected {
            effect: evidence.hypotheses[h].effect.name().into(),
            site: evidence.hypotheses[h].site.name.clone(),
            rms: ((empty.squares - gain).max(0.0) / ground.freedom()).sqrt() * size,
            why: if gains[h].1 == 0 {
                "calibration takes it up entirely, or its sign cannot be"
            } else if ground.is_chance(gain, gains[h].1) {
                "no more than chance"
            } else if members.is_empty() {
                "it takes up a part, and most of the gap stays"
            } else {
                "the causes found do better"
            },
        })
        .collect()
}
