//! The least-squares test problems of Moré, Garbow and Hillstrom, free and within Gay's bounds.
//!
//! - J. J. Moré, B. S. Garbow, K. E. Hillstrom, "Testing unconstrained optimization software", *ACM Transactions on
//!   Mathematical Software* 7 (1981), 17-41; algorithm 566. The functions carry its numbers, and the standard starts and
//!   free minima are its.
//! - D. M. Gay, "A trust-region approach to linearly constrained optimization", Lecture Notes in Mathematics 1066,
//!   Springer 1984, 72-105: the bounds and the sums of squares at the constrained minima, as collected by A. Neumaier
//!   (<https://arnold-neumaier.at/glopt/bounds.html>).
//!
//! The constrained minima were recomputed independently, see `tests/data/mgh/README.md`; the first-order conditions are
//! checked here as well.

use std::f64::consts::PI;

use elastogeo::least_squares::{Bounds, Settings, Side, Solution, minimize};
use num_dual::DualNum;

use crate::dual::{Dual, Smooth};

type Function<const N: usize> = fn(&[Dual<N>; N]) -> Vec<Dual<N>>;

const UNBOUNDED: ([f64; 0], [f64; 0]) = ([], []);

/// Solves from `start` and compares the sum of squares with the nearest of `minima`; returns the solution.
fn solve<const N: usize>(
    name: &str,
    function: Function<N>,
    start: [f64; N],
    (lower, upper): (&[f64], &[f64]),
    minima: &[f64],
    tolerance: f64,
) -> Solution {
    let residuals = function(&start.map(Dual::from_re)).len();
    let bounds = if lower.is_empty() { Bounds::none(N) } else { Bounds::new(lower.to_vec(), upper.to_vec()).unwrap() };
    let problem = Smooth { residuals, function };
    let solution = minimize(&problem, &start, &bounds, &Settings::default()).unwrap();
    let sum = 2.0 * solution.cost;
    // A minimum of zero has no relative error; there the sum itself must vanish.
    let error = |minimum: &f64| if *minimum == 0.0 { sum } else { (sum - minimum).abs() / minimum };
    let error = minima.iter().map(error).fold(f64::INFINITY, f64::min);
    println!(
        "{name:26} sum {sum:.9e}, error {error:.1e}, {:3} steps, {:?} at {:.5?}",
        solution.iterations, solution.status, solution.x
    );
    assert!(solution.status.converged(), "{name}: {:?}", solution.status);
    assert!(error <= tolerance, "{name}: sum of squares {sum:e}, published {minima:?}");
    assert_first_order(name, &solution, &bounds);
    solution
}

/// Downhill leads nowhere: each parameter has no slope, or rests on a bound that the slope leads out of.
fn assert_first_order(name: &str, solution: &Solution, bounds: &Bounds) {
    for (j, &gradient) in solution.gradient.iter().enumerate() {
        let (x, lower, upper) = (solution.x[j], bounds.lower[j], bounds.upper[j]);
        assert!(lower <= x && x <= upper, "{name}: parameter {j} out of bounds");
        let held = match solution.at_bound[j] {
            Some(Side::Lower) => gradient >= 0.0,
            Some(Side::Upper) => gradient <= 0.0,
            None => false,
        };
        // As a cosine; where the residual vanishes it is made of rounding errors and has no direction.
        let size = solution.jacobian.column(j).norm() * solution.residual.norm();
        let flat = gradient.abs() <= 1e-4 * size || solution.cost < 1e-20;
        assert!(held || flat, "{name}: parameter {j} has slope {gradient:e} of {size:e}");
    }
}

macro_rules! problems {
    ($($test:ident: $function:expr, start $start:expr, bounds $bounds:expr, minima $minima:expr, within $tolerance:expr;)*) => {
        $(#[test]
        fn $test() {
            let (lower, upper) = $bounds;
            solve(stringify!($test), $function, $start, (&lower, &upper), &$minima, $tolerance);
        })*
    };
}

