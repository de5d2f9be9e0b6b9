//! Residuals on the robot.

use minijinja::context;

use crate::render::html::data::Report;
use crate::render::html::page::{Page, Section};

pub fn section(report: &Report, page: &Page) -> Option<Section> {
    let stages: Vec<_> = report
        .readings
        .stages
        .iter()
        .map(|stage| context! { key => stage.key, label => Report::stage_label(stage.key) })
        .collect();
    let has_arrows = report.campaign.components() >= 3;
    let html = page.render(
        "arrows.html",
        context! { stages, has_arrows, shots => report.shots.len(), readings => report.campaign.readings.len() },
    );
    Some(Section { id: "arrows", title: "Where the errors are".into(), html })
}
