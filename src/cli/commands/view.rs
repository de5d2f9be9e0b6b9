//! `view`: the robot itself.

use super::pose::beyond_limits;
use super::report::page;
use crate::Error;
use crate::cli::args::View;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::cli::values::{joints, nothing_elastic, numbers, wrench};
use crate::elastics::Elastics;
use crate::kinematics::Placements;
use crate::render::html::{Look, figure, magnification, view_page};
use crate::results::{OwnWeight, View as Shown};
use crate::review::shot;
use crate::scene::draw;
use crate::state::{Loads, Mechanics};

pub fn run(command: &View, session: &Session) -> Result<Output, Error> {
    let path = page(session.arguments, "view.html", command.svg.as_deref())?;
    let look = match numbers("--look", &command.look, &[2])?[..] {
        [yaw, pitch] => Look { yaw, pitch },
        _ => Look::default(),
    };
    let loaded = session.reader.robot(&command.robot)?;
    let (model, units) = (&loaded.model, &loaded.raw.units);
    let loads = Loads { weight: command.weight, wrench: true };
    let mechanics = Mechanics::new(model, &model.shifted(&model.registry.nominal()), loads, &[])?;
    let geometry = &mechanics.geometry;
    let mut placements = Placements::default();
    let mut q = joints(model, units, command.joints.as_deref().unwrap_or(""))?;
    if command.joints.is_none() && geometry.place(&q, &mut placements).is_err() {
        q = model.middle();
    }
    geometry.place(&q, &mut placements)?;
    let scene = draw(&loaded.robot, geometry, &placements);
    let Some(mut shot) = shot(&scene, &mechanics, &q, model.name.clone(), Vec::new()) else {
        return Err(Error::Impossible {
            message: "the robot cannot be assembled at this configuration".into(),
            remedy: "give joint values within limits at which the loops close (`--joints`)",
        });
    };
    let load = command.wrench.as_deref().map(|text| wrench(units, text)).transpose()?;
    let is_loaded = load.is_some() || command.weight;
    if load.is_some() && model.is_by_rules() {
        return Err(Error::input(
            "the compliance is fuzzy (`fuzzy`), so no deflected shape exists",
            "leave --wrench out, or view the description without `fuzzy`; `stiffness` gives the displacement",
        ));
    }
    if is_loaded {
        if !Elastics::new(model, geometry.values(), &[]).is_compliant() {
            return Err(nothing_elastic(", so that nothing can be deflected"));
        }
        let mut state = mechanics.state();
        mechanics.place(&q, &mut state)?;
        shot.moved = scene.deflect(&mechanics, &state, &shot.points, &load.unwrap_or_default());
    }
    let magnified = if is_loaded { magnification(&shot) } else { 1.0 };
    let shown = Shown {
        source: source(command),
        load: is_loaded.then(|| in_words(load.as_ref(), command.weight)),
        magnified,
        own_weight: OwnWeight::nominal(model, command.weight),
        ..Shown::new(model, &q, &scene, &shot)
    };
    let (html, words) = view_page(&shown, &scene, &shot)?;
    let weight = shown.own_weight.words("--weight draws its deflection");
    let mut output = Output::new(format!("{words}\n{weight}\n"), &shown)?;
    output.diagnostics = beyond_limits(&loaded, &q);
    output.diagnostics.extend(loaded.diagnostics.iter().cloned());
    if let Some(svg) = &command.svg {
        output.file("drawing", svg, figure(&scene, &shot, look, magnified, !command.no_names, &words));
    }
    output.page("view", path.as_deref(), html);
    Ok(output)
}

fn in_words(load: Option<&[f64; 6]>, weight: bool) -> String {
    let mut words = Vec::new();
    if let Some([fx, fy, fz, mx, my, mz]) = load {
        words.push(format!("force {fx:.1}, {fy:.1}, {fz:.1} N and moment {mx:.1}, {my:.1}, {mz:.1} N.m"));
    }
    if weight {
        words.push("own weight and preloads".into());
    }
    words.join(" with ")
}

/// The command line that shows the same.
fn source(command: &View) -> String {
    let mut line = format!("elastogeo view {}", command.robot);
    for (flag, value) in [("--joints", &command.joints), ("--wrench", &command.wrench)] {
        line += &value.as_ref().map_or(String::new(), |value| format!(" {flag} {value}"));
    }
    line + if command.weight { " --weight" } else { "" }
}
