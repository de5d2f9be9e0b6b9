//! What `check` finds of a campaign: what was measured, where, how well, and what calibration will estimate. Lengths in mm,
//! angles in deg, forces in N, moments in N.m.

use indexmap::IndexMap;
use serde::Serialize;

use super::counts::{PartCount, ReadingOrder, part_counts};
use super::identification::NoiseSources;
use super::own_weight::OwnWeight;
use super::units::{deg, mm, shown, shown_unit};
use crate::description::campaign::raw::JointSource;
use crate::description::campaign::{Campaign, NoiseOrigin};
use crate::diagnostic::Diagnostic;
use crate::estimation::{What, candidates};
use crate::math::{distinct, mean_rms_max, norm};
use crate::model::Model;
use crate::noise::{NoiseEstimate, Repeated, reference_noise, repeats, rigid_markers};
use crate::observation::Observes;
use crate::parameter::Group;

/// Readings by the column `set`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Sets {
    /// Readings that the file assigns to the fit.
    pub fit: usize,
    /// Readings that the file holds out to check.
    pub check: usize,
    /// Readings that the file assigns to neither: commands hold a share of their configurations out.
    pub unassigned: usize,
}

/// How far a variable goes over the campaign.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointRange {
    /// `deg` of an angle, `mm` of a length: of all values here.
    pub unit: &'static str,
    /// Least value in a reading.
    pub least: f64,
    /// Greatest value in a reading.
    pub most: f64,
    /// Of the description.
    pub limits: Option<[f64; 2]>,
    /// Share of the range between the limits that the campaign covers; `None` without finite limits.
    pub covered: Option<f64>,
    /// Readings beyond the limits.
    pub beyond: usize,
}

/// Noise that the campaign states, one sigma.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StatedNoise {
    /// Along x, y, z (of a distance: the first), root mean square over the readings, with what grows with the distance; `None` where
    /// that of orientations or torques alone is stated.
    pub position: Option<[f64; 3]>,
    /// The least and the greatest of a coordinate, where readings differ.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// Of a component of the orientation, deg.
    pub orientation: Option<f64>,
    /// Of a torque or force, N.m or N, root mean square.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque: Option<f64>,
}

impl StatedNoise {
    /// Of a campaign; `None` where it states none.
    fn of(campaign: &Campaign) -> Option<Self> {
        let of_lengths = campaign.readings.iter().filter(|reading| reading.observes.length_rows() > 0);
        let sizes = of_lengths.flat_map(|reading| {
            reading.observes.sigmas(&reading.noise).into_iter().take(reading.observes.length_rows())
        });
        let [least, most] = sizes.fold([f64::INFINITY, 0.0], |[least, most], size| [size.min(least), size.max(most)]);
        let stated = campaign.sigma.filter(|_| campaign.noise_origin == NoiseOrigin::Stated);
        let is_by_axis = stated.is_some_and(|[x, y, z]| x != y || y != z);
        let loads: Vec<f64> = campaign
            .readings
            .iter()
            .filter(|reading| reading.observes.by_variable().is_some())
            .filter_map(|reading| reading.noise.is_stated[2].then_some(reading.noise.load))
            .collect();
        let found = Self {
            position: stated.map(|sigma| sigma.map(mm)),
            range: stated.filter(|_| !is_by_axis && most > least).map(|_| [least, most].map(mm)),
            orientation: campaign.sigma_orientation.map(deg),
            torque: (!loads.is_empty()).then(|| mean_rms_max(loads.into_iter())[1]),
        };
        (found.position.is_some() || found.orientation.is_some() || found.torque.is_some()).then_some(found)
    }
}

/// Loads that were applied.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AppliedLoads {
    /// Readings under load.
    pub readings: usize,
    /// Greatest magnitude of a force applied on the tool, N.
    pub greatest_force: f64,
    /// Greatest magnitude of a torque applied on the tool, N.m.
    pub greatest_moment: f64,
}

/// Parameters that `identify` will try to estimate, before the reduction drops what the readings cannot separate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ToEstimate {
    /// Pose of the base in the measurement frame.
    pub base: Vec<String>,
    /// Tool centre point and markers.
    pub tool: Vec<String>,
    /// Geometric constants of the robot.
    pub geometry: Vec<String>,
    /// Springs, sections and masses.
    pub elastic: Vec<String>,
    /// Amounts of the effects that are switched on.
    pub effects: Vec<String>,
    /// Places of contacts and anchors, zeros, gains and offsets of sensors, the instrument's scale.
    pub targets: Vec<String>,
    /// Why nothing will be estimated.
    pub none: Option<String>,
}

