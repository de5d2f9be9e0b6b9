//! From the description as it is down to the noise.

use kuva::plot::WaterfallPlot;
use kuva::plot::annotations::ReferenceLine;
use kuva::render::plots::Plot;
use minijinja::context;

use crate::render::html::charts::{BLUE, Frame, GREY, ORANGE, chart};
use crate::render::html::page::{Page, Section, safe};
use crate::results::{Report, StepKey, WaterfallStep};

/// A step this many times the next is in the table, not drawn: the others would be no more than a line.
const OFF: f64 = 20.0;

pub fn section(report: &Report, page: &Page) -> Option<Section> {
    let (noise, steps) = report.waterfall.split_last()?;
    let off = steps.len() > 2 && steps[0].rms > OFF * steps[1].rms;
    let drawn = &steps[usize::from(off)..];
    let mut plot = WaterfallPlot::new()
        .with_color_positive(GREY)
        .with_color_negative(BLUE)
        .with_color_total(ORANGE)
        .with_connectors();
    let mut effects = 0;
    let mut last = 0.0;
    for &WaterfallStep { key, rms, .. } in drawn {
        let name = match key {
            StepKey::Described => "as described".to_string(),
            StepKey::Registered => "registered".into(),
            StepKey::Calibrated => "calibrated".into(),
            StepKey::Competed => "re-fitted".into(),
            StepKey::Effect | StepKey::Noise => {
                effects += 1;
                format!("effect {effects}")
            }
        };
        plot = plot.with_delta(name, rms - last);
        last = rms;
    }
    plot = plot.with_total("left");
    let frame = Frame {
        size: [(110.0 * (drawn.len() + 1) as f64 + 90.0).clamp(380.0, 760.0), 300.0],
        x: "",
        y: "rms error, mm",
        alt: "Waterfall of the rms position error from the description as it is down to what is left, and the noise",
    };
    let top = drawn.iter().map(|step| step.rms).fold(noise.rms, f64::max);
    let chart = chart(&frame, None, vec![Plot::Waterfall(plot)], |layout| {
        let line = ReferenceLine::horizontal(noise.rms).with_color("var(--ink)").with_label("noise");
        layout.with_reference_line(line).with_y_axis_min(0.0).with_y_axis_max(1.08 * top)
    });
    let html = page.render("waterfall.html", context! { chart => safe(chart), off });
    Some(Section { id: "waterfall", title: "From the description down to the noise".into(), html })
}
