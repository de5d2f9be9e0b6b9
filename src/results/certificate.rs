//! What a certificate states: errors on readings that the calibration did not see, the verdict on a tolerance, accuracy and
//! repeatability of poses. Lengths in mm, angles in deg.

use serde::Serialize;

use super::errors::FitOrCheck;
use super::units::{deg, mm};
use crate::description::campaign::raw::RawCertificate;
use crate::description::campaign::{Campaign, NoiseOrigin};
use crate::diagnostic::Diagnostic;
use crate::estimation::Calibration;
use crate::math::norm;
use crate::model::Model;
use crate::review::{Direction, Repeated, repeated};

/// Coverage factor of expanded uncertainties: 95 % of a normal distribution (JCGM 100:2008, 6.2.2).
pub const COVERAGE: f64 = 2.0;

/// What is decided of a tolerance, with the measurement's uncertainty against whoever decides (ISO 14253-1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The greatest error and its expanded uncertainty are within the tolerance.
    Pass,
    /// The greatest error is beyond it by more than its expanded uncertainty.
    Fail,
    /// Neither, or the instrument's uncertainty is not stated.
    Undecided,
}

/// Position errors of readings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CertifiedErrors {
    /// Number of readings.
    pub readings: usize,
    /// Mean error, mm.
    pub mean: f64,
    /// Root mean square error, mm.
    pub rms: f64,
    /// Greatest error, mm.
    pub max: f64,
    /// Mean and three standard deviations.
    pub mean_3s: f64,
}

/// One reading: Euclidean errors with base and markers fitted alone, and calibrated.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CertifiedReading {
    /// Row of the measurements' file.
    pub row: usize,
    /// Name of the configuration.
    pub pose: String,
    /// Name of the marker; `TCP` is the tool centre point.
    pub marker: String,
    /// Whether it was fitted or held out.
    pub set: FitOrCheck,
    /// Position error with base and markers fitted alone, mm.
    pub before: f64,
    /// Position error after calibration, mm.
    pub after: f64,
    /// Along x, y, z of the measurement frame, calibrated.
    pub error: Vec<f64>,
}

/// A pose measured several times (ISO 9283:1998, 7.2): AP, RP and, reached from several sides, vAP.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CertifiedPose {
    /// Name of the configuration of its first reading.
    pub pose: String,
    /// Name of the marker; `TCP` is the tool centre point.
    pub marker: String,
    /// Number of readings.
    pub cycles: usize,
    /// AP with base and markers fitted alone.
    pub accuracy_before: f64,
    /// AP, calibrated; where sides of approach are known and have two cycles each, the greatest over the sides.
    pub accuracy: f64,
    /// RP, likewise.
    pub repeatability: f64,
    /// AP of the orientation, calibrated, deg: angle of the mean rotation error; `None` of readings without orientation.
    pub orientation_accuracy: Option<f64>,
    /// RP of the orientation, calibrated, deg; `None` of readings without orientation.
    pub orientation_repeatability: Option<f64>,
    /// vAP.
    pub variation: Option<f64>,
    /// AP and RP over the cycles of all sides together, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub multidirectional: Option<[f64; 2]>,
    /// Of each side of approach, where there are several.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub directions: Vec<CertifiedDirection>,
}

/// Cycles of a pose in which joints came from one side.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CertifiedDirection {
    /// Variables whose side of approach is known, with the sign of its column: `q1+` came from above, its angle falling.
    pub approach: String,
    /// Number of readings from this side.
    pub cycles: usize,
    /// AP of the position over these readings, calibrated, mm.
    pub accuracy: f64,
    /// `None` of a single cycle.
    pub repeatability: Option<f64>,
}

/// The instrument.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CertifiedInstrument {
    /// Greatest stated standard deviation of a coordinate.
    pub sigma: f64,
    /// Expanded uncertainty of the error of a reading, k = 2.
    pub expanded: f64,
}

/// What a certificate states.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Certificate {
    /// Name of the campaign.
    pub campaign: String,
    /// Maker and type of the robot as `about` states them, or else the description's name.
    pub robot: String,
    /// Unit of lengths.
    pub unit: &'static str,
    /// Factor from standard to expanded uncertainties: 2, for 95 % of a normal distribution.
    pub coverage_factor: f64,
    /// Verdict on the tolerance; `None` where no tolerance was given.
    pub verdict: Option<Verdict>,
    /// Greatest position error allowed, mm, where it was given.
    pub tolerance: Option<f64>,
    /// Why it is decided so; without a tolerance, why the readings held out cannot judge, if they cannot.
    pub reason: Option<String>,
    /// Whether the errors are those of readings held out.
    pub held_out: bool,
    /// Errors of the readings that judge, with base and markers fitted alone.
    pub before: CertifiedErrors,
    /// Errors of the readings that judge, calibrated.
    pub after: CertifiedErrors,
    /// `None` where no noise is stated.
    pub instrument: Option<CertifiedInstrument>,
    /// Expanded uncertainty (k = 2) of the positions that the calibrated description predicts: root mean square and
    /// greatest over the readings.
    pub predicted: Option<[f64; 2]>,
    /// Accuracy and repeatability of poses measured several times.
    pub poses: Vec<CertifiedPose>,
    /// Errors of each reading, fitted ones included.
    pub readings: Vec<CertifiedReading>,
    /// What the campaign states for the certificate: customer, instrument, traceability and so on.
    pub about: RawCertificate,
    /// Whether the calibration ended at a minimum.
    pub converged: bool,
    /// Of the program.
    pub version: &'static str,
    /// The command that made it.
    pub command: String,
}

