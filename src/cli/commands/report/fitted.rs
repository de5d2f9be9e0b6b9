//! `report` of angles or loads alone: effects are not compared in them, and the page shows the calibration.

use std::path::PathBuf;
use std::time::Instant;

use super::super::delivery::Delivery;
use super::super::identify::{NO_LENGTHS, compared, not_computed, other};
use super::sources::sources;
use crate::Error;
use crate::cli::args::Report as Asked;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::diagnostic::Code;
use crate::estimation::{Settings, calibrate};
use crate::files::LoadedCampaign;
use crate::plausibility::{Evidence, Limits, judge, judge_result};
use crate::prediction::with_holding_loads;
use crate::render::html::fitted_page;
use crate::results::{CombinedParameters, FittedReport, Identification};

/// The report of a loaded campaign whose readings hold no lengths, `held_out` those that the fit does not see.
pub fn run(
    command: &Asked,
    session: &Session,
    loaded: LoadedCampaign,
    held_out: &[bool],
    page: Option<PathBuf>,
) -> Result<Output, Error> {
    let (model, campaign) = (&loaded.robot.model, &loaded.campaign);
    let force = session.arguments.force;
    let mut judged = judge(&Evidence::of(model, campaign), &Limits::default());
    Output::gate(&judged, force, &loaded.diagnostics)?;
    let other = command.against.as_deref().map(|name| other(name, &command.campaign, &loaded, session)).transpose()?;
    let bar = session.terminal.bar(None, "{spinner} {msg}");
    let (started, settings) = (Instant::now(), Settings::default());
    let found = calibrate(model, campaign, held_out, &settings, &mut |_: &_| bar.set_message("calibrating".into()))
        .map_err(|error| not_computed(error.into(), model, campaign, session))?;
    drop(bar);
    let loaded_joints = with_holding_loads(model, campaign, &found.values)?;
    let campaign = &*loaded_joints;
    let mut identify = Identification::new(model, campaign, &found, started.elapsed().as_secs_f64());
    let declared = &loaded.robot.robot.calibration.combinations;
    identify.conventions = CombinedParameters::all(declared, model, &found);
    if let Some(other) = &other {
        identify.against = compared(other, model, campaign, &found, &settings)?;
    }
    judged.extend(judge_result(&Evidence::with(model, campaign, &found), &Limits::default()));
    Output::gate(&judged, force, &loaded.diagnostics)?;
    let sources = sources(command, session, &loaded);
    let mut report = FittedReport::new(model, campaign, &found, identify, sources, NO_LENGTHS.into());
    // That it did not converge stands in the report itself.
    judged.retain(|found| found.code != Code::NotConverged);
    let delivery = Delivery { command, session, page, diagnostics: loaded.diagnostics, judged };
    report.diagnostics = delivery.shown();
    let html = fitted_page(&mut report)?;
    let text = format!("{}\n\n{}\n", campaign.name, report.answer.as_deref().unwrap_or_default());
    delivery.finish("report", &report, text, html, report.identify.converged)
}
