//! What the amounts of a cause mean on the machine: stiffnesses in words, and the curve of a free form.

use indexmap::IndexMap;
use nalgebra::{DMatrix, DVector};

use super::hypothesis::Hypothesis;
use super::linear_fit::FittedParameter;
use super::result::Curve;
use crate::effects::{Family, NonlinearValue};
use crate::math::{norm, orthonormal};
use crate::model::Model;

/// What the amounts imply, in words with figures.
pub fn implied(hypothesis: &Hypothesis, fitted: &[FittedParameter], values: &[f64]) -> Vec<String> {
    if hypothesis.family() != Family::Elastic || hypothesis.constants.len() != fitted.len() {
        return Vec::new();
    }
    let of = |(parameter, slot): (&FittedParameter, &usize)| {
        // What a cause changes adds to what the description has.
        let compliance = values.get(*slot).copied().unwrap_or_default() + parameter.value;
        let (size, unit) = match parameter.unit {
            "rad/(N.m)" => (1e-3 / compliance, "kN.m/rad"),
            "m/N" => (1e-6 / compliance, "N/um"),
            _ => return None,
        };
        (compliance > 0.0).then(|| format!("{}: a stiffness of {size:.3} {unit}", parameter.name))
    };
    fitted.iter().zip(&hypothesis.constants).filter_map(of).collect()
}

/// A curve is shown without its straight line where its band is then at most this part of the whole one. A judgement: the shape is known ten times
/// as well as the line.
const OF_LINE: f64 = 0.1;

/// The curve of a free form at a joint or the instrument; `None` of anything else. Where constants that are calibrated can stand for a straight
/// line, its amounts are known together with these only: the curve is then shown without its line. `correlations` are those of `fitted`.
pub fn curve(
    model: &Model,
    hypothesis: &Hypothesis,
    fitted: &[FittedParameter],
    correlations: &DMatrix<f64>,
) -> Option<Curve> {
    let whole = curve_of(model, hypothesis, fitted, "k")?;
    let count = whole.at.len();
    let own = |k: usize| fitted.iter().position(|parameter| parameter.name == format!("k{}", k + 1));
    // Of an amount that was left out nothing is uncertain.
    let known: Vec<Option<usize>> = (0..count).map(own).collect();
    let amount = DVector::from_fn(count, |k, _| known[k].map_or(0.0, |at| fitted[at].value));
    let covariance = DMatrix::from_fn(count, count, |i, j| match (known[i], known[j]) {
        (Some(i), Some(j)) => correlations.get((i, j)).copied().unwrap_or_default() * fitted[i].ci95 * fitted[j].ci95,
        _ => 0.0,
    });
    let middle = whole.at.iter().sum::<f64>() / count as f64;
    let line = orthonormal(
        &DMatrix::from_fn(count, 2, |k, column| if column == 0 { 1.0 } else { whole.at[k] - middle }),
        None,
    );
    let without = DMatrix::identity(count, count) - &line * line.transpose();
    let shape = &without * covariance * &without;
    let band: Vec<f64> = shape.diagonal().iter().map(|variance| variance.max(0.0).sqrt()).collect();
    if norm(&band) > OF_LINE * norm(&whole.band) {
        return Some(whole);
    }
    let amount = (without * amount).iter().copied().collect();
    Some(Curve { amount, band, is_without_line: true, ..whole })
}

/// The curves of a free form at the base or the tool, by component.
pub fn curves(model: &Model, hypothesis: &Hypothesis, fitted: &[FittedParameter]) -> IndexMap<String, Curve> {
    let of = |component: &str| Some((component.to_string(), curve_of(model, hypothesis, fitted, component)?));
    ["x", "y", "z", "rx", "ry", "rz"].into_iter().filter_map(of).collect()
}

/// The curve of the amounts of one symbol, numbered by their knots.
fn curve_of(model: &Model, hypothesis: &Hypothesis, fitted: &[FittedParameter], symbol: &str) -> Option<Curve> {
    let values = hypothesis.nonlinear.values();
    let [NonlinearValue::Driver(driver), NonlinearValue::Knots(at)] = &values[..] else { return None };
    let amount = |k: usize| fitted.iter().find(|parameter| parameter.name == format!("{symbol}{k}"));
    let known = || (1..=at.len()).filter_map(amount);
    let amount_unit = known().next()?.unit;
    let of = |value: fn(&FittedParameter) -> f64| (1..=at.len()).map(move |k| amount(k).map_or(0.0, value));
    let (mut amounts, mut band): (Vec<f64>, Vec<f64>) = (of(|own| own.value).collect(), of(|own| own.ci95).collect());
    // An amount that was left out is a constant which is calibrated anyway.
    if known().count() < at.len() {
        let mean = amounts.iter().sum::<f64>() / amounts.len() as f64;
        amounts.iter_mut().for_each(|amount| *amount -= mean);
        // It is known no better than the others.
        let widest = band.iter().copied().fold(0.0, f64::max);
        band.iter_mut().zip(1..).filter(|(_, k)| amount(*k).is_none()).for_each(|(own, _)| *own = widest);
    }
    let unit = model.unit_of(*driver);
    Some(Curve { at: at.to_vec(), amount: amounts, band, unit, amount_unit, is_without_line: false })
}
