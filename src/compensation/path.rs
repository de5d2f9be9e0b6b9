//! A path: all points in parallel, sides of approach from the way the commands go, and why the robot would miss.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::correct::{Corrected, correct};
use super::coupling::{Balance, Start, settle};
use super::{Deflects, Desired, Deviation, Refusal, Settings};
use crate::description::campaign::Campaign;
use crate::kinematics::AssemblyError;
use crate::model::{Condition, Model, SwitchedOn};
use crate::prediction::{Seen, SinglePredictor, SingleWorkspace};
use crate::process::{Bent, Process};

/// A compensated point.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Commands and residual.
    pub corrected: Corrected,
    /// How the robot would miss, uncorrected; none where the process allows no such place.
    pub before: Option<Deviation>,
    /// Wrench on the tool at the target, the process's included, N and N.m, base axes.
    pub wrench: [f64; 6],
    /// With a process: distance from the target of the equilibrium found from the commands alone, m.
    pub settled: Option<f64>,
    /// How far a strip that can yield is bent there.
    pub strip: Option<Bent>,
    /// How far the linear deflection at the commands is off that of the equilibrium at the deflected pose, m; none where that
    /// is not asked for, or there is no such equilibrium.
    pub linear_error: Option<f64>,
}

/// What became of a path.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Its points, in order.
    pub points: Vec<Result<Point, Refusal>>,
    /// Where sides of approach came from.
    pub sides: Sides,
    /// Effects of the measurement, left out.
    pub left_out: Vec<String>,
}

/// Where sides of approach came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Sides {
    /// The path's own columns.
    Given,
    /// The way the corrected commands go.
    Derived,
    /// As derived; but corrections turn some back and forth, and those of the last pass are taken.
    Unsettled,
}

/// Compensates a path for a model with its values (all slots, SI). `path` holds markers, wrenches and conditions of the
/// points, `desired` what is wanted of each.
///
/// # Errors
/// The model cannot be assembled with these values.
///
/// ```
/// use elastogeo::compensation::{Asked, Controller, Hold, Settings, compensate, desire};
/// use elastogeo::files::Reader;
/// use elastogeo::kinematics::{Geometry, Transform};
///
/// let reader = Reader::default();
/// let robot = reader.robot("kuka-ir663")?;
/// let model = &robot.model;
/// let path = reader.path("ir663-strip", &robot, robot.raw.units)?;
/// let geometry = Geometry::nominal(model)?;
/// let controller = Controller { geometry: &geometry, markers: &[] };
/// let asked = Asked { joints: false, position: true, orientation: true, hold: Hold::POSE };
/// let desired = desire(&controller, &path.campaign, asked, &Transform::identity(), None, None);
/// let values = model.registry.nominal();
/// let found = compensate(model, &values, &path.campaign, &desired, None, &Settings::new(6))?;
/// let first = found.points[0].as_ref().expect("reachable");
/// // Own weight alone: 1.8 mm are corrected to less than 0.1 um.
/// assert!(first.before.is_some_and(|deviation| deviation.all.norm() > 1e-3) && first.corrected.position <= 1e-7);
/// # Ok::<(), elastogeo::Error>(())
/// ```
pub fn compensate(
    model: &Model,
    values: &[f64],
    path: &Campaign,
    desired: &[Result<Desired, Refusal>],
    process: Option<&Process>,
    settings: &Settings,
) -> Result<Outcome, AssemblyError> {
    let mut path = path.clone();
    let own = own_sides(model, &path);
    let derived = own.contains(&false);
    let mut commands: Vec<Option<Vec<f64>>> =
        desired.iter().map(|d| d.as_ref().ok().map(|d| d.nominal.clone())).collect();
    let mut sides = if derived { Sides::Derived } else { Sides::Given };
    let travel = travel(desired);
    let history = process.filter(|process| process.remembers()).map(|process| history(process, desired, &travel));
    let mut pass = 0;
    loop {
        pass += 1;
        if derived {
            derive_sides(&commands, &own, settings.standing, &mut path);
        }
        let predictor = predictor(model, values, &path, settings)?;
        let uncorrected = history.is_some().then(|| in_order(&predictor, desired, process, &travel, settings));
        let points: Vec<Result<Point, Refusal>> = desired
            .par_iter()
            .enumerate()
            .map_init(
                || predictor.workspace(),
                |work, (index, desired)| {
                    let desired = desired.as_ref().map_err(Clone::clone)?;
                    let (past, strip) = match &history {
                        Some(history) => (Some(&history[index].0), history[index].1),
                        None => (process, None),
                    };
                    let before = uncorrected.as_ref().map(|found| found[index].as_ref().ok().map(|found| found.seen));
                    let task = Task { desired, process: past, travel: &travel[index], before };
                    Ok(Point { strip, ..point(&predictor, index, task, settings, work)? })
                },
            )
            .collect();
        let found: Vec<Option<Vec<f64>>> =
            points.iter().map(|p| p.as_ref().ok().map(|p| p.corrected.joints.clone())).collect();
        let left_out = predictor.left_out.clone();
        let before = path.conditions.clone();
        // The side matters only at joints with an effect that depends on it.
        let settled = !derived || {
            derive_sides(&found, &own, settings.standing, &mut path);
            sides_that_matter(model).all(|variable| path.conditions.sides(variable) == before.sides(variable))
        };
        if settled || pass == settings.max_passes {
            sides = if settled { sides } else { Sides::Unsettled };
            return Ok(Outcome { points, sides, left_out });
        }
        commands = found;
    }
}

