//! What `identify --against` finds: the identified parameters and another set on the same readings. Lengths in mm, angles in
//! deg, stiffnesses in SI.

use serde::Serialize;

use super::errors::{CoordinateErrors, FitOrCheck, ReadingErrors};
use super::parts::{PartErrors, parts};
use super::since::MovedParameter;
use super::units::mm;
use crate::description::campaign::{Campaign, Reading};
use crate::estimation::{Against, Calibration, Change, errors_of};
use crate::math::mean_rms_max;
use crate::math::quantiles::two_sided_sign;
use crate::model::Model;

/// Errors of the readings that judge, with one set of parameters.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SetErrors {
    /// Position errors (mm), and errors of orientations and loads where readings hold them.
    #[serde(flatten)]
    pub errors: ReadingErrors,
    /// Along x, y, z, of readings that have all three.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub directions: Vec<CoordinateErrors>,
    /// By session, station, file, kind and marker, where there are several.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<PartErrors>,
}

impl SetErrors {
    /// `None` where no reading judges.
    fn new(model: &Model, campaign: &Campaign, residual: &[f64], among: &dyn Fn(usize) -> bool) -> Option<Self> {
        let along = |k: usize| {
            let readings = campaign.by_reading(residual, 1).enumerate();
            let own = readings.filter(|(index, (reading, _))| among(*index) && reading.observes.length_rows() == 3);
            mean_rms_max(own.map(|(_, (_, own))| own[k]))
        };
        let has_directions = |(index, reading): (usize, &Reading)| among(index) && reading.observes.length_rows() == 3;
        let axes = if campaign.readings.iter().enumerate().any(has_directions) { 0..3 } else { 0..0 };
        Some(Self {
            errors: ReadingErrors::new(&errors_of(campaign, residual, among))?,
            directions: axes.map(along).map(|[_, rms, max]| CoordinateErrors { rms: mm(rms), max: mm(max) }).collect(),
            parts: parts(model, campaign, residual, among),
        })
    }
}

/// In how many of the configurations that judge the identified set is closer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Closer {
    /// Configurations whose weighted sums of squares differ between the two sets.
    pub configurations: usize,
    /// Those of them in which the identified set has the smaller sum.
    pub identified_closer: usize,
    /// Probability of a count as uneven were both sets as good (sign test).
    pub chance: f64,
}

/// What the errors are before either set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Before {
    /// Deflections as they were measured.
    Measured,
    /// Residuals of the campaign's description with base and tool fitted alone.
    Registration,
}

/// The identified parameters against another set.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AgainstOther {
    /// The other description.
    pub description: String,
    /// Readings that the fit did not see; those of the fit where none were held out.
    pub judged_by: FitOrCheck,
    /// What `before` holds.
    pub before_is: Before,
    /// Errors before either set is applied.
    pub before: SetErrors,
    /// Errors with the other set.
    pub other: SetErrors,
    /// Errors with the identified set.
    pub identified: SetErrors,
    /// In how many configurations the identified set is closer.
    pub closer: Closer,
    /// Identified parameters of the robot that both sets have.
    pub parameters: Vec<Difference>,
    /// Identified parameters of the robot that the other set does not have.
    pub alone: Vec<String>,
}

impl AgainstOther {
    /// With the names and units of a model; `None` where no reading judges.
    pub fn new(
        description: &str,
        model: &Model,
        campaign: &Campaign,
        found: &Calibration,
        against: &Against,
    ) -> Option<Self> {
        let is_checked = found.held_out.contains(&true);
        let among = |index: usize| !is_checked || found.held_out[index];
        let is_difference = campaign.readings.iter().all(|reading| reading.observes.is_difference());
        let measured = || campaign.readings.iter().flat_map(|reading| &reading.measured[..reading.observes.rows()]);
        let before = if is_difference { measured().copied().collect() } else { found.registered.clone() };
        let of = |residual: &[f64]| SetErrors::new(model, campaign, residual, &among);
        Some(Self {
            description: description.into(),
            judged_by: FitOrCheck::of(is_checked),
            before_is: if is_difference { Before::Measured } else { Before::Registration },
            before: of(&before)?,
            other: of(&against.other)?,
            identified: of(&against.identified)?,
            closer: closer(campaign, &against.identified, &against.other, &among),
            parameters: against.differences.iter().map(|change| Difference::new(model, change)).collect(),
            alone: against.alone.iter().map(|slot| model.registry[*slot].name.clone()).collect(),
        })
    }
}

fn closer(campaign: &Campaign, identified: &[f64], other: &[f64], among: &dyn Fn(usize) -> bool) -> Closer {
    let mut sums = vec![[0.0; 2]; campaign.poses.len()];
    for (side, residual) in [identified, other].into_iter().enumerate() {
        for (_, (reading, own)) in campaign.by_reading(residual, 1).enumerate().filter(|(index, _)| among(*index)) {
            let sigmas = reading.observes.sigmas(&reading.noise);
            sums[reading.pose][side] += own.iter().zip(sigmas).map(|(v, sigma)| (v / sigma).powi(2)).sum::<f64>();
        }
    }
    let unequal: Vec<&[f64; 2]> = sums.iter().filter(|[identified, other]| identified != other).collect();
    let identified_closer = unequal.iter().filter(|[identified, other]| identified < other).count();
    let configurations = unequal.len();
    Closer { configurations, identified_closer, chance: two_sided_sign(identified_closer, configurations) }
}

/// An identified parameter of the robot and the other set's value, in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Difference {
    /// Name of the parameter.
    pub name: String,
    /// Unit of the values, of their difference and of its interval.
    pub unit: &'static str,
    /// Value of the other set.
    pub other: f64,
    /// Identified value.
    pub identified: f64,
    /// Identified less other.
    pub difference: f64,
    /// Half width of the 95 % interval of the difference.
    pub ci95: f64,
    /// Whether the other description states an uncertainty, which is in `ci95`.
    pub both: bool,
    /// Probability of a difference as great by chance, all parameters considered (Holm).
    pub p: f64,
    /// Whether `p` is below 5 %.
    pub differs: bool,
}

impl Difference {
    fn new(model: &Model, change: &Change) -> Self {
        let own = &model.registry[change.slot];
        let MovedParameter { name, unit, before, now, difference, ci95, both, p, moved, .. } =
            MovedParameter::new(own, change);
        Self { name, unit, other: before, identified: now, difference, ci95, both, p, differs: moved }
    }
}
