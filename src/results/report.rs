//! What `report` finds: what `identify` and `diagnose` find, and what only a report shows. Lengths in mm, angles in deg,
//! forces in N; residuals in the measurement frame.

use indexmap::IndexMap;
use serde::Serialize;

use super::campaign::kinds;
use super::diagnosis::Diagnosis;
use super::identifiability::Sensitivities;
use super::identification::Identification;
use super::own_weight::OwnWeight;
use super::units::{mm, shown, shown_unit};
use crate::description::campaign::Campaign;
use crate::diagnostic::Diagnostic;
use crate::math::distinct;
use crate::model::Model;
use crate::observation::Observes;
use crate::review::{Node, Review, Slice, Stage, StageKey};

/// The campaign.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CampaignSummary {
    /// Name of the campaign.
    pub name: String,
    /// Name of the robot.
    pub robot: String,
    /// Kind of the readings, as the campaign declares it.
    pub observes: Observes,
    /// Readings by kind.
    pub kinds: IndexMap<&'static str, usize>,
    /// Number of readings.
    pub readings: usize,
    /// Number of distinct configurations.
    pub poses: usize,
    /// Readings held out.
    pub set_aside: usize,
    /// Noise of a coordinate; `None` where none is stated.
    pub sigma: Option<[f64; 3]>,
    /// Unit of errors.
    pub unit: &'static str,
    /// Effects that a diagnosis re-fits whatever it tries.
    pub calibrate: Vec<String>,
    /// Elements of the description left out.
    pub without: Vec<String>,
    /// Whether the base's pose in the measurement frame is unknown.
    pub estimate_base: bool,
    /// Whether tool or markers are unknown.
    pub estimate_tool: bool,
    /// Whether the readings are predicted with own weight.
    pub own_weight: OwnWeight,
}

/// Commands that find the same.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sources {
    /// The `identify` command.
    pub identify: String,
    /// The `diagnose` command.
    pub diagnose: String,
    /// The `stiffness` command; joints are to be filled in.
    pub stiffness: String,
    /// The `residuals` command.
    pub residuals: String,
    /// The `sensitivity` command.
    pub sensitivity: String,
    /// The `report` command.
    pub report: String,
}

impl Sources {
    /// `given`: the campaign with its flags; `robot`: its description.
    pub fn new(given: &str, robot: &str) -> Self {
        Self {
            identify: format!("elastogeo identify {given}"),
            diagnose: format!("elastogeo diagnose {given}"),
            stiffness: format!("elastogeo stiffness {robot} --joints .."),
            residuals: format!("elastogeo residuals {robot} {given}"),
            sensitivity: format!("elastogeo sensitivity {robot} {given}"),
            report: format!("elastogeo report {given}"),
        }
    }
}

/// What the errors are after a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum StepKey {
    /// Of the description as it is.
    Described,
    /// With base, tool and markers fitted alone.
    Registered,
    /// As the calibration left them.
    Calibrated,
    /// With what a diagnosis re-fits.
    Competed,
    /// With one more effect.
    Effect,
    /// Expected by noise alone.
    Noise,
}

/// A step from the description as it is down to the noise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WaterfallStep {
    /// Which step.
    pub key: StepKey,
    /// The step in words.
    pub label: String,
    /// Root mean square position error.
    pub rms: f64,
    /// The command that finds it.
    pub source: &'static str,
    /// Of which readings.
    pub on: &'static str,
}

/// A stage at which residuals are given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct StageLabel {
    /// Which stage.
    pub key: StageKey,
    /// The stage in words.
    pub label: &'static str,
}

/// A swept variable.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Swept {
    /// Name of the variable.
    pub name: String,
    /// `deg` or `mm`.
    pub unit: &'static str,
}

/// Units of a slice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct SliceUnits {
    /// Of the places, `at`.
    pub at: &'static str,
    /// Of the least stiffness, `least`.
    pub least: &'static str,
    /// Of the semi-axes, `ellipse`.
    pub ellipse: &'static str,
}

/// A configuration of a slice.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SliceNode {
    /// The swept variables.
    pub q: [f64; 2],
    /// Distance from the base's axis, and height.
    pub at: [f64; 2],
    /// Least translational stiffness.
    pub least: f64,
    /// Semi-axes of the displacement under a force in any direction.
    pub ellipse: [[f64; 2]; 2],
}

/// Stiffness over a slice of the workspace.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StiffnessSlice {
    /// The two variables that are swept.
    pub swept: [Swept; 2],
    /// Units of the nodes.
    pub units: SliceUnits,
    /// Configurations that can be assembled within the limits of the joints.
    pub nodes: Vec<SliceNode>,
}

