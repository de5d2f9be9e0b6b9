//! The page of a robot over time: control charts.

use kuva::plot::{LinePlot, ScatterPlot};
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use minijinja::context;

use super::charts::{BLUE, Frame, GREY, ORANGE, chart};
use super::page::{Page, inert, safe};
use crate::Error;
use crate::results::{Track, TrackedCourse, TrackedParameter};

/// Size of a chart.
const SIZE: [f64; 2] = [430.0, 280.0];
/// Most parameters charted: those that changed, then those that are farthest from the first check.
const CHARTED: usize = 12;
/// Parameters charted where none has changed.
const QUIET: usize = 4;

/// Most ticks of checks on an axis.
const TICKS: usize = 12;
/// Room above the highest value, as a part of it: a dot has a size.
const ROOM: f64 = 0.08;

/// The page of `track`.
///
/// # Errors
/// A result that cannot be written as JSON.
pub fn track_page(found: &Track) -> Result<String, Error> {
    let page = Page::new(&serde_json::to_value(found)?);
    let parameters: Vec<_> = charted(found)
        .into_iter()
        .map(|(index, parameter)| {
            context! { index, chart => safe(over_checks(parameter)), name => &parameter.name, meaning => &parameter.meaning, changed => parameter.changed }
        })
        .collect();
    let statistic = safe(statistic(found));
    let held_out = held_out(found).map(safe);
    let version = env!("CARGO_PKG_VERSION");
    Ok(inert(&page.render("track.html", context! { statistic, held_out, parameters, version })))
}

/// An axis of so many checks, with ticks at whole ones.
fn checks(layout: Layout, count: usize) -> Layout {
    let step = count.div_ceil(TICKS).max(1) as f64;
    layout.with_x_axis_min(0.5).with_x_axis_max(count as f64 + 0.5).with_x_tick_step(step)
}

/// The same with values from 0 on.
fn from_zero(layout: Layout, count: usize, values: impl Iterator<Item = f64>) -> Layout {
    let most = values.fold(0.0, f64::max);
    checks(layout, count).with_y_axis_min(0.0).with_y_axis_max(if most > 0.0 { most * (1.0 + ROOM) } else { 1.0 })
}

/// The statistic of each check with its limit.
fn statistic(found: &Track) -> String {
    let points = |alarm: bool| -> Vec<(f64, f64)> {
        let checks = found.checks.iter().enumerate().filter(|(_, check)| check.alarm == alarm);
        checks.filter_map(|(k, check)| Some(((k + 1) as f64, check.statistic?))).collect()
    };
    let limit: Vec<(f64, f64)> =
        found.checks.iter().enumerate().filter_map(|(k, check)| Some(((k + 1) as f64, check.limit?))).collect();
    let frame = Frame {
        size: SIZE,
        x: "check",
        y: "T2",
        alt: "T2 of each check against the checks before it, with the limit that a single test has",
    };
    let plots = vec![
        Plot::Line(LinePlot::new().with_data(limit).with_color("var(--red)").with_stroke_width(1.5)),
        Plot::Scatter(ScatterPlot::new().with_data(points(false)).with_color(BLUE).with_size(4.0)),
        Plot::Scatter(ScatterPlot::new().with_data(points(true)).with_color(ORANGE).with_size(6.0)),
    ];
    let values = || found.checks.iter().flat_map(|check| [check.statistic, check.limit]).flatten();
    chart(&frame, None, plots, |layout| from_zero(layout, found.checks.len(), values()))
}

/// Error of readings held out at each check; nothing where none are.
fn held_out(found: &Track) -> Option<String> {
    let points: Vec<(f64, f64)> =
        found.checks.iter().enumerate().filter_map(|(k, check)| Some(((k + 1) as f64, check.check_rms?))).collect();
    let frame =
        Frame { size: SIZE, x: "check", y: "held-out rms, mm", alt: "Error of readings held out at each check" };
    let plots = vec![
        Plot::Line(LinePlot::new().with_data(points.clone()).with_color(GREY).with_stroke_width(1.0)),
        Plot::Scatter(ScatterPlot::new().with_data(points.clone()).with_color(BLUE).with_size(4.0)),
    ];
    let values = || points.iter().map(|(_, value)| *value);
    let count = found.checks.len();
    (!points.is_empty()).then(|| chart(&frame, None, plots, |layout| from_zero(layout, count, values())))
}

/// Parameters to be charted, with their places in the list.
fn charted(found: &Track) -> Vec<(usize, &TrackedParameter)> {
    let size = |parameter: &TrackedParameter| {
        parameter
            .values
            .iter()
            .map(|value| value.difference.abs() / value.ci95.max(f64::MIN_POSITIVE))
            .fold(0.0, f64::max)
    };
    let mut all: Vec<(usize, &TrackedParameter)> = found.parameters.iter().enumerate().collect();
    all.sort_by(|(_, a), (_, b)| b.changed.cmp(&a.changed).then(size(b).total_cmp(&size(a))));
    let changed = all.iter().filter(|(_, parameter)| parameter.changed).count();
    all.truncate(if changed > 0 { changed.min(CHARTED) } else { QUIET });
    all
}

/// A parameter over the checks, with its intervals and the levels and lines that were reported.
fn over_checks(parameter: &TrackedParameter) -> String {
    let points: Vec<(f64, f64)> =
        parameter.values.iter().enumerate().map(|(k, value)| ((k + 1) as f64, value.difference)).collect();
    let widths: Vec<f64> = parameter.values.iter().map(|value| value.ci95).collect();
    let color = if parameter.changed { ORANGE } else { BLUE };
    let y = format!("difference, {}", parameter.unit);
    let alt = format!("{} over the checks with 95 % intervals", parameter.name);
    let frame = Frame { size: SIZE, x: "check", y: &y, alt: &alt };
    let dots = ScatterPlot::new().with_data(points).with_y_err(widths).with_color(color).with_size(4.0);
    let course = |course: &TrackedCourse| {
        // A level of one check is as long as half the way to its neighbours.
        let points: Vec<(f64, f64)> = match course.values[..] {
            [one] => [0.6, 1.4].map(|x| (course.from as f64 + x, one)).to_vec(),
            _ => course.values.iter().enumerate().map(|(k, value)| ((course.from + k + 1) as f64, *value)).collect(),
        };
        Plot::Line(LinePlot::new().with_data(points).with_color(GREY).with_stroke_width(1.5))
    };
    let plots: Vec<Plot> = parameter.courses.iter().map(course).chain([Plot::Scatter(dots)]).collect();
    chart(&frame, None, plots, |layout| checks(layout, parameter.values.len()))
}
