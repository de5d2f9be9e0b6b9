//! Arrays of floats from and to bytes.

use pyo3::prelude::*;
use pyo3::types::PyByteArray;

use crate::error::fault;

/// Rows of `width` floats.
pub fn rows(py: Python<'_>, bytes: &[u8], width: usize, what: &str) -> PyResult<Vec<f64>> {
    let values: Vec<f64> =
        bytes.chunks_exact(8).map(|chunk| chunk.try_into().map_or(f64::NAN, f64::from_ne_bytes)).collect();
    if width == 0 || !bytes.len().is_multiple_of(8) || !values.len().is_multiple_of(width) {
        let message = format!("{what}: {} numbers are no rows of {width}", values.len());
        return Err(fault(py, message, &format!("give an array of shape (n, {width})")));
    }
    if let Some(at) = values.iter().position(|value| !value.is_finite()) {
        let message = format!("{what}: row {} has a number that is not finite", at / width);
        return Err(fault(py, message, "leave such rows out"));
    }
    Ok(values)
}

/// The bytes of floats, writable so that the array made of them is.
pub fn bytes<'py>(py: Python<'py>, values: &[f64]) -> PyResult<Bound<'py, PyByteArray>> {
    PyByteArray::new_with(py, values.len() * 8, |out| {
        for (out, value) in out.chunks_exact_mut(8).zip(values) {
            out.copy_from_slice(&value.to_ne_bytes());
        }
        Ok(())
    })
}
