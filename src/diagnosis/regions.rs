//! Where the gap lies in the campaign: regions of joint values, load and conditions in which errors are greatest, or in
//! which the robot is more compliant than its description. Limits are found as in a regression tree.
//!
//! Source: Breiman, Friedman, Olshen and Stone, *Classification and Regression Trees*, sec. 8.4.

use nalgebra::Vector3;

use super::result::{ExcessCompliance, Region};
use super::settings::LocationSettings;
use crate::description::campaign::Campaign;
use crate::math::mean_rms_max;
use crate::model::Model;

/// Contrasts that agree this well are equal but for rounding.
const TIE: f64 = 1e-9;

/// A quantity that limits a region.
struct Feature {
    name: String,
    unit: &'static str,
    /// Size of the unit, SI.
    size: f64,
    /// Value at each reading, SI.
    values: Vec<f64>,
}

/// One side of a limit.
struct Limit {
    feature: usize,
    /// SI.
    threshold: f64,
    is_below: bool,
}

impl Limit {
    /// As an inequality.
    fn text(&self, features: &[Feature]) -> String {
        let Feature { name, unit, size, .. } = &features[self.feature];
        let sign = if self.is_below { "<" } else { ">" };
        format!("{name} {sign} {:.3} {unit}", self.threshold / size).trim_end().to_string()
    }

    fn holds(&self, value: f64) -> bool {
        if self.is_below { value < self.threshold } else { value > self.threshold }
    }
}

/// Conditions, variables and load: a limit of the side of approach says more than one of a joint that divides alike.
fn features(model: &Model, campaign: &Campaign) -> Vec<Feature> {
    let count = campaign.readings.len();
    let mut features: Vec<Feature> = Vec::new();
    // What some readings lack divides none.
    let known = campaign.conditions.columns().filter(|(_, values)| values.iter().all(|value| value.is_finite()));
    for (condition, values) in known {
        let name = condition.column(|variable| model.variables[variable].name.as_str());
        features.push(Feature { name, unit: condition.unit(), size: 1.0, values: values.clone() });
    }
    for (k, variable) in model.variables.iter().enumerate() {
        let (unit, size) = if variable.is_angle { ("deg", 1f64.to_radians()) } else { ("mm", 1e-3) };
        let values = (0..count).map(|i| campaign.configuration(i)[k]).collect();
        features.push(Feature { name: variable.name.clone(), unit, size, values });
    }
    let force = |w: &[f64; 6]| (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]).sqrt();
    let values = campaign.readings.iter().map(|reading| force(&reading.wrench)).collect();
    features.push(Feature { name: "|f|".into(), unit: "N", size: 1.0, values });
    features
}

/// The limit, among those with enough readings on either side, for which `contrast` of the sums over the readings below
/// and above is greatest: how different they are, and whether those below are greater. Where limits of two features divide
/// the readings alike, that of the earlier one is taken.
fn best_limit(
    features: &[Feature],
    inside: &[usize],
    least: f64,
    sums: impl Fn(usize) -> [f64; 2],
    contrast: impl Fn(&[f64; 2], &[f64; 2]) -> Option<(f64, bool)>,
) -> Option<Limit> {
    let mut best: Option<(f64, Limit)> = None;
    let add = |a: &mut [f64; 2], b: [f64; 2], sign: f64| a.iter_mut().zip(b).for_each(|(a, b)| *a += sign * b);
    for (feature, Feature { values, .. }) in features.iter().enumerate() {
        let mut order: Vec<usize> = inside.to_vec();
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
        let mut total = [0.0; 2];
        order.iter().for_each(|&i| add(&mut total, sums(i), 1.0));
        let mut low = [0.0; 2];
        for (k, pair) in order.windows(2).enumerate() {
            add(&mut low, sums(pair[0]), 1.0);
            let is_narrow = ((k + 1) as f64) < least || ((order.len() - k - 1) as f64) < least;
            if is_narrow || values[pair[0]] == values[pair[1]] {
                continue;
            }
            let mut high = total;
            add(&mut high, low, -1.0);
            if let Some((contrast, is_below)) = contrast(&low, &high)
                && best.as_ref().is_none_or(|known| contrast > known.0 * (1.0 + TIE))
            {
                let threshold = 0.5 * (values[pair[0]] + values[pair[1]]);
                best = Some((contrast, Limit { feature, threshold, is_below }));
            }
        }
    }
    best.map(|(_, limit)| limit)
}

