//! Normal equations, configuration by configuration, of displacements that are linear in a few quantities: components of a
//! compliance, or compliances of springs. Whatever the rules over configurations, no reading is looked at again.

use std::collections::HashMap;

use nalgebra::{DMatrix, DVector};

/// Ridge of the constant quantities relative to the mean diagonal: zero where nothing is said, and else no visible change.
const RIDGE: f64 = 1e-12;

/// Displacements linear in `m` quantities that depend on the configuration.
#[derive(Debug, Clone, Default)]
pub struct Normal {
    /// Inputs of each configuration.
    pub x: Vec<Vec<f64>>,
    /// Sums of products of coefficients (m x m), of coefficient and displacement (m), and of squared displacements, by
    /// configuration; displacements are what `base` leaves.
    pub gram: Vec<DMatrix<f64>>,
    pub right: Vec<DVector<f64>>,
    pub square: Vec<f64>,
    /// Number of displacements.
    pub rows: usize,
    /// Quantities from which those of each rule deviate.
    pub base: DVector<f64>,
    /// Least value of each quantity.
    pub least: Vec<f64>,
    index: HashMap<usize, usize>,
}

impl Normal {
    /// Nothing yet, of quantities not below `least`.
    pub fn new(least: Vec<f64>) -> Self {
        Self { base: DVector::zeros(least.len()), least, ..Self::default() }
    }

    /// Number of quantities.
    pub fn quantities(&self) -> usize {
        self.least.len()
    }

    /// Adds a displacement (`weight` counts its square) at a configuration with its inputs.
    pub fn add(&mut self, pose: usize, x: &[f64], coefficients: &DVector<f64>, displacement: f64, weight: f64) {
        let m = self.quantities();
        let at = *self.index.entry(pose).or_insert_with(|| {
            self.x.push(x.to_vec());
            self.gram.push(DMatrix::zeros(m, m));
            self.right.push(DVector::zeros(m));
            self.square.push(0.0);
            self.x.len() - 1
        });
        self.gram[at].ger(weight, coefficients, coefficients, 1.0);
        self.right[at].axpy(weight * displacement, coefficients, 1.0);
        self.square[at] += weight * displacement * displacement;
        self.rows += 1;
    }

    /// Takes quantities out of the displacements: rules then say how far theirs deviate from these.
    pub fn subtract(&mut self, base: DVector<f64>) {
        for ((gram, right), square) in self.gram.iter().zip(&mut self.right).zip(&mut self.square) {
            let by_base = gram * &base;
            *square += base.dot(&by_base) - 2.0 * base.dot(right);
            *right -= by_base;
        }
        self.base += base;
    }

    /// The constant quantities that fit best.
    pub fn constant(&self) -> DVector<f64> {
        let m = self.quantities();
        let mut gram: DMatrix<f64> = self.gram.iter().fold(DMatrix::zeros(m, m), |sum, own| sum + own);
        let ridge = RIDGE * gram.trace().max(f64::MIN_POSITIVE) / m.max(1) as f64;
        (0..m).for_each(|k| gram[(k, k)] += ridge);
        let right: DVector<f64> = self.right.iter().fold(DVector::zeros(m), |sum, own| sum + own);
        gram.cholesky().map_or_else(|| DVector::zeros(m), |factor| factor.solve(&right))
    }

    /// Mean over the configurations of what each quantity's diagonal holds.
    pub fn mean_diagonal(&self) -> Vec<f64> {
        let count = self.gram.len().max(1) as f64;
        (0..self.quantities()).map(|k| self.gram.iter().map(|gram| gram[(k, k)]).sum::<f64>() / count).collect()
    }
}
