//! Parameters: value, interval, bound, what was dropped and merged into what.

use minijinja::context;
use serde_json::Value;

use crate::render::html::data::Report;
use crate::render::html::page::{Page, Section};

/// Factors below this are not told.
const LEAST: f64 = 5e-4;

pub fn section(report: &Report, page: &Page, json: &Value) -> Option<Section> {
    let title = "Parameters".to_string();
    let found = json["identify"].as_object();
    let Some(found) = found else {
        let html = page.render("parameters.html", context! { none => true });
        return Some(Section { id: "parameters", title, html });
    };
    let empty = serde_json::Map::new();
    let combinations = found["combinations"].as_object().unwrap_or(&empty);
    let factor_of = |terms: &Value, name: &str| terms.get(name).and_then(Value::as_f64).filter(|f| f.abs() >= LEAST);
    // What each dropped parameter went into, the greatest factors first.
    let dropped: Vec<_> = found["dropped"]
        .as_array()
        .map(Vec::as_slice)
        .unwrap_or_default()
        .iter()
        .map(|entry| {
            let name = entry["name"].as_str().unwrap_or("");
            let mut into: Vec<(&str, f64)> = combinations
                .iter()
                .filter_map(|(keeper, terms)| Some((keeper.as_str(), factor_of(terms, name)?)))
                .collect();
            into.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
            let into: Vec<_> = into
                .into_iter()
                .take(6)
                .map(|(keeper, _)| context! { keeper, pointer => pointer(keeper, name) })
                .collect();
            context! { name, why => entry["why"].as_str().unwrap_or(""), into }
        })
        .collect();
    let absorbed = |name: &str| -> Vec<String> {
        let terms = combinations.get(name).and_then(Value::as_object);
        let terms = terms.into_iter().flatten();
        terms.filter(|(_, f)| f.as_f64().is_some_and(|f| f.abs() >= LEAST)).map(|(other, _)| other.clone()).collect()
    };
    let rows: Vec<_> = found["parameters"]
        .as_array()
        .map(Vec::as_slice)
        .unwrap_or_default()
        .iter()
        .enumerate()
        .filter(|(_, p)| p["identifiable"] == true)
        .map(|(index, p)| {
            let name = p["name"].as_str().unwrap_or("");
            let length = matches!(p["unit"].as_str(), Some("mm" | "deg"));
            context! { index, name, unit => p["unit"].as_str().unwrap_or(""), length, at_bound => p["at_bound"] == true,
            stands_for => absorbed(name) }
        })
        .collect();
    let equivalences = found["equivalences"].as_array().map_or(0, Vec::len);
    let held = report.campaign.components() > 0;
    let html = page.render("parameters.html", context! { none => false, rows, dropped, equivalences, held });
    Some(Section { id: "parameters", title, html })
}

/// JSON pointer of a factor.
fn pointer(keeper: &str, name: &str) -> String {
    let step = |name: &str| name.replace('~', "~0").replace('/', "~1");
    format!("/identify/combinations/{}/{}", step(keeper), step(name))
}
