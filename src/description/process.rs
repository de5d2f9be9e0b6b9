//! Image of a process file: what pushes back on the tool, as a function of where the tool really is.

#[cfg(feature = "cli")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::resolve::{GREATEST, Locate};
use super::units::Units;
use crate::diagnostic::Diagnostic;

/// A process. Everything is in the robot's base frame; what is listed acts together.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct RawProcess {
    /// Display name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub process: Option<String>,
    /// Where the figures come from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// Units of this file; SI where absent.
    pub units: Units,
    /// Force on the tool at all times: a weight that it carries.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub carried: Option<[f64; 3]>,
    /// An elastic strip that the tool bends.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strip: Option<RawStrip>,
    /// Linear springs from fixed points to the tool.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub springs: Vec<RawAnchored>,
}

/// A cantilever strip, bent in its plane by the tip of the tool, which slides on its surface.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RawStrip {
    /// Point of the surface that the tool touches, in the middle of its width, where the strip leaves its clamp.
    pub clamp: [f64; 3],
    /// Direction from the clamp to the free end.
    pub along: [f64; 3],
    /// Direction in which the tool pushes; what of it lies along the strip is dropped.
    pub push: [f64; 3],
    /// From the clamp to the free end.
    pub length: f64,
    /// Across the plane of bending.
    pub width: f64,
    /// In the plane of bending.
    pub height: f64,
    /// Young's modulus.
    pub young: f64,
    /// How its deflection is computed.
    #[serde(default)]
    pub theory: Theory,
    /// Coefficient of friction between tool and strip, against the tool's travel.
    #[serde(default)]
    pub friction: f64,
    /// Yield stress: bent beyond it the strip keeps part of its bend, for the points of the path that follow. Needs `theory:
    /// large`; without it the strip stays elastic.
    #[serde(rename = "yield", default, skip_serializing_if = "Option::is_none")]
    pub yields: Option<f64>,
    /// Tangent modulus beyond the yield stress, in the unit of pressure; 0 (perfectly plastic) where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hardening: Option<f64>,
}

/// Theory of bending.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Theory {
    /// Small slopes: the force stands across the straight strip.
    EulerBernoulli,
    /// Geometrically exact: the strip bends as an elastica, and the force stands across it where it is touched.
    #[default]
    Large,
}

/// A spring between a fixed point and the tool.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RawAnchored {
    /// Where it does not pull.
    pub at: [f64; 3],
    /// Force per displacement along the axes of the base; negative where it pushes away.
    pub stiffness: [f64; 3],
}

/// Farthest coordinate from the robot's base (m) that is no slip of units.
const FARTHEST: f64 = 100.0;
/// A strip softer than this (Pa) is no strip.
const SOFTEST: f64 = 1e6;
/// Greatest length of a strip (m), modulus (Pa) and stiffness of a spring (N/m) that are taken for one.
const LONGEST: f64 = 1e3;
const HARDEST: f64 = 1e13;
const STIFFEST: f64 = 1e12;

/// Values that no process has, and (as warnings) those that come of undeclared units.
pub fn faults(raw: &RawProcess, locate: Locate) -> Vec<Diagnostic> {
    let mut faults = Faults { locate, diagnostics: Vec::new() };
    if raw.carried.is_none() && raw.strip.is_none() && raw.springs.is_empty() {
        faults.add(&[], "the process does nothing to the tool", "give `strip`, `springs` or `carried`");
    }
    if raw.carried.is_some_and(|carried| !within(&carried, raw.units.force.factor())) {
        faults.add(&["carried"], "the force carried is not finite, or too great", "give three components");
    }
    if let Some(strip) = &raw.strip {
        faults.strip(strip, &raw.units);
    }
    for (index, spring) in raw.springs.iter().enumerate() {
        let index = index.to_string();
        if !within(&spring.at, raw.units.length.factor()) {
            faults.add(&["springs", &index, "at"], "`at` is not finite, or too far", "give three coordinates");
        }
        if !spring.stiffness.iter().all(|k| (k * raw.units.stiffness.factor()).abs() <= STIFFEST) {
            let path = ["springs", &index, "stiffness"];
            faults.add(&path, "the stiffness is no number that a spring has", "give three");
        }
    }
    faults.diagnostics.extend(doubtful_units(raw, locate));
    faults.diagnostics
}

/// Whether all are finite numbers that a length or a force can be.
fn within(values: &[f64], factor: f64) -> bool {
    values.iter().all(|v| (v * factor).abs() <= GREATEST)
}

struct Faults<'a> {
    locate: Locate<'a>,
    diagnostics: Vec<Diagnostic>,
}

