//! What readings refer to in addition to the robot: anchors of distances, contacts. Each has values that a kind of reading reads in
//! its own order; known ones are constants, unknown ones parameters.

use std::collections::HashSet;
use std::f64::consts::PI;

use nalgebra::Vector3;

use super::Reading;
use crate::observation::{ANCHOR_COLUMN, CONTACT_COLUMN, MOST_TARGET_VALUES, Observes, TargetValues};
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
    /// Whether the campaign says where it is about, and no other start is to be sought.
    pub has_start: bool,
    /// Whether the campaign says where it is about.
    pub is_near: bool,
}

/// What a constraint says of two targets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Between {
    /// The distance of their points, m.
    Points,
    /// The angle of their normals, rad, or what it lacks to a half turn: a face has two sides.
    Normals,
    /// The distance of two faces that share a normal, m: of the planes in which the ball's centre is.
    Faces,
}

/// A distance between the points of two targets, or an angle between their normals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constraint {
    /// The targets, by index.
    pub targets: [usize; 2],
    /// Which of the two it is.
    pub between: Between,
    /// The distance or angle, where [`Constraint::length`] does not stand in for it.
    pub value: f64,
    /// The target whose first value is the distance, by index, where it is unknown: constraints may share one.
    pub length: Option<usize>,
    /// One sigma of it.
    pub sigma: f64,
}

impl Constraint {
    /// Those of `declared` that hold: every value that they constrain is known, or determined by readings of the targets. One to a
    /// contact that is not touched says only where that contact is.
    pub fn held(declared: &[Self], targets: &[Target], readings: &[Reading]) -> Vec<Self> {
        let is_read = |target: usize| {
            let column = targets[target].column;
            readings
                .iter()
                .any(|r| r.target == Some(target) && r.observes.target_column().is_none_or(|of| of == column))
        };
        let read = (0..targets.len()).filter(|&target| is_read(target)).flat_map(|target| &targets[target].values);
        let determined: HashSet<&String> = read.filter_map(|value| value.parameter.as_ref()).collect();
        let is_determined = |value: &TargetValue| value.parameter.as_ref().is_none_or(|name| determined.contains(name));
        let is_held = |constraint: &&Self| {
            let count = if constraint.between == Between::Faces { 4 } else { 3 };
            constraint.targets.iter().all(|&target| targets[target].values.iter().take(count).all(is_determined))
        };
        declared.iter().filter(is_held).copied().collect()
    }

    /// What is constrained, of the values of both targets, and its derivatives by the first four of them.
    pub fn of(&self, values: [&TargetValues; 2], expected: f64) -> (f64, [[f64; 4]; 2]) {
        let [a, b] = values.map(|values| Vector3::from_column_slice(&values[..3]));
        let by = |by: Vector3<f64>, fourth: f64| [by.x, by.y, by.z, fourth];
        if self.between == Between::Points {
            let arm = a - b;
            let direction = arm / arm.norm().max(f64::MIN_POSITIVE);
            return (arm.norm(), [by(direction, 0.0), by(-direction, 0.0)]);
        }
        if self.between == Between::Faces {
            // Known normals may be opposite.
            let alike = if a.dot(&b) < 0.0 { -1.0 } else { 1.0 };
            let apart = values[0][3] - alike * values[1][3];
            let side = if apart < 0.0 { -1.0 } else { 1.0 };
            return (apart.abs(), [by(Vector3::zeros(), side), by(Vector3::zeros(), -side * alike)]);
        }
        let lengths = [a, b].map(|normal| normal.norm().max(f64::MIN_POSITIVE));
        let [a, b] = [a / lengths[0], b / lengths[1]];
        let (sine, cosine) = (a.cross(&b).norm(), a.dot(&b));
        let angle = sine.atan2(cosine);
        let side = if (angle - expected).abs() <= (PI - angle - expected).abs() { 1.0 } else { -1.0 };
        // Parallel normals have no direction in which their angle grows.
        let steep = if sine > 0.0 { -side / sine } else { 0.0 };
        let derivatives = [(b - a * cosine) * (steep / lengths[0]), (a - b * cosine) * (steep / lengths[1])];
        (if side > 0.0 { angle } else { PI - angle }, derivatives.map(|derivative| by(derivative, 0.0)))
    }
}

impl Target {
    /// A known point from which distances are measured, m, measurement frame.
    pub fn anchor(name: &str, at: &Vector3<f64>) -> Self {
        let values = at.iter().map(|&value| known(value, Kind::Length)).collect();
        Self {
            name: name.into(),
            column: ANCHOR_COLUMN,
            member: (name.into(), None),
            observes: None,
            values,
            has_start: true,
            is_near: true,
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
            is_near: false,
        }
    }

    /// Its values as far as they are known or assumed; zero beyond them.
    pub fn assumed(&self) -> TargetValues {
        let mut values = [0.0; MOST_TARGET_VALUES];
        values.iter_mut().zip(&self.values).for_each(|(to, from)| *to = from.value);
        values
    }

    /// Whether distances are measured from it.
    pub fn is_anchor(&self) -> bool {
        self.column == ANCHOR_COLUMN
    }

    /// Whether it is touched.
    pub fn is_contact(&self) -> bool {
        self.column == CONTACT_COLUMN
    }

    /// Makes a face parallel to another: it has that one's normal, whichever of the two is known. Faces that had its own have it too.
    pub fn make_parallel(targets: &mut [Self], [one, other]: [usize; 2]) {
        let normal = |target: usize| targets[target].values[..3].to_vec();
        let is_known = |normal: &[TargetValue]| normal.iter().all(|value| value.parameter.is_none());
        let (mut kept, mut replaced) = (normal(one), normal(other));
        if is_known(&replaced) {
            std::mem::swap(&mut kept, &mut replaced);
        }
        if is_known(&replaced) {
            return;
        }
        let faces = targets.iter_mut().filter(|target| target.is_face());
        let own = faces.filter(|target| target.values[0].parameter == replaced[0].parameter);
        own.for_each(|target| target.values[..3].clone_from_slice(&kept));
    }

    /// Whether it is a face that is touched.
    pub fn is_face(&self) -> bool {
        self.observes.is_some_and(|kind| kind.is_on_face())
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
