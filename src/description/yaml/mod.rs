//! YAML texts: read with every fault located, and written back.
//!
//! The only module that uses the YAML crate. A text is walked twice: once for the place of each key and value
//! ([`Document`]), once for the typed value ([`read`]). The crate's own `Spanned` gives the places of values that parse,
//! but neither those of keys nor those of values that do not, which are the ones to report.

mod document;
mod index;
mod read;
mod syntax;
mod wording;

pub use document::{Document, text_of};
pub use read::read;

use serde::Serialize;

/// Writes a value as YAML, so that [`read`] gives it back: floats in their shortest exact form, texts quoted where needed.
///
/// # Errors
///
/// What the value's own `Serialize` refuses.
pub fn write<T: Serialize>(value: &T) -> Result<String, WriteError> {
    Ok(serde_yaml::to_string(value)?)
}

/// A value that cannot be written as YAML.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct WriteError(#[from] serde_yaml::ser::Error);