/// How the robot deflects.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StiffnessReview {
    /// Stiffness over a slice of the workspace, where it can be computed.
    pub slice: Option<StiffnessSlice>,
    /// Of the strain energy, by element.
    pub shares: Option<IndexMap<String, f64>>,
    /// Under the campaign's loads; else under 1 kN downwards.
    pub own_loads: Option<bool>,
    /// Readings over which shares are taken.
    pub readings: Option<usize>,
}

/// A reading with its residuals at every stage.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReadingReview {
    /// Row of the measurements' file.
    pub row: usize,
    /// Name of the configuration.
    pub pose: String,
    /// `None` is the tool centre point.
    pub marker: Option<String>,
    /// Held out by the calibration.
    pub set_aside: bool,
    /// Values of the variables, deg or mm.
    pub joints: Vec<f64>,
    /// Where it was taken, base frame.
    pub point: [f64; 3],
    /// By stage.
    pub errors: IndexMap<StageKey, Vec<f64>>,
    /// Force (N) and torque (N.m) on the tool, base axes; absent where there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wrench: Option<[f64; 6]>,
    /// What the suspected effects take out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pattern: Option<Vec<f64>>,
    /// Conditions by column, as the campaign gives them: temperatures, time (s), sides of approach (signs).
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub conditions: IndexMap<String, f64>,
}

/// What `report` finds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// The campaign.
    pub campaign: CampaignSummary,
    /// Commands that find the same.
    pub sources: Sources,
    /// `None` where nothing is free.
    pub identify: Option<Identification>,
    /// Why there is no identification.
    pub identify_why: Option<String>,
    /// What `diagnose` finds.
    pub diagnose: Diagnosis,
    /// Errors from the description as it is down to the noise.
    pub waterfall: Vec<WaterfallStep>,
    /// Stages at which residuals of the readings are given, in order.
    pub stages: Vec<StageLabel>,
    /// How the robot deflects.
    pub stiffness: StiffnessReview,
    /// What `sensitivity` finds.
    pub sensitivity: Sensitivities,
    /// Each reading with its residuals.
    pub readings: Vec<ReadingReview>,
    /// The answer in two sentences; written with the page.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub answer: Option<String>,
    /// What casts doubt on the figures.
    pub diagnostics: Vec<Diagnostic>,
}

/// What a stage is called.
pub fn stage_label(key: StageKey) -> &'static str {
    match key {
        StageKey::Described => "description as it is",
        StageKey::Registered => "base, tool and markers fitted alone",
        StageKey::Calibrated => "calibrated (identify)",
        StageKey::Competed => "calibrated, what effects compete for (diagnose)",
        StageKey::Explained => "with the effects added (diagnose)",
    }
}

impl Report {
    /// From a reviewed campaign.
    pub fn new(review: &Review, sources: Sources) -> Self {
        let (model, campaign) = (review.model, review.campaign);
        let (identify, identify_why) = match &review.calibration {
            Ok((found, seconds)) => (Some(Identification::new(model, campaign, found, *seconds)), None),
            Err(why) => (None, Some(why.clone())),
        };
        let diagnose = Diagnosis::new(model, campaign, &review.diagnosis, review.seconds);
        let label = |stage: &Stage| StageLabel { key: stage.key, label: stage_label(stage.key) };
        let shares = review.strain_energy.as_ref();
        Self {
            campaign: CampaignSummary::new(review),
            sources,
            waterfall: waterfall(campaign, identify.as_ref(), &diagnose),
            identify,
            identify_why,
            diagnose,
            stages: review.readings.stages.iter().map(label).collect(),
            stiffness: StiffnessReview {
                slice: review.slice.as_ref().map(|slice| StiffnessSlice::new(model, slice)),
                shares: shares.map(|found| found.shares.clone()),
                own_loads: shares.map(|found| found.own_loads),
                readings: shares.map(|found| found.readings),
            },
            sensitivity: Sensitivities::new(model, campaign, &review.sensitivity[0], &review.sensitivity[1]),
            readings: (0..campaign.readings.len()).map(|index| ReadingReview::new(review, index)).collect(),
            answer: None,
            diagnostics: Vec::new(),
        }
    }

    /// Sites of the causes.
    pub fn suspects(&self) -> Vec<&str> {
        self.diagnose.causes.iter().map(|cause| cause.site.as_str()).collect()
    }
}

impl CampaignSummary {
    fn new(review: &Review) -> Self {
        Self::of(review.model, review.campaign, review.held_out)
    }

