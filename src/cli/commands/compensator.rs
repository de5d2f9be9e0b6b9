//! `compensator`: mounting and spring of a gravity compensator.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::Vector3;

use crate::Error;
use crate::cli::args::Compensator;
use crate::cli::output::Output;
use crate::cli::session::Session;
use crate::cli::values::{numbers, within};
use crate::description::table::{ColumnKind, Dialect, ExpectedColumn, Table, read_table};
use crate::description::units::{Angle, Length, Unit};
use crate::estimation::compensator::{JointCompliance, Triangle, elasticity, from_deflections, mounting};
use crate::plausibility::{Evidence, Limits, judge, of_compliances, of_elasticity, of_mounting};
use crate::render::compensator as render;
use crate::results::Compensator as Found;

pub fn run(command: &Compensator, session: &Session) -> Result<Output, Error> {
    if let Some(campaign) = &command.deflections {
        return deflections(command, campaign, session);
    }
    if command.circle.is_none() && command.mounting.is_none() {
        return Err(Error::input(
            "no measurements of the compensator",
            "give --circle FILE [--anchor FILE], or --mounting L,AX,AY; and --compliances FILE for its spring; or --deflections CAMPAIGN",
        ));
    }
    let (mut mounted, mut compliances, mut spring) = (None, Vec::new(), None);
    let (mut triangle, mut points, mut judged) = (None, Vec::new(), Vec::new());
    if let Some(path) = &command.circle {
        let table = read(session, path, &[("q", true), ("x", true), ("y", true), ("z", true)], false)?;
        let angles = table.numbers("q").unwrap_or_default();
        points = angles.iter().zip(positions(&table)).map(|(q, p)| (q.to_radians(), p)).collect();
        let arcs = command.anchor.as_deref().map(|path| arcs(session, path)).transpose()?.unwrap_or_default();
        let found = mounting(&points, &arcs)?;
        triangle = found.anchor.map(|[ax, ay]| Triangle { lever: found.lever.value, ax: ax.value, ay: ay.value });
        mounted = Some(found);
    }
    if let Some(text) = &command.mounting {
        let given = numbers("--mounting", text, &[3])?;
        triangle = Some(Triangle { lever: given[0] * 1e-3, ax: given[1] * 1e-3, ay: given[2] * 1e-3 });
    }
    if let Some(path) = &command.compliances {
        let Some(triangle) = triangle else {
            return Err(Error::input(
                "--compliances: where the spring is hung is not known",
                "give --anchor as well as --circle, or --mounting L,AX,AY",
            ));
        };
        compliances = read_compliances(session, path)?;
        judged = of_mounting(&points, mounted.as_ref(), Some(&triangle));
        judged.extend(of_compliances(&compliances));
        Output::gate(&judged, session.arguments.force, &[])?;
        spring = Some(elasticity(&triangle, &compliances)?);
    }
    match triangle.as_ref().zip(spring.as_ref()) {
        Some((triangle, spring)) => judged.extend(of_elasticity(triangle, &compliances, spring)),
        None => judged = of_mounting(&points, mounted.as_ref(), triangle.as_ref()),
    }
    let found = Found::new(mounted.as_ref(), triangle.as_ref(), &compliances, spring.as_ref());
    let output = Output::new(render::compensator(&found, session.terminal.screen), &found)?;
    output.judged(judged, session.arguments.force)
}

