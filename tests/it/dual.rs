//! Residuals with exact derivatives: functions of dual numbers as problems.

use elastogeo::least_squares::{EvaluationError, Problem};
use nalgebra::{Const, DMatrix, DVector, U1};
use num_dual::{Derivative, DualSVec64};

/// A number and its derivative by N parameters.
pub type Dual<const N: usize> = DualSVec64<N>;

/// N parameters, M residuals.
pub struct Smooth<const N: usize, F> {
    pub residuals: usize,
    pub function: F,
}

impl<const N: usize, F: Fn(&[Dual<N>; N]) -> Vec<Dual<N>>> Problem for Smooth<N, F> {
    fn parameters(&self) -> usize {
        N
    }

    fn residuals(&self) -> usize {
        self.residuals
    }

    fn evaluate(
        &self,
        x: &[f64],
        residual: &mut DVector<f64>,
        mut jacobian: Option<&mut DMatrix<f64>>,
    ) -> Result<(), EvaluationError> {
        let x: [Dual<N>; N] = std::array::from_fn(|j| {
            let mut x = Dual::from_re(x[j]);
            x.eps = Derivative::derivative_generic(Const::<N>, U1, j);
            x
        });
        let values = (self.function)(&x);
        assert_eq!(values.len(), self.residuals);
        for (i, value) in values.into_iter().enumerate() {
            residual[i] = value.re;
            if let Some(jacobian) = jacobian.as_deref_mut() {
                jacobian.set_row(i, &value.eps.unwrap_generic(Const::<N>, U1).transpose());
            }
        }
        Ok(())
    }
}
