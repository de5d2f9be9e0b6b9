//! Something that moved between readings, and how it is said.

use super::evidence::Evidence;
use super::shown::mm;
use crate::diagnostic::{Code, Diagnostic};

/// What moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum What {
    /// The instrument, or the robot's base.
    Instrument,
    /// The marker on its body, or the tool with all markers.
    Tool,
    /// One marker of several, by index.
    Marker(usize),
    /// The zero of a variable, by index.
    Zero(usize),
}

/// A step: what moved, the first reading after it, its size (m; of a zero what half of the readings after it moved at least), how many
/// values it has, what it takes out of the weighted squares. Or a drift, whose size is that from the first row to the last.
pub(super) struct Step {
    pub what: What,
    pub is_drift: bool,
    pub at: usize,
    pub by: f64,
    /// Of a zero, rad or m.
    pub change: f64,
    pub values: f64,
    pub gain: f64,
    /// Residuals without it over those with it, of the readings that it concerns.
    pub fall: f64,
    /// The same of half of them: a few that are wrong leave the others where they were.
    pub fall_of_half: f64,
}

/// The figure that holds the index of the one marker that moved.
pub(super) const OF_MARKER: &str = "marker";

/// What is said of it.
pub(super) fn described(evidence: &Evidence, step: &Step) -> Diagnostic {
    let (campaign, fall) = (evidence.campaign, step.fall);
    let address = campaign.address(&campaign.readings[step.at]);
    // Readings that were held out stand between the last fitted one before the step and the first one after it.
    let place = |index: usize| campaign.rank(index);
    let is_before = |index: &usize| place(*index) < place(step.at);
    let later = |a: &usize, b: &usize| place(*a).total_cmp(&place(*b));
    let held_out = evidence.found.map_or(&[][..], |found| &found.held_out);
    let last = (0..campaign.readings.len()).filter(is_before).max_by(later);
    let fitted = |index: &usize| held_out.get(*index) != Some(&true);
    let before = (0..campaign.readings.len()).filter(is_before).filter(fitted).max_by(later);
    let since = match before.filter(|_| last != before) {
        Some(before) => {
            format!("from a row after {} and up to {address}", campaign.address(&campaign.readings[before]))
        }
        None => format!("from {address} on"),
    };
    const TOOL: &str = "name sessions before and after it (column `session`) and write `estimate: {tool: per-session}`; or leave one part out";
    let name = match step.what {
        What::Marker(marker) => evidence.model.markers.get(marker).map(|marker| marker.name.as_str()),
        _ => None,
    };
    let of = name.map_or_else(String::new, |name| format!(" of marker `{name}`"));
    if step.is_drift {
        return drift(step, &of);
    }
    let (what, remedy) = match step.what {
        What::Tool => ("the marker moved on its body, or the tool was changed".to_owned(), TOOL),
        What::Marker(_) => ("did it move on its body".to_owned(), TOOL),
        What::Instrument => (
            "the instrument or the robot's base was moved".to_owned(),
            "name sessions before and after it (column `session`) and write `estimate: {base: per-session}`; or leave one part out",
        ),
        What::Zero(k) => (
            evidence.model.variables.get(k).map_or_else(String::new, |variable| {
                let change = match variable.is_angle {
                    true => format!("{:+.4} deg", step.change.to_degrees()),
                    false => format!("{:+.4} mm", 1e3 * step.change),
                };
                format!("the zero of `{}` changed by {change} (an encoder set anew, a slip)", variable.name)
            }),
            "calibrate the part before it and the part after it each by itself; or correct the column of that joint in one of them",
        ),
    };
    let message = format!(
        "{since} readings{of} are {} mm away from those before, and without that step errors fall to 1/{fall:.1}: {what}?",
        mm(step.by)
    );
    let diagnostic = Diagnostic::warning(message).code(Code::MovedMidway).remedy(remedy);
    let diagnostic = diagnostic.figure("step_mm", 1e3 * step.by).figure("fall", fall);
    match step.what {
        What::Marker(marker) => diagnostic.figure(OF_MARKER, marker as f64),
        _ => diagnostic,
    }
}

/// Words of a drift; `of` names the marker that does it.
fn drift(step: &Step, of: &str) -> Diagnostic {
    let fall = step.fall;
    let what = match step.what {
        What::Instrument => "the instrument or the robot's base moved slowly, or the room's temperature changed",
        What::Tool | What::Marker(_) => "what the marker is on moved slowly, or warmed up",
        What::Zero(_) => "a joint's zero or a link changed slowly, as in warming up",
    };
    let message = format!(
        "readings{of} drift by {} mm from the first row to the last, and without that errors fall to 1/{fall:.1}: {what}?",
        mm(step.by)
    );
    let remedy = "let the robot and the instrument warm up and measure again; or write a column `time` and let `diagnose` find the drift; \
                  or name sessions and write `estimate: {base: per-session}`";
    let diagnostic = Diagnostic::warning(message).code(Code::MovedMidway).remedy(remedy);
    diagnostic.figure("drift_mm", 1e3 * step.by).figure("fall", fall)
}
