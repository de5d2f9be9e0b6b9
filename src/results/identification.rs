//! What `identify` finds. Lengths in mm, angles in deg, stiffnesses in SI.

use serde::Serialize;

use super::against::AgainstOther;
use super::combinations::CombinedParameters;
use super::configurations::ConfigurationResidual;
use super::errors::ReadingErrors;
use super::faces::{OfFace, of_faces};
use super::identifiability::Reduction;
use super::own_weight::OwnWeight;
use super::parts::{PartErrors, WorstReading, parts, worst};
use super::since::Since;
use super::springs::{SpringGroup, insensitive, least_stiffness};
use super::units::{mm, unit};
use crate::description::campaign::{Campaign, NoiseOrigin, Reading};
use crate::diagnostic::Diagnostic;
use crate::estimation::{Calibration, Comparison, Estimate};
use crate::math::quantiles::normal95;
use crate::model::Model;
use crate::observation::Observes;

/// A parameter as estimated, in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParameterEstimate {
    /// Name of the parameter.
    pub name: String,
    /// Unit of its values and intervals.
    pub unit: &'static str,
    /// `None` where nothing is: of a face whose place is unknown.
    pub nominal: Option<f64>,
    /// Nominal where it was dropped.
    pub value: f64,
    /// Half width of the 95 % interval; `None` where it was dropped.
    pub ci95: Option<f64>,
    /// Ends of the 95 % interval of a spring whose logarithm was fitted (`--logarithms`).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval: Option<[f64; 2]>,
    /// Standard uncertainty within it by what dropped parameters do in second order; `None` where that is nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub of_dropped: Option<f64>,
    /// Whether it was estimated.
    pub identifiable: bool,
    /// Whether it stopped at a bound.
    pub at_bound: bool,
    /// Greatest displacement of a fitted reading by an elastic parameter, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub moves: Option<f64>,
    /// Whether that is below a third of the noise, so that other values fit as well; of elastic parameters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub insensitive: Option<bool>,
    /// Of a compliance: the least stiffness that fits, and its unit.
    #[serde(skip)]
    pub least_stiffness: Option<(f64, &'static str)>,
}

impl ParameterEstimate {
    /// As a face shows it.
    fn shown_of_face(&mut self, of: &OfFace) {
        self.nominal = self.nominal.filter(|_| of.has_nominal);
        if let Some((value, ci95)) = of.component {
            (self.value, self.ci95, self.identifiable) = (value, ci95, ci95.is_some());
            self.of_dropped = None;
        }
    }

    /// Whether it was dropped, and has another value than the description's: that to which others are fitted.
    pub fn is_held_elsewhere(&self) -> bool {
        let is_other = |nominal: f64| (self.value - nominal).abs() > 1e-9 * nominal.abs().max(1.0);
        !self.identifiable && self.nominal.is_some_and(is_other)
    }

    /// Whether what dropped parameters do in second order is more than half of its variance.
    pub fn is_uncertain_by_dropped(&self) -> bool {
        self.of_dropped.zip(self.ci95).is_some_and(|(open, ci95)| normal95() * open > ci95 / 2.0_f64.sqrt())
    }
}

/// Errors before and after, of fitted readings and of those held out to check; `None` of no readings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Residuals {
    /// With the description as it is.
    pub before: Option<ReadingErrors>,
    /// With base, tool and markers fitted alone.
    pub registration: Option<ReadingErrors>,
    /// Calibrated.
    pub after: Option<ReadingErrors>,
    /// Readings held out, with the description as it is.
    pub check_before: Option<ReadingErrors>,
    /// Readings held out, with base, tool and markers fitted alone.
    pub check_registration: Option<ReadingErrors>,
    /// Readings held out, calibrated.
    pub check_after: Option<ReadingErrors>,
}

/// Root mean square position errors of the readings held out, mm: predicted and observed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PredictedError {
    /// By the covariance of the parameters alone.
    pub parameters_rms: f64,
    /// With the residual noise added.
    pub with_noise_rms: f64,
    /// As observed.
    pub observed_rms: f64,
}

/// Where a noise comes from by which readings are weighed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum WeightSource {
    /// The campaign states it.
    Stated,
    /// Scatter of the distances between markers of one body.
    Markers,
    /// Scatter of readings repeated in place.
    Repeats,
    /// Scatter of fixed reflectors.
    References,
    /// What the model leaves, its own errors included.
    Residuals,
}

impl WeightSource {
    /// What shows a noise that is not stated; `None` of one that is, and of residuals.
    pub fn shown_by(self) -> Option<&'static str> {
        match self {
            Self::Markers => Some("distances between rigid markers"),
            Self::Repeats => Some("readings repeated in place"),
            Self::References => Some("fixed reflectors"),
            Self::Stated | Self::Residuals => None,
        }
    }
}

/// Where the noise comes from by which readings are weighed and intervals judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct NoiseSources {
    /// Of positions; of orientations or torques, where no reading holds a length.
    pub position: WeightSource,
    /// Of orientations; `None` where no reading has both a position and an orientation, and none is stated.
    pub orientation: Option<WeightSource>,
}

