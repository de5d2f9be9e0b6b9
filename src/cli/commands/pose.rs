//! `pose`: the forward model.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::Error;
use crate::cli::args::Pose;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::cli::values::{joints, wrench};
use crate::description::campaign::WRENCH;
use crate::description::limits::beyond;
use crate::description::table::{ColumnKind, Dialect, ExpectedColumn, read_table};
use crate::diagnostic::Diagnostic;
use crate::elastics::{Elastics, PointLoad, Response, Statics, equilibrium};
use crate::files::LoadedRobot;
use crate::fuzzy;
use crate::kinematics::{Geometry, Placements};
use crate::render::pose as render;
use crate::results::{Pose as Found, Poses};
use crate::simulation::Loaded;

pub fn run(command: &Pose, session: &Session) -> Result<Output, Error> {
    let mut loaded = session.reader.robot(&command.robot)?;
    let load = command.wrench.as_deref().map(|text| wrench(&loaded.raw.units, text)).transpose()?;
    let configurations = match (&command.joints, &command.table) {
        (_, Some(path)) => {
            let (rows, warnings) = read(session, &loaded, path, &[])?;
            loaded.diagnostics.extend(warnings);
            rows.into_iter().map(|(q, _)| q).collect()
        }
        (Some(text), None) => {
            let q = joints(&loaded.model, &loaded.raw.units, text)?;
            loaded.diagnostics.extend(beyond_limits(&loaded, &q));
            vec![q]
        }
        (None, None) => return Err(Error::input("no configuration", "give --joints or --table")),
    };
    linear(&loaded.model, command.equilibrium)?;
    let geometry = Geometry::nominal(&loaded.model)?;
    let mut placements = Placements::default();
    let mut poses = Vec::new();
    for (row, q) in configurations.iter().enumerate() {
        if let Err(error) = geometry.place(q, &mut placements) {
            let error = Error::from(error);
            return Err(if command.table.is_some() { error.at(format!("row {}", row + 1)) } else { error });
        }
        let pose = Found::new(&geometry, &placements);
        poses.push(match &load {
            Some(load) => pose.deflected(deflected(&geometry, q, &placements, load, command.equilibrium)?),
            None => pose,
        });
    }
    let text = poses.iter().map(|pose| render::pose(pose, session.terminal.screen)).collect();
    let mut output = match &poses[..] {
        [pose] if command.table.is_none() => Output::new(text, pose)?,
        _ => Output::new(text, &Poses { poses })?,
    };
    output.diagnostics = loaded.diagnostics;
    Ok(output)
}

/// Refuses an equilibrium where a fuzzy compliance, linear in the load, stands for the structure.
pub fn linear(model: &crate::model::Model, at_equilibrium: bool) -> Result<(), Error> {
    if at_equilibrium && model.fuzzy.is_some() {
        return Err(Error::input(
            "--equilibrium: the description's fuzzy compliance is linear in the load",
            "leave --equilibrium out",
        ));
    }
    Ok(())
}

/// Displacement and rotation of the tool and every marker, each loaded by the wrench and own weight.
fn deflected(
    geometry: &Geometry,
    q: &[f64],
    placements: &Placements,
    load: &[f64; 6],
    at_equilibrium: bool,
) -> Result<Vec<(String, [f64; 6])>, Error> {
    let model = geometry.model;
    let elastics = Elastics::new(model, geometry.values(), &[]);
    let (force, moment) = (Vector3::new(load[0], load[1], load[2]), Vector3::new(load[3], load[4], load[5]));
    let mut statics = Statics::new(true);
    elastics.prepare(placements, &mut statics)?;
    let tool = ("tool".to_string(), model.tool.0, geometry.tool().translation.vector);
    let markers = model.markers.iter().enumerate();
    let markers =
        markers.map(|(m, marker)| (format!("marker {}", marker.name), marker.frame, geometry.marker(m).coords));
    let mut all = Vec::new();
    for (name, frame, local) in std::iter::once(tool).chain(markers) {
        let vertex = model.structure.carrier(frame, &local);
        let point = (placements.frames[frame] * nalgebra::Point3::from(local)).coords;
        let (d, r) = if at_equilibrium {
            let found = equilibrium(&elastics, placements, &PointLoad { vertex, point, force, moment }, true);
            let found = found?;
            (found.displacement, found.rotation)
        } else {
            let mut response = Response::new(&elastics, vertex);
            response.evaluate(&elastics, &mut statics);
            fuzzy::put(geometry, q, placements, &mut response);
            response.displacement(&point, &force, &moment, true)
        };
        all.push((name, [d.x, d.y, d.z, r.x, r.y, r.z]));
    }
    Ok(all)
}

