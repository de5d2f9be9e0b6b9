//! Tables with several markers in a row: `m1_x, m1_y, m1_z, m2_x, ..`.

use super::columns::{ExpectedColumn, Table, TextColumn};
use super::rows::Faults;
use crate::diagnostic::{Diagnostic, Place};

/// The column that names what was measured.
const MARKER: &str = "marker";

/// Our name of a column of a marker.
fn of_marker(marker: &str, column: &str) -> String {
    format!("{marker}_{column}")
}

/// What is expected of a table that has `columns` for each marker: all of them are empty where it was not seen.
pub fn widened(expected: Vec<ExpectedColumn>, markers: &[String], columns: &[String]) -> Vec<ExpectedColumn> {
    let wide = |column: ExpectedColumn| match columns.contains(&column.name) {
        true => markers
            .iter()
            .map(|marker| ExpectedColumn { name: of_marker(marker, &column.name), or_none: true, ..column.clone() })
            .collect(),
        false => vec![column],
    };
    expected.into_iter().filter(|column| column.name != MARKER).flat_map(wide).collect()
}

impl Table {
    /// Each row as one row for each marker that was seen, which `columns` of it are about; all else is the same in these.
    ///
    /// # Errors
    /// Markers of which a row has some columns and lacks others; a table without any reading.
    pub fn by_marker(mut self, markers: &[String], columns: &[String]) -> Result<Self, Vec<Diagnostic>> {
        let seen = self.seen(markers, columns)?;
        for column in columns {
            let names: Vec<String> = markers.iter().map(|marker| of_marker(marker, column)).collect();
            let first = names.iter().filter_map(|name| self.fields.remove(name)).min();
            let values: Vec<Vec<f64>> = names.iter().filter_map(|name| self.numbers.remove(name)).collect();
            let own = seen.iter().filter_map(|&(row, marker)| values.get(marker)?.get(row).copied());
            let own: Vec<f64> = own.collect();
            self.fields.insert(column.clone(), first.unwrap_or_default());
            self.numbers.insert(column.clone(), own);
        }
        let is_own = |name: &String| columns.contains(name);
        self.numbers.iter_mut().filter(|(name, _)| !is_own(name)).for_each(|(_, all)| *all = taken(all, &seen));
        self.texts.values_mut().for_each(|all| all.rows = taken(&all.rows, &seen));
        self.lines = taken(&self.lines, &seen);
        if let Some(joined) = &mut self.joined {
            joined.rows = taken(&joined.rows, &seen);
        }
        let first = columns.iter().filter_map(|column| self.fields.get(column)).min().copied();
        self.fields.insert(MARKER.into(), first.unwrap_or_default());
        let rows = seen.iter().filter_map(|(_, marker)| u32::try_from(*marker).ok()).collect();
        self.texts.insert(MARKER.into(), TextColumn { texts: markers.to_vec(), rows });
        Ok(self)
    }

    /// Rows and markers that were read in them, by index.
    fn seen(&self, markers: &[String], columns: &[String]) -> Result<Vec<(usize, usize)>, Vec<Diagnostic>> {
        let of_all = |marker: &String| -> Vec<(String, &[f64])> {
            let names = columns.iter().map(|column| of_marker(marker, column));
            names.filter_map(|name| self.numbers(&name).map(|values| (name.clone(), values))).collect()
        };
        let all: Vec<Vec<(String, &[f64])>> = markers.iter().map(of_all).collect();
        let (mut seen, mut faults) = (Vec::new(), Faults::default());
        for row in 0..self.row_count() {
            for (marker, own) in all.iter().enumerate() {
                let empty = || own.iter().filter(|(_, values)| values.get(row).is_none_or(|value| value.is_nan()));
                match empty().next() {
                    None => seen.push((row, marker)),
                    Some((first, _)) if empty().count() < own.len() => faults.add(|| {
                        let message = format!("empty cell in column `{first}`, where the row has others of its marker");
                        let fault = Diagnostic::error(message).at(self.place(row, first));
                        fault.remedy("fill it in; or empty all columns of a marker that was not seen")
                    }),
                    Some(_) => {}
                }
            }
        }
        if seen.is_empty() && faults.none() {
            let fault = Diagnostic::error("no row holds a reading of a marker").at(Place::line_of(self.file(), 1));
            faults.add(|| fault.remedy("fill in the columns of those that were seen"));
        }
        if faults.none() { Ok(seen) } else { Err(faults.finish()) }
    }
}

/// The values of the rows.
fn taken<T: Copy>(all: &[T], rows: &[(usize, usize)]) -> Vec<T> {
    rows.iter().filter_map(|&(row, _)| all.get(row).copied()).collect()
}
