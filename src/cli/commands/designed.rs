//! Readings that a campaign file asks for, before they are made: its tables with joints and names, and nothing measured.

use indexmap::IndexMap;

use crate::Error;
use crate::cli::session::Session;
use crate::cli::values::markers;
use crate::description::campaign::raw::{Measurements, RawCampaign, RawCsv, RawEntry};
use crate::description::campaign::{WRENCH, kinds};
use crate::description::table::Sheet;
use crate::description::units::Units;
use crate::diagnostic::Code;
use crate::files::{Design, LoadedCampaign};
use crate::observation::{ANCHOR_COLUMN, CONTACT_COLUMN};

/// The cells of a row, by column.
pub type Cells = IndexMap<String, String>;

/// What is to be read of each file of a campaign.
pub struct Wanted<'a> {
    /// Markers read at each configuration; the tool centre point where there are none.
    pub markers: &'a [String],
    /// Readings of each point.
    pub repeats: usize,
    /// Wrenches on the tool, one reading each, N and N.m; none where empty.
    pub wrenches: &'a [[f64; 6]],
    /// Where the fixtures of contacts stand one after the other.
    pub placements: usize,
    /// Of each file, runs of rows one after the other: the cells that name their session and station. Nothing where the campaign file names
    /// them.
    pub runs: &'a [Vec<Cells>],
    /// Rows of a file that name the joints, and may name what is touched; in its units.
    pub given: Option<&'a [Cells]>,
}

/// The campaign file with files of its own for what is to be read, written as this program writes tables.
pub fn plain(raw: &RawCampaign) -> RawCampaign {
    let entries = raw.measurements.as_ref().map_or(&[][..], |all| &all.0);
    let own = |(k, entry): (usize, &RawEntry)| RawEntry {
        file: if entries.len() == 1 { "measurements.csv".into() } else { format!("measurements-{}.csv", k + 1) },
        columns: Default::default(),
        ignore: Vec::new(),
        csv: None,
        format: None,
        points: None,
        orientation: None,
        joints: None,
        join: None,
        ..entry.clone()
    };
    let measurements = match entries.is_empty() {
        true => Measurements::file("measurements.csv"),
        false => Measurements(entries.iter().enumerate().map(own).collect()),
    };
    RawCampaign {
        measurements: Some(measurements),
        references: None,
        columns: Default::default(),
        ignore: Vec::new(),
        orientation: None,
        joints: None,
        csv: RawCsv::default(),
        ..raw.clone()
    }
}

/// The campaign of `raw` (as [`plain`] makes it) at these configurations (rad, m), one list for each file. Every value that is to be
/// measured is one, whatever its unit: it has to be predicted.
///
/// # Errors
/// What cannot be read so, as it would be of a measured campaign.
pub fn blank(
    design: &Design,
    raw: RawCampaign,
    wanted: &Wanted,
    configurations: &[Vec<Vec<f64>>],
) -> Result<LoadedCampaign, Error> {
    markers(&design.robot.model, wanted.markers)?;
    let mut tables = Vec::new();
    for rows in all_rows(design, &raw, wanted, configurations) {
        tables.push(sheet(&rows).csv(0..rows.len())?);
    }
    let mut found = design.measured(raw, &tables)?;
    // Repeats are copies of each other until they are measured.
    found.diagnostics.retain(|diagnostic| diagnostic.code != Code::SuspectReadings);
    Ok(found)
}

/// Whether some file of a campaign holds differences with and without load.
pub fn holds_differences(design: &Design, raw: &RawCampaign) -> bool {
    let mut all = raw.entries().into_iter().flat_map(|entry| kinds(&entry, &design.kinds));
    all.any(|kind| kind.is_difference())
}

/// Rows of each file, as [`blank`] reads them.
pub fn all_rows(
    design: &Design,
    raw: &RawCampaign,
    wanted: &Wanted,
    configurations: &[Vec<Vec<f64>>],
) -> Vec<Vec<Cells>> {
    let mut all = Vec::new();
    let mut poses = 0;
    let entries = raw.measurements.iter().flat_map(|all| &all.0).enumerate();
    for ((k, entry), configurations) in entries.zip(configurations) {
        let runs = wanted.runs.get(k).map_or(&[][..], Vec::as_slice);
        all.push(rows(design, raw, &raw.completed(entry), wanted, &Asked { configurations, poses, runs }));
        poses += configurations.len();
    }
    all
}

