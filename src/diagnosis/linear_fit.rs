//! Parameters of the members of a subset with their intervals, fitted to first order with the nuisance, and as they are
//! written into a description.

use nalgebra::{DMatrix, DVector};

use super::hypothesis::Hypothesis;
use super::linear_problem::LinearProblem;
use super::result::CauseParameter;
use crate::description::raw::{JointKind, RawAmount};
use crate::effects::{EffectEntry, SiteKind};
use crate::math::linear::{cofactor, tr_mul};
use crate::math::quantiles::normal95;
use crate::math::{joined, least_squares, orthonormal, project_off};
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

/// A free curve in what the members leave, which nothing explains.
#[derive(Debug, Clone, Copy)]
pub struct Structure {
    /// Its hypothesis.
    pub curve: usize,
    /// The weighted squares that it takes away, less those of noise.
    pub squares: f64,
    /// Whether it is no chance.
    pub is_certain: bool,
}

/// Nuisance and members fitted to all readings.
pub struct LinearFit<'a> {
    problem: &'a LinearProblem,
    /// The members, in the order in which they entered.
    pub members: &'a [usize],
    /// What the noise is at least, over the sigmas of the rows.
    pub noise: f64,
    /// What is left that is no noise.
    pub structures: Vec<Structure>,
    /// Changes of the nuisance, then the parameters of each member, SI.
    pub x: DVector<f64>,
    /// Half widths of their 95 % intervals.
    half_widths: DVector<f64>,
    /// Of each member: how the readings change with its continuous nonlinear parameter, by relative change of that, where they tell it.
    slopes: Vec<Option<DVector<f64>>>,
    /// Of each of these: half width of the 95 % interval of the relative change.
    of_slopes: Vec<Option<f64>>,
    /// Their covariance, in units of the variance of a residual.
    cofactor: DMatrix<f64>,
}

impl<'a> LinearFit<'a> {
    /// Fits. The noise is that of the residuals, and at least `noise` times the sigmas of the rows. Of a curve that is left only the part shows
    /// that the members do not take up. The other part is assumed to be as great, and biases the amounts in whose direction it lies (the bias of
    /// an omitted variable).
    /// `slopes` are, of each member, how the readings change with its continuous nonlinear parameter, which is fitted too.
    pub fn new(
        problem: &'a LinearProblem,
        members: &'a [usize],
        noise: f64,
        structures: Vec<Structure>,
        slopes: Vec<Option<DVector<f64>>>,
    ) -> Self {
        let own = problem.design(members);
        let x = least_squares(&own, &problem.residual);
        let is_distinct = distinct_columns(&own, &slopes);
        let slopes: Vec<Option<DVector<f64>>> =
            slopes.into_iter().zip(is_distinct).map(|(slope, is_distinct)| slope.filter(|_| is_distinct)).collect();
        let design = slopes.iter().flatten().fold(own, |all, slope| {
            let at = all.ncols();
            let mut all = all.insert_column(at, 0.0);
            all.set_column(at, slope);
            all
        });
        let residual = &problem.residual - design.columns(0, x.len()) * &x;
        let freedom = (problem.rows() as f64 - design.ncols() as f64).max(1.0);
        let scale = (residual.norm_squared() / freedom).sqrt().max(noise);
        let cofactor = cofactor(&design);
        let mut half_widths = cofactor.diagonal().map(|v| normal95() * scale * v.max(0.0).sqrt());
        if !structures.is_empty() {
            let first = problem.nuisance.ncols();
            // Of each amount the row of the pseudo-inverse: its length is the standard error for noise of one sigma.
            let determined_by = &design * cofactor.columns(first, x.len() - first);
            let nuisance = orthonormal(&problem.nuisance, None);
            let mut by_shape = vec![0.0_f64; determined_by.ncols()];
            for Structure { curve, squares, .. } in &structures {
                let shape = orthonormal(&problem.hypotheses[*curve].columns, Some(&nuisance));
                for (by, direction) in by_shape.iter_mut().zip(tr_mul(&shape, &determined_by).column_iter()) {
                    *by = by.max(squares.sqrt() * direction.norm());
                }
            }
            for (k, by) in by_shape.into_iter().enumerate() {
                half_widths[first + k] = half_widths[first + k].hypot(normal95() * by);
            }
        }
        let mut widths = half_widths.iter().skip(x.len());
        let of_slopes = slopes.iter().map(|slope| slope.as_ref().and_then(|_| widths.next().copied())).collect();
        Self { problem, members, noise, structures, x, half_widths, slopes, of_slopes, cofactor }
    }

    /// The fit of some of the members alone, in their order.
    pub fn of<'b>(&self, members: &'b [usize]) -> LinearFit<'b>
    where
        'a: 'b,
    {
        let slope = |member: &usize| {
            let at = self.members.iter().position(|own| own == member)?;
            self.slopes.get(at).cloned().flatten()
        };
        LinearFit::new(self.problem, members, self.noise, self.structures.clone(), members.iter().map(slope).collect())
    }

    /// Half width of the 95 % interval of a member's continuous nonlinear parameter; `None` where it has none, or the readings do not tell it.
    pub fn width_of_nonlinear(&self, step: usize) -> Option<f64> {
        let value = self.problem.hypotheses[self.members[step]].nonlinear.continuous()?;
        self.of_slopes.get(step).copied().flatten().map(|width| width * value.abs())
    }

    /// Where the parameters of a member are among all.
    fn place(&self, step: usize) -> std::ops::Range<usize> {
        let width = |member: usize| self.problem.hypotheses[member].columns.ncols();
        let before: usize = self.members[..step].iter().map(|&member| width(member)).sum();
        let first = self.problem.nuisance.ncols() + before;
        first..first + width(self.members[step])
    }

    /// What a member adds to the weighted readings.
    pub fn contribution(&self, step: usize) -> DVector<f64> {
        let place = self.place(step);
        &self.problem.hypotheses[self.members[step]].columns * self.x.rows(place.start, place.len())
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

/// Share of its size that a column must have beyond all others to be told from them: a parameter below it has no interval.
const DISTINCT: f64 = 1e-3;

/// Which columns the readings tell from those of a design, and from those before them.
fn distinct_columns(design: &DMatrix<f64>, slopes: &[Option<DVector<f64>>]) -> Vec<bool> {
    if slopes.iter().all(Option::is_none) {
        return vec![false; slopes.len()];
    }
    let mut basis = orthonormal(design, None);
    let mut is_distinct = |slope: &DVector<f64>| {
        let beyond = project_off(slope, &basis);
        let is_distinct = beyond.norm() > DISTINCT * slope.norm();
        if is_distinct {
            basis = joined(&basis, &DMatrix::from_columns(&[beyond.normalize()]));
        }
        is_distinct
    };
    slopes.iter().map(|slope| slope.as_ref().is_some_and(&mut is_distinct)).collect()
}

/// The fitted parameters and the values of the nonlinear ones, as they are reported; `width` is the half width of the interval of the one that is
/// continuous.
pub fn reported(
    model: &Model,
    hypothesis: &Hypothesis,
    fitted: &[FittedParameter],
    width: Option<f64>,
) -> Vec<CauseParameter> {
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
            ci95:
                width.filter(|_| hypothesis.nonlinear.continuous().is_some_and(|own| value == RawAmount::Number(own))),
            value,
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