/// Configurations of a CSV with one column a variable, in the description's units, with the load of each row: columns
/// fx, fy, fz, mx, my, mz, which may be absent; and warnings of limits. The name of a row and the pose that
/// `compensate --table` writes next to the joints are ignored.
pub fn loaded_configurations(
    session: &Session,
    loaded: &LoadedRobot,
    path: &std::path::Path,
) -> Result<(Vec<Loaded>, Vec<Diagnostic>), Error> {
    read(session, loaded, path, &WRENCH)
}

/// Columns that `plan` and `compensate` write next to the joints.
const IGNORED: [&str; 7] = ["pose", "x", "y", "z", "rx", "ry", "rz"];

/// Warnings of joints given beyond the description's limits.
pub fn beyond_limits(loaded: &LoadedRobot, q: &[f64]) -> Vec<Diagnostic> {
    beyond(&loaded.model.variables, &loaded.raw.units, "configurations", std::iter::once(q), |_, _| None)
}

fn read(
    session: &Session,
    loaded: &LoadedRobot,
    path: &std::path::Path,
    also: &[&str],
) -> Result<(Vec<Loaded>, Vec<Diagnostic>), Error> {
    let name = path.display().to_string();
    let file = session.reader.table(path).map_err(|diagnostic| {
        let diagnostic = if diagnostic.remedy.is_some() {
            diagnostic
        } else {
            diagnostic.remedy("give a CSV with one column a variable")
        };
        Error::from(vec![diagnostic])
    })?;
    let variables = loaded.model.variables.iter().map(|variable| (variable.name.as_str(), true));
    let expected: Vec<ExpectedColumn> = variables
        .chain(also.iter().map(|&name| (name, false)))
        .map(|(name, required)| ExpectedColumn { name: name.into(), kind: ColumnKind::Number, required })
        .collect();
    let ignored = IGNORED.iter().filter(|name| expected.iter().all(|column| column.name != **name));
    let ignored: Vec<String> = ignored.map(ToString::to_string).collect();
    let table = read_table(&name, file, &expected, &BTreeMap::new(), &ignored, &Dialect::default(), 1_000_000)?;
    let units = &loaded.raw.units;
    let factor = |angle: bool| if angle { units.angle.factor() } else { units.length.factor() };
    let at = |name: &str, row: usize| table.numbers(name).and_then(|all| all.get(row)).copied().unwrap_or(0.0);
    let row = |row: usize| {
        let value =
            |variable: &crate::description::robot::Variable| at(&variable.name, row) * factor(variable.is_angle);
        let load = std::array::from_fn(|k| {
            at(WRENCH[k], row) * if k < 3 { units.force.factor() } else { units.torque.factor() }
        });
        (loaded.model.variables.iter().map(value).collect(), load)
    };
    let rows: Vec<Loaded> = (0..table.row_count()).map(row).collect();
    let configurations = rows.iter().map(|(q, _)| q.as_slice());
    let diagnostics =
        beyond(&loaded.model.variables, units, "rows", configurations, |row, variable| table.place(row, variable));
    Ok((rows, diagnostics))
}
