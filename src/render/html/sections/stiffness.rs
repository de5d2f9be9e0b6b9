//! How the robot deflects: over a slice of the workspace, and element by element.

use kuva::plot::{BarPlot, LinePlot, ScatterPlot};
use kuva::render::plots::Plot;
use minijinja::context;

use crate::math::extremes;
use crate::render::html::charts::{BLUE, Frame, chart};
use crate::render::html::page::{Page, Section, safe};
use crate::results::Report;
use crate::review::{Node, Review, Slice};

/// Lines of equal stiffness.
const LEVELS: usize = 5;
/// Every so many nodes has its ellipse.
const EACH: usize = 5;
/// Most elements drawn.
const ELEMENTS: usize = 10;

pub fn section(review: &Review, report: &Report, page: &Page) -> Option<Section> {
    let title = "How the robot deflects".to_string();
    let found = &report.stiffness;
    let map = review.slice.as_ref().and_then(drawn);
    let shares = found.shares.iter().flatten().take(ELEMENTS);
    let shares: Vec<(String, f64)> = shares.map(|(name, share)| (name.clone(), 100.0 * share)).collect();
    let bars = (!shares.is_empty()).then(|| {
        let frame = Frame {
            size: [430.0, 320.0],
            x: "element",
            y: "share of the compliance, %",
            alt: "Share of each element in the strain energy",
        };
        let plot = BarPlot::new().with_bars(shares.clone()).with_color(BLUE);
        chart(&frame, None, vec![Plot::Bar(plot)], |layout| layout.with_x_tick_rotate(-45.0).with_y_axis_min(0.0))
    });
    let html = page.render(
        "stiffness.html",
        context! {
            map => map.as_ref().map(|(svg, ..)| safe(svg.clone())), magnified => map.as_ref().map(|m| m.1.clone()),
            levels => map.as_ref().map(|m| m.2.clone()), swept => found.slice.as_ref().map(|slice| slice.swept.each_ref().map(|s| s.name.clone())),
            bars => bars.map(safe), elements => shares.iter().map(|s| s.0.clone()).collect::<Vec<_>>(),
            rigid => found.slice.is_none() && found.shares.is_none() && review.model.fuzzy.is_none(),
            ruled => review.model.fuzzy.is_some(),
        },
    );
    Some(Section { id: "stiffness", title, html })
}

/// The slice: nodes coloured by their least stiffness, lines of equal stiffness, ellipses; how much these are magnified;
/// and the levels (N/mm).
fn drawn(slice: &Slice) -> Option<(String, String, Vec<String>)> {
    let nodes: Vec<&Node> = slice.nodes.iter().flatten().flatten().collect();
    let mut sizes: Vec<f64> = nodes.iter().map(|node| node.least).collect();
    sizes.sort_by(f64::total_cmp);
    let (low, high) = (*sizes.first()?, *sizes.get((sizes.len() - 1) * 98 / 100)?);
    let share = |least: f64| ((least - low) / (high - low).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    let color = |share: f64| format!("color-mix(in srgb, var(--blue) {:.0}%, var(--warm))", 100.0 * share);
    let span = |k: usize| {
        let [low, high] = extremes(nodes.iter().map(|node| node.at[k]));
        let margin = 0.06 * (high - low) + 1e-3;
        (1e3 * (low - margin), 1e3 * (high + margin))
    };
    let (x, y) = (span(0), span(1));
    let mut plots = vec![Plot::Scatter(
        ScatterPlot::new()
            .with_data(nodes.iter().map(|node| (1e3 * node.at[0], 1e3 * node.at[1])).collect::<Vec<_>>())
            .with_colors(nodes.iter().map(|node| color(share(node.least))).collect::<Vec<_>>())
            .with_size(4.5)
            .with_marker_opacity(0.8),
    )];
    let levels: Vec<f64> = (1..=LEVELS).map(|k| rounded(low + (high - low) * k as f64 / (LEVELS + 1) as f64)).collect();
    for level in &levels {
        for [a, b] in slice.iso(*level) {
            let ends = [a, b].map(|p| (1e3 * p[0], 1e3 * p[1]));
            plots.push(Plot::Line(
                LinePlot::new().with_data(ends.to_vec()).with_color("var(--ink)").with_stroke_width(1.0),
            ));
        }
    }
    // The greatest ellipse drawn is a twentieth of the slice wide.
    let largest = nodes.iter().flat_map(|node| node.ellipse).map(|axis| axis[0].hypot(axis[1])).fold(0.0, f64::max);
    let magnified = rounded(0.05 * (x.1 - x.0).max(y.1 - y.0) / (1e6 * largest).max(f64::MIN_POSITIVE));
    let rows = slice.nodes.iter().step_by(EACH).flat_map(|row| row.iter().step_by(EACH)).flatten();
    for node in rows {
        let point = |k: usize| {
            let (sine, cosine) = (std::f64::consts::TAU * k as f64 / 28.0).sin_cos();
            // mm under 1 kN.
            let offset = |c: usize| 1e6 * magnified * (cosine * node.ellipse[0][c] + sine * node.ellipse[1][c]);
            (1e3 * node.at[0] + offset(0), 1e3 * node.at[1] + offset(1))
        };
        let ring: Vec<(f64, f64)> = (0..=28).map(point).collect();
        plots.push(Plot::Line(LinePlot::new().with_data(ring).with_color("var(--red)").with_stroke_width(1.2)));
    }
    let frame = Frame {
        size: [600.0, 560.0],
        x: "distance from the base's axis, mm",
        y: "height, mm",
        alt: "Least stiffness over a slice of the workspace, with lines of equal stiffness and compliance ellipses",
    };
    let svg = chart(&frame, Some([x, y]), plots, |layout| layout.with_equal_aspect());
    Some((svg, two_digits(magnified), levels.iter().map(|level| two_digits(level * 1e-3)).collect()))
}

/// A number of two digits, without a point where it needs none.
fn two_digits(value: f64) -> String {
    if value >= 10.0 { format!("{value:.0}") } else { format!("{value}") }
}

/// To two digits.
fn rounded(value: f64) -> f64 {
    if !(value > 0.0 && value.is_finite()) {
        return 1.0;
    }
    let size = 10f64.powi(value.log10().floor() as i32 - 1);
    (value / size).round() * size
}
