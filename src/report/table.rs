//! Tables of text, and numbers with their units.

use comfy_table::{Cell, CellAlignment, ContentArrangement, LineStyle, Table, presets};

use crate::parameter::Kind;

/// A table with a header; the first column is aligned to the left, numbers to the right.
pub fn table(header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let mut table = Table::new();
    let rule = LineStyle::none().fill('─').junction('─');
    table.load_style(presets::NOTHING.header_separator(rule)).set_content_arrangement(ContentArrangement::Disabled);
    let rows: Vec<Vec<String>> = rows.into_iter().collect();
    // A column is one of numbers if all that stands in it is.
    let number = |text: &String| {
        let first = text.split_whitespace().next().unwrap_or("0");
        first.parse::<f64>().is_ok() && text.split_whitespace().count() <= 2
    };
    let right = |column: usize| column > 0 && rows.iter().filter_map(|row| row.get(column)).all(number);
    let cell = |column: usize, text: &str| {
        Cell::new(text).set_alignment(if right(column) { CellAlignment::Right } else { CellAlignment::Left })
    };
    table.set_header(header.iter().enumerate().map(|(column, text)| cell(column, text)));
    for row in &rows {
        table.add_row(row.iter().enumerate().map(|(column, text)| cell(column, text)));
    }
    table.trim_fmt() + "\n"
}

/// Unit in which reports speak of a kind, and its size in SI.
pub fn unit(kind: Kind) -> (&'static str, f64) {
    match kind {
        Kind::Length => ("mm", 1e-3),
        Kind::Angle => ("deg", std::f64::consts::PI / 180.0),
        other => (other.unit(), 1.0),
    }
}

/// A number of a kind in the unit of [`unit`]: fixed decimals for lengths and angles, powers of ten for the rest.
pub fn number(kind: Kind, value: f64) -> String {
    match kind {
        Kind::Length | Kind::Angle => format!("{:.5}", value / unit(kind).1),
        _ => format!("{value:.4e}"),
    }
}

/// A length in mm.
pub fn mm(metres: f64) -> f64 {
    metres * 1e3
}

/// An angle in deg.
pub fn deg(radians: f64) -> f64 {
    radians.to_degrees()
}
