//! What `diagnose` finds. Lengths in mm, amounts of effects in SI.

use std::borrow::Cow;

use indexmap::IndexMap;
use serde::Serialize;

use super::identification::{NoiseSources, WeightSource, stated_error};
use super::own_weight::OwnWeight;
use super::since::Since;
use super::units::mm;
use crate::description::campaign::Campaign;
use crate::diagnosis::{
    self, Autocorrelation, CauseParameter, Curve, EffectAtSite, ExcessCompliance, Excluded, FewAngles, Level,
    LookAlikes, NoiseSource, NotTried, SiteShare, Stability, Support, Verdict,
};
use crate::effects::Family;
use crate::model::Model;

/// The gap that calibration leaves on readings that were not fitted, mm; where outliers are a part of it, `rms` and `max` are those
/// of all readings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Gap {
    /// Root mean square position error.
    pub rms: f64,
    /// Greatest position error.
    pub max: f64,
    /// With the outliers set aside, where they are a part of the gap.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub without_outliers: Option<f64>,
    /// Root mean square position error by noise alone.
    pub noise: f64,
    /// sqrt(rms^2 - noise^2).
    pub closable: f64,
    /// Unit of all values here.
    pub unit: &'static str,
    /// Whether the gap is more than noise alone would leave, or outliers are a part of it.
    pub significant: bool,
    /// With base and tool fitted alone; `None` where nothing is fitted.
    pub registration: Option<f64>,
}

/// A region in which the gap is greatest, mm.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Region {
    /// The region as inequalities, for example `q2 > 40 deg`.
    pub when: String,
    /// Root mean square error inside the region.
    pub rms: f64,
    /// Root mean square error outside it.
    pub elsewhere: f64,
}

/// Root mean square error along the axes of the measurement frame, mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Directions {
    /// Along x.
    pub x: f64,
    /// Along y.
    pub y: f64,
    /// Along z.
    pub z: f64,
}

/// Where the gap lies.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Location {
    /// Share of the gap that a free error at each site could carry, the greatest first; empty where the gap is not significant.
    pub sites: Vec<SiteShare>,
    /// Regions in which the gap is greatest; empty where the gap is not significant.
    pub conditions: Vec<Region>,
    /// Root mean square error by direction.
    pub directions: Directions,
    /// Deflections greater than predicted.
    pub yielding: Option<ExcessCompliance>,
}

/// A cause.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cause {
    /// Name of the effect in the catalogue.
    pub effect: String,
    /// Name of the site, for example `joint:2`.
    pub site: String,
    /// As much as is certain, in words.
    pub claim: String,
    /// `None` where nothing competes with it.
    pub probability: Option<f64>,
    /// Its parameters, fitted or chosen, SI.
    pub parameters: Vec<CauseParameter>,
    /// Root mean square error before it was added, mm, cross-validated.
    pub rms_before: f64,
    /// Root mean square error after it was added, mm, cross-validated.
    pub rms_after: f64,
    /// How far it reduces the root mean square error: 1 - after / before.
    pub shrinkage: f64,
    /// 95 % interval of the shrinkage, by bootstrap over configurations; both ends null where there is none.
    pub shrinkage_ci95: [Option<f64>; 2],
    /// Effects and sites that the readings do not separate from it.
    pub indistinguishable_from: Vec<EffectAtSite>,
    /// What kind of cause it is.
    pub family: Family,
    /// How much is certain: `law`, `site` or `family`.
    pub level: Level,
    /// What it follows; `None` of constants.
    pub follows: Option<String>,
    /// Frequencies over half-samples of configurations.
    pub stability: Option<Stability>,
    /// What speaks for its law, on readings that were not fitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub support: Option<Support>,
    /// Its curve, of a free form at a joint or the instrument.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub curve: Option<Curve>,
    /// By component, of a free form at the base or the tool.
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub curves: IndexMap<String, Curve>,
    /// What the amounts mean on the machine.
    pub implies: Vec<String>,
    /// What it looks like in the residuals.
    pub signature: Cow<'static, str>,
    /// What to do about it on the machine.
    pub remedy: &'static str,
}

