//! `pose`: the forward model.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::Error;
use crate::cli::args::Pose;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::cli::values::{joints, wrench};
use crate::compensation::Refusal;
use crate::description::campaign::{Campaign, Payload, WRENCH};
use crate::description::limits::beyond;
use crate::description::table::{ColumnKind, Dialect, ExpectedColumn, Table, read_table};
use crate::description::validity::State;
use crate::diagnostic::{Diagnostic, Place};
use crate::files::{LoadedRobot, not_allowed};
use crate::kinematics::{Geometry, Placements, Transform};
use crate::model::{EffectEntry, Family, Model};
use crate::prediction::{SinglePredictor, SingleWorkspace};
use crate::render::pose as render;
use crate::results::{OwnWeight, Pose as Found, Poses};
use crate::simulation::{Loaded, all_points};

pub fn run(command: &Pose, session: &Session) -> Result<Output, Error> {
    let mut loaded = session.reader.robot(&command.robot)?;
    let load = command.wrench.as_deref().map(|text| wrench(&loaded.raw.units, text)).transpose()?;
    let rows: Vec<Carrying> = match (&command.joints, &command.table) {
        (_, Some(path)) => {
            let table = read(session, &loaded, path, &["payload"])?;
            loaded.diagnostics.extend(table.warnings);
            let configurations = table.rows.into_iter().map(|(q, _)| q);
            configurations.zip(table.payloads).map(|(q, payload)| Carrying { q, payload }).collect()
        }
        (Some(text), None) => {
            let q = joints(&loaded.model, &loaded.raw.units, text)?;
            loaded.diagnostics.extend(beyond_limits(&loaded, &q));
            vec![Carrying { q, payload: None }]
        }
        (None, None) => return Err(Error::input("no configuration", "give --joints or --table")),
    };
    linear(&loaded.model, command.equilibrium)?;
    let wrench = load.unwrap_or_default();
    let mass = |row: &Carrying| row.payload.map(|payload| payload.mass);
    let outside = loaded.outside(rows.iter().map(|row| State { payload: mass(row), ..State::new(&row.q, &wrench) }));
    loaded.diagnostics.extend(outside);
    // What is carried weighs, and so does the arm that carries it.
    let weight = command.weight || rows.iter().any(|row| row.payload.is_some());
    if command.equilibrium && load.is_none() && !weight {
        return Err(Error::input("--equilibrium: nothing loads the robot", "give --wrench or --weight"));
    }
    let loads = Applied { wrench: load, weight };
    let (mut poses, beyond_small) = placed(command, &loaded.model, &rows, loads)?;
    if let Some(uncertainty) = loaded.uncertainty() {
        let at = rows.iter().map(|row| row.q.as_slice());
        for (pose, own) in poses.iter_mut().zip(uncertainty.tool(&loaded.model, at, wrench)?) {
            pose.standard_uncertainty = Some(own);
        }
    }
    let text = poses.iter().map(|pose| render::pose(pose, session.terminal.screen)).collect();
    let mut output = match &poses[..] {
        [pose] if command.table.is_none() => Output::new(text, pose)?,
        _ => Output::new(text, &Poses { poses })?,
    };
    output.diagnostics = loaded.diagnostics;
    output.diagnostics.extend(beyond_small);
    output.diagnostics.extend(loads.is_any().then(|| effects_left_out(&loaded.model)).flatten());
    Ok(output)
}

/// A configuration (rad, m), and what the tool carries there.
struct Carrying {
    q: Vec<f64>,
    payload: Option<Payload>,
}

/// What loads the robot in all rows.
#[derive(Clone, Copy)]
struct Applied {
    /// N and N.m.
    wrench: Option<[f64; 6]>,
    /// Own weight, and what is carried.
    weight: bool,
}

impl Applied {
    /// Whether loads and effects count.
    fn is_any(self) -> bool {
        self.wrench.is_some() || self.weight
    }
}

