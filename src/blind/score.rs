//! How often the diagnosis finds what was withheld.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use crate::description::campaign::Campaign;
use crate::diagnosis::{Settings, Verdict, diagnose};
use crate::estimation::{self, CalibrationError, calibrate, errors_of};
use crate::model::Model;
use crate::prediction::{Linearised, Predictor};

/// Most effects that a group may hold to count as an answer.
const GROUP: usize = 3;
/// Gap over the noise that divides small from plain.
const PLAIN: f64 = 1.5;

/// What a sealed campaign hides.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Name of the campaign.
    pub name: String,
    /// Kind: single, pair, triple, null, unknown.
    pub kind: String,
    /// Robot.
    pub robot: String,
    /// What a reading is.
    pub observes: String,
    /// One sigma, m.
    pub noise: f64,
    /// Root mean square after calibration, over that of the noise.
    pub gap: f64,
    /// Causes.
    pub causes: Vec<TruthCause>,
    /// Rows of outliers.
    pub outliers: Vec<usize>,
}

/// A cause that was put in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TruthCause {
    /// Effect of the catalogue, or what else it is.
    pub effect: String,
    /// Where it sits.
    pub site: String,
    /// Its size, of its shape.
    pub size: f64,
    /// The gap that it alone leaves, over the noise.
    pub gap: f64,
    /// Its shape.
    pub shape: String,
}

/// An effect at a site that was named, with what the campaign cannot distinguish from it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Named {
    /// Effect.
    pub effect: String,
    /// Site.
    pub site: String,
    /// Effects and sites that would do as well.
    pub rivals: Vec<(String, String)>,
}

impl Named {
    /// Whether it, or its small enough group, holds an effect.
    fn holds(&self, effect: &str) -> bool {
        self.effect == effect || self.group() <= GROUP && self.rivals.iter().any(|(rival, _)| rival == effect)
    }

    /// Whether it, or its small enough group, holds an effect at a site.
    fn is_at(&self, effect: &str, site: &str) -> bool {
        let own = self.effect == effect && self.site == site;
        own || self.group() <= GROUP && self.rivals.iter().any(|(e, s)| e == effect && s == site)
    }

    /// Number of effects that cannot be distinguished, itself included.
    pub fn group(&self) -> usize {
        1 + self.rivals.len()
    }
}

/// What the diagnosis found in one campaign, and how it does on a fresh one.
#[derive(Debug, Clone, Serialize)]
pub struct Examined {
    /// What was behind it.
    pub truth: Truth,
    /// Verdict in a word.
    pub verdict: &'static str,
    /// Causes named, in the order found, without outliers.
    pub named: Vec<Named>,
    /// Rows found to be outliers.
    pub outliers: Vec<usize>,
    /// Shrinkage promised, and its 95 % interval.
    pub promised: f64,
    /// Its interval, where it has one.
    pub promised_ci95: Option<[f64; 2]>,
    /// Shrinkage on the fresh campaign.
    pub realised: f64,
    /// Root mean square on the fresh campaign, calibrated only and as diagnosed, m.
    pub fresh: [f64; 2],
    /// s.
    pub seconds: f64,
}

/// What the diagnosis found: everything but the truth, which is opened afterwards.
#[derive(Debug, Clone)]
pub struct Answer {
    verdict: &'static str,
    named: Vec<Named>,
    outliers: Vec<usize>,
    promised: (f64, Option<[f64; 2]>),
    fresh: [f64; 2],
    seconds: f64,
}

impl Answer {
    /// Opens the truth.
    pub fn open(self, truth: Truth) -> Examined {
        Examined {
            truth,
            verdict: self.verdict,
            named: self.named,
            outliers: self.outliers,
            promised: self.promised.0,
            promised_ci95: self.promised.1,
            realised: 1.0 - self.fresh[1] / self.fresh[0],
            fresh: self.fresh,
            seconds: self.seconds,
        }
    }
}

/// Diagnoses a campaign and tries the outcome on a fresh one of the same machine.
///
/// # Errors
/// As [`diagnose`].
pub fn examine(model: &Model, campaign: &Campaign, fresh: &Campaign, seed: u64) -> Result<Answer, CalibrationError> {
    let started = std::time::Instant::now();
    let held_out: Vec<bool> = vec![false; campaign.readings.len()];
    let settings = Settings { propose: false, ..Settings::new(campaign, seed) };
    let found = diagnose(model, campaign, &held_out, &settings, &mut |_| {})?;
    let seconds = started.elapsed().as_secs_f64();
    let only = Some(crate::diagnosis::nuisance(model, campaign, &campaign.calibrate));
    // Outliers are left out of the plain calibration as well, so that the causes are judged alone.
    let kept = campaign.select(|_, reading| !found.outliers.contains(&reading.row));
    let asked = estimation::Settings { only, ..estimation::Settings::default() };
    let plain = calibrate(model, &kept, &vec![false; kept.readings.len()], &asked, &mut |_| {})?;
    let left = |model: &Model, values: &[f64]| -> Result<f64, CalibrationError> {
        let mut out = Linearised::default();
        Predictor::new(model, fresh, Vec::new())?.linearise(values, false, &mut out)?;
        Ok(errors_of(fresh, &out.residual, |_| true).distance[1])
    };
    let diagnosed = found.applied(model);
    let fresh = [left(model, &plain.values)?, left(&diagnosed, &diagnosed.completed(&found.values))?];
    let named = found.causes.iter().filter(|cause| cause.effect != "outliers").map(|cause| Named {
        effect: cause.effect.clone(),
        site: cause.site.clone(),
        rivals: cause.rivals.iter().map(|rival| (rival.effect.clone(), rival.site.clone())).collect(),
    });
    Ok(Answer {
        verdict: match found.verdict {
            Verdict::NoGap => "no-gap",
            Verdict::Explained => "explained",
            Verdict::PartlyExplained => "partly-explained",
            Verdict::Unexplained => "unexplained",
            Verdict::Undecided => "undecided",
        },
        named: named.collect(),
        outliers: found.outliers.clone(),
        promised: (found.shrinkage.value, found.shrinkage.ci95),
        fresh,
        seconds,
    })
}

