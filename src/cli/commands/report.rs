//! `report`: a campaign in one self-contained HTML file.

mod fitted;
mod sources;

use std::path::{Path, PathBuf};

use sources::sources;

use super::delivery::Delivery;
use super::diagnose::{Described, worse_than_found};
use super::identify::{compared, left_to_fit, not_computed, other};
use crate::Error;
use crate::cli::args::{Arguments, Format, Report as Asked};
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::diagnosis::Verdict;
use crate::diagnostic::Code;
use crate::estimation::{CHECK, Settings, split};
use crate::files::{is_device, writable};
use crate::plausibility::{Evidence, Limits, doubts, is_above_noise, judge, judge_result};
use crate::render::html::write;
use crate::results::{CombinedParameters, Report};
use crate::review::review;

pub fn run(command: &Asked, session: &Session) -> Result<Output, Error> {
    let page = page(session.arguments, "report.html", command.json.as_deref())?;
    let loaded = session.reader.campaign(&command.campaign, command.robot.as_deref())?;
    let (model, campaign) = (&loaded.robot.model, &loaded.campaign);
    let held_out = split(campaign, CHECK, session.seed());
    left_to_fit(campaign, &held_out)?;
    if !campaign.holds_lengths() {
        return fitted::run(command, session, loaded, &held_out, page);
    }
    let force = session.arguments.force;
    let mut judged = judge(&Evidence::of(model, campaign), &Limits::default());
    Output::gate(&judged, force, &loaded.diagnostics)?;
    let other = command.against.as_deref().map(|name| other(name, &command.campaign, &loaded, session)).transpose()?;
    let bar = session.terminal.bar(None, "{spinner} {msg}");
    let mut progress = |what: &str| bar.set_message(what.to_string());
    let review = review(&loaded.robot.robot, model, campaign, &held_out, session.seed(), &mut progress)
        .map_err(|error| not_computed(error, model, campaign, session))?;
    let mut report = Report::new(&review, sources(command, session, &loaded));
    if let Ok((found, _)) = &review.calibration {
        let declared = &loaded.robot.robot.calibration.combinations;
        let conventions = CombinedParameters::all(declared, model, found);
        report.identify.iter_mut().for_each(|own| own.conventions.clone_from(&conventions));
        if let (Some(other), Some(own)) = (&other, &mut report.identify) {
            own.against = compared(other, model, campaign, found, &Settings::default())?;
        }
        // What calibration leaves above the noise is no doubt where the causes explain it.
        let is_explained = review.diagnosis.verdict == Verdict::Explained;
        let mut of_result = judge_result(&Evidence::with(model, campaign, found), &Limits::default());
        of_result.retain(|own| !(is_explained && is_above_noise(own)));
        judged.extend(of_result);
    }
    for doubt in doubts(model, campaign, &review.diagnosis, &Limits::default()) {
        if !judged.iter().any(|known| known.code == doubt.code) {
            judged.push(doubt);
        }
    }
    let described = Described::new(&loaded.robot, campaign, &review.diagnosis);
    judged.extend(worse_than_found(&described, session)?);
    Output::gate(&judged, force, &loaded.diagnostics)?;
    // That it did not converge stands in the report itself.
    judged.retain(|found| found.code != Code::NotConverged);
    let delivery = Delivery { command, session, page, diagnostics: loaded.diagnostics, judged };
    report.diagnostics = delivery.shown();
    let html = write(&review, &mut report)?;
    drop(bar);
    let text = format!("{}\n\n{}\n", campaign.name, report.answer.as_deref().unwrap_or_default());
    let is_converged = report.identify.as_ref().is_none_or(|found| found.converged);
    delivery.finish("report", &report, text, html, is_converged)
}

/// Where the page goes: `--output`, or the usual name; none where JSON is asked for.
pub fn page(arguments: &Arguments, usual: &str, other: Option<&Path>) -> Result<Option<PathBuf>, Error> {
    let path = match arguments.format {
        Format::Json => None,
        Format::Text => Some(arguments.output.clone().unwrap_or_else(|| PathBuf::from(usual))),
    };
    path.as_deref().map_or(Ok(()), writable)?;
    let ending = path.as_deref().and_then(Path::extension).and_then(|ending| ending.to_str());
    let is_page = ending.is_none_or(|ending| ["html", "htm", "xhtml"].contains(&ending.to_lowercase().as_str()));
    if let Some(path) = path.as_ref().filter(|path| !is_page && !is_device(path)) {
        return Err(Error::input(
            format!("`{}`: a page is written", path.display()),
            "end the name in .html; a browser prints it as PDF",
        ));
    }
    if let Some(other) = other {
        writable(other)?;
    }
    Ok(path)
}