impl Certificate {
    /// From a calibration; `predicted` are the standard uncertainties (m) of all predicted positions, `tolerance` is in m.
    pub fn new(
        model: &Model,
        campaign: &Campaign,
        found: &Calibration,
        predicted: Option<&[[f64; 3]]>,
        about: RawCertificate,
        tolerance: Option<f64>,
        command: String,
    ) -> Self {
        let places = campaign.by_difference().map(|[places, _]| (places, of_places(campaign, found)));
        let (campaign, found) = places.as_ref().map_or((campaign, found), |(places, found)| (places, found));
        let held_out = found.held_out.contains(&true);
        let judges =
            |index: usize| (!held_out || found.held_out[index]) && campaign.readings[index].observes.length_rows() > 0;
        let (before, after) = (sizes(campaign, &found.registered), sizes(campaign, &found.residual));
        let of = |all: &[f64]| certified((0..all.len()).filter(|&index| judges(index)).map(|index| all[index]));
        let is_stated = campaign.noise_origin == NoiseOrigin::Stated
            && campaign.readings.iter().filter(|r| r.observes.length_rows() > 0).all(|r| r.noise.is_stated[0]);
        let sigma = campaign.readings.iter().flat_map(|r| {
            let lengths = r.observes.length_rows();
            r.observes.sigmas(&r.noise).into_iter().take(lengths).collect::<Vec<_>>()
        });
        let sigma = sigma.fold(0.0, f64::max);
        let instrument = is_stated.then(|| CertifiedInstrument { sigma: mm(sigma), expanded: mm(COVERAGE * sigma) });
        let all = found.held_out.iter().filter(|held| **held).count();
        let both = campaign.held_out_and_fitted(|index| found.held_out.get(index).copied()).len();
        let seen = (2 * both > all).then(|| {
            format!("{both} of the {all} readings that are held out stand at configurations that were fitted as well: measure others")
        });
        let (verdict, reason) = match tolerance {
            None => (None, seen),
            Some(tolerance) => {
                let (verdict, reason) = match seen {
                    Some(why) => (Verdict::Undecided, why),
                    None => decide(of(&after).max, mm(tolerance), instrument.map(|own| own.expanded)),
                };
                (Some(verdict), Some(reason))
            }
        };
        let size = |own: &[f64; 3]| mm(COVERAGE * norm(own));
        let predicted = predicted.filter(|all| !all.is_empty()).map(|all| {
            let squares = all.iter().map(|own| size(own).powi(2)).sum::<f64>();
            [(squares / all.len() as f64).sqrt(), all.iter().map(size).fold(0.0, f64::max)]
        });
        Self {
            campaign: campaign.name.clone(),
            robot: about.robot.clone().unwrap_or_else(|| model.name.clone()),
            unit: "mm",
            coverage_factor: COVERAGE,
            verdict,
            tolerance: tolerance.map(mm),
            reason,
            held_out,
            before: of(&before),
            after: of(&after),
            instrument,
            predicted,
            poses: poses(model, campaign, found),
            readings: readings(model, campaign, found, [&before, &after]),
            about,
            converged: found.converged(),
            version: env!("CARGO_PKG_VERSION"),
            command,
        }
    }

    /// Withdraws a pass where something casts doubt on the figures.
    pub fn doubted(&mut self, doubts: &[Diagnostic]) {
        if let (Some(Verdict::Pass), Some(first)) = (self.verdict, doubts.first()) {
            self.verdict = Some(Verdict::Undecided);
            let reason = self.reason.take().unwrap_or_default();
            self.reason = Some(format!("{reason}, but the figures are doubtful ({})", first.code.name()));
        }
    }
}

