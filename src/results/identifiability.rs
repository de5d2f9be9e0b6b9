//! What `identifiability` and `sensitivity` find. Factors of combinations in SI (m, rad).

use indexmap::IndexMap;
use serde::{Serialize, Serializer};

use super::own_weight::OwnWeight;
use super::units::unit;
use crate::description::campaign::Campaign;
use crate::identifiability::{Identifiability, Sensitivity, Why};
use crate::model::Model;
use crate::parameter::Slot;

/// A parameter into which a dropped one is merged.
#[derive(Debug, Clone, PartialEq)]
pub struct Merged {
    /// The kept parameter.
    pub keeper: String,
    /// Its change by one unit of the dropped one, each in the unit of its kind.
    pub factor: f64,
    /// Unit of the factor; empty for a pure number.
    pub unit: String,
}

/// A parameter that is not estimated.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Dropped {
    /// Name of the parameter.
    pub name: String,
    /// Why it was dropped.
    pub why: Why,
    /// What is left of its scaled column after those of the kept parameters.
    #[serde(skip)]
    pub remainder: f64,
    /// Where its effect went, the greatest factor (SI) first.
    #[serde(skip)]
    pub merged: Vec<Merged>,
}

/// Observability indices of Sun and Hollerbach.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "UPPERCASE")]
pub struct Observability {
    /// O1: geometric mean of the singular values over the root of the number of rows.
    pub o1: f64,
    /// O2: least over greatest singular value.
    pub o2: f64,
    /// O3: least singular value.
    pub o3: f64,
    /// O4: least singular value squared over the greatest.
    pub o4: f64,
    /// O5: inverse of the sum of the inverse singular values.
    pub o5: f64,
}

/// Which parameters the readings of a campaign determine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reduction {
    /// Candidates.
    pub columns: usize,
    /// Exact rank.
    pub rank: usize,
    /// Parameters kept.
    pub kept: usize,
    /// Relative tolerance below which singular values count as zero; `None`: the noise decides.
    #[serde(serialize_with = "tolerance_or_noise")]
    pub tolerance: Option<f64>,
    /// Parameters that are not estimated, and why.
    pub dropped: Vec<Dropped>,
    /// By kept parameter: what is merged into it, with its factor (SI).
    pub combinations: IndexMap<String, IndexMap<String, f64>>,
    /// Condition number of the scaled columns that are kept; `None` where none is.
    pub condition: Option<f64>,
    /// Observability indices of the scaled columns that are kept; `None` where none is.
    pub observability: Option<Observability>,
    /// Of the scaled observation matrix.
    pub singular_values: Vec<f64>,
    /// Names of the kept parameters.
    pub kept_parameters: Vec<String>,
    /// Whether the readings are predicted with own weight; `None` within a result that says so itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own_weight: Option<OwnWeight>,
}

fn tolerance_or_noise<S: Serializer>(tolerance: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    match tolerance {
        Some(tolerance) => serializer.serialize_f64(*tolerance),
        None => serializer.serialize_str("noise"),
    }
}

impl Reduction {
    /// What the reduction of the columns `slots` found.
    pub fn new(model: &Model, slots: &[Slot], found: &Identifiability) -> Self {
        let name = |column: usize| model.registry[slots[column]].name.clone();
        let of = |terms: &[(usize, f64)]| terms.iter().map(|&(column, factor)| (name(column), factor)).collect();
        let dropped = |&(column, why): &(usize, Why)| Dropped {
            name: name(column),
            why,
            remainder: found.remainder[column],
            merged: merged(model, slots, found, column),
        };
        Self {
            columns: found.columns,
            rank: found.rank,
            kept: found.kept.len(),
            tolerance: found.tolerance,
            dropped: found.dropped.iter().map(dropped).collect(),
            combinations: found.combinations.iter().map(|(keeper, terms)| (name(*keeper), of(terms))).collect(),
            condition: found.condition,
            observability: found.observability.map(|[o1, o2, o3, o4, o5]| Observability { o1, o2, o3, o4, o5 }),
            singular_values: found.singular_values.clone(),
            kept_parameters: found.kept.iter().map(|&column| name(column)).collect(),
            own_weight: None,
        }
    }
}