/// A hypothesis that was not selected.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rejected {
    /// Name of the effect in the catalogue.
    pub effect: String,
    /// Name of the site.
    pub site: String,
    /// Root mean square error of the fitted readings with it alone, by degree of freedom, mm; compares with `with_none`.
    pub rms_after: f64,
    /// Why it was not selected.
    pub why: &'static str,
}

/// What all causes leave.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rest {
    /// Root mean square error above the noise, of readings that were not fitted, mm.
    pub rms: f64,
    /// The site of the curve that takes most of it away, where that is certain.
    #[serde(rename = "where")]
    pub site: Option<String>,
    /// What that curve follows.
    pub follows: Option<String>,
    /// The site of a curve in it for which the intervals of the amounts of the causes allow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub allowed_for: Option<String>,
    /// The few angles of one joint at which most of it lies, where that is certain and the answer is open.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub few_angles: Option<FewAngles>,
}

impl From<&diagnosis::Rest> for Rest {
    fn from(found: &diagnosis::Rest) -> Self {
        let diagnosis::Rest { rms, site, follows, allowed_for, few_angles } = found.clone();
        Self { rms: mm(rms), site, follows, allowed_for, few_angles }
    }
}

/// What is left after all causes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AfterAll {
    /// Root mean square error, mm, cross-validated.
    pub rms: f64,
    /// 95 % interval of it, mm, by bootstrap over configurations; both ends null where there is none.
    pub rms_ci95: [Option<f64>; 2],
    /// The same without those causes that belong to the session and are not written into a description; absent where there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_of_robot: Option<f64>,
    /// How far all causes reduce the root mean square error of the gap, outliers included: 1 - after / before.
    pub shrinkage: f64,
    /// 95 % interval of the shrinkage; both ends null where there is none.
    pub shrinkage_ci95: [Option<f64>; 2],
}

/// Share of an error from which a difference is worth a sentence.
const NOTICED: f64 = 0.05;

impl AfterAll {
    /// Whether what belongs to the session is noticed in what the description leaves without it.
    pub fn is_session_noticed(&self) -> bool {
        self.rms_of_robot.is_some_and(|robot| robot > (1.0 + NOTICED) * self.rms)
    }
}

/// A configuration at which rivals predict different readings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NextPose {
    /// rad and m.
    pub joints: IndexMap<String, f64>,
    /// Force (N) and torque (N.m) on the tool, measurement frame.
    pub wrench: [f64; 6],
    /// The two rivals, `effect@site`.
    pub separates: [String; 2],
    /// Distance between the two predictions, mm.
    pub apart: f64,
    /// The same with each coordinate divided by its noise.
    pub sigmas: f64,
}

/// Where the noise comes from that the gap is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum NoiseFrom {
    /// The campaign states it.
    Stated,
    /// Scatter of repeated readings.
    Repeats,
    /// What the best explanation leaves.
    Leftover,
}

impl NoiseFrom {
    fn words(self) -> &'static str {
        match self {
            Self::Stated => "as the campaign states",
            Self::Repeats => "from repeated readings",
            Self::Leftover => "not known: the model's own leftover",
        }
    }
}

impl From<NoiseSource> for NoiseFrom {
    fn from(source: NoiseSource) -> Self {
        match source {
            NoiseSource::Stated => Self::Stated,
            NoiseSource::Repeated => Self::Repeats,
            NoiseSource::Residual => Self::Leftover,
        }
    }
}

/// The noise that the gap is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Noise {
    /// Root mean square position error by noise alone, mm.
    pub value: f64,
    /// Where it comes from.
    pub source: NoiseFrom,
    /// Of orientations; `None` where no reading has both a position and an orientation.
    pub orientation: Option<WeightSource>,
    /// That of the instrument alone, as `identify` states it, where rigid markers or fixed reflectors show it and nothing shows what all readings of
    /// a configuration share.
    pub instrument: Option<ShownNoise>,
}

/// Noise of an instrument that readings without the robot show.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ShownNoise {
    /// Root mean square of a reading, mm.
    pub value: f64,
    /// What shows it.
    pub source: WeightSource,
}

impl ShownNoise {
    fn new(campaign: &Campaign) -> Option<Self> {
        let source = NoiseSources::new(campaign).position;
        let is_shown = matches!(source, WeightSource::Markers | WeightSource::References);
        let value = stated_error(campaign).filter(|_| is_shown && campaign.sigma.is_some())?;
        Some(Self { value: mm(value), source })
    }
}

