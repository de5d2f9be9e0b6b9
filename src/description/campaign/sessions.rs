//! Sessions: runs of readings between which base, tool or instrument were set up anew.
//!
//! A parameter that belongs to one of them is named with it: `base@monday.x`.

#[cfg(feature = "cli")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The column that names sessions.
pub const SESSION: &str = "session";
/// The column that names stations.
pub const STATION: &str = "station";

/// Between which readings a part of the measuring arrangement is shared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
#[cfg_attr(feature = "cli", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Sharing {
    /// Between all.
    #[default]
    All,
    /// Between those of a session.
    PerSession,
    /// Between those of a station of the instrument.
    PerStation,
}

/// Names of sessions and stations, and of those between which base, tool and scale differ. Each list has at least one name;
/// the name of what all readings share is empty.
#[derive(Debug, Clone, PartialEq)]
pub struct Sessions {
    /// Sessions, in the order in which they first come.
    pub names: Vec<String>,
    /// Stations of the instrument.
    pub stations: Vec<String>,
    /// What the base is shared between.
    pub base: Sharing,
    /// What tool and markers are shared between.
    pub tool: Sharing,
    /// What the instrument's scale is shared between.
    pub scale: Sharing,
    /// Files of measurements: name, and the first [`super::Reading::row`] of each. Empty where readings come from no file.
    pub files: Vec<(String, usize)>,
}

impl Default for Sessions {
    fn default() -> Self {
        let one = || vec![String::new()];
        let all = Sharing::All;
        Self { names: one(), stations: one(), base: all, tool: all, scale: all, files: Vec::new() }
    }
}

/// Session and station of a reading, by index in [`Sessions::names`] and [`Sessions::stations`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct InSession {
    /// Session.
    pub session: usize,
    /// Station.
    pub station: usize,
}

impl InSession {
    /// Which of the parts that are shared so is this reading's.
    pub fn part(&self, shared: Sharing) -> usize {
        match shared {
            Sharing::All => 0,
            Sharing::PerSession => self.session,
            Sharing::PerStation => self.station,
        }
    }
}

impl Sessions {
    /// Names of the parts that are shared so; one without a name where all readings share it.
    pub fn parts(&self, shared: Sharing) -> Vec<&str> {
        match shared {
            Sharing::All => vec![""],
            Sharing::PerSession => self.names.iter().map(String::as_str).collect(),
            Sharing::PerStation => self.stations.iter().map(String::as_str).collect(),
        }
    }

    /// Whether readings differ in session.
    pub fn is_several(&self) -> bool {
        self.names.len() > 1 || self.stations.len() > 1
    }
}
