//! `identify --what fuzzy|grey|local`: a fuzzy compliance, a fuzzy correction of springs, or local springs blended by fuzzy rules.

use std::path::Path;
use std::time::Instant;

use serde::Serialize;

use super::convert::{Expected, unusable, written};
use super::schema::file_name;
use crate::Error;
use crate::cli::args::{Identify, PlacementName, SchemaOf};
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::description::campaign::{Campaign, LoadPoint, Reading};
use crate::description::fuzzy::Input;
use crate::description::raw::{JointKind, RawFuzzy};
use crate::description::yaml;
use crate::estimation::fuzzy::{
    AxesOf, FuzzySettings, FuzzyTask, Placement, Step, Structure, changing_inputs, fit_fuzzy, fit_grey, fit_local,
};
use crate::estimation::{Settings, What, calibrate};
use crate::files::{LoadedCampaign, schema_line};
use crate::least_squares::Progress;
use crate::math::norm;
use crate::model::{Model, with_fuzzy, with_values};
use crate::prediction::residuals;
use crate::render::fuzzy as render;
use crate::results::{
    FuzzyCompliance, GreyCompliance, GrowthStep, LocalSpringsFound, MethodComparison, MethodErrors, Timed,
};

const KINDS: [&str; 5] = ["geometric", "elastic", "fuzzy", "grey", "local"];
/// Those that are rules.
const RULES: [&str; 3] = ["fuzzy", "grey", "local"];

/// What to do where a flag of rules stands without them.
const ADD_RULES: &str = "add --what fuzzy, grey or local";

/// Whether rules are asked for.
pub fn asked(command: &Identify) -> Result<bool, Error> {
    if let Some(unknown) = command.what.iter().find(|name| !KINDS.contains(&name.as_str())) {
        return Err(Error::unknown(format!("--what: unknown `{unknown}`"), unknown, KINDS));
    }
    let has = |name: &str| command.what.iter().any(|what| what == name);
    let by_rules = RULES.iter().any(|name| has(name));
    if by_rules && has("geometric") {
        return Err(Error::input(
            "--what: geometry is not fitted together with rules",
            "identify the geometry first and --save it, then --what fuzzy, grey or local",
        ));
    }
    if by_rules && (command.what.len() > 1 || command.compare) && command.save.is_some() {
        let remedy = if command.compare { "leave --compare out to save one" } else { "ask for one with --what" };
        return Err(Error::input("--save: several models are compared", remedy));
    }
    if !by_rules && command.save_rules.is_some() {
        return Err(Error::input("--save-rules: no rules are asked for", ADD_RULES));
    }
    let of_rules = !command.inputs.is_empty() || command.fit_force.is_some() || command.structure.is_some();
    if !by_rules && (of_rules || command.axes.is_some() || command.reciprocal) {
        let message = "--inputs, --structure, --axes, --reciprocal, --fit-force: no rules are asked for";
        return Err(Error::input(message, ADD_RULES));
    }
    if command.reciprocal && command.structure == Some(Structure::Grid) {
        return Err(Error::input(
            "--reciprocal: on a grid each component has sets of its own",
            "take --structure tree, in which components share their splits",
        ));
    }
    if by_rules && command.prior {
        return Err(Error::input("--prior: rules have no tolerances", "leave it out"));
    }
    Ok(by_rules)
}