// Free: six digits are published.
problems! {
    rosenbrock_free: rosenbrock, start [-1.2, 1.0], bounds UNBOUNDED, minima [0.0], within 1e-20;
    freudenstein_roth_free: freudenstein_roth, start [0.5, -2.0], bounds UNBOUNDED, minima [0.0, 48.9842], within 1e-5;
    powell_badly_scaled_free: powell_badly_scaled, start [0.0, 1.0], bounds UNBOUNDED, minima [0.0], within 1e-20;
    brown_badly_scaled_free: brown_badly_scaled, start [1.0, 1.0], bounds UNBOUNDED, minima [0.0], within 1e-20;
    beale_free: beale, start [1.0, 1.0], bounds UNBOUNDED, minima [0.0], within 1e-20;
    jennrich_sampson_free: jennrich_sampson, start [0.3, 0.4], bounds UNBOUNDED, minima [124.362], within 1e-5;
    helical_valley_free: helical_valley, start [-1.0, 0.0, 0.0], bounds UNBOUNDED, minima [0.0], within 1e-20;
    bard_free: bard, start [1.0, 1.0, 1.0], bounds UNBOUNDED, minima [8.21487e-3], within 1e-5;
    gaussian_free: gaussian, start [0.4, 1.0, 0.0], bounds UNBOUNDED, minima [1.12793e-8], within 1e-5;
    meyer_free: meyer, start [0.02, 4000.0, 250.0], bounds UNBOUNDED, minima [87.9458], within 1e-5;
    gulf_free: gulf::<99>, start [5.0, 2.5, 0.15], bounds UNBOUNDED, minima [0.0], within 1e-20;
    box_three_free: box_three::<10>, start [0.0, 10.0, 20.0], bounds UNBOUNDED, minima [0.0], within 1e-20;
    powell_singular_free: powell_singular, start [3.0, -1.0, 0.0, 1.0], bounds UNBOUNDED, minima [0.0], within 1e-20;
    wood_free: wood, start [-3.0, -1.0, -3.0, -1.0], bounds UNBOUNDED, minima [0.0], within 1e-20;
    kowalik_osborne_free: kowalik_osborne, start [0.25, 0.39, 0.415, 0.39], bounds UNBOUNDED, minima [3.07505e-4], within 1e-5;
    brown_dennis_free: brown_dennis, start [25.0, 5.0, -5.0, -1.0], bounds UNBOUNDED, minima [85822.2], within 1e-5;
    osborne_1_free: osborne_1, start [0.5, 1.5, -1.0, 0.01, 0.02], bounds UNBOUNDED, minima [5.46489e-5], within 1e-5;
    biggs_free: biggs, start [1.0, 2.0, 1.0, 1.0, 1.0, 1.0], bounds UNBOUNDED, minima [0.0, 5.65565e-3], within 1e-5;
    osborne_2_free: osborne_2, start [1.3, 0.65, 0.65, 0.7, 0.6, 3.0, 5.0, 7.0, 2.0, 4.5, 5.5], bounds UNBOUNDED,
        minima [4.01377e-2], within 1e-5;
    watson_free: watson, start [0.0; 9], bounds UNBOUNDED, minima [1.39976e-6], within 1e-5;
    penalty_1_free: penalty_1, start [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0], bounds UNBOUNDED,
        minima [7.08765e-5], within 1e-5;
    penalty_2_free: penalty_2, start [0.5; 10], bounds UNBOUNDED, minima [2.93660e-4], within 1e-5;
    variably_dimensioned_free: variably_dimensioned, start [0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.0],
        bounds UNBOUNDED, minima [0.0], within 1e-20;
    chebyquad_free: chebyquad, start std::array::from_fn(|j| (j + 1) as f64 / 9.0), bounds UNBOUNDED,
        minima [3.51687e-3], within 1e-5;
}

