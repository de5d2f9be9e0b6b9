//! Errors by session, station, file, kind and marker, by reading, and the worst readings.

use kuva::plot::ScatterPlot;
use kuva::render::plots::Plot;
use minijinja::{Value, context};

use crate::description::campaign::Reading;
use crate::math::norm;
use crate::render::html::charts::{BLUE, Frame, GREY, ORANGE, chart};
use crate::render::html::page::{Page, Section, safe};
use crate::results::{Identification, Report, stage_label};
use crate::review::{Review, StageKey};

/// Colours of the parts that are told apart in the chart, one after the other.
const COLORS: [(&str, &str); 3] = [(BLUE, "blue"), (ORANGE, "orange"), (GREY, "grey")];
/// Most points drawn.
const POINTS: usize = 2000;

pub fn section(review: &Review, report: &Report, page: &Page) -> Option<Section> {
    let found = report.identify.as_ref()?;
    let stage = review.readings.stage(StageKey::Calibrated).or(review.readings.stages.last())?;
    let campaign = review.campaign;
    let sessions = &campaign.sessions;
    let (names, of): (&[String], fn(&Reading) -> usize) = match sessions.names.len() {
        1 => (&sessions.stations, |reading| reading.session.station),
        _ => (&sessions.names, |reading| reading.session.session),
    };
    let is_reported = (2..=COLORS.len()).contains(&names.len());
    let mut points = vec![Vec::new(); COLORS.len()];
    let step = campaign.readings.len().div_ceil(POINTS).max(1);
    for (index, (reading, own)) in campaign.by_reading(&stage.residual, 1).enumerate().step_by(step) {
        let lengths = &own[..reading.observes.length_rows().min(own.len())];
        let error = norm(lengths) * 1e3;
        if !lengths.is_empty() {
            points[if is_reported { of(reading) } else { 0 }].push(((index + 1) as f64, error));
        }
    }
    let frame =
        Frame { size: [860.0, 260.0], x: "reading", y: "error, mm", alt: "Errors of the readings in their order" };
    let plots = points.into_iter().zip(COLORS).filter(|(own, _)| !own.is_empty());
    let plots: Vec<Plot> = plots
        .map(|(own, (color, _))| Plot::Scatter(ScatterPlot::new().with_data(own).with_color(color).with_size(2.0)))
        .collect();
    let drawn = (!plots.is_empty()).then(|| safe(chart(&frame, None, plots, |layout| layout.with_y_axis_min(0.0))));
    let named = names.iter().zip(COLORS).map(|(name, (_, color))| format!("{name} {color}"));
    let named = is_reported.then(|| named.collect::<Vec<_>>().join(", "));
    table(found, page, context! { chart => drawn, stage => stage_label(stage.key), named })
}

/// The tables, with a chart before them where there is one; nothing where there are none.
pub fn table(found: &Identification, page: &Page, chart: Value) -> Option<Section> {
    if found.parts.is_empty() && found.worst.is_empty() {
        return None;
    }
    let context = context! {
        turned => found.worst.iter().any(|reading| reading.orientation_error_deg.is_some()),
        placed => found.worst.iter().any(|reading| reading.error.is_some()),
        angles => found.parts.iter().any(|part| part.errors.orientation.is_some()),
        lengths => (0..found.parts.len()).filter(|&k| found.parts[k].errors.has_lengths()).collect::<Vec<_>>(),
        loads => found.parts.iter().any(|part| part.errors.load.is_some()),
        ..chart
    };
    let html = page.render("parts.html", context);
    Some(Section { id: "parts", title: "Errors by session, file and reading".into(), html })
}
