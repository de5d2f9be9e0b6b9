//! `residuals`: a description against measurements, nothing fitted.

use crate::Error;
use crate::cli::args::Residuals;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::{RegistrationSettings, errors_of, registered, with_campaign_fitted};
use crate::files::{LoadedCampaign, writable_table};
use crate::plausibility::misread;
use crate::prediction::residuals;
use crate::render::identification as render;
use crate::render::tables;
use crate::results::units::mm;
use crate::results::{ConfigurationResidual, DescriptionResiduals};

/// Times by which base and tool of the description leave more than those fitted to the readings, from which they are of another set-up. A
/// judgement: tolerances of the robot itself make less.
const ELSEWHERE: f64 = 10.0;

/// A warning where base and tool, which the campaign has unknown, are not those of the description.
fn placed_elsewhere(loaded: &LoadedCampaign, values: &[f64], predicted: &[f64]) -> Option<Diagnostic> {
    let (model, campaign) = (&loaded.robot.model, &loaded.campaign);
    if campaign.is_difference() || !(campaign.estimate_base || campaign.estimate_tool) {
        return None;
    }
    // What cannot be registered has its residuals all the same.
    let (_, placed) = registered(model, campaign, values, &RegistrationSettings::default()).ok()?;
    let [as_described, as_placed] = [predicted, &placed[..]].map(|own| errors_of(campaign, own, |_| true).distance[1]);
    let message = format!(
        "base and tool are those of the description, which leave {:.4} mm of these readings; fitted to them, as `estimate:` of the campaign has \
         it, they leave {:.4} mm",
        mm(as_described),
        mm(as_placed)
    );
    let remedy = "fit them with `register CAMPAIGN --robot DESCRIPTION`";
    let warning = || Diagnostic::warning(message).code(Code::AnotherPlacement).remedy(remedy);
    (as_described > ELSEWHERE * as_placed).then(warning)
}

pub fn run(command: &Residuals, session: &Session) -> Result<Output, Error> {
    for path in command.table.iter().chain(&command.configurations).chain(&command.parts) {
        writable_table(path)?;
    }
    let loaded = session.reader.campaign(&command.on.campaign, Some(&command.on.robot))?;
    let (model, campaign) = (&loaded.robot.model, &loaded.campaign);
    let nominal = model.registry.nominal();
    let (values, fitted) = with_campaign_fitted(model, campaign, &nominal, &RegistrationSettings::default())?;
    let predicted = residuals(model, campaign, &values)?;
    let mut found = DescriptionResiduals::new(model, campaign, &predicted);
    found.fitted = fitted.into_iter().map(|slot| model.registry[slot].name.clone()).collect();
    if let Some(uncertainty) = loaded.robot.uncertainty() {
        if !campaign.is_difference() {
            found = found.with_uncertainties(campaign, &uncertainty.positions(model, &values, campaign)?);
        }
        let configurations = uncertainty.configurations(model, &values, campaign, &predicted)?;
        found.configurations = ConfigurationResidual::all(campaign, &configurations);
    }
    let mut output = Output::new(render::residuals(&found, session.terminal.screen), &found)?;
    if let Some(path) = &command.table {
        output.table("residuals, a reading a row", path, tables::residuals(&found, campaign, path)?);
    }
    if let Some(path) = &command.configurations {
        if found.configurations.is_empty() {
            let message = "--configurations: the description says nothing of how certain its parameters are";
            return Err(Error::input(
                message,
                "give one that `identify --save` wrote, and positions, poses or deflections",
            ));
        }
        let table = tables::configurations(&found.configurations, path)?;
        output.table("observed and predicted error, a configuration a row", path, table);
    }
    if let Some(path) = &command.parts {
        output.table("residuals by session, file and marker", path, tables::parts(&found.parts_and_markers(), path)?);
    }
    let elsewhere = placed_elsewhere(&loaded, &values, &predicted);
    let outside = loaded.outside();
    output.diagnostics = loaded.diagnostics;
    output.diagnostics.extend(outside);
    output.diagnostics.extend(elsewhere);
    // Nothing is fitted and nothing saved: what would be refused elsewhere is a doubt here.
    output.judged(misread(model, campaign), true)
}
