//! Least steps of the variables that bring a small motion about.

use nalgebra::{Cholesky, Const, Matrix6, Vector6};

/// Share of the trace below which a value is zero to rounding.
const ROUNDING: f64 = 1e-15;

/// Steps J' (J J' + damping)^-1 f, or their equal (J' J + damping)^-1 J' f where the variables are fewer than the directions, J having a column
/// of displacement and rotation for each variable.
pub struct LeastSteps {
    are_few: bool,
    factor: Cholesky<f64, Const<6>>,
}

impl LeastSteps {
    /// Of columns, rows of zeros being what is not held; `held` are the other rows. `None` where a direction is lost.
    pub fn new(
        columns: impl ExactSizeIterator<Item = Vector6<f64>> + Clone,
        held: usize,
        damping: f64,
    ) -> Option<Self> {
        let are_few = columns.len() < held;
        let mut gram = Matrix6::zeros();
        if are_few {
            for (i, a) in columns.clone().enumerate() {
                columns.clone().enumerate().for_each(|(j, b)| gram[(i, j)] = a.dot(&b));
            }
        } else {
            columns.for_each(|a| gram += a * a.transpose());
        }
        let floor = ROUNDING * gram.trace();
        for k in 0..6 {
            gram[(k, k)] += damping.max(floor);
            if gram[(k, k)] <= floor {
                gram[(k, k)] = 1.0;
            }
        }
        gram.cholesky().map(|factor| Self { are_few, factor })
    }

    /// The step for a motion, variable by variable, by the columns of [`LeastSteps::new`].
    pub fn step(
        &self,
        columns: impl Iterator<Item = Vector6<f64>> + Clone,
        motion: &Vector6<f64>,
        mut put: impl FnMut(usize, f64),
    ) {
        if self.are_few {
            let mut right = Vector6::zeros();
            columns.clone().enumerate().for_each(|(k, column)| right[k] = column.dot(motion));
            let step = self.factor.solve(&right);
            columns.enumerate().for_each(|(k, _)| put(k, step[k]));
        } else {
            let y = self.factor.solve(motion);
            columns.enumerate().for_each(|(k, column)| put(k, column.dot(&y)));
        }
    }
}
