//! How much the tool moves by an error of each parameter: mean and greatest over the campaign's configurations.
//!
//! Charts as figures C.21 to C.24 of the IR663 calibration paper; with those of elastic parameters.

use kuva::plot::BarPlot;
use kuva::render::plots::Plot;
use minijinja::context;

use crate::render::html::charts::{BLUE, Frame, ORANGE, chart};
use crate::render::html::page::{Page, Section, safe};
use crate::results::units::{deg, mm};
use crate::results::{MeanMax, ParameterSensitivity, Report};

/// An error of this size is charted: 1 mm, 0.1 deg, and 10 % of an elastic parameter.
const SHARE: f64 = 0.1;
/// Bars of a chart at most: the tallest.
const MOST: usize = 40;

pub fn section(report: &Report, page: &Page) -> Option<Section> {
    let found = &report.sensitivity;
    let of = |is_angle: bool| found.parameters.iter().filter(move |s| (s.per.0 == "deg") == is_angle);
    let by = |s: &ParameterSensitivity, mu: &MeanMax, is_angle: bool, turns: bool| {
        let error = if is_angle { SHARE.to_radians() } else { 1e-3 };
        let shown = |mu: f64| if turns { deg(mu * error) } else { mm(mu * error) };
        (s.name.clone(), shown(mu.mean), shown(mu.max))
    };
    let mut figures = Vec::new();
    for (turns, y) in [(false, "position, mm"), (true, "orientation, deg")] {
        for (is_angle, x) in [(false, "length 1 mm off"), (true, "angle 0.1 deg off")] {
            let bars = of(is_angle).map(|s| by(s, if turns { &s.orientation } else { &s.position }, is_angle, turns));
            figures.extend(bar_chart(bars.collect(), x, y));
        }
    }
    let elastic = found.elastic.iter().filter(|s| s.value != 0.0);
    let bars = elastic.map(|s| (s.name.clone(), mm(SHARE * s.of_value.mean), mm(SHARE * s.of_value.max)));
    let elastic = bar_chart(bars.collect(), "elastic parameter 10 % off", "position, mm");
    if figures.is_empty() && elastic.is_none() {
        return None;
    }
    let figures: Vec<_> = figures.into_iter().map(safe).collect();
    let html = page.render("sensitivity.html", context! { figures, elastic => elastic.map(safe) });
    Some(Section { id: "sensitivity", title: "What an error of each parameter costs".into(), html })
}

/// Bars of name, mean and greatest; `None` where all are zero.
fn bar_chart(mut bars: Vec<(String, f64, f64)>, x: &str, y: &str) -> Option<String> {
    bars.retain(|(_, _, greatest)| *greatest > 1e-9);
    if bars.is_empty() {
        return None;
    }
    bars.sort_by(|a, b| b.1.total_cmp(&a.1));
    bars.truncate(MOST);
    let alt = format!("{y} by a {x}, mean and greatest");
    let frame = Frame { size: [(18.0 * bars.len() as f64 + 120.0).clamp(380.0, 860.0), 300.0], x, y, alt: &alt };
    let mut plot = BarPlot::new().with_legend(vec!["mean", "greatest"]);
    for (name, mean, greatest) in bars {
        plot = plot.with_group(name, vec![(mean, BLUE), (greatest, ORANGE)]);
    }
    let adjust =
        |layout: kuva::render::layout::Layout| layout.with_x_tick_rotate(-90.0).with_y_axis_min(0.0).with_tick_size(9);
    Some(chart(&frame, None, vec![Plot::Bar(plot)], adjust))
}
