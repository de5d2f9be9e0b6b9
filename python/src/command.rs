//! The commands.

use std::ffi::OsString;

use pyo3::prelude::*;

use crate::effect::{Own, catalogue};
use crate::work::{brief, long};

/// Runs a command: its JSON, its text, and whether the result is not to be used.
#[pyfunction]
#[pyo3(signature = (arguments, progress=None, effects=Vec::new()))]
pub fn command(
    py: Python<'_>,
    arguments: Vec<String>,
    progress: Option<Bound<'_, PyAny>>,
    effects: Vec<Bound<'_, PyAny>>,
) -> PyResult<(String, String, bool)> {
    let Own { catalogue, faults } = catalogue(py, &effects)?;
    let found = long(py, progress.as_ref(), move |watch| elastogeo::cli::call(catalogue, &arguments, watch));
    let found = faults.first(found)?;
    Ok((found.json.to_string(), found.text, found.failed))
}

/// Runs the command line: the exit status.
#[pyfunction]
pub fn main(py: Python<'_>, arguments: Vec<OsString>) -> PyResult<u8> {
    brief(py, move || Ok(elastogeo::cli::main_from(arguments)))
}

/// Names of the bundled robots.
#[pyfunction]
pub fn bundled_robots() -> Vec<String> {
    elastogeo::files::bundled_robots()
}
