//! `compensate --stream`: a header and then point by point from the standard input, one answer a line, for use while a robot moves.

use std::io::{BufRead, Write};
use std::time::Instant;

use super::controller::{ControllerFile, Shown};
use super::points::{condition_doubts, found, load};
use crate::Error;
use crate::cli::args::{Compensate, Format};
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::compensation::{Settings, compensate};
use crate::description::path::Path;
use crate::description::units::Units;
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
    if stream.session.arguments.output.is_some() {
        return Err(Error::input("--output, and --stream answers on the standard output", "redirect it: > FILE"));
    }
    if stream.session.terminal.watch.is_some() {
        return Err(Error::input(
            "--stream is of the command, which has a standard input",
            "call `compensate` with a path",
        ));
    }
    let mut input = std::io::stdin().lock();
    let mut head = String::new();
    while head.trim().is_empty() {
        if next_line(&mut input, &mut head)? == 0 {
            return Err(Error::input(
                "the standard input is empty",
                "give a line with the names of the columns, and then a line for each point",
            ));
        }
    }
    let is_json = stream.session.arguments.format == Format::Json;
    let mut out = std::io::stdout().lock();
    let mut state =
        State { nominal: stream.from.clone(), corrected: None, sides: vec![0.0; stream.loaded.model.variables.len()] };
    let mut controller: Option<ControllerFile> = None;
    let (mut latencies, mut refused) = (Vec::new(), 0);
    let mut line = String::new();
    // The controller's file is read with the first point, whose columns say what it is needed for.
    let first = loop {
        line.clear();
        if next_line(&mut input, &mut line)? == 0 {
            break None;
        }
        if !line.trim().is_empty() {
            let path = stream.read(&head, &line, 1)?;
            let file = ControllerFile::new(stream.command.nominal.as_deref(), stream.loaded, &path, stream.session)?;
            let doubts = file.diagnostics.iter().cloned().chain(condition_doubts(&stream.loaded.model, &path));
            let doubts: Vec<_> = doubts.chain(stream.loaded.diagnostics.iter().cloned()).collect();
            stream.session.terminal.warn(&doubts);
            break Some(controller.insert(file));
        }
    };
    let Some(file) = first else { return Ok(Output::nothing()) };
    let shown = file.geometry(stream.loaded)?;
    if !is_json {
        writeln!(out, "{}", header(&stream.loaded.model.variables))?;
    }
    let mut number = 1;
    loop {
        let started = Instant::now();
        // A line that cannot be read is answered, and the stream goes on.
        let point = stream.answer(&head, &line, number, &shown, &mut state).unwrap_or_else(|error| {
            CompensatedPoint::Refused(RefusedPoint::new(number - 1, nameless(number), error.to_string()))
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
        line.clear();
        while line.trim().is_empty() {
            line.clear();
            if next_line(&mut input, &mut line)? == 0 {
                break;
            }
        }
        if line.trim().is_empty() {
            break;
        }
    }
    if !stream.session.arguments.quiet {
        latencies.sort_by(f64::total_cmp);
        let of =
            |share: f64| 1e3 * latencies.get((share * (latencies.len() - 1) as f64).round() as usize).unwrap_or(&0.0);
        eprintln!(
            "{} points, {refused} refused; from a line read to its answer written {:.3} ms (median), {:.3} ms (99 of 100)",
            latencies.len(),
            of(0.5),
            of(0.99)
        );
    }
    Ok(Output { failed: refused > 0, ..Output::nothing() })
}

/// The name of a point whose line gives it none.
fn nameless(number: usize) -> String {
    format!("row {number}")
}

/// Appends a line; bytes that are no UTF-8 are replaced, so that no number or name is read from them. How many bytes there were.
fn next_line(input: &mut impl BufRead, line: &mut String) -> std::io::Result<usize> {
    let mut bytes = Vec::new();
    let count = input.read_until(b'\n', &mut bytes)?;
    *line += &String::from_utf8_lossy(&bytes);
    Ok(count)
}

impl Stream<'_> {
    /// A line as a path of one point.
    fn read(&self, head: &str, line: &str, number: usize) -> Result<Path, Error> {
        let text = format!("{}\n{}\n", head.trim_end(), line.trim_end());
        let mut path =
            self.session.reader.path_text(&format!("line {number}"), text.as_bytes(), self.loaded, self.units)?;
        load(self.command, self.loaded, &mut path)?;
        Ok(path)
    }

    fn answer(
        &self,
        head: &str,
        line: &str,
        number: usize,
        shown: &Shown,
        state: &mut State,
    ) -> Result<CompensatedPoint, Error> {
        let mut path = self.read(head, line, number)?;
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
        let side = |((now, last), side): ((&f64, &f64), &f64)| {
            if (now - last).abs() > self.settings.standing { (now - last).signum() } else { *side }
        };
        moved.map(side).collect()
    }
}
