//! Tables with several markers in a row: `m1_x, m1_y, m1_z, m2_x, ..`.

use super::columns::{ExpectedColumn, Table, TextColumn};

/// The column that names what was measured.
const MARKER: &str = "marker";

/// Our name of a column of a marker.
fn of_marker(marker: &str, column: &str) -> String {
    format!("{marker}_{column}")
}

/// What is expected of a table that has `columns` for each marker.
pub fn widened(expected: Vec<ExpectedColumn>, markers: &[String], columns: &[String]) -> Vec<ExpectedColumn> {
    let wide = |column: ExpectedColumn| match columns.contains(&column.name) {
        true => markers
            .iter()
            .map(|marker| ExpectedColumn { name: of_marker(marker, &column.name), ..column.clone() })
            .collect(),
        false => vec![column],
    };
    expected.into_iter().filter(|column| column.name != MARKER).flat_map(wide).collect()
}

impl Table {
    /// Each row as one row for each marker, which `columns` of it are about; all else is the same in these.
    #[must_use]
    pub fn by_marker(mut self, markers: &[String], columns: &[String]) -> Self {
        let rows = self.row_count();
        let taken = columns.iter().map(|column| {
            let names = markers.iter().map(|marker| of_marker(marker, column));
            let fields: Vec<usize> = names.clone().filter_map(|name| self.fields.remove(&name)).collect();
            let values: Vec<Vec<f64>> = names.filter_map(|name| self.numbers.remove(&name)).collect();
            let values = (0..rows).flat_map(|row| values.iter().filter_map(move |own| own.get(row).copied())).collect();
            (column.clone(), fields, values)
        });
        let taken: Vec<(String, Vec<usize>, Vec<f64>)> = taken.collect();
        self.numbers.values_mut().for_each(|all| *all = repeated(all, markers.len()));
        self.texts.values_mut().for_each(|all| all.rows = repeated(&all.rows, markers.len()));
        self.lines = repeated(&self.lines, markers.len());
        if let Some(joined) = &mut self.joined {
            joined.rows = repeated(&joined.rows, markers.len());
        }
        let which = (0..rows).flat_map(|_| (0..).zip(markers).map(|(index, _)| index)).collect();
        let first = taken.iter().filter_map(|(_, fields, _)| fields.first().copied()).min();
        self.fields.insert(MARKER.into(), first.unwrap_or_default());
        self.texts.insert(MARKER.into(), TextColumn { texts: markers.to_vec(), rows: which });
        for (column, fields, values) in taken {
            self.fields.insert(column.clone(), fields.first().copied().unwrap_or_default());
            self.numbers.insert(column, values);
        }
        self
    }
}

fn repeated<T: Copy>(all: &[T], times: usize) -> Vec<T> {
    all.iter().flat_map(|value| std::iter::repeat_n(*value, times)).collect()
}