impl Faults<'_> {
    fn add(&mut self, path: &[&str], message: impl Into<String>, remedy: &str) {
        self.diagnostics.push(Diagnostic::error(message).at((self.locate)(path)).remedy(remedy));
    }

    fn strip(&mut self, strip: &RawStrip, units: &Units) {
        let (length, pressure) = (units.length.factor(), units.pressure.factor());
        for (key, value, factor, greatest) in [
            ("length", strip.length, length, LONGEST),
            ("width", strip.width, length, LONGEST),
            ("height", strip.height, length, LONGEST),
            ("young", strip.young, pressure, HARDEST),
        ] {
            if !(value > 0.0 && value * factor <= greatest) {
                let message = format!("`{key}` of the strip is {value}, and must be a number above 0 that a strip has");
                self.add(&["strip", key], message, "check the value and `units:`");
            }
        }
        if strip.height > 0.2 * strip.length {
            let message = format!("the strip is {} high and {} long: no slender strip", strip.height, strip.length);
            self.add(&["strip", "height"], message, "beam theory holds for a height below a fifth of the length");
        }
        if let Some(yields) = strip.yields {
            if !(yields > 0.0 && yields < 0.1 * strip.young) {
                let message = format!("`yield` is {yields}, and must be above 0 and below a tenth of `young`");
                self.add(
                    &["strip", "yield"],
                    message,
                    "check the value and `units: {pressure: ..}`, which hold for both",
                );
            }
            if strip.theory == Theory::EulerBernoulli {
                let message = "a strip of `theory: euler-bernoulli` does not yield";
                self.add(&["strip", "yield"], message, "leave `theory` out, or `yield`");
            }
        }
        if let Some(hardening) = strip.hardening {
            if strip.yields.is_none() {
                self.add(&["strip", "hardening"], "`hardening`, and the strip does not yield", "give `yield`");
            } else if !(0.0..strip.young).contains(&hardening) {
                let message = format!("`hardening` is {hardening}, and must be from 0 to below `young`");
                self.add(&["strip", "hardening"], message, "give the tangent modulus beyond the yield stress");
            }
        }
        if !(0.0..=2.0).contains(&strip.friction) {
            let message = format!("`friction` is {}, and must be from 0 to 2", strip.friction);
            self.add(&["strip", "friction"], message, "leave it out for none");
        }
        if !within(&strip.clamp, length) {
            self.add(&["strip", "clamp"], "`clamp` is not finite, or too far", "give three coordinates");
        }
        let unit = |v: [f64; 3]| {
            let v = nalgebra::Vector3::from(v);
            (v.norm().is_finite() && v.norm() > 0.0).then(|| v.normalize())
        };
        let (along, push) = (unit(strip.along), unit(strip.push));
        let remedy = "give three components, not all 0";
        if along.is_none() {
            self.add(&["strip", "along"], "`along` is no direction", remedy);
        } else if push.is_none() {
            self.add(&["strip", "push"], "`push` is no direction", remedy);
        } else if along.zip(push).is_some_and(|(along, push)| along.dot(&push).abs() > 0.99) {
            self.add(&["strip", "push"], "`push` is parallel to `along`", "the tool pushes across the strip");
        }
    }
}

/// Coordinates that no robot reaches, and a strip softer than any solid.
fn doubtful_units(raw: &RawProcess, locate: Locate) -> Vec<Diagnostic> {
    let length = raw.units.length.factor();
    let mut diagnostics = Vec::new();
    let mut doubt = |path: &[&str], message: String, kind: &str, remedy: &str| {
        let remedy = format!("{kind}; if they are not, declare them: `units: {{{remedy}}}`");
        diagnostics.push(Diagnostic::warning(message).at(locate(path)).remedy(remedy));
    };
    let far = |at: &[f64; 3]| {
        let most = at.iter().fold(0.0, |most: f64, v| most.max((v * length).abs()));
        (FARTHEST..=GREATEST).contains(&most).then_some(most)
    };
    let lengths = format!("lengths here are in {}", raw.units.length.symbol());
    if let Some(strip) = &raw.strip {
        if let Some(most) = far(&strip.clamp) {
            doubt(&["strip", "clamp"], format!("`clamp` is {most:.0} m away"), &lengths, "length: mm");
        }
        let young = strip.young * raw.units.pressure.factor();
        if young > 0.0 && young < SOFTEST {
            let message = format!("`young` of the strip is {young} Pa, softer than any strip");
            let moduli = format!("moduli here are in {}", raw.units.pressure.symbol());
            doubt(&["strip", "young"], message, &moduli, "pressure: GPa");
        }
    }
    for (index, spring) in raw.springs.iter().enumerate() {
        if let Some(most) = far(&spring.at) {
            doubt(&["springs", &index.to_string(), "at"], format!("`at` is {most:.0} m away"), &lengths, "length: mm");
        }
    }
    diagnostics
}
