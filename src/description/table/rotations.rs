//! Orientations of a table as rotation vectors: the columns rx, ry, rz, which every kind of readings with an orientation has.

use super::columns::{ColumnKind, ExpectedColumn, Table};
use super::orientation::{Orientation, VECTOR};
use crate::description::units::Angle;
use crate::diagnostic::Diagnostic;
use crate::math::rotation_vector;

/// Most faults shown of one file.
const MOST_SHOWN: usize = 20;

impl Orientation {
    /// The columns that a file should have where these are expected: its own in place of rx, ry, rz.
    #[must_use]
    pub fn expected(self, mut columns: Vec<ExpectedColumn>) -> Vec<ExpectedColumn> {
        let Some(first) = columns.iter().position(|column| column.name == VECTOR[0]) else { return columns };
        let of_angles = columns[first].clone();
        columns.retain(|column| !VECTOR.contains(&column.name.as_str()));
        let kind = match self {
            Self::Quaternion(_) | Self::Matrix => ColumnKind::Number,
            _ => of_angles.kind,
        };
        let own = self.columns().iter();
        columns.extend(own.map(|name| ExpectedColumn::new(*name, kind, of_angles.required)));
        columns
    }
}

impl Table {
    /// Adds the columns rx, ry, rz from those of an orientation, all angles in the given unit. Without its columns nothing is
    /// added.
    ///
    /// # Errors
    /// Rows that hold no rotation, each located.
    pub fn add_rotation_vectors(&mut self, orientation: Orientation, angle: Angle) -> Result<(), Vec<Diagnostic>> {
        let names = orientation.columns();
        let is_there = names.iter().all(|name| self.numbers.contains_key(*name));
        if orientation == Orientation::RotationVector || !is_there {
            return Ok(());
        }
        let factor = match orientation {
            Orientation::Quaternion(_) | Orientation::Matrix => 1.0,
            _ => angle.factor(),
        };
        let (mut vectors, mut faults) = ([const { Vec::new() }; 3], Vec::new());
        for row in 0..self.row_count() {
            let value = |name: &&str| self.numbers(name).and_then(|all| all.get(row)).copied().unwrap_or(f64::NAN);
            let values: Vec<f64> = names.iter().map(|name| value(name) * factor).collect();
            match orientation.rotation(&values) {
                Ok(rotation) => {
                    let vector = rotation_vector(&rotation) / angle.factor();
                    vectors.iter_mut().zip(vector.iter()).for_each(|(all, value)| all.push(*value));
                }
                Err(fault) if faults.len() < MOST_SHOWN => {
                    let diagnostic = Diagnostic::error(fault).at(names.first().and_then(|name| self.place(row, name)));
                    faults
                        .push(diagnostic.remedy("correct the row; check which columns hold the orientation, and how"));
                }
                Err(_) => {}
            }
        }
        if !faults.is_empty() {
            return Err(faults);
        }
        let field = names.first().and_then(|name| self.fields.get(*name)).copied().unwrap_or(0);
        for (name, vector) in VECTOR.into_iter().zip(vectors) {
            self.fields.insert(name.into(), field);
            self.numbers.insert(name.into(), vector);
        }
        Ok(())
    }
}
