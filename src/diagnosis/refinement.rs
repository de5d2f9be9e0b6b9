//! Second pass over continuous nonlinear parameters: values between those offered at first.

use nalgebra::DMatrix;

use super::inputs::Inputs;
use super::linear_problem::LinearProblem;
use crate::effects::Form;
use crate::math::{orthonormal, project_off};
use crate::prediction::{PredictionError, Term, effect_columns};

/// Refines the nonlinear parameters of the members in place, fitted to the readings that are not `unused`. Whether there
/// was any.
///
/// # Errors
/// A configuration that cannot be assembled.
pub fn refine(
    inputs: &Inputs,
    values: &[f64],
    problem: &mut LinearProblem,
    members: &[usize],
    unused: &[bool],
) -> Result<bool, PredictionError> {
    let settings = &inputs.settings.selection;
    let continuous: Vec<usize> = members.iter().copied().filter(|&h| problem.hypotheses[h].form.continuous).collect();
    let rows: Vec<usize> = (0..problem.rows()).filter(|&row| !unused[problem.reading[row]]).collect();
    let residual = problem.residual.select_rows(&rows);
    for &h in &continuous {
        let hypothesis = &problem.hypotheses[h];
        let steps = -settings.refinements..=settings.refinements;
        let value = |k: i32| hypothesis.form.value * settings.refinement_ratio.powi(k);
        let forms: Vec<Form> = steps.map(|k| Form { value: value(k), ..hypothesis.form }).collect();
        let term = |form: &Form| Term::new(inputs.model, hypothesis.effect, hypothesis.site.clone(), *form);
        let terms = forms.iter().map(term).collect();
        let (all, width) = effect_columns(inputs.model, inputs.campaign, values, terms)?;
        let count = hypothesis.parameters.len();
        let mut best: Option<(f64, Form, DMatrix<f64>)> = None;
        for (k, form) in forms.into_iter().enumerate() {
            let columns = DMatrix::from_fn(problem.rows(), count, |row, c| {
                all[row * width + k * count + c] / problem.sigmas[row]
            });
            problem.hypotheses[h].columns = columns.clone();
            let span = orthonormal(&problem.design(members).select_rows(&rows), None);
            let squares = project_off(&residual, &span).norm_squared();
            if best.as_ref().is_none_or(|known| squares < known.0) {
                best = Some((squares, form, columns));
            }
        }
        if let Some((_, form, columns)) = best {
            problem.hypotheses[h].form = form;
            problem.hypotheses[h].columns = columns;
        }
    }
    Ok(!continuous.is_empty())
}
