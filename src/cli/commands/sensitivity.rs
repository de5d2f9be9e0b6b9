//! `sensitivity`: mu_P and mu_Phi of the geometry, and of what gives under the campaign's loads.

use crate::Error;
use crate::cli::args::OnCampaign;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::identifiability::{elastic_parameters, elastic_sensitivities, sensitivities};
use crate::kinematics::Geometry;
use crate::render::identification as render;
use crate::results::Sensitivities;

pub fn run(command: &OnCampaign, session: &Session) -> Result<Output, Error> {
    let loaded = session.reader.campaign(&command.campaign, Some(&command.robot))?;
    let model = &loaded.robot.model;
    let geometry = Geometry::nominal(model)?;
    let found = sensitivities(&geometry, &loaded.campaign, &model.free_slots())?;
    let elastic = elastic_sensitivities(model, &loaded.campaign, &elastic_parameters(model))?;
    let found = Sensitivities::new(model, &loaded.campaign, &found, &elastic);
    let mut output = Output::new(render::sensitivities(&found, session.terminal.screen), &found)?;
    output.diagnostics = loaded.diagnostics;
    Ok(output)
}