/// Rows of a CSV that name joints, and what is touched or carried with them.
pub fn given(session: &Session, path: &std::path::Path) -> Result<Vec<Cells>, Error> {
    let text = session.reader.text(path)?;
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let refused = |error: csv::Error| {
        Error::input(format!("`{}`: {error}", path.display()), "give a CSV as `plan --table` writes it")
    };
    let names = reader.headers().map_err(refused)?.clone();
    let cells = |record: csv::StringRecord| -> Cells {
        names.iter().map(str::trim).zip(record.iter().map(str::trim)).map(|(a, b)| (a.into(), b.into())).collect()
    };
    reader.records().map(|record| Ok(cells(record.map_err(refused)?))).collect()
}

/// A table of these rows.
pub fn sheet(rows: &[Cells]) -> Sheet<'_> {
    let mut names: Vec<&String> = Vec::new();
    for name in rows.iter().flat_map(|row| row.keys()) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let mut sheet = Sheet::new();
    for name in names {
        sheet.texts(name, |row| rows[row].get(name).cloned().unwrap_or_default());
    }
    sheet
}

/// How many different rows a file needs, so that each contact in each placement, and each payload, is in one.
pub fn variety(design: &Design, raw: &RawCampaign, entry: &RawEntry, wanted: &Wanted) -> usize {
    let payloads = if entry.payload.is_none() { raw.payloads.len() + 1 } else { 1 };
    touched(design, raw, entry, wanted).len().max(1) * payloads
}

/// What each row of a file may touch, as cells: a contact in a placement. Empty where the file is of no contacts.
fn touched(design: &Design, raw: &RawCampaign, entry: &RawEntry, wanted: &Wanted) -> Vec<Cells> {
    if !kinds(entry, &design.kinds).iter().any(|kind| kind.touches()) {
        return Vec::new();
    }
    let one = |name: &String| Cells::from([(CONTACT_COLUMN.to_string(), name.clone())]);
    let mut all = Vec::new();
    for member in 1..=wanted.placements.max(1) {
        for (name, contact) in &raw.contacts {
            // The entry may say of all its rows in which group they are.
            match contact.group.as_ref().filter(|group| entry.named(group).is_none()) {
                None if member == 1 => all.push(one(name)),
                None => {}
                Some(group) => {
                    let mut cells = one(name);
                    cells.insert(group.clone(), member.to_string());
                    all.push(cells);
                }
            }
        }
    }
    // A table has one set of columns.
    let groups = raw.contacts.values().filter_map(|contact| contact.group.as_ref());
    let groups: Vec<&String> = groups.filter(|group| entry.named(group).is_none()).collect();
    for cells in &mut all {
        for group in &groups {
            cells.entry((*group).clone()).or_insert_with(|| "1".into());
        }
    }
    all
}

/// What is asked for of one file.
struct Asked<'a> {
    configurations: &'a [Vec<f64>],
    /// Configurations of the files before.
    poses: usize,
    runs: &'a [Cells],
}

