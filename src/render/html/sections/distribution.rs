//! Histogram and Q-Q plot of what is left.

use kuva::plot::{Histogram, LinePlot, QQPlot};
use kuva::render::plots::Plot;
use minijinja::context;

use crate::description::campaign::Reading;
use crate::render::html::charts::{BLUE, Frame, GREY, ORANGE, chart};
use crate::render::html::page::{Page, Section, safe};
use crate::results::stage_label;
use crate::review::Review;

/// Bins of a histogram.
const BINS: usize = 31;
/// Most points of a Q-Q plot: quantiles, where there are more residuals.
const POINTS: usize = 300;

pub fn section(review: &Review, page: &Page) -> Option<Section> {
    let stage = review.readings.stages.last()?;
    let readings = || review.campaign.by_reading(&stage.residual, 1);
    let lengths = readings().flat_map(|(of, own)| &own[..of.observes.length_rows()]).map(|v| v * 1e3);
    let is_angle = |(of, _): &(&Reading, &[f64])| of.observes.by_variable().is_none();
    let angles =
        readings().filter(is_angle).flat_map(|(of, own)| &own[of.observes.length_rows()..]).map(|v| v.to_degrees());
    let named = [
        ("error of a coordinate, mm", lengths.collect::<Vec<f64>>()),
        ("error of a rotation component, deg", angles.collect()),
    ];
    let pairs = named.iter().filter(|(_, values)| !values.is_empty()).map(|(what, values)| pair(what, values));
    let html = page.render(
        "distribution.html",
        context! { charts => pairs.flatten().map(safe).collect::<Vec<_>>(), stage => stage_label(stage.key) },
    );
    Some(Section { id: "distribution", title: "How what is left is distributed".into(), html })
}

fn pair(what: &str, values: &[f64]) -> [String; 2] {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    let sd = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt().max(1e-12);
    let reach = values.iter().map(|v| v.abs()).fold(0.0, f64::max).min(6.0 * sd).max(1e-9);
    let width = 2.0 * reach / BINS as f64;
    let mut counts = vec![0.0; BINS];
    for v in values {
        let bin = ((v + reach) / width).floor().clamp(0.0, BINS as f64 - 1.0) as usize;
        counts[bin] += 1.0;
    }
    let edges: Vec<f64> = (0..=BINS).map(|k| -reach + width * k as f64).collect();
    let normal: Vec<(f64, f64)> = (0..=80)
        .map(|k| -reach + 2.0 * reach * f64::from(k) / 80.0)
        .map(|x| (x, n * width * (-0.5 * ((x - mean) / sd).powi(2)).exp() / (sd * std::f64::consts::TAU.sqrt())))
        .collect();
    let top = counts.iter().copied().chain(normal.iter().map(|p| p.1)).fold(1.0, f64::max);
    let size = [430.0, 280.0];
    let histogram = chart(
        &Frame {
            size,
            x: what,
            y: "readings' coordinates",
            alt: "Histogram of the residuals with the normal curve of the same spread",
        },
        Some([(-reach, reach), (0.0, 1.08 * top)]),
        vec![
            Plot::Histogram(Histogram::from_bins(edges, counts).with_color(GREY)),
            Plot::Line(LinePlot::new().with_data(normal).with_color(ORANGE).with_stroke_width(1.8)),
        ],
        |layout| layout,
    );
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let quantiles: Vec<f64> = if sorted.len() <= POINTS {
        sorted
    } else {
        (0..POINTS).map(|k| sorted[k * (sorted.len() - 1) / (POINTS - 1)]).collect()
    };
    let label = format!("measured, {}", what.rsplit(", ").next().unwrap_or("mm"));
    let qq = chart(
        &Frame { size, x: "normal quantile, sigma", y: &label, alt: "Normal Q-Q plot of the residuals" },
        None,
        vec![Plot::QQ(
            QQPlot::new()
                .with_data("residuals", quantiles)
                .with_normal()
                .with_reference_line()
                .with_marker_size(2.0)
                .with_color(BLUE),
        )],
        |layout| layout,
    );
    [histogram, qq]
}