/// Where the robot passes under uncorrected commands, in equilibrium with a process: the reading and the whole wrench of
/// each point. Sides of approach that the path does not give are derived from its commands, and written into it.
///
/// # Errors
/// The model cannot be assembled with these values.
pub fn predict_path(
    model: &Model,
    values: &[f64],
    path: &mut Campaign,
    desired: &[Result<Desired, Refusal>],
    process: Option<&Process>,
    settings: &Settings,
) -> Result<Vec<Result<Balance, Refusal>>, AssemblyError> {
    let own = own_sides(model, path);
    let commands: Vec<Option<Vec<f64>>> = desired.iter().map(|d| d.as_ref().ok().map(|d| d.nominal.clone())).collect();
    derive_sides(&commands, &own, settings.standing, path);
    let predictor = predictor(model, values, path, settings)?;
    let travel = travel(desired);
    if process.is_some_and(Process::remembers) {
        return Ok(in_order(&predictor, desired, process, &travel, settings));
    }
    let settled = desired.par_iter().enumerate().map_init(
        || predictor.workspace(),
        |work, (index, desired)| {
            let desired = desired.as_ref().map_err(Clone::clone)?;
            balanced(&predictor, index, desired, process, &travel[index], settings, work)
        },
    );
    Ok(settled.collect())
}

/// The predictor that the settings ask for.
fn predictor<'a>(
    model: &'a Model,
    values: &[f64],
    path: &'a Campaign,
    settings: &Settings,
) -> Result<SinglePredictor<'a>, AssemblyError> {
    let predictor = SinglePredictor::new(model, values, path)?;
    Ok(if settings.deflection == Deflects::Equilibrium { predictor.at_equilibrium() } else { predictor })
}

/// Where a point of the path passes under its own commands.
fn balanced(
    predictor: &SinglePredictor,
    index: usize,
    desired: &Desired,
    process: Option<&Process>,
    travel: &Vector3<f64>,
    settings: &Settings,
    work: &mut SingleWorkspace,
) -> Result<Balance, Refusal> {
    let given = predictor.campaign.readings[index].wrench;
    predictor.place(&desired.nominal, work)?;
    match process {
        None => Ok(Balance { seen: predictor.see(index, &given, work)?, wrench: given, strip: None }),
        Some(process) => {
            let target = desired.target.translation.vector;
            let start = Start { wrench: given, travel: *travel, point: target };
            settle(predictor, index, process, &start, &settings.balance, work)
        }
    }
}

/// The same of all points one after the other, with what a process remembers.
fn in_order(
    predictor: &SinglePredictor,
    desired: &[Result<Desired, Refusal>],
    process: Option<&Process>,
    travel: &[Vector3<f64>],
    settings: &Settings,
) -> Vec<Result<Balance, Refusal>> {
    let mut work = predictor.workspace();
    let mut process = process.cloned();
    let mut found = Vec::with_capacity(desired.len());
    for (index, (desired, travel)) in desired.iter().zip(travel).enumerate() {
        let desired = desired.as_ref().map_err(Clone::clone);
        let balance = desired
            .and_then(|desired| balanced(predictor, index, desired, process.as_ref(), travel, settings, &mut work));
        found.push(balance.and_then(|mut balance| {
            let at = balance.seen.real.translation.vector;
            if let Some((after, bent)) =
                process.as_ref().map(|process| process.after(&at, travel)).transpose()?.flatten()
            {
                (process, balance.strip) = (Some(after), Some(bent));
            }
            Ok(balance)
        }));
    }
    found
}

/// A process that remembers as it stands before each target, all of which are met, and how far its strip is bent there.
fn history(
    process: &Process,
    desired: &[Result<Desired, Refusal>],
    travel: &[Vector3<f64>],
) -> Vec<(Process, Option<Bent>)> {
    let mut now = process.clone();
    let each = desired.iter().zip(travel).map(|(desired, travel)| {
        let before = now.clone();
        let target = desired.as_ref().ok().map(|desired| desired.target.translation.vector);
        // Where the process cannot be, the point is refused.
        let after = target.and_then(|target| now.after(&target, travel).ok().flatten());
        let bent = after.map(|(after, bent)| {
            now = after;
            bent
        });
        (before, bent)
    });
    each.collect()
}

/// A point to be compensated.
struct Task<'a> {
    desired: &'a Desired,
    /// As it stands before the point.
    process: Option<&'a Process>,
    travel: &'a Vector3<f64>,
    /// Where the point passes without correction, if that has been found already.
    before: Option<Option<Seen>>,
}