/// Noise of an instrument from readings in which no robot is, one sigma of a coordinate, mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct NoiseFigure {
    /// Standard deviation of a coordinate, mm.
    pub sigma: f64,
    /// Degrees of freedom of the estimate.
    pub degrees_of_freedom: f64,
}

/// Motion of the fixed reflectors against the instrument, mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ReferenceMotion {
    /// Root mean square displacement from the mean places.
    pub rms: f64,
    /// Greatest displacement from the mean places.
    pub greatest: f64,
    /// From the first tenth of the times to the last.
    pub drift: f64,
    /// Probability of as much by noise alone.
    pub p: f64,
}

/// What a campaign says of its instrument without the robot.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct InstrumentNoise {
    /// From distances between markers of one body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rigid_markers: Option<NoiseFigure>,
    /// From readings repeated one after the other.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub repeats: Option<NoiseFigure>,
    /// From fixed reflectors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub references: Option<NoiseFigure>,
    /// That of these by which readings are weighed, since the campaign states none, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub taken: Option<f64>,
    /// `None` without reflectors, or with one that cannot tell motion from noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<ReferenceMotion>,
}

impl InstrumentNoise {
    fn new(model: &Model, campaign: &Campaign) -> Self {
        let figure =
            |found: NoiseEstimate| NoiseFigure { sigma: mm(found.sigma), degrees_of_freedom: found.degrees_of_freedom };
        let references = reference_noise(&campaign.references);
        let motion = references.and_then(|found| found.motion).map(|motion| ReferenceMotion {
            rms: mm(motion.rms),
            greatest: mm(motion.greatest),
            drift: mm(motion.drift),
            p: motion.p,
        });
        Self {
            rigid_markers: rigid_markers(model, campaign).map(figure),
            repeats: repeats(campaign, Repeated::InPlace, |_, _| 1.0).map(figure),
            references: references.map(|found| figure(found.noise)),
            taken: campaign.sigma.filter(|_| campaign.noise_origin != NoiseOrigin::Stated).map(|sigma| mm(sigma[0])),
            motion,
        }
    }

    /// Whether nothing was found.
    pub fn is_empty(&self) -> bool {
        self.rigid_markers.is_none() && self.repeats.is_none() && self.references.is_none()
    }
}

/// What `check` finds of a campaign.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CampaignCheck {
    /// Name of the campaign.
    pub campaign: String,
    /// Name of the robot.
    pub robot: String,
    /// Kind of the readings, as the campaign declares it; `kinds` counts those of each kind.
    pub observes: Observes,
    /// Readings by kind.
    pub kinds: IndexMap<&'static str, usize>,
    /// Number of readings.
    pub readings: usize,
    /// Number of distinct configurations.
    pub configurations: usize,
    /// Readings by marker; `TCP` is the tool centre point.
    pub markers: IndexMap<String, usize>,
    /// Readings to fit and to check, as the file assigns them.
    pub sets: Sets,
    /// What says which reading came before which.
    pub order: ReadingOrder,
    /// Readings by session, station, file, contact, placement, anchor and payload, where there are such.
    pub parts: Vec<PartCount>,
    /// Unit of lengths.
    pub unit: &'static str,
    /// Range of each variable over the readings.
    pub joints: IndexMap<String, JointRange>,
    /// Which joints the model is evaluated at: `plain` columns, `commanded` or `recorded`; `None` where the files give no others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub evaluated_at: Option<&'static str>,
    /// `None` where none is stated.
    pub noise: Option<StatedNoise>,
    /// What the campaign says of its instrument without the robot; nothing where it says nothing.
    #[serde(skip_serializing_if = "InstrumentNoise::is_empty")]
    pub without_robot: InstrumentNoise,
    /// `None` where no reading is loaded.
    pub loads: Option<AppliedLoads>,
    /// Columns of conditions: sides of approach, time, temperatures.
    pub conditions: Vec<String>,
    /// Parameters that `identify` will try to estimate.
    pub estimate: ToEstimate,
    /// Effects that a diagnosis re-fits whatever it tries.
    pub calibrate: Vec<String>,
    /// Elements of the description left out.
    pub without: Vec<String>,
    /// Whether the readings are predicted with own weight.
    pub own_weight: OwnWeight,
    /// Warnings raised on reading the campaign and the robot.
    pub warnings: Vec<Diagnostic>,
    /// Readings hold an orientation in addition to a position.
    #[serde(skip)]
    pub has_orientations: bool,
    /// Readings hold lengths.
    #[serde(skip)]
    pub has_lengths: bool,
}

