//! `sensitivity`: mu_P and mu_Phi.

use crate::cli::args::OnCampaign;
use crate::cli::{Failure, Output};
use crate::files::load_campaign;
use crate::identifiability::sensitivities;
use crate::kinematics::Geometry;
use crate::render::identification::{sensitivity_json, sensitivity_text};

pub fn run(command: &OnCampaign) -> Result<Output, Failure> {
    let loaded = load_campaign(&command.campaign, Some(&command.robot))?;
    let model = &loaded.robot.model;
    let geometry = Geometry::nominal(model).map_err(Failure::computation)?;
    let found = sensitivities(&geometry, &loaded.campaign, &model.free_slots()).map_err(Failure::computation)?;
    let mut output = Output::new(sensitivity_text(model, &found), sensitivity_json(model, &found));
    output.diagnostics = loaded.diagnostics;
    Ok(output)
}
