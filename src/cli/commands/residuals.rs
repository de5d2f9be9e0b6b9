//! `residuals`: a description against measurements, nothing fitted.

use crate::Error;
use crate::cli::args::OnCampaign;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::prediction::{Linearised, Predictor};
use crate::render::identification as render;
use crate::results::DescriptionResiduals;

pub fn run(command: &OnCampaign, session: &Session) -> Result<Output, Error> {
    let loaded = session.reader.campaign(&command.campaign, Some(&command.robot))?;
    let (model, campaign) = (&loaded.robot.model, &loaded.campaign);
    let mut predicted = Linearised::default();
    Predictor::new(model, campaign, Vec::new())?.linearise(&model.registry.nominal(), false, &mut predicted)?;
    let found = DescriptionResiduals::new(model, campaign, &predicted.residual);
    let mut output = Output::new(render::residuals(&found, session.terminal.screen), &found)?;
    output.diagnostics = loaded.diagnostics;
    Ok(output)
}
