//! Bounded least squares: answers known by hand, robustness, and refusals.

use elastogeo::least_squares::{
    Bounds, BoundsError, EvaluationError, Loss, Problem, Settings, Side, Solution, Status, UsageError, minimize,
    minimize_in_box, minimize_observed,
};
use nalgebra::{DMatrix, DVector, dmatrix, dvector};
use num_dual::DualNum;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::dual::{Dual, Smooth};

/// `r = a x + b`.
struct Linear {
    a: DMatrix<f64>,
    b: DVector<f64>,
}

impl Problem for Linear {
    fn parameters(&self) -> usize {
        self.a.ncols()
    }

    fn residuals(&self) -> usize {
        self.a.nrows()
    }

    fn evaluate(
        &self,
        x: &[f64],
        residual: &mut DVector<f64>,
        jacobian: Option<&mut DMatrix<f64>>,
    ) -> Result<(), EvaluationError> {
        residual.copy_from(&(&self.a * DVector::from_row_slice(x) + &self.b));
        if let Some(jacobian) = jacobian {
            jacobian.copy_from(&self.a);
        }
        Ok(())
    }
}

/// One parameter, one residual, given by closures for the residual and its derivative.
struct Scalar<R, D> {
    residual: R,
    derivative: D,
}

impl<R, D> Problem for Scalar<R, D>
where
    R: Fn(f64) -> Result<f64, EvaluationError>,
    D: Fn(f64) -> Result<f64, EvaluationError>,
{
    fn parameters(&self) -> usize {
        1
    }

    fn residuals(&self) -> usize {
        1
    }

    fn evaluate(
        &self,
        x: &[f64],
        residual: &mut DVector<f64>,
        jacobian: Option<&mut DMatrix<f64>>,
    ) -> Result<(), EvaluationError> {
        residual[0] = (self.residual)(x[0])?;
        if let Some(jacobian) = jacobian {
            jacobian[(0, 0)] = (self.derivative)(x[0])?;
        }
        Ok(())
    }
}

fn asked(problem: &impl Problem, start: &[f64]) -> Result<Solution, UsageError> {
    minimize(problem, start, &Bounds::none(start.len()), &Settings::default())
}

fn free(problem: &impl Problem, start: &[f64]) -> Solution {
    asked(problem, start).unwrap()
}

fn assert_close(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (found_j, expected_j) in found.iter().zip(expected) {
        assert!((found_j - expected_j).abs() <= tolerance, "{found:?} is not {expected:?}");
    }
}

#[test]
fn a_box_cuts_off_the_minimum_and_the_rest_adjusts() {
    // (z1 + 2 z2 - 6)^2 + (z2 - 1)^2 is least at (4, 1). On z1 = 2, 4 (2 z2 - 4) + 2 (z2 - 1) = 0 gives z2 = 1.8.
    let (a, b) = (dmatrix![1.0, 2.0; 0.0, 1.0], dvector![-6.0, -1.0]);
    let bounds = Bounds::new(vec![0.0, f64::NEG_INFINITY], vec![2.0, f64::INFINITY]).unwrap();
    assert_close(minimize_in_box(&a, &b, &bounds).unwrap().as_slice(), &[2.0, 1.8], 1e-14);

    let solution = minimize(&Linear { a, b }, &[0.5, 0.5], &bounds, &Settings::default()).unwrap();
    assert_close(&solution.x, &[2.0, 1.8], 1e-13);
    assert_eq!(solution.at_bound, [Some(Side::Upper), None]);
    // 2 + 3.6 - 6 = -0.4 and 0.8
    assert_close(solution.residual.as_slice(), &[-0.4, 0.8], 1e-13);
    assert_close(solution.gradient.as_slice(), &[-0.4, 0.0], 1e-13);
    assert!((solution.cost - 0.4).abs() < 1e-14, "{}", solution.cost);
    assert!(solution.status.converged());
}

#[test]
fn a_box_that_holds_the_minimum_changes_nothing() {
    let (a, b) = (dmatrix![1.0, 2.0; 0.0, 1.0], dvector![-6.0, -1.0]);
    let bounds = Bounds::new(vec![-10.0; 2], vec![10.0; 2]).unwrap();
    assert_close(minimize_in_box(&a, &b, &bounds).unwrap().as_slice(), &[4.0, 1.0], 1e-14);
}

