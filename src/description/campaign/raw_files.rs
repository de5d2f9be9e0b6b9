//! Image of what a campaign says of how its files are written.

#[cfg(feature = "cli")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::description::table::Points;

/// What kind of file holds readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Format {
    /// A table under a line with the names of its columns.
    Table,
    /// Points as metrology programs export them: collection, group, name, x, y, z, with or without a header.
    Points,
}

/// A field that names a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum PointField {
    /// Its collection.
    Collection,
    /// Its group.
    Group,
    /// Its own name.
    Name,
}

impl PointField {
    fn name(self) -> String {
        match self {
            Self::Collection => "collection".into(),
            Self::Group => "group".into(),
            Self::Name => "name".into(),
        }
    }
}

/// What the fields of a list of points are.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct RawPoints {
    /// The field that names the pose; the point's name where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose: Option<PointField>,
    /// The field that names the marker.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub marker: Option<PointField>,
    /// The field that names the session.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub session: Option<PointField>,
    /// The field that names the station of the instrument.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub station: Option<PointField>,
    /// The fields of a line in order, where they are not collection, group, name, x, y, z or the last of these.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub fields: Vec<String>,
}

impl From<&RawPoints> for Points {
    fn from(raw: &RawPoints) -> Self {
        let pose = Some(raw.pose.unwrap_or(PointField::Name));
        let all = [("pose", pose), ("marker", raw.marker), ("session", raw.session), ("station", raw.station)];
        let columns = all.into_iter().filter_map(|(ours, field)| Some((ours.to_owned(), field?.name()))).collect();
        Self { columns, fields: raw.fields.clone() }
    }
}

impl RawCsv {
    /// Most rows of a campaign where nothing is said: a calibration of the six joints of the starter on so many positions takes 0.55 GB
    /// (measured with `/usr/bin/time`, base and marker unknown).
    pub const MOST_ROWS: usize = 80_000;
}

/// How CSV files are written.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct RawCsv {
    /// Between fields; guessed from the header line where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delimiter: Option<char>,
    /// `.` or `,`; where absent a point between commas, else that of the first number that has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decimal: Option<char>,
    /// Most rows accepted of a file and of all together; 80,000 where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_rows: Option<usize>,
}
