//! The identified parameters compared with another set.

use minijinja::context;

use crate::render::html::page::{Page, Section};
use crate::results::{Before, Report};

pub fn section(report: &Report, page: &Page) -> Option<Section> {
    let found = report.identify.as_ref()?.against.as_ref()?;
    let sets = [&found.before, &found.other, &found.identified];
    let has_lengths = sets.iter().any(|set| set.errors.max > 0.0);
    let context = context! {
        has_lengths, angles => found.identified.errors.orientation.is_some(), loads => found.identified.errors.load.is_some(),
        directions => found.identified.directions.len(), parts => if has_lengths { found.identified.parts.len() } else { 0 },
        before => match found.before_is {
            Before::Measured => "as measured",
            Before::Registration => "base and tool alone",
        },
        lengths => found.parameters.iter().map(|own| matches!(own.unit, "mm" | "deg")).collect::<Vec<_>>(),
    };
    let html = page.render("against.html", context);
    Some(Section { id: "against", title: "Compared with another set of parameters".into(), html })
}
