//! What to measure next.

use minijinja::context;

use crate::render::html::data::Report;
use crate::render::html::page::{Page, Section};

pub fn section(report: &Report, page: &Page) -> Option<Section> {
    let variables: Vec<_> = report
        .model
        .variables
        .iter()
        .map(|variable| {
            let (scale, unit) = if variable.is_angle { ("deg", "deg") } else { ("mm", "mm") };
            context! { name => variable.name.as_str(), scale, unit }
        })
        .collect();
    let html = page.render("next.html", context! { variables, poses => report.next.len() });
    Some(Section { id: "next", title: "What to measure next".into(), html })
}
