//! `pose`: the forward model.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use serde_json::{Map, Value, json};

use crate::Error;
use crate::cli::args::Pose;
use crate::cli::values::{joints, wrench};
use crate::cli::{Output, Session};
use crate::description::campaign::WRENCH;
use crate::description::limits::beyond;
use crate::description::table::{ColumnKind, Dialect, ExpectedColumn, read_table};
use crate::diagnostic::Diagnostic;
use crate::elastics::{Elastics, PointLoad, Response, Statics, equilibrium};
use crate::files::LoadedRobot;
use crate::fuzzy;
use crate::kinematics::{Geometry, Placements, Transform, rotation_vector};
use crate::render::table::Screen;
use crate::results::units::{deg, mm};
use crate::simulation::Loaded;

pub fn run(command: &Pose, session: &Session) -> Result<Output, Error> {
    let mut loaded = session.reader.robot(&command.robot)?;
    let load = command.wrench.as_deref().map(|text| wrench(&loaded.raw.units, text)).transpose()?;
    let configurations = match (&command.joints, &command.table) {
        (_, Some(path)) => {
            let (rows, said) = read(session, &loaded, path, &[])?;
            loaded.diagnostics.extend(said);
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
    let (mut text, mut all) = (String::new(), Vec::new());
    for (row, q) in configurations.iter().enumerate() {
        geometry.place(q, &mut placements).map_err(|error| {
            let which = if command.table.is_some() { format!("row {}: ", row + 1) } else { String::new() };
            Error::Impossible(format!("{which}{error}"))
        })?;
        text += &in_words(&geometry, &placements, session.terminal.screen);
        let mut json = as_json(&geometry, &placements);
        if let Some(load) = &load {
            let deflected = deflected(&geometry, q, &placements, load, command.equilibrium)?;
            text += "\nunder the wrench and own weight\n";
            text += &session.terminal.screen.table(
                &["point", "dx mm", "dy mm", "dz mm", "rx deg", "ry deg", "rz deg"],
                deflected.iter().map(|(name, d)| {
                    let mut row = vec![name.clone()];
                    row.extend(d[..3].iter().map(|v| format!("{:.4}", mm(*v))));
                    row.extend(d[3..].iter().map(|v| format!("{:.5}", deg(*v))));
                    row
                }),
            );
            json["deflection"] = json!(deflected.into_iter().collect::<BTreeMap<String, [f64; 6]>>());
        }
        all.push(json);
    }
    let json = if command.table.is_some() { json!({"poses": all}) } else { all.pop().unwrap_or(Value::Null) };
    let mut output = Output::new(text, &json)?;
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
/// `compensate --table` writes beside the joints are passed over.
pub fn loaded_configurations(
    session: &Session,
    loaded: &LoadedRobot,
    path: &std::path::Path,
) -> Result<(Vec<Loaded>, Vec<Diagnostic>), Error> {
    read(session, loaded, path, &WRENCH)
}

/// Columns that `plan` and `compensate` write beside the joints.
const PASSED_OVER: [&str; 7] = ["pose", "x", "y", "z", "rx", "ry", "rz"];

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
    let ignored = PASSED_OVER.iter().filter(|name| expected.iter().all(|column| column.name != **name));
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

fn joint_values(geometry: &Geometry, placements: &Placements) -> Vec<(String, f64, bool)> {
    let model = geometry.model;
    let moving = model.frames.iter().enumerate().filter(|(_, frame)| frame.moves());
    moving
        .map(|(index, frame)| {
            let angle = frame.joint == crate::description::raw::JointKind::Revolute;
            (frame.name.clone(), placements.joints[index], angle)
        })
        .collect()
}

fn as_json(geometry: &Geometry, placements: &Placements) -> Value {
    let model = geometry.model;
    let matrix = |t: &Transform| {
        let m = t.to_homogeneous();
        json!((0..4).map(|i| (0..4).map(|j| m[(i, j)]).collect::<Vec<f64>>()).collect::<Vec<_>>())
    };
    let joints: Map<String, Value> =
        joint_values(geometry, placements).into_iter().map(|(name, value, _)| (name, json!(value))).collect();
    let frames: Map<String, Value> = model
        .frames
        .iter()
        .zip(&placements.frames)
        .skip(1)
        .map(|(frame, placed)| (frame.name.clone(), matrix(placed)))
        .collect();
    let markers: Map<String, Value> = (0..model.markers.len())
        .map(|m| {
            let point = placements.frames[model.markers[m].frame] * geometry.marker(m);
            (model.markers[m].name.clone(), json!([point.x, point.y, point.z]))
        })
        .collect();
    let tool = placements.frames[model.tool.0] * geometry.tool();
    json!({"joints": joints, "frames": frames, "markers": markers, "tool": matrix(&tool)})
}

fn in_words(geometry: &Geometry, placements: &Placements, screen: Screen) -> String {
    let model = geometry.model;
    let joint = |(name, value, angle): (String, f64, bool)| {
        vec![name, if angle { format!("{:.4} deg", deg(value)) } else { format!("{:.4} mm", mm(value)) }]
    };
    let mut text = screen.table(&["joint", "value"], joint_values(geometry, placements).into_iter().map(joint));
    let row = |name: &str, placed: &Transform| {
        let p = placed.translation.vector;
        let r = rotation_vector(&placed.rotation);
        let mut row = vec![name.to_string()];
        row.extend(p.iter().map(|v| format!("{:.4}", mm(*v))));
        row.extend(r.iter().map(|v| format!("{:.4}", deg(*v))));
        row
    };
    let mut rows: Vec<Vec<String>> =
        model.frames.iter().zip(&placements.frames).skip(1).map(|(frame, placed)| row(&frame.name, placed)).collect();
    rows.push(row("tool", &(placements.frames[model.tool.0] * geometry.tool())));
    for m in 0..model.markers.len() {
        let point = placements.frames[model.markers[m].frame] * geometry.marker(m);
        let mut row = vec![format!("marker {}", model.markers[m].name)];
        row.extend(point.iter().map(|v| format!("{:.4}", mm(*v))));
        row.extend(std::iter::repeat_n(String::new(), 3));
        rows.push(row);
    }
    text += "\n";
    text += &screen.table(&["frame", "x mm", "y mm", "z mm", "rx deg", "ry deg", "rz deg"], rows);
    text
}