// Within Gay's bounds.
problems! {
    rosenbrock_bounded: rosenbrock, start [-1.2, 1.0], bounds ([-50.0, 0.0], [0.5, 100.0]), minima [0.25], within 1e-7;
    powell_badly_scaled_bounded: powell_badly_scaled, start [0.0, 1.0], bounds ([0.0, 1.0], [1.0, 9.0]),
        minima [0.15125900e-9], within 1e-5;
    brown_badly_scaled_bounded: brown_badly_scaled, start [1.0, 1.0], bounds ([0.0, 3e-5], [1e6, 100.0]),
        minima [0.784e3], within 1e-7;
    beale_bounded: beale, start [1.0, 1.0], bounds ([0.6, 0.5], [10.0, 100.0]), minima [0.0], within 1e-20;
    helical_valley_bounded: helical_valley, start [-1.0, 0.0, 0.0], bounds ([-100.0, -1.0, -1.0], [0.8, 1.0, 1.0]),
        minima [0.99042212], within 1e-7;
    gaussian_bounded: gaussian, start [0.4, 1.0, 0.0], bounds ([0.398, 1.0, -0.5], [4.2, 2.0, 0.1]),
        minima [0.11279300e-7], within 1e-5;
    // Gay's minimum belongs to three residuals.
    gulf_bounded: gulf::<3>, start [5.0, 2.5, 0.15], bounds ([1e-16, 0.0, 0.0], [10.0, 10.0, 10.0]),
        minima [0.58281431e-4], within 1e-7;
    box_three_bounded: box_three::<3>, start [0.0, 10.0, 20.0], bounds ([0.0, 5.0, 0.0], [2.0, 9.5, 20.0]),
        minima [0.30998153e-5], within 1e-7;
    wood_bounded: wood, start [-3.0, -1.0, -3.0, -1.0], bounds ([-100.0; 4], [0.0, 10.0, 100.0, 100.0]),
        minima [0.15567008e1], within 1e-7;
    brown_dennis_bounded: brown_dennis, start [25.0, 5.0, -5.0, -1.0],
        bounds ([-10.0, 0.0, -100.0, -20.0], [100.0, 15.0, 0.0, 0.2]), minima [0.88860479e5], within 1e-7;
    biggs_bounded: biggs, start [1.0, 2.0, 1.0, 1.0, 1.0, 1.0],
        bounds ([0.0, 0.0, 0.0, 1.0, 0.0, 0.0], [2.0, 8.0, 1.0, 7.0, 5.0, 5.0]), minima [0.53209865e-3], within 1e-7;
    watson_bounded: watson, start [0.0; 9],
        bounds ([-1e-5, 0.0, 0.0, 0.0, 0.0, -3.0, 0.0, -3.0, 0.0], [1e-5, 0.9, 0.1, 1.0, 1.0, 0.0, 4.0, 0.0, 2.0]),
        minima [0.37401397e-1], within 1e-7;
    powell_singular_bounded: powell_singular, start [3.0, -1.0, 0.0, 1.0],
        bounds ([0.1, -20.0, -1.0, -1.0], [100.0, 20.0, 1.0, 50.0]), minima [0.1878196e-3], within 1e-6;
    penalty_1_bounded: penalty_1, start [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0],
        bounds ([0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], [100.0; 10]), minima [0.75625699e1], within 1e-7;
    penalty_2_bounded: penalty_2, start [0.5; 10],
        bounds ([-10.0, 0.1, 0.0, 0.05, 0.0, -10.0, 0.0, 0.2, 0.0, 0.0],
            [50.0, 50.0, 50.0, 50.0, 50.0, 50.0, 50.0, 50.0, 50.0, 0.5]),
        // Published: 2.94426e-4. The lower value is the independent one, as is the next.
        minima [2.943444541e-4], within 1e-8;
    variably_dimensioned_bounded: variably_dimensioned, start [0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.0],
        bounds ([0.0; 10], [10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0, 0.5]), minima [0.33741268], within 1e-7;
    chebyquad_bounded: chebyquad, start std::array::from_fn(|j| (j + 1) as f64 / 9.0),
        bounds ([0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0], [0.04, 0.2, 0.3, 1.0, 1.0, 1.0, 1.0, 1.0]),
        // Published: 3.639985e-3.
        minima [3.592242386e-3], within 1e-8;
}

fn square<const N: usize>(x: Dual<N>) -> Dual<N> {
    x * x
}

