//! From the description as it is down to the noise.

use kuva::plot::WaterfallPlot;
use kuva::plot::annotations::ReferenceLine;
use kuva::render::plots::Plot;
use minijinja::context;
use serde_json::Value;

use crate::render::html::charts::{BLUE, Frame, GREY, ORANGE, chart};
use crate::render::html::page::{Page, Section, safe};

/// A step this many times the next is told, not drawn: the others would be no more than a line.
const OFF: f64 = 20.0;

pub fn section(page: &Page, json: &Value) -> Option<Section> {
    let steps: Vec<(&str, &str, f64)> = json["waterfall"]
        .as_array()?
        .iter()
        .map(|step| {
            (
                step["key"].as_str().unwrap_or(""),
                step["label"].as_str().unwrap_or(""),
                step["rms"].as_f64().unwrap_or(0.0),
            )
        })
        .collect();
    let (noise, steps) = steps.split_last()?;
    let off = steps.len() > 2 && steps[0].2 > OFF * steps[1].2;
    let drawn = &steps[usize::from(off)..];
    let mut plot = WaterfallPlot::new()
        .with_color_positive(GREY)
        .with_color_negative(BLUE)
        .with_color_total(ORANGE)
        .with_connectors();
    let mut effects = 0;
    let mut last = 0.0;
    for &(key, _, rms) in drawn {
        let name = match key {
            "described" => "as described".to_string(),
            "registered" => "registered".into(),
            "calibrated" => "calibrated".into(),
            "competed" => "re-fitted".into(),
            _ => {
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
        alt: "Waterfall of the rms position error from the description as it is down to what is left, beside the noise",
    };
    let top = drawn.iter().map(|step| step.2).fold(noise.2, f64::max);
    let chart = chart(&frame, None, vec![Plot::Waterfall(plot)], |layout| {
        let line = ReferenceLine::horizontal(noise.2).with_color("var(--ink)").with_label("noise");
        layout.with_reference_line(line).with_y_axis_min(0.0).with_y_axis_max(1.08 * top)
    });
    let html = page.render("waterfall.html", context! { chart => safe(chart), off });
    Some(Section { id: "waterfall", title: "From the description down to the noise".into(), html })
}