/// A warning of effects that a configuration by itself does not say: those of the moves before it, of times and temperatures, and of the
/// measurement.
pub(super) fn effects_left_out(model: &Model) -> Option<Diagnostic> {
    let is_left_out = |entry: &EffectEntry| {
        let family = entry.effect.family(&entry.nonlinear);
        matches!(family, Family::History | Family::Time | Family::Temperature)
            || entry.effect.is_of_the_measurement(&entry.site)
    };
    let entries = model.effects.iter().map(|on| &on.entry).filter(|entry| is_left_out(entry));
    let names: Vec<String> = entries.map(EffectEntry::to_string).collect();
    (!names.is_empty()).then(|| {
        let text = format!("effects left out, since a configuration alone does not say how great they are: {}", names.join(", "));
        Diagnostic::warning(text).remedy(
            "`residuals` counts them at the readings of a campaign, with its order and its columns `time`, `temperature` and `approach.<variable>`",
        )
    })
}

/// The points of the robot, one campaign for each of these bodies that the tool carries.
fn points(model: &Model, bodies: &[Option<Payload>]) -> Vec<Campaign> {
    let of = |body: &Option<Payload>| {
        let mut points = all_points(model);
        points.readings.iter_mut().for_each(|reading| reading.payload = *body);
        points
    };
    bodies.iter().map(of).collect()
}

/// Poses at all configurations, under what is applied; and a warning where that deflects the tool further than linear springs say.
fn placed(
    command: &Pose,
    model: &Model,
    rows: &[Carrying],
    loads: Applied,
) -> Result<(Vec<Found>, Option<Diagnostic>), Error> {
    let geometry = Geometry::nominal(model)?;
    let bodies = distinct_bodies(rows);
    let points = if loads.is_any() { points(model, &bodies) } else { Vec::new() };
    let values = model.registry.nominal();
    let predict = |points| -> Result<(SinglePredictor, SingleWorkspace), Error> {
        let predictor = SinglePredictor::new(model, &values, points)?;
        let predictor = if command.equilibrium { predictor.at_equilibrium() } else { predictor };
        let work = predictor.workspace();
        Ok((predictor, work))
    };
    let mut predictors = points.iter().map(predict).collect::<Result<Vec<_>, Error>>()?;
    let mut placements = Placements::default();
    let mut beyond_small = None;
    let mut place = |row: &Carrying| -> Result<Found, Error> {
        geometry.place(&row.q, &mut placements)?;
        let pose = Found::new(&geometry, &placements);
        let own = bodies.iter().position(|body| *body == row.payload).and_then(|k| predictors.get_mut(k));
        let Some((predictor, work)) = own else { return Ok(pose) };
        predictor.place(&row.q, work).map_err(Refusal::from)?;
        let points = loaded_points(predictor, &loads.wrench.unwrap_or_default(), work)?;
        if !command.equilibrium {
            beyond_small = beyond_small.take().or_else(|| large_deflection(&points));
        }
        Ok(shown(model, pose, &points, loads.weight))
    };
    let named = |row: usize, error: Error| match command.table {
        Some(_) => error.at(format!("row {}", row + 1)),
        None => error,
    };
    let rows = rows.iter().enumerate();
    let poses = rows.map(|(k, row)| place(row).map_err(|error| named(k, error))).collect::<Result<Vec<_>, _>>()?;
    Ok((poses, beyond_small))
}

/// What is carried in some row, each once.
fn distinct_bodies(rows: &[Carrying]) -> Vec<Option<Payload>> {
    let mut bodies: Vec<Option<Payload>> = Vec::new();
    for row in rows {
        if !bodies.contains(&row.payload) {
            bodies.push(row.payload);
        }
    }
    bodies
}

