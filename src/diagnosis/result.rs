//! What a diagnosis finds: plain structs. Lengths in m and amounts in SI; frames as stated.

use indexmap::IndexMap;
use serde::Serialize;

use super::level::{Level, Stability, Support};
use crate::description::campaign::Amount;
use crate::description::raw::RawAmount;
use crate::effects::{EffectEntry, Family};
use crate::estimation::Calibration;
use crate::model::Model;
use crate::parameter::Slot;

/// The answer of a diagnosis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Calibration leaves nothing but noise.
    NoGap,
    /// The causes named leave nothing but noise.
    Explained,
    /// The causes named leave more than noise.
    PartlyExplained,
    /// There is a gap, and nothing in the catalogue explains it.
    Unexplained,
    /// No gap shows, but there is too little to say that there is none: few configurations, hardly more readings than
    /// parameters, or no hypothesis that could have shown.
    Undecided,
}

/// The gap that calibration leaves, on readings that were not fitted. Lengths in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// Root mean square position error.
    pub rms: f64,
    /// Greatest position error.
    pub max: f64,
    /// Root mean square position error by noise alone.
    pub noise: f64,
    /// The gap above the noise: sqrt(rms^2 - noise^2).
    pub closable: f64,
    /// Whether it is more than chance.
    pub is_significant: bool,
    /// Root mean square error with base and tool fitted alone, over all readings; `None` where nothing is fitted.
    pub registration: Option<f64>,
}

/// An effect at a site.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct EffectAtSite {
    /// Name of the effect in the catalogue.
    pub effect: String,
    /// Name of the site, for example `joint:2`.
    pub site: String,
}

/// A parameter of a cause: fitted, SI, or nonlinear and chosen.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CauseParameter {
    /// Name.
    pub name: String,
    /// Unit; empty where it has none.
    pub unit: &'static str,
    /// Value; of a constant of the model: its change.
    pub value: RawAmount,
    /// Half width of its 95 % interval, with what it is nonlinear in fitted too; `None` for a value that was chosen, or that the readings do not tell.
    pub ci95: Option<f64>,
}

/// How far the gap shrinks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shrinkage {
    /// 1 - after / before.
    pub value: f64,
    /// 95 % interval, by bootstrap over configurations; `None` where it cannot be drawn.
    pub ci95: Option<[f64; 2]>,
}

/// A cause, in the order found.
#[derive(Debug, Clone)]
pub struct Cause {
    /// Name of the effect.
    pub effect: String,
    /// Name of the site.
    pub site: String,
    /// Whether it is a curve of any shape at its site, without a law.
    pub is_free: bool,
    /// Probability among the hypotheses that would do in its place; `None` where no hypothesis competes with it
    /// (outliers).
    pub probability: Option<f64>,
    /// Fitted parameters and nonlinear ones.
    pub parameters: Vec<CauseParameter>,
    /// Root mean square error before it was added, m, cross-validated.
    pub rms_before: f64,
    /// Root mean square error after it was added, m, cross-validated.
    pub rms_after: f64,
    /// How far the gap shrinks by it.
    pub shrinkage: Shrinkage,
    /// What this campaign cannot distinguish from it.
    pub rivals: Vec<EffectAtSite>,
    /// What the effect looks like in residuals.
    pub signature: &'static str,
    /// What to do on the machine.
    pub remedy: &'static str,
    /// What kind of thing it is.
    pub family: Family,
    /// How much of it is certain.
    pub level: Level,
    /// What it follows, as a column or a curve is named; `None` of constants.
    pub follows: Option<String>,
    /// How often it wins over half-samples; `None` of outliers.
    pub stability: Option<Stability>,
    /// What speaks for its law; `None` of outliers and curves.
    pub support: Option<Support>,
    /// Its curve, of a free form at a joint or the instrument.
    pub curve: Option<Curve>,
    /// Its curves by component (x, y, z, rx, ry, rz), of a free form at the base or the tool.
    pub curves: IndexMap<String, Curve>,
    /// What its amounts mean on the machine, in words.
    pub implies: Vec<String>,
    /// The effect with its amounts, as it is switched on and written into a description; several where it was found with
    /// different nonlinear values, none of outliers.
    pub entries: Vec<EffectEntry>,
}

/// An effect that could not compete.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct NotTried {
    /// Name of the effect.
    pub effect: String,
    /// What the campaign or the description lacks.
    pub needs: String,
}

/// An effect that another measurement speaks against.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Excluded {
    /// Name of the effect.
    pub effect: String,
    /// Name of the site.
    pub site: String,
    /// What excludes it, with its figure.
    pub by: String,
}

