//! Tables of text, and numbers with their units.

use comfy_table::{Cell, CellAlignment, ColumnConstraint, ContentArrangement, LineStyle, Table, Width, presets};

/// Columns between two columns of a table.
const GAP: usize = 3;

/// What text is laid out for: a screen of so many columns, or a file, where tables are as wide as they need.
#[derive(Debug, Clone, Copy, Default)]
pub struct Screen(Option<usize>);

impl Screen {
    /// A screen of so many columns; `None` where nothing limits the width.
    pub fn new(columns: Option<usize>) -> Self {
        Self(columns)
    }

    /// Its columns.
    pub fn columns(self) -> Option<usize> {
        self.0
    }

    /// A table with a header; the first column is aligned to the left, numbers to the right.
    ///
    /// On a screen too narrow for it, words go to further lines of their cell; where that is not enough, columns to further
    /// blocks, each with the first column before it.
    pub fn table(self, header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
        let rows: Vec<Vec<String>> = rows.into_iter().collect();
        let Some(screen) = self.0 else { return block(header, &rows, None) };
        let least: Vec<usize> = (0..header.len()).map(|column| longest_word(header, &rows, column)).collect();
        let mut blocks: Vec<Vec<usize>> = vec![vec![]];
        let mut wide = 0;
        for (column, least) in least.iter().enumerate() {
            if wide + least + GAP > screen && blocks.last().is_some_and(|block| block.len() > 1) {
                blocks.push(vec![0]);
                wide = longest_word(header, &rows, 0) + GAP;
            }
            wide += least + GAP;
            if let Some(block) = blocks.last_mut() {
                block.push(column);
            }
        }
        let part = |columns: &Vec<usize>| {
            let header: Vec<&str> = columns.iter().filter_map(|&column| header.get(column).copied()).collect();
            let pick = |row: &Vec<String>| columns.iter().filter_map(|&column| row.get(column).cloned()).collect();
            block(&header, &rows.iter().map(pick).collect::<Vec<_>>(), Some(screen))
        };
        blocks.iter().map(part).collect::<Vec<_>>().join("\n")
    }
}

/// The least width of a column: its longest word.
fn longest_word(header: &[&str], rows: &[Vec<String>], column: usize) -> usize {
    let cells = rows.iter().filter_map(|row| row.get(column).map(String::as_str));
    let words = cells.chain(header.get(column).copied()).flat_map(str::split_whitespace);
    words.map(|word| word.chars().count()).max().unwrap_or(0)
}

fn block(header: &[&str], rows: &[Vec<String>], screen: Option<usize>) -> String {
    let mut table = Table::new();
    let rule = LineStyle::none().fill('─').junction('─');
    table.load_style(presets::NOTHING.header_separator(rule)).set_content_arrangement(ContentArrangement::Disabled);
    // A column is one of numbers if all that stands in it is.
    let number = |text: &String| {
        let first = text.split_whitespace().next().unwrap_or("0");
        first.parse::<f64>().is_ok() && text.split_whitespace().count() <= 2
    };
    let is_number = |column: usize| column > 0 && rows.iter().filter_map(|row| row.get(column)).all(number);
    let columns = rows.iter().map(Vec::len).chain([header.len()]).max().unwrap_or(0);
    let right: Vec<bool> = (0..columns).map(is_number).collect();
    let cell = |column: usize, text: &str| {
        let is_right = right.get(column).copied().unwrap_or_default();
        Cell::new(text).set_alignment(if is_right { CellAlignment::Right } else { CellAlignment::Left })
    };
    table.set_header(header.iter().enumerate().map(|(column, text)| cell(column, text)));
    for row in rows {
        table.add_row(row.iter().enumerate().map(|(column, text)| cell(column, text)));
    }
    if let Some(screen) = screen.and_then(|screen| u16::try_from(screen).ok()) {
        table.set_content_arrangement(ContentArrangement::Dynamic).set_width(screen);
        let least = |column| u16::try_from(longest_word(header, rows, column) + GAP - 1).unwrap_or(u16::MAX);
        table.set_constraints((0..header.len()).map(|k| ColumnConstraint::LowerBoundary(Width::Fixed(least(k)))));
    }
    table.trim_fmt() + "\n"
}

/// A number in a unit of results: fixed decimals for lengths and angles, powers of ten for the rest.
pub fn number(unit: &str, value: f64) -> String {
    if matches!(unit, "mm" | "deg") { format!("{value:.5}") } else { format!("{value:.4e}") }
}
