//! Arrays of floats from and to numpy.

use numpy::ndarray::{ArrayD, IxDyn};
use numpy::{AllowTypeChange, PyArrayDyn, PyArrayLikeDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::error::fault;

/// Rows of numbers, and whether it was a single one: an array without the first axis.
pub struct Rows {
    pub values: Vec<f64>,
    pub is_single: bool,
}

/// Finite numbers of an array, or of what numpy makes one of, of shape (n, `width`) or (`width`,).
pub fn rows(py: Python<'_>, given: &Bound<'_, PyAny>, width: usize, what: &str) -> PyResult<Rows> {
    let given: PyArrayLikeDyn<'_, f64, AllowTypeChange> = given.extract()?;
    let is_single = match *given.shape() {
        [own] if own == width => true,
        [_, own] if own == width => false,
        _ => return Err(misshapen(what, given.shape(), &format!("(n, {width}) or ({width},)"))),
    };
    let values = finite(py, &given, width, what)?;
    Ok(Rows { values, is_single })
}

/// Finite numbers of an array of shape (`width`,).
pub fn vector(py: Python<'_>, given: &Bound<'_, PyAny>, width: usize, what: &str) -> PyResult<Vec<f64>> {
    let given: PyArrayLikeDyn<'_, f64, AllowTypeChange> = given.extract()?;
    if *given.shape() != [width] {
        return Err(misshapen(what, given.shape(), &format!("({width},)")));
    }
    finite(py, &given, 1, what)
}

fn finite(
    py: Python<'_>,
    given: &PyArrayLikeDyn<'_, f64, AllowTypeChange>,
    width: usize,
    what: &str,
) -> PyResult<Vec<f64>> {
    // In the order of rows, however they lie in memory.
    let given = given.as_array();
    let values: Vec<f64> = given.as_slice().map_or_else(|| given.iter().copied().collect(), <[f64]>::to_vec);
    if let Some(at) = values.iter().position(|value| !value.is_finite()) {
        let message = format!("{what}: row {} has a number that is not finite", at / width.max(1));
        return Err(fault(py, message, "leave such rows out"));
    }
    Ok(values)
}

fn misshapen(what: &str, shape: &[usize], expected: &str) -> PyErr {
    let sizes: Vec<String> = shape.iter().map(ToString::to_string).collect();
    let comma = if shape.len() == 1 { "," } else { "" };
    PyValueError::new_err(format!("{what}: an array of shape ({}{comma}); expected {expected}", sizes.join(", ")))
}

/// An array of these numbers, row-major.
pub fn array<'py>(py: Python<'py>, values: Vec<f64>, shape: &[usize]) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let made = ArrayD::from_shape_vec(IxDyn(shape), values);
    Ok(PyArrayDyn::from_owned_array(py, made.map_err(|error| PyValueError::new_err(error.to_string()))?))
}

/// An array of what was computed for each row, each of `shape`.
pub fn of_rows<'py>(
    py: Python<'py>,
    values: Vec<f64>,
    is_single: bool,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let size = shape.iter().product::<usize>().max(1);
    let count = [values.len() / size];
    array(py, values, &[if is_single { &[] } else { &count[..] }, shape].concat())
}
