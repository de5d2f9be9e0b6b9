//! Sections of the report, one file each, in their order on the page. A section that has nothing to show is left out.

mod against;
mod arrows;
mod color;
pub mod conditioning;
mod curves;
mod distribution;
mod effects;
mod fuzzy;
mod next;
pub mod parameters;
pub mod parts;
mod patterns;
mod sensitivity;
mod stiffness;
mod waterfall;

use super::page::{Page, Section};
use crate::results::Report;
use crate::review::Review;

/// All sections.
pub fn all(review: &Review, report: &Report, page: &Page) -> Vec<Section> {
    let sections = [
        waterfall::section(report, page),
        arrows::section(review, report, page),
        parts::section(review, report, page),
        patterns::section(review, page),
        distribution::section(review, page),
        parameters::section(report.identify.as_ref(), page),
        against::section(report, page),
        conditioning::section(report.identify.as_ref(), page),
        sensitivity::section(report, page),
        effects::section(report, page),
        stiffness::section(review, report, page),
        fuzzy::section(review.model, page),
        next::section(review, page),
    ];
    sections.into_iter().flatten().collect()
}
