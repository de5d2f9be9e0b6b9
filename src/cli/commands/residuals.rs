//! `residuals`: a description against measurements, nothing fitted.

use crate::Error;
use crate::cli::args::Residuals;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::files::writable_table;
use crate::plausibility::misread;
use crate::prediction::{Linearised, Predictor};
use crate::render::identification as render;
use crate::render::tables;
use crate::results::DescriptionResiduals;

pub fn run(command: &Residuals, session: &Session) -> Result<Output, Error> {
    if let Some(path) = &command.table {
        writable_table(path)?;
    }
    let loaded = session.reader.campaign(&command.on.campaign, Some(&command.on.robot))?;
    let (model, campaign) = (&loaded.robot.model, &loaded.campaign);
    let mut predicted = Linearised::default();
    Predictor::new(model, campaign, Vec::new())?.linearise(&model.registry.nominal(), false, &mut predicted)?;
    let mut found = DescriptionResiduals::new(model, campaign, &predicted.residual);
    if let Some(uncertainty) = loaded.robot.uncertainty().filter(|_| !campaign.is_difference()) {
        found = found.with_uncertainties(&uncertainty.positions(model, campaign)?);
    }
    let mut output = Output::new(render::residuals(&found, session.terminal.screen), &found)?;
    if let Some(path) = &command.table {
        output.tables.push((path.clone(), tables::residuals(&found, campaign, path)?));
        output.text += &format!("residuals, a reading a row: {}\n", path.display());
    }
    let outside = loaded.outside();
    output.diagnostics = loaded.diagnostics;
    output.diagnostics.extend(outside);
    // Nothing is fitted and nothing saved: what would be refused elsewhere is a doubt here.
    output.judged(misread(model, campaign), true)
}
