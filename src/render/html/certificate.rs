//! A calibration certificate as a page that prints.

use kuva::plot::Histogram;
use kuva::render::plots::Plot;
use minijinja::value::Serde;
use minijinja::{Value, context};

use super::charts::{BLUE, Frame, GREY, chart};
use super::page::{Page, inert, plain, safe};
use crate::Error;
use crate::diagnostic::Diagnostic;
use crate::results::{Certificate, FitOrCheck};

/// Bins of the histogram.
const BINS: usize = 30;
/// Most rows of a table; the data have them all.
const MOST: usize = 1000;

/// The page of a certificate, and its answer in words.
///
/// # Errors
/// A result that cannot be written as JSON.
pub fn certificate_page(
    found: &Certificate,
    description: &str,
    doubts: &[Diagnostic],
) -> Result<(String, String), Error> {
    let page = Page::of(&serde_json::to_value(found)?, &[]);
    let answer = page.render("certificate-answer.html", context! {});
    let number = found.about.number.as_deref().unwrap_or("");
    // It stands in a string of the style sheet.
    let footer: String = format!("{number} {}", found.robot)
        .chars()
        .filter(|c| c.is_alphanumeric() || " .,-_/()".contains(*c))
        .collect();
    let rows: Vec<Vec<String>> =
        found.about.rows().iter().map(|(label, text)| vec![label.to_string(), text.to_string()]).collect();
    let html = page.render(
        "certificate.html",
        context! {
            title => format!("{}: calibration certificate", found.robot), answer => safe(answer.clone()), description => description.to_string(), footer => footer.trim().to_string(),
            rows, missing => found.about.missing(), most => MOST,
            turned => found.poses.iter().any(|pose| pose.orientation_accuracy.is_some()),
            varied => found.poses.iter().any(|pose| pose.variation.is_some()),
            histogram => safe(histogram(found)), doubts => Value::from(Serde(doubts)), version => found.version,
        },
    );
    Ok((inert(&html), plain(&answer)))
}

/// Position errors before and after, on one axis.
fn histogram(found: &Certificate) -> String {
    let judges = |set: FitOrCheck| !found.held_out || set == FitOrCheck::Check;
    let of = |after: bool| -> Vec<f64> {
        let judged = found.readings.iter().filter(|reading| judges(reading.set) && !reading.error.is_empty());
        judged.map(|reading| if after { reading.after } else { reading.before }).collect()
    };
    let [before, after] = [of(false), of(true)];
    let reach = before.iter().chain(&after).copied().fold(1e-9, f64::max);
    let width = reach / BINS as f64;
    let counted = |all: &[f64]| -> Vec<f64> {
        let mut counts = vec![0.0; BINS];
        all.iter().for_each(|e| counts[((e / width) as usize).min(BINS - 1)] += 1.0);
        counts
    };
    let edges: Vec<f64> = (0..=BINS).map(|k| width * k as f64).collect();
    let [grey, blue] = [counted(&before), counted(&after)];
    let top = grey.iter().chain(&blue).copied().fold(1.0, f64::max);
    let plots = [(grey, GREY), (blue, BLUE)]
        .map(|(counts, color)| Plot::Histogram(Histogram::from_bins(edges.clone(), counts).with_color(color)));
    let frame = Frame {
        size: [640.0, 260.0],
        x: "position error, mm (grey: before, blue: after)",
        y: "readings",
        alt: "Histogram of the position errors before and after calibration",
    };
    chart(&frame, Some([(0.0, reach), (0.0, 1.08 * top)]), plots.into(), |layout| layout)
}
