//! The exception of the package, with the diagnostics that it carries.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use serde_json::Value;

pyo3::create_exception!(
    elastogeo,
    Error,
    PyValueError,
    "Why an input cannot be read or a result not be computed; `diagnostics` lists every fault found."
);

/// The exception of an error of the library.
pub fn raised(py: Python<'_>, error: &elastogeo::Error) -> PyErr {
    let found: Vec<Value> = error.explained().iter().map(|found| flat(serde_json::to_value(found))).collect();
    with_diagnostics(py, error.to_string(), &Value::Array(found))
}

/// An exception of one fault that the package found itself.
pub fn fault(py: Python<'_>, message: impl Into<String>, remedy: &str) -> PyErr {
    raised(py, &elastogeo::Error::input(message, remedy))
}

fn with_diagnostics(py: Python<'_>, message: String, diagnostics: &Value) -> PyErr {
    let raised = Error::new_err(message);
    let told = read_json(py, &diagnostics.to_string())
        .and_then(|diagnostics| raised.value(py).setattr("diagnostics", diagnostics));
    told.err().unwrap_or(raised)
}

/// A diagnostic with its place in it, not below it.
fn flat(diagnostic: Result<Value, serde_json::Error>) -> Value {
    let mut diagnostic = diagnostic.unwrap_or_default();
    if let Some(fields) = diagnostic.as_object_mut() {
        let place = fields.shift_remove("at").unwrap_or_default();
        for name in ["file", "line", "column", "excerpt"] {
            fields.insert(name.into(), place.get(name).cloned().unwrap_or_default());
        }
    }
    diagnostic
}

/// A Python value of a JSON text.
pub fn read_json<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (text,))
}
