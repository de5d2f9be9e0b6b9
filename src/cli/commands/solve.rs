//! `solve`: the inverse model.

use nalgebra::{Point3, Rotation3, Vector3};
use serde_json::{Map, Value, json};

use super::pose::beyond_limits;
use crate::Error;
use crate::cli::args::Solve;
use crate::cli::values::{joints, numbers};
use crate::cli::{Output, Session};
use crate::kinematics::{Geometry, InverseSettings, Target, solve};
use crate::results::units::{deg, mm};

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

    let variables = &loaded.model.variables;
    let spoken =
        |index: usize, value: f64| if variables[index].is_angle { (deg(value), "deg") } else { (mm(value), "mm") };
    let mut header: Vec<String> =
        variables.iter().enumerate().map(|(k, v)| format!("{} {}", v.name, spoken(k, 0.0).1)).collect();
    header.insert(0, "solution".into());
    header.push("position error um".into());
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let rows = solutions.iter().enumerate().map(|(n, solution)| {
        let mut row = vec![(n + 1).to_string()];
        row.extend(solution.joints.iter().enumerate().map(|(k, q)| format!("{:.4}", spoken(k, *q).0)));
        row.push(format!("{:.1e}", solution.position_error * 1e6));
        row
    });
    let mut text = session.terminal.screen.table(&header, rows);
    if solutions.iter().any(|solution| solution.self_motions > 0) {
        text += "the robot can move while its tool stands still: these are samples of a continuum\n";
    }
    let as_json = |solution: &crate::kinematics::Solution| {
        let joints: Map<String, Value> =
            variables.iter().zip(&solution.joints).map(|(v, q)| (v.name.clone(), json!(q))).collect();
        json!({"joints": joints, "position_error": solution.position_error, "orientation_error": solution.orientation_error,
               "self_motions": solution.self_motions})
    };
    let mut output = Output::new(text, &json!({"solutions": solutions.iter().map(as_json).collect::<Vec<_>>()}))?;
    output.diagnostics = loaded.diagnostics;
    Ok(output)
}
