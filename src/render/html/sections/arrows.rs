//! Residuals on the robot.

use minijinja::value::Serde;
use minijinja::{Value, context};

use crate::render::html::page::{Page, Section};
use crate::results::Report;
use crate::review::Review;

pub fn section(review: &Review, report: &Report, page: &Page) -> Option<Section> {
    let has_arrows = review.campaign.readings.iter().any(|reading| reading.observes.length_rows() >= 3);
    let (shots, readings) = (review.shots.len(), report.readings.len());
    let html = page
        .render("arrows.html", context! { stages => Value::from(Serde(&report.stages)), has_arrows, shots, readings });
    Some(Section { id: "arrows", title: "Where the errors are".into(), html })
}
