//! `solve`: the inverse model.

use nalgebra::{Point3, Rotation3, Vector3};

use super::pose::{beyond_limits, effects_left_out};
use crate::Error;
use crate::cli::args::Solve;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::cli::values::{joints, numbers};
use crate::compensation::deflected;
use crate::diagnostic::Diagnostic;
use crate::files::LoadedRobot;
use crate::kinematics::{Geometry, Hold, InverseSettings, Solution, Target, solve};
use crate::prediction::SinglePredictor;
use crate::render::solve as render;
use crate::results::InverseSolutions;
use crate::simulation::all_points;

/// Errors up to which a target counts as met, m and rad: a pose as `pose` prints it, to 1e-4 mm and 1e-4 deg, is off by 8.7e-8 m and
/// 1.5e-6 rad at most, and robots with fewer than six axes cannot take up even that.
const ROUNDED: f64 = 1.6e-6;

pub fn run(command: &Solve, session: &Session) -> Result<Output, Error> {
    let seed = session.seed();
    let mut loaded = session.reader.robot(&command.robot)?;
    let units = loaded.raw.units;
    let target = numbers("--target", &command.target, &[3, 6])?;
    let (length, angle) = (units.length.factor(), units.angle.factor());
    let position = Point3::new(target[0], target[1], target[2]) * length;
    let rotation = target.get(3..6).map(|r| Rotation3::new(Vector3::new(r[0], r[1], r[2]) * angle));
    let from = command.from.as_deref().map(|text| joints(&loaded.model, &units, text)).transpose()?;
    if let Some(q) = &from {
        loaded.diagnostics.extend(beyond_limits(&loaded, q));
    }
    let geometry = Geometry::nominal(&loaded.model)?;
    let settings =
        InverseSettings { restarts: command.restarts, seed, from, tolerance: ROUNDED, ..InverseSettings::default() };
    let hold = if rotation.is_some() { Hold::POSE } else { Hold::POSITION };
    let target = Target { position, rotation, hold };
    let mut solutions = solve(&geometry, &target, &settings)?;
    if command.weight {
        solutions = under_weight(&mut loaded, &target, solutions)?;
    }
    let mut found = InverseSolutions::new(&loaded.model, &solutions, command.weight);
    if let Some(uncertainty) = loaded.uncertainty() {
        let at = solutions.iter().map(|solution| solution.joints.as_slice());
        for (solution, own) in found.solutions.iter_mut().zip(uncertainty.tool(&loaded.model, at, [0.0; 6])?) {
            solution.standard_uncertainty = Some(own);
        }
    }
    let mut output = Output::new(render::solutions(&found, session.terminal.screen), &found)?;
    output.diagnostics = loaded.diagnostics;
    output.diagnostics.extend(command.weight.then(|| effects_left_out(&loaded.model)).flatten());
    Ok(output)
}

/// The solutions of the rigid robot moved to where the tool is at the target under own weight, preloads and effects; a
/// solution that cannot be moved there is left out with a warning.
///
/// # Errors
/// No solution can be moved there.
fn under_weight(loaded: &mut LoadedRobot, target: &Target, rigid: Vec<Solution>) -> Result<Vec<Solution>, Error> {
    let (model, points) = (&loaded.model, all_points(&loaded.model));
    let predictor = SinglePredictor::new(model, &model.registry.nominal(), &points)?;
    let mut work = predictor.workspace();
    let (mut found, mut why) = (Vec::new(), None);
    for solution in rigid {
        match deflected(&predictor, target, &solution, &mut work) {
            Ok(moved) => found.push(moved),
            Err(refusal) => {
                let text = format!("a solution of the rigid robot is none under own weight: {refusal}");
                loaded.diagnostics.push(Diagnostic::warning(text));
                why = Some(refusal);
            }
        }
    }
    match why {
        Some(refusal) if found.is_empty() => Err(Error::Refusal(refusal)),
        _ => Ok(found),
    }
}
