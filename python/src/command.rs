//! The commands.

use std::ffi::OsString;

use pyo3::prelude::*;

use crate::observation::Kind;
use crate::own::own;
use crate::work::{brief, long};

/// Runs a command: its JSON, its text, and whether the result is not to be used.
#[pyfunction]
#[pyo3(signature = (arguments, progress=None, effects=Vec::new(), kinds=Vec::new()))]
pub fn command(
    py: Python<'_>,
    arguments: Vec<String>,
    progress: Option<Bound<'_, PyAny>>,
    effects: Vec<Bound<'_, PyAny>>,
    kinds: Vec<Bound<'_, Kind>>,
) -> PyResult<(String, String, bool)> {
    let own = own(py, &effects, &kinds)?;
    let faults = own.faults.clone();
    let found = long(py, progress.as_ref(), move |watch| elastogeo::cli::call(own.reader(), &arguments, watch));
    let found = faults.first(found)?;
    Ok((found.json.to_string(), found.text, found.failed))
}

/// Runs the command line: the exit status.
#[pyfunction]
pub fn main(py: Python<'_>, arguments: Vec<OsString>) -> PyResult<u8> {
    brief(py, move || Ok(elastogeo::cli::main_from(arguments)))
}

/// Names of the commands.
#[pyfunction]
pub fn command_names() -> Vec<String> {
    elastogeo::cli::command_names()
}

/// Names of the bundled robots.
#[pyfunction]
pub fn bundled_robots() -> Vec<String> {
    elastogeo::files::bundled_robots()
}
