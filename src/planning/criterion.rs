//! What makes one set of measurements better than another.

use nalgebra::{Cholesky, DMatrix, Dyn};
use rayon::prelude::*;

/// What is to be best.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Optimality {
    /// Root mean square position error after compensation at the test poses.
    TestError,
    /// Determinant of the information matrix.
    D,
    /// Mean variance of the parameters, in units of their tolerances.
    A,
    /// Greatest variance of any combination of them.
    E,
    /// Observability index 1 to 5 of the parameters in units of their tolerances.
    O(usize),
}

impl Optimality {
    /// All, by name.
    pub const NAMES: [&'static str; 9] = ["test-error", "D", "A", "E", "O1", "O2", "O3", "O4", "O5"];

    /// By name, whatever its case.
    pub fn named(name: &str) -> Option<Self> {
        let k = Self::NAMES.iter().position(|known| known.eq_ignore_ascii_case(name))?;
        Some([Self::TestError, Self::D, Self::A, Self::E].get(k).copied().unwrap_or(Self::O(k.saturating_sub(3))))
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::TestError => "test-error",
            Self::D => "D",
            Self::A => "A",
            Self::E => "E",
            Self::O(k) => Self::NAMES.get(k + 3).copied().unwrap_or("O"),
        }
    }
}

/// A criterion with what it needs of the problem; all losses are logarithms to be made small.
pub enum Target {
    /// Half the logarithm of tr(W M^-1).
    Trace(DMatrix<f64>),
    /// Less the mean logarithm of the eigenvalues.
    Determinant,
    /// Of the singular values of the Jacobian by scaled parameters, whose information is S' M S; and so many candidates are
    /// tried, the best by the determinant.
    Singular(Optimality, DMatrix<f64>, usize),
}

impl Target {
    pub fn loss(&self, m: &DMatrix<f64>) -> f64 {
        let loss = match self {
            Self::Trace(weight) => m.clone().cholesky().map(|c| 0.5 * c.solve(weight).trace().ln()),
            Self::Determinant => m.clone().cholesky().map(|c| -log_determinant(&c) / m.nrows() as f64),
            Self::Singular(kind, scale, _) => singular_loss(*kind, &scale.tr_mul(&m.tr_mul(scale))),
        };
        loss.filter(|loss| loss.is_finite()).unwrap_or(f64::INFINITY)
    }

    /// Loss when each of the `blocks` (columns are readings' rows; those not `allowed` are passed over) joins `m`.
    pub fn joined(&self, m: &DMatrix<f64>, blocks: &[&DMatrix<f64>], allowed: &[bool]) -> Vec<f64> {
        let Some(factor) = m.clone().cholesky() else { return vec![f64::INFINITY; blocks.len()] };
        let of = |loss: &(dyn Fn(&DMatrix<f64>) -> f64 + Sync)| -> Vec<f64> {
            let each = |(block, allowed): (&&DMatrix<f64>, &bool)| if *allowed { loss(block) } else { f64::INFINITY };
            blocks.par_iter().zip(allowed).with_min_len(32).map(each).collect()
        };
        let inverse = factor.inverse();
        let n = m.nrows() as f64;
        let information = |block: &DMatrix<f64>, spread: &DMatrix<f64>| {
            let mut k = block.tr_mul(spread);
            (0..k.nrows()).for_each(|i| k[(i, i)] += 1.0);
            k
        };
        match self {
            Self::Trace(weight) => {
                // Woodbury: tr(W (M + B B')^-1) = tr(W C) - tr((1 + B' C B)^-1 B' C W C B).
                let spread = inverse.tr_mul(&weight.tr_mul(&inverse));
                let before = inverse.component_mul(weight).sum();
                of(&|block| {
                    let small = information(block, &inverse.tr_mul(block)).cholesky();
                    let gain = small.map(|small| small.solve(&block.tr_mul(&spread.tr_mul(block))).trace());
                    gain.map_or(f64::INFINITY, |gain| 0.5 * (before - gain).max(f64::MIN_POSITIVE).ln())
                })
            }
            Self::Determinant => {
                let before = -log_determinant(&factor) / n;
                of(&|block| {
                    let small = information(block, &inverse.tr_mul(block)).cholesky();
                    small.map_or(f64::INFINITY, |small| before - log_determinant(&small) / n)
                })
            }
            Self::Singular(_, _, short_list) => {
                let coarse = Self::Determinant.joined(m, blocks, allowed);
                let mut order: Vec<usize> = (0..blocks.len()).filter(|&k| coarse[k].is_finite()).collect();
                order.sort_by(|&a, &b| coarse[a].total_cmp(&coarse[b]));
                let mut losses = vec![f64::INFINITY; blocks.len()];
                for &k in order.iter().take(*short_list) {
                    losses[k] = self.loss(&joined(m, blocks[k]));
                }
                losses
            }
        }
    }
}

/// Adds the information of a block.
pub fn join(m: &mut DMatrix<f64>, block: &DMatrix<f64>) {
    for row in block.column_iter() {
        m.ger(1.0, &row, &row, 1.0);
    }
}

fn joined(m: &DMatrix<f64>, block: &DMatrix<f64>) -> DMatrix<f64> {
    let mut m = m.clone();
    join(&mut m, block);
    m
}

fn log_determinant(factor: &Cholesky<f64, Dyn>) -> f64 {
    2.0 * factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>()
}

fn singular_loss(kind: Optimality, information: &DMatrix<f64>) -> Option<f64> {
    let values: Vec<f64> = information.symmetric_eigenvalues().iter().map(|v| v.max(0.0).sqrt()).collect();
    let (least, most) = values.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), &v| (a.min(v), b.max(v)));
    Some(match kind {
        Optimality::O(1) => -values.iter().map(|v| v.ln()).sum::<f64>() / values.len() as f64,
        Optimality::O(2) => (most / least).ln(),
        Optimality::O(4) => (most / (least * least)).ln(),
        Optimality::O(5) => values.iter().map(|v| 1.0 / v).sum::<f64>().ln(),
        _ => -least.ln(),
    })
}
