//! A result as XML: an element a key, list entries as elements `item`, numbers as JSON writes them.

use std::fmt::Write;

use serde_json::Value;

use super::diagnostics::is_active;

/// The text of an XML file with the root element `name`.
pub fn xml(name: &str, value: &Value) -> String {
    let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    element(&mut out, name, value, 0);
    out
}

fn element(out: &mut String, name: &str, value: &Value, depth: usize) {
    let indent = "  ".repeat(depth);
    // Keys of results are names; those of maps may be anything, and stand in an attribute then.
    let is_name = name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
    let (open, close) = match is_name {
        true => (name.to_string(), name),
        false => (format!("entry name=\"{}\"", escaped(name)), "entry"),
    };
    let _ = match value {
        Value::Null => writeln!(out, "{indent}<{open}/>"),
        Value::Object(fields) => {
            let _ = writeln!(out, "{indent}<{open}>");
            fields.iter().for_each(|(key, value)| element(out, key, value, depth + 1));
            writeln!(out, "{indent}</{close}>")
        }
        Value::Array(items) => {
            let _ = writeln!(out, "{indent}<{open}>");
            items.iter().for_each(|item| element(out, "item", item, depth + 1));
            writeln!(out, "{indent}</{close}>")
        }
        Value::String(text) => writeln!(out, "{indent}<{open}>{}</{close}>", escaped(text)),
        number => writeln!(out, "{indent}<{open}>{number}</{close}>"),
    };
}

fn escaped(text: &str) -> String {
    let text: String = text.chars().map(|c| if is_active(c) { '\u{fffd}' } else { c }).collect();
    crate::description::urdf::escaped(&text)
}
