//! Parameters of the members of a subset with their intervals, fitted to first order with the nuisance, and as they are
//! written into a description.

use nalgebra::{DMatrix, DVector};

use super::hypothesis::Hypothesis;
use super::linear_problem::LinearProblem;
use super::result::CauseParameter;
use crate::description::raw::JointKind;
use crate::effects::{EffectEntry, SiteKind};
use crate::math::least_squares;
use crate::math::linear::cofactor;
use crate::math::quantiles::normal95;
use crate::model::Model;

/// A fitted parameter of a hypothesis, SI.
#[derive(Debug, Clone)]
pub struct FittedParameter {
    /// Name.
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
    /// Value; of a constant of the model: its change.
    pub value: f64,
    /// Half width of its 95 % interval.
    pub ci95: f64,
}

/// Nuisance and members fitted to all readings.
pub struct LinearFit<'a> {
    problem: &'a LinearProblem,
    members: &'a [usize],
    /// What the noise is at least, over the sigmas of the rows.
    pub noise: f64,
    /// Changes of the nuisance, then the parameters of each member, SI.
    pub x: DVector<f64>,
    /// Half widths of their 95 % intervals.
    half_widths: DVector<f64>,
    /// Their covariance, in units of the variance of a residual.
    cofactor: DMatrix<f64>,
}

impl<'a> LinearFit<'a> {
    /// Fits. The noise is that of the residuals, and at least `noise` times the sigmas of the rows.
    pub fn new(problem: &'a LinearProblem, members: &'a [usize], noise: f64) -> Self {
        let design = problem.design(members);
        let x = least_squares(&design, &problem.residual);
        let residual = &problem.residual - &design * &x;
        let freedom = (problem.rows() as f64 - design.ncols() as f64).max(1.0);
        let scale = (residual.norm_squared() / freedom).sqrt().max(noise);
        let cofactor = cofactor(&design);
        let half_widths = cofactor.diagonal().map(|v| normal95() * scale * v.max(0.0).sqrt());
        Self { problem, members, noise, x, half_widths, cofactor }
    }

    /// Where the parameters of a member are among all.
    fn place(&self, step: usize) -> std::ops::Range<usize> {
        let width = |member: usize| self.problem.hypotheses[member].columns.ncols();
        let before: usize = self.members[..step].iter().map(|&member| width(member)).sum();
        let first = self.problem.nuisance.ncols() + before;
        first..first + width(self.members[step])
    }

    /// Correlations of the parameters of a member.
    pub fn correlations(&self, step: usize) -> DMatrix<f64> {
        let place = self.place(step);
        let own = self.cofactor.view_range(place.clone(), place);
        let size = |k: usize| own[(k, k)].max(f64::MIN_POSITIVE).sqrt();
        DMatrix::from_fn(own.nrows(), own.ncols(), |i, j| own[(i, j)] / (size(i) * size(j)))
    }

    /// Parameters of a member.
    pub fn parameters(&self, step: usize) -> Vec<FittedParameter> {
        let first = self.place(step).start;
        let parameter = |(k, parameter): (usize, &crate::effects::EffectParameter)| FittedParameter {
            name: parameter.symbol.clone(),
            unit: parameter.unit,
            value: self.x[first + k],
            ci95: self.half_widths[first + k],
        };
        self.problem.hypotheses[self.members[step]].parameters.iter().enumerate().map(parameter).collect()
    }
}

/// The fitted parameters and the values of the nonlinear ones, as they are reported.
pub fn reported(model: &Model, hypothesis: &Hypothesis, fitted: &[FittedParameter]) -> Vec<CauseParameter> {
    let fitted = fitted.iter().map(|FittedParameter { name, unit, value, ci95 }| CauseParameter {
        name: name.clone(),
        unit,
        value: (*value).into(),
        ci95: Some(*ci95),
    });
    let nonlinear = hypothesis.nonlinear.written(&model.coordinate_names()).into_iter();
    let of = |unit: &'static str| of_joint(model, hypothesis, unit);
    fitted
        .chain(nonlinear.map(|(name, unit, value)| CauseParameter {
            name: name.into(),
            unit: of(unit),
            value,
            ci95: None,
        }))
        .collect()
}

/// The unit at the hypothesis' joint of what is an angle where that turns and a length where it slides: `rad or m`.
fn of_joint(model: &Model, hypothesis: &Hypothesis, unit: &'static str) -> &'static str {
    let site = &hypothesis.site;
    match unit.split_once(" or ") {
        Some((turns, slides)) if site.kind == SiteKind::Joint => match model.frames[site.frame].joint {
            JointKind::Prismatic => slides,
            _ => turns,
        },
        _ => unit,
    }
}

/// A hypothesis with its amounts, as it is switched on or written into a description.
pub fn entry(hypothesis: &Hypothesis, fitted: &[FittedParameter]) -> EffectEntry {
    EffectEntry {
        effect: hypothesis.effect.clone(),
        site: hypothesis.site.clone(),
        nonlinear: hypothesis.nonlinear.clone(),
        amounts: fitted.iter().map(|parameter| (parameter.name.clone(), parameter.value)).collect(),
    }
}
