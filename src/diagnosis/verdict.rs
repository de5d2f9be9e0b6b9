//! The diagnosis from beginning to end.

use indexmap::IndexMap;
use nalgebra::Vector3;

use super::algebra::{orthonormal, rest};
use super::evidence::Evidence;
use super::figures::{Drawn, folds, held_out, reading_errors, rms_max};
use super::fit::{Fit, entry};
use super::location::{Location, conditions, sites, yielding};
use super::look_alikes::LookAlikes;
use super::next::next_poses;
use super::nuisance::nuisance;
use super::report::{Cause, CauseParameter, Diagnosis, Gap, Rejected, Shrinkage, Verdict};
use super::round::{Round, training};
use super::search::{Fitted, GREATEST, Ground};
use super::structure::{judged, structure};
use crate::description::campaign::Campaign;
use crate::estimation::{self, CalibrationError};
use crate::math::mean_rms_max;
use crate::model::Model;
use crate::prediction::{Linearised, Predictor};

/// What is asked of a diagnosis.
#[derive(Clone)]
pub struct Settings {
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
    /// The defaults for a campaign. The effects that compete are those of the model's catalogue.
    pub fn new(campaign: &Campaign, seed: u64) -> Self {
        Self { known: campaign.calibrate.clone(), seed, draws: 1000, propose: true }
    }
}

/// Merit within which another hypothesis is no worse.
const RIVAL: f64 = 9.0;
/// Members of a group that is told apart from the rest only under doubt.
const GROUP: usize = 3;
/// What is left above the noise, of what was there, when a gap counts as explained (of squares).
const EXPLAINED: f64 = 0.15;
/// A cause must leave less than this share of the error of unseen readings.
const HELPS: f64 = 0.995;
/// Share of the error that wrong readings must make up to count as a cause.
const SLIGHT: f64 = 0.01;
/// Squares left above the noise's, of the noise's, beyond which nothing counts as explained (1.5 times the noise).
const NEAR: f64 = 1.25;
/// What the causes must take away of the squares above the noise to be named at all.
const NAMED: f64 = 0.5;

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
    for _ in 0..4 {
        let found = round.wrong(&wrong);
        if found == wrong {
            break;
        }
        wrong = found;
        progress("wrong readings set aside");
        round = Round::new(model, campaign, aside, settings, &known, &wrong, progress)?;
    }
    let found = round.conclude(model, campaign, settings, &wrong, progress)?;
    let is_open = matches!(found.verdict, Verdict::Unexplained | Verdict::PartlyExplained);
    if is_open && wrong.contains(&true) && !round.stand_apart(&wrong) {
        // What nothing explains has a tail of its own.
        let none = vec![false; wrong.len()];
        let round = Round::new(model, campaign, aside, settings, &known, &none, progress)?;
        return round.conclude(model, campaign, settings, &none, progress);
    }
    Ok(found)
}

