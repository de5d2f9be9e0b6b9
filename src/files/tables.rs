//! The tables of a campaign's measurements: which files they are, and what is read of them.

use super::place::{Place, open};
use super::reader::Reader;
use super::readings::{Asked, faults, read};
use super::robot::LoadedRobot;
use crate::description::campaign;
use crate::description::campaign::raw::{RawCampaign, RawCsv, RawEntry};
use crate::description::table::{Table, too_many};
use crate::description::yaml::Document;
use crate::diagnostic::Diagnostic;

/// A table in the place of a file of measurements, with what holds of it.
pub(super) struct Made {
    pub entry: RawEntry,
    pub csv: String,
}

/// Of a file that a campaign names, and that cannot be opened.
pub(super) fn unopened(mut diagnostic: Diagnostic, at: impl Into<Option<crate::diagnostic::Place>>) -> Diagnostic {
    diagnostic
        .remedy
        .get_or_insert_with(|| "correct the name; the file is sought in the folder of the campaign".into());
    diagnostic.at(at)
}

/// Diagnostics on files of measurements that cannot be opened. Their columns are not checked: that needs the robot's
/// variables.
pub(super) fn check_table_files(
    reader: &Reader,
    raw: &RawCampaign,
    place: &Place,
    document: &Document,
    diagnostics: &mut Vec<Diagnostic>,
) {
    for file in table_files(raw, place, document, diagnostics) {
        for (path, place) in file.all() {
            if let Err(diagnostic) = open(reader, place) {
                diagnostics.push(unopened(diagnostic, place_of(document, path)));
            }
        }
    }
}

/// Where the files of a campaign are.
pub(super) struct Files<'a> {
    pub place: &'a Place,
    pub document: &'a Document,
    pub made: &'a [Option<Made>],
}

/// The tables of measurements that can be read.
pub(super) fn tables(
    reader: &Reader,
    raw: &RawCampaign,
    files: &Files,
    robot: &LoadedRobot,
    diagnostics: &mut Vec<Diagnostic>,
) -> Vec<(RawEntry, Table)> {
    let &Files { place, document, made } = files;
    let (mut tables, mut rows) = (Vec::new(), 0);
    let files = table_files(raw, place, document, diagnostics);
    // With a fault in what says how the files are read, their faults would follow from those.
    let mut keys = ["observes", "columns", "ignore", "csv", "orientation", "contacts", "loads", "payloads"].into_iter();
    let is_readable = keys.all(|key| !document.holds_fault(&[key])) && raw.unknown_kinds(&reader.kinds).is_empty();
    for (k, file) in files.into_iter().enumerate() {
        let made = made.get(k).and_then(Option::as_ref);
        let entry = made.map_or_else(|| raw.completed(file.entry), |made| made.entry.clone());
        let units = entry.units(raw.units);
        let asked = Asked {
            expected: campaign::expected_columns(raw, &entry, &robot.robot, &reader.kinds),
            variables: robot.robot.variables.iter().map(|variable| variable.name.as_str()).collect(),
            units: &units,
            entry: &entry,
        };
        let mut opened = Vec::new();
        for (path, place) in file.all().filter(|_| made.is_none()) {
            match open(reader, place) {
                Ok(bytes) => opened.push((place.name(), bytes)),
                Err(diagnostic) => diagnostics.push(unopened(diagnostic, place_of(document, path))),
            }
        }
        if let Some(made) = made {
            opened.push((file.place.name(), Box::new(std::io::Cursor::new(made.csv.clone().into_bytes()))));
        }
        let declared = faults(&asked, |key| place_of_key(document, &file.path, key));
        if !is_readable
            || file.is_unclear(document)
            || !declared.is_empty()
            || made.is_none() && opened.len() < file.all().count()
        {
            diagnostics.extend(declared);
            continue;
        }
        match read(&asked, opened) {
            Ok(table) => {
                rows += table.row_count();
                let most = entry.csv.as_ref().and_then(|csv| csv.max_rows).unwrap_or(RawCsv::MOST_ROWS);
                if rows > most {
                    diagnostics.push(too_many(most).at(place_of(document, &file.path)));
                    break;
                }
                tables.push((entry, table));
            }
            Err(mut found) => diagnostics.append(&mut found),
        }
    }
    tables
}

/// A file of measurements, and that of its joints where there is one; with the keys of the campaign file that name them.
struct File<'r> {
    path: Vec<String>,
    place: Place,
    joints: Option<(Vec<String>, Place)>,
    entry: &'r RawEntry,
}

impl File<'_> {
    fn all(&self) -> impl Iterator<Item = (&Vec<String>, &Place)> {
        std::iter::once((&self.path, &self.place)).chain(self.joints.iter().map(|(path, place)| (path, place)))
    }

    /// Whether a fault is reported of what its entry says of how it is written.
    fn is_unclear(&self, document: &Document) -> bool {
        const KEYS: [&str; 9] =
            ["observes", "format", "points", "joints", "join", "csv", "columns", "ignore", "orientation"];
        let entry: Vec<&str> = self.path.iter().map(String::as_str).filter(|part| *part != "file").collect();
        KEYS.iter().any(|key| document.holds_fault(&[&entry[..], &[key]].concat()))
    }
}

fn place_of(document: &Document, path: &[String]) -> Option<crate::diagnostic::Place> {
    document.place_of_value(&path.iter().map(String::as_str).collect::<Vec<_>>())
}

/// Where a key of the entry of a file stands.
fn place_of_key(document: &Document, file: &[String], key: &str) -> Option<crate::diagnostic::Place> {
    let mut path: Vec<&str> = file.iter().map(String::as_str).filter(|part| *part != "file").collect();
    path.push(key);
    document.place_of_value(&path)
}

/// The files of measurements; a diagnostic where there are none.
fn table_files<'r>(
    raw: &'r RawCampaign,
    place: &Place,
    document: &Document,
    diagnostics: &mut Vec<Diagnostic>,
) -> Vec<File<'r>> {
    let entries = raw.measurements.as_ref().map_or(&[][..], |all| &all.0);
    let has = |path: &[&str]| document.has(path);
    let path = |k: usize, key: &str| {
        let number = k.to_string();
        let paths = [&["measurements", &number, key][..], &["measurements", key], &["measurements", &number]];
        let named = paths.into_iter().find(|path| has(path)).unwrap_or(&["measurements"]);
        named.iter().map(ToString::to_string).collect::<Vec<String>>()
    };
    let file = |(k, entry): (usize, &'r RawEntry)| {
        let joints = entry.joints.as_ref().map(|joints| (path(k, "joints"), place.next_to(joints)));
        File { path: path(k, "file"), place: place.next_to(&entry.file), joints, entry }
    };
    let files: Vec<File> = entries.iter().enumerate().map(file).collect();
    if files.is_empty() && !document.explains_absence(&["measurements"]) {
        diagnostics.push(
            Diagnostic::error("the campaign names no measurements")
                .at(document.place_of_value(&["measurements"]))
                .remedy("add `measurements: file.csv`"),
        );
    }
    files
}
