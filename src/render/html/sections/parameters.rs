//! Parameters: value, interval, bound, what was dropped and merged into what.

use minijinja::context;

use crate::render::html::page::{Page, Section};
use crate::results::{Dropped, Identification, ParameterEstimate};

/// Factors (SI) below this are not shown.
const LEAST: f64 = 5e-4;
/// Most parameters shown into which a dropped one is merged.
const MOST: usize = 6;

pub fn section(identified: Option<&Identification>, page: &Page) -> Option<Section> {
    let title = "Parameters".to_string();
    let Some(found) = identified else {
        let html = page.render("parameters.html", context! { none => true });
        return Some(Section { id: "parameters", title, html });
    };
    let combinations = &found.reduction.combinations;
    let is_shown = |factor: f64| factor.abs() >= LEAST;
    // What each dropped parameter went into, the greatest factors first.
    let dropped = |dropped: &Dropped| {
        let terms = combinations.iter().filter_map(|(keeper, terms)| Some((keeper, *terms.get(&dropped.name)?)));
        let mut into: Vec<(&String, f64)> = terms.filter(|(_, factor)| is_shown(*factor)).collect();
        into.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
        let keeper = |(keeper, _): (&String, f64)| context! { keeper => keeper.as_str(), pointer => pointer(keeper, &dropped.name) };
        let into: Vec<_> = into.into_iter().take(MOST).map(keeper).collect();
        let at = found.parameters.iter().position(|own| own.name == dropped.name && own.is_held_elsewhere());
        let unit = at.map(|at| found.parameters[at].unit);
        context! { name => dropped.name.as_str(), why => dropped.why.to_string(), into, at, unit }
    };
    let absorbed = |name: &str| -> Vec<String> {
        let terms = combinations.get(name).into_iter().flatten();
        terms.filter(|(_, factor)| is_shown(**factor)).map(|(other, _)| other.clone()).collect()
    };
    let row = |(index, p): (usize, &ParameterEstimate)| {
        let length = matches!(p.unit, "mm" | "deg");
        let stands_for = absorbed(&p.name);
        context! { index, name => p.name.as_str(), unit => p.unit, length, nominal => p.nominal.is_some(), at_bound => p.at_bound, stands_for }
    };
    let rows: Vec<_> = found.parameters.iter().enumerate().filter(|(_, p)| p.identifiable).map(row).collect();
    let dropped: Vec<_> = found.reduction.dropped.iter().map(dropped).collect();
    let equivalences = found.equivalences.len();
    let html = page.render("parameters.html", context! { none => false, rows, dropped, equivalences });
    Some(Section { id: "parameters", title, html })
}

/// JSON pointer of a factor.
fn pointer(keeper: &str, name: &str) -> String {
    let step = |name: &str| name.replace('~', "~0").replace('/', "~1");
    format!("/identify/combinations/{}/{}", step(keeper), step(name))
}