/// A free curve, with mean zero where a constant cannot be distinguished from what is calibrated.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Curve {
    /// What it follows, SI.
    pub at: Vec<f64>,
    /// Amounts, rad or m; of the instrument the part by which it reads too long.
    pub amount: Vec<f64>,
    /// Half widths of their 95 % intervals.
    pub band: Vec<f64>,
    /// Unit of what it follows.
    pub unit: &'static str,
    /// Unit of amounts and bands.
    pub amount_unit: &'static str,
    /// Whether it is what stays off a straight line, for which constants that are calibrated can stand.
    #[serde(rename = "without_line", skip_serializing_if = "std::ops::Not::not")]
    pub is_without_line: bool,
}

impl Curve {
    /// The unit in which amounts are shown, and how many of it are one of theirs.
    pub fn shown_in(&self) -> (&'static str, f64) {
        match self.amount_unit {
            "rad" => ("mrad", 1e3),
            "m" => ("mm", 1e3),
            _ => ("ppm", 1e6),
        }
    }

    /// Whether an amount is not zero with 95 %.
    pub fn is_certain(&self) -> bool {
        self.amount.iter().zip(&self.band).any(|(amount, band)| amount.abs() > *band)
    }
}

/// What all causes leave.
#[derive(Debug, Clone, PartialEq)]
pub struct Rest {
    /// Root mean square error above the noise, of readings that were not fitted, m.
    pub rms: f64,
    /// The site of the curve that takes most of it away, where that is certain.
    pub site: Option<String>,
    /// What that curve follows.
    pub follows: Option<String>,
    /// The site of a curve in it for which the intervals of the amounts of the causes allow where these could take it up.
    pub allowed_for: Option<String>,
    /// The few angles of one joint at which most of it lies, where that is certain and the answer is open.
    pub few_angles: Option<FewAngles>,
}

/// An error at a few angles of one joint, as a damaged tooth makes: a raised cosine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FewAngles {
    /// The joint's site.
    pub site: String,
    /// Its variable.
    pub variable: String,
    /// Where the error is greatest, deg.
    pub at_deg: f64,
    /// How far from there it is none, deg.
    pub half_width_deg: f64,
    /// The greatest error of the joint's angle, deg.
    pub amount_deg: f64,
    /// Share of the squares that are left, those of known noise taken off, that it takes away.
    pub share: f64,
}

/// A hypothesis that was not selected.
#[derive(Debug, Clone, PartialEq)]
pub struct Rejected {
    /// Name of the effect.
    pub effect: String,
    /// Name of the site.
    pub site: String,
    /// Root mean square error with it alone, m, of the fitted readings, by degree of freedom.
    pub rms: f64,
    /// Why it was not selected.
    pub why: &'static str,
}

/// A configuration that would distinguish two rivals.
#[derive(Debug, Clone, PartialEq)]
pub struct NextPose {
    /// Actuated variables, rad and m.
    pub q: Vec<f64>,
    /// Wrench at the tool, N and N.m, measurement frame.
    pub wrench: [f64; 6],
    /// The two rivals, `effect@site`.
    pub separates: [String; 2],
    /// Distance between the two predictions of the reading, m.
    pub apart: f64,
    /// The same with each coordinate divided by its noise.
    pub sigmas: f64,
}

/// Share of the gap that a free local error at a site could carry.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SiteShare {
    /// Name of the site.
    pub site: String,
    /// Share of the squared gap above the noise, beyond what as many directions carry of any motion of the tool.
    pub share: f64,
    /// 95 % interval, by bootstrap over configurations.
    pub ci95: [f64; 2],
}

/// A region of the campaign in which the gap is greatest.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// The region as inequalities, for example `q2 > 40 deg`.
    pub when: String,
    /// Root mean square error inside, m.
    pub rms: f64,
    /// Root mean square error outside, m.
    pub elsewhere: f64,
}

/// A region in which measured deflections exceed the predicted ones: the description is too stiff there.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExcessCompliance {
    /// The region as inequalities.
    pub when: String,
    /// Measured deflections over predicted ones, less 1 (least squares over the region).
    pub excess: f64,
    /// The same outside.
    pub elsewhere: f64,
}

/// Where the gap lies.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Location {
    /// By site, the greatest share first; empty where the gap is not significant.
    pub sites: Vec<SiteShare>,
    /// By region; empty where the gap is not significant.
    pub regions: Vec<Region>,
    /// Root mean square error by direction, m, measurement frame.
    pub directions: [f64; 3],
    /// For deflections: the region in which the robot is most compliant compared with its description.
    pub excess_compliance: Option<ExcessCompliance>,
}