fn merged(model: &Model, slots: &[Slot], found: &Identifiability, column: usize) -> Vec<Merged> {
    let mut terms: Vec<(usize, f64)> = found
        .combinations
        .iter()
        .flat_map(|(keeper, terms)| terms.iter().filter(|term| term.0 == column).map(|term| (*keeper, term.1)))
        .collect();
    terms.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    let unit_of = |column: usize| unit(model.registry[slots[column]].kind);
    let (from, from_size) = unit_of(column);
    let merged = |(keeper, factor): (usize, f64)| {
        let (to, to_size) = unit_of(keeper);
        Merged {
            keeper: model.registry[slots[keeper]].name.clone(),
            factor: factor * from_size / to_size,
            unit: if to == from { String::new() } else { format!("{to}/{from}") },
        }
    };
    terms.into_iter().map(merged).collect()
}

/// Mean and greatest over the configurations.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MeanMax {
    /// Mean.
    pub mean: f64,
    /// Greatest.
    pub max: f64,
}

/// How much a parameter moves the tool centre point.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParameterSensitivity {
    /// Name of the parameter.
    pub name: String,
    /// Position, m per m or rad.
    #[serde(rename = "mu_P")]
    pub position: MeanMax,
    /// Orientation, rad per m or rad.
    #[serde(rename = "mu_Phi")]
    pub orientation: MeanMax,
    /// Unit of the parameter in text, and its size in SI.
    #[serde(skip)]
    pub per: (&'static str, f64),
}

/// What `sensitivity` finds, SI.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sensitivities {
    /// Unit of the sensitivities in `parameters`.
    pub unit: &'static str,
    /// Free geometric parameters.
    pub parameters: Vec<ParameterSensitivity>,
    /// Springs, sections and masses under the campaign's loads, m or rad per SI unit of each.
    pub elastic: Vec<ElasticSensitivity>,
    /// Whether the loads hold own weight.
    pub own_weight: OwnWeight,
}

/// What an elastic parameter does to the tool's deflection, SI.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ElasticSensitivity {
    /// Name of the parameter.
    pub name: String,
    /// Unit of the value.
    pub unit: &'static str,
    /// Value of the description.
    pub value: f64,
    /// Position, m per SI unit.
    #[serde(rename = "mu_P")]
    pub position: MeanMax,
    /// Orientation, rad per SI unit.
    #[serde(rename = "mu_Phi")]
    pub orientation: MeanMax,
    /// Position by the whole value, m: of a compliance what it makes of the deflection.
    #[serde(rename = "mu_P_of_value")]
    pub of_value: MeanMax,
    /// Orientation by the whole value, rad.
    #[serde(rename = "mu_Phi_of_value")]
    pub turn_of_value: MeanMax,
}

impl Sensitivities {
    /// Of geometric and of elastic parameters, with the names of a model.
    pub fn new(model: &Model, campaign: &Campaign, found: &[Sensitivity], elastic: &[Sensitivity]) -> Self {
        let pair = |[mean, max]: [f64; 2]| MeanMax { mean, max };
        let of_elastic = |s: &Sensitivity| {
            let parameter = &model.registry[s.slot];
            let whole = parameter.nominal.abs();
            ElasticSensitivity {
                name: parameter.name.clone(),
                unit: parameter.kind.unit(),
                value: parameter.nominal,
                position: pair(s.position),
                orientation: pair(s.orientation),
                of_value: pair(s.position.map(|mu| mu * whole)),
                turn_of_value: pair(s.orientation.map(|mu| mu * whole)),
            }
        };
        let one = |s: &Sensitivity| ParameterSensitivity {
            name: model.registry[s.slot].name.clone(),
            position: pair(s.position),
            orientation: pair(s.orientation),
            per: unit(model.registry[s.slot].kind),
        };
        Self {
            unit: "m or rad per m or rad",
            parameters: found.iter().map(one).collect(),
            elastic: elastic.iter().map(of_elastic).collect(),
            own_weight: OwnWeight::of_campaign(model, &model.registry.nominal(), campaign),
        }
    }
}