impl Round {
    fn conclude(
        &self,
        model: &Model,
        campaign: &Campaign,
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
        // Noise: as stated; else what repeats show; else what the best explanation leaves.
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
        let named = path.last().map(|fit| fit.members.clone()).unwrap_or_default();
        let structure = structure(model, &self.campaign, evidence, &named, settings.seed);
        // Where the noise is not known, what is left is noise only as far as it has no structure.
        let verdict = if self.noise.is_none() { judged(verdict, &structure) } else { verdict };
        let is_significant = verdict != Verdict::NoGap;
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
        let left = rest(&evidence.residual, &orthonormal(&evidence.nuisance, None));
        let shares = if is_significant {
            sites(model, &self.campaign, &self.values, evidence, &left, noise, settings.seed)?
        } else {
            Vec::new()
        };
        let in_place = reading_errors(evidence, &left);
        let directions = std::array::from_fn(|k| mean_rms_max(in_place.iter().map(|(_, e)| e[k]))[1]);
        let regions = if is_significant { conditions(model, &self.campaign, &in_place) } else { Vec::new() };
        let softer = if is_significant { yielding(model, &self.campaign, &in_place) } else { None };
        let location = Location { sites: shares, conditions: regions, directions, yielding: softer };

        let members = path.last().map(|fit| fit.members.clone()).unwrap_or_default();
        let fitted = Fit::of(evidence, &members, noise);
        let refitted = if members.is_empty() { None } else { self.refit(model, &members, &fitted) };
        let (values, amounts) = match refitted {
            Some((values, amounts)) => (values, Some(amounts)),
            None => (self.values_with(&fitted), None),
        };
        let drawn = Drawn::new(evidence, &members, settings.draws, settings.seed);
        let mut causes = Vec::new();
        let mut rivals_of = Vec::new();
        for (step, &member) in members.iter().enumerate() {
            let hypothesis = &evidence.hypotheses[member];
            let best = &path[path.len() - 1];
            // What readings of one configuration share counts once: beyond the sharp limit, as many as make a group.
            let near = RIVAL * evidence.rows() as f64 / self.poses() as f64 / 3.0;
            let within = |(k, rival): &(usize, (usize, f64))| rival.1 < RIVAL || *k < GROUP - 1 && rival.1 < near;
            let rivals = ground.rivals(best, step).into_iter().enumerate().filter(within).take(8);
            let rivals: Vec<(usize, f64)> = rivals.map(|(_, rival)| rival).collect();
            let weights: f64 = 1.0 + rivals.iter().map(|(_, loss)| (-0.5 * loss.max(0.0)).exp()).sum::<f64>();
            let of = |step: usize| rms_max(&steps[step])[0];
            let value = 1.0 - of(step + 1) / of(step);
            let parameters = match &amounts {
                Some(amounts) => amounts[step].clone(),
                None => fitted.parameters(evidence, &members, step),
            };
            causes.push(Cause {
                effect: hypothesis.effect.name().into(),
                site: hypothesis.site.name.clone(),
                probability: 1.0 / weights,
                entries: vec![entry(hypothesis, &parameters)],
                parameters,
                rms: [of(step), of(step + 1)],
                shrinkage: Shrinkage { value, ci95: drawn.shrinkage(step, step + 1, value) },
                rivals: rivals
                    .iter()
                    .map(|(h, _)| {
                        let rival = &evidence.hypotheses[*h];
                        (rival.effect.name().to_string(), rival.site.name.clone())
                    })
                    .collect(),
                words: [hypothesis.effect.signature(), hypothesis.effect.remedy()],
            });
            rivals_of.push((member, rivals));
        }
        let mut causes = merged(causes);
        let last = path.len() - 1;
        let rms_after = rms_max(&steps[last])[0];
        let value = 1.0 - rms_after / rms;
        let shrinkage = Shrinkage { value, ci95: drawn.shrinkage(0, last, value) };
        let rms_interval = drawn.rms(last, rms_after);
        let outliers: Vec<usize> =
            campaign.readings.iter().zip(wrong).filter(|(_, wrong)| **wrong).map(|(r, _)| r.row).collect();
        if !outliers.is_empty() {
            let cause = self.outliers(model, campaign, &members, wrong, rms_after)?;
            // A few readings just beyond what noise does are named; they explain no gap.
            causes.extend(Some(cause).filter(|cause| cause.shrinkage.value >= SLIGHT));
        }
        let verdict = match verdict {
            Verdict::NoGap if causes.iter().any(|cause| cause.effect == "outliers") => Verdict::Explained,
            other => other,
        };
        let (rejected, with_none) = rejected(&ground, &members, evidence);
        let next = if settings.propose && verdict != Verdict::NoGap {
            progress("proposing configurations");
            next_poses(model, &self.campaign, &self.values, evidence, &self.kept, &rivals_of, settings.seed)
        } else {
            Vec::new()
        };
        let mut notes = IndexMap::new();
        notes.insert(
            "noise",
            if self.campaign.sigma.is_some() {
                "as the campaign states".to_string()
            } else if self.noise.is_some() {
                "from repeated readings".to_string()
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
            with_none,
            after: (rms_after, rms_interval),
            structure,
            shrinkage,
            next_poses: next,
            outliers,
            values,
            look_alikes: LookAlikes::of(&ground, &members, evidence),
            calibrated: self.values.clone(),
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
        let mut with = model.clone();
        for (step, &member) in members.iter().enumerate() {
            let parameters = fitted.parameters(&self.evidence, members, step);
            with.switch_on(entry(&self.evidence.hypotheses[member], &parameters));
        }
        let values = with.completed(&self.values_with(&fitted));
        let mut found = Linearised::default();
        Predictor::new(&with, campaign, Vec::new())?.linearise(&values, false, &mut found)?;
        let errors = estimation::errors_of(campaign, &found.residual, |_| true);
        let count = wrong.iter().filter(|w| **w).count() as f64;
        let effect = model.catalogue.get("outliers");
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
            entries: Vec::new(),
        })
    }
}

/// Forms of one effect at one site that were found together are one cause.
fn merged(causes: Vec<Cause>) -> Vec<Cause> {
    let mut out: Vec<Cause> = Vec::new();
    for cause in causes {
        match out.iter_mut().find(|known| known.effect == cause.effect && known.site == cause.site) {
            Some(known) => {
                known.parameters.extend(cause.parameters);
                known.entries.extend(cause.entries);
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

/// What was not taken, each effect at each site in its best form, with it alone; and the error with none at all, likewise
/// of all readings, by degree of freedom.
fn rejected(ground: &Ground, members: &[usize], evidence: &Evidence) -> (Vec<Rejected>, f64) {
    let gains = ground.gains(&[], GREATEST);
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
    let left = |gain: f64| ((empty.squares - gain).max(0.0) / ground.freedom()).sqrt() * size;
    let rejected = best
        .into_iter()
        .map(|(h, gain)| Rejected {
            effect: evidence.hypotheses[h].effect.name().into(),
            site: evidence.hypotheses[h].site.name.clone(),
            rms: left(gain),
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
        .collect();
    (rejected, left(0.0))
}