/// Autocorrelation of residuals between neighbours, tested by permutation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Autocorrelation {
    /// Neighbours in what: `configuration`, `load`, `time`, or `within a pose`.
    pub against: &'static str,
    /// Correlation of the residuals of neighbours.
    pub correlation: f64,
    /// Probability of as much by chance.
    pub p: f64,
}

/// Which hypotheses look alike in the readings of the campaign.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct LookAlikes {
    /// The hypotheses compared.
    pub hypotheses: Vec<EffectAtSite>,
    /// By row: share (0 to 1) of what the row's hypothesis changes in the readings that the column's can reproduce, the
    /// mean squared cosine of the row's directions with the column's space. Not symmetric where one has more parameters.
    pub overlap: Vec<Vec<f64>>,
}

/// Where the noise that a gap is compared with comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoiseSource {
    /// The campaign states it.
    Stated,
    /// Scatter of repeated readings.
    Repeated,
    /// Residuals of the best explanation.
    Residual,
}

/// A diagnosis.
#[derive(Debug, Clone)]
pub struct Diagnosis {
    /// The gap.
    pub gap: Gap,
    /// Where it lies.
    pub location: Location,
    /// The answer.
    pub verdict: Verdict,
    /// Causes, in the order found; outliers, which are set aside before anything is fitted, first, or last where a greater gap hides them.
    pub causes: Vec<Cause>,
    /// Hypotheses that were not selected, the nearest first.
    pub rejected: Vec<Rejected>,
    /// What corresponds to [`Rejected::rms`] with no effect at all, m.
    pub rms_with_none: f64,
    /// Root mean square error with all causes, m, cross-validated.
    pub rms_after: f64,
    /// Its 95 % interval, by bootstrap over configurations.
    pub rms_after_ci95: Option<[f64; 2]>,
    /// Root mean square error without those causes that belong to the session, m: what a description with the others leaves of these
    /// readings; `None` where all causes are the robot's.
    pub rms_of_robot: Option<f64>,
    /// Autocorrelation of the residuals that all causes leave.
    pub autocorrelation: Vec<Autocorrelation>,
    /// Shrinkage by all causes.
    pub shrinkage: Shrinkage,
    /// Configurations that would distinguish rivals.
    pub next_poses: Vec<NextPose>,
    /// Rows of the readings that are outliers.
    pub outliers: Vec<usize>,
    /// Where these stand: file and line.
    pub outliers_at: Vec<String>,
    /// Root mean square and greatest error before outliers were set aside, m; `None` where they are no cause, or hidden by a greater gap.
    pub with_outliers: Option<[f64; 2]>,
    /// Calibrated values of the model with the causes added, by slot.
    pub values: Vec<f64>,
    /// Whether the tolerances of the description pulled the calibration, which did not converge without them.
    pub is_pulled: bool,
    /// The calibration that the hypotheses start from, on the readings without outliers; `None` where nothing is fitted.
    pub calibration: Option<Calibration>,
    /// Parameters that are re-fitted with every hypothesis.
    pub refitted: Vec<Slot>,
    /// How many configurations were drawn of how many, where all of them would take too much memory.
    pub drawn_from: Option<[usize; 2]>,
    /// How much the fitted readings hold that is not a repetition, and the parameters that are re-fitted with every hypothesis.
    pub evidence: (Amount, usize),
    /// Calibrated values without the causes: where the hypotheses were compared.
    pub calibrated: Vec<f64>,
    /// Which hypotheses look alike in these readings.
    pub look_alikes: LookAlikes,
    /// Effects that could not compete, and what they need.
    pub not_tried: Vec<NotTried>,
    /// What other measurements exclude.
    pub excluded: Vec<Excluded>,
    /// What all causes leave.
    pub rest: Rest,
    /// Number of hypotheses compared.
    pub hypotheses: usize,
    /// Where the noise comes from.
    pub noise_source: NoiseSource,
}

impl Diagnosis {
    /// Entries of all causes: what a description has to switch on.
    pub fn entries(&self) -> impl Iterator<Item = &EffectEntry> {
        self.causes.iter().flat_map(|cause| &cause.entries)
    }

    /// The model with all causes switched on; [`Model::completed`] extends [`Diagnosis::values`] to it.
    #[must_use]
    pub fn applied(&self, model: &Model) -> Model {
        let mut with = model.clone();
        self.entries().for_each(|entry| with.switch_on(entry.clone()));
        with
    }
}
