//! Paths and processes from disk or from the bundled set.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path as FilePath, PathBuf};

use super::place::{PROCESSES, Place, inside, open};
use super::reader::Reader;
use super::robot::LoadedRobot;
use super::schema_line::name_schema;
use crate::description::path::{Path, expected_columns, read};
use crate::description::process::{RawProcess, faults};
use crate::description::table::{Dialect, Orientation, Table, read_table};
use crate::description::units::Units;
use crate::description::yaml;
use crate::diagnostic::{Diagnostic, Diagnostics, nearest};
use crate::process::Process;

/// Most points of a path.
const MOST_POINTS: usize = 1_000_000;

/// The file of that name, or the one of a bundled process.
fn found(name: &str, file: &str) -> Place {
    let bundled = PathBuf::from(name).join(file);
    let path = FilePath::new(name);
    if path.is_dir() {
        Place::Disk(path.join(file))
    } else if !path.exists() && PROCESSES.get_file(&bundled).is_some() {
        Place::Bundled(bundled)
    } else {
        Place::Disk(path.to_path_buf())
    }
}

/// The diagnostics of a file that could not be read, with the nearest bundled name as the remedy.
fn or_bundled(mut found: Vec<Diagnostic>, name: &str) -> Vec<Diagnostic> {
    let known: Vec<&str> = PROCESSES.dirs().filter_map(|dir| dir.path().to_str()).collect();
    let path = FilePath::new(name);
    if let Some(first) = found.first_mut()
        && first.remedy.is_none()
        && path.is_dir()
    {
        first.remedy = Some(inside(path));
    }
    if let Some(first) = found.first_mut()
        && first.remedy.is_none()
        && !path.exists()
    {
        first.remedy = Some(match nearest(name, known.iter().copied()) {
            Some(near) => format!("did you mean the bundled `{near}`?"),
            None => format!("give a file, or one of the bundled: {}", known.join(", ")),
        });
    }
    found
}

impl Reader {
    /// Reads a path of a robot: a CSV, or the path of a bundled process; in the units given.
    ///
    /// # Errors
    /// Every fault found, located.
    ///
    /// ```
    /// let reader = elastogeo::files::Reader::default();
    /// let robot = reader.robot("kuka-ir663")?;
    /// let path = reader.path("ir663-strip", &robot, robot.raw.units)?;
    /// assert_eq!(path.campaign.readings.len(), 26);
    /// assert!(path.position && path.orientation && !path.joints);
    /// # Ok::<(), elastogeo::Error>(())
    /// ```
    pub fn path(&self, name: &str, robot: &LoadedRobot, units: Units) -> Result<Path, Diagnostics> {
        self.path_as(name, robot, units, Orientation::default())
    }

    /// The same with orientations written otherwise than as rotation vectors.
    ///
    /// # Errors
    /// Every fault found, located.
    pub fn path_as(
        &self,
        name: &str,
        robot: &LoadedRobot,
        units: Units,
        orientation: Orientation,
    ) -> Result<Path, Diagnostics> {
        Ok(read(&table(self, name, robot, &units, &[], orientation)?, &robot.robot, units)?)
    }

    /// Reads a path from the bytes of a table, with orientations so written; `name` is what faults call it.
    ///
    /// # Errors
    /// Every fault found, located.
    pub fn path_text(
        &self,
        name: &str,
        bytes: &[u8],
        robot: &LoadedRobot,
        units: Units,
        orientation: Orientation,
    ) -> Result<Path, Diagnostics> {
        Ok(read(&parsed(name, bytes, robot, &units, &[], orientation)?, &robot.robot, units)?)
    }

    /// Reads commands to carry out: where there are joints they count, and poses next to them are ignored.
    ///
    /// # Errors
    /// Every fault found, located.
    pub fn commands(&self, name: &str, robot: &LoadedRobot, units: Units) -> Result<Path, Diagnostics> {
        let poses = ["x", "y", "z", "rx", "ry", "rz"];
        let ignored: Vec<String> = poses
            .into_iter()
            .filter(|name| robot.robot.variables.iter().all(|v| v.name != *name))
            .map(String::from)
            .collect();
        match table(self, name, robot, &units, &ignored, Orientation::default()) {
            Ok(table) if robot.robot.variables.iter().all(|variable| table.has(&variable.name)) => {
                Ok(read(&table, &robot.robot, units)?)
            }
            _ => self.path(name, robot, units),
        }
    }

    /// Reads a process: a YAML file, or a bundled one; with warnings.
    ///
    /// # Errors
    /// Every fault found, located.
    pub fn process(&self, name: &str) -> Result<(Process, Vec<Diagnostic>), Diagnostics> {
        let (_, process, diagnostics) = self.process_as_declared(name)?;
        Ok((process, diagnostics))
    }

    /// The same with what the file declares.
    ///
    /// # Errors
    /// Every fault found, located.
    pub fn process_as_declared(&self, name: &str) -> Result<(RawProcess, Process, Vec<Diagnostic>), Diagnostics> {
        let place = found(name, "process.yaml");
        let text = place.text(self).map_err(|found| or_bundled(found, name))?;
        self.process_text(&place.name(), &text)
    }

    /// Reads a process from its text; `name` is what faults call it.
    ///
    /// # Errors
    /// Every fault found, located.
    pub fn process_text(&self, name: &str, text: &str) -> Result<(RawProcess, Process, Vec<Diagnostic>), Diagnostics> {
        let (raw, document, mut diagnostics) = yaml::read::<RawProcess>(name, text);
        name_schema(&mut diagnostics, "process");
        let Some(raw) = raw else { return Err(diagnostics.into()) };
        if !diagnostics.iter().any(Diagnostic::is_error) {
            diagnostics.extend(faults(&raw, &|path| document.place_of_value(path)));
        }
        if diagnostics.iter().any(Diagnostic::is_error) {
            return Err(diagnostics.into());
        }
        let process = Process::new(&raw);
        Ok((raw, process, diagnostics))
    }
}

fn table(
    reader: &Reader,
    name: &str,
    robot: &LoadedRobot,
    units: &Units,
    ignored: &[String],
    orientation: Orientation,
) -> Result<Table, Vec<Diagnostic>> {
    let place = found(name, "path.csv");
    let bytes = open(reader, &place).map_err(|diagnostic| or_bundled(vec![diagnostic], name))?;
    parsed(&place.name(), bytes, robot, units, ignored, orientation)
}

/// A table with its orientations as rotation vectors.
fn parsed(
    name: &str,
    bytes: impl Read,
    robot: &LoadedRobot,
    units: &Units,
    ignored: &[String],
    orientation: Orientation,
) -> Result<Table, Vec<Diagnostic>> {
    let expected = orientation.expected(expected_columns(&robot.robot, units));
    let dialect = Dialect { orientation, ..Dialect::default() };
    let mut table = read_table(name, bytes, &expected, &BTreeMap::new(), ignored, &dialect, MOST_POINTS)?;
    table.add_rotation_vectors(orientation, units.angle)?;
    Ok(table)
}
