//! What `plan` finds. Configurations and loads in SI, errors in mm, widths of parameters in their unit.

use indexmap::IndexMap;
use serde::Serialize;

use super::identifiability::Reduction;
use super::own_weight::OwnWeight;
use super::units::{half_width_95, mm, unit};
use crate::description::campaign::{Reading, names};
use crate::math::distinct;
use crate::model::Model;
use crate::planning::{Design, Planned, Request};

/// A configuration to measure.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlannedPose {
    /// Name of the configuration.
    pub pose: String,
    /// rad and m.
    pub joints: IndexMap<String, f64>,
    /// Force (N) and torque (N.m) to apply on the tool, base axes.
    pub wrench: [f64; 6],
    /// Markers seen there; `TCP` is the tool centre point.
    pub markers: Vec<String>,
    /// What is read there, of a campaign that says it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub readings: Vec<PlannedReading>,
    /// Of a campaign with contacts, payloads or sessions: what is touched, carried, and in which session, by column.
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub names: IndexMap<String, String>,
}

/// A reading at a configuration to measure.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PlannedReading {
    /// What it is, as `observes:` names it.
    pub observes: &'static str,
    /// The file of the campaign to which it belongs, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
}

impl PlannedPose {
    /// What is read there, each kind once, and the files to which it belongs.
    pub fn kinds_and_files(&self) -> [String; 2] {
        let kinds = distinct(self.readings.iter().map(|reading| reading.observes));
        let files = distinct(self.readings.iter().filter_map(|reading| reading.file.as_deref()));
        [kinds.join(" "), files.join(" ")]
    }
}

/// Position error after compensation, rms at the test poses, mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PlannedError {
    /// With what is measured already.
    pub before: Option<f64>,
    /// With the plan.
    pub planned: f64,
}

/// What a number of configurations buys, mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Bought {
    /// How many configurations.
    pub poses: usize,
    /// Root mean square position error at the test poses, of configurations that are planned.
    pub planned: f64,
    /// Median of random sets.
    pub random: f64,
}

/// Half width of a parameter's 95 % interval.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParameterWidth {
    /// Name of the parameter.
    pub name: String,
    /// Unit of the half width.
    pub unit: &'static str,
    /// Half width of the interval expected after the plan, in `unit`.
    pub ci95: f64,
}

/// What `plan` finds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Plan {
    /// Name of the criterion: `test-error`, `D`, `A`, `E`, or `O1` to `O5`.
    pub criterion: &'static str,
    /// Configurations in the order in which they should be measured.
    pub poses: Vec<PlannedPose>,
    /// Unit of errors.
    pub unit: &'static str,
    /// Error after compensation that the plan should leave.
    pub error: PlannedError,
    /// Errors with other numbers of configurations, and with this one.
    pub bought: Vec<Bought>,
    /// How many random configurations do as well; `None` if all the candidates together do not.
    pub random_equal: Option<usize>,
    /// Fewest configurations that determine the parameters.
    pub least: usize,
    /// Candidate configurations that keep the rules, from which was chosen.
    pub candidates: usize,
    /// Expected intervals of the parameters that are estimated.
    pub parameters: Vec<ParameterWidth>,
    /// Which parameters the planned readings, with those made already, determine.
    pub identifiability: Reduction,
    /// Whether the readings are predicted with own weight.
    pub own_weight: OwnWeight,
    /// Time that planning took, s.
    pub seconds: f64,
    /// The robot's name.
    #[serde(skip)]
    pub robot: String,
    /// Random sets compared with, of whose errors the median is taken.
    #[serde(skip)]
    pub random_sets: u64,
    /// Markers asked for.
    #[serde(skip)]
    pub markers: usize,
    /// By variable: name, and whether it is an angle.
    #[serde(skip)]
    pub variables: Vec<(String, bool)>,
}

impl Plan {
    /// With the names and units of a model.
    pub fn new(model: &Model, request: &Request, planned: &Planned, seconds: f64) -> Self {
        let marker = |marker: &Option<usize>| marker.map_or("TCP", |m| &model.markers[m].name).to_string();
        let poses = planned.stations.iter().zip(&planned.campaign.poses).map(|(station, pose)| PlannedPose {
            pose: pose.clone(),
            joints: model.variables.iter().zip(&station.q).map(|(v, q)| (v.name.clone(), *q)).collect(),
            wrench: station.load,
            markers: station.markers.iter().map(marker).collect(),
            readings: request.design.as_ref().map_or_else(Vec::new, |design| readings(design, station.way)),
            names: request.design.as_ref().map_or_else(IndexMap::new, |design| {
                names(&design.campaign, design.ways.get(station.way).map_or(&[][..], Vec::as_slice))
            }),
        });
        let bought =
            planned.bought.iter().map(|b| Bought { poses: b.count, planned: mm(b.planned), random: mm(b.random) });
        let width = |&(slot, sigma): &(usize, f64)| {
            let parameter = &model.registry[slot];
            let (unit, size) = unit(parameter.shown_kind());
            let ci95 = parameter.shown_width(parameter.nominal, half_width_95(sigma)) / size;
            ParameterWidth { name: parameter.name.clone(), unit, ci95 }
        };
        Self {
            criterion: request.criterion.name(),
            poses: poses.collect(),
            unit: "mm",
            error: PlannedError { before: planned.before.map(mm), planned: mm(planned.error) },
            bought: bought.collect(),
            random_equal: planned.random_equal,
            least: planned.least,
            candidates: planned.candidates,
            parameters: planned.deviations.iter().map(width).collect(),
            identifiability: Reduction::new(model, &planned.slots, &planned.identifiability),
            own_weight: OwnWeight::of_campaign(model, &model.registry.nominal(), &planned.campaign),
            seconds,
            robot: model.name.clone(),
            random_sets: request.settings.random_sets,
            markers: request.markers.len(),
            variables: model.variables.iter().map(|v| (v.name.clone(), v.is_angle)).collect(),
        }
    }
}

/// What is read together, and the file of each.
fn readings(design: &Design, way: usize) -> Vec<PlannedReading> {
    let (Some(readings), Some(files)) = (design.ways.get(way), design.files.get(way)) else { return Vec::new() };
    let one = |(reading, file): (&Reading, &Option<String>)| PlannedReading {
        observes: reading.observes.name(),
        file: file.clone(),
    };
    readings.iter().zip(files).map(one).collect()
}
