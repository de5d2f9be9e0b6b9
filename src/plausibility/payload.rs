//! What the tool carries, stated with a mass or a centre in another unit: springs take up part of it, and the rest is left.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::evidence::{Evidence, Limits};
use super::readings::AS_GOOD;
use super::shown::{mm, number};
use super::trial::drawn;
use crate::description::campaign::Campaign;
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::{Calibration, Settings, calibrate};

/// A payload that was meant instead: its mass and its centre times a factor, and what the number then is.
struct Meant {
    mass: f64,
    com: f64,
    question: &'static str,
}

/// Pound, kg.
const POUND: f64 = 0.453_592_37;
/// Standard gravity, m/s2.
const GRAVITY: f64 = 9.80665;

/// Powers of ten, pounds and weights for masses; units of length for centres.
const MEANT: [Meant; 12] = [
    Meant::of_mass(0.1, "a decimal sign in another place"),
    Meant::of_mass(10.0, "a decimal sign in another place"),
    Meant::of_mass(1e-3, "a mass in g"),
    Meant::of_mass(1e3, "a mass in t"),
    Meant::of_mass(POUND, "a mass in lb"),
    Meant::of_mass(1.0 / POUND, "a mass in kg where lb were meant"),
    Meant::of_mass(1.0 / GRAVITY, "a weight in N"),
    Meant::of_mass(GRAVITY, "a mass divided by gravity"),
    Meant::of_com(10.0, "a centre in cm"),
    Meant::of_com(0.1, "a centre in mm where cm were meant"),
    Meant::of_com(1e3, "a centre in m"),
    Meant::of_com(25.4, "a centre in inches"),
];

impl Meant {
    const fn of_mass(mass: f64, question: &'static str) -> Self {
        Self { mass, com: 1.0, question }
    }

    const fn of_com(com: f64, question: &'static str) -> Self {
        Self { mass: 1.0, com, question }
    }

    fn apply(&self, campaign: &Campaign) -> Campaign {
        let mut meant = campaign.clone();
        for payload in meant.readings.iter_mut().filter_map(|reading| reading.payload.as_mut()) {
            payload.mass *= self.mass;
            payload.com *= self.com;
        }
        meant
    }

    fn with(&self) -> String {
        match self.com {
            1.0 => format!("the payload's mass times {}", number(self.mass)),
            com => format!("the payload's centre of mass times {}", number(com)),
        }
    }
}

/// Steps within which a payload that is meant is fitted, begun at the description: wrong ones may take hundreds.
const STEPS: usize = 15;
/// Readings on which they are compared: several times the parameters of an arm with its springs.
const READINGS: usize = 240;

/// Where calibration leaves more than the noise, the same with the payload as it may be meant, on some of the configurations. It is named where
/// nothing but noise is left, or a small part of the error: springs that are off leave much with any payload.
pub(super) fn as_declared(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let is_open = |found: &&Calibration| {
        found.converged() && found.noise_ratio > limits.joints_fall && found.degrees_of_freedom >= limits.noise_freedom
    };
    let Some(found) = evidence.found.filter(is_open).filter(|_| !campaign.is_difference()) else { return Vec::new() };
    let carried = || campaign.readings.iter().filter_map(|reading| reading.payload).filter(|own| own.mass > 0.0);
    if campaign.sigma.is_none() || carried().next().is_none() {
        return Vec::new();
    }
    let is_off_centre = carried().any(|payload| payload.com != Vector3::zeros());
    let chosen = drawn(campaign, &Limits { readings: READINGS, ..*limits });
    let is_fitted = |index: usize| !found.held_out.get(index).copied().unwrap_or(false);
    let some = campaign.select(|index, reading| is_fitted(index) && chosen[reading.pose]);
    let none = vec![false; some.readings.len()];
    let left = |campaign: &Campaign, steps: Option<usize>| {
        let settings = Settings {
            only: Some(found.slots.clone()),
            second_order: false,
            max_iterations: steps,
            ..Settings::default()
        };
        let again = calibrate(model, campaign, &none, &settings, &mut |_| {}).ok()?;
        Some((again.converged(), again.after.fit.distance[1], again.noise_ratio))
    };
    let Some((_, here, _)) = left(&some, Some(STEPS)) else { return Vec::new() };
    let all: Vec<&Meant> = MEANT.iter().filter(|meant| meant.com == 1.0 || is_off_centre).collect();
    let is_decisive = |(is_converged, there, ratio): &(bool, f64, f64)| {
        let is_noise = *ratio <= limits.joints_fall && here >= limits.joints_fall * there;
        *is_converged && (is_noise || here >= limits.fall * there)
    };
    let fitted = |meant: &Meant| left(&meant.apply(&some), Some(STEPS)).filter(is_decisive);
    let mut tried: Vec<(&Meant, f64)> =
        all.into_par_iter().filter_map(|meant| fitted(meant).map(|(_, there, _)| (meant, there))).collect();
    tried.sort_by(|a, b| a.1.total_cmp(&b.1));
    let Some(&(best, there)) = tried.first() else { return Vec::new() };
    let alike = tried.iter().skip(1).filter(|(_, error)| *error <= AS_GOOD * there);
    let others: String =
        alike.map(|(meant, error)| format!("; or {} ({} mm): {}?", meant.with(), mm(*error), meant.question)).collect();
    let message = format!(
        "with {} the error of calibration falls from {} to {} mm: {}?{others}",
        best.with(),
        mm(here),
        mm(there),
        best.question
    );
    let remedy = "look at `mass` and `com` under `payloads:`, and at `units:`; weigh what the tool carried; or are springs that are held off by \
                  as much?";
    let diagnostic = Diagnostic::warning(message).code(Code::WrongUnits).remedy(remedy);
    vec![diagnostic.figure("before_mm", 1e3 * here).figure("after_mm", 1e3 * there)]
}
