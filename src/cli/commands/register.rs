//! `register`: where the robot stands and what its tool is, everything else as described.

use super::convert::can_write;
use super::identify::{Asked, calibrated, left_to_fit, loss};
use crate::Error;
use crate::cli::args::{LossName, Register};
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::cli::values::known_parameters;
use crate::description::campaign::{Campaign, Target};
use crate::estimation::{Settings, split};
use crate::plausibility::far_when_registered;

pub fn run(command: &Register, session: &Session) -> Result<Output, Error> {
    let loss = loss(&command.robust)?;
    command.save.as_deref().map_or(Ok(()), can_write)?;
    let loaded = session.reader.campaign(&command.campaign, command.robot.as_deref())?;
    let campaign = &loaded.campaign;
    known_parameters(&loaded.robot.model, command.hold.iter().map(String::as_str))?;
    if campaign.observes.is_difference() {
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
    let of = |campaign: &Campaign| {
        let held_out = split(campaign, command.check, session.seed());
        left_to_fit(campaign, &held_out)?;
        calibrated(session, &loaded, campaign, &held_out, &settings, &asked)
    };
    // A few readings that are far off move base and tool by millimetres.
    let may_leave_out = command.robust.loss != Some(LossName::Squares);
    match may_leave_out.then(|| far_when_registered(&loaded.robot.model, campaign, session.seed())).flatten() {
        Some((wrong, diagnostic)) => {
            let mut found = of(&campaign.select(|reading, _| !wrong.contains(&reading)))?;
            found.diagnostics.push(diagnostic);
            Ok(found)
        }
        None => of(campaign),
    }
}