#[test]
fn a_box_away_from_the_origin() {
    // Distance to (0, 0) within [3, 5] x [-7, -6].
    let bounds = Bounds::new(vec![3.0, -7.0], vec![5.0, -6.0]).unwrap();
    let z = minimize_in_box(&DMatrix::identity(2, 2), &dvector![0.0, 0.0], &bounds).unwrap();
    assert_eq!(z.as_slice(), [3.0, -6.0]);
}

/// All 3^n ways of fixing variables, the feasible one with the least cost; columns are independent.
fn exhaustive(a: &DMatrix<f64>, b: &DVector<f64>, bounds: &Bounds) -> f64 {
    let n = a.ncols();
    let mut least = f64::INFINITY;
    for code in 0..3_usize.pow(n as u32) {
        let choice: Vec<usize> = (0..n).map(|j| code / 3_usize.pow(j as u32) % 3).collect();
        let mut z = DVector::from_fn(n, |j, _| [0.0, bounds.lower[j], bounds.upper[j]][choice[j]]);
        let free: Vec<usize> = (0..n).filter(|&j| choice[j] == 0).collect();
        if !free.is_empty() {
            let columns = a.select_columns(&free);
            let right = -columns.tr_mul(&(a * &z + b));
            let Some(factor) = columns.tr_mul(&columns).cholesky() else { continue };
            for (&j, value) in free.iter().zip(&factor.solve(&right)) {
                z[j] = *value;
            }
        }
        if (0..n).all(|j| bounds.lower[j] <= z[j] && z[j] <= bounds.upper[j]) {
            least = least.min((a * &z + b).norm_squared());
        }
    }
    least
}

#[test]
fn a_box_against_every_active_set() {
    let mut random = ChaCha8Rng::seed_from_u64(4);
    for case in 0..400 {
        let n = 2 + case % 4;
        let mut draw = |low: f64, high: f64| random.random_range(low..high);
        let mut a = DMatrix::from_fn(n + 2, n, |_, _| draw(-1.0, 1.0));
        // Columns of very different size, as parameters in different units have.
        for (j, mut column) in a.column_iter_mut().enumerate() {
            column *= 10_f64.powi(3 * j as i32 - 3);
        }
        let b = DVector::from_fn(n + 2, |_, _| draw(-3.0, 3.0));
        let lower: Vec<f64> = (0..n).map(|_| draw(-1.0, 0.5)).collect();
        let upper: Vec<f64> = lower.iter().map(|lower| lower + draw(0.01, 1.0)).collect();
        let mut bounds = Bounds::new(lower, upper).unwrap();
        // Also variables with equal bounds, with nearly equal ones, and with a limit on one side or none.
        for j in 0..n {
            match (case / 4 + 3 * j) % 8 {
                0 => bounds.upper[j] = bounds.lower[j],
                1 => bounds.upper[j] = bounds.lower[j] + 1e-13,
                2 => bounds.upper[j] = f64::INFINITY,
                3 => (bounds.lower[j], bounds.upper[j]) = (f64::NEG_INFINITY, f64::INFINITY),
                _ => {}
            }
        }
        let z = minimize_in_box(&a, &b, &bounds).unwrap();
        let found = (&a * &z + &b).norm_squared();
        let least = exhaustive(&a, &b, &bounds);
        assert!((found - least).abs() <= 1e-12 * (1.0 + least), "case {case}: {found} instead of {least}");
    }
}

#[test]
fn unreachable_parameters_stay_and_confounded_ones_share() {
    // Only x0 + x1 is determined, x2 not at all.
    let a = dmatrix![1.0, 1.0, 0.0; 2.0, 2.0, 0.0; -1.0, -1.0, 0.0];
    let solution = free(&Linear { a: a.clone(), b: dvector![-3.0, -6.0, 3.0] }, &[0.0, 0.0, 7.0]);
    assert!(solution.status.converged());
    assert_close(&solution.x, &[1.5, 1.5, 7.0], 1e-12);

    // A bound on one of the two sends the remaining step to the other.
    let bounds = Bounds::new(vec![-1.0; 3], vec![1.0, 5.0, 9.0]).unwrap();
    let problem = Linear { a, b: dvector![-3.0, -6.0, 3.0] };
    let solution = minimize(&problem, &[0.0, 0.0, 7.0], &bounds, &Settings::default()).unwrap();
    assert!(solution.cost < 1e-24, "{}", solution.cost);
    assert_eq!(solution.x[2], 7.0);
}

