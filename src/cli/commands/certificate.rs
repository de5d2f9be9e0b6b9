//! `report --certificate`: what a customer is given.

use super::delivery::Delivery;
use super::identify::{left_to_fit, not_computed};
use super::report::page;
use crate::Error;
use crate::cli::args::Report as Asked;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::estimation::{CHECK, Settings, calibrate, split};
use crate::files::writable;
use crate::model::with_values;
use crate::plausibility::{Evidence, Limits, forced, judge};
use crate::prediction::FittedUncertainty;
use crate::render::html::certificate_page;
use crate::results::Certificate;

pub fn run(command: &Asked, session: &Session) -> Result<Output, Error> {
    let page = page(session.arguments, "certificate.html", command.json.as_deref())?;
    command.xml.as_deref().map_or(Ok(()), writable)?;
    let loaded = session.reader.campaign(&command.campaign, command.robot.as_deref())?;
    let (model, campaign) = (&loaded.robot.model, &loaded.campaign);
    let about = loaded.raw.certificate.clone().unwrap_or_default();
    let unit = loaded.raw.units.length.factor();
    let tolerance = command.tolerance.map(|mm| mm * 1e-3).or(about.tolerance.map(|own| own * unit));
    if let Some(tolerance) = tolerance.filter(|tolerance| !(tolerance.is_finite() && *tolerance > 0.0)) {
        let message = format!("a tolerance of {} mm", tolerance * 1e3);
        return Err(Error::input(message, "give a length above 0: --tolerance, or `certificate: {tolerance: ..}`"));
    }
    if campaign.readings.iter().all(|reading| reading.observes.length_rows() == 0) || campaign.is_difference() {
        return Err(Error::input(
            "a certificate states position errors, and the readings are none of positions",
            "measure positions, poses or distances; `identify` shows what other readings say",
        ));
    }
    let held_out = split(campaign, CHECK, session.seed());
    left_to_fit(campaign, &held_out)?;
    let bar = session.terminal.bar(None, "{spinner} iteration {pos}");
    let found = calibrate(model, campaign, &held_out, &Settings::default(), &mut |progress| {
        bar.set_position(progress.iteration as u64);
    });
    let found = found.map_err(|error| not_computed(error.into(), model, campaign, session))?;
    drop(bar);
    let calibrated = with_values(&loaded.robot.raw, model, &found.values);
    let uncertainty =
        FittedUncertainty::new(model, &found.fit).positions(model, &model.registry.nominal(), campaign).ok();
    let mut judged = judge(&Evidence::with(model, campaign, &found), &Limits::default());
    let force = session.arguments.force;
    if force {
        judged = forced(judged);
    }
    let given = command.robot.as_ref().map_or(String::new(), |robot| format!(" --robot {robot}"));
    let written = format!("elastogeo report {}{given} --certificate", command.campaign);
    let mut certificate = Certificate::new(model, campaign, &found, uncertainty.as_deref(), about, tolerance, written);
    let all = loaded.diagnostics.iter().chain(&judged);
    let doubts: Vec<_> = all.filter(|found| found.code.is_about_figures()).cloned().collect();
    if !force {
        certificate.doubted(&doubts);
    }
    let (html, answer) = certificate_page(&certificate, &calibrated.robot.unwrap_or_default(), &doubts)?;
    let delivery = Delivery { command, session, page, diagnostics: loaded.diagnostics, judged };
    delivery.finish("certificate", &certificate, format!("{answer}\n"), html, certificate.converged)
}
