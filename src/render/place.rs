//! Where a process deflects the arm least, as text and as the path there. Lengths in mm, angles in deg.

use std::fmt::Write;
use std::path::Path;

use super::table::Screen;
use crate::compensation::Hold;
use crate::description::campaign::WRENCH;
use crate::description::table::Sheet;
use crate::description::units::Units;
use crate::observation::POSE;
use crate::results::units::{deg, mm, shown, shown_unit};
use crate::results::{Deflections, PlacedPoint, Placement};

/// Greatest number of points shown in text.
const MOST_SHOWN: usize = 200;

/// Text of `place`.
pub fn placement(found: &Placement, screen: Screen) -> String {
    let words = |of: &Deflections| format!("{:.4} mm rms, {:.4} mm at most", mm(of.rms), mm(of.max));
    let or_none = |of: Option<&Deflections>| of.map_or("the arm cannot take it".into(), words);
    let along = match found.directions[..] {
        ["x", "y", "z"] => String::new(),
        _ => format!(" along {} of the workpiece as given", found.directions.join(", ")),
    };
    let mut out = format!("{}: deflection of the tool{along}\n\n", found.robot);
    let rows = [
        ["the path as given".to_string(), or_none(found.given.as_ref())],
        ["the best posture there".to_string(), or_none(found.posture.as_ref())],
        [format!("the best place ({})", moved(found)), words(&found.best)],
    ];
    let is_moved = found.moved.shift != [0.0; 3] || found.moved.turn != [0.0; 3];
    out += &screen.table(&["", "deflection"], rows[..if is_moved { 3 } else { 2 }].iter().map(|row| row.to_vec()));
    if found.may_move && !is_moved {
        out += "no other place of those tried is better\n";
    }
    let units: Vec<String> = found.variables.iter().map(|v| format!("{} {}", v.name, shown_unit(v.is_angle))).collect();
    let mut header = vec!["point", "name", "deflection mm", "as given"];
    header.extend(units.iter().map(String::as_str));
    header.push("condition");
    out += "\n";
    out += &screen.table(&header, found.points.iter().take(MOST_SHOWN).map(|point| row(found, point)));
    if found.points.len() > MOST_SHOWN {
        let _ = writeln!(out, "and {} more (--format json, --table)", found.points.len() - MOST_SHOWN);
    }
    out += "\n";
    let greatest = found.steps.values().zip(&found.variables).max_by(|a, b| {
        let size = |(by, v): &(&f64, &crate::description::robot::Variable)| shown(**by, v.is_angle);
        size(a).total_cmp(&size(b))
    });
    if let Some((by, variable)) = greatest.filter(|(by, _)| **by > 0.0) {
        let (name, is_angle) = (&variable.name, variable.is_angle);
        let _ = writeln!(
            out,
            "greatest step between points: {name} by {:.2} {}",
            shown(*by, is_angle),
            shown_unit(is_angle)
        );
    }
    if found.held.len() < 6 {
        let _ = writeln!(out, "held {}; the rest is chosen", found.held.join(", "));
    }
    let _ = writeln!(out, "{}", found.own_weight.words("--weight counts it"));
    let _ = writeln!(out, "{} ways through the path tried", found.tried);
    out
}

/// How the workpiece is moved, in words.
fn moved(found: &Placement) -> String {
    let lengths = found.moved.shift.iter().map(|v| (mm(*v), "mm"));
    let all = lengths.chain(found.moved.turn.iter().map(|v| (deg(*v), "deg"))).zip(Hold::NAMES);
    let words = all.filter(|((by, _), _)| *by != 0.0).map(|((by, unit), name)| format!("{name} {by:+.2} {unit}"));
    words.collect::<Vec<_>>().join(", ")
}

fn row(found: &Placement, point: &PlacedPoint) -> Vec<String> {
    let mut row = vec![(point.index + 1).to_string(), point.name.clone(), format!("{:.4}", mm(point.counted))];
    row.push(point.given.map_or("-".into(), |given| format!("{:.4}", mm(given))));
    let joints = point.joints.values().zip(&found.variables);
    row.extend(joints.map(|(q, variable)| format!("{:.3}", shown(*q, variable.is_angle))));
    row.push(format!("{:.1}", point.condition));
    row
}

/// The path where it is best, in units, to be written to a file of that name: joints, poses of the tool, wrenches.
///
/// # Errors
/// As [`Sheet::file`].
pub fn table(found: &Placement, units: &Units, file: &Path) -> std::io::Result<Vec<u8>> {
    let points = &found.points;
    let mut sheet = Sheet::new();
    sheet.texts("pose", |row| points[row].name.clone());
    for (k, variable) in found.variables.iter().enumerate() {
        let unit = units.of(variable.kind());
        sheet.column(&variable.name, move |row| format!("{:.12}", points[row].joints[k] / unit));
    }
    for (k, column) in POSE.columns().iter().enumerate() {
        let unit = units.of(column.kind);
        sheet.column(column.name, move |row| format!("{:.9}", points[row].pose[k] / unit));
    }
    for (k, name) in WRENCH.iter().enumerate() {
        let unit = if k < 3 { units.force.factor() } else { units.torque.factor() };
        sheet.column(*name, move |row| format!("{:.9}", points[row].wrench[k] / unit));
    }
    sheet.file(file, 0..points.len())
}
