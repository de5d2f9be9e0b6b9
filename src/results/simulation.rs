//! What `simulate` makes: a campaign with known truth. SI.

use indexmap::IndexMap;
use serde::Serialize;

use super::StripAt;
use super::own_weight::OwnWeight;
use crate::description::raw::RawEffect;
use crate::model::Model;

/// A parameter that is not as described, SI.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TrueParameter {
    /// Value of the description.
    pub nominal: f64,
    /// Value with which the readings were made.
    #[serde(rename = "true")]
    pub truth: f64,
}

/// What the readings were made with.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Truth {
    /// Seed of all that was drawn.
    pub seed: u64,
    /// Units of lengths and angles.
    pub unit: &'static str,
    /// Parameters that differ from the description, by name.
    pub parameters: IndexMap<String, TrueParameter>,
    /// Effects that were switched on, with their amounts.
    pub effects: Vec<RawEffect>,
}

impl Truth {
    /// The parameters of a model that differ from their nominal values, and its effects.
    pub fn new(model: &Model, values: &[f64], seed: u64) -> Self {
        let all = model.registry.all().iter().zip(values).filter(|(parameter, value)| parameter.nominal != **value);
        let truth = |(parameter, value): (&crate::parameter::Parameter, &f64)| {
            (parameter.name.clone(), TrueParameter { nominal: parameter.nominal, truth: *value })
        };
        let effects = model.effects.iter().map(|effect| effect.entry.raw(model)).collect();
        Self { seed, unit: "m, rad", parameters: all.map(truth).collect(), effects }
    }
}

/// A point of a path carried out in equilibrium with a process.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PathPoint {
    /// Position in the path, from 0.
    pub index: usize,
    /// Name of the point.
    pub name: String,
    /// Where the tool is, less where it should be, m.
    pub missed: [f64; 3],
    /// N and N.m.
    pub wrench: [f64; 6],
    /// With a strip that can yield, where the tool touches it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strip: Option<StripAt>,
}

/// What `simulate` makes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Simulation {
    /// The campaign's file.
    pub campaign: String,
    /// Number of readings.
    pub readings: usize,
    /// Whether the readings hold the deflection by own weight.
    pub own_weight: OwnWeight,
    /// What they were made with.
    pub truth: Truth,
    /// Of a path with a process.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<Vec<PathPoint>>,
}
