//! `identifiability`: what a campaign can tell.

use crate::Error;
use crate::cli::args::{Identifiability, Reduction as Asked};
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::cli::values::known_parameters;
use crate::estimation::{What, observe};
use crate::identifiability::{Criterion, Scaling};
use crate::render::identification as render;
use crate::results::{OwnWeight, Reduction};

pub fn run(command: &Identifiability, session: &Session) -> Result<Output, Error> {
    let (scaling, criterion) = reduction(&command.reduction)?;
    let loaded = session.reader.campaign(&command.on.campaign, Some(&command.on.robot))?;
    let model = &loaded.robot.model;
    known_parameters(model, command.reduction.hold.iter().map(String::as_str))?;
    let found = observe(model, &loaded.campaign, &command.reduction.hold, scaling, criterion, what(&command.what)?)?;
    let own_weight = OwnWeight::of_campaign(model, &model.registry.nominal(), &loaded.campaign);
    let reduction = Reduction::new(model, &found.slots, &found.identifiability);
    let found = Reduction { own_weight: Some(own_weight), ..reduction };
    let mut output = Output::new(render::reduction(&found, session.terminal.screen), &found)?;
    output.diagnostics = loaded.diagnostics;
    Ok(output)
}

/// Which parameters, as asked for; `None` where nothing is asked.
pub fn what(asked: &[String]) -> Result<Option<What>, Error> {
    let mut what = What { geometric: false, elastic: false };
    for name in asked {
        match name.as_str() {
            "geometric" => what.geometric = true,
            "elastic" => what.elastic = true,
            other => {
                return Err(Error::unknown(format!("--what: unknown `{other}`"), other, ["geometric", "elastic"]));
            }
        }
    }
    Ok((!asked.is_empty()).then_some(what))
}

/// Scaling and criterion as asked for.
pub fn reduction(asked: &Asked) -> Result<(Scaling, Criterion), Error> {
    let criterion = match asked.tolerance.as_str() {
        "noise" => Criterion::Noise,
        number => match number.parse::<f64>() {
            Ok(tolerance) if (0.0..1.0).contains(&tolerance) => Criterion::Relative(tolerance),
            _ => {
                return Err(Error::input(format!("--tolerance `{number}`"), "give a fraction in [0, 1), or `noise`"));
            }
        },
    };
    Ok((asked.scale, criterion))
}
