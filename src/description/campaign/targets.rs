//! What readings refer to besides the robot: anchors of distances, contacts. Each has values that a kind of reading reads in
//! its own order; known ones are constants, unknown ones parameters.

use nalgebra::Vector3;

use crate::observation::{MOST_TARGET_VALUES, Observes, TargetValues};
use crate::parameter::Kind;

/// What names unknown distances, as [`Target::column`]: no column of a table.
const DISTANCES: &str = "distances";

/// A value of a target.
#[derive(Debug, Clone, PartialEq)]
pub struct TargetValue {
    /// What is known or assumed at first, SI, measurement frame.
    pub value: f64,
    /// What it measures.
    pub kind: Kind,
    /// Name of the parameter where it is estimated; targets may share one.
    pub parameter: Option<String>,
}

/// Something that readings refer to.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// Its name; with the group of which it is a member, `socket0@placement1`.
    pub name: String,
    /// The column that names it.
    pub column: &'static str,
    /// Its name in that column, and the group's column and member where there is a group.
    pub member: (String, Option<[String; 2]>),
    /// The kind of the readings that refer to it, where it decides that.
    pub observes: Option<Observes>,
    /// Its values, in the order of that kind.
    pub values: Vec<TargetValue>,
    /// Whether the campaign says where it is about.
    pub has_start: bool,
}

/// A distance between the points of two targets, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constraint {
    /// The targets, by index.
    pub targets: [usize; 2],
    /// Their distance, if known; that of [`Constraint::length`] is added to it.
    pub distance: f64,
    /// The target whose first value is the distance, by index, where it is unknown: constraints may share one.
    pub length: Option<usize>,
    /// One sigma of it.
    pub sigma: f64,
}

impl Target {
    /// A known point from which distances are measured, m, measurement frame.
    pub fn anchor(name: &str, at: &Vector3<f64>) -> Self {
        let values = at.iter().map(|&value| known(value, Kind::Length)).collect();
        Self {
            name: name.into(),
            column: "anchor",
            member: (name.into(), None),
            observes: None,
            values,
            has_start: true,
        }
    }

    /// An unknown distance between contacts.
    pub fn distance(key: &str) -> Self {
        let parameter = Some(format!("{key}.distance"));
        Self {
            name: key.into(),
            column: DISTANCES,
            member: (key.into(), None),
            observes: None,
            values: vec![TargetValue { value: 0.0, kind: Kind::Length, parameter }],
            // It follows from the contacts'.
            has_start: true,
        }
    }

    /// Its values as far as they are known or assumed; zero beyond them.
    pub fn assumed(&self) -> TargetValues {
        let mut values = [0.0; MOST_TARGET_VALUES];
        values.iter_mut().zip(&self.values).for_each(|(to, from)| *to = from.value);
        values
    }

    /// Whether a start for it is to be sought: nothing says where it is about.
    pub fn is_to_be_sought(&self) -> bool {
        self.is_estimated() && !self.has_start
    }

    /// Whether anything of it is estimated.
    pub fn is_estimated(&self) -> bool {
        self.values.iter().any(|value| value.parameter.is_some())
    }

    /// Whether a row that names `name` means it; `group` gives the text of a column.
    pub fn is_meant<'t>(&self, name: &str, group: impl Fn(&str) -> Option<&'t str>) -> bool {
        let (own, of) = &self.member;
        own == name && of.as_ref().is_none_or(|[column, member]| group(column) == Some(member))
    }
}

fn known(value: f64, kind: Kind) -> TargetValue {
    TargetValue { value, kind, parameter: None }
}
