//! What the files of a campaign say twice or by half: of a row in a column and of the file in its entry, in two columns for one
//! thing, of the noise for some axes or some readings only.

use super::raw::{RawCampaign, RawEntry};
use super::source::Source;
use super::{Campaign, LOAD_POINT, Reading};
use crate::description::resolve::Locate;
use crate::description::robot::Robot;
use crate::diagnostic::Diagnostic;
use crate::observation::{Observes, ValueColumn};

/// Columns of the noise by axis.
const BY_AXIS: [&str; 3] = ["sigma.x", "sigma.y", "sigma.z"];

/// Faults of the files' columns.
pub(super) fn contradictions(robot: &Robot, sources: &[Source], locate: Locate) -> Vec<Diagnostic> {
    let mut faults = Vec::new();
    for source in sources {
        faults.extend(column_against_key(source));
        faults.extend(two_noises(source));
        faults.extend(two_ways(source, robot));
        faults.extend(noise_of_some_axes(source));
    }
    faults.extend(read_twice(sources, locate));
    faults
}

/// One fault of columns from which two kinds of readings would be taken: each row would count twice, and a loaded place is no deflection.
/// Readings that are copies of others are told where they are counted.
fn read_twice(sources: &[Source], locate: Locate) -> Option<Diagnostic> {
    let of = |entry: &RawEntry| {
        (entry.file.clone(), entry.columns.clone(), entry.body.clone(), entry.points.clone(), entry.markers.clone())
    };
    let shares =
        |a: Observes, b: Observes| a.columns().iter().any(|one| b.columns().iter().any(|two| one.name == two.name));
    let mut known: Vec<(usize, &Source, Observes)> = Vec::new();
    let mut twice = None;
    for (index, source) in sources.iter().enumerate() {
        for &kind in &source.kinds {
            let is_again = |(other, earlier, before): &&(usize, &Source, Observes)| {
                (*other == index || *before != kind && of(earlier.entry) == of(source.entry)) && shares(*before, kind)
            };
            twice = twice.or_else(|| known.iter().find(is_again).map(|(_, _, before)| (source, *before, kind)));
            known.push((index, source, kind));
        }
    }
    let (source, one, two) = twice?;
    let message = match one == two {
        true => format!("`{}` is read twice as `{}`", source.entry.file, one.name()),
        false => {
            format!("`{}` and `{}` are read from the same columns of `{}`", one.name(), two.name(), source.entry.file)
        }
    };
    let remedy = "name one kind of each reading; give readings that are not the same a file, or columns, of their own";
    Some(Diagnostic::error(message).at(Source::place_of_kinds(locate)).remedy(remedy))
}

/// A column that says of a row otherwise than the file's entry says of all its rows.
fn column_against_key(source: &Source) -> Vec<Diagnostic> {
    let RawEntry { session, station, payload, load_point, .. } = source.entry;
    let stated = [("session", session), ("station", station), ("payload", payload), (LOAD_POINT, load_point)];
    let against = |(name, key): (&'static str, &Option<String>)| {
        let key = key.as_deref()?;
        let texts = source.table.texts(name)?;
        let row = (0..source.table.row_count()).find(|&row| texts.get(row).is_some_and(|text| text != key))?;
        let other = texts.get(row).unwrap_or_default();
        let message =
            format!("the column `{name}` says `{other}`, and the entry of its file says `{name}: {key}` of all rows");
        let diagnostic = Diagnostic::error(message).at(source.table.place(row, name));
        Some(diagnostic.remedy(format!("leave out `{name}:` of the entry, or the column by `ignore:`")))
    };
    stated.into_iter().filter_map(against).collect()
}

/// One fault of two columns that say the same thing.
fn both(source: &Source, one: &str, other: &str, of: &str) -> Diagnostic {
    let message = format!("the columns `{one}` and `{other}` both give {of}");
    let diagnostic = Diagnostic::error(message).at(source.table.place(0, other));
    diagnostic.remedy("keep one of them, and take the other out with `ignore:`")
}

/// The noise in two ways: by a standard and by an expanded uncertainty, of all axes and by axis.
fn two_noises(source: &Source) -> Option<Diagnostic> {
    let ways = ["sigma", "U95"].into_iter().chain(BY_AXIS);
    let mut given = ways.filter(|name| source.table.has(name));
    let first = given.next().filter(|first| !BY_AXIS.contains(first))?;
    given.next().map(|other| both(source, first, other, "the noise of a row"))
}

/// What is measured in two ways of writing it.
fn two_ways(source: &Source, robot: &Robot) -> Vec<Diagnostic> {
    let is_joint = |column: &ValueColumn| robot.variables.iter().any(|variable| variable.name == column.name);
    let of_kind = |kind: &crate::observation::Observes| {
        let other = kind.other_columns();
        let there = |columns: &'static [ValueColumn]| columns.iter().find(|column| source.table.has(column.name));
        // A joint that is called so is that joint.
        let other = if other.iter().any(is_joint) { None } else { there(other) };
        Some(both(source, there(kind.columns())?.name, other?.name, &format!("the {}", kind.name())))
    };
    source.kinds.iter().filter_map(of_kind).collect()
}

/// Noise of some coordinates, where nothing states that of the others.
fn noise_of_some_axes(source: &Source) -> Option<Diagnostic> {
    let has = |name: &&str| source.table.has(name);
    let is_stated = source.entry.instrument.as_ref().is_some_and(|instrument| instrument.sigma.is_some());
    let is_of_axes = source.kinds.iter().any(|kind| kind.length_rows() > 1);
    if is_stated || !is_of_axes || ["sigma", "U95"].iter().any(has) {
        return None;
    }
    let (there, lacking): (Vec<&str>, Vec<&str>) = BY_AXIS.into_iter().partition(|name| has(name));
    let first = there.first().filter(|_| !lacking.is_empty())?;
    let message = format!(
        "`{}` states the noise of some axes, and nothing that of the others: `{}` is missing",
        there.join("`, `"),
        lacking.join("`, `")
    );
    let diagnostic = Diagnostic::error(message).at(source.table.place(0, first));
    Some(diagnostic.remedy("give all three, one column `sigma`, or `instrument: {sigma: ..}` for the others"))
}

/// Readings of lengths whose noise is not stated next to others whose noise is: their weights against each other are not known.
pub(super) fn noise_of_some_readings(campaign: &Campaign, raw: &RawCampaign, locate: Locate) -> Option<Diagnostic> {
    let of_lengths = || campaign.readings.iter().filter(|reading| reading.observes.length_rows() > 0);
    let is_stated = |reading: &&Reading| reading.noise.is_stated[0];
    let (count, stated) = (of_lengths().count(), of_lengths().filter(is_stated).count());
    let first = of_lengths().find(|reading| !is_stated(reading)).filter(|_| stated > 0)?;
    let message = format!(
        "{} of {count} readings state their noise, and the others do not, from {} on: their relative weights are unknown",
        stated,
        campaign.address(first)
    );
    // The file whose readings lack it.
    let files = raw.measurements.as_ref().map_or(0, |all| all.0.len());
    let before = campaign.files.iter().filter(|(_, end)| first.row > *end).count().min(files.saturating_sub(1));
    let diagnostic = Diagnostic::error(message).at(locate(&["measurements", &before.to_string()]));
    Some(
        diagnostic
            .remedy("state it of all: `instrument: {sigma: ..}` of the campaign or of the file, or a column `sigma`"),
    )
}