/// A warning where the tool is deflected further than linear springs say.
fn large_deflection(points: &[LoadedPlace]) -> Option<Diagnostic> {
    let (_, [x, y, z, about_x, about_y, about_z]) = points.first()?;
    large("the tool", &Vector3::new(*x, *y, *z), &Vector3::new(*about_x, *about_y, *about_z))
}

/// Rotation from which a deflection is no longer small, rad, and displacement, m: sines and lever arms are off by a hundredth of it.
const SMALL: f64 = 0.1;

/// A warning of a deflection (m, rad) of `point` to which the linear answer does not apply.
pub(super) fn large(point: &str, displacement: &Vector3<f64>, rotation: &Vector3<f64>) -> Option<Diagnostic> {
    let [far, turned] = [displacement, rotation].map(Vector3::norm);
    (far > SMALL || turned > SMALL).then(|| {
        Diagnostic::warning(format!(
            "{point} is displaced by {:.0} mm and turns by {:.1} deg: springs are linear here, and that is not small",
            1e3 * far,
            turned.to_degrees()
        ))
        .remedy("check the units of stiffness and load; `--equilibrium` follows large deflections")
    })
}

/// Refuses an equilibrium where a fuzzy compliance, linear in the load, stands for the structure.
pub fn linear(model: &Model, at_equilibrium: bool) -> Result<(), Error> {
    if at_equilibrium && model.fuzzy.is_some() {
        return Err(Error::input(
            "--equilibrium: the description's fuzzy compliance is linear in the load",
            "leave --equilibrium out",
        ));
    }
    Ok(())
}

/// Where a point is under load, base frame, and its displacement (m) and rotation vector (rad) by the loads.
type LoadedPlace = (Transform, [f64; 6]);

/// The tool, then every marker, each loaded by the wrench and own weight, at the configuration just placed.
fn loaded_points(
    predictor: &SinglePredictor,
    load: &[f64; 6],
    work: &mut SingleWorkspace,
) -> Result<Vec<LoadedPlace>, Error> {
    let place = |index: usize| -> Result<LoadedPlace, Error> {
        let seen = predictor.see(index, load, work).map_err(Refusal::from)?;
        Ok((seen.real, seen.deflection()))
    };
    (0..predictor.campaign.readings.len()).map(place).collect()
}

/// A pose with what loads do to the tool and the markers: how far they are deflected and, if `loaded`, where they then are.
fn shown(model: &Model, pose: Found, points: &[LoadedPlace], loaded: bool) -> Found {
    let names =
        std::iter::once("tool".to_string()).chain(model.markers.iter().map(|marker| format!("marker {}", marker.name)));
    let pose = pose.deflected(names.zip(points).map(|(name, (_, deflection))| (name, *deflection)).collect());
    match points {
        [(tool, _), markers @ ..] if loaded => {
            let markers: Vec<Transform> = markers.iter().map(|(place, _)| *place).collect();
            pose.loaded(OwnWeight::nominal(model, true), tool, &markers)
        }
        _ => pose,
    }
}

/// Configurations of a CSV with one column a variable, in the description's units, with the load of each row: columns
/// fx, fy, fz, mx, my, mz, which may be absent; and warnings of limits. The name of a row and the pose that
/// `compensate --table` writes next to the joints are ignored.
pub fn loaded_configurations(
    session: &Session,
    loaded: &LoadedRobot,
    path: &std::path::Path,
) -> Result<(Vec<Loaded>, Vec<Diagnostic>), Error> {
    let ConfigurationTable { rows, warnings, .. } = read(session, loaded, path, &WRENCH)?;
    Ok((rows, warnings))
}

/// A table of configurations.
struct ConfigurationTable {
    rows: Vec<Loaded>,
    /// What the tool carries in each row; nothing where the table has no column `payload`.
    payloads: Vec<Option<Payload>>,
    warnings: Vec<Diagnostic>,
}

/// Columns that `plan` and `compensate` write next to the joints.
const IGNORED: [&str; 8] = ["pose", "file", "x", "y", "z", "rx", "ry", "rz"];

