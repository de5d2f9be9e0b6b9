//! Parameters of the members of a subset with their intervals, fitted to first order with the nuisance, and as they are
//! written into a description.

use indexmap::IndexMap;
use nalgebra::DVector;

use super::hypothesis::Hypothesis;
use super::linear_problem::LinearProblem;
use super::result::CauseParameter;
use crate::description::raw::RawEffect;
use crate::math::least_squares;
use crate::math::linear::cofactor;
use crate::math::quantiles::normal95;

/// Nuisance and members fitted to all readings.
pub struct LinearFit<'a> {
    problem: &'a LinearProblem,
    members: &'a [usize],
    /// Changes of the nuisance, then the parameters of each member, SI.
    pub x: DVector<f64>,
    /// Half widths of their 95 % intervals.
    half_widths: DVector<f64>,
}

impl<'a> LinearFit<'a> {
    /// Fits. The noise is that of the residuals, and at least `noise` times the sigmas of the rows.
    pub fn new(problem: &'a LinearProblem, members: &'a [usize], noise: f64) -> Self {
        let design = problem.design(members);
        let x = least_squares(&design, &problem.residual);
        let residual = &problem.residual - &design * &x;
        let freedom = (problem.rows() as f64 - design.ncols() as f64).max(1.0);
        let scale = (residual.norm_squared() / freedom).sqrt().max(noise);
        let half_widths = cofactor(&design).diagonal().map(|v| normal95() * scale * v.max(0.0).sqrt());
        Self { problem, members, x, half_widths }
    }

    /// Parameters of a member.
    pub fn parameters(&self, step: usize) -> Vec<CauseParameter> {
        let hypothesis = |member: usize| &self.problem.hypotheses[member];
        let before: usize = self.members[..step].iter().map(|&member| hypothesis(member).columns.ncols()).sum();
        let first = self.problem.nuisance.ncols() + before;
        let parameter = |(k, parameter): (usize, &crate::effects::EffectParameter)| CauseParameter {
            name: parameter.symbol.clone(),
            unit: parameter.unit,
            value: self.x[first + k],
            ci95: Some(self.half_widths[first + k]),
        };
        hypothesis(self.members[step]).parameters.iter().enumerate().map(parameter).collect()
    }
}

/// The parameters, and the nonlinear one of the hypothesis if there is any.
pub fn with_nonlinear(hypothesis: &Hypothesis, mut parameters: Vec<CauseParameter>) -> Vec<CauseParameter> {
    if !hypothesis.form.symbol.is_empty() {
        let (name, value) = (hypothesis.form.symbol.to_string(), hypothesis.form.value);
        parameters.push(CauseParameter { name, unit: "", value, ci95: None });
    }
    parameters
}

/// As it is written into a description.
pub fn entry(hypothesis: &Hypothesis, parameters: &[CauseParameter]) -> RawEffect {
    let mut all: IndexMap<String, f64> =
        parameters.iter().map(|parameter| (parameter.name.clone(), parameter.value)).collect();
    if !hypothesis.form.symbol.is_empty() {
        all.insert(hypothesis.form.symbol.into(), hypothesis.form.value);
    }
    RawEffect {
        effect: Some(hypothesis.effect.name().into()),
        site: Some(hypothesis.site.name.clone()),
        parameters: all,
    }
}
