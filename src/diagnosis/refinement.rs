//! Second pass over continuous nonlinear parameters: values between those offered at first.

use nalgebra::DMatrix;

use super::inputs::Inputs;
use super::linear_problem::LinearProblem;
use crate::effects::{Nonlinear, Survey};
use crate::math::{orthonormal, project_off};
use crate::prediction::{PredictionError, Term, effect_columns};

/// Refines the nonlinear parameters of the members in place, to what readings that span so much tell, fitted to all but the readings that
/// are `unused`. Whether there was any.
///
/// # Errors
/// A configuration that cannot be assembled.
pub fn refine(
    inputs: &Inputs,
    values: &[f64],
    survey: &Survey,
    problem: &mut LinearProblem,
    members: &[usize],
    unused: &[bool],
) -> Result<bool, PredictionError> {
    let settings = &inputs.settings.selection;
    let center = |problem: &LinearProblem, h: usize| problem.hypotheses[h].nonlinear.continuous();
    let continuous: Vec<(usize, f64)> = members.iter().filter_map(|&h| Some((h, center(problem, h)?))).collect();
    let rows: Vec<usize> = (0..problem.rows()).filter(|&row| unused.get(problem.reading[row]) != Some(&true)).collect();
    let residual = problem.residual.select_rows(&rows);
    let squares = |problem: &LinearProblem| {
        let span = orthonormal(&problem.design(members).select_rows(&rows), None);
        project_off(&residual, &span).norm_squared()
    };
    for &(h, center) in &continuous {
        let steps = -settings.refinements..=settings.refinements;
        let (mut ratio, mut best) = (settings.refinement_ratio, (f64::INFINITY, center));
        let mut values_tried: Vec<f64> = steps.map(|k| center * ratio.powi(k)).collect();
        // The squares are chi-square: a value is found when those beside it are worse by less than they tell of it.
        loop {
            let (before, mut worst) = (best.0, best.0);
            for (own, columns) in columns_of(inputs, values, survey, problem, h, &values_tried)? {
                let value = own.continuous().unwrap_or(center);
                let (known, stood) = (std::mem::replace(&mut problem.hypotheses[h].nonlinear, own), columns);
                let columns = std::mem::replace(&mut problem.hypotheses[h].columns, stood);
                let left = squares(problem);
                worst = worst.max(left);
                if left < best.0 {
                    best = (left, value);
                } else {
                    problem.hypotheses[h].nonlinear = known;
                    problem.hypotheses[h].columns = columns;
                }
            }
            ratio = ratio.sqrt();
            let is_known = before.is_finite() && worst - best.0 < settings.refined;
            if !best.0.is_finite() || is_known || ratio - 1.0 < FINEST {
                break;
            }
            values_tried = vec![best.1 / ratio, best.1 * ratio];
        }
    }
    Ok(!continuous.is_empty())
}

/// Relative distance of neighbouring values below which nothing is refined further, whatever the readings tell.
const FINEST: f64 = 1e-4;

/// A hypothesis with these values of its continuous nonlinear parameter, as far as they can be told from others, and its columns. The first
/// of those that it has now is always among them.
fn columns_of(
    inputs: &Inputs,
    values: &[f64],
    survey: &Survey,
    problem: &LinearProblem,
    h: usize,
    tried: &[f64],
) -> Result<Vec<(Nonlinear, DMatrix<f64>)>, PredictionError> {
    let hypothesis = &problem.hypotheses[h];
    let (effect, site, now) = (&hypothesis.effect, &hypothesis.site, hypothesis.nonlinear.continuous());
    let of = |&value: &f64| hypothesis.nonlinear.clone().with_continuous(value);
    let is_identifiable = |own: &Nonlinear| own.continuous() == now || effect.is_identifiable(site, survey, own);
    let tried: Vec<Nonlinear> = tried.iter().map(of).filter(is_identifiable).collect();
    let terms = tried.iter().map(|own| Term::new(inputs.model, effect, site, own)).collect();
    let (all, width) = effect_columns(inputs.model, inputs.campaign, values, terms)?;
    let count = hypothesis.parameters.len();
    let columns = |k: usize| {
        DMatrix::from_fn(problem.rows(), count, |row, c| all[row * width + k * count + c] / problem.sigmas[row])
    };
    Ok(tried.into_iter().enumerate().map(|(k, own)| (own, columns(k))).collect())
}
