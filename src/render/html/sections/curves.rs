//! Free curves with their bands, against what they follow.

use kuva::plot::{BandPlot, LinePlot, ScatterPlot};
use kuva::render::plots::Plot;

use crate::diagnosis::Curve;
use crate::math::NaturalSpline;
use crate::render::html::charts::{BLUE, Frame, GREY, ORANGE, chart};
use crate::results::Cause;

/// Points of a line.
const POINTS: usize = 120;

/// The charts of a cause that is a curve, or holds some: of several components those that are not zero for certain.
pub fn charts(cause: &Cause) -> Vec<String> {
    let follows = cause.follows.as_deref().unwrap_or("what it follows");
    let of_components = cause.curves.iter().filter(|(_, curve)| curve.is_certain());
    let named = of_components.map(|(component, curve)| (format!("{} {component}", cause.site), curve));
    let single = cause.curve.iter().map(|curve| (cause.site.clone(), curve));
    single.chain(named).filter_map(|(name, curve)| drawn(&name, follows, curve)).collect()
}

/// A curve with its band, against what it follows.
fn drawn(name: &str, follows: &str, curve: &Curve) -> Option<String> {
    let (least, most) = (*curve.at.first()?, *curve.at.last()?);
    let spline = NaturalSpline::new(&curve.at)?;
    let (unit, size) = curve.shown_in();
    let is_angle = curve.unit == "rad";
    let place = |x: f64| if is_angle { x.to_degrees() } else { x };
    let along: Vec<f64> = (0..POINTS).map(|k| least + (most - least) * k as f64 / (POINTS - 1) as f64).collect();
    // The band is that of the amounts at the knots, drawn through as they are.
    let line = |bands: f64| -> Vec<f64> {
        let value = |x: &f64| {
            let mut sum = 0.0;
            spline.weights(*x, |k, weight| sum += weight * knot(curve, k, bands));
            size * sum
        };
        along.iter().map(value).collect()
    };
    let shown: Vec<f64> = along.iter().map(|x| place(*x)).collect();
    let middle: Vec<(f64, f64)> = shown.iter().copied().zip(line(0.0)).collect();
    let knots: Vec<(f64, f64)> =
        curve.at.iter().enumerate().map(|(k, x)| (place(*x), size * knot(curve, k, 0.0))).collect();
    let x = format!("{follows}, {}", if is_angle { "deg" } else { curve.unit });
    let y = format!("{name}, {unit}");
    let alt = format!("Curve at {name} against {follows}, with its 95 % band");
    let band = BandPlot::new(shown, line(-1.0), line(1.0)).with_color(GREY).with_opacity(0.35);
    let plots = vec![
        Plot::Band(band),
        Plot::Line(LinePlot::new().with_data(middle).with_color(BLUE).with_stroke_width(1.6)),
        Plot::Scatter(ScatterPlot::new().with_data(knots).with_color(ORANGE).with_size(3.5)),
    ];
    Some(chart(&Frame { size: [430.0, 260.0], x: &x, y: &y, alt: &alt }, None, plots, |layout| layout))
}

/// The amount at a knot, so many of its bands off.
fn knot(curve: &Curve, k: usize, bands: f64) -> f64 {
    let value = |all: &[f64]| all.get(k).copied().unwrap_or_default();
    value(&curve.amount) + bands * value(&curve.band)
}
