//! Causes, what they look like, what was tried and not taken, and where the gap lies.

use std::sync::Arc;

use kuva::plot::{BarPlot, ColorMap, Heatmap};
use kuva::render::plots::Plot;
use minijinja::context;
use serde_json::Value;

use super::matrix;
use crate::render::html::charts::{BLUE, Frame, chart};
use crate::render::html::data::Report;
use crate::render::html::page::{Page, Section, safe};

/// Most sites drawn.
const SITES: usize = 12;

/// Colours from -1 (orange) over 0 (the paper) to 1 (blue), whatever the range of the numbers drawn: the chart hands on
/// where in it a number lies.
pub fn scale(rows: &[Vec<f64>]) -> ColorMap {
    let all = || rows.iter().flatten().copied();
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
    ColorMap::Custom(Arc::new(move |share: f64| {
        let value = (low + share * (high - low)).clamp(-1.0, 1.0);
        let color = if value < 0.0 { "var(--orange)" } else { "var(--blue)" };
        format!("color-mix(in srgb, {color} {:.0}%, var(--paper))", 100.0 * value.abs())
    }))
}

pub fn section(_report: &Report, page: &Page, json: &Value) -> Option<Section> {
    let found = &json["diagnose"];
    let alike = &found["look_alikes"];
    let names: Vec<String> = alike["hypotheses"]
        .as_array()?
        .iter()
        .map(|h| format!("{} {}", h["effect"].as_str().unwrap_or(""), h["site"].as_str().unwrap_or("")))
        .collect();
    let mut rows = matrix(&alike["overlap"]);
    rows.reverse();
    let mut upwards = names.clone();
    upwards.reverse();
    let side = (names.len() as f64 * 22.0 + 260.0).clamp(420.0, 760.0);
    let matrix = (names.len() > 1).then(|| {
        chart(
            &Frame {
                size: [side + 60.0, side],
                x: "can be imitated by",
                y: "what this one changes",
                alt: "Look-alike matrix of effects",
            },
            None,
            vec![Plot::Heatmap(Heatmap::new().with_color_map(scale(&rows)).with_data(rows).with_legend("share"))],
            |layout| {
                layout.with_x_categories(names.clone()).with_y_categories(upwards.clone()).with_x_tick_rotate(-90.0)
            },
        )
    });
    let sites: Vec<(String, f64)> = found["where"]["sites"]
        .as_array()
        .map(Vec::as_slice)
        .unwrap_or_default()
        .iter()
        .take(SITES)
        .map(|s| (s["site"].as_str().unwrap_or("").to_string(), 100.0 * s["share"].as_f64().unwrap_or(0.0)))
        .collect();
    let located = (!sites.is_empty()).then(|| {
        let frame = Frame {
            size: [560.0, 280.0],
            x: "site of a free error",
            y: "share of the gap, %",
            alt: "Share of the gap that a free error at each site could carry",
        };
        let plot = BarPlot::new().with_bars(sites.clone()).with_color(BLUE);
        chart(&frame, None, vec![Plot::Bar(plot)], |layout| layout.with_x_tick_rotate(-45.0).with_y_axis_min(0.0))
    });
    let html = page.render(
        "effects.html",
        context! { matrix => matrix.map(safe), located => located.map(safe), verdict => found["verdict"].as_str() },
    );
    Some(Section { id: "effects", title: "Effects: causes, look-alikes, and what was not taken".into(), html })
}