impl NoiseSources {
    pub(super) fn new(campaign: &Campaign) -> Self {
        let source = |is_stated: bool| if is_stated { WeightSource::Stated } else { WeightSource::Residuals };
        let has_both = |reading: &Reading| reading.observes.length_rows() > 0 && reading.observes.angle_rows() > 0;
        let has_angles = |reading: &Reading| reading.observes.angle_rows() > 0;
        let is_stated = campaign.sigma_orientation.is_some() && campaign.readings.iter().any(has_angles);
        let position = match campaign.noise_origin {
            NoiseOrigin::Stated => source(campaign.states_noise()),
            NoiseOrigin::RigidMarkers => WeightSource::Markers,
            NoiseOrigin::Repeats => WeightSource::Repeats,
            NoiseOrigin::References => WeightSource::References,
        };
        Self { position, orientation: (is_stated || campaign.readings.iter().any(has_both)).then(|| source(is_stated)) }
    }
}

/// What `identify` finds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Identification {
    /// Which parameters the readings determine.
    #[serde(flatten)]
    pub reduction: Reduction,
    /// All candidates.
    pub parameters: Vec<ParameterEstimate>,
    /// Springs that the readings see as one.
    pub equivalences: Vec<SpringGroup>,
    /// Errors before and after, of fitted readings and of those held out.
    pub residuals: Residuals,
    /// Calibrated errors of the readings that judge, by session, station, file, kind and marker, where there are several.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<PartErrors>,
    /// The readings that the calibrated description fits worst.
    pub worst: Vec<WorstReading>,
    /// Whether the predictions hold the deflection by own weight.
    pub own_weight: OwnWeight,
    /// `None` where nothing is held out.
    pub predicted_error: Option<PredictedError>,
    /// Observed and predicted error of each configuration held out.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub configurations: Vec<ConfigurationResidual>,
    /// Residuals over the stated noise; `None` where none is stated.
    pub noise_ratio: Option<f64>,
    /// Where the noise comes from by which readings are weighed.
    pub noise_sources: NoiseSources,
    /// Residual noise along x, y, z, mm.
    pub direction_noise: [f64; 3],
    /// Of the kept parameters, in the order of `kept_parameters`.
    pub correlation: Vec<Vec<f64>>,
    /// Unit of position errors.
    pub unit: &'static str,
    /// Iterations of the fit.
    pub iterations: usize,
    /// Root mean square of the residuals over their sigmas after each step taken.
    pub history: Vec<f64>,
    /// What has moved since an earlier description, where one was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub since: Option<Since>,
    /// In the parameters of the conventions that the description declares under `combinations:`; that key is here what each kept
    /// parameter absorbed.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub conventions: Vec<CombinedParameters>,
    /// The result against another set of parameters, where one was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub against: Option<AgainstOther>,
    /// Why the fit ended.
    pub ending: String,
    /// Whether the fit ended at a minimum.
    pub converged: bool,
    /// Time that it took, s.
    pub seconds: f64,
    /// Why the result is not to be used; nothing where it may be.
    #[serde(skip)]
    pub refusals: Vec<Diagnostic>,
    /// The campaign's name.
    #[serde(skip)]
    pub campaign: String,
    /// What its readings are.
    #[serde(skip)]
    pub observes: Observes,
    /// Root mean square position error by the noise, mm; `None` where it is not known.
    #[serde(skip)]
    pub noise: Option<f64>,
    /// Coordinates (or distances) of all readings after calibration, m.
    #[serde(skip)]
    pub left: Vec<f64>,
}

impl Identification {
    /// With the names and units of a model.
    pub fn new(model: &Model, campaign: &Campaign, found: &Calibration, seconds: f64) -> Self {
        let errors = ReadingErrors::new;
        let (before, registration, after) = (&found.before, &found.registration, &found.after);
        let residuals = Residuals {
            before: errors(&before.fit),
            registration: errors(&registration.fit),
            after: errors(&after.fit),
            check_before: errors(&before.check),
            check_registration: errors(&registration.check),
            check_after: errors(&after.check),
        };
        let stated = stated_error(campaign);
        let is_checked = found.held_out.contains(&true);
        let mut parameters: Vec<_> = found.estimates.iter().map(|e| parameter(model, campaign, e)).collect();
        for of in of_faces(model, campaign, found) {
            parameters[of.column].shown_of_face(&of);
        }
        Self {
            reduction: Reduction::new(model, &found.slots, &found.identifiability),
            parameters,
            equivalences: found.equivalences.iter().map(|g| SpringGroup::new(model, campaign, found, g)).collect(),
            predicted_error: found.predicted.filter(|_| stated.is_some()).map(|predicted| PredictedError {
                parameters_rms: mm(predicted.parameters),
                with_noise_rms: mm(predicted.with_noise),
                observed_rms: mm(after.check.distance[1]),
            }),
            configurations: ConfigurationResidual::all(campaign, &found.configurations),
            residuals,
            parts: parts(model, campaign, &found.residual, |index| !is_checked || found.held_out[index]),
            worst: worst(model, campaign, &found.residual, &found.held_out),
            own_weight: OwnWeight::of_campaign(model, &found.values, campaign),
            noise_ratio: campaign.states_noise().then_some(found.noise_ratio),
            noise_sources: NoiseSources::new(campaign),
            direction_noise: found.direction_noise.map(mm),
            correlation: found.correlation.row_iter().map(|row| row.iter().copied().collect()).collect(),
            unit: "mm",
            iterations: found.iterations,
            history: found.history.clone(),
            since: None,
            conventions: Vec::new(),
            against: None,
            ending: found.ending.to_string(),
            converged: found.converged(),
            seconds,
            refusals: Vec::new(),
            campaign: campaign.name.clone(),
            observes: campaign.observes,
            noise: campaign.sigma.and(stated).map(mm),
            left: campaign
                .by_reading(&found.residual, 1)
                .flat_map(|(reading, own)| &own[..reading.observes.length_rows()])
                .copied()
                .collect(),
        }
    }

