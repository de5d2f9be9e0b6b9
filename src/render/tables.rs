//! Results as tables, to be written as CSV or as a workbook. Lengths in mm, angles in deg, as the columns' names say.

use std::io;
use std::path::Path;

use crate::description::campaign::{Campaign, InSession};
use crate::description::table::Sheet;
use crate::math::norm;
use crate::observation::{Observes, ValueColumn};
use crate::parameter::Kind;
use crate::results::{ConfigurationResidual, DescriptionResiduals, Identification, PartErrors, ReadingErrors};

/// Table of `residuals`, a reading a row, to be written to a file of that name: measured less predicted in the columns
/// `error.<column>` (mm, or deg of a rotation vector), its length in `error` (mm).
///
/// # Errors
/// As [`Sheet::file`].
pub fn residuals(found: &DescriptionResiduals, campaign: &Campaign, file: &Path) -> io::Result<Vec<u8>> {
    let readings = &found.readings;
    let mut sheet = Sheet::new();
    sheet.column("row", |row| readings[row].row.to_string());
    sheet.texts("pose", |row| readings[row].pose.clone());
    sheet.texts("marker", |row| readings[row].marker.clone());
    if readings.iter().any(|reading| reading.target.is_some()) {
        sheet.texts("target", |row| readings[row].target.clone().unwrap_or_default());
    }
    if campaign.files.len() > 1 {
        sheet.texts("file", |row| campaign.file(&campaign.readings[row]).unwrap_or_default().to_string());
    }
    let sessions = &campaign.sessions;
    for (name, names, of) in [
        ("session", &sessions.names, (|at| at.session) as fn(&InSession) -> usize),
        ("station", &sessions.stations, |at| at.station),
    ] {
        if names.len() > 1 {
            sheet.texts(name, move |row| names.get(of(&campaign.readings[row].session)).cloned().unwrap_or_default());
        }
    }
    let set = |check| if check { "check" } else { "fit" };
    sheet.texts("set", move |row| campaign.readings[row].check.map_or(String::new(), |check| set(check).into()));
    for ErrorColumn { name, is_angle, at, kinds } in error_columns(campaign) {
        sheet.column(format!("error.{name}"), move |row| {
            let reading = &readings[row];
            if !kinds.contains(&campaign.readings[row].observes) {
                return String::new();
            }
            let all = if is_angle { reading.orientation_error_deg.as_deref() } else { Some(reading.error.as_slice()) };
            let error = all.and_then(|all| all.get(at));
            error.map_or_else(String::new, |error| format!("{error:.9}"))
        });
    }
    if readings.iter().any(|reading| reading.load_error.is_some()) {
        sheet.column("error.load", |row| {
            readings[row].load_error.map_or_else(String::new, |error| format!("{error:.9}"))
        });
    }
    sheet.column("error", |row| match readings[row].error.as_slice() {
        [] => String::new(),
        error => format!("{:.9}", norm(error)),
    });
    if found.predicted_uncertainty.is_some() {
        for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
            sheet.column(format!("uncertainty.{name}"), move |row| {
                readings[row].standard_uncertainty.map_or_else(String::new, |own| format!("{:.9}", own[k]))
            });
        }
    }
    sheet.file(file, 0..readings.len())
}

/// A column of errors: its name, whether it is an angle, its number among the lengths or angles of a reading, and the kinds of
/// readings that have it.
struct ErrorColumn {
    name: &'static str,
    is_angle: bool,
    at: usize,
    kinds: Vec<Observes>,
}

fn error_columns(campaign: &Campaign) -> Vec<ErrorColumn> {
    let mut all: Vec<ErrorColumn> = Vec::new();
    let mut kinds: Vec<Observes> = Vec::new();
    for reading in &campaign.readings {
        if kinds.contains(&reading.observes) {
            continue;
        }
        let kind = reading.observes;
        kinds.push(kind);
        for (is_angle, rows, usual) in
            [(false, kind.length_rows(), ["x", "y", "z"]), (true, kind.angle_rows(), ["rx", "ry", "rz"])]
        {
            let of_kind = |column: &&ValueColumn| (column.kind == Kind::Angle) == is_angle && is_measured(column.kind);
            let mut named = kind.columns().iter().filter(of_kind).map(|column| column.name);
            for (at, usual) in (0..rows).zip(usual) {
                let name = named.next().unwrap_or(usual);
                match all.iter_mut().find(|known| known.name == name) {
                    Some(known) => known.kinds.push(kind),
                    None => all.push(ErrorColumn { name, is_angle, at, kinds: vec![kind] }),
                }
            }
        }
    }
    all
}

/// Whether a column holds what its errors are of: components of a direction do not, whose errors are angles.
fn is_measured(kind: Kind) -> bool {
    matches!(kind, Kind::Length | Kind::Angle)
}