impl Examined {
    /// Whether all true effects were named: the only one first, several in any order.
    pub fn is_hit(&self) -> bool {
        let causes = &self.truth.causes;
        let wanted = if causes.len() == 1 { 1 } else { self.named.len() };
        !causes.is_empty()
            && causes.iter().all(|cause| self.named.iter().take(wanted).any(|named| named.holds(&cause.effect)))
    }

    /// Whether all true effects were named at their sites.
    pub fn is_at_site(&self) -> bool {
        self.is_hit()
            && self.truth.causes.iter().all(|c| self.named.iter().any(|named| named.is_at(&c.effect, &c.site)))
    }

    /// Whether the answer is right: hits of known kinds, no cause named for others.
    pub fn is_right(&self) -> bool {
        match self.truth.kind.as_str() {
            "null" | "unknown" => self.named.is_empty(),
            _ => self.is_hit(),
        }
    }
}

/// One class of campaigns.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Class {
    /// Campaigns.
    pub count: usize,
    /// Right answers: hits; no cause named for nulls and unknowns.
    pub right: usize,
    /// Right sites as well.
    pub sites: usize,
}

/// The figures of all campaigns.
#[derive(Debug, Clone, Serialize)]
pub struct Score {
    /// By kind and gap: below and above 1.5 times the noise.
    pub classes: IndexMap<String, Class>,
    /// True effect, named first (of several: the named one that fits, else the first), count.
    pub confusion: IndexMap<String, IndexMap<String, usize>>,
    /// Mean size of the groups named.
    pub group: f64,
    /// Mean promised and realised shrinkage where something was named.
    pub shrinkage: [f64; 2],
    /// Share of realised shrinkages within the promised 95 % intervals.
    pub coverage: f64,
    /// Campaigns where something was named.
    pub named: usize,
    /// Outliers: true, found of these, found in all.
    pub outliers: [usize; 3],
}

/// Counts.
pub fn score(all: &[Examined]) -> Score {
    let mut classes: IndexMap<String, Class> = IndexMap::new();
    let mut confusion: IndexMap<String, IndexMap<String, usize>> = IndexMap::new();
    let mut outliers = [0; 3];
    for one in all {
        let kind = one.truth.kind.clone();
        let gap = if one.truth.gap < PLAIN { "below" } else { "above" };
        let parts = if kind == "null" { vec![kind] } else { vec![kind.clone(), format!("{kind}, {gap} 1.5")] };
        for part in parts {
            let class = classes.entry(part).or_default();
            class.count += 1;
            class.right += usize::from(one.is_right());
            class.sites += usize::from(one.is_at_site());
        }
        let first = one.named.first().map_or("-".to_string(), |named| named.effect.clone());
        if one.truth.causes.is_empty() {
            *confusion.entry("none".into()).or_default().entry(first.clone()).or_default() += 1;
        }
        for cause in &one.truth.causes {
            let fits = one.named.iter().any(|named| named.holds(&cause.effect));
            let unused = one.named.iter().find(|n| !one.truth.causes.iter().any(|c| n.holds(&c.effect)));
            let named = match (fits, unused) {
                (true, _) => cause.effect.clone(),
                (false, Some(other)) => other.effect.clone(),
                (false, None) => "-".into(),
            };
            *confusion.entry(cause.effect.clone()).or_default().entry(named).or_default() += 1;
        }
        outliers[0] += one.truth.outliers.len();
        outliers[1] += one.truth.outliers.iter().filter(|row| one.outliers.contains(row)).count();
        outliers[2] += one.outliers.len();
    }
    classes.sort_keys();
    confusion.sort_keys();
    let named: Vec<&Examined> = all.iter().filter(|one| !one.named.is_empty()).collect();
    let mean = |values: Vec<f64>| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let inside = |one: &&Examined| one.promised_ci95.is_some_and(|[low, high]| (low..=high).contains(&one.realised));
    Score {
        classes,
        confusion,
        group: mean(named.iter().flat_map(|one| one.named.iter().map(|n| n.group() as f64)).collect()),
        shrinkage: [
            mean(named.iter().map(|one| one.promised).collect()),
            mean(named.iter().map(|one| one.realised).collect()),
        ],
        coverage: mean(named.iter().map(|one| f64::from(u8::from(inside(one)))).collect()),
        named: named.len(),
        outliers,
    }
}
