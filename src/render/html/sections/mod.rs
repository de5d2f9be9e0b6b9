//! Sections of the report, one file each, in their order on the page. A section that has nothing to say is left out.

mod arrows;
mod conditioning;
mod distribution;
mod effects;
mod fuzzy;
mod next;
mod parameters;
mod patterns;
mod stiffness;
mod waterfall;

use serde_json::Value;

use super::data::Report;
use super::page::{Page, Section};

/// All sections.
pub fn all(report: &Report, page: &Page, json: &Value) -> Vec<Section> {
    let sections = [
        waterfall::section(page, json),
        arrows::section(report, page),
        patterns::section(report, page),
        distribution::section(report, page),
        parameters::section(report, page, json),
        conditioning::section(report, page, json),
        effects::section(report, page, json),
        stiffness::section(report, page, json),
        fuzzy::section(report, page),
        next::section(report, page),
    ];
    sections.into_iter().flatten().collect()
}

/// Numbers of a JSON list.
fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().map(|list| list.iter().filter_map(Value::as_f64).collect()).unwrap_or_default()
}

/// Rows of numbers of a JSON list of lists.
fn matrix(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().map(|rows| rows.iter().map(numbers).collect()).unwrap_or_default()
}