pub fn run(
    command: &Identify,
    loaded: &LoadedCampaign,
    campaign: &Campaign,
    held_out: &[bool],
    settings: &Settings,
    session: &Session,
) -> Result<Output, Error> {
    let model = &loaded.robot.model;
    holds_rules(campaign)?;
    let (fitted, of_fitted) = match command.fit_force {
        Some(force) => under(campaign, held_out, force)?,
        None => (campaign.clone(), held_out.to_vec()),
    };
    let inputs = inputs(model, &fitted, &command.inputs, structure(command))?;
    let placement = match command.placement {
        PlacementName::GaussNewton => Placement::GaussNewton,
        PlacementName::SolisWets => Placement::SolisWets(session.seed()),
    };
    let limits = FuzzySettings { placement, ..FuzzySettings::default() };
    let task = FuzzyTask {
        model,
        campaign: &fitted,
        held_out: &of_fitted,
        inputs: &inputs,
        structure: structure(command),
        axes: axes(model, command.axes.as_deref())?,
        reciprocal: command.reciprocal,
        settings: limits,
    };
    let fit = Fit { command, loaded, task: &task, settings, session, started: Instant::now() };
    let mut output = if command.compare || command.what.len() > 1 {
        // What was not fitted: held out, or under another load.
        let judges = campaign.readings.iter().zip(held_out);
        let judges: Vec<bool> = judges.map(|(r, held_out)| *held_out || !is_under(r, command.fit_force)).collect();
        fit.compared(campaign, &judges)?
    } else {
        fit.alone()?
    };
    output.diagnostics.extend(loaded.diagnostics.iter().cloned());
    Ok(output)
}

/// Rules to be fitted.
struct Fit<'a> {
    command: &'a Identify,
    loaded: &'a LoadedCampaign,
    task: &'a FuzzyTask<'a>,
    settings: &'a Settings,
    session: &'a Session<'a>,
    started: Instant,
}

