//! `identify`: calibration.

use std::time::Instant;

use super::convert::{can_write, written};
use super::identifiability::{reduction, what};
use crate::Error;
use crate::cli::args::{Identify, LossName, SchemeName, SplitName, WeightsName};
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::cli::values::known_parameters;
use crate::description::campaign::Campaign;
use crate::estimation::{Scheme, Settings, Split, Weights, What, calibrate, compare, split};
use crate::least_squares::Loss;
use crate::model::with_values;
use crate::render::identification as render;
use crate::results::{Identification, SchemeComparison};

pub fn run(command: &Identify, session: &Session) -> Result<Output, Error> {
    let seed = session.seed();
    let by_rules = super::identify_fuzzy::asked(command)?;
    let what = if by_rules { None } else { what(&command.what)? };
    if !(command.loss_scale.is_finite() && command.loss_scale > 0.0) {
        return Err(Error::input(format!("--loss-scale `{}`", command.loss_scale), "give a number above 0"));
    }
    if !(0.0..=0.9).contains(&command.check) {
        return Err(Error::input(format!("--check `{}`", command.check), "give a share from 0 to 0.9"));
    }
    if let Some(path) = &command.save {
        can_write(path)?;
    }
    let (scaling, criterion) = reduction(&command.reduction)?;
    let loaded = session.reader.campaign(&command.campaign, command.robot.as_deref())?;
    let model = &loaded.robot.model;
    known_parameters(model, command.reduction.hold.iter().map(String::as_str))?;
    let settings = Settings { scaling, criterion, ..settings(command, what) };
    let campaign = match command.train {
        Some(count) => fewer(&loaded.campaign, count, command.check, seed),
        None => loaded.campaign.clone(),
    };
    let held_out = split(&campaign, command.check, seed);
    left_to_fit(&campaign, &held_out)?;
    if by_rules {
        return super::identify_fuzzy::run(command, &loaded, &campaign, &held_out, &settings, session);
    }
    let started = Instant::now();
    if command.compare {
        let both = compare(model, &campaign, &held_out, &settings)?;
        let found = SchemeComparison::new(model, &campaign, &both, started.elapsed().as_secs_f64());
        let mut output = Output::new(render::comparison(&found, session.terminal.screen), &found)?;
        output.diagnostics = loaded.diagnostics;
        return Ok(output);
    }
    let bar = session.terminal.bar(None, "{spinner} iteration {pos}  {msg}");
    let found = calibrate(model, &campaign, &held_out, &settings, &mut |progress| {
        bar.set_position(progress.iteration as u64);
        bar.set_message(format!("cost {:.6e}", progress.cost));
        bar.tick();
    })?;
    bar.finish_and_clear();
    let result = Identification::new(model, &campaign, &found, started.elapsed().as_secs_f64());
    let mut output = Output::new(render::identification(&result, session.terminal.screen), &result)?;
    output.diagnostics = loaded.diagnostics;
    output.failed = !found.converged();
    if let Some(path) = &command.save {
        let (text, diagnostics) = written(&with_values(&loaded.robot.raw, model, &found.values), path)?;
        output.diagnostics.extend(diagnostics);
        output.text += &format!("calibrated description: {}\n", path.display());
        output.files.push((path.clone(), text));
    }
    Ok(output)
}

/// What the flags ask of the fit, but for the reduction.
fn settings(command: &Identify, what: Option<What>) -> Settings {
    Settings {
        what,
        split: match command.split {
            SplitName::Prior => Split::Prior,
            SplitName::MinimumNorm => Split::MinimumNorm,
        },
        scheme: match command.scheme {
            SchemeName::Batch => Scheme::Batch,
            SchemeName::PoseByPose => Scheme::PoseByPose,
            SchemeName::Alternating => Scheme::Alternating,
        },
        weights: match command.weights {
            WeightsName::Stated => Weights::Stated,
            WeightsName::Equal => Weights::Equal,
            WeightsName::Direction => Weights::Direction,
        },
        loss: match command.loss {
            LossName::Squares => Loss::Squares,
            LossName::Huber => Loss::Huber(command.loss_scale),
            LossName::Cauchy => Loss::Cauchy(command.loss_scale),
            LossName::Tukey => Loss::Tukey(command.loss_scale),
        },
        prior: command.prior,
        hold: command.reduction.hold.clone(),
        ..Settings::default()
    }
}

/// Refuses a campaign of which all readings, or all that are loaded, are held out to check.
pub fn left_to_fit(campaign: &Campaign, held_out: &[bool]) -> Result<(), Error> {
    let mut fitted = campaign
        .readings
        .iter()
        .zip(held_out)
        .filter(|(_, held_out)| !**held_out)
        .map(|(reading, _)| reading)
        .peekable();
    if fitted.peek().is_none() {
        return Err(Error::input(
            "no reading is left to fit: all are held out to check",
            "mark readings to fit with `fit` in the column `set`",
        ));
    }
    if campaign.observes.is_difference() && fitted.all(|reading| reading.wrench == [0.0; 6]) {
        return Err(Error::input(
            format!("no reading to fit is loaded, and {}s are observed", campaign.observes.name()),
            "mark loaded readings with `fit` in the column `set`",
        ));
    }
    Ok(())
}

/// Only `count` of the configurations that would be fitted, drawn with the seed, and all those to check.
fn fewer(campaign: &Campaign, count: usize, share: f64, seed: u64) -> Campaign {
    use rand::seq::SliceRandom;
    let held_out = split(campaign, share, seed);
    let mut poses: Vec<usize> = campaign
        .readings
        .iter()
        .zip(&held_out)
        .filter(|(_, held_out)| !**held_out)
        .map(|(reading, _)| reading.pose)
        .collect();
    poses.dedup();
    poses.shuffle(&mut crate::simulation::generator(seed));
    poses.truncate(count);
    let mut drawn = campaign.select(|i, reading| held_out[i] || poses.contains(&reading.pose));
    let check: Vec<bool> = campaign
        .readings
        .iter()
        .zip(&held_out)
        .filter(|(reading, held_out)| **held_out || poses.contains(&reading.pose))
        .map(|(_, held_out)| *held_out)
        .collect();
    for (reading, check) in drawn.readings.iter_mut().zip(check) {
        reading.check = Some(check);
    }
    drawn
}
