//! How a file is written, as far as that is declared.

use std::collections::BTreeMap;

use super::orientation::Orientation;

/// How a file separates its columns and writes its numbers.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Dialect {
    /// A blank: any number of blanks and tabs. `None`: that of a first line `sep=;`, else whichever of `,`, `;` and the tab
    /// the header line holds most of, else blanks.
    pub delimiter: Option<char>,
    /// `.` or `,`; `None`: a point between commas, else that of the first number that has one.
    pub decimal: Option<char>,
    /// How orientations are written: of a quaternion, in which order its components may be numbered.
    pub orientation: Orientation,
    /// That it is a list of points, and what its fields are.
    pub points: Option<Points>,
    /// Whether names and `ignore:` hold for several files, of which this may lack what another has.
    pub is_shared: bool,
    /// Whether a campaign file says how the table is read, so that remedies may name its keys.
    pub of_campaign: bool,
}

/// A list of points as metrology programs export it, mostly without a header.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Points {
    /// Our text columns and the fields that hold them, of `collection`, `group` and `name`.
    pub columns: BTreeMap<String, String>,
    /// All fields of a line in order; empty: `x, y, z` last, before them what the number of fields leaves of `collection`,
    /// `group`, `name`.
    pub fields: Vec<String>,
}

impl Default for Points {
    /// The name of a point is that of a pose.
    fn default() -> Self {
        Self { columns: BTreeMap::from([("pose".into(), "name".into())]), fields: Vec::new() }
    }
}
