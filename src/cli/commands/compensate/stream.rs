//! `compensate --stream`: a header and then point by point from the standard input, one answer a line, for use while a robot moves.

use std::io::{BufRead, Write};
use std::time::Instant;

use super::controller::{ControllerFile, Shown};
use super::points::{condition_doubts, found, load};
use crate::Error;
use crate::cli::args::{Compensate, Format};
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::compensation::{Settings, compensate, side_after};
use crate::description::path::Path;
use crate::description::units::Units;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::files::LoadedRobot;
use crate::model::Condition;
use crate::render::compensation::{header, row_of};
use crate::results::{CompensatedPoint, RefusedPoint};

/// A stream of points.
pub struct Stream<'a> {
    pub command: &'a Compensate,
    pub session: &'a Session<'a>,
    pub loaded: &'a LoadedRobot,
    pub units: Units,
    pub settings: Settings,
    pub from: Option<Vec<f64>>,
}

/// What the last points leave for the next.
struct State {
    /// Nominal commands, from which the next are sought.
    nominal: Option<Vec<f64>>,
    /// Corrected commands.
    corrected: Option<Vec<f64>>,
    /// Side from which each variable moved last.
    sides: Vec<f64>,
}

pub fn run(stream: &Stream) -> Result<Output, Error> {
    can_stream(stream.session)?;
    let mut input = Lines { from: std::io::stdin().lock(), number: 0 };
    let empty = || {
        let remedy = "give a line with the names of the columns, and then a line for each point";
        Error::input("the standard input is empty", remedy)
    };
    let mut head = input.next()?.ok_or_else(empty)?;
    // A word to spreadsheets; how the columns are separated is seen from their names.
    if head.text.trim_matches('"').get(..4).is_some_and(|start| start.eq_ignore_ascii_case("sep=")) {
        head = input.next()?.ok_or_else(empty)?;
    }
    stream.check_head(&head)?;
    let is_json = stream.session.arguments.format == Format::Json;
    let mut out = std::io::stdout().lock();
    if !is_json {
        writeln!(out, "{}", header(&stream.loaded.model.variables)).and_then(|()| out.flush())?;
    }
    let mut state =
        State { nominal: stream.from.clone(), corrected: None, sides: vec![0.0; stream.loaded.model.variables.len()] };
    let (mut latencies, mut refused) = (Vec::new(), 0);
    let Some(mut line) = input.next()? else { return Ok(Output::nothing()) };
    // The controller's file is read with the first point, whose columns say what it is needed for.
    let path = stream.read(&head, &line)?;
    let file = ControllerFile::new(stream.command.nominal.as_deref(), stream.loaded, &path, stream.session)?;
    let doubts = file.diagnostics.iter().cloned().chain(condition_doubts(&stream.loaded.model, &path));
    let doubts: Vec<_> = doubts.chain(stream.loaded.diagnostics.iter().cloned()).collect();
    stream.session.terminal.warn(&doubts);
    let shown = file.geometry(stream.loaded)?;
    let mut number = 1;
    loop {
        let started = Instant::now();
        // A line that cannot be read is answered, and the stream goes on.
        let point = stream.answer(&head, &line, number, &shown, &mut state).unwrap_or_else(|error| {
            let name = name_in(&head, &line).map_or_else(|| nameless(number), str::to_string);
            CompensatedPoint::Refused(RefusedPoint::new(number - 1, name, reason(&error)))
        });
        refused += usize::from(matches!(point, CompensatedPoint::Refused(_)));
        let text = match is_json {
            true => serde_json::to_string(&point)?,
            false => row_of(&stream.loaded.model.variables, &point, &stream.units),
        };
        match writeln!(out, "{text}").and_then(|()| out.flush()) {
            Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => break,
            written => written?,
        }
        latencies.push(started.elapsed().as_secs_f64());
        number += 1;
        let Some(next) = input.next()? else { break };
        line = next;
    }
    if !stream.session.arguments.quiet {
        eprintln!("{} points, {refused} refused; {}", latencies.len(), in_words(latencies));
    }
    Ok(Output { failed: refused > 0, ..Output::nothing() })
}

/// Refuses where there is no standard input or output to stream by.
fn can_stream(session: &Session) -> Result<(), Error> {
    if session.arguments.output.is_some() {
        return Err(Error::input("--output, and --stream answers on the standard output", "redirect it: > FILE"));
    }
    if session.terminal.watch.is_some() {
        let message = "--stream is of the command, which has a standard input";
        return Err(Error::input(message, "call `compensate` with a path"));
    }
    Ok(())
}

/// How long answers took, s.
fn in_words(mut latencies: Vec<f64>) -> String {
    latencies.sort_by(f64::total_cmp);
    let last = latencies.len().saturating_sub(1) as f64;
    let of = |share: f64| 1e3 * latencies.get((share * last).round() as usize).unwrap_or(&0.0);
    let [median, most] = [of(0.5), of(0.99)];
    format!("from a line read to its answer written {median:.3} ms (median), {most:.3} ms (99 of 100)")
}

/// The name of a point whose line gives it none.
fn nameless(number: usize) -> String {
    format!("row {number}")
}

/// A line and its number, from 1.
struct Line {
    text: String,
    number: usize,
}

/// Lines that are not blank.
struct Lines<R> {
    from: R,
    number: usize,
}

impl<R: BufRead> Lines<R> {
    /// The next one; bytes that are no UTF-8 are replaced, so that no number or name is read from them.
    fn next(&mut self) -> std::io::Result<Option<Line>> {
        loop {
            let mut bytes = Vec::new();
            if self.from.read_until(b'\n', &mut bytes)? == 0 {
                return Ok(None);
            }
            self.number += 1;
            let text = String::from_utf8_lossy(&bytes).trim_end().to_string();
            if !text.is_empty() {
                return Ok(Some(Line { text, number: self.number }));
            }
        }
    }
}