/// The regions (two limits together, then one) in which the error is greatest compared with elsewhere. `errors` are of all
/// readings, m.
pub fn regions(
    model: &Model,
    campaign: &Campaign,
    errors: &[Vector3<f64>],
    settings: &LocationSettings,
) -> Vec<Region> {
    let squares: Vec<f64> = errors.iter().map(Vector3::norm_squared).collect();
    let features = features(model, campaign);
    let mut is_inside = vec![true; errors.len()];
    let mut limits: Vec<Limit> = Vec::new();
    let mut found = Vec::new();
    for _ in 0..settings.limits {
        let inside: Vec<usize> = (0..errors.len()).filter(|&i| is_inside[i]).collect();
        if inside.len() < settings.least_readings {
            break;
        }
        // Reduction of the sum of squares about the means of either side.
        let contrast = |low: &[f64; 2], high: &[f64; 2]| {
            let (mean_low, mean_high) = (low[0] / low[1], high[0] / high[1]);
            Some((low[1] * high[1] * (mean_low - mean_high).powi(2), mean_low > mean_high))
        };
        let least = (settings.least_share * inside.len() as f64).max(settings.least_side);
        let Some(limit) = best_limit(&features, &inside, least, |i| [squares[i], 1.0], contrast) else { break };
        let values = &features[limit.feature].values;
        is_inside.iter_mut().zip(values).for_each(|(inside, &value)| *inside &= limit.holds(value));
        // A narrower limit on the same side replaces the wider one.
        limits.retain(|known| (known.feature, known.is_below) != (limit.feature, limit.is_below));
        limits.push(limit);
        let rms = |side: bool| {
            let chosen = squares.iter().zip(&is_inside).filter(|(_, inside)| **inside == side);
            mean_rms_max(chosen.map(|(square, _)| square.sqrt()))[1]
        };
        let when = limits.iter().map(|limit| limit.text(&features)).collect::<Vec<_>>().join(" and ");
        found.push(Region { when, rms: rms(true), elsewhere: rms(false) });
    }
    found.reverse();
    found
}

/// The region (one limit) in which measured deflections exceed predicted ones most, compared with elsewhere; `None` where
/// the campaign measures no deflections. `errors` are of all readings, m.
pub fn excess_compliance(
    model: &Model,
    campaign: &Campaign,
    errors: &[Vector3<f64>],
    settings: &LocationSettings,
) -> Option<ExcessCompliance> {
    if !campaign.is_difference() {
        return None;
    }
    // Error along the prediction, and the square of the prediction.
    let sums: Vec<[f64; 2]> = errors
        .iter()
        .zip(&campaign.readings)
        .map(|(error, reading)| {
            let predicted = Vector3::new(reading.measured[0], reading.measured[1], reading.measured[2]) - error;
            [error.dot(&predicted), predicted.norm_squared()]
        })
        .collect();
    let features = features(model, campaign);
    let all: Vec<usize> = (0..sums.len()).collect();
    let contrast = |low: &[f64; 2], high: &[f64; 2]| {
        let excess = [low, high].map(|side| side[0] / side[1]);
        let weight = low[1] * high[1] / (low[1] + high[1]);
        (low[1] > 0.0 && high[1] > 0.0).then(|| (weight * (excess[0] - excess[1]).powi(2), excess[0] > excess[1]))
    };
    let least = (settings.least_share * sums.len() as f64).max(settings.least_side);
    let limit = best_limit(&features, &all, least.floor(), |i| sums[i], contrast)?;
    let excess = |side: bool| {
        let is_on = |i: usize| limit.holds(features[limit.feature].values[i]) == side;
        let chosen = sums.iter().enumerate().filter(|(i, _)| is_on(*i));
        let total = chosen.fold([0.0; 2], |sum, (_, own)| [sum[0] + own[0], sum[1] + own[1]]);
        total[0] / total[1]
    };
    Some(ExcessCompliance { when: limit.text(&features), excess: excess(true), elsewhere: excess(false) })
}