fn point(
    predictor: &SinglePredictor,
    index: usize,
    task: Task,
    settings: &Settings,
    work: &mut SingleWorkspace,
) -> Result<Point, Refusal> {
    let Task { desired, process, travel, before } = task;
    let given = predictor.campaign.readings[index].wrench;
    let target = desired.target.translation.vector;
    let mut wrench = given;
    if let Some(process) = process {
        // Compensated, the tool is where it should be, and the process pushes as it does there.
        let push = process.push(&target, travel)?;
        (0..3).for_each(|k| wrench[k] += push.force[k]);
    }
    let before = match (before, process) {
        (Some(before), _) => before,
        (None, None) => Some(balanced(predictor, index, desired, None, travel, settings, work)?.seen),
        (None, Some(_)) => {
            balanced(predictor, index, desired, process, travel, settings, work).ok().map(|found| found.seen)
        }
    };
    let before = before.map(|seen| deviation(&seen, desired));
    let corrected = correct(predictor, index, desired, &wrench, settings, work)?;
    let settled = match process {
        None => None,
        Some(process) => {
            predictor.place(&corrected.joints, work)?;
            // From where the arm stands under what it carries alone, and else from the target.
            let free = predictor.see(index, &given, work)?.real.translation.vector;
            let settle = |from: &Vector3<f64>, work: &mut SingleWorkspace| {
                let start = Start { wrench: given, travel: *travel, point: *from };
                settle(predictor, index, process, &start, &settings.balance, work)
            };
            let found = settle(&free, work).or_else(|_| settle(&target, work))?;
            Some((found.seen.real.translation.vector - target).norm())
        }
    };
    let linear_error = if settings.deflection == Deflects::Compared {
        predictor.place(&corrected.joints, work)?;
        predictor.linear_error(index, &wrench, work).ok()
    } else {
        None
    };
    Ok(Point { corrected, before, wrench, settled, strip: None, linear_error })
}

fn deviation(seen: &Seen, desired: &Desired) -> Deviation {
    let target = desired.target.translation.vector;
    Deviation {
        all: seen.real.translation.vector - target,
        geometry: seen.rigid.translation.vector - target,
        weight: seen.by_weight,
        wrench: seen.by_wrench,
        effects: seen.by_effects(),
        turned: seen.to(&desired.target).fixed_rows::<3>(3).norm(),
    }
}

/// Direction in which each target is reached; of the first, in which it is left.
fn travel(desired: &[Result<Desired, Refusal>]) -> Vec<Vector3<f64>> {
    let at = |row: usize| desired.get(row).and_then(|d| d.as_ref().ok()).map(|d| d.target.translation.vector);
    (0..desired.len())
        .map(|row| {
            let (from, to) = if row == 0 { (at(0), at(1)) } else { (at(row - 1), at(row)) };
            from.zip(to).map_or(Vector3::zeros(), |(from, to)| to - from)
        })
        .collect()
}

/// Whether the path gives the sides of approach of each variable.
fn own_sides(model: &Model, path: &Campaign) -> Vec<bool> {
    (0..model.variables.len()).map(|variable| path.conditions.sides(variable).is_some()).collect()
}

/// The side from which a variable reaches its second value from the first, as the column `approach` has it: above zero where it came
/// from above. One that moves by less than `standing` keeps the side it had.
pub fn side_after([last, now]: [f64; 2], standing: f64, side: f64) -> f64 {
    if (now - last).abs() > standing { (last - now).signum() } else { side }
}

/// Variables at whose joints an effect depends on the side of approach.
fn sides_that_matter(model: &Model) -> impl Iterator<Item = usize> {
    let looks = |on: &&SwitchedOn| on.entry.effect.reads().contains(&Condition::Approach);
    let seen: Vec<Option<usize>> = model.effects.iter().filter(looks).map(|on| on.entry.site.coordinate).collect();
    (0..model.variables.len()).filter(move |&variable| seen.iter().any(|own| own.is_none_or(|own| own == variable)))
}

/// Writes the side from which each variable reaches each point (of the first: as if coming the way it leaves) into the
/// conditions of a path, except of variables whose sides are its `own`. A variable that moves by less than `standing` (rad or m) keeps its side; 0 before it first moves.
fn derive_sides(commands: &[Option<Vec<f64>>], own: &[bool], standing: f64, path: &mut Campaign) {
    for (k, _) in own.iter().enumerate().filter(|(_, own)| !**own) {
        let mut sides = vec![0.0; commands.len()];
        let mut side = 0.0;
        let mut last: Option<f64> = None;
        for (row, q) in commands.iter().enumerate() {
            let Some(now) = q.as_ref().map(|q| q[k]) else {
                sides[row] = side;
                continue;
            };
            if let Some(last) = last {
                side = side_after([last, now], standing, side);
            }
            sides[row] = side;
            last = Some(now);
        }
        if let Some(first) = sides.iter().copied().find(|side| *side != 0.0) {
            sides.iter_mut().take_while(|side| **side == 0.0).for_each(|side| *side = first);
        }
        path.conditions.set_sides(k, sides);
    }
}
