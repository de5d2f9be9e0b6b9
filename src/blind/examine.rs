//! What the diagnosis says of a sealed campaign, before its truth is opened.

use serde::Serialize;

use crate::description::campaign::Campaign;
use crate::diagnosis::{Cause, Level, Settings, Support, Verdict, diagnose};
use crate::diagnostic::Diagnostic;
use crate::estimation::{self, CalibrationError, calibrate, errors_of};
use crate::model::{Catalogue, Family, Model};
use crate::plausibility::{Evidence, Limits, doubts, judge, refusing};
use crate::prediction::residuals;

/// Most effects that a group may hold to count as an answer.
const GROUP: usize = 3;

/// An effect at a site that was named, with what the campaign cannot distinguish from it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Named {
    /// Effect.
    pub effect: String,
    /// Whether it is a curve without a law at its site.
    #[serde(skip)]
    pub is_free: bool,
    /// Site.
    pub site: String,
    /// Effects and sites that would do as well.
    pub rivals: Vec<(String, String)>,
    /// How much of it is claimed.
    pub level: Level,
    /// Its probability.
    pub probability: Option<f64>,
    /// How often it is the best by half of the configurations, of what is claimed.
    pub stability: Option<f64>,
    /// What speaks for its law.
    pub support: Option<Support>,
    /// Whether it is tied with a true cause on these readings ([`super::Signals`]).
    pub tied: bool,
}

impl Named {
    fn new(cause: &Cause) -> Self {
        Self {
            effect: cause.effect.clone(),
            is_free: cause.is_free,
            site: cause.site.clone(),
            rivals: cause.rivals.iter().map(|rival| (rival.effect.clone(), rival.site.clone())).collect(),
            level: cause.level,
            probability: cause.probability,
            stability: cause.stability.map(|stability| stability.of(cause.level)),
            support: cause.support,
            tied: false,
        }
    }

    /// Whether it is an effect of the catalogue: neither a curve without a law nor a family.
    pub fn is_of_catalogue(&self) -> bool {
        self.level == Level::Law
    }

    /// Whether only its family is known: neither a law nor a curve at a site.
    pub fn is_family(&self) -> bool {
        self.level != Level::Law && !self.is_free
    }

    /// Whether it, or its small enough group, holds an effect.
    pub fn holds(&self, effect: &str) -> bool {
        self.effect == effect || self.group() <= GROUP && self.rivals.iter().any(|(rival, _)| rival == effect)
    }

    /// Whether it, or its small enough group, holds an effect at a site.
    pub fn is_at(&self, effect: &str, site: &str) -> bool {
        self.members().any(|(e, s)| e == effect && s == site)
    }

    /// Itself and, where they are few enough, what cannot be distinguished from it: effects and sites.
    pub fn members(&self) -> impl Iterator<Item = (&str, &str)> {
        let rivals = if self.group() <= GROUP { &self.rivals[..] } else { &[] };
        let others = rivals.iter().map(|(effect, site)| (effect.as_str(), site.as_str()));
        std::iter::once((self.effect.as_str(), self.site.as_str())).chain(others)
    }

    /// Number of effects that cannot be distinguished, itself included where it is one and no family.
    pub fn group(&self) -> usize {
        usize::from(!self.is_family()) + self.rivals.len()
    }
}

/// What the diagnosis found: everything but the truth, which is opened afterwards.
#[derive(Debug, Clone)]
pub struct Answer {
    pub(super) verdict: &'static str,
    pub(super) doubted: Vec<String>,
    pub(super) named: Vec<Named>,
    pub(super) outliers: Vec<usize>,
    pub(super) promised: (f64, Option<[f64; 2]>),
    pub(super) fresh: [f64; 2],
    pub(super) seconds: f64,
}

impl Answer {
    /// Of readings that are refused, or with which nothing can be done.
    fn refused(why: String, seconds: f64) -> Self {
        let (named, outliers) = (Vec::new(), Vec::new());
        Self {
            verdict: "refused",
            doubted: vec![why],
            named,
            outliers,
            promised: (0.0, None),
            fresh: [1.0; 2],
            seconds,
        }
    }
}

/// Diagnoses a campaign, as `diagnose` does, and tries the outcome on a fresh one of the same machine. Readings that are
/// refused, or cannot be calibrated, are an answer too.
///
/// # Errors
/// A fresh campaign that cannot be predicted.
pub fn examine(model: &Model, campaign: &Campaign, fresh: &Campaign, seed: u64) -> Result<Answer, CalibrationError> {
    let started = std::time::Instant::now();
    let seconds = || started.elapsed().as_secs_f64();
    let limits = Limits::default();
    let mut judged = judge(&Evidence::of(model, campaign), &limits);
    if let Some(found) = refusing(judged.clone(), false) {
        return Ok(Answer::refused(implausible(&found).join(", "), seconds()));
    }
    let held_out: Vec<bool> = vec![false; campaign.readings.len()];
    let settings = Settings { propose: false, ..Settings::new(campaign, seed) };
    let found = match diagnose(model, campaign, &held_out, &settings, &mut |_| {}) {
        Ok(found) => found,
        Err(error) => return Ok(Answer::refused(error.to_string(), seconds())),
    };
    let taken = seconds();
    judged.extend(doubts(model, campaign, &found, &limits));
    let only = Some(crate::model::nuisance(model, campaign, &campaign.calibrate));
    // Outliers are left out of the plain calibration as well, so that the causes are judged alone.
    let kept = campaign.select(|_, reading| !found.outliers.contains(&reading.row));
    let asked = estimation::Settings { only, ..estimation::Settings::default() };
    let plain = match calibrate(model, &kept, &vec![false; kept.readings.len()], &asked, &mut |_| {}) {
        Ok(plain) => plain,
        Err(error) => return Ok(Answer::refused(error.to_string(), taken)),
    };
    let left = |model: &Model, values: &[f64]| -> Result<f64, CalibrationError> {
        let out = residuals(model, fresh, values)?;
        Ok(errors_of(fresh, &out, |_| true).distance[1])
    };
    let diagnosed = found.applied(model);
    let fresh = [left(model, &plain.values)?, left(&diagnosed, &diagnosed.completed(&found.values))?];
    Ok(Answer {
        verdict: match found.verdict {
            Verdict::NoGap => "no-gap",
            Verdict::Explained => "explained",
            Verdict::PartlyExplained => "partly-explained",
            Verdict::Unexplained => "unexplained",
            Verdict::Undecided => "undecided",
        },
        doubted: implausible(&judged),
        named: found.causes.iter().filter(|cause| cause.family != Family::Gross).map(Named::new).collect(),
        outliers: found.outliers.clone(),
        promised: (found.shrinkage.value, found.shrinkage.ci95),
        fresh,
        seconds: taken,
    })
}

/// Codes of what speaks against the readings being what they are said to be.
fn implausible(found: &[Diagnostic]) -> Vec<String> {
    let doubts = found.iter().filter(|diagnostic| diagnostic.code.is_plausibility());
    doubts.map(|diagnostic| diagnostic.code.name().to_string()).collect()
}

/// The model whose catalogue lacks an effect; `None` where it has none of that name, or the campaign calibrates it.
pub fn without(model: &Model, campaign: &Campaign, effect: &str) -> Option<Model> {
    model.catalogue.get(effect)?;
    if campaign.calibrate.iter().any(|name| name == effect) {
        return None;
    }
    let others = model.catalogue.iter().filter(|other| other.name() != effect).cloned().collect();
    Some(Model { catalogue: Catalogue::new(others).into(), ..model.clone() })
}
