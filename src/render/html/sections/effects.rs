//! Causes, what they look like, what was tried and not taken, and where the gap lies.

use kuva::plot::{BarPlot, Heatmap};
use kuva::render::plots::Plot;
use minijinja::value::Serde;
use minijinja::{Value, context};

use super::color::scale;
use super::curves::charts;
use crate::diagnosis::Curve;
use crate::render::html::charts::{BLUE, Frame, chart};
use crate::render::html::page::{Page, Section, safe};
use crate::results::{Cause, Report};

/// Most sites drawn.
const SITES: usize = 12;

pub fn section(report: &Report, page: &Page) -> Option<Section> {
    let found = &report.diagnose;
    let alike = &found.look_alikes;
    let names: Vec<String> = alike.hypotheses.iter().map(|h| format!("{} {}", h.effect, h.site)).collect();
    let mut rows = alike.overlap.clone();
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
    let sites = found.location.sites.iter().take(SITES).map(|s| (s.site.clone(), 100.0 * s.share));
    let sites: Vec<(String, f64)> = sites.collect();
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
    let curves: Vec<Vec<Value>> =
        found.causes.iter().map(|cause| charts(cause).into_iter().map(safe).collect()).collect();
    let is_certain = |cause: &Cause| cause.curve.as_ref().is_none_or(Curve::is_certain);
    let certain: Vec<bool> = found.causes.iter().map(is_certain).collect();
    let html = page.render(
        "effects.html",
        context! { curves, certain, matrix => matrix.map(safe), located => located.map(safe), verdict => Value::from(Serde(&found.verdict)) },
    );
    Some(Section { id: "effects", title: "Effects: causes, look-alikes, and what was not taken".into(), html })
}
