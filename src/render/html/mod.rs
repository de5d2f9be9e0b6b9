//! Reports for a browser: one self-contained HTML file, and the JSON that holds the same data.
//!
//! Nothing is computed here but where things stand on the page. Figures in the text carry the JSON pointer of their value
//! in `report.json` (`data-path`), so that the two can be compared.

mod charts;
mod data;
mod drawing;
mod figure;
mod page;
mod sections;
mod view;

pub use data::{Report, report_json};
pub use drawing::Shot;
pub use figure::{Look, figure};
pub use view::{View, magnification, view_json, view_page};

use minijinja::context;
use serde_json::{Value, json};

use drawing::{parts_json, shot_json};
use page::{Page, embedded, plain};

/// A finished report.
#[derive(Debug, Clone)]
pub struct Written {
    /// The HTML file.
    pub html: String,
    /// The same data.
    pub json: Value,
    /// The answer in two sentences.
    pub answer: String,
}

/// Writes a report.
pub fn write(report: &Report) -> Written {
    let mut json = report_json(report);
    let page = Page::new(&json);
    let answer = page.render("answer.html", context! { judged => report.judged() });
    let sections = sections::all(report, &page, &json);
    let scene = embedded(&json!({
        "unit": "m", "axis": report.scene.axis, "parts": parts_json(report.scene),
        "shots": report.shots.iter().map(shot_json).collect::<Vec<_>>(),
        "next": report.next.iter().map(shot_json).collect::<Vec<_>>(),
        "suspects": report.suspects(),
        "arrows": data::arrows(report),
    }));
    let html = page.render(
        "page.html",
        context! {
            title => format!("{}: report", report.campaign.name),
            heading => report.campaign.name.as_str(),
            answer => page::safe(answer.clone()),
            sections => sections.iter().map(|s| context! { id => s.id, title => s.title.as_str(), html => page::safe(s.html.clone()) }).collect::<Vec<_>>(),
            data => scene,
            version => env!("CARGO_PKG_VERSION"),
            report => true,
        },
    );
    let answer = plain(&answer);
    json["answer"] = json!(answer);
    Written { html, json, answer }
}