#[test]
fn fewer_residuals_than_parameters() {
    // The nearest point of x0 + 2 x1 = 5 to the origin, in variables scaled by 1 and 2.
    let solution = free(&Linear { a: dmatrix![1.0, 2.0], b: dvector![-5.0] }, &[0.0, 0.0]);
    assert!(solution.status.converged());
    assert_close(&solution.x, &[2.5, 1.25], 1e-12);
}

#[test]
fn nothing_to_adjust_or_nothing_to_fit() {
    let none = free(&Linear { a: DMatrix::zeros(2, 0), b: dvector![3.0, 4.0] }, &[]);
    assert_eq!((none.status, none.cost, none.iterations), (Status::Gradient, 12.5, 0));
    let nothing = free(&Linear { a: DMatrix::zeros(0, 2), b: DVector::zeros(0) }, &[1.0, 2.0]);
    assert!(nothing.status.converged());
    assert_eq!(nothing.x, [1.0, 2.0]);
    assert_eq!(minimize_in_box(&DMatrix::zeros(0, 0), &DVector::zeros(0), &Bounds::none(0)).unwrap().len(), 0);
}

#[test]
fn equal_bounds_hold_a_parameter() {
    let problem = Linear { a: dmatrix![1.0, 2.0; 0.0, 1.0], b: dvector![-6.0, -1.0] };
    let bounds = Bounds::new(vec![2.0, -9.0], vec![2.0, 9.0]).unwrap();
    let solution = minimize(&problem, &[2.0, 0.0], &bounds, &Settings::default()).unwrap();
    assert_close(&solution.x, &[2.0, 1.8], 1e-13);
    assert_eq!(solution.at_bound, [Some(Side::Lower), None]);
    assert!(solution.iterations <= 3, "a held parameter must not slow the others: {}", solution.iterations);
}

#[test]
fn a_bound_that_holds_hard_does_not_slow_the_rest() {
    // The first parameter would go to a million; were it counted, the radius would damp the second for ever.
    let problem = Linear { a: DMatrix::identity(2, 2), b: dvector![-1e6, -1.0] };
    let bounds = Bounds::new(vec![0.0, -9.0], vec![2.0, 9.0]).unwrap();
    let solution = minimize(&problem, &[2.0, 0.0], &bounds, &Settings::default()).unwrap();
    assert_eq!(solution.x, [2.0, 1.0]);
    assert!(solution.iterations <= 3, "{} steps", solution.iterations);
}

#[test]
fn a_start_outside_is_moved_inside() {
    let problem = Linear { a: DMatrix::identity(2, 2), b: dvector![-1.0, -1.0] };
    let bounds = Bounds::new(vec![0.0, 0.0], vec![2.0, 0.5]).unwrap();
    let solution = minimize(&problem, &[50.0, -50.0], &bounds, &Settings::default()).unwrap();
    assert_close(&solution.x, &[1.0, 0.5], 1e-14);
    assert_eq!(solution.initial_cost, 0.5 * (1.0 + 1.0));
}

/// A decay sampled at 40 times, with every fifth sample far off.
fn decay_with_outliers() -> Smooth<2, impl Fn(&[Dual<2>; 2]) -> Vec<Dual<2>>> {
    let function = |x: &[Dual<2>; 2]| {
        let residual = |i: u32| {
            let t = f64::from(i) / 10.0;
            // Noise of standard deviation 0.7 units, at most 1.
            let noise = (f64::from(i) * 2.4).sin();
            let outlier = if i.is_multiple_of(5) { 60.0 } else { 0.0 };
            x[0] * (-x[1] * t).exp() - 100.0 * (-0.5 * t).exp() - noise - outlier
        };
        (0..40).map(residual).collect()
    };
    Smooth { residuals: 40, function }
}