/// A calibration without what it leaves of deflections, which are no position errors.
fn of_places(campaign: &Campaign, found: &Calibration) -> Calibration {
    let is_place = |index: usize| !campaign.readings[index].observes.is_difference();
    let of = |all: &[f64]| -> Vec<f64> {
        let own = campaign.by_reading(all, 1).enumerate().filter(|(index, _)| is_place(*index));
        own.flat_map(|(_, (_, rows))| rows).copied().collect()
    };
    let held_out = found.held_out.iter().enumerate().filter(|(index, _)| is_place(*index)).map(|(_, held)| *held);
    Calibration {
        registered: of(&found.registered),
        residual: of(&found.residual),
        held_out: held_out.collect(),
        ..found.clone()
    }
}

/// The rule of ISO 14253-1, in mm.
fn decide(max: f64, tolerance: f64, expanded: Option<f64>) -> (Verdict, String) {
    let Some(expanded) = expanded else {
        let why = "The instrument's noise is not stated (instrument: {sigma: ..}): errors cannot be separated from measurement noise";
        return (Verdict::Undecided, why.into());
    };
    let greatest = format!("The greatest error is {max:.4} mm, with an expanded uncertainty of {expanded:.4} mm");
    if max + expanded <= tolerance {
        (Verdict::Pass, format!("{greatest}: both together are within {tolerance:.4} mm"))
    } else if max - expanded > tolerance {
        (Verdict::Fail, format!("{greatest}: beyond {tolerance:.4} mm by more than that"))
    } else {
        (Verdict::Undecided, format!("{greatest}: too near to {tolerance:.4} mm to decide"))
    }
}

/// Euclidean position errors of all readings, mm; 0 of readings without lengths.
fn sizes(campaign: &Campaign, residual: &[f64]) -> Vec<f64> {
    let size = |own: &[f64]| mm(norm(own));
    campaign.by_reading(residual, 1).map(|(reading, own)| size(&own[..reading.observes.length_rows()])).collect()
}

fn certified(all: impl Iterator<Item = f64> + Clone) -> CertifiedErrors {
    let [mean, rms, max] = crate::math::mean_rms_max(all.clone());
    let readings = all.clone().count();
    let squares = all.map(|e| (e - mean).powi(2)).sum::<f64>();
    let deviation = if readings > 1 { (squares / (readings - 1) as f64).sqrt() } else { 0.0 };
    CertifiedErrors { readings, mean, rms, max, mean_3s: mean + 3.0 * deviation }
}

fn marker(model: &Model, campaign: &Campaign, index: usize) -> String {
    campaign.readings[index].marker.map_or("TCP", |marker| model.markers[marker].name.as_str()).to_string()
}

fn pose(campaign: &Campaign, index: usize) -> String {
    campaign.poses[campaign.readings[index].pose].clone()
}

fn poses(model: &Model, campaign: &Campaign, found: &Calibration) -> Vec<CertifiedPose> {
    let before = repeated(campaign, &found.registered);
    let after = repeated(campaign, &found.residual);
    let direction = |own: &Direction| {
        let [accuracy, repeatability] = own.figures.position.map(mm);
        let moved = own.sides.iter().zip(&model.variables).filter(|(side, _)| **side != 0);
        let moved = moved.map(|(side, variable)| format!("{}{}", variable.name, if *side > 0 { '+' } else { '-' }));
        let repeatability = (own.count > 1).then_some(repeatability);
        CertifiedDirection { approach: moved.collect::<Vec<_>>().join(" "), cycles: own.count, accuracy, repeatability }
    };
    let one = |(before, after): (&Repeated, &Repeated)| {
        let own = after.unidirectional();
        CertifiedPose {
            pose: pose(campaign, after.first),
            marker: marker(model, campaign, after.first),
            cycles: after.count,
            accuracy_before: mm(before.unidirectional().position[0]),
            accuracy: mm(own.position[0]),
            repeatability: mm(own.position[1]),
            orientation_accuracy: own.orientation.map(|[accuracy, _]| deg(accuracy)),
            orientation_repeatability: own.orientation.map(|[_, spread]| deg(spread)),
            variation: after.variation.map(mm),
            multidirectional: (!after.directions.is_empty()).then(|| after.position.map(mm)),
            directions: after.directions.iter().map(direction).collect(),
        }
    };
    before.iter().zip(&after).map(one).collect()
}

fn readings(model: &Model, campaign: &Campaign, found: &Calibration, sizes: [&[f64]; 2]) -> Vec<CertifiedReading> {
    let one = |(index, (reading, own)): (usize, (&crate::description::campaign::Reading, &[f64]))| CertifiedReading {
        row: reading.row,
        pose: pose(campaign, index),
        marker: marker(model, campaign, index),
        set: FitOrCheck::of(found.held_out[index]),
        before: sizes[0][index],
        after: sizes[1][index],
        error: own[..reading.observes.length_rows()].iter().map(|v| mm(*v)).collect(),
    };
    campaign.by_reading(&found.residual, 1).enumerate().map(one).collect()
}