impl Fit<'_> {
    fn asks(&self, name: &str) -> bool {
        self.command.what.iter().any(|what| what == name)
    }

    fn output(&self, text: String, found: &impl Serialize) -> Result<Output, Error> {
        Output::new(text, &Timed { seconds: self.started.elapsed().as_secs_f64(), found })
    }

    /// The one kind of rules asked for, saved where that is asked for too.
    fn alone(&self) -> Result<Output, Error> {
        let Self { task, settings, session, .. } = *self;
        let screen = session.terminal.screen;
        let bar = session.terminal.bar(None, "{spinner} {msg}");
        let taken = |step: &Step| bar.set_message(render::step(&GrowthStep::new(step)));
        let mut iterated = |progress: &Progress| bar.set_message(springs(progress));
        if self.asks("fuzzy") {
            let fit = fit_fuzzy(task, &taken)?;
            let found = FuzzyCompliance::new(&fit);
            return self.saved(self.output(render::fuzzy(&found, screen), &found)?, &fit.model, &fit.values);
        }
        if self.asks("local") {
            let fit = fit_local(task, settings, &mut iterated, &mut |step| {
                let error = 1e3 * step.cross_validated;
                bar.set_message(format!("{} rules, cross-validated error {error:.4} mm", step.rules));
            })?;
            let found = LocalSpringsFound::new(&fit);
            return self.saved(self.output(render::local(&found, screen), &found)?, &fit.model, &fit.parametric.values);
        }
        let fit = fit_grey(task, settings, &mut iterated, &taken)?;
        let found = GreyCompliance::new(&fit);
        let with = fit.correction.as_ref().map_or(task.model, |correction| &correction.model);
        self.saved(self.output(render::grey(&found, screen), &found)?, with, &fit.parametric.values)
    }

    /// All methods asked for side by side, over the readings of a campaign that count.
    fn compared(&self, whole: &Campaign, judges: &[bool]) -> Result<Output, Error> {
        let bar = self.session.terminal.bar(None, "{spinner} {msg}");
        let taken = |step: &Step| bar.set_message(render::step(&GrowthStep::new(step)));
        let mut iterated = |progress: &Progress| bar.set_message(springs(progress));
        let (methods, dropped) = self.methods(whole, judges, &mut iterated, &taken)?;
        let found = MethodComparison { unit: "mm", check: judges.contains(&true), methods };
        let mut output = self.output(render::methods(&found, self.session.terminal.screen), &found)?;
        if dropped {
            output.text +=
                "grey: no correction is kept, since none helps readings that it has not seen; these are the springs\n";
        }
        Ok(output)
    }

    /// Errors of all methods asked for, over the readings of the `whole` campaign that count (`judges`); and whether the correction of the grey one
    /// was dropped.
    fn methods(
        &self,
        whole: &Campaign,
        judges: &[bool],
        iterated: &mut dyn FnMut(&Progress),
        taken: &(dyn Fn(&Step) + Sync),
    ) -> Result<(Vec<MethodErrors>, bool), Error> {
        let Self { task, settings, .. } = *self;
        let model = task.model;
        let errors = |method, model: &Model, values: &[f64]| -> Result<MethodErrors, Error> {
            let found = residuals(model, whole, values)?;
            Ok(MethodErrors::new(method, whole, judges, &found))
        };
        let has = |name: &str| self.command.compare || self.asks(name);
        let mut methods = Vec::new();
        let mut dropped = false;
        if has("elastic") {
            let elastic = Settings { what: Some(What { geometric: false, elastic: true }), ..settings.clone() };
            let found = calibrate(model, task.campaign, task.held_out, &elastic, iterated)?;
            methods.push(errors("parametric", model, &found.values)?);
        }
        if has("fuzzy") {
            let fit = fit_fuzzy(task, taken)?;
            methods.push(errors("fuzzy", &fit.model, &fit.values)?);
        }
        if has("grey") {
            let fit = fit_grey(task, settings, iterated, taken)?;
            dropped = fit.correction.is_none();
            let with = fit.correction.as_ref().map_or(model, |correction| &correction.model);
            methods.push(errors("grey", with, &fit.parametric.values)?);
        }
        if has("local") {
            let fit = fit_local(task, settings, iterated, &mut |_| {})?;
            methods.push(errors("local springs", &fit.model, &fit.parametric.values)?);
        }
        Ok((methods, dropped))
    }

    /// With the description and the rules written that the command asks for.
    fn saved(&self, mut output: Output, model: &Model, values: &[f64]) -> Result<Output, Error> {
        let Self { command, loaded, session, .. } = *self;
        let Some(path) = &command.save else { return Ok(output) };
        let mut raw = with_fuzzy(&with_values(&loaded.robot.raw, model, values), model);
        if let Some(refused) =
            unusable(&raw, session, &Expected { campaign: &loaded.campaign, residual: None, fitted: (model, values) })?
        {
            output.not_written(path, None);
            output.diagnostics.push(refused);
            return Ok(output);
        }
        if command.save_rules.is_some() && raw.fuzzy.is_none() {
            output.text += "no rules are kept, so that --save-rules writes no file\n";
        }
        if let (Some(file), Some(fuzzy)) = (&command.save_rules, &raw.fuzzy) {
            let line = schema_line(file, file_name(SchemaOf::Rules));
            let text = line + &yaml::write(fuzzy)?;
            let named = relative(file, path)?;
            output.file("identified rules", file, text);
            raw.fuzzy = Some(RawFuzzy { file: Some(named), ..RawFuzzy::default() });
        }
        let (text, diagnostics) = written(&raw, path)?;
        output.diagnostics.extend(diagnostics);
        output.file("identified description", path, text);
        Ok(output)
    }
}

fn springs(progress: &Progress) -> String {
    format!("springs: iteration {}", progress.iteration)
}

/// Refuses readings to which rules cannot be fitted.
fn holds_rules(campaign: &Campaign) -> Result<(), Error> {
    if !campaign.is_difference() {
        return Err(Error::input(
            "rules are fitted to deflections alone, and the campaign observes something else",
            "measure loaded minus unloaded positions (`observes: deflection`), and give them a campaign of their own",
        ));
    }
    let several = campaign.readings.iter().any(|reading| reading.marker != campaign.readings[0].marker);
    if several && campaign.readings.iter().any(|reading| reading.load_point == LoadPoint::Measured) {
        return Err(Error::input(
            "rules are those of one body under one load, and the loads act at each of several markers",
            "say where on the tool they act (`load_point`), or give the readings of one marker",
        ));
    }
    Ok(())
}

/// How rules divide the inputs, as asked for; components that share splits need a tree.
fn structure(command: &Identify) -> Option<Structure> {
    command.structure.or(command.reciprocal.then_some(Structure::Tree))
}

