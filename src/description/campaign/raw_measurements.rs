//! Image of `measurements:` and of the short forms that a campaign file allows: one name or a list, a file or an entry that
//! says more about it. Read by hand where an untagged enum would only say that nothing matched.

#[cfg(feature = "cli")]
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

#[cfg(feature = "cli")]
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::raw_files::{Format, RawCsv, RawPoints};
use super::raw_instrument::RawInstrument;
use super::raw_targets::OrUnknown;
use super::sessions::{SESSION, STATION, Sharing};
use crate::description::form::forms;
use crate::description::table::{Join, Orientation};
use crate::description::units::{SomeUnits, Units};
use crate::observation::Observes;

/// A file of readings, and what differs from what the campaign says of all its files.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct RawEntry {
    /// The file, relative to the campaign's.
    pub file: String,
    /// What its readings are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub observes: Option<RawKinds>,
    /// The session in which they were taken; a column `session` says it row by row.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub session: Option<String>,
    /// The station of the instrument; a column `station` says it row by row.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub station: Option<String>,
    /// What the tool carries in these readings; a column `payload` says it row by row.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub payload: Option<String>,
    /// Where the wrenches of these readings are applied: a marker, `TCP` or a frame of the tool's body, else the measured
    /// point; a column `load_point` says it row by row.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load_point: Option<String>,
    /// Units of this file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<SomeUnits>,
    /// Noise of the instrument with which they were taken.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instrument: Option<RawInstrument>,
    /// The frame whose inclination is read; that of the tool where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<String>,
    /// Rotation vector of the inclinometer's axes in those of the frame, in the unit of angles; none where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mount: Option<OrUnknown<[f64; 3]>>,
    /// Columns that are named otherwise in the file: our name, the file's name; in addition to the campaign's.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub columns: BTreeMap<String, String>,
    /// Columns of the file to pass over, in addition to the campaign's.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ignore: Vec<String>,
    /// Markers that each row holds, in columns `<marker>_x` and so on; a column `marker` says of a row which one it is.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub markers: Vec<String>,
    /// How the file is written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub csv: Option<RawCsv>,
    /// Whether it is a table or a list of points.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub format: Option<Format>,
    /// Of a list of points: what its fields are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<RawPoints>,
    /// How orientations are written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orientation: Option<Orientation>,
    /// The file of the joints of these readings, where they are not in the same.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joints: Option<String>,
    /// Columns of the file of joints whose names are others than `columns` says: our name, that file's name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub joint_columns: BTreeMap<String, String>,
    /// How rows of both files belong together: by the names of poses where both have them, else by order.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub join: Option<Join>,
    /// Of fixed reflectors: what they stand on; the robot's base where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on: Option<StandsOn>,
}

/// What fixed reflectors stand on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum StandsOn {
    /// The robot's base: they move with it against the instrument.
    Base,
    /// What the robot is mounted on: they show motion of the instrument, and not that of the robot on its mount.
    Pedestal,
}

/// Files of readings: a name, an entry, or a list of them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Measurements(pub Vec<RawEntry>);

/// Kinds of readings in one row, by their names: one or a list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RawKinds(pub Vec<String>);

/// Whether a part of the arrangement is unknown, and between what it is shared: `true`, `false`, `per-session`,
/// `per-station`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct RawSharing(pub Option<Sharing>);

impl RawSharing {
    /// Whether it is known.
    pub fn is_known(&self) -> bool {
        self.0.is_none()
    }
}

impl RawKinds {
    /// One kind.
    pub fn one(observes: Observes) -> Self {
        Self(vec![observes.name().into()])
    }
}

impl Measurements {
    /// One file.
    pub fn file(name: impl Into<String>) -> Self {
        Self(vec![RawEntry { file: name.into(), ..RawEntry::default() }])
    }
}

impl RawEntry {
    /// Its units: those of the campaign, where it names none of its own.
    pub fn units(&self, of_campaign: Units) -> Units {
        self.units.map_or(of_campaign, |own| own.or(of_campaign))
    }

