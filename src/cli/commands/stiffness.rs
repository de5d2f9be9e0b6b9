//! `stiffness`: compliance of the structure at a point.

use nalgebra::Vector3;

use super::pose::{beyond_limits, large, linear};
use crate::Error;
use crate::cli::args::Stiffness;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::cli::values::{joints, nothing_elastic, wrench};
use crate::description::robot::FrameIndex;
use crate::description::validity::State;
use crate::diagnostic::Diagnostic;
use crate::elastics::{
    Elastics, PointLoad, Response, Statics, at_point, equilibrium, fuzzy_doubts, put_fuzzy, shares, spatial,
};
use crate::kinematics::{Geometry, Placements};
use crate::model::{Family, Model, SwitchedOn};
use crate::plausibility::{Limits, as_stiff_as_arms};
use crate::render::stiffness as render;
use crate::results::{OwnWeight, Stiffness as Found};

pub fn run(command: &Stiffness, session: &Session) -> Result<Output, Error> {
    let loaded = session.reader.robot(&command.robot)?;
    let model = &loaded.model;
    let q = joints(model, &loaded.raw.units, &command.joints)?;
    let load = command.wrench.as_deref().map(|text| wrench(&loaded.raw.units, text)).transpose()?;
    let outside = loaded.outside(std::iter::once(State::new(&q, &load.unwrap_or_default())));
    let values = model.shifted(&model.registry.nominal());
    let geometry = Geometry::new(model, &values)?;
    let mut placements = Placements::default();
    geometry.place(&q, &mut placements)?;
    let (name, frame, local) = point(&geometry, command.at.as_deref())?;
    let elastics = Elastics::new(model, &values, &[]);
    linear(model, command.equilibrium)?;
    if !elastics.is_compliant() && model.fuzzy.is_none() {
        return Err(nothing_elastic(""));
    }
    let vertex = model.structure.carrier(frame, &local);
    let point = (placements.frames[frame] * nalgebra::Point3::from(local)).coords;
    let mut statics = Statics::new(command.weight);
    let mut response = Response::new(&elastics, vertex);
    elastics.prepare(&placements, &mut statics)?;
    response.evaluate(&elastics, &mut statics);
    put_fuzzy(&geometry, &placements, &mut response);
    let w = load.unwrap_or_default();
    let (force, moment) = (Vector3::new(w[0], w[1], w[2]), Vector3::new(w[3], w[4], w[5]));
    let loaded_by = spatial(&point, &force, &moment);
    let (displacement, rotation, load_factor) = if command.equilibrium {
        let load = PointLoad::at(vertex, point, force, moment);
        let found = equilibrium(&elastics, &placements, &load, command.weight)?;
        (found.displacement, found.rotation, Some(found.load_factor))
    } else {
        let (displacement, rotation) = at_point(&response.twist(&loaded_by, command.weight), &point);
        (displacement, rotation, None)
    };
    let shares = shares(&elastics, &statics, &response, &loaded_by, command.weight);
    let found = Found {
        deflection: [displacement.x, displacement.y, displacement.z, rotation.x, rotation.y, rotation.z],
        load_factor: load_factor.filter(|factor: &f64| factor.is_finite()),
        own_weight: OwnWeight::nominal(model, command.weight),
        is_loaded: load.is_some() || command.weight,
        ..Found::new(&model.name, name, &response.compliance_at(&point), shares, model.is_by_rules())
    };
    let mut output = Output::new(render::stiffness(&found, session.terminal.screen), &found)?;
    output.diagnostics = beyond_limits(&loaded, &q);
    output.diagnostics.extend(loaded.diagnostics.iter().cloned());
    output.diagnostics.extend(as_stiff_as_arms(model, &Limits::default()));
    output.diagnostics.extend(left_out(model));
    output.diagnostics.extend(outside);
    output.diagnostics.extend((!command.equilibrium).then(|| large("the point", &displacement, &rotation)).flatten());
    let own = command.at.as_deref().map_or(Some(None), |at| model.marker(at).map(Some));
    output.diagnostics.extend(fuzzy_doubts(model, &geometry, &[(q.as_slice(), own)]));
    Ok(output)
}

/// Effects under load that are no constants of the structure, and are in no compliance matrix.
fn left_out(model: &Model) -> Option<Diagnostic> {
    let is_own =
        |on: &&SwitchedOn| on.shifts.is_empty() && on.entry.effect.family(&on.entry.nonlinear) == Family::Elastic;
    let names: Vec<String> = model.effects.iter().filter(is_own).map(|on| on.entry.to_string()).collect();
    (!names.is_empty()).then(|| {
        let message = format!("{}: not linear in the load, and left out of the compliance", names.join(", "));
        Diagnostic::warning(message).remedy("`pose --wrench` and `pose --weight` count what an effect does")
    })
}

/// The point that is loaded: its name, the frame that carries it, and where it is there (m).
fn point(geometry: &Geometry, at: Option<&str>) -> Result<(String, FrameIndex, Vector3<f64>), Error> {
    let model = geometry.model;
    let Some(at) = at else { return Ok(("tool".into(), model.tool.0, geometry.tool().translation.vector)) };
    match (model.frame(at), model.marker(at)) {
        (Some(frame), _) => Ok((at.into(), frame, Vector3::zeros())),
        (_, Some(marker)) => Ok((at.into(), model.markers[marker].frame, geometry.marker(marker).coords)),
        _ => {
            let frames = model.frames.iter().map(|frame| frame.name.as_str());
            let valid = frames.chain(model.markers.iter().map(|marker| marker.name.as_str()));
            Err(Error::unknown(format!("--at: no frame or marker is called `{at}`"), at, valid))
        }
    }
}