/// Table of the parameters that `identify` finds, to be written to a file of that name: each in its unit.
///
/// # Errors
/// As [`Sheet::file`].
pub fn parameters(found: &Identification, file: &Path) -> io::Result<Vec<u8>> {
    let parameters = &found.parameters;
    let mut sheet = Sheet::new();
    sheet.texts("parameter", |row| parameters[row].name.clone());
    sheet.texts("unit", |row| parameters[row].unit.into());
    sheet.column("nominal", |row| parameters[row].nominal.map_or_else(String::new, |value| value.to_string()));
    sheet.column("value", |row| parameters[row].value.to_string());
    sheet.column("ci95", |row| parameters[row].ci95.map_or_else(String::new, |width| width.to_string()));
    sheet.texts("estimated", |row| if parameters[row].identifiable { "yes" } else { "no" }.into());
    sheet.texts("at_bound", |row| if parameters[row].at_bound { "yes" } else { "no" }.into());
    sheet.file(file, 0..parameters.len())
}

/// Figures of the parts of the readings, a part a row: lengths in mm, orientations in deg, torques in N.m (forces in N).
///
/// # Errors
/// As [`Sheet::file`].
pub fn parts(found: &[PartErrors], file: &Path) -> io::Result<Vec<u8>> {
    let mut sheet = Sheet::new();
    sheet.texts("part", |row| found[row].part.to_string());
    sheet.texts("name", |row| found[row].name.clone());
    sheet.column("readings", |row| found[row].errors.readings.to_string());
    type Figure = fn(&ReadingErrors) -> Option<f64>;
    // Those of lengths are always there.
    let lengths: [(&str, Figure); 5] = [
        ("mean", |of| of.has_lengths().then_some(of.mean)),
        ("rms", |of| of.has_lengths().then_some(of.rms)),
        ("max", |of| of.has_lengths().then_some(of.max)),
        ("coordinate_rms", |of| of.has_lengths().then_some(of.coordinate.rms)),
        ("coordinate_max", |of| of.has_lengths().then_some(of.coordinate.max)),
    ];
    let others: [(&str, Figure); 6] = [
        ("orientation_mean", |of| Some(of.orientation?.mean)),
        ("orientation_rms", |of| Some(of.orientation?.rms)),
        ("orientation_max", |of| Some(of.orientation?.max)),
        ("torque_mean", |of| Some(of.load?.mean)),
        ("torque_rms", |of| Some(of.load?.rms)),
        ("torque_max", |of| Some(of.load?.max)),
    ];
    let is_known = |value: Figure| found.iter().any(|of| value(&of.errors).is_some());
    for (name, value) in lengths.into_iter().chain(others.into_iter().filter(|(_, value)| is_known(*value))) {
        let cell = move |row: usize| value(&found[row].errors).map_or_else(String::new, |value| format!("{value:.9}"));
        sheet.column(name, cell);
    }
    sheet.file(file, 0..found.len())
}

/// Table of observed and predicted errors, a configuration a row, to be written to a file of that name; mm.
///
/// # Errors
/// As [`Sheet::file`].
pub fn configurations(found: &[ConfigurationResidual], file: &Path) -> io::Result<Vec<u8>> {
    let shown = |value: f64| format!("{value:.9}");
    let mut sheet = Sheet::new();
    sheet.texts("pose", |row| found[row].pose.clone());
    sheet.column("readings", |row| found[row].readings.to_string());
    if found.iter().any(|of| of.wrench.is_some()) {
        for (k, name) in ["fx", "fy", "fz", "mx", "my", "mz"].into_iter().enumerate() {
            sheet.column(name, move |row| found[row].wrench.map_or(0.0, |wrench| wrench[k]).to_string());
        }
    }
    type OfAxis = fn(&ConfigurationResidual, usize) -> Option<f64>;
    let columns: [(&str, OfAxis); 7] = [
        ("measured", |of, k| Some(of.measured?[k])),
        ("predicted", |of, k| Some(of.predicted?[k])),
        ("least", |of, k| Some(of.range[k][0])),
        ("greatest", |of, k| Some(of.range[k][1])),
        ("error", |of, k| Some(of.mean[k])),
        ("uncertainty", |of, k| Some(of.standard_uncertainty[k])),
        ("ci95", |of, k| Some(of.ci95[k])),
    ];
    for (name, value) in columns.into_iter().filter(|(_, value)| found.iter().any(|of| value(of, 0).is_some())) {
        for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
            sheet.column(format!("{name}.{axis}"), move |row| value(&found[row], k).map_or_else(String::new, shown));
        }
    }
    sheet.column("observed_rms", |row| shown(found[row].observed_rms));
    sheet.column("parameters_rms", |row| shown(found[row].parameters_rms));
    sheet.column("predicted_rms", |row| shown(found[row].predicted_rms));
    sheet.column("predicted_least", |row| shown(found[row].predicted_ci95[0]));
    sheet.column("predicted_greatest", |row| shown(found[row].predicted_ci95[1]));
    sheet.texts("within", |row| if found[row].within { "yes" } else { "no" }.into());
    sheet.file(file, 0..found.len())
}