/// How figures came about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Notes {
    /// Where the noise comes from, in words.
    pub noise: &'static str,
}

/// What `diagnose` finds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Diagnosis {
    /// What calibration leaves on readings that were not fitted.
    pub gap: Gap,
    /// Where the gap lies.
    #[serde(rename = "where")]
    pub location: Location,
    /// Whether there is a gap, and whether the causes explain it.
    pub verdict: Verdict,
    /// Causes in the order found.
    pub causes: Vec<Cause>,
    /// Hypotheses that were not selected, the nearest first.
    pub rejected: Vec<Rejected>,
    /// All readings, by degree of freedom, with no effect.
    pub with_none: f64,
    /// What is left with all causes.
    pub after_all: AfterAll,
    /// Autocorrelation of the residuals that all causes leave.
    pub structure: Vec<Autocorrelation>,
    /// Configurations whose readings would distinguish rivals.
    pub next_poses: Vec<NextPose>,
    /// Which hypotheses look alike in the readings of this campaign.
    pub look_alikes: LookAlikes,
    /// Rows of the readings.
    pub outliers: Vec<usize>,
    /// Where these stand: file and line.
    pub outliers_at: Vec<String>,
    /// Effects that could not compete, and what they need.
    pub not_tried: Vec<NotTried>,
    /// What other measurements exclude.
    pub excluded: Vec<Excluded>,
    /// The noise that the gap is compared with.
    pub noise: Noise,
    /// What all causes leave, mm.
    pub rest: Rest,
    /// Number of hypotheses compared.
    pub hypotheses: usize,
    /// How figures came about, in words.
    pub notes: Notes,
    /// Time that the diagnosis took, s.
    pub seconds: f64,
    /// Whether the readings are predicted with own weight.
    pub own_weight: OwnWeight,
    /// How many configurations were drawn of how many, where all of them would take too much memory.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drawn_from: Option<[usize; 2]>,
    /// What is refitted with each hypothesis: names of effects, and the parameters which that are here.
    pub refitted: Refitted,
    /// What has moved since an earlier description, where one was given: the geometry and springs that it states, fitted without causes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub since: Option<Since>,
    /// The campaign's name.
    #[serde(skip)]
    pub campaign: String,
}

/// What is refitted with each hypothesis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Refitted {
    /// Effects under `calibrate:`, or what stands for it.
    pub effects: Vec<String>,
    /// Parameters that the readings determine, base and tool included.
    pub parameters: Vec<String>,
}

/// Both ends of an interval, null where there is none.
fn ends(interval: Option<[f64; 2]>) -> [Option<f64>; 2] {
    interval.map_or([None; 2], |ends| ends.map(Some))
}

