//! A row of units below the header: which it names, and what that makes of the columns.

use super::columns::ColumnKind;
use super::header::{Column, Header};
use super::line::unquoted;
use super::row::Row;
use crate::description::units::Unit;
use crate::diagnostic::{Code, Diagnostic, Place};
use csv::ByteRecord;

/// What the units of a file say of one of its columns.
pub(super) struct OfColumn {
    /// Numbers of the file in one of the unit that is expected.
    pub factor: f64,
    /// The unit and its place, where the campaign declares another.
    pub other: Option<(Unit, Place)>,
}

/// A cell without the brackets around a unit.
fn bare(cell: &[u8]) -> Option<&str> {
    let cell = unquoted(std::str::from_utf8(cell).ok()?);
    let pairs = [('[', ']'), ('(', ')')];
    let inside = pairs.into_iter().find_map(|(open, close)| cell.strip_prefix(open)?.strip_suffix(close));
    Some(inside.unwrap_or(cell).trim())
}

/// Whether a row is one of units: it has some in columns of numbers, and no number in any of them.
pub(super) fn is_row_of_units(record: &ByteRecord, columns: &[Column]) -> bool {
    let numeric = || columns.iter().filter(|column| !matches!(column.kind, ColumnKind::Text | ColumnKind::TextOrNone));
    let cell = |column: &Column| bare(record.get(column.field).unwrap_or_default());
    let is_number = |cell: &str| cell.replace(',', ".").parse::<f64>().is_ok();
    numeric().any(|column| cell(column).is_some_and(|cell| Unit::named(cell).is_some()))
        && numeric().all(|column| cell(column).is_some_and(|cell| !is_number(cell)))
}

/// What a row of units says of each column that is read.
pub(super) fn of_columns(record: &ByteRecord, header: &Header, row: &Row) -> Result<Vec<OfColumn>, Vec<Diagnostic>> {
    let (mut all, mut faults) = (Vec::new(), Vec::new());
    for column in &header.columns {
        let cell = bare(record.get(column.field).unwrap_or_default()).unwrap_or_default();
        match of_column(column, cell, row) {
            Ok(found) => all.push(found),
            Err(fault) => faults.push(fault),
        }
    }
    if faults.is_empty() { Ok(all) } else { Err(faults) }
}

fn of_column(column: &Column, cell: &str, row: &Row) -> Result<OfColumn, Diagnostic> {
    let as_expected = OfColumn { factor: 1.0, other: None };
    let place = row.field(column.field);
    let expected = match column.kind {
        ColumnKind::Quantity(expected) => expected,
        // Of a temperature, a side of approach: read as they are.
        ColumnKind::Number | ColumnKind::NumberOrZero if Unit::named(cell).is_some() => {
            let message = format!("the column `{}` is read as it is, and cannot be in `{cell}`", column.title);
            return Err(Diagnostic::error(message).at(place).remedy("leave this cell of the row of units empty"));
        }
        ColumnKind::Number | ColumnKind::NumberOrZero | ColumnKind::Text | ColumnKind::TextOrNone => {
            return Ok(as_expected);
        }
    };
    if matches!(cell, "" | "-") {
        return Ok(as_expected);
    }
    let quantity = expected.quantity();
    match Unit::named(cell) {
        None => {
            let message = format!("`{cell}` is no unit of {quantity}s that is known, in the column `{}`", column.title);
            let remedy = format!("write one such as `{}`, or leave the cell empty", expected.symbol());
            Err(Diagnostic::error(message).code(Code::Unknown).at(place).remedy(remedy))
        }
        Some(unit) if unit.quantity() != quantity => {
            let message = format!("the column `{}` holds {quantity}s, and its unit is `{cell}`", column.title);
            Err(Diagnostic::error(message).at(place).remedy("correct the unit, or the name of the column"))
        }
        Some(unit) if unit == expected => Ok(as_expected),
        Some(unit) => {
            let factor = unit.factor() / expected.factor();
            Ok(OfColumn { factor, other: (!expected.is_default()).then_some((unit, place)) })
        }
    }
}

/// One warning for all columns whose unit is not the one that is declared for the file.
pub(super) fn doubt(columns: &[Column], units: &[OfColumn]) -> Option<Diagnostic> {
    let differing: Vec<(&Column, &(Unit, Place))> =
        columns.iter().zip(units).filter_map(|(column, units)| Some((column, units.other.as_ref()?))).collect();
    let (_, (_, place)) = differing.first()?;
    let mut given: Vec<(String, Vec<&str>)> = Vec::new();
    for (column, (unit, _)) in &differing {
        let ColumnKind::Quantity(declared) = column.kind else { continue };
        let units = format!("{} where {} is declared", unit.symbol(), declared.symbol());
        match given.iter_mut().find(|(known, _)| *known == units) {
            Some((_, names)) => names.push(&column.title),
            None => given.push((units, vec![&column.title])),
        }
    }
    let given: Vec<String> =
        given.iter().map(|(units, names)| format!("{units}, of `{}`", names.join("`, `"))).collect();
    let message = format!("the row of units says {}; the row counts", given.join(", and "));
    let diagnostic = Diagnostic::warning(message).at(place.clone());
    Some(diagnostic.remedy("make `units:` and the row agree, or remove the row"))
}
