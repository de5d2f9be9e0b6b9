//! Campaign files of which nothing is measured yet: what they say of readings to come, for simulation and planning.

use super::campaign::{Described, LoadedCampaign, described, resolved};
use super::place::Place;
use super::reader::Reader;
use super::readings::{Asked, read};
use super::robot::LoadedRobot;
use crate::description::campaign::expected_columns;
use crate::description::campaign::raw::{RawCampaign, RawEntry};
use crate::description::table::Table;
use crate::description::yaml::Document;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::observation::Kinds;

/// A campaign file with its robot, whatever its files of readings hold.
#[derive(Debug)]
pub struct Design {
    /// The campaign file.
    pub raw: RawCampaign,
    /// Its robot.
    pub robot: LoadedRobot,
    /// Warnings, the robot's left out.
    pub diagnostics: Vec<Diagnostic>,
    /// Kinds of readings that it may name.
    pub kinds: Kinds,
    document: Document,
    place: Place,
}

impl Reader {
    /// Reads a campaign file and its robot, or the one given instead, and none of its measurements.
    ///
    /// # Errors
    /// Every fault of the two, located.
    pub fn design(&self, file: &str, robot: Option<&str>) -> Result<Design, Diagnostics> {
        let Described { raw, document, place, mut diagnostics, robot } = described(self, file, robot)?;
        let is_sound = !diagnostics.iter().any(Diagnostic::is_error);
        match robot {
            Ok(robot) if is_sound => Ok(Design { raw, robot, diagnostics, kinds: self.kinds.clone(), document, place }),
            Ok(_) => Err(diagnostics.into()),
            Err(mut reported) => {
                diagnostics.append(&mut reported);
                Err(diagnostics.into())
            }
        }
    }
}

impl Design {
    /// Whether there is none of its files of readings.
    pub fn is_unmeasured(&self) -> bool {
        let Place::Disk(_) = &self.place else { return false };
        let entries = self.raw.measurements.iter().flat_map(|all| &all.0);
        entries.map(|entry| self.place.next_to(&entry.file)).all(|file| match file {
            Place::Disk(path) => !path.exists(),
            Place::Bundled(_) => false,
        })
    }

    /// The campaign that `raw` (its file, with other files of readings) and these tables (CSV) in the order of its
    /// `measurements:` make.
    ///
    /// # Errors
    /// Every fault, located in the campaign file where it is one of it.
    pub fn measured(&self, raw: RawCampaign, tables: &[String]) -> Result<LoadedCampaign, Diagnostics> {
        let entries = raw.entries();
        let robot = &self.robot.robot;
        let mut found: Vec<Table> = Vec::new();
        for (entry, text) in entries.iter().zip(tables) {
            let units = entry.units(raw.units);
            let asked = Asked {
                expected: expected_columns(&raw, entry, robot, &self.kinds),
                variables: robot.variables.iter().map(|variable| variable.name.as_str()).collect(),
                units: &units,
                entry,
            };
            let bytes = std::io::Cursor::new(text.clone().into_bytes());
            found.push(read(&asked, vec![(entry.file.clone(), Box::new(bytes))])?);
        }
        let read: Vec<(RawEntry, &Table)> = entries.into_iter().zip(&found).collect();
        Ok(resolved(&self.kinds, raw, &self.document, self.robot.clone(), &read, self.diagnostics.clone())?)
    }
}