/// Joint and spring from deflections, in two steps and in one.
fn deflections(command: &Compensator, campaign: &str, session: &Session) -> Result<Output, Error> {
    within("--within", command.within, |v| v > 0.0 && v < 90.0, "give an angle between 0 and 90, deg")?;
    let loaded = session.reader.campaign(campaign, command.robot.as_deref())?;
    let model = &loaded.robot.model;
    let springs = &model.structure.springs;
    let names: Vec<&str> = springs.iter().map(|spring| spring.spring.name.as_str()).collect();
    let spring = match (&command.spring, &springs[..]) {
        (Some(name), _) => springs.iter().find(|spring| spring.spring.name == *name),
        (None, [only]) => Some(only),
        (None, _) => None,
    };
    let Some(spring) = spring else {
        return Err(match names.is_empty() {
            true => {
                Error::input("the description has no spring between bodies", "declare the compensator under `springs:`")
            }
            false => {
                Error::input("which spring is the compensator?", format!("give --spring, one of: {}", names.join(", ")))
            }
        });
    };
    if !loaded.campaign.is_difference() {
        let also = if loaded.campaign.holds_differences() { " too" } else { "" };
        let message = format!("--deflections: the campaign observes `{}`{also}", loaded.campaign.observes.name());
        return Err(Error::input(message, "give a campaign of deflections alone (`observes: deflection`)"));
    }
    let force = session.arguments.force;
    let mut judged = judge(&Evidence::of(model, &loaded.campaign), &Limits::default());
    Output::gate(&judged, force, &loaded.diagnostics)?;
    let found = from_deflections(model, &loaded.campaign, spring, command.within.to_radians())?;
    let given: Vec<JointCompliance> =
        found.angles.iter().map(|at| JointCompliance { ci95: None, ..at.compliance }).collect();
    judged.extend(of_elasticity(&found.triangle, &given, &found.two_steps.elasticity));
    let found = Found::from_deflections(model, &found);
    let mut output = Output::new(render::compensator(&found, session.terminal.screen), &found)?;
    output.diagnostics = loaded.diagnostics;
    output.judged(judged, force)
}

/// The compliances of a joint at its angles.
fn read_compliances(session: &Session, path: &Path) -> Result<Vec<JointCompliance>, Error> {
    let table = read(session, path, &[("q", true), ("k2", true), ("ci95", false)], false)?;
    let column = |name: &str| table.numbers(name).unwrap_or_default();
    let widths = table.has("ci95").then(|| column("ci95"));
    let compliances: Vec<_> = column("q")
        .iter()
        .zip(column("k2"))
        .enumerate()
        .map(|(row, (q, k2))| JointCompliance {
            angle: q.to_radians(),
            compliance: k2 * 1e-6,
            ci95: widths.and_then(|w| w.get(row)).map(|w| w * 1e-6),
        })
        .collect();
    match compliances.iter().position(|k| k.compliance <= 0.0 || k.ci95.is_some_and(|ci| ci <= 0.0)) {
        Some(row) => {
            let line = table.line(row).unwrap_or_default();
            let message = format!("`{}` line {line}: k2 and ci95 must be above 0", path.display());
            Err(Error::input(message, "give compliances in 1e-6 rad/(N.m)"))
        }
        None => Ok(compliances),
    }
}

/// Reads columns of numbers (and of the points' names) with whether each must be there.
fn read(session: &Session, path: &Path, columns: &[(&str, bool)], named: bool) -> Result<Table, Error> {
    let name = path.display().to_string();
    let listed: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    let file = session.reader.table(path).map_err(|diagnostic| {
        let wanted = format!("give a CSV with the columns {}", listed.join(", "));
        if diagnostic.remedy.is_some() { diagnostic } else { diagnostic.remedy(wanted) }
    })?;
    let mut expected: Vec<ExpectedColumn> = columns
        .iter()
        .map(|&(name, required)| {
            let kind = match name {
                "q" => ColumnKind::Quantity(Unit::Angle(Angle::Degree)),
                "x" | "y" | "z" => ColumnKind::Quantity(Unit::Length(Length::Millimetre)),
                _ => ColumnKind::Number,
            };
            ExpectedColumn::new(name, kind, required)
        })
        .collect();
    if named {
        expected.push(ExpectedColumn::new("point", ColumnKind::Text, true));
    }
    Ok(read_table(&name, file, &expected, &BTreeMap::new(), &[], &Dialect::default(), 100_000)?)
}

fn positions(table: &Table) -> Vec<Vector3<f64>> {
    let column = |name: &str| table.numbers(name).unwrap_or_default();
    let (x, y, z) = (column("x"), column("y"), column("z"));
    x.iter().zip(y).zip(z).map(|((x, y), z)| Vector3::new(*x, *y, *z) * 1e-3).collect()
}

/// Positions of each reference point.
fn arcs(session: &Session, path: &Path) -> Result<Vec<Vec<Vector3<f64>>>, Error> {
    let table = read(session, path, &[("x", true), ("y", true), ("z", true), ("q", false)], true)?;
    let names = table.texts("point").cloned().unwrap_or_default();
    let mut arcs = vec![Vec::new(); names.texts().len()];
    for (&point, position) in names.indices().iter().zip(positions(&table)) {
        if let Some(arc) = arcs.get_mut(point as usize) {
            arc.push(position);
        }
    }
    Ok(arcs)
}
