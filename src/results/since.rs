//! What `identify --since` finds: which parameters have moved since an earlier description. Lengths in mm, angles in deg,
//! stiffnesses in SI.

use serde::Serialize;

use super::units::unit;
use crate::estimation::{Change, LEVEL};
use crate::model::Model;
use crate::parameter::{Parameter, Slot};

/// The change of a parameter, in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MovedParameter {
    /// Name of the parameter.
    pub name: String,
    /// Unit of the values, of their difference, of its deviation and interval.
    pub unit: &'static str,
    /// Value of the earlier description.
    pub before: f64,
    /// Value as estimated now.
    pub now: f64,
    /// Now less before.
    pub difference: f64,
    /// Standard deviation of the difference.
    pub sigma: f64,
    /// Half width of its 95 % interval.
    pub ci95: f64,
    /// Whether the earlier description states an uncertainty, which is in `sigma`.
    pub both: bool,
    /// The difference in standard deviations; `None` where readings without noise leave no deviation.
    pub z: Option<f64>,
    /// Probability of a difference as great by chance, all parameters considered (Holm).
    pub p: f64,
    /// Whether `p` is below 5 %.
    pub moved: bool,
}

impl MovedParameter {
    /// With the name and unit of a parameter.
    pub fn new(parameter: &Parameter, change: &Change) -> Self {
        let (unit, size) = unit(parameter.shown_kind());
        let [before, now] = [change.before, change.now].map(|value| parameter.shown(value) / size);
        Self {
            name: parameter.name.clone(),
            unit,
            before,
            now,
            difference: now - before,
            sigma: parameter.shown_width(change.now, change.sigma) / size,
            ci95: parameter.shown_width(change.now, change.ci95) / size,
            both: change.both,
            z: change.z(),
            p: change.p,
            moved: change.moved(),
        }
    }
}

/// What has moved.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Since {
    /// The earlier description.
    pub description: String,
    /// Probability with which anything is said to have moved although nothing has.
    pub level: f64,
    /// Names of what has moved.
    pub moved: Vec<String>,
    /// All parameters compared.
    pub parameters: Vec<MovedParameter>,
    /// Names of parameters estimated of which the earlier description states nothing.
    pub not_compared: Vec<String>,
}

impl Since {
    /// With the names and units of a model.
    pub fn new(description: &str, model: &Model, changes: &[Change], not_stated: &[Slot]) -> Self {
        let parameter = |change: &Change| MovedParameter::new(&model.registry[change.slot], change);
        let parameters: Vec<MovedParameter> = changes.iter().map(parameter).collect();
        let moved = parameters.iter().filter(|parameter| parameter.moved).map(|parameter| parameter.name.clone());
        Self {
            description: description.into(),
            level: LEVEL,
            moved: moved.collect(),
            parameters,
            not_compared: not_stated.iter().map(|&slot| model.registry[slot].name.clone()).collect(),
        }
    }
}
