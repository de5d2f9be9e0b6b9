//! Reports for a browser: one self-contained HTML file that shows a result.
//!
//! Nothing is computed here but where things stand on the page. Figures in the text carry the JSON pointer of their value
//! in the result's JSON (`data-path`), so that the two can be compared; a pointer to nothing is a fault of the template.

mod arrows;
mod certificate;
mod charts;
mod drawing;
mod figure;
mod fitted;
mod page;
mod sections;
mod track;
mod view;

pub use certificate::certificate_page;
pub use figure::{Look, figure};
pub use fitted::fitted_page;
pub use track::track_page;
pub use view::{magnification, view_page};

use minijinja::context;

use crate::Error;
use crate::results::Report;
use crate::review::Review;
use arrows::Arrows;
use drawing::{Drawing, DrawnShot};
use page::{Page, embedded, inert, plain, safe};

/// Writes the page of a report, and the answer of two sentences at its head into the report.
///
/// # Errors
/// A report that cannot be written as JSON.
pub fn write(review: &Review, report: &mut Report) -> Result<String, Error> {
    let page = Page::new(&serde_json::to_value(&*report)?);
    let judged = if report.identify.as_ref().is_some_and(|found| found.is_checked()) { "check_" } else { "" };
    let is_session_noticed = report.diagnose.after_all.is_session_noticed();
    let answer = page.render("answer.html", context! { judged, is_session_noticed });
    let sections = sections::all(review, report, &page);
    let data = embedded(&Drawing {
        unit: "m",
        axis: review.scene.axis,
        parts: review.scene.parts.clone(),
        shots: review.shots.iter().map(DrawnShot::new).collect(),
        next: review.next.iter().map(DrawnShot::new).collect(),
        suspects: report.suspects(),
        arrows: Arrows::new(review),
        magnified: None,
    })?;
    let sections = sections.into_iter().map(|s| context! { id => s.id, title => s.title, html => safe(s.html) });
    let name = &report.campaign.name;
    let html = page.render(
        "page.html",
        context! {
            title => format!("{name}: report"), heading => name, answer => safe(answer.clone()),
            sections => sections.collect::<Vec<_>>(), data, version => env!("CARGO_PKG_VERSION"), report => true,
            own_weight => report.campaign.own_weight.of_readings(),
            doubtful => report.diagnostics.iter().map(|found| found.code.is_about_figures()).collect::<Vec<bool>>(),
        },
    );
    report.answer = Some(plain(&answer));
    Ok(inert(&html))
}
