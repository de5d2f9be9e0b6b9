//! One cell: what it must hold, and what is wrong with it.

use super::columns::{ColumnKind, TextColumn};
use super::dialect::Dialect;
use super::header::Column;
use super::line::unquoted;
use super::row::{Delimiter, Writing};
use crate::diagnostic::Diagnostic;
use std::collections::HashMap;

/// The cells of one column so far.
pub(super) enum Data {
    Numbers { column: Vec<f64>, empty: Option<f64> },
    Texts { column: TextColumn, known: HashMap<String, u32>, or_none: bool },
}

/// What is wrong with a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Wrong {
    Empty,
    NotText,
    NotNumber,
    NotFinite,
    DecimalComma,
    DecimalPoint,
}

impl Wrong {
    /// In words, with the remedy.
    ///
    /// `decimal` is the sign in force, declared or that of the cells above.
    pub fn diagnostic(
        self,
        cell: &[u8],
        column: &Column,
        dialect: &Dialect,
        writing: Writing,
        decimal: char,
    ) -> Diagnostic {
        let text = String::from_utf8_lossy(cell);
        let text: String = text.trim().chars().take(40).collect();
        let must = format!("column `{}` must hold a finite number", column.title);
        match self {
            Self::Empty => {
                let diagnostic = Diagnostic::error(format!("empty cell in column `{}`", column.title));
                diagnostic.remedy("fill it in, or remove the row")
            }
            Self::NotText => Diagnostic::error("the cell is not UTF-8").remedy("save the file as UTF-8"),
            Self::NotFinite => {
                Diagnostic::error(format!("{must}, found `{text}`")).remedy("correct the value, or remove the row")
            }
            Self::DecimalComma => Diagnostic::error(format!("{must}, found `{text}` with a decimal comma")).remedy(
                match dialect.decimal {
                    _ if writing.sheet.is_some() => "make the cell a number: here it is a text",
                    Some(_) => "declare it: `csv: {decimal: \",\"}`",
                    None if writing.delimiter == Delimiter::Byte(b',') => {
                        "write decimal points, or separate the columns by `;`"
                    }
                    None => "write one decimal sign throughout; cells above have a point",
                },
            ),
            Self::DecimalPoint => {
                Diagnostic::error(format!("{must}, found `{text}` with a point, while the decimal sign is `{decimal}`"))
                    .remedy(match dialect.decimal {
                        Some(_) => "write one decimal sign throughout, or correct `csv: {decimal: ..}`",
                        None => "write one decimal sign throughout",
                    })
            }
            Self::NotNumber => {
                let remedy = if text.contains('\u{2212}') {
                    "write the minus sign as `-`".to_owned()
                } else {
                    format!("write a number such as 1{decimal}5 or 2e-3, its unit left to `units:`")
                };
                Diagnostic::error(format!("{must}, found `{text}`")).remedy(remedy)
            }
        }
    }
}

impl Data {
    pub fn of(column: &Column) -> Self {
        match column.kind {
            ColumnKind::Number | ColumnKind::NumberOrZero | ColumnKind::Quantity(_) => {
                let zero = (column.kind == ColumnKind::NumberOrZero).then_some(0.0);
                Self::Numbers { column: Vec::new(), empty: zero.or(column.or_none.then_some(f64::NAN)) }
            }
            ColumnKind::Text | ColumnKind::TextOrNone => Self::Texts {
                column: TextColumn::default(),
                known: HashMap::new(),
                or_none: column.kind == ColumnKind::TextOrNone,
            },
        }
    }

    /// Checks a cell and, if asked to, keeps it. The first number with a decimal sign settles one that is open.
    pub fn push(&mut self, cell: &[u8], decimal: &mut Option<char>, keep: bool) -> Result<(), Wrong> {
        let text = unquoted(std::str::from_utf8(cell).map_err(|_| Wrong::NotText)?);
        match self {
            Self::Texts { or_none: false, .. } if text.is_empty() => return Err(Wrong::Empty),
            Self::Numbers { column, empty } => {
                let number = match text.is_empty() {
                    true => empty.ok_or(Wrong::Empty)?,
                    false => number(text, decimal)?,
                };
                if keep {
                    column.push(number);
                }
            }
            Self::Texts { column, known, .. } if keep => {
                let index = match known.get(text) {
                    Some(&index) => index,
                    None => {
                        let index = u32::try_from(column.texts.len()).unwrap_or(u32::MAX);
                        column.texts.push(text.to_owned());
                        known.insert(text.to_owned(), index);
                        index
                    }
                };
                column.rows.push(index);
            }
            Self::Texts { .. } => {}
        }
        Ok(())
    }

    /// Drops what has been kept.
    pub fn forget(&mut self) {
        match self {
            Self::Numbers { column, .. } => *column = Vec::new(),
            Self::Texts { column, known, .. } => (*column, *known) = (TextColumn::default(), HashMap::new()),
        }
    }
}

/// A finite number, written with the given decimal sign; one that is open is settled by the first number that has one.
fn number(text: &str, decimal: &mut Option<char>) -> Result<f64, Wrong> {
    let with_comma =
        || -> Option<f64> { (text.matches(',').count() == 1).then(|| text.replace(',', ".").parse().ok()).flatten() };
    let parsed = match decimal {
        Some(',') if text.contains('.') => Err(Wrong::DecimalPoint),
        Some(',') => text.replace(',', ".").parse::<f64>().map_err(|_| Wrong::NotNumber),
        Some(_) => {
            text.parse::<f64>().map_err(|_| if with_comma().is_some() { Wrong::DecimalComma } else { Wrong::NotNumber })
        }
        None => match text.parse::<f64>() {
            Ok(number) => {
                *decimal = text.contains('.').then_some('.');
                Ok(number)
            }
            Err(_) => with_comma().inspect(|_| *decimal = Some(',')).ok_or(Wrong::NotNumber),
        },
    }?;
    if parsed.is_finite() { Ok(parsed) } else { Err(Wrong::NotFinite) }
}