fn rows(design: &Design, raw: &RawCampaign, entry: &RawEntry, wanted: &Wanted, asked: &Asked) -> Vec<Cells> {
    let &Asked { configurations, poses, runs } = asked;
    let (robot, units) = (&design.robot.robot, entry.units(raw.units));
    let kinds = kinds(entry, &design.kinds);
    let touched = touched(design, raw, entry, wanted);
    let needs_anchor = kinds.iter().any(|kind| kind.needs_anchor());
    let own = robot.anchors.iter().map(|(name, _)| name).filter(|name| !raw.anchors.contains_key(*name));
    let anchors: Vec<&String> = own.chain(raw.anchors.keys()).filter(|_| needs_anchor).collect();
    let sees_points = kinds.iter().any(|kind| !kind.ignores_arrangement());
    // Of places and deflections the latter are the loaded ones.
    let is_loaded = kinds.iter().any(|kind| kind.is_difference()) || !holds_differences(design, raw);
    let wrenches = if is_loaded { wanted.wrenches } else { &[] };
    let count = configurations.len();
    let mut all = Vec::new();
    for (k, q) in configurations.iter().enumerate() {
        let mut cells = Cells::from([("pose".to_string(), format!("p{:03}", poses + k + 1))]);
        for (variable, q) in robot.variables.iter().zip(q) {
            cells.insert(variable.name.clone(), (q / units.of(variable.kind())).to_string());
        }
        // One run after the other: a fixture is put down once, and a session ends.
        let sessions = runs.len().max(1);
        let run = k * sessions / count;
        let (begin, end) = ((run * count).div_ceil(sessions), ((run + 1) * count).div_ceil(sessions));
        cells.extend(runs.get(run).cloned().unwrap_or_default());
        let payloads = raw.payloads.len() + 1;
        if payloads > 1 && entry.payload.is_none() {
            let name = (k % payloads).checked_sub(1).and_then(|k| raw.payloads.get_index(k));
            cells.insert("payload".into(), name.map_or_else(|| "none".into(), |(name, _)| name.clone()));
        }
        if !touched.is_empty() {
            cells.extend(touched[(k - begin) * touched.len() / (end - begin).max(1)].clone());
        }
        if let Some(given) = wanted.given.and_then(|rows| rows.get(k)) {
            cells.extend(named(given, &cells, raw));
        }
        for kind in &kinds {
            cells.extend(kind.columns().iter().map(|column| (column.name.to_string(), "1".to_string())));
            if let Some(prefix) = kind.by_variable() {
                let is_read = |name: &String| raw.torques.is_empty() || raw.torques.contains_key(name);
                let read = robot.variables.iter().map(|variable| &variable.name).filter(|name| is_read(name));
                cells.extend(read.map(|name| (format!("{prefix}.{name}"), "1".to_string())));
            }
        }
        let each = each_reading(wanted, wrenches, sees_points, &anchors, &units);
        all.extend(each.into_iter().map(|own| cells.clone().into_iter().chain(own).collect::<Cells>()));
    }
    all
}

/// What differs between the rows of one configuration: marker, anchor, wrench; repeats one after the other.
fn each_reading(
    wanted: &Wanted,
    loads: &[[f64; 6]],
    sees_points: bool,
    anchors: &[&String],
    units: &Units,
) -> Vec<Cells> {
    let markers = if sees_points && !wanted.markers.is_empty() { wanted.markers } else { &[String::new()][..] };
    let wrenches = if loads.is_empty() { &[[0.0; 6]][..] } else { loads };
    let unit = |k: usize| if k < 3 { units.force.factor() } else { units.torque.factor() };
    let mut all = Vec::new();
    for marker in std::iter::repeat_n(markers, wanted.repeats).flatten() {
        for anchor in anchors.iter().map(|name| Some(*name)).chain(anchors.is_empty().then_some(None)) {
            for wrench in wrenches {
                let mut row = Cells::new();
                if !marker.is_empty() {
                    row.insert("marker".into(), marker.clone());
                }
                row.extend(anchor.map(|name| (ANCHOR_COLUMN.to_string(), name.clone())));
                if !loads.is_empty() {
                    let load = wrench.iter().enumerate();
                    row.extend(load.map(|(k, v)| (WRENCH[k].to_string(), (v / unit(k)).to_string())));
                }
                all.push(row);
            }
        }
    }
    all
}

/// What a given row says in addition to its joints: what is touched and where, what is carried, in which session.
fn named(given: &Cells, known: &Cells, raw: &RawCampaign) -> Vec<(String, String)> {
    let groups = raw.contacts.values().filter_map(|contact| contact.group.clone());
    let names = ["pose", CONTACT_COLUMN, "payload", "session", "station"].map(String::from).into_iter().chain(groups);
    let is_said = |name: &String| known.contains_key(name) || name == "session" || name == "station";
    names
        .filter(is_said)
        .filter_map(|name| Some((name.clone(), given.get(&name).filter(|text| !text.is_empty())?.clone())))
        .collect()
}
