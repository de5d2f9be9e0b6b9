//! `solve`: the inverse model.

use nalgebra::{Point3, Rotation3, Vector3};

use super::pose::beyond_limits;
use crate::Error;
use crate::cli::args::Solve;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::cli::values::{joints, numbers};
use crate::kinematics::{Geometry, InverseSettings, Target, solve};
use crate::render::solve as render;
use crate::results::InverseSolutions;

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
    let settings = InverseSettings { restarts: command.restarts, seed, from, ..InverseSettings::default() };
    let solutions = solve(&geometry, &Target { position, rotation }, &settings)?;
    let found = InverseSolutions::new(&loaded.model, &solutions);
    let mut output = Output::new(render::solutions(&found, session.terminal.screen), &found)?;
    output.diagnostics = loaded.diagnostics;
    Ok(output)
}