/// The numbers 1, 2, .. m.
fn count(m: usize) -> impl Iterator<Item = f64> {
    (1..=m).map(|i| i as f64)
}

// 1 (and 21, extended, with n = 2)
fn rosenbrock(x: &[Dual<2>; 2]) -> Vec<Dual<2>> {
    vec![(x[1] - square(x[0])) * 10.0, -x[0] + 1.0]
}

// 2
fn freudenstein_roth(x: &[Dual<2>; 2]) -> Vec<Dual<2>> {
    vec![x[0] - 13.0 + ((-x[1] + 5.0) * x[1] - 2.0) * x[1], x[0] - 29.0 + ((x[1] + 1.0) * x[1] - 14.0) * x[1]]
}

// 3
fn powell_badly_scaled(x: &[Dual<2>; 2]) -> Vec<Dual<2>> {
    vec![x[0] * x[1] * 1e4 - 1.0, (-x[0]).exp() + (-x[1]).exp() - 1.0001]
}

// 4
fn brown_badly_scaled(x: &[Dual<2>; 2]) -> Vec<Dual<2>> {
    vec![x[0] - 1e6, x[1] - 2e-6, x[0] * x[1] - 2.0]
}

// 5
fn beale(x: &[Dual<2>; 2]) -> Vec<Dual<2>> {
    let residual = |(power, y)| -x[0] * (-x[1].powi(power) + 1.0) + y;
    [(1, 1.5), (2, 2.25), (3, 2.625)].map(residual).to_vec()
}

// 6
fn jennrich_sampson(x: &[Dual<2>; 2]) -> Vec<Dual<2>> {
    count(10).map(|i| -((x[0] * i).exp() + (x[1] * i).exp()) + (2.0 + 2.0 * i)).collect()
}

// 7
fn helical_valley(x: &[Dual<3>; 3]) -> Vec<Dual<3>> {
    let turn = (x[1] / x[0]).atan() / (2.0 * PI) + if x[0].re < 0.0 { 0.5 } else { 0.0 };
    let radius = (square(x[0]) + square(x[1])).sqrt();
    vec![(x[2] - turn * 10.0) * 10.0, (radius - 1.0) * 10.0, x[2]]
}

// 8
fn bard(x: &[Dual<3>; 3]) -> Vec<Dual<3>> {
    let y = [0.14, 0.18, 0.22, 0.25, 0.29, 0.32, 0.35, 0.39, 0.37, 0.58, 0.73, 0.96, 1.34, 2.10, 4.39];
    let residual = |(u, y): (f64, f64)| {
        let v = 16.0 - u;
        -(x[0] + (x[1] * v + x[2] * u.min(v)).recip() * u) + y
    };
    count(15).zip(y).map(residual).collect()
}

// 9
fn gaussian(x: &[Dual<3>; 3]) -> Vec<Dual<3>> {
    let half = [0.0009, 0.0044, 0.0175, 0.0540, 0.1295, 0.2420, 0.3521, 0.3989];
    let y = half.iter().chain(half[..7].iter().rev());
    let residual = |(i, y): (f64, &f64)| x[0] * (-x[1] * square(-x[2] + (8.0 - i) / 2.0) / 2.0).exp() - *y;
    count(15).zip(y).map(residual).collect()
}

// 10
fn meyer(x: &[Dual<3>; 3]) -> Vec<Dual<3>> {
    let y = [34780, 28610, 23650, 19630, 16370, 13720, 11540, 9744, 8261, 7030, 6005, 5147, 4427, 3820, 3307, 2872];
    count(16).zip(y).map(|(i, y)| x[0] * (x[1] / (x[2] + 45.0 + 5.0 * i)).exp() - f64::from(y)).collect()
}

// 11, with the |y - x2| of the published code and of the minimum (50, 25, 1.5); the paper prints a product
fn gulf<const M: usize>(x: &[Dual<3>; 3]) -> Vec<Dual<3>> {
    let residual = |i: f64| {
        let t = i / 100.0;
        let y = 25.0 + (-50.0 * t.ln()).powf(2.0 / 3.0);
        let distance = if x[1].re < y { -x[1] + y } else { x[1] - y };
        (-(distance.ln() * x[2]).exp() / x[0]).exp() - t
    };
    count(M).map(residual).collect()
}

