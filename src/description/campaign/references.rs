//! Fixed reflectors on base or pedestal, measured again and again while the robot is: evidence of the instrument's noise, and for
//! or against motion of the base. No joints, no robot.

use std::collections::{HashMap, HashSet};

use nalgebra::Vector3;

use super::raw::{RawCampaign, RawEntry};
use crate::description::table::{ColumnKind, ExpectedColumn, Table};
use crate::description::units::Units;
use crate::diagnostic::{Code, Diagnostic};
use crate::parameter::Kind;

/// Readings of fixed reflectors.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct References {
    /// Names of the reflectors.
    pub reflectors: Vec<String>,
    /// Number of times that the reflectors were measured, one after the other.
    pub epochs: usize,
    /// All readings.
    pub readings: Vec<ReferenceReading>,
    /// Configurations that the rows name, each once.
    pub poses: Vec<String>,
    /// Whether some stand on the pedestal: where they stand still, the robot may have moved on it.
    pub beside_base: bool,
    /// Rows whose session only their number (`order`) says.
    pub numbered: usize,
}

/// A reading of a fixed reflector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceReading {
    /// The time, from 0 to [`References::epochs`] less 1.
    pub epoch: usize,
    /// The reflector, by index in [`References::reflectors`].
    pub reflector: usize,
    /// Its position, m, measurement frame.
    pub position: Vector3<f64>,
}

/// What a row says of the configuration at which it was measured.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Configuration {
    /// Its name, by the column `pose`.
    Pose(String),
    /// Its number, by the column `order`: the bits of it, which may lie between those of two readings.
    Order(u64),
}

impl Configuration {
    /// What a row of a table says: the number before the name.
    pub fn of(table: &Table, row: usize) -> impl Iterator<Item = Self> + use<> {
        let order = table.numbers("order").and_then(|all| all.get(row)).filter(|number| number.is_finite());
        let pose = table.texts("pose").and_then(|all| all.get(row)).filter(|name| !name.is_empty());
        let order = order.map(|number| Self::Order(number.to_bits()));
        order.into_iter().chain(pose.map(|name| Self::Pose(name.to_owned())))
    }
}

/// What holds of a file of references: the campaign's units and dialect where it has none of its own.
pub fn completed(raw: &RawCampaign, entry: &RawEntry) -> RawEntry {
    let mut all = entry.clone();
    all.units = Some(all.units(raw.units).into());
    all.csv = all.csv.or_else(|| Some(raw.csv.clone()));
    all
}

/// Columns of such a file.
pub fn reference_columns(units: &Units) -> Vec<ExpectedColumn> {
    let column = |name: &str, kind, required| ExpectedColumn::new(name, kind, required);
    let length = units.unit(Kind::Length).map_or(ColumnKind::Number, ColumnKind::Quantity);
    let [pose, session, reflector] = [("pose", false), ("session", false), ("reflector", true)]
        .map(|(name, required)| column(name, ColumnKind::Text, required));
    let order = column("order", ColumnKind::Number, false);
    let coordinates = ["x", "y", "z"].map(|name| column(name, length, true));
    [pose, session, order, reflector].into_iter().chain(coordinates).collect()
}

impl References {
    /// A warning where rows name configurations that are none of a campaign's.
    pub fn of_another_campaign(&self, poses: &[String]) -> Option<Diagnostic> {
        let known: HashSet<&str> = poses.iter().map(String::as_str).collect();
        let unknown: Vec<&String> = self.poses.iter().filter(|pose| !known.contains(pose.as_str())).collect();
        let first = unknown.first()?;
        if unknown.len() < self.poses.len() {
            let message = format!(
                "fixed reflectors were measured at {} configurations that the campaign does not have, such as `{first}`: they count between its \
                 own, or not at all where each session has a base of its own",
                unknown.len()
            );
            return Some(
                Diagnostic::warning(message).remedy("correct the names in the column `pose` of the references"),
            );
        }
        let message = format!(
            "fixed reflectors were measured at configurations `{first}` .., none of which the campaign has: references of another campaign?"
        );
        let remedy = "name the file of references that belongs to these readings, or leave its column `pose` out";
        Some(Diagnostic::warning(message).code(Code::SuspectReadings).remedy(remedy))
    }

    /// A warning where rows say by their number alone with which readings they were measured, and the readings have no numbers: of which
    /// session they are is then not known, which counts where each has a base of its own.
    pub fn unnumbered(&self) -> Option<Diagnostic> {
        (self.numbered > 0).then(|| {
            let message = format!(
                "{} rows of fixed reflectors are numbered by `order`, and the readings have no such column: of which session they are is not \
                 known, and they do not count, since each session has a base of its own",
                self.numbered
            );
            let remedy = "give the readings a column `order`; or name in the references the session of each row, or its configuration (`pose`)";
            Diagnostic::warning(message).code(Code::Doubtful).remedy(remedy)
        })
    }

    /// Appends the rows of a table. Rows of one `order`, or else of one `pose`, were measured together; without either, each
    /// reading of a reflector begins a new time where that reflector was read before. Reflectors of two sessions are not compared:
    /// those of the column `session`, of a file of one `session`, or of configurations of it; none of them counts where `of_pose`
    /// is `None`, since the base is one of all sessions.
    pub fn append(
        &mut self,
        table: &Table,
        units: &Units,
        session: Option<&str>,
        of_pose: Option<&HashMap<Configuration, &str>>,
    ) {
        let factor = units.length.factor();
        let names = table.texts("reflector");
        let sessions = table.texts("session");
        let coordinates = ["x", "y", "z"].map(|name| table.numbers(name));
        let mut by_key: HashMap<(Configuration, &str), usize> = HashMap::new();
        let mut seen: Vec<usize> = Vec::new();
        for row in 0..table.row_count() {
            let name = names.and_then(|names| names.get(row)).unwrap_or_default();
            let at: Vec<Configuration> = Configuration::of(table, row).collect();
            let named = sessions.and_then(|all| all.get(row)).filter(|own| !own.is_empty()).or(session);
            let is_numbered = matches!(at[..], [Configuration::Order(_)]);
            self.numbered += usize::from(is_numbered && named.is_none());
            let of_row = of_pose.and_then(|known| named.or_else(|| at.iter().find_map(|at| known.get(at)).copied()));
            let name = of_row.map_or_else(|| name.to_owned(), |session| format!("{name}@{session}"));
            let reflector = self.reflectors.iter().position(|own| *own == name).unwrap_or_else(|| {
                self.reflectors.push(name);
                self.reflectors.len() - 1
            });
            for at in &at {
                if let Configuration::Pose(name) = at
                    && self.poses.last() != Some(name)
                {
                    self.poses.push(name.clone());
                }
            }
            let key = at.into_iter().next().map(|at| (at, of_row.unwrap_or_default()));
            let epoch = match key {
                Some(key) => *by_key.entry(key).or_insert_with(|| {
                    self.epochs += 1;
                    self.epochs - 1
                }),
                None => {
                    if seen.is_empty() || seen.contains(&reflector) {
                        seen.clear();
                        self.epochs += 1;
                    }
                    seen.push(reflector);
                    self.epochs - 1
                }
            };
            let coordinate =
                |k: usize| coordinates[k].and_then(|all| all.get(row)).copied().unwrap_or(f64::NAN) * factor;
            let position = Vector3::new(coordinate(0), coordinate(1), coordinate(2));
            self.readings.push(ReferenceReading { epoch, reflector, position });
        }
    }
}