#[test]
fn robust_losses_resist_outliers() {
    let problem = decay_with_outliers();
    let solve = |loss| {
        let settings = Settings { loss, ..Settings::default() };
        // A redescending loss sees nothing from afar.
        let start = if matches!(loss, Loss::Tukey(_)) { [95.0, 0.48] } else { [80.0, 1.0] };
        minimize(&problem, &start, &Bounds::none(2), &settings).unwrap()
    };
    let miss = |solution: &Solution| (solution.x[0] / 100.0 - 1.0).abs().max((solution.x[1] / 0.5 - 1.0).abs());
    let squares = solve(Loss::Squares);
    assert!(miss(&squares) > 0.1, "one sample in five should spoil plain least squares: {:?}", squares.x);
    assert!(squares.weights.iter().all(|&weight| weight == 1.0));
    for (loss, tolerance) in [(Loss::Huber(1.0), 0.02), (Loss::Cauchy(1.0), 0.01), (Loss::Tukey(4.685), 0.01)] {
        let solution = solve(loss);
        assert!(solution.status.converged(), "{loss:?}: {:?}", solution.status);
        assert!(miss(&solution) < tolerance, "{loss:?}: {:?}", solution.x);
        // The cost and the gradient belong to the loss.
        let cost = 0.5 * solution.residual.iter().map(|&r| loss.value(r)).sum::<f64>();
        assert!((solution.cost - cost).abs() <= 1e-12 * cost);
        let slope = solution
            .gradient
            .component_div(&DVector::from_iterator(2, solution.jacobian.column_iter().map(|column| column.norm())));
        assert!(slope.amax() <= 1e-6 * solution.residual.norm(), "{loss:?}: {slope}");
        for (i, &weight) in solution.weights.iter().enumerate() {
            assert!(
                if i.is_multiple_of(5) { weight < 0.05 } else { weight > 0.2 },
                "{loss:?}: sample {i} weighs {weight}"
            );
        }
    }
}

#[test]
fn weights_are_derivatives_of_the_loss() {
    for loss in [Loss::Squares, Loss::Huber(1.5), Loss::Cauchy(0.7), Loss::Tukey(2.0)] {
        for residual in [-5.0, -1.6, -0.3, 0.2, 1.4, 1.9, 3.0_f64] {
            let square = residual * residual;
            let value = |square: f64| loss.value(square.sqrt());
            let step = 1e-6 * square;
            let slope = (value(square + step) - value(square - step)) / (2.0 * step);
            assert!((slope - loss.weight(residual)).abs() < 1e-8, "{loss:?} at {residual}: {slope}");
        }
    }
}

#[test]
fn a_wall_shortens_the_step() {
    // ln x = -3 from x = 10: the first Newton step goes to 10 - 10 (ln 10 + 3) = -43.
    let logarithm =
        |x: f64| if x > 0.0 { Ok(x.ln() + 3.0) } else { Err(EvaluationError::new(format!("logarithm of {x}"))) };
    let problem = Scalar { residual: logarithm, derivative: |x: f64| Ok(1.0 / x) };
    let settings = Settings { initial_radius: 1e3, ..Settings::default() };
    let mut refused = 0;
    let solution = minimize_observed(&problem, &[10.0], &Bounds::none(1), &settings, &mut |progress| {
        refused += usize::from(progress.gain.is_none());
    })
    .unwrap();
    assert!(refused > 0, "the wall was never met");
    assert!(solution.status.converged());
    assert_close(&solution.x, &[(-3.0_f64).exp()], 1e-13);

    // The same wall as NaN, and a wall in the derivative only.
    let silent = Scalar { residual: |x: f64| Ok(x.ln() + 3.0), derivative: |x: f64| Ok(1.0 / x) };
    assert_close(&free(&silent, &[10.0]).x, &solution.x, 1e-13);
    let derivative = |x: f64| if x > 0.04 { Ok(1.0 / x) } else { Err(EvaluationError::new("too small")) };
    let half = Scalar { residual: logarithm, derivative };
    assert_close(&free(&half, &[10.0]).x, &solution.x, 1e-13);
}

#[test]
fn a_minimum_behind_a_wall_is_not_called_converged() {
    let residual = |x: f64| if x < 1.0 { Ok(x - 2.0) } else { Err(EvaluationError::new("beyond the wall")) };
    let solution = free(&Scalar { residual, derivative: |_| Ok(1.0) }, &[0.0]);
    assert_eq!(solution.status, Status::Stalled);
    assert!((solution.x[0] - 1.0).abs() < 1e-9, "{:?}", solution.x);
}

#[test]
fn no_value_at_the_start() {
    let problem = Scalar { residual: |x: f64| Ok(x.ln()), derivative: |x: f64| Ok(1.0 / x) };
    let refused = |found: Result<Solution, UsageError>| match found {
        Err(UsageError::NoStart(reason)) => reason.to_string(),
        other => panic!("{other:?}"),
    };
    assert_eq!(refused(asked(&problem, &[-1.0])), "residual 0 is NaN");
    let steep = Scalar { residual: |_| Ok(1.0), derivative: |_| Ok(f64::INFINITY) };
    assert_eq!(refused(asked(&steep, &[1.0])), "derivative of residual 0 by parameter 0 is inf");
    let huge = Scalar { residual: |_| Ok(1e200), derivative: |_| Ok(1.0) };
    refused(asked(&huge, &[1.0]));
}