/// Axes of the components, as asked for.
fn axes(model: &Model, name: Option<&str>) -> Result<AxesOf, Error> {
    match name {
        None => Ok(AxesOf::Best),
        Some("base") => Ok(AxesOf::Base),
        Some(name) => model.frame(name).map(AxesOf::Frame).ok_or_else(|| {
            let frames = model.frames.iter().map(|frame| frame.name.as_str()).chain(["base"]);
            Error::unknown(format!("--axes: no frame is called `{name}`"), name, frames)
        }),
    }
}

fn is_under(reading: &Reading, force: Option<f64>) -> bool {
    let size = norm(&reading.wrench[..3]);
    force.is_none_or(|force| (size - force).abs() < 1e-3 * force.max(1.0))
}

/// Readings under one force.
fn under(campaign: &Campaign, held_out: &[bool], force: f64) -> Result<(Campaign, Vec<bool>), Error> {
    let of = |reading: &Reading| is_under(reading, Some(force));
    let found = campaign.select(|_, reading| of(reading));
    let set: Vec<bool> =
        campaign.readings.iter().zip(held_out).filter(|(r, _)| of(r)).map(|(_, held_out)| *held_out).collect();
    if set.iter().all(|held_out| *held_out) {
        let mut sizes: Vec<String> = campaign.readings.iter().map(|r| format!("{:.0}", norm(&r.wrench[..3]))).collect();
        sizes.sort_by(|a, b| (a.len(), a).cmp(&(b.len(), b)));
        sizes.dedup();
        return Err(Error::input(
            format!("--fit-force {force}: no reading to fit is under that force"),
            format!("forces in the campaign, N: {}", sizes.join(", ")),
        ));
    }
    Ok((found, set))
}

/// A file's name as a file at `from` would call it.
fn relative(file: &Path, from: &Path) -> Result<String, Error> {
    let refuse = |what: String, remedy| Err(Error::input(format!("--save-rules {}: {what}", file.display()), remedy));
    if !file.extension().is_some_and(|extension| extension == "yaml" || extension == "yml") {
        return refuse("rules are YAML".into(), "end the name in .yaml");
    }
    if !from.extension().is_some_and(|extension| extension == "yaml" || extension == "yml") {
        return refuse("only a YAML description can name a file of rules".into(), "end the name of --save in .yaml");
    }
    if file == from {
        return refuse("that is the file of --save".into(), "give another file");
    }
    let folder = from.parent().unwrap_or(Path::new(""));
    let inside = file.strip_prefix(folder).ok();
    match inside.or(file.is_absolute().then_some(file)).and_then(Path::to_str) {
        Some(name) => Ok(name.to_string()),
        None => refuse("it is not in the folder of --save".into(), "write it there, or give its whole path"),
    }
}

/// Inputs as named, or what changes in the readings.
fn inputs(
    model: &Model,
    campaign: &Campaign,
    names: &[String],
    structure: Option<Structure>,
) -> Result<Vec<Input>, Error> {
    if names.is_empty() {
        return Ok(changing_inputs(model, campaign, structure)?);
    }
    let mut inputs = Vec::new();
    for (k, name) in names.iter().enumerate() {
        let variable = model.variables.iter().position(|variable| variable.name == *name);
        let joint = model.frame(name).filter(|&frame| model.frames[frame].joint != JointKind::Fixed);
        match (variable, joint) {
            _ if names[..k].contains(name) => {
                return Err(Error::input(format!("--inputs: `{name}` is given twice"), "name each input once"));
            }
            (Some(variable), _) => inputs.push(Input::Variable(variable)),
            (None, Some(frame)) => inputs.push(Input::Joint(frame)),
            (None, None) => {
                let variables = model.variables.iter().map(|variable| variable.name.as_str());
                let joints = model.frames.iter().filter(|frame| frame.moves()).map(|frame| frame.name.as_str());
                let message = format!("--inputs: no joint or variable is called `{name}`");
                return Err(Error::unknown(message, name, variables.chain(joints)));
            }
        }
    }
    Ok(inputs)
}
