//! What a diagnosis says.

use indexmap::IndexMap;

use super::location::Location;
use super::look_alikes::LookAlikes;
use super::structure::Structure;
use crate::description::raw::RawAmount;
use crate::effects::EffectEntry;
use crate::model::Model;

/// What comes out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Calibration leaves nothing but noise.
    NoGap,
    /// The causes named leave nothing but noise.
    Explained,
    /// They leave something.
    PartlyExplained,
    /// There is a gap, and nothing in the catalogue explains it.
    Unexplained,
}

/// The gap that calibration leaves, on readings it did not see. Lengths in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// Root mean square position error.
    pub rms: f64,
    /// Greatest.
    pub max: f64,
    /// What noise alone would give.
    pub noise: f64,
    /// The gap above the noise: sqrt(rms^2 - noise^2).
    pub closable: f64,
    /// Whether it is more than chance.
    pub is_significant: bool,
    /// Root mean square error with base and tool fitted alone, on all readings.
    pub registration: f64,
}

/// A fitted parameter of a cause, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct CauseParameter {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: &'static str,
    /// Value; of a constant of the model: its change.
    pub value: f64,
    /// Half width of its 95 % interval.
    pub ci95: f64,
}

/// How far the gap shrinks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shrinkage {
    /// 1 - after / before.
    pub value: f64,
    /// 95 % interval by configuration.
    pub ci95: [f64; 2],
}

/// A cause, in the order found.
#[derive(Debug, Clone)]
pub struct Cause {
    /// Effect.
    pub effect: String,
    /// Site.
    pub site: String,
    /// Probability among those that would do in its place.
    pub probability: f64,
    /// Parameters.
    pub parameters: Vec<CauseParameter>,
    /// Root mean square errors before and after it was added, m, held out.
    pub rms: [f64; 2],
    /// How far the gap shrinks by it.
    pub shrinkage: Shrinkage,
    /// What this campaign cannot tell from it: effect, site.
    pub rivals: Vec<(String, String)>,
    /// Signature and remedy, in words.
    pub words: [&'static str; 2],
    /// The effect with its amounts; several where it was found with different nonlinear values, none of outliers.
    pub entries: Vec<EffectEntry>,
}

/// A parameter as it is reported: name, unit, value, half width of its 95 % interval where it has one.
pub type ReportedParameter = (String, &'static str, RawAmount, Option<f64>);

impl Cause {
    /// Parameters of each entry, its nonlinear values after its amounts.
    pub fn reported(&self, model: &Model) -> Vec<ReportedParameter> {
        let variables = model.variable_names();
        let mut amounts = self.parameters.iter();
        let mut all = Vec::new();
        let one = |p: &CauseParameter| (p.name.clone(), p.unit, p.value.into(), Some(p.ci95).filter(|w| w.is_finite()));
        for entry in &self.entries {
            all.extend(amounts.by_ref().take(entry.amounts.len()).map(one));
            let nonlinear = entry.nonlinear.written(&variables).into_iter();
            all.extend(nonlinear.map(|(name, unit, value)| (name.to_string(), unit, value, None)));
        }
        all.extend(amounts.map(one));
        all
    }
}

impl Diagnosis {
    /// Entries of all causes: what a description has to switch on.
    pub fn entries(&self) -> impl Iterator<Item = &EffectEntry> {
        self.causes.iter().flat_map(|cause| &cause.entries)
    }

    /// The model with all causes switched on; [`Model::completed`] makes [`Diagnosis::values`] its own.
    #[must_use]
    pub fn applied(&self, model: &Model) -> Model {
        let mut with = model.clone();
        self.entries().for_each(|entry| with.switch_on(entry.clone()));
        with
    }
}

/// A hypothesis that was not taken.
#[derive(Debug, Clone, PartialEq)]
pub struct Rejected {
    /// Effect.
    pub effect: String,
    /// Site.
    pub site: String,
    /// Root mean square error with it alone, m, of the fitted readings.
    pub rms: f64,
    /// Why.
    pub why: &'static str,
}

/// A configuration that would separate rivals.
#[derive(Debug, Clone, PartialEq)]
pub struct NextPose {
    /// Variables, rad and m.
    pub q: Vec<f64>,
    /// Wrench, N and N.m.
    pub wrench: [f64; 6],
    /// What it separates.
    pub separates: [String; 2],
    /// How far apart the two predict its reading, m.
    pub apart: f64,
    /// The same over the noise of one coordinate.
    pub sigmas: f64,
}

/// A diagnosis.
#[derive(Debug, Clone)]
pub struct Diagnosis {
    /// The gap.
    pub gap: Gap,
    /// Where it lies.
    pub location: Location,
    /// Verdict.
    pub verdict: Verdict,
    /// Causes.
    pub causes: Vec<Cause>,
    /// Rejected hypotheses, the nearest first.
    pub rejected: Vec<Rejected>,
    /// What stands for [`Rejected::rms`] with no effect at all, m.
    pub with_none: f64,
    /// Root mean square error with all causes, m, held out, and its 95 % interval.
    pub after: (f64, [f64; 2]),
    /// Structure left beside all causes.
    pub structure: Vec<Structure>,
    /// Shrinkage by all causes.
    pub shrinkage: Shrinkage,
    /// Configurations that would separate rivals.
    pub next_poses: Vec<NextPose>,
    /// Rows of readings that are simply wrong.
    pub outliers: Vec<usize>,
    /// Calibrated values of the model with the causes in, by slot.
    pub values: Vec<f64>,
    /// Calibrated values without the causes: what the hypotheses competed on.
    pub calibrated: Vec<f64>,
    /// Which hypotheses look alike in these readings.
    pub look_alikes: LookAlikes,
    /// Number of hypotheses that competed.
    pub hypotheses: usize,
    /// Free notes: what was tested and what could not be.
    pub notes: IndexMap<&'static str, String>,
}