// 12
fn box_three<const M: usize>(x: &[Dual<3>; 3]) -> Vec<Dual<3>> {
    let residual = |i: f64| {
        let t = 0.1 * i;
        (x[0] * -t).exp() - (x[1] * -t).exp() - x[2] * ((-t).exp() - (-10.0 * t).exp())
    };
    count(M).map(residual).collect()
}

// 13 (and 22, extended, with n = 4)
fn powell_singular(x: &[Dual<4>; 4]) -> Vec<Dual<4>> {
    vec![
        x[0] + x[1] * 10.0,
        (x[2] - x[3]) * 5_f64.sqrt(),
        square(x[1] - x[2] * 2.0),
        square(x[0] - x[3]) * 10_f64.sqrt(),
    ]
}

// 14
fn wood(x: &[Dual<4>; 4]) -> Vec<Dual<4>> {
    vec![
        (x[1] - square(x[0])) * 10.0,
        -x[0] + 1.0,
        (x[3] - square(x[2])) * 90_f64.sqrt(),
        -x[2] + 1.0,
        (x[1] + x[3] - 2.0) * 10_f64.sqrt(),
        (x[1] - x[3]) / 10_f64.sqrt(),
    ]
}

// 15
fn kowalik_osborne(x: &[Dual<4>; 4]) -> Vec<Dual<4>> {
    let y = [0.1957, 0.1947, 0.1735, 0.1600, 0.0844, 0.0627, 0.0456, 0.0342, 0.0323, 0.0235, 0.0246];
    let u = [4.0, 2.0, 1.0, 0.5, 0.25, 0.167, 0.125, 0.1, 0.0833, 0.0714, 0.0625];
    let residual = |(y, u): (f64, f64)| -x[0] * (x[1] * u + u * u) / (x[2] * u + x[3] + u * u) + y;
    y.into_iter().zip(u).map(residual).collect()
}

// 16
fn brown_dennis(x: &[Dual<4>; 4]) -> Vec<Dual<4>> {
    let residual = |i: f64| {
        let t = i / 5.0;
        square(x[0] + x[1] * t - t.exp()) + square(x[2] + x[3] * t.sin() - t.cos())
    };
    count(20).map(residual).collect()
}

// 17
fn osborne_1(x: &[Dual<5>; 5]) -> Vec<Dual<5>> {
    let y = [
        0.844, 0.908, 0.932, 0.936, 0.925, 0.908, 0.881, 0.850, 0.818, 0.784, 0.751, 0.718, 0.685, 0.658, 0.628, 0.603,
        0.580, 0.558, 0.538, 0.522, 0.506, 0.490, 0.478, 0.467, 0.457, 0.448, 0.438, 0.431, 0.424, 0.420, 0.414, 0.411,
        0.406,
    ];
    let residual = |(i, y): (f64, f64)| {
        let t = 10.0 * (i - 1.0);
        -(x[0] + x[1] * (x[3] * -t).exp() + x[2] * (x[4] * -t).exp()) + y
    };
    count(33).zip(y).map(residual).collect()
}

// 18
fn biggs(x: &[Dual<6>; 6]) -> Vec<Dual<6>> {
    let residual = |i: f64| {
        let t = 0.1 * i;
        let y = (-t).exp() - 5.0 * (-10.0 * t).exp() + 3.0 * (-4.0 * t).exp();
        x[2] * (x[0] * -t).exp() - x[3] * (x[1] * -t).exp() + x[5] * (x[4] * -t).exp() - y
    };
    count(13).map(residual).collect()
}

