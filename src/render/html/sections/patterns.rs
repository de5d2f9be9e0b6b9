//! Residuals against everything that was different between readings, with the suspected pattern drawn through.

use kuva::plot::{LinePlot, ScatterPlot};
use kuva::render::plots::Plot;
use minijinja::context;

use crate::math::{distinct, extremes, norm};
use crate::render::html::charts::{BLUE, Frame, GREY, ORANGE, chart};
use crate::render::html::page::{Page, Section, safe};
use crate::review::Review;

/// Most points of a chart.
const POINTS: usize = 300;
/// Bins of the means that are drawn through.
const BINS: usize = 14;

/// Something that readings differ in: name with unit, and its value at each reading.
struct Axis {
    name: String,
    values: Vec<f64>,
}

/// Three components of a reading (or its distance) that are drawn on one scale.
struct Scale {
    /// First of them among the reading's.
    first: usize,
    names: &'static [&'static str],
    /// Unit, and its size in SI.
    unit: (&'static str, f64),
}

const DISTANCE: Scale = Scale { first: 0, names: &["distance"], unit: ("mm", 1e-3) };
const POSITION: Scale = Scale { first: 0, names: &["x", "y", "z"], unit: ("mm", 1e-3) };
const ROTATION: Scale = Scale { first: 3, names: &["rx", "ry", "rz"], unit: ("deg", std::f64::consts::PI / 180.0) };

pub fn section(review: &Review, page: &Page) -> Option<Section> {
    let axes = axes(review);
    let any = |rows: usize| review.campaign.readings.iter().any(|reading| reading.observes.rows() >= rows);
    let own = if any(3) { &POSITION } else { &DISTANCE };
    let order = chosen(&coordinates(review, review.readings.left(), own), review.campaign.readings.len());
    let (rows, beyond) = rows(review, &axes, own, &order);
    let (rotations, _) = if any(6) { self::rows(review, &axes, &ROTATION, &order) } else { (Vec::new(), 0) };
    let html = page.render(
        "patterns.html",
        context! {
            rows, rotations, beyond, drawn => order.len(), count => review.campaign.readings.len(),
            suspected => !review.readings.pattern.is_empty(), columns => own.names.len(),
        },
    );
    Some(Section { id: "patterns", title: "What the errors follow".into(), html })
}

/// Residuals of all readings by component, in the scale's unit; none where there are none.
fn coordinates(review: &Review, all: &[f64], scale: &Scale) -> Vec<Vec<f64>> {
    if all.is_empty() {
        return Vec::new();
    }
    // Not a number where a reading has no such component.
    let value = |own: &[f64], k: usize| match own.len() >= scale.first + scale.names.len() {
        true => own[scale.first + k] / scale.unit.1,
        false => f64::NAN,
    };
    let of = |k: usize| review.campaign.by_reading(all, 1).map(|(_, own)| value(own, k)).collect();
    (0..scale.names.len()).map(of).collect()
}

/// A row of charts for each axis, all of one height so that they compare; and how many coordinates are far outside it:
/// these are counted, not drawn.
fn rows(review: &Review, axes: &[Axis], scale: &Scale, order: &[usize]) -> (Vec<minijinja::Value>, usize) {
    let errors = coordinates(review, review.readings.left(), scale);
    let taken = coordinates(review, &review.readings.pattern, scale);
    let mut sizes: Vec<f64> =
        errors.iter().chain(&taken).flatten().map(|v| v.abs()).filter(|v| v.is_finite()).collect();
    sizes.sort_by(f64::total_cmp);
    let most = 1.25 * sizes.get((sizes.len().saturating_sub(1)) * 99 / 100).copied().unwrap_or(1.0).max(1e-6);
    let beyond = errors.iter().flatten().filter(|v| v.abs() > most).count();
    let row = |axis: &Axis| {
        let chart = |(k, errors): (usize, &Vec<f64>)| {
            let label = format!("error in {}, {}", scale.names[k], scale.unit.0);
            safe(panel(axis, &label, errors, taken.get(k).map(Vec::as_slice), order, most))
        };
        let charts: Vec<_> = errors.iter().enumerate().map(chart).collect();
        context! { name => axis.name.as_str(), charts }
    };
    (axes.iter().map(row).collect(), beyond)
}

