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
    for &(h, center) in &continuous {
        let hypothesis = &problem.hypotheses[h];
        let steps = -settings.refinements..=settings.refinements;
        let value = |k: i32| center * settings.refinement_ratio.powi(k);
        let (effect, site) = (&hypothesis.effect, &hypothesis.site);
        let of = |k: i32| (k, hypothesis.nonlinear.clone().with_continuous(value(k)));
        let is_identifiable =
            |(k, nonlinear): &(i32, Nonlinear)| *k == 0 || effect.is_identifiable(site, survey, nonlinear);
        let tried: Vec<Nonlinear> = steps.map(of).filter(is_identifiable).map(|(_, nonlinear)| nonlinear).collect();
        let term = |own: &Nonlinear| Term::new(inputs.model, &hypothesis.effect, &hypothesis.site, own);
        let terms = tried.iter().map(term).collect();
        let (all, width) = effect_columns(inputs.model, inputs.campaign, values, terms)?;
        let count = hypothesis.parameters.len();
        let mut best: Option<(f64, Nonlinear, DMatrix<f64>)> = None;
        for (k, nonlinear) in tried.into_iter().enumerate() {
            let columns = DMatrix::from_fn(problem.rows(), count, |row, c| {
                all[row * width + k * count + c] / problem.sigmas[row]
            });
            problem.hypotheses[h].columns = columns.clone();
            let span = orthonormal(&problem.design(members).select_rows(&rows), None);
            let squares = project_off(&residual, &span).norm_squared();
            if best.as_ref().is_none_or(|known| squares < known.0) {
                best = Some((squares, nonlinear, columns));
            }
        }
        if let Some((_, nonlinear, columns)) = best {
            problem.hypotheses[h].nonlinear = nonlinear;
            problem.hypotheses[h].columns = columns;
        }
    }
    Ok(!continuous.is_empty())
}