// 19
fn osborne_2(x: &[Dual<11>; 11]) -> Vec<Dual<11>> {
    let y = [
        1.366, 1.191, 1.112, 1.013, 0.991, 0.885, 0.831, 0.847, 0.786, 0.725, 0.746, 0.679, 0.608, 0.655, 0.616, 0.606,
        0.602, 0.626, 0.651, 0.724, 0.649, 0.649, 0.694, 0.644, 0.624, 0.661, 0.612, 0.558, 0.533, 0.495, 0.500, 0.423,
        0.395, 0.375, 0.372, 0.391, 0.396, 0.405, 0.428, 0.429, 0.523, 0.562, 0.607, 0.653, 0.672, 0.708, 0.633, 0.668,
        0.645, 0.632, 0.591, 0.559, 0.597, 0.625, 0.739, 0.710, 0.729, 0.720, 0.636, 0.581, 0.428, 0.292, 0.162, 0.098,
        0.054,
    ];
    let residual = |(i, y): (f64, f64)| {
        let t = (i - 1.0) / 10.0;
        let bell =
            |height: usize, centre: usize, sharpness: usize| x[height] * (-square(-x[centre] + t) * x[sharpness]).exp();
        -(x[0] * (x[4] * -t).exp() + bell(1, 8, 5) + bell(2, 9, 6) + bell(3, 10, 7)) + y
    };
    count(65).zip(y).map(residual).collect()
}

// 20, n = 9
fn watson(x: &[Dual<9>; 9]) -> Vec<Dual<9>> {
    let residual = |i: f64| {
        let t: f64 = i / 29.0;
        let (mut slope, mut value) = (Dual::from_re(0.0), Dual::from_re(0.0));
        for (j, &x) in x.iter().enumerate() {
            value += x * t.powi(j as i32);
            if j > 0 {
                slope += x * (j as f64 * t.powi(j as i32 - 1));
            }
        }
        slope - square(value) - 1.0
    };
    count(29).map(residual).chain([x[0], x[1] - square(x[0]) - 1.0]).collect()
}

// 23, n = 10
fn penalty_1(x: &[Dual<10>; 10]) -> Vec<Dual<10>> {
    let length = x.iter().fold(Dual::from_re(0.0), |sum, &x| sum + square(x));
    x.iter().map(|&x| (x - 1.0) * 1e-5_f64.sqrt()).chain([length - 0.25]).collect()
}

// 24, n = 10
fn penalty_2(x: &[Dual<10>; 10]) -> Vec<Dual<10>> {
    let a = 1e-5_f64.sqrt();
    let mut residuals = vec![x[0] - 0.2];
    for i in 1..10 {
        let y = ((i + 1) as f64 / 10.0).exp() + (i as f64 / 10.0).exp();
        residuals.push(((x[i] / 10.0).exp() + (x[i - 1] / 10.0).exp() - y) * a);
    }
    for x in &x[1..] {
        residuals.push(((*x / 10.0).exp() - (-0.1_f64).exp()) * a);
    }
    let weighted = x.iter().enumerate().fold(Dual::from_re(0.0), |sum, (j, &x)| sum + square(x) * (10 - j) as f64);
    residuals.push(weighted - 1.0);
    residuals
}

// 25, n = 10
fn variably_dimensioned(x: &[Dual<10>; 10]) -> Vec<Dual<10>> {
    let sum = x.iter().enumerate().fold(Dual::from_re(0.0), |sum, (j, &x)| sum + (x - 1.0) * (j + 1) as f64);
    x.iter().map(|&x| x - 1.0).chain([sum, square(sum)]).collect()
}

// 35, m = n = 8
fn chebyquad(x: &[Dual<8>; 8]) -> Vec<Dual<8>> {
    let residual = |i: usize| {
        let mean = x.iter().fold(Dual::from_re(0.0), |sum, &x| {
            // Shifted Chebyshev polynomials by their three-term recurrence.
            let argument = x * 2.0 - 1.0;
            let (mut before, mut current) = (Dual::from_re(1.0), argument);
            for _ in 1..i {
                (before, current) = (current, argument * current * 2.0 - before);
            }
            sum + current / 8.0
        });
        let integral = if i.is_multiple_of(2) { -1.0 / ((i * i) as f64 - 1.0) } else { 0.0 };
        mean - integral
    };
    (1..=8).map(residual).collect()
}
