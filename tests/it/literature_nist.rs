//! Nonlinear regression against the certified values of the NIST Statistical Reference Datasets.
//!
//! <https://www.itl.nist.gov/div898/strd/nls/nls_main.shtml>; the files and how they are read: `tests/data/nist/README.md`.
//! Every problem is solved from both certified starts with default settings. Digits are log relative errors,
//! `-log10(|found - certified| / |certified|)`, the worst over the entries, capped at the 11 digits that are certified.

use std::f64::consts::PI;

use elastogeo::least_squares::{Bounds, Settings, Solution, minimize};
use nalgebra::DMatrix;
use num_dual::DualNum;

use crate::dual::{Dual, Smooth};

struct Certified {
    starts: [Vec<f64>; 2],
    parameters: Vec<f64>,
    deviations: Vec<f64>,
    sum_of_squares: f64,
    /// Response first, then the predictors.
    rows: Vec<Vec<f64>>,
}

/// Reads a data set as NIST prints it: `bK = start1 start2 value deviation`, the residual sum of squares, and the numbers
/// after the last line that begins with `Data:`.
fn read(name: &str) -> Certified {
    let path = format!("{}/tests/data/nist/{name}.dat", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let numbers = |line: &str| -> Vec<f64> { line.split_whitespace().map(|word| word.parse().unwrap()).collect() };
    let mut set = Certified {
        starts: [vec![], vec![]],
        parameters: vec![],
        deviations: vec![],
        sum_of_squares: f64::NAN,
        rows: vec![],
    };
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    for line in &lines {
        if let Some((name, values)) = line.split_once('=')
            && name.trim().strip_prefix('b').is_some_and(|index| index.trim().parse::<usize>().is_ok())
        {
            let values = numbers(values);
            set.starts[0].push(values[0]);
            set.starts[1].push(values[1]);
            set.parameters.push(values[2]);
            set.deviations.push(values[3]);
        }
        if let Some(value) = line.strip_prefix("Residual Sum of Squares:") {
            set.sum_of_squares = numbers(value)[0];
        }
    }
    let header = lines.iter().rposition(|line| line.starts_with("Data:")).unwrap();
    set.rows = lines[header + 1..].iter().filter(|line| !line.is_empty()).map(|line| numbers(line)).collect();
    let announced = lines.iter().find_map(|line| line.strip_prefix("Number of Observations:")).unwrap();
    assert_eq!(set.rows.len(), announced.trim().parse::<usize>().unwrap(), "{name}");
    set
}

fn digits(found: impl IntoIterator<Item = f64>, certified: &[f64]) -> f64 {
    let lre = |(found, certified): (f64, &f64)| -((found - certified) / certified).abs().log10();
    found.into_iter().zip(certified).map(lre).fold(11.0, f64::min)
}

/// Standard deviations of the parameters, `sqrt(s^2 diag((J'J)^-1))`, by QR of the Jacobian with unit columns.
fn deviations(solution: &Solution) -> Vec<f64> {
    let (m, n) = solution.jacobian.shape();
    let norms: Vec<f64> = solution.jacobian.column_iter().map(|column| column.norm()).collect();
    let scaled = DMatrix::from_fn(m, n, |i, j| solution.jacobian[(i, j)] / norms[j]);
    let inverse = scaled.qr().r().try_inverse().expect("full rank");
    let variance = 2.0 * solution.cost / (m - n) as f64;
    (0..n).map(|j| variance.sqrt() * inverse.row(j).norm() / norms[j]).collect()
}

/// Solves from both starts; the digits of parameters, deviations and sum of squares must reach `required`.
fn check<const N: usize>(name: &str, required: [f64; 3], model: fn(&[Dual<N>; N], &[f64]) -> Dual<N>) {
    let set = read(name);
    for (number, start) in set.starts.iter().enumerate() {
        let problem = Smooth {
            residuals: set.rows.len(),
            function: |b: &[Dual<N>; N]| {
                let residual = |row: &Vec<f64>| {
                    // Nelson's model is of the logarithm of the response.
                    let response = if name == "Nelson" { row[0].ln() } else { row[0] };
                    model(b, &row[1..]) - response
                };
                set.rows.iter().map(residual).collect()
            },
        };
        let solution = minimize(&problem, start, &Bounds::none(N), &Settings::default()).unwrap();
        let reached = [
            digits(solution.x.iter().copied(), &set.parameters),
            digits(deviations(&solution), &set.deviations),
            digits([2.0 * solution.cost], &[set.sum_of_squares]),
        ];
        println!(
            "{name:9} start {}: {:5.1} {:5.1} {:5.1} digits, {:3} steps, {:?}",
            number + 1,
            reached[0],
            reached[1],
            reached[2],
            solution.iterations,
            solution.status
        );
        assert!(solution.status.converged(), "{name} from start {}: {:?}", number + 1, solution.status);
        for (reached, required) in reached.iter().zip(required) {
            assert!(*reached >= required, "{name} from start {}: {reached:.2} digits, {required} required", number + 1);
        }
    }
}

macro_rules! problems {
    ($($test:ident: $name:literal, $required:expr, $parameters:literal, $model:expr;)*) => {
        $(#[test]
        fn $test() {
            check::<$parameters>($name, $required, $model);
        })*
    };
}

fn gauss(b: &[Dual<8>; 8], x: &[f64]) -> Dual<8> {
    let bell = |height: Dual<8>, centre: Dual<8>, width: Dual<8>| height * (-((-centre + x[0]) / width).powi(2)).exp();
    b[0] * (-b[1] * x[0]).exp() + bell(b[2], b[3], b[4]) + bell(b[5], b[6], b[7])
}

fn lanczos(b: &[Dual<6>; 6], x: &[f64]) -> Dual<6> {
    b[0] * (-b[1] * x[0]).exp() + b[2] * (-b[3] * x[0]).exp() + b[4] * (-b[5] * x[0]).exp()
}

fn cubic_over_cubic(b: &[Dual<7>; 7], x: &[f64]) -> Dual<7> {
    let x = x[0];
    (b[0] + b[1] * x + b[2] * x.powi(2) + b[3] * x.powi(3)) / (b[4] * x + b[5] * x.powi(2) + b[6] * x.powi(3) + 1.0)
}

fn chwirut(b: &[Dual<3>; 3], x: &[f64]) -> Dual<3> {
    (-b[0] * x[0]).exp() / (b[1] + b[2] * x[0])
}

/// Digits of parameters, deviations and sum of squares.
const ALL: [f64; 3] = [6.0, 6.0, 10.0];
/// The residuals of Lanczos1 are 1e-13 for data of size 1, so that double precision leaves them three digits and their
/// sum of squares, on which the deviations depend, as many.
const LANCZOS1: [f64; 3] = [10.0, 2.0, 2.0];

problems! {
    // Lower level of difficulty
    misra1a: "Misra1a", ALL, 2, |b, x| b[0] * (-(-b[1] * x[0]).exp() + 1.0);
    chwirut2: "Chwirut2", ALL, 3, chwirut;
    chwirut1: "Chwirut1", ALL, 3, chwirut;
    lanczos3: "Lanczos3", ALL, 6, lanczos;
    gauss1: "Gauss1", ALL, 8, gauss;
    gauss2: "Gauss2", ALL, 8, gauss;
    dan_wood: "DanWood", ALL, 2, |b, x| b[0] * (b[1] * x[0].ln()).exp();
    misra1b: "Misra1b", ALL, 2, |b, x| b[0] * (-(b[1] * (x[0] / 2.0) + 1.0).powi(-2) + 1.0);
    // Average level of difficulty
    kirby2: "Kirby2", ALL, 5, |b, x| {
        let x = x[0];
        (b[0] + b[1] * x + b[2] * x * x) / (b[3] * x + b[4] * x * x + 1.0)
    };
    hahn1: "Hahn1", ALL, 7, cubic_over_cubic;
    nelson: "Nelson", ALL, 3, |b, x| b[0] - b[1] * x[0] * (-b[2] * x[1]).exp();
    mgh17: "MGH17", ALL, 5, |b, x| b[0] + b[1] * (-b[3] * x[0]).exp() + b[2] * (-b[4] * x[0]).exp();
    lanczos1: "Lanczos1", LANCZOS1, 6, lanczos;
    lanczos2: "Lanczos2", ALL, 6, lanczos;
    gauss3: "Gauss3", ALL, 8, gauss;
    misra1c: "Misra1c", ALL, 2, |b, x| b[0] * (-(b[1] * (2.0 * x[0]) + 1.0).sqrt().recip() + 1.0);
    misra1d: "Misra1d", ALL, 2, |b, x| b[0] * b[1] * x[0] / (b[1] * x[0] + 1.0);
    roszman1: "Roszman1", ALL, 4, |b, x| b[0] - b[1] * x[0] - (b[2] / (-b[3] + x[0])).atan() / PI;
    enso: "ENSO", ALL, 9, |b, x| {
        let annual = 2.0 * PI * x[0] / 12.0;
        let turns = |period: Dual<9>| period.recip() * (2.0 * PI * x[0]);
        b[0] + b[1] * annual.cos() + b[2] * annual.sin()
            + b[4] * turns(b[3]).cos() + b[5] * turns(b[3]).sin()
            + b[7] * turns(b[6]).cos() + b[8] * turns(b[6]).sin()
    };
    // Higher level of difficulty
    mgh09: "MGH09", ALL, 4, |b, x| b[0] * (b[1] * x[0] + x[0] * x[0]) / (b[2] * x[0] + b[3] + x[0] * x[0]);
    thurber: "Thurber", ALL, 7, cubic_over_cubic;
    box_bod: "BoxBOD", ALL, 2, |b, x| b[0] * (-(-b[1] * x[0]).exp() + 1.0);
    rat42: "Rat42", ALL, 3, |b, x| b[0] / ((b[1] - b[2] * x[0]).exp() + 1.0);
    mgh10: "MGH10", ALL, 3, |b, x| b[0] * (b[1] / (b[2] + x[0])).exp();
    eckerle4: "Eckerle4", ALL, 3, |b, x| b[0] / b[1] * (((-b[2] + x[0]) / b[1]).powi(2) * -0.5).exp();
    rat43: "Rat43", ALL, 4, |b, x| b[0] / ((b[1] - b[2] * x[0]).exp() + 1.0).powd(b[3].recip());
    bennett5: "Bennett5", ALL, 3, |b, x| b[0] * (b[1] + x[0]).powd(-b[2].recip());
}