/// Readings of a campaign by kind.
pub(super) fn kinds(campaign: &Campaign) -> IndexMap<&'static str, usize> {
    let mut kinds: IndexMap<&'static str, usize> = IndexMap::new();
    campaign.readings.iter().for_each(|reading| *kinds.entry(reading.observes.name()).or_default() += 1);
    kinds
}

impl CampaignCheck {
    /// Of a campaign and its robot, the joints that its file says it is evaluated at, and the warnings of reading them.
    pub fn new(model: &Model, campaign: &Campaign, joints: Option<JointSource>, warnings: &[Diagnostic]) -> Self {
        let has_others = campaign.conditions.other_joints.iter().any(Option::is_some);
        let evaluated_at = joints.map_or("plain", JointSource::prefix);
        let readings = &campaign.readings;
        let count = |set: Option<bool>| readings.iter().filter(|reading| reading.check == set).count();
        let mut markers: IndexMap<String, usize> = IndexMap::new();
        for reading in readings {
            let name = reading.marker.map_or("TCP", |marker| model.markers[marker].name.as_str());
            *markers.entry(name.into()).or_default() += 1;
        }
        let poses: Vec<usize> = distinct(readings.iter().map(|reading| reading.pose));
        let variable = |k: usize| model.variables[k].name.as_str();
        Self {
            campaign: campaign.name.clone(),
            robot: model.name.clone(),
            observes: campaign.observes,
            kinds: kinds(campaign),
            readings: readings.len(),
            configurations: poses.len(),
            markers,
            sets: Sets { fit: count(Some(false)), check: count(Some(true)), unassigned: count(None) },
            order: ReadingOrder::new(campaign),
            parts: part_counts(campaign),
            unit: "mm",
            joints: (0..model.variables.len()).map(|k| (variable(k).into(), range(model, campaign, k))).collect(),
            evaluated_at: has_others.then_some(evaluated_at),
            noise: StatedNoise::of(campaign),
            without_robot: InstrumentNoise::new(model, campaign),
            loads: loads(campaign),
            conditions: campaign.conditions.columns().map(|(column, _)| column.column(variable)).collect(),
            estimate: ToEstimate::new(model, campaign),
            calibrate: campaign.calibrate.clone(),
            without: campaign.without.clone(),
            own_weight: OwnWeight::of_campaign(model, &model.registry.nominal(), campaign),
            warnings: warnings.to_vec(),
            has_orientations: NoiseSources::new(campaign).orientation.is_some(),
            has_lengths: campaign.holds_lengths(),
        }
    }
}

fn range(model: &Model, campaign: &Campaign, k: usize) -> JointRange {
    let variable = &model.variables[k];
    let at = |value: f64| shown(value, variable.is_angle);
    let values = || (0..campaign.readings.len()).map(|reading| campaign.configuration(reading)[k]);
    let (least, most) =
        values().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), q| (least.min(q), most.max(q)));
    let [least, most] = if least <= most { [least, most] } else { [0.0; 2] };
    let finite = variable.limits.filter(|[low, high]| (high - low).is_finite() && high > low);
    JointRange {
        unit: shown_unit(variable.is_angle),
        least: at(least),
        most: at(most),
        limits: variable.limits.map(|limits| limits.map(at)),
        covered: finite.map(|[low, high]| (most.min(high) - least.max(low)).max(0.0) / (high - low)),
        beyond: values().filter(|q| variable.limits.is_some_and(|[low, high]| !(low..=high).contains(q))).count(),
    }
}

fn loads(campaign: &Campaign) -> Option<AppliedLoads> {
    let loaded = || campaign.readings.iter().map(|reading| reading.wrench).filter(|wrench| *wrench != [0.0; 6]);
    let greatest = |from: usize| {
        let sizes = loaded().map(|w| norm(&w[from..from + 3]));
        sizes.fold(0.0, f64::max)
    };
    let readings = loaded().count();
    (readings > 0).then(|| AppliedLoads { readings, greatest_force: greatest(0), greatest_moment: greatest(3) })
}

impl ToEstimate {
    fn new(model: &Model, campaign: &Campaign) -> Self {
        let (slots, none) = match candidates(model, campaign, What::usual(model, campaign)) {
            Ok(slots) => (slots, None),
            Err(why) => (Vec::new(), Some(why.to_string())),
        };
        let of = |group: Group| {
            let own = slots.iter().map(|&slot| &model.registry[slot]).filter(|parameter| parameter.group == group);
            own.map(|parameter| parameter.name.clone()).collect()
        };
        Self {
            base: of(Group::Base),
            tool: of(Group::Tool),
            geometry: of(Group::Geometry),
            elastic: of(Group::Elastic),
            effects: of(Group::Effect),
            targets: of(Group::Arrangement),
            none,
        }
    }
}