    /// What it names for all its rows in the place of a column.
    pub fn named(&self, column: &str) -> Option<&str> {
        match column {
            SESSION => self.session.as_deref(),
            STATION => self.station.as_deref(),
            _ => None,
        }
    }

    fn is_only_a_file(&self) -> bool {
        *self == Self { file: self.file.clone(), ..Self::default() }
    }
}

/// An entry of the list, as a name or in full.
struct Element(RawEntry);

forms! {
    Element: "a file name, or an entry `{file: ..}`",
    text name => Element(RawEntry { file: name.into(), ..RawEntry::default() }),
    map entry: RawEntry => Element(entry)
}

forms! {
    Measurements: "a file name, an entry `{file: ..}`, or a list of them",
    text name => Measurements::file(name),
    list all: Vec<Element> => Measurements(all.into_iter().map(|element| element.0).collect()),
    map entry: RawEntry => Measurements(vec![entry])
}

impl Serialize for Measurements {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0.as_slice() {
            [one] if one.is_only_a_file() => serializer.serialize_str(&one.file),
            all if all.iter().all(RawEntry::is_only_a_file) => {
                serializer.collect_seq(all.iter().map(|entry| &entry.file))
            }
            all => serializer.collect_seq(all),
        }
    }
}

#[cfg(feature = "cli")]
impl JsonSchema for Measurements {
    fn schema_name() -> Cow<'static, str> {
        "Measurements".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let entry = generator.subschema_for::<RawEntry>();
        let one = json_schema!({"anyOf": [{"type": "string"}, entry]});
        json_schema!({
            "description": "Files of readings, relative to this file: a name, an entry, or a list of them.",
            "anyOf": [one, {"type": "array", "items": one}],
        })
    }
}

forms! {
    RawKinds: "the name of a kind of readings, or a list of them",
    text name => RawKinds(vec![name.into()]),
    list names: Vec<String> => RawKinds(names)
}

impl Serialize for RawKinds {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0.as_slice() {
            [one] => one.serialize(serializer),
            all => serializer.collect_seq(all),
        }
    }
}

#[cfg(feature = "cli")]
impl JsonSchema for RawKinds {
    fn schema_name() -> Cow<'static, str> {
        "Kinds".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let one = generator.subschema_for::<Observes>();
        json_schema!({
            "description": "What a reading is; a list where one row holds several.",
            "anyOf": [one, {"type": "array", "items": one}],
        })
    }
}

impl<'de> Deserialize<'de> for RawSharing {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl Visitor<'_> for Reader {
            type Value = RawSharing;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("`true`, `false`, `per-session` or `per-station`")
            }
            fn visit_bool<E: Error>(self, is_unknown: bool) -> Result<RawSharing, E> {
                Ok(RawSharing(is_unknown.then_some(Sharing::All)))
            }
            fn visit_str<E: Error>(self, word: &str) -> Result<RawSharing, E> {
                match word.replace(' ', "-").as_str() {
                    "per-session" => Ok(RawSharing(Some(Sharing::PerSession))),
                    "per-station" => Ok(RawSharing(Some(Sharing::PerStation))),
                    _ => Err(E::unknown_variant(word, &["true", "false", "per-session", "per-station"])),
                }
            }
        }
        deserializer.deserialize_any(Reader)
    }
}

impl Serialize for RawSharing {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            None => serializer.serialize_bool(false),
            Some(Sharing::All) => serializer.serialize_bool(true),
            Some(shared) => shared.serialize(serializer),
        }
    }
}

#[cfg(feature = "cli")]
impl JsonSchema for RawSharing {
    fn schema_name() -> Cow<'static, str> {
        "Sharing".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "Whether it is unknown; where it differs between sessions or stations of the instrument, so.",
            "anyOf": [{"type": "boolean"}, {"type": "string", "enum": ["per-session", "per-station"]}],
        })
    }
}
