//! A description in the terms of a controller: Denavit and Hartenberg's parameters, offsets of the joints' zeros. mm and deg.

use std::io;
use std::path::Path;

use crate::description::khalil_kleinfinger::clean;
use crate::description::robot::Motion;
use crate::description::table::Sheet;
use crate::kinematics::{DenavitHartenberg, Transform, rotation_vector};
use crate::math::wrapped;
use crate::model::Model;

/// Names of the columns, in the order in which they are applied.
const DISTAL: [&str; 4] = ["theta_deg", "d_mm", "a_mm", "alpha_deg"];
const MODIFIED: [&str; 4] = ["alpha_deg", "a_mm", "theta_deg", "d_mm"];

/// Rows of a table: the base, the joints and the tool.
struct Rows {
    names: Vec<String>,
    variables: Vec<String>,
    values: Vec<[f64; 4]>,
    /// Position (mm) and rotation vector (deg) of base and tool.
    ends: [[f64; 6]; 2],
}

impl Rows {
    fn new(found: &DenavitHartenberg, modified: bool) -> Self {
        let mm = |length: f64| 1e3 * clean(length, 1.0);
        let deg = |angle: f64| clean(angle, 1.0).to_degrees();
        let links = &found.links;
        let before = |k: usize| k.checked_sub(1).map_or([0.0, 0.0], |k| [deg(links[k].alpha), mm(links[k].a)]);
        let row = |k: usize| {
            let own = &links[k];
            match modified {
                true => [before(k)[0], before(k)[1], deg(own.theta), mm(own.d)],
                false => [deg(own.theta), mm(own.d), mm(own.a), deg(own.alpha)],
            }
        };
        let end = |pose: &Transform| {
            let (at, turned) = (pose.translation.vector, rotation_vector(&pose.rotation));
            [mm(at.x), mm(at.y), mm(at.z), deg(turned.x), deg(turned.y), deg(turned.z)]
        };
        Self {
            names: links.iter().map(|link| link.joint.clone()).collect(),
            variables: links.iter().map(|link| link.variable.clone()).collect(),
            values: (0..links.len()).map(row).collect(),
            ends: [end(&found.base), end(&found.tool)],
        }
    }
}

/// Table of Denavit and Hartenberg's parameters at zero of all variables, a joint a row; the first and the last row place base and tool by
/// position and rotation vector (`x_mm` to `rz_deg`). Those of the nominal description, and the differences, stand next to them.
///
/// # Errors
/// As [`Sheet::file`].
pub fn dh(
    found: &DenavitHartenberg,
    nominal: Option<&DenavitHartenberg>,
    modified: bool,
    file: &Path,
) -> io::Result<Vec<u8>> {
    let own = Rows::new(found, modified);
    let other = nominal.map(|nominal| Rows::new(nominal, modified));
    let (own, other, count) = (&own, other.as_ref(), own.names.len());
    let joint = |row: usize| row.checked_sub(1).filter(|joint| *joint < count);
    let mut sheet = Sheet::new();
    sheet.texts("joint", move |row| match joint(row) {
        Some(joint) => own.names[joint].clone(),
        None => if row == 0 { "base" } else { "tool" }.into(),
    });
    sheet.texts("variable", move |row| joint(row).map_or_else(String::new, |joint| own.variables[joint].clone()));
    // Axes that are nearly parallel have feet kilometres away: angles must be as exact as lengths.
    let number = |value: f64| format!("{:.12}", value + 0.0);
    for (k, name) in if modified { MODIFIED } else { DISTAL }.into_iter().enumerate() {
        let cell = move |of: &Rows, row: usize| joint(row).map(|joint| of.values[joint][k]);
        sheet.column(name, move |row| cell(own, row).map_or_else(String::new, number));
        if let Some(other) = other {
            sheet.column(format!("{name}.nominal"), move |row| cell(other, row).map_or_else(String::new, number));
            let is_angle = name.ends_with("_deg");
            let change = move |row| {
                let change = cell(own, row)? - cell(other, row)?;
                Some(if is_angle { wrapped(change.to_radians()).to_degrees() } else { change })
            };
            sheet.column(format!("{name}.change"), move |row| change(row).map_or_else(String::new, number));
        }
    }
    for (k, name) in ["x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg"].into_iter().enumerate() {
        let cell = move |of: &Rows, row: usize| joint(row).is_none().then(|| of.ends[usize::from(row > 0)][k]);
        sheet.column(name, move |row| cell(own, row).map_or_else(String::new, number));
    }
    sheet.file(file, 0..count + 2)
}

/// The offset of a variable's zero: what is to be added to its value for the nominal description to place its joint as the calibrated
/// one does (rad, m); `None` where no joint or actuator of either has the variable.
fn offset(model: &Model, nominal: &Model, variable: usize) -> Option<f64> {
    let zero = |model: &Model| {
        let value = |slot: usize| model.registry[slot].nominal;
        let of_joint = model.frames.iter().find_map(|frame| match frame.motion {
            Motion::Variable { index, direction } if index == variable => Some(direction * value(frame.moving_slot())),
            _ => None,
        });
        let actuators = model.actuators.iter().find(|actuator| actuator.variable == variable);
        of_joint.or_else(|| actuators.map(|actuator| value(actuator.slot)))
    };
    Some(zero(model)? - zero(nominal)?)
}

/// Table of the offsets of the variables' zeros, deg and mm.
///
/// # Errors
/// As [`Sheet::file`].
pub fn mastering(model: &Model, nominal: &Model, file: &Path) -> io::Result<Vec<u8>> {
    let mut sheet = Sheet::new();
    let variables = &model.variables;
    sheet.texts("variable", move |row| variables[row].name.clone());
    sheet.texts("unit", move |row| if variables[row].is_angle { "deg" } else { "mm" }.into());
    sheet.column("offset", move |row| {
        let size = if variables[row].is_angle { 1f64.to_degrees() } else { 1e3 };
        offset(model, nominal, row).map_or_else(String::new, |offset| format!("{:.9}", size * offset + 0.0))
    });
    sheet.file(file, 0..variables.len())
}