#[test]
fn a_wrong_derivative_is_not_called_converged() {
    let problem = Scalar { residual: |x: f64| Ok(x + 5.0), derivative: |_| Ok(-1.0) };
    let solution = free(&problem, &[1.0]);
    assert_eq!(solution.status, Status::Stalled);
    assert_eq!(solution.x, [1.0]);
}

/// `r = a x + b`, rounded: a model of far greater terms than its parameters, which are changes.
struct Rounded {
    exact: Linear,
    unit: f64,
    is_known: bool,
}

impl Problem for Rounded {
    fn parameters(&self) -> usize {
        self.exact.parameters()
    }

    fn residuals(&self) -> usize {
        self.exact.residuals()
    }

    fn rounding(&self) -> f64 {
        if self.is_known { self.unit * (self.residuals() as f64).sqrt() } else { 0.0 }
    }

    fn evaluate(
        &self,
        x: &[f64],
        residual: &mut DVector<f64>,
        jacobian: Option<&mut DMatrix<f64>>,
    ) -> Result<(), EvaluationError> {
        self.exact.evaluate(x, residual, jacobian)?;
        residual.iter_mut().for_each(|r| *r = (*r / self.unit).round() * self.unit);
        Ok(())
    }
}

/// Begun where the last step is below the rounding of the residual, a fit has converged; where the problem does not say what that is, no
/// step shows it: the changes are too small to tell.
#[test]
fn a_fit_begun_at_its_end_converges() {
    let unit = 1e-7;
    let of = |is_known| {
        // Least at 0, but for the rounding of the first residual.
        let b = dvector![3.0 - 0.8 * unit, -1.0, -1.0 + 0.4 * unit, -2.0 + 0.4 * unit];
        let exact = Linear { a: dmatrix![1.0, 0.0; 0.0, 1.0; 1.0, 1.0; 1.0, -1.0], b };
        let settings = Settings { cost_tolerance: 1e-18, max_iterations: 200, ..Settings::default() };
        let problem = Rounded { exact, unit, is_known };
        minimize(&problem, &[0.0, 0.0], &Bounds::none(2), &settings).expect("well posed").status
    };
    assert_eq!([of(true), of(false)], [Status::Cost, Status::IterationLimit]);
}

#[test]
fn the_iteration_limit_is_a_status() {
    let problem = decay_with_outliers();
    let settings = Settings { max_iterations: 2, ..Settings::default() };
    let solution = minimize(&problem, &[80.0, 1.0], &Bounds::none(2), &settings).unwrap();
    assert_eq!((solution.status, solution.iterations), (Status::IterationLimit, 2));
    assert!(solution.cost < solution.initial_cost);
}

#[test]
fn the_observer_sees_every_step() {
    let problem = decay_with_outliers();
    let mut diary = Vec::new();
    let solution = minimize_observed(&problem, &[5.0, 4.0], &Bounds::none(2), &Settings::default(), &mut |progress| {
        diary.push(*progress);
    })
    .unwrap();
    assert_eq!(diary.len(), solution.iterations);
    assert!(diary.iter().all(|entry| entry.step <= entry.radius * (1.0 + 1e-12)));
    assert!(diary.windows(2).all(|pair| pair[1].cost <= pair[0].cost * (1.0 + 1e-12)));
    assert_eq!(diary.iter().filter(|entry| entry.accepted).count() + 1, solution.jacobian_evaluations);
}

#[test]
fn the_same_question_has_the_same_answer() {
    let problem = decay_with_outliers();
    let bounds = Bounds::new(vec![0.0, 0.4], vec![90.0, 3.0]).unwrap();
    let settings = Settings { loss: Loss::Cauchy(1.0), ..Settings::default() };
    let solve = || minimize(&problem, &[80.0, 1.0], &bounds, &settings).unwrap();
    assert_eq!(solve(), solve());
}

#[test]
fn units_do_not_matter() {
    // The same decay with the height in other units and the rate per other times, both by powers of two.
    let plain = decay_with_outliers();
    let function =
        |x: &[Dual<2>; 2]| (decay_with_outliers().function)(&[x[0] * 2_f64.powi(-30), x[1] * 2_f64.powi(20)]);
    let converted = Smooth { residuals: 40, function };
    let here = free(&plain, &[80.0, 1.0]);
    let there = free(&converted, &[80.0 * 2_f64.powi(30), 2_f64.powi(-20)]);
    assert_eq!(here.iterations, there.iterations);
    assert_close(&[there.x[0] * 2_f64.powi(-30), there.x[1] * 2_f64.powi(20)], &here.x, 1e-12);
}