/// What separates the columns of a table.
const SEPARATORS: [char; 3] = [',', ';', '\t'];

/// The name that a line gives its point.
fn name_in<'l>(head: &Line, line: &'l Line) -> Option<&'l str> {
    let at = head.text.split(SEPARATORS).position(|column| column.trim() == "pose")?;
    line.text.split(SEPARATORS).nth(at).map(str::trim).filter(|name| !name.is_empty())
}

/// Why a line is refused, with its place.
fn reason(error: &Error) -> String {
    let Some(first) = error.diagnostics().and_then(|all| all.iter().find(|found| found.is_error())) else {
        return error.to_string();
    };
    match &first.place {
        Some(at) => format!("line {}, column {}: {}", at.line, at.column, first.message),
        None => first.message.clone(),
    }
}

impl Stream<'_> {
    /// Refuses a header that no point can follow.
    fn check_head(&self, head: &Line) -> Result<(), Error> {
        let zeros: String = head
            .text
            .split_inclusive(SEPARATORS)
            .map(|cell| match cell.chars().next_back() {
                Some(last) if SEPARATORS.contains(&last) => format!("0{last}"),
                _ => "0".into(),
            })
            .collect();
        let Err(found) = self.parsed(head, &Line { text: zeros, number: 0 }) else { return Ok(()) };
        // What is said of the row of zeros is not said of the header.
        let is_own = |fault: &Diagnostic| fault.is_error() && fault.place.as_ref().is_none_or(|at| at.line > 0);
        let own: Vec<Diagnostic> = found.iter().filter(|fault| is_own(fault)).cloned().collect();
        if own.is_empty() { Ok(()) } else { Err(own.into()) }
    }

    /// A line as a table of one row; faults have the line's place.
    fn parsed(&self, head: &Line, line: &Line) -> Result<Path, Diagnostics> {
        let text = format!("{}\n{}\n", head.text, line.text);
        let orientation = self.command.orientation.into();
        let reader = &self.session.reader;
        let parsed = reader.path_text("standard input", text.as_bytes(), self.loaded, self.units, orientation);
        parsed.map_err(|found| {
            let placed = |mut fault: Diagnostic| {
                if let Some(at) = &mut fault.place {
                    at.line = if at.line == 1 { head.number } else { line.number };
                }
                fault
            };
            Vec::from(found).into_iter().map(placed).collect()
        })
    }

    /// A line as a path of one point.
    fn read(&self, head: &Line, line: &Line) -> Result<Path, Error> {
        let mut path = self.parsed(head, line)?;
        load(self.command, self.loaded, &mut path)?;
        Ok(path)
    }

    fn answer(
        &self,
        head: &Line,
        line: &Line,
        number: usize,
        shown: &Shown,
        state: &mut State,
    ) -> Result<CompensatedPoint, Error> {
        let mut path = self.read(head, line)?;
        // Each line is a table of one row.
        path.campaign.poses.iter_mut().filter(|name| **name == nameless(1)).for_each(|name| *name = nameless(number));
        let model = &self.loaded.model;
        let desired = shown.desired(&path, state.nominal.as_deref(), self.command.frame, self.settings.hold)?;
        let nominal = desired.first().and_then(|desired| desired.as_ref().ok()).map(|desired| desired.nominal.clone());
        let values = model.registry.nominal();
        let given: Vec<bool> =
            (0..model.variables.len()).map(|k| path.campaign.conditions.sides(k).is_some()).collect();
        let looks = model.effects.iter().any(|on| on.entry.effect.reads().contains(&Condition::Approach));
        let mut sides = self.sides(state, nominal.as_deref());
        let mut pass = 0;
        let outcome = loop {
            pass += 1;
            for (k, side) in sides.iter().enumerate().filter(|(k, _)| !given[*k]) {
                path.campaign.conditions.set_sides(k, vec![*side]);
            }
            let outcome = compensate(model, &values, &path.campaign, &desired, None, &self.settings)?;
            let corrected = outcome.points.first().and_then(|point| point.as_ref().ok());
            let by_correction = self.sides(state, corrected.map(|point| point.corrected.joints.as_slice()));
            if !looks || by_correction == sides || pass == self.settings.max_passes {
                break outcome;
            }
            sides = by_correction;
        };
        let mut found = found(self.loaded, &path, shown, &desired, &outcome, self.settings.hold)?;
        if let Some(Ok(point)) = outcome.points.first() {
            state.sides = self.sides(state, Some(&point.corrected.joints));
            state.corrected = Some(point.corrected.joints.clone());
            state.nominal = nominal;
        }
        let mut point = found.points.pop().ok_or_else(|| Error::input("no point", "give a value for each column"))?;
        match &mut point {
            CompensatedPoint::Corrected(point) => point.index = number - 1,
            CompensatedPoint::Refused(point) => point.index = number - 1,
        }
        Ok(point)
    }

    /// Sides from which these commands are reached; a variable that stands keeps its own.
    fn sides(&self, state: &State, commands: Option<&[f64]>) -> Vec<f64> {
        let (Some(now), Some(last)) = (commands, &state.corrected) else { return state.sides.clone() };
        let moved = now.iter().zip(last).zip(&state.sides);
        let side = |((now, last), side): ((&f64, &f64), &f64)| side_after([*last, *now], self.settings.standing, *side);
        moved.map(side).collect()
    }
}