    /// Of a campaign of which some readings are held out.
    pub fn of(model: &Model, campaign: &Campaign, held_out: &[bool]) -> Self {
        let poses: Vec<usize> = distinct(campaign.readings.iter().map(|reading| reading.pose));
        Self {
            name: campaign.name.clone(),
            robot: model.name.clone(),
            observes: campaign.observes,
            kinds: kinds(campaign),
            readings: campaign.readings.len(),
            poses: poses.len(),
            set_aside: held_out.iter().filter(|held_out| **held_out).count(),
            sigma: campaign.sigma.map(|sigma| sigma.map(mm)),
            unit: "mm",
            calibrate: campaign.calibrate.clone(),
            without: campaign.without.clone(),
            estimate_base: campaign.estimate_base,
            estimate_tool: campaign.estimate_tool,
            own_weight: OwnWeight::of_campaign(model, &model.registry.nominal(), campaign),
        }
    }
}

/// Steps from the description as it is down to the noise: rms position errors of readings that the fit did not see where
/// there are such, with what found them.
fn waterfall(campaign: &Campaign, identify: Option<&Identification>, diagnose: &Diagnosis) -> Vec<WaterfallStep> {
    let mut steps = Vec::new();
    let mut step = |key, label: String, rms, source, on| steps.push(WaterfallStep { key, label, rms, source, on });
    let gap = &diagnose.gap;
    let is_placed = campaign.estimate_base || campaign.estimate_tool;
    if let Some(found) = identify {
        let on = if found.is_checked() { "readings held out" } else { "fitted readings" };
        let [described, registered, calibrated] = found.judged();
        step(StepKey::Described, "description as it is".into(), described, "identify", on);
        if is_placed {
            step(StepKey::Registered, stage_label(StageKey::Registered).into(), registered, "identify", on);
        }
        step(StepKey::Calibrated, "calibrated".into(), calibrated, "identify", on);
    }
    // The same thing, if both re-fit the same parameters and hold the same readings back.
    if identify.is_none_or(|found| (gap.rms - found.judged()[2]).abs() >= 5e-3 * gap.rms) {
        let refitted = match campaign.calibrate.join(", ") {
            list if !list.is_empty() => format!("{list} re-fitted"),
            _ if is_placed => "base and tool re-fitted".into(),
            _ => "nothing re-fitted".into(),
        };
        step(StepKey::Competed, refitted, gap.rms, "diagnose", "held-out readings");
    }
    for cause in &diagnose.causes {
        step(StepKey::Effect, cause.claim.clone(), cause.rms_after, "diagnose", "held-out readings");
    }
    step(StepKey::Noise, "noise".into(), gap.noise, "diagnose", "expected");
    steps
}

impl StiffnessSlice {
    fn new(model: &Model, slice: &Slice) -> Self {
        let is_angle = slice.swept.map(|k| model.variables[k].is_angle);
        let node = |node: &Node| SliceNode {
            q: [0, 1].map(|k| shown(node.q[k], is_angle[k])),
            at: node.at.map(mm),
            least: node.least * 1e-3,
            ellipse: node.ellipse.map(|axis| axis.map(|v| v * 1e6)),
        };
        Self {
            swept: slice.swept.map(|k| Swept {
                name: model.variables[k].name.clone(),
                unit: shown_unit(model.variables[k].is_angle),
            }),
            units: SliceUnits { at: "mm", least: "N/mm", ellipse: "mm/kN" },
            nodes: slice.nodes.iter().flatten().flatten().map(node).collect(),
        }
    }
}

impl ReadingReview {
    fn new(review: &Review, index: usize) -> Self {
        let (model, campaign, readings) = (review.model, review.campaign, &review.readings);
        let reading = &campaign.readings[index];
        let lengths = reading.observes.length_rows().min(3);
        let first = readings.first_rows[index];
        let position = |all: &[f64]| -> Vec<f64> {
            let own = all.iter().skip(first).take(lengths);
            own.map(|v| (v * 1e9).round() / 1e6).collect()
        };
        let joints = campaign.configuration(index).iter().zip(&model.variables);
        let at = readings.points[index];
        let name = |variable: usize| model.variables[variable].name.as_str();
        let conditions = campaign.conditions.columns();
        Self {
            row: reading.row,
            pose: campaign.poses[reading.pose].clone(),
            marker: reading.marker.map(|m| model.markers[m].name.clone()),
            set_aside: review.held_out[index],
            joints: joints.map(|(q, variable)| shown(*q, variable.is_angle)).collect(),
            point: [at.x, at.y, at.z].map(|v| (v * 1e6).round() / 1e3),
            errors: readings.stages.iter().map(|stage| (stage.key, position(&stage.residual))).collect(),
            wrench: (reading.wrench != [0.0; 6]).then_some(reading.wrench),
            pattern: (!readings.pattern.is_empty()).then(|| position(&readings.pattern)),
            conditions: conditions.map(|(condition, all)| (condition.column(name), all[index])).collect(),
        }
    }
}