#[test]
fn malformed_questions_are_refused() {
    let problem = Linear { a: DMatrix::identity(2, 2), b: dvector![1.0, 1.0] };
    let good = Bounds::none(2);
    let ask = |start: &[f64], bounds: &Bounds, settings: &Settings| {
        minimize(&problem, start, bounds, settings).unwrap_err().to_string()
    };
    let usual = Settings::default();
    assert_eq!(ask(&[0.0], &good, &usual), "start has 1 entries, the problem has 2 parameters");
    assert_eq!(ask(&[0.0; 2], &Bounds::none(3), &usual), "lower bounds has 3 entries, the problem has 2 parameters");
    assert_eq!(ask(&[0.0, f64::NAN], &good, &usual), "starting value of parameter 1 is NaN");
    assert_eq!(ask(&[f64::INFINITY, 0.0], &good, &usual), "starting value of parameter 0 is inf");
    let reversed = Bounds { lower: vec![0.0, 2.0], upper: vec![1.0, 1.0] };
    assert_eq!(ask(&[0.0; 2], &reversed, &usual), "bounds of parameter 1 leave no value: lower 2, upper 1");
    let settings = [
        (Settings { cost_tolerance: -1.0, ..usual }, "cost_tolerance is -1; it must be at least 0 and less than 1"),
        (Settings { step_tolerance: 1.0, ..usual }, "step_tolerance is 1; it must be at least 0 and less than 1"),
        (
            Settings { gradient_tolerance: f64::NAN, ..usual },
            "gradient_tolerance is NaN; it must be at least 0 and less than 1",
        ),
        (Settings { cost_floor: f64::INFINITY, ..usual }, "cost_floor is inf; it must be finite and not negative"),
        (Settings { initial_radius: 0.0, ..usual }, "initial_radius is 0; it must be finite and positive"),
        (Settings { loss: Loss::Huber(-1.0), ..usual }, "loss is -1; it must be a finite and positive scale"),
    ];
    for (settings, message) in settings {
        assert_eq!(ask(&[0.0; 2], &good, &settings), message);
    }
}

#[test]
fn bounds_are_checked() {
    let empty = |lower: f64, upper: f64| Bounds::new(vec![0.0, lower], vec![1.0, upper]).unwrap_err();
    assert_eq!(empty(2.0, 1.0), BoundsError::Empty { index: 1, lower: 2.0, upper: 1.0 });
    assert!(matches!(empty(f64::NAN, 1.0), BoundsError::Empty { index: 1, .. }));
    assert!(matches!(empty(f64::INFINITY, f64::INFINITY), BoundsError::Empty { index: 1, .. }));
    assert_eq!(Bounds::new(vec![0.0], vec![]).unwrap_err(), BoundsError::Lengths { lower: 1, upper: 0 });
    assert!(Bounds::new(vec![f64::NEG_INFINITY, 1.0], vec![f64::INFINITY, 1.0]).is_ok());
}

#[test]
fn a_box_refuses_what_it_cannot_mean() {
    let one = Bounds::none(1);
    let refused = |a, b, bounds| minimize_in_box(&a, &b, bounds).unwrap_err();
    assert!(matches!(
        refused(dmatrix![1.0, 2.0], dvector![1.0], &one),
        UsageError::Length { expected: 2, found: 1, .. }
    ));
    assert!(matches!(refused(dmatrix![1.0], dvector![1.0, 2.0], &one), UsageError::Shape { .. }));
    assert!(matches!(refused(dmatrix![f64::NAN], dvector![1.0], &one), UsageError::Setting { .. }));
}

#[test]
fn a_problem_that_breaks_its_word_is_refused() {
    struct Liar;
    impl Problem for Liar {
        fn parameters(&self) -> usize {
            1
        }

        fn residuals(&self) -> usize {
            2
        }

        fn evaluate(
            &self,
            _: &[f64],
            residual: &mut DVector<f64>,
            _: Option<&mut DMatrix<f64>>,
        ) -> Result<(), EvaluationError> {
            *residual = dvector![1.0, 2.0, 3.0];
            Ok(())
        }
    }
    let error = minimize(&Liar, &[0.0], &Bounds::none(1), &Settings::default()).unwrap_err();
    assert_eq!(error, UsageError::Shape { what: "residual", expected: (2, 1), found: (3, 1) });
}
