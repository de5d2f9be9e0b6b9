//! The report of a campaign of angles or loads alone: what a calibration takes away, and what it leaves.

use kuva::plot::ScatterPlot;
use kuva::render::plots::Plot;
use minijinja::context;

use super::charts::{BLUE, Frame, chart};
use super::page::{Page, Section, embedded, inert, plain, safe};
use super::sections::{conditioning, parameters, parts};
use crate::Error;
use crate::math::norm;
use crate::results::{FittedReport, ReadingErrors, Residuals};

/// Most points drawn.
const POINTS: usize = 2000;

/// Writes the page, and the answer at its head into the report.
///
/// # Errors
/// A report that cannot be written as JSON.
pub fn fitted_page(report: &mut FittedReport) -> Result<String, Error> {
    let page = Page::new(&serde_json::to_value(&*report)?);
    let found = &report.identify;
    let is_placed = report.campaign.estimate_base || report.campaign.estimate_tool;
    let judged = if found.is_checked() { "check_" } else { "" };
    let from = if is_placed { "registration" } else { "before" };
    let value = if found.judged_unit() == "deg" { "/orientation/rms" } else { "/load/rms" };
    let answer =
        page.render("fitted-answer.html", context! { judged, from, value, unit => found.judged_unit(), is_placed });
    let sections = [
        errors(report, &page),
        parts::table(found, &page, context! {}),
        parameters::section(Some(found), &page),
        conditioning::section(Some(found), &page),
    ];
    let sections = sections.into_iter().flatten();
    let sections = sections.map(|s| context! { id => s.id, title => s.title, html => safe(s.html) });
    let name = &report.campaign.name;
    let html = page.render(
        "page.html",
        context! {
            title => format!("{name}: report"), heading => name, answer => safe(answer.clone()),
            sections => sections.collect::<Vec<_>>(), data => embedded(&serde_json::json!({}))?,
            version => env!("CARGO_PKG_VERSION"), report => true,
            own_weight => report.campaign.own_weight.of_readings(),
            doubtful => report.diagnostics.iter().map(|found| found.code.is_about_figures()).collect::<Vec<bool>>(),
        },
    );
    report.answer = Some(plain(&answer));
    Ok(inert(&html))
}

/// Errors with the description as it is, registered and calibrated, and those of all readings.
fn errors(report: &FittedReport, page: &Page) -> Option<Section> {
    let all = sets(&report.identify.residuals);
    let sets = all.iter().filter(|(_, _, errors)| errors.is_some());
    let sets: Vec<_> = sets.map(|(label, key, _)| context! { label => *label, key => *key }).collect();
    let has =
        |of: fn(&ReadingErrors) -> bool| all.iter().filter_map(|(_, _, errors)| **errors).any(|errors| of(&errors));
    let (angles, loads) = (has(|errors| errors.orientation.is_some()), has(|errors| errors.load.is_some()));
    let readings = || report.readings.iter().enumerate();
    let turned = readings().filter_map(|(k, own)| Some(((k + 1) as f64, norm(own.orientation_error_deg.as_ref()?))));
    let loaded = readings().filter_map(|(k, own)| Some(((k + 1) as f64, own.load_error?.abs())));
    let charts = [drawn(turned.collect(), "error, deg"), drawn(loaded.collect(), "error, N.m or N")];
    let charts: Vec<_> = charts.into_iter().flatten().map(safe).collect();
    let html = page.render("fitted.html", context! { sets, angles, loads, charts });
    Some(Section { id: "errors", title: "From the description to the calibrated robot".into(), html })
}

/// Sets of readings at each stage: what they are called, their key, their errors.
fn sets(all: &Residuals) -> [(&'static str, &'static str, &Option<ReadingErrors>); 6] {
    [
        ("fitted, description as it is", "before", &all.before),
        ("fitted, registered", "registration", &all.registration),
        ("fitted, calibrated", "after", &all.after),
        ("held out, description as it is", "check_before", &all.check_before),
        ("held out, registered", "check_registration", &all.check_registration),
        ("held out, calibrated", "check_after", &all.check_after),
    ]
}

/// What is left of each reading, in the order of the files.
fn drawn(points: Vec<(f64, f64)>, y: &str) -> Option<String> {
    let step = points.len().div_ceil(POINTS).max(1);
    let points: Vec<(f64, f64)> = points.into_iter().step_by(step).collect();
    let frame = Frame { size: [860.0, 260.0], x: "reading", y, alt: "Errors of the readings in their order" };
    (!points.is_empty()).then(|| {
        let plot = Plot::Scatter(ScatterPlot::new().with_data(points).with_color(BLUE).with_size(2.0));
        chart(&frame, None, vec![plot], |layout| layout.with_y_axis_min(0.0))
    })
}
