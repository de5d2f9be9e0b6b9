//! Lists of points as metrology programs export them: what their fields are.
//!
//! SpatialAnalyzer writes, by the user's choice, collection, group and name of a point, group and name, the name, or none,
//! then x, y, z, separated by blanks or commas, below comments that begin with `//` (SpatialAnalyzer User Manual, "Exporting
//! ASCII Formatted Points").

use csv::ByteRecord;

use super::dialect::Points;
use super::row::Row;
use crate::diagnostic::Diagnostic;

/// Fields that name a point, from the widest.
pub(super) const NAMES: [&str; 3] = ["collection", "group", "name"];
const POSITION: [&str; 3] = ["x", "y", "z"];

/// Other words for a field.
fn known(title: &str) -> String {
    let bare = title.to_lowercase().replace(['_', ' ', '.'], "");
    match bare.as_str() {
        "x" | "y" | "z" | "collection" | "group" | "name" => bare,
        "collectionname" => "collection".into(),
        "groupname" | "pointgroup" => "group".into(),
        "point" | "pointname" | "target" | "targetname" | "pointid" | "id" => "name".into(),
        _ => title.to_owned(),
    }
}

/// The names of the fields, and whether the first line is a header: by what is declared, by the header, or by their number.
pub(super) fn titles(points: &Points, cells: &[String], row: &Row) -> Result<(Vec<String>, bool), Diagnostic> {
    let is_number = |cell: &String| cell.replace(',', ".").parse::<f64>().is_ok();
    // A delimiter at the end of each line is no field.
    let cells = match cells.split_last() {
        Some((last, others)) if last.trim().is_empty() => others,
        _ => cells,
    };
    let found = if !points.fields.is_empty() {
        if points.fields.len() != cells.len() {
            let message = format!("`fields:` names {}, and the line has {} fields", points.fields.len(), cells.len());
            return Err(Diagnostic::error(message).at(row.fields_from(0)).remedy("name each field of a line"));
        }
        let titles: Vec<String> = points.fields.iter().map(|field| known(field)).collect();
        let mut positions = titles.iter().zip(cells).filter(|(title, _)| POSITION.contains(&title.as_str()));
        let is_header = !positions.any(|(_, cell)| is_number(cell));
        (titles, is_header)
    } else if !cells.iter().any(is_number) {
        (cells.iter().map(|cell| known(cell)).collect(), true)
    } else {
        let last = cells.len().checked_sub(POSITION.len()).filter(|names| *names <= NAMES.len());
        let (names, position) = cells.split_at(last.unwrap_or(0));
        // A name that is a number with decimals is a coordinate, with something else behind z.
        let is_decimal = |cell: &String| is_number(cell) && cell.contains(['.', ',']);
        if last.is_none() || !position.iter().all(is_number) || names.iter().any(is_decimal) {
            let diagnostic = Diagnostic::error(
                "this is no point as expected: x, y, z last, before them at most collection, group, name",
            );
            let remedy = "name the fields of a line: `points: {fields: [group, name, x, y, z, time]}`";
            return Err(diagnostic.at(row.fields_from(0)).remedy(remedy));
        }
        let names = NAMES.iter().skip(NAMES.len() - names.len());
        (names.chain(&POSITION).map(|name| (*name).to_owned()).collect(), false)
    };
    let missing = points.columns.iter().find(|(_, field)| !found.0.contains(*field));
    match missing {
        // Points without any name are joined by their order.
        Some((ours, field)) if ours != "pose" || found.0.iter().any(|title| NAMES.contains(&title.as_str())) => {
            let message = format!("`points:` takes `{ours}` from the field `{field}`, which the lines do not have");
            let known: Vec<&str> = found.0.iter().map(String::as_str).filter(|name| NAMES.contains(name)).collect();
            let diagnostic = Diagnostic::error(message).at(row.fields_from(0));
            Err(diagnostic.remedy(format!(
                "they have {}",
                if known.is_empty() { "x, y, z alone".into() } else { known.join(", ") }
            )))
        }
        _ => Ok(found),
    }
}

/// A field that names points and is not used, and two of its values that differ.
pub(super) struct Unused {
    title: &'static str,
    field: usize,
    first: Option<Vec<u8>>,
    other: Option<Vec<u8>>,
}

impl Unused {
    /// Those of a list with these fields, of which some are taken from and some ignored.
    pub fn of(titles: &[String], points: &Points, ignored: &[String]) -> Vec<Self> {
        let is_used = |title: &str| {
            points.columns.values().any(|used| used == title) || ignored.iter().any(|ignored| ignored == title)
        };
        let field = |title: &'static str| {
            let field = titles.iter().position(|found| found == title)?;
            Some(Self { title, field, first: None, other: None })
        };
        NAMES.into_iter().filter(|title| !is_used(title)).filter_map(field).collect()
    }

    /// Takes a row in.
    pub fn take(&mut self, record: &ByteRecord) {
        let value = record.get(self.field).unwrap_or_default().trim_ascii();
        match &self.first {
            None => self.first = Some(value.to_owned()),
            Some(first) if self.other.is_none() && first != value => self.other = Some(value.to_owned()),
            Some(_) => {}
        }
    }

    /// That points differ in what is not used.
    pub fn doubt(&self) -> Option<Diagnostic> {
        let [first, other] = [self.first.as_ref()?, self.other.as_ref()?].map(|value| String::from_utf8_lossy(value));
        let message =
            format!("the field `{}` of the points is not used, and differs: `{first}`, `{other}`", self.title);
        let remedy = format!(
            "say what it is, as in `points: {{pose: name, marker: {0}}}` or `{{pose: name, session: {0}}}`, or `ignore: [{0}]`",
            self.title
        );
        Some(Diagnostic::warning(message).remedy(remedy))
    }
}
