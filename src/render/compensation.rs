//! Compensated paths as text and as a table of commands. Lengths in mm, angles in deg.

use std::fmt::Write;
use std::path::Path;

use indexmap::IndexMap;

use super::table::Screen;
use crate::compensation::{Hold, Sides};
use crate::description::robot::Variable;
use crate::description::table::Sheet;
use crate::description::units::Units;
use crate::math::norm;
use crate::observation::POSE;
use crate::results::units::{mm, shown, shown_unit};
use crate::results::{CompensatedPoint, Compensation, CorrectedPoint, StripLeft};

/// Greatest number of points shown in text.
const MOST_SHOWN: usize = 200;

const HEADER: [&str; 9] =
    ["point", "name", "missed mm", "geometry", "own weight", "wrench", "effects", "largest correction", "residual mm"];

/// Text of `compensate`.
pub fn compensation(found: &Compensation, screen: Screen) -> String {
    let mut out = format!("{}: compensated path\n\n", found.robot);
    let (met, all) = (found.met().count(), found.points.len());
    if met > 0 {
        out += &screen.table(&HEADER, found.met().take(MOST_SHOWN).map(|point| row(found, point)));
    }
    if met > MOST_SHOWN {
        let _ = writeln!(out, "and {} more (--format json, --table)", met - MOST_SHOWN);
    }
    if found.met().any(|point| point.before.is_none()) {
        out += "\n-: without correction arm and process find no balance there\n";
    }
    let _ = if met == 0 {
        writeln!(out, "none of {all} points can be met")
    } else {
        writeln!(
            out,
            "\n{met} of {all} points: {:.4} mm rms, {:.4} mm at most without correction; predicted residual {:.1e} mm at most",
            mm(found.before.rms),
            mm(found.before.max),
            mm(found.after.max)
        )
    };
    if let Some(uncertainty) = found.uncertainty.as_ref().filter(|_| met > 0) {
        let _ = writeln!(
            out,
            "standard uncertainty of the points, by the fit that the description states: {:.4} mm rms, {:.4} mm at most",
            mm(uncertainty.rms),
            mm(uncertainty.max)
        );
    }
    if let Some(error) = found.linear_error.filter(|error| error.max > 0.0) {
        let _ = writeln!(
            out,
            "the linear deflection is off the equilibrium at the deflected pose by {:.1e} mm rms, {:.1e} mm at most (--equilibrium finds that)",
            mm(error.rms),
            mm(error.max)
        );
    }
    out += &found.strip.as_ref().map(strip_left).unwrap_or_default();
    out += &let_go(found);
    let _ = writeln!(out, "{}", found.own_weight.words(""));
    if !found.left_out.is_empty() {
        let names = found.left_out.join(", ");
        let _ = writeln!(out, "left out, being of the measurement and not of the robot: {names}");
    }
    if found.sides == Sides::Unsettled {
        out += "the side of approach of some points flips with the correction itself: those may miss by the backlash\n";
    }
    for point in found.not_met().take(MOST_SHOWN) {
        let _ = writeln!(out, "point {} ({}) refused: {}", point.index + 1, point.name, point.why);
    }
    if found.refused.len() > MOST_SHOWN {
        let _ = writeln!(out, "and {} more refused", found.refused.len() - MOST_SHOWN);
    }
    out
}

/// What remains of a strip that can yield.
pub fn strip_left(left: &StripLeft) -> String {
    let Some(first) = &left.yields_at else { return "the strip stays elastic and keeps no bend\n".into() };
    let [bent, kept, back] = [left.at.bent, left.at.left, left.sprung_back].map(mm);
    format!(
        "the strip yields from point {first} on, its curvature at most {:.2} times that of yield; at {} its free end is bent by \
         {bent:.3} mm, of which {kept:.3} mm remain when the tool leaves ({back:.3} mm spring back)\n",
        left.at.worst, left.after
    )
}

