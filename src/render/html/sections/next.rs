//! What to measure next.

use minijinja::context;

use crate::render::html::page::{Page, Section};
use crate::results::units::shown_unit;
use crate::review::Review;

pub fn section(review: &Review, page: &Page) -> Option<Section> {
    let variables = review.model.variables.iter();
    let variables = variables.map(|v| context! { name => v.name.as_str(), unit => shown_unit(v.is_angle) });
    let html =
        page.render("next.html", context! { variables => variables.collect::<Vec<_>>(), poses => review.next.len() });
    Some(Section { id: "next", title: "What to measure next".into(), html })
}