/// Warnings of joints given beyond the description's limits, and of passive joints and sums that they take beyond theirs.
pub fn beyond_limits(loaded: &LoadedRobot, q: &[f64]) -> Vec<Diagnostic> {
    beyond_all(loaded, "configurations", &[q], |_, _| None)
}

fn beyond_all(
    loaded: &LoadedRobot,
    of: &str,
    configurations: &[&[f64]],
    place: impl Fn(usize, &str) -> Option<Place>,
) -> Vec<Diagnostic> {
    let (model, units) = (&loaded.model, &loaded.raw.units);
    let rows = configurations.iter().copied();
    let mut diagnostics = beyond(&model.variables, units, of, rows.clone(), &place);
    diagnostics.extend(not_allowed(model, units, of, rows, place));
    diagnostics
}

fn read(
    session: &Session,
    loaded: &LoadedRobot,
    path: &std::path::Path,
    also: &[&str],
) -> Result<ConfigurationTable, Error> {
    let name = path.display().to_string();
    let file = session.reader.table(path).map_err(|diagnostic| match diagnostic.remedy {
        Some(_) => diagnostic,
        None => diagnostic.remedy("give a CSV with one column a variable"),
    })?;
    let units = &loaded.raw.units;
    let variables = loaded.model.variables.iter();
    let variables = variables.filter_map(|variable| Some((variable.name.as_str(), units.unit(variable.kind())?, true)));
    let loads = WRENCH.into_iter().zip(units.of_wrench()).filter(|(name, _)| also.contains(name));
    let expected: Vec<ExpectedColumn> = variables
        .chain(loads.map(|(name, unit)| (name, unit, false)))
        .map(|(name, unit, required)| ExpectedColumn::new(name, ColumnKind::Quantity(unit), required))
        .chain(also.contains(&"payload").then(|| ExpectedColumn::new("payload", ColumnKind::TextOrNone, false)))
        .collect();
    let ignored = IGNORED.iter().filter(|name| expected.iter().all(|column| column.name != **name));
    let ignored: Vec<String> = ignored.map(ToString::to_string).collect();
    let table = read_table(&name, file, &expected, &BTreeMap::new(), &ignored, &Dialect::default(), 1_000_000)?;
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
    let configurations: Vec<&[f64]> = rows.iter().map(|(q, _)| q.as_slice()).collect();
    let mut warnings = table.notes().to_vec();
    warnings.extend(beyond_all(loaded, "rows", &configurations, |row, variable| table.place(row, variable)));
    let payloads = carried(&table, &loaded.robot.payloads)?;
    Ok(ConfigurationTable { rows, payloads, warnings })
}

/// The bodies that a table's column `payload` names.
fn carried(table: &Table, known: &[(String, Payload)]) -> Result<Vec<Option<Payload>>, Error> {
    let Some(names) = table.texts("payload") else { return Ok(vec![None; table.row_count()]) };
    let (mut found, mut faults) = (Vec::new(), Vec::new());
    for (row, name) in (0..table.row_count()).map(|row| (row, names.get(row).unwrap_or_default())) {
        let body = known.iter().find(|(own, _)| own == name).map(|(_, body)| *body);
        if body.is_none() && !name.is_empty() && name != "none" && faults.len() < MOST_FAULTS {
            let diagnostic = Diagnostic::error(format!("unknown payload `{name}`")).at(table.place(row, "payload"));
            faults.push(match known.is_empty() {
                true => diagnostic.remedy("declare it under `payloads:` of the description, with its mass and centre"),
                false => diagnostic.suggest(name, known.iter().map(|(own, _)| own.as_str()).chain(["none"])),
            });
        }
        found.push(body);
    }
    if faults.is_empty() { Ok(found) } else { Err(Error::from(faults)) }
}

/// Most faults shown of a column.
const MOST_FAULTS: usize = 10;
