//! Which commands find what a report shows.

use crate::cli::args::Report as Asked;
use crate::cli::session::Session;
use crate::files::LoadedCampaign;
use crate::results::Sources;

/// Commands that find the same.
pub fn sources(command: &Asked, session: &Session, loaded: &LoadedCampaign) -> Sources {
    let mut given = command.campaign.clone();
    given += &command.robot.as_ref().map_or(String::new(), |robot| format!(" --robot {robot}"));
    given += &if session.seed() == 1 { String::new() } else { format!(" --seed {}", session.seed()) };
    let robot = command.robot.clone().or(loaded.raw.robot.clone()).unwrap_or_default();
    Sources::new(&given, &robot)
}
