//! What `identify` finds, in the parameters of other conventions: sums of changes that the description declares, with the
//! covariance `J C J'`. Lengths in mm, angles in deg, everything else in SI.

use indexmap::IndexMap;
use nalgebra::DMatrix;
use serde::Serialize;

use super::units::unit;
use crate::description::robot::Combination;
use crate::estimation::Calibration;
use crate::math::quantiles::t95;
use crate::model::Model;

/// A sum of changes, in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CombinedParameter {
    /// Name of the sum in the convention.
    pub name: String,
    /// Unit of the value and its interval.
    pub unit: &'static str,
    /// Change from the description.
    pub value: f64,
    /// Half width of its 95 % interval; `None` where nothing of it was estimated.
    pub ci95: Option<f64>,
}

/// The parameters of a convention.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CombinedParameters {
    /// Name of the convention.
    pub convention: String,
    /// Its sums, in the order declared.
    pub parameters: Vec<CombinedParameter>,
    /// Between them, in their order; 0 where nothing was estimated.
    pub correlation: Vec<Vec<f64>>,
}

impl CombinedParameters {
    /// Of all conventions that a description declares and of which something was estimated.
    pub fn all(
        declared: &IndexMap<String, IndexMap<String, Combination>>,
        model: &Model,
        found: &Calibration,
    ) -> Vec<Self> {
        let kept: Vec<_> =
            found.identifiability.kept.iter().filter_map(|&column| found.estimates.get(column)).collect();
        let sigma = |k: usize| kept[k].sigma().unwrap_or(0.0);
        let covariance =
            DMatrix::from_fn(kept.len(), kept.len(), |i, j| found.correlation[(i, j)] * sigma(i) * sigma(j));
        let of = |(convention, sums): (&String, &IndexMap<String, Combination>)| {
            // Of a sum by the kept parameters; of one reported as its inverse, by the inverse.
            let jacobian = DMatrix::from_fn(sums.len(), kept.len(), |row, k| {
                let parameter = &model.registry[kept[k].slot];
                let factor = |of: &(String, f64)| if of.0 == parameter.name { of.1 } else { 0.0 };
                let by = if parameter.inverted { -1.0 / kept[k].value.powi(2) } else { 1.0 };
                by * sums[row].of.iter().map(factor).sum::<f64>()
            });
            let own = &jacobian * &covariance * jacobian.transpose();
            let deviation: Vec<f64> = (0..sums.len()).map(|k| own[(k, k)].max(0.0).sqrt()).collect();
            let parameter = |(row, (name, sum)): (usize, (&String, &Combination))| {
                let (unit, size) = unit(sum.kind);
                let members = (0..kept.len()).filter(|&k| jacobian[(row, k)] != 0.0);
                // The fewest of its members count: its own are hardly fewer.
                let freedom = members.filter_map(|k| kept[k].degrees_of_freedom).reduce(f64::min);
                CombinedParameter {
                    name: name.clone(),
                    unit,
                    value: sum.of.iter().map(|(name, factor)| factor * change(model, found, name)).sum::<f64>() / size,
                    ci95: freedom.map(|freedom| t95(freedom) * deviation[row] / size),
                }
            };
            let correlation = |i: usize, j: usize| match deviation[i] * deviation[j] {
                size if size > 0.0 => own[(i, j)] / size,
                _ => 0.0,
            };
            Self {
                convention: convention.clone(),
                parameters: sums.iter().enumerate().map(parameter).collect(),
                correlation: (0..sums.len()).map(|i| (0..sums.len()).map(|j| correlation(i, j)).collect()).collect(),
            }
        };
        let is_estimated = |set: &Self| set.parameters.iter().any(|sum| sum.ci95.is_some());
        declared.iter().map(of).filter(is_estimated).collect()
    }
}

/// Change of a parameter from the description, as it is reported; 0 of one that the model does not have.
fn change(model: &Model, found: &Calibration, name: &str) -> f64 {
    let Some(slot) = model.registry.slot(name) else { return 0.0 };
    let parameter = &model.registry[slot];
    if found.values[slot] == parameter.nominal {
        return 0.0;
    }
    parameter.shown(found.values[slot]) - parameter.shown(parameter.nominal)
}