/// The directions that are not held, and how far the points are off in them.
fn let_go(found: &Compensation) -> String {
    let mut most: IndexMap<&str, f64> = IndexMap::new();
    for (name, off) in found.met().flat_map(|point| &point.let_go) {
        let most = most.entry(name).or_default();
        *most = most.max(off.abs());
    }
    if most.is_empty() {
        return String::new();
    }
    let shown = most.iter().map(|(name, off)| {
        let is_angle = Hold::NAMES[3..].contains(name);
        format!("{name} {:.4} {}", shown(*off, is_angle), shown_unit(is_angle))
    });
    let free = found.variables.len().saturating_sub(found.held.len());
    let more = match free {
        0 => String::new(),
        _ => format!("; {free} more could be held (--hold)"),
    };
    format!("held {}; let go, off by at most: {}{more}\n", found.held.join(", "), shown.collect::<Vec<_>>().join(", "))
}

fn row(found: &Compensation, point: &CorrectedPoint) -> Vec<String> {
    let norm = |v: &[f64; 3]| format!("{:.4}", mm(norm(v)));
    let mut row = vec![(point.index + 1).to_string(), point.name.clone()];
    match &point.before {
        Some(d) => row.extend([&d.all, &d.geometry, &d.weight, &d.wrench, &d.effects].map(norm)),
        None => row.extend(std::iter::repeat_n("-".to_string(), 5)),
    }
    row.push(largest(found, point));
    row.push(format!("{:.1e}", mm(point.residual)));
    row
}

/// The largest correction of a variable.
fn largest(found: &Compensation, point: &CorrectedPoint) -> String {
    let by = point.correction.iter().flat_map(|by| by.values()).zip(&found.variables);
    let by = by.map(|(by, variable)| (variable, shown(*by, variable.is_angle)));
    let most = by.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    most.map_or(String::new(), |(variable, by)| format!("{} {by:+.4} {}", variable.name, shown_unit(variable.is_angle)))
}

/// Names of the columns of [`row_of`].
pub fn header(variables: &[Variable]) -> String {
    let joints = variables.iter().map(|variable| variable.name.as_str());
    let names: Vec<&str> =
        ["pose", "status"].into_iter().chain(joints).chain(POSE.columns().iter().map(|column| column.name)).collect();
    names.join(",")
}

/// A point as a line of CSV, in units: name, `ok` or why it is refused, commands, and their pose by the controller's geometry.
pub fn row_of(variables: &[Variable], point: &CompensatedPoint, units: &Units) -> String {
    let mut cells: Vec<String> = Vec::new();
    match point {
        CompensatedPoint::Refused(point) => {
            cells.extend([point.name.clone(), point.status.to_string().replace(['\n', '\r'], " ")]);
            cells.resize(2 + variables.len() + POSE.columns().len(), String::new());
        }
        CompensatedPoint::Corrected(point) => {
            cells.extend([point.name.clone(), point.status.to_string()]);
            let joints = variables.iter().zip(point.joints.values());
            cells.extend(joints.map(|(v, q)| format!("{:.9}", q / units.of(v.kind()))));
            cells.extend(POSE.columns().iter().enumerate().map(|(k, column)| {
                point.pose.map_or_else(String::new, |pose| format!("{:.9}", pose[k] / units.of(column.kind)))
            }));
        }
    }
    let mut sheet = Sheet::new();
    let cells = &cells;
    (0..cells.len()).for_each(|k| sheet.texts("", move |_| cells[k].clone()));
    let table = sheet.csv(0..1).unwrap_or_default();
    table.lines().nth(1).unwrap_or_default().to_string()
}

/// Table of the points that are met, in units, to be written to a file of that name: commands, and the poses by the
/// controller's geometry.
///
/// # Errors
/// As [`Sheet::file`].
pub fn table(found: &Compensation, units: &Units, file: &Path) -> std::io::Result<Vec<u8>> {
    let points: Vec<&CorrectedPoint> = found.met().collect();
    let points = &points;
    let mut sheet = Sheet::new();
    sheet.texts("pose", |row| points[row].name.clone());
    for (k, variable) in found.variables.iter().enumerate() {
        let unit = units.of(variable.kind());
        sheet.column(&variable.name, move |row| format!("{:.9}", points[row].joints[k] / unit));
    }
    // Empty where the controller's own geometry has no pose for the commands.
    for (k, column) in POSE.columns().iter().enumerate() {
        let unit = units.of(column.kind);
        sheet.column(column.name, move |row| {
            points[row].pose.map_or_else(String::new, |pose| format!("{:.9}", pose[k] / unit))
        });
    }
    sheet.file(file, 0..points.len())
}
