//! Parameters of what was found, with their intervals, and as they are written into a description.

use nalgebra::{DMatrix, DVector};

use super::algebra::solve;
use super::evidence::{Evidence, Hypothesis};
use super::figures::design;
use super::report::CauseParameter;
use crate::effects::EffectEntry;

/// Nuisance and members fitted to all readings.
pub struct Fit {
    pub x: DVector<f64>,
    widths: DVector<f64>,
    nuisance: usize,
}

impl Fit {
    pub fn of(evidence: &Evidence, members: &[usize], noise: f64) -> Self {
        let design = design(evidence, members);
        let x = solve(&design, &evidence.residual);
        let left = &evidence.residual - &design * &x;
        let freedom = (evidence.rows() as f64 - design.ncols() as f64).max(1.0);
        let scale = (left.norm_squared() / freedom).sqrt().max(noise);
        let lengths: Vec<f64> = design.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
        let n = design.ncols();
        let normal = DMatrix::from_fn(n, n, |i, j| design.column(i).dot(&design.column(j)) / (lengths[i] * lengths[j]))
            + DMatrix::identity(n, n) * 1e-11;
        let inverse = normal.cholesky().map(|factor| factor.inverse());
        let widths = DVector::from_fn(n, |k, _| {
            inverse.as_ref().map_or(f64::NAN, |inverse| 1.96 * scale * inverse[(k, k)].max(0.0).sqrt() / lengths[k])
        });
        Self { x, widths, nuisance: evidence.nuisance.ncols() }
    }

    pub fn parameters(&self, evidence: &Evidence, members: &[usize], step: usize) -> Vec<CauseParameter> {
        let before: usize = members[..step].iter().map(|&m| evidence.hypotheses[m].columns.ncols()).sum();
        let hypothesis = &evidence.hypotheses[members[step]];
        hypothesis
            .parameters
            .iter()
            .enumerate()
            .map(|(k, parameter)| CauseParameter {
                name: parameter.symbol.clone(),
                unit: parameter.unit,
                value: self.x[self.nuisance + before + k],
                ci95: self.widths[self.nuisance + before + k],
            })
            .collect()
    }
}

/// A hypothesis with its amounts, as it is switched on or written into a description.
pub fn entry(hypothesis: &Hypothesis, parameters: &[CauseParameter]) -> EffectEntry {
    EffectEntry {
        effect: hypothesis.effect.clone(),
        site: hypothesis.site.clone(),
        nonlinear: hypothesis.nonlinear.clone(),
        amounts: parameters.iter().map(|parameter| (parameter.name.clone(), parameter.value)).collect(),
    }
}
