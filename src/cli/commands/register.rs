//! `register`: where the robot stands and what its tool is, everything else as described.

use super::convert::can_write;
use super::identify::{Asked, calibrated, left_to_fit, loss};
use crate::Error;
use crate::cli::args::{LossName, Register, Robust};
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::cli::values::known_parameters;
use crate::description::campaign::{Campaign, Target};
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::{Settings, split};
use crate::plausibility::far_when_registered;

pub fn run(command: &Register, session: &Session) -> Result<Output, Error> {
    let loss = loss(&command.robust)?;
    command.save.as_deref().map_or(Ok(()), can_write)?;
    let loaded = session.reader.campaign(&command.campaign, command.robot.as_deref())?;
    let campaign = &loaded.campaign;
    known_parameters(&loaded.robot.model, command.hold.iter().map(String::as_str))?;
    if campaign.is_difference() {
        return Err(Error::input(
            format!("{}s do not determine the robot's base", campaign.observes.name()),
            "register positions, poses or distances",
        ));
    }
    let is_known = !campaign.estimate_base && !campaign.estimate_tool && !campaign.estimate_scale;
    if is_known && !campaign.targets.iter().any(Target::is_estimated) {
        return Err(Error::input(
            "the campaign declares neither base nor tool unknown: there is nothing to register",
            "write `estimate: {base: true, tool: true}` in the campaign file",
        ));
    }
    let settings = Settings { only: Some(Vec::new()), loss, hold: command.hold.clone(), ..Settings::default() };
    let asked = Asked { save: command.save.as_deref(), ..Asked::default() };
    let of = |campaign: &Campaign, settings: &Settings| {
        let held_out = split(campaign, command.check, session.seed());
        left_to_fit(campaign, &held_out)?;
        calibrated(session, &loaded, campaign, &held_out, settings, &asked)
    };
    // A few readings that are far off move base and tool by millimetres.
    let may_leave_out = command.robust.loss != Some(LossName::Squares);
    let far = may_leave_out.then(|| far_when_registered(&loaded.robot.model, campaign, session.seed())).flatten();
    if let Some((wrong, diagnostic)) = far {
        let mut found = of(&campaign.select(|reading, _| !wrong.contains(&reading)), &settings)?;
        found.diagnostics.push(diagnostic);
        return Ok(found);
    }
    let found = of(campaign, &settings)?;
    let is_far = |of: &Diagnostic| of.code == Code::OutlyingReadings;
    if command.robust.loss.is_some() || !found.diagnostics.iter().any(is_far) {
        return Ok(found);
    }
    // Contacts, anchors and sensors are estimated too, of which the better half of the readings need not hold all.
    let robust = super::identify::loss(&Robust { loss: Some(LossName::Cauchy), ..command.robust })?;
    let mut found = of(campaign, &Settings { loss: robust, ..settings })?;
    let message = "readings that are far off count little here (`--loss cauchy`)";
    found.diagnostics.push(Diagnostic::warning(message).remedy("with `--loss squares` all readings count alike"));
    Ok(found)
}
