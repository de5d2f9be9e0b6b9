//! Dense elimination for the few unknowns of a structure, in place and without allocation between configurations.
//!
//! Written here and not taken from faer: a structure has none to some twenty unknowns, is factored at every configuration of
//! every iteration, and is solved for one right-hand side at a time, where a blocked factorisation with its own workspace
//! costs more than the elimination itself. What is needed in addition is the rank after balancing forces and moments, and the null
//! vectors, which name a mechanism; complete pivoting gives both from the same factors.

/// Pivots below this fraction of the greatest count as none: what is left is rounding.
const NONE: f64 = 1e-11;

/// A square system with complete pivoting, rows and columns brought to the same size first.
#[derive(Debug, Clone, Default)]
pub struct Elimination {
    size: usize,
    /// Row-major, factored in place.
    matrix: Vec<f64>,
    row_scale: Vec<f64>,
    column_scale: Vec<f64>,
    rows: Vec<usize>,
    columns: Vec<usize>,
    /// Number of pivots found.
    pub rank: usize,
    work: Vec<f64>,
}

impl Elimination {
    /// Factors a row-major matrix of `size` rows and columns.
    pub fn factor(&mut self, size: usize, matrix: &[f64]) {
        let n = size;
        self.size = n;
        self.matrix.clear();
        self.matrix.extend_from_slice(matrix);
        self.rows.clear();
        self.rows.extend(0..n);
        self.columns.clear();
        self.columns.extend(0..n);
        self.row_scale.clear();
        self.row_scale.resize(n, 1.0);
        self.column_scale.clear();
        self.column_scale.resize(n, 1.0);
        self.work.resize(n, 0.0);
        // Twice in turns: forces, moments and turns have sizes far apart.
        for _ in 0..2 {
            self.balance();
        }
        self.eliminate();
    }

    /// Scales each row, then each column, by the square root of its greatest entry.
    fn balance(&mut self) {
        let n = self.size;
        for i in 0..n {
            let largest = self.matrix[i * n..(i + 1) * n].iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            if largest > 0.0 {
                let scale = largest.sqrt().recip();
                self.matrix[i * n..(i + 1) * n].iter_mut().for_each(|v| *v *= scale);
                self.row_scale[i] *= scale;
            }
        }
        for j in 0..n {
            let largest = (0..n).fold(0.0_f64, |m, i| m.max(self.matrix[i * n + j].abs()));
            if largest > 0.0 {
                let scale = largest.sqrt().recip();
                (0..n).for_each(|i| self.matrix[i * n + j] *= scale);
                self.column_scale[j] *= scale;
            }
        }
    }

    /// Eliminates with complete pivoting, until the pivots are rounding.
    fn eliminate(&mut self) {
        let n = self.size;
        self.rank = 0;
        let mut first = 0.0;
        for step in 0..n {
            let (mut best, mut at) = (0.0, (step, step));
            for i in step..n {
                for j in step..n {
                    let value = self.matrix[self.rows[i] * n + self.columns[j]].abs();
                    if value > best {
                        (best, at) = (value, (i, j));
                    }
                }
            }
            if step == 0 {
                first = best;
            }
            if best <= NONE * first || best.is_nan() {
                break;
            }
            self.rows.swap(step, at.0);
            self.columns.swap(step, at.1);
            self.rank += 1;
            let pivot_row = self.rows[step] * n;
            let pivot = self.matrix[pivot_row + self.columns[step]];
            for i in step + 1..n {
                let row = self.rows[i] * n;
                let factor = self.matrix[row + self.columns[step]] / pivot;
                self.matrix[row + self.columns[step]] = factor;
                if factor != 0.0 {
                    for j in step + 1..n {
                        let column = self.columns[j];
                        self.matrix[row + column] -= factor * self.matrix[pivot_row + column];
                    }
                }
            }
        }
    }

    /// Solves for one right-hand side in place; unknowns beyond the rank are zero.
    pub fn solve(&mut self, right: &mut [f64]) {
        let n = self.size;
        for i in 0..n {
            self.work[i] = right[self.rows[i]] * self.row_scale[self.rows[i]];
        }
        for i in 0..n {
            let row = self.rows[i] * n;
            for j in 0..i.min(self.rank) {
                self.work[i] -= self.matrix[row + self.columns[j]] * self.work[j];
            }
        }
        self.back(right);
    }

    /// Back substitution of `work[..rank]`, into the unknowns' own order and size.
    fn back(&mut self, out: &mut [f64]) {
        let n = self.size;
        for i in (0..self.rank).rev() {
            let row = self.rows[i] * n;
            for j in i + 1..self.rank {
                self.work[i] -= self.matrix[row + self.columns[j]] * self.work[j];
            }
            self.work[i] /= self.matrix[row + self.columns[i]];
        }
        for i in 0..n {
            let column = self.columns[i];
            out[column] = if i < self.rank { self.work[i] * self.column_scale[column] } else { 0.0 };
        }
    }

    /// Null vectors of a deficient system, each scaled to a greatest entry of one in the balanced unknowns.
    pub fn null_vectors(&mut self) -> Vec<Vec<f64>> {
        let n = self.size;
        (self.rank..n)
            .map(|free| {
                let column = self.columns[free];
                for i in 0..self.rank {
                    self.work[i] = -self.matrix[self.rows[i] * n + column];
                }
                let mut vector = vec![0.0; n];
                self.back(&mut vector);
                for (value, scale) in vector.iter_mut().zip(&self.column_scale) {
                    *value /= scale;
                }
                vector[column] = 1.0;
                let largest = vector.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
                vector.iter_mut().for_each(|v| *v /= largest);
                vector
            })
            .collect()
    }
}