/// All axes along which readings differ.
fn axes(review: &Review) -> Vec<Axis> {
    let (model, campaign) = (review.model, review.campaign);
    let count = campaign.readings.len();
    let mut axes: Vec<Axis> = model
        .variables
        .iter()
        .enumerate()
        .map(|(k, variable)| {
            let (size, unit) = if variable.is_angle { (180.0 / std::f64::consts::PI, "deg") } else { (1e3, "mm") };
            let values = (0..count).map(|i| campaign.configuration(i)[k] * size).collect();
            Axis { name: format!("{}, {unit}", variable.name), values }
        })
        .collect();
    let load = |name: &str, of: &dyn Fn(&[f64; 6]) -> f64| Axis {
        name: name.into(),
        values: campaign.readings.iter().map(|reading| of(&reading.wrench)).collect(),
    };
    axes.push(load("force, N", &|w| norm(&w[..3])));
    for (k, name) in ["fx, N", "fy, N", "fz, N", "mx, N.m", "my, N.m", "mz, N.m"].into_iter().enumerate() {
        axes.push(load(name, &|w| w[k]));
    }
    for (condition, values) in campaign.conditions.columns() {
        let name = condition.column(|variable| review.model.variables[variable].name.as_str());
        let unit = Some(condition.unit()).filter(|unit| !unit.is_empty()).unwrap_or("side");
        axes.push(Axis { name: format!("{name}, {unit}"), values: values.clone() });
    }
    axes.retain(|axis| axis.values.iter().any(|v| *v != axis.values[0]));
    axes
}

/// Readings that are drawn: evenly spread, and the greatest of all.
fn chosen(errors: &[Vec<f64>], count: usize) -> Vec<usize> {
    if count <= POINTS {
        return (0..count).collect();
    }
    let size = |i: usize| errors.iter().map(|e| e[i] * e[i]).sum::<f64>();
    let mut greatest: Vec<usize> = (0..count).collect();
    greatest.sort_by(|&a, &b| size(b).total_cmp(&size(a)));
    distinct((0..count).step_by(count.div_ceil(POINTS - 30)).chain(greatest.into_iter().take(30)))
}

/// Means of `y` in bins of equal numbers of readings along `x`.
fn means(x: &[f64], y: &[f64]) -> Vec<(f64, f64)> {
    let mut order: Vec<usize> = (0..x.len()).collect();
    order.sort_by(|&a, &b| x[a].total_cmp(&x[b]));
    let mut levels: Vec<f64> = order.iter().map(|&i| x[i]).collect();
    levels.dedup();
    let mean = |among: &[usize]| {
        let n = among.len().max(1) as f64;
        (among.iter().map(|&i| x[i]).sum::<f64>() / n, among.iter().map(|&i| y[i]).sum::<f64>() / n)
    };
    if levels.len() <= BINS {
        let at = |level: &f64| order.iter().copied().filter(|&i| x[i] == *level).collect::<Vec<_>>();
        return levels.iter().map(|level| mean(&at(level))).collect();
    }
    order.chunks(order.len().div_ceil(BINS).max(1)).map(mean).collect()
}

fn panel(axis: &Axis, label: &str, errors: &[f64], pattern: Option<&[f64]>, order: &[usize], most: f64) -> String {
    let points = |y: &[f64]| -> Vec<(f64, f64)> {
        order.iter().map(|&i| (axis.values[i], y[i])).filter(|(_, y)| y.abs() <= most).collect()
    };
    let dots = |y: &[f64], color: &str, size: f64| {
        Plot::Scatter(
            ScatterPlot::new().with_data(points(y)).with_color(color).with_size(size).with_marker_opacity(0.7),
        )
    };
    let line = |y: &[f64], color: &str| {
        Plot::Line(LinePlot::new().with_data(means(&axis.values, y)).with_color(color).with_stroke_width(2.0))
    };
    let mut plots = vec![dots(errors, BLUE, 1.6)];
    if let Some(pattern) = pattern {
        plots.push(dots(pattern, ORANGE, 1.3));
        plots.push(line(errors, BLUE));
        plots.push(line(pattern, ORANGE));
    } else {
        plots.push(line(errors, GREY));
    }
    let [low, high] = extremes(axis.values.iter().copied());
    let margin = 0.04 * (high - low);
    let alt = format!("{label} against {}", axis.name);
    let frame = Frame { size: [330.0, 210.0], x: &axis.name, y: label, alt: &alt };
    chart(&frame, Some([(low - margin, high + margin), (-most, most)]), plots, |layout| layout.with_ticks(5))
}