    /// Whether readings are held out to check.
    pub fn is_checked(&self) -> bool {
        self.residuals.check_after.is_some()
    }

    /// Root mean square errors with the description as it is, with base and tool fitted alone, and calibrated, mm
    /// ([`Identification::judged_unit`]), of the readings by which the calibration is judged: those held out, or the fitted ones where none are.
    pub fn judged(&self) -> [f64; 3] {
        let r = &self.residuals;
        let of = if self.is_checked() {
            [&r.check_before, &r.check_registration, &r.check_after]
        } else {
            [&r.before, &r.registration, &r.after]
        };
        let size = |errors: &ReadingErrors| match (self.has_lengths(), &errors.orientation, &errors.load) {
            (false, Some(turned), _) => turned.rms,
            (false, None, Some(load)) => load.rms,
            _ => errors.rms,
        };
        of.map(|errors| errors.as_ref().map_or(0.0, size))
    }

    /// Unit of what judges.
    pub fn judged_unit(&self) -> &'static str {
        let of = self.residuals.after.as_ref();
        match of {
            Some(errors) if !self.has_lengths() && errors.orientation.is_some() => "deg",
            Some(errors) if !self.has_lengths() && errors.load.is_some() => "N.m",
            _ => "mm",
        }
    }

    /// Whether readings hold lengths; where they hold angles only, these judge, and else torques.
    pub fn has_lengths(&self) -> bool {
        !self.left.is_empty()
    }

    /// Whether base and tool affect the readings: not deflections.
    pub fn is_registered(&self) -> bool {
        !self.observes.is_difference()
    }
}

/// Root mean square position error that the noise of the readings makes, m; `None` where none holds a length.
pub(super) fn stated_error(campaign: &Campaign) -> Option<f64> {
    let square = |reading: &Reading| -> f64 {
        let lengths = reading.observes.length_rows();
        reading.observes.sigmas(&reading.noise)[..lengths].iter().map(|s| s * s).sum()
    };
    let with_lengths = || campaign.readings.iter().filter(|reading| reading.observes.length_rows() > 0);
    let count = with_lengths().count();
    (count > 0).then(|| (with_lengths().map(square).sum::<f64>() / count as f64).sqrt())
}

fn parameter(model: &Model, campaign: &Campaign, estimate: &Estimate) -> ParameterEstimate {
    let parameter = &model.registry[estimate.slot];
    let (unit, size) = unit(parameter.shown_kind());
    let shown = |value: f64| parameter.shown(value) / size;
    ParameterEstimate {
        name: parameter.name.clone(),
        unit,
        nominal: Some(shown(estimate.nominal)),
        value: shown(estimate.value),
        ci95: estimate.ci95.map(|ci95| parameter.shown_width(estimate.value, ci95) / size),
        interval: estimate.interval.map(|ends| {
            let [a, b] = ends.map(shown);
            [a.min(b), a.max(b)]
        }),
        of_dropped: estimate.of_dropped.map(|open| parameter.shown_width(estimate.value, open) / size),
        identifiable: estimate.identifiable(),
        at_bound: estimate.at_bound,
        moves: estimate.moves.map(mm),
        insensitive: estimate.moves.map(|_| insensitive(campaign, estimate)),
        least_stiffness: least_stiffness(parameter, estimate),
    }
}

/// Ordinary (equal weights) and weighted (noise by direction) least squares.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SchemeComparison {
    /// By ordinary least squares.
    pub ols: Identification,
    /// By weighted least squares.
    pub wls: Identification,
}

impl SchemeComparison {
    /// With the names and units of a model.
    pub fn new(model: &Model, campaign: &Campaign, found: &Comparison, seconds: f64) -> Self {
        let of = |found: &Calibration| Identification::new(model, campaign, found, seconds);
        Self { ols: of(&found.ols), wls: of(&found.wls) }
    }
}
