//! How well the parameters can be separated: correlations and singular values; and how the fit went, step by step (figure 7 of
//! the IR663 calibration paper).

use kuva::plot::annotations::ReferenceLine;
use kuva::plot::{Heatmap, LinePlot, ScatterPlot};
use kuva::render::plots::Plot;
use minijinja::context;

use super::color::scale;
use crate::render::html::charts::{BLUE, Frame, GREY, chart};
use crate::render::html::page::{Page, Section, safe};
use crate::results::{Identification, Reduction};

pub fn section(identified: Option<&Identification>, page: &Page) -> Option<Section> {
    let found = identified?;
    let values = &found.reduction.singular_values;
    // Where nothing was identified there is nothing to show, least of all on a logarithmic axis.
    if !values.iter().any(|value| *value > 0.0) {
        return None;
    }
    let singular = singular_values(&found.reduction);
    let history = history(&found.history);
    let correlation = &found.correlation;
    let map = (correlation.len() > 1).then(|| correlations(correlation, &found.reduction.kept_parameters));
    let html = page.render(
        "conditioning.html",
        context! { singular => safe(singular), history => history.map(safe), correlation => map.map(safe), large => correlation.len() > 14 },
    );
    Some(Section { id: "conditioning", title: "Identifiability".into(), html })
}

fn singular_values(reduction: &Reduction) -> String {
    let values = &reduction.singular_values;
    let points: Vec<(f64, f64)> =
        values.iter().enumerate().filter(|(_, v)| **v > 0.0).map(|(k, v)| ((k + 1) as f64, *v)).collect();
    let frame = Frame {
        size: [430.0, 300.0],
        x: "number of the singular value",
        y: "singular value (columns scaled)",
        alt: "Singular values of the scaled observation matrix, on a logarithmic axis",
    };
    let threshold = reduction.tolerance.map(|tolerance| tolerance * values.first().copied().unwrap_or(1.0));
    let least = values.iter().copied().chain(threshold).filter(|v| *v > 0.0).fold(f64::INFINITY, f64::min);
    chart(
        &frame,
        None,
        vec![
            Plot::Line(LinePlot::new().with_data(points.clone()).with_color(GREY).with_stroke_width(1.0)),
            Plot::Scatter(ScatterPlot::new().with_data(points).with_color(BLUE).with_size(3.0)),
        ],
        |layout| {
            let layout = layout.with_log_y().with_y_axis_min(0.5 * least);
            match threshold {
                Some(at) => layout.with_reference_line(
                    ReferenceLine::horizontal(at).with_color("var(--red)").with_label("dropped below"),
                ),
                None => layout,
            }
        },
    )
}

/// Costs of the fit, where it took more than one step.
fn history(costs: &[f64]) -> Option<String> {
    let steps: Vec<(f64, f64)> =
        costs.iter().enumerate().filter(|(_, v)| **v > 0.0).map(|(k, v)| ((k + 1) as f64, *v)).collect();
    (steps.len() > 1).then(|| {
        let frame = Frame {
            size: [430.0, 300.0],
            x: "step",
            y: "rms residual over sigma",
            alt: "Root mean square of the residuals over their sigmas after each step of the fit, on a logarithmic axis",
        };
        let line = LinePlot::new().with_data(steps.clone()).with_color(BLUE).with_stroke_width(1.5);
        let dots = ScatterPlot::new().with_data(steps).with_color(BLUE).with_size(3.0);
        chart(&frame, None, vec![Plot::Line(line), Plot::Scatter(dots)], |layout| layout.with_log_y())
    })
}

fn correlations(correlation: &[Vec<f64>], names: &[String]) -> String {
    let side = (correlation.len() as f64 * 14.0 + 190.0).clamp(360.0, 860.0);
    // The first parameter stands at the top, as in the table.
    let mut rows = correlation.to_vec();
    rows.reverse();
    let mut upwards = names.to_vec();
    upwards.reverse();
    let small = if correlation.len() > 30 { 9 } else { 11 };
    chart(
        &Frame {
            size: [side, side - 60.0],
            x: "parameter",
            y: "parameter",
            alt: "Correlations of the identified parameters",
        },
        None,
        vec![Plot::Heatmap(Heatmap::new().with_color_map(scale(&rows)).with_data(rows).with_legend("correlation"))],
        |layout| {
            layout
                .with_x_categories(names.to_vec())
                .with_y_categories(upwards.clone())
                .with_x_tick_rotate(-90.0)
                .with_tick_size(small)
        },
    )
}