impl Diagnosis {
    /// With the variables of a model.
    pub fn new(model: &Model, campaign: &Campaign, found: &diagnosis::Diagnosis, seconds: f64) -> Self {
        let (gap, location) = (&found.gap, &found.location);
        let [rms, max] = found.with_outliers.unwrap_or([gap.rms, gap.max]);
        // Of the whole, the causes proper have only what the outliers leave.
        let left = gap.rms / rms.max(f64::MIN_POSITIVE);
        let of_all = |shrinkage: f64| 1.0 - left * (1.0 - shrinkage);
        let [x, y, z] = location.directions.map(mm);
        let region =
            |r: &diagnosis::Region| Region { when: r.when.clone(), rms: mm(r.rms), elsewhere: mm(r.elsewhere) };
        let rejected = |r: &diagnosis::Rejected| {
            let (effect, site) = (r.effect.clone(), r.site.clone());
            Rejected { effect, site, rms_after: mm(r.rms), why: r.why }
        };
        Self {
            gap: Gap {
                rms: mm(rms),
                max: mm(max),
                without_outliers: found.with_outliers.map(|_| mm(gap.rms)),
                noise: mm(gap.noise),
                closable: mm((rms * rms - gap.noise * gap.noise).max(0.0).sqrt()),
                unit: "mm",
                significant: gap.is_significant || found.with_outliers.is_some(),
                registration: gap.registration.map(mm),
            },
            location: Location {
                sites: location.sites.clone(),
                conditions: location.regions.iter().map(region).collect(),
                directions: Directions { x, y, z },
                yielding: location.excess_compliance.clone(),
            },
            verdict: found.verdict,
            causes: found.causes.iter().map(cause).collect(),
            rejected: found.rejected.iter().map(rejected).collect(),
            with_none: mm(found.rms_with_none),
            after_all: AfterAll {
                rms: mm(found.rms_after),
                rms_ci95: ends(found.rms_after_ci95).map(|v| v.map(mm)),
                rms_of_robot: found.rms_of_robot.map(mm),
                shrinkage: of_all(found.shrinkage.value),
                shrinkage_ci95: ends(found.shrinkage.ci95.map(|ends| ends.map(of_all))),
            },
            structure: found.autocorrelation.clone(),
            next_poses: found.next_poses.iter().map(|pose| next_pose(model, pose)).collect(),
            look_alikes: found.look_alikes.clone(),
            outliers: found.outliers.clone(),
            outliers_at: found.outliers_at.clone(),
            not_tried: found.not_tried.clone(),
            excluded: found.excluded.clone(),
            noise: Noise {
                value: mm(gap.noise),
                orientation: NoiseSources::new(campaign).orientation,
                source: found.noise_source.into(),
                instrument: ShownNoise::new(campaign).filter(|_| found.noise_source == NoiseSource::Residual),
            },
            rest: (&found.rest).into(),
            hypotheses: found.hypotheses,
            notes: Notes { noise: NoiseFrom::from(found.noise_source).words() },
            seconds,
            own_weight: OwnWeight::of_campaign(model, &model.registry.nominal(), campaign),
            drawn_from: found.drawn_from,
            refitted: Refitted {
                effects: campaign.calibrate.clone(),
                parameters: found.refitted.iter().map(|slot| model.registry[*slot].name.clone()).collect(),
            },
            since: None,
            campaign: campaign.name.clone(),
        }
    }
}

/// A configuration at which rivals differ, with the variables of a model.
fn next_pose(model: &Model, pose: &diagnosis::NextPose) -> NextPose {
    NextPose {
        joints: model.variables.iter().zip(&pose.q).map(|(v, q)| (v.name.clone(), *q)).collect(),
        wrench: pose.wrench,
        separates: pose.separates.clone(),
        apart: mm(pose.apart),
        sigmas: pose.sigmas,
    }
}

fn cause(cause: &diagnosis::Cause) -> Cause {
    Cause {
        effect: cause.effect.clone(),
        site: cause.site.clone(),
        claim: claim(cause),
        probability: cause.probability,
        parameters: cause.parameters.clone(),
        rms_before: mm(cause.rms_before),
        rms_after: mm(cause.rms_after),
        shrinkage: cause.shrinkage.value,
        shrinkage_ci95: ends(cause.shrinkage.ci95),
        indistinguishable_from: cause.rivals.clone(),
        family: cause.family,
        level: cause.level,
        follows: cause.follows.clone(),
        stability: cause.stability,
        support: cause.support,
        curve: cause.curve.clone(),
        curves: cause.curves.clone(),
        implies: cause.implies.clone(),
        signature: match cause.level {
            Level::Family if cause.curve.is_some() || !cause.curves.is_empty() => {
                format!("a curve at {} shows it; it may as well be elsewhere", cause.site).into()
            }
            _ => cause.signature.into(),
        },
        remedy: cause.remedy,
    }
}

/// Most names given with a cause that the readings do not separate from it.
const NAMED_WITH: usize = 2;

/// A cause as far as it is certain.
fn claim(cause: &diagnosis::Cause) -> String {
    let follows = cause.follows.as_ref().map_or(String::new(), |follows| format!(" that goes with {follows}"));
    match cause.level {
        Level::Law => {
            let tied =
                cause.rivals.iter().take(NAMED_WITH).map(|rival| format!(" or {} at {}", rival.effect, rival.site));
            format!("{} at {}{}", cause.effect, cause.site, tied.collect::<String>())
        }
        Level::Site => format!("something at {}{follows}, its law unknown", cause.site),
        Level::Family => format!("{} (site and law unknown)", cause.family.words()),
    }
}
