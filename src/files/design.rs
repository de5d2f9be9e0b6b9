//! Campaign files of which nothing is measured yet: what they say of readings to come, for simulation and planning.

use std::path::Path;

use super::campaign::{Described, LoadedCampaign, described, read_campaign, resolved};
use super::place::Place;
use super::reader::Reader;
use super::readings::{Asked, read};
use super::robot::LoadedRobot;
use super::tables::Made;
use crate::description::campaign::expected_columns;
use crate::description::campaign::raw::{RawCampaign, RawEntry};
use crate::description::table::{Table, workbook_name};
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
    /// Of each of its files of readings, whether nothing is measured yet: there is no such file, or it holds a header alone.
    pub fn unmeasured(&self) -> Vec<bool> {
        let entries = self.raw.measurements.iter().flat_map(|all| &all.0);
        entries.map(|entry| is_unmeasured(&self.place.next_to(&entry.file))).collect()
    }

    /// Whether nothing is measured yet.
    pub fn is_unmeasured(&self) -> bool {
        self.unmeasured().into_iter().all(|one| one)
    }

    /// The campaign read again by `reader` from its name (and another robot's), with tables (CSV) of `raw`, which has the same entries, in the
    /// place of those of its files of which nothing is measured.
    ///
    /// # Errors
    /// Every fault found, located.
    pub fn continued(
        &self,
        reader: &Reader,
        [file, robot]: [Option<&str>; 2],
        raw: &RawCampaign,
        tables: Vec<String>,
    ) -> Result<LoadedCampaign, Diagnostics> {
        let made = raw.entries().into_iter().zip(tables).zip(self.unmeasured());
        let made = made.map(|((entry, csv), is_unmeasured)| is_unmeasured.then_some(Made { entry, csv }));
        Ok(read_campaign(reader, file.unwrap_or_default(), robot, &made.collect::<Vec<_>>())?)
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

/// Whether a file of readings is not there, or is a text of one line at most.
fn is_unmeasured(place: &Place) -> bool {
    const FEW_BYTES: u64 = 64 << 10;
    let Place::Disk(path) = place else { return false };
    let workbook = path.to_str().and_then(workbook_name).map(|(workbook, _)| Path::new(workbook));
    let Ok(file) = std::fs::metadata(workbook.unwrap_or(path)) else { return !workbook.unwrap_or(path).exists() };
    if workbook.is_some() || !file.is_file() || file.len() > FEW_BYTES {
        return false;
    }
    let text = std::fs::read(path).unwrap_or_default();
    let lines = text.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    lines.filter(|line| !line.is_empty() && !line.starts_with(b"#")).count() <= 1
}
