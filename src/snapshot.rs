//! Snapshots that guard robot descriptions: frames, every declared number, the structure and how it gives, limits, rank and
//! kept parameters of the geometric calibration. SI.

use std::fmt::Write;

use crate::description::elastic::Payload;
use crate::description::fuzzy::{Component, Premise, Rules, Split};
use crate::description::raw::RawValidity;
use crate::description::robot::Robot;
use crate::elements::{Direction, PerLength};
use crate::identifiability::{Column, Criterion, DEFAULT_TOLERANCE, Scaling, reduce};
use crate::kinematics::{AssemblyError, By, ErrorColumns, Geometry, Placements, Rates};
use crate::model::{Edge, Model};
use crate::parameter::Group;
use crate::simulation::{draw_configurations, generator};
use crate::state::{Loads, Mechanics};

/// Configurations of which frames are written.
const SAMPLES: usize = 3;

/// A text that changes when the description's meaning does: frames at sample configurations and how the tool gives there,
/// parameters with their tolerances and bounds, anchors, elements, limits, effects, rules, and rank and kept set for pose
/// readings at 60 seeded configurations.
///
/// # Errors
/// What keeps the robot from being assembled.
///
/// ```
/// let model = elastogeo::files::load_robot("universal-ur5")?.model;
/// let text = elastogeo::snapshot::snapshot(&model).expect("assembled");
/// assert!(text.starts_with(&model.name) && text.lines().count() > 20);
/// # Ok::<(), elastogeo::Error>(())
/// ```
pub fn snapshot(model: &Model) -> Result<String, AssemblyError> {
    let geometry = Geometry::nominal(model)?;
    let configurations = draw_configurations(&geometry, 60, 0.8, &mut generator(1))?;
    let mut out = format!("{}\n", model.name);
    let mut placements = Placements::default();
    for q in configurations.iter().take(SAMPLES) {
        geometry.place(q, &mut placements)?;
        let _ = writeln!(out, "\nat {}", numbers(q));
        for (frame, placed) in model.frames.iter().zip(&placements.frames).skip(1) {
            let r = placed.rotation.matrix();
            let _ = writeln!(
                out,
                "{:>4}: {} | {} | {}",
                frame.name,
                numbers(placed.translation.vector.as_slice()),
                numbers(r.column(0).as_slice()),
                numbers(r.column(2).as_slice())
            );
        }
    }
    out += &given(model, &configurations)?;
    out += &declared(model);
    let slots = model.free_slots();
    let by: Vec<By> = slots.iter().map(|&slot| By::Slot(slot)).collect();
    let mut rates = Rates::new(model);
    let plan = ErrorColumns::new(&geometry, &rates, model.tool.0, &by);
    let mut columns = vec![[0.0; 6]; slots.len()];
    let mut matrix = Vec::new();
    for q in &configurations {
        geometry.place(q, &mut placements)?;
        rates.evaluate(&geometry, q, &placements);
        plan.evaluate(&geometry, &placements, &rates, &mut columns);
        (0..6).for_each(|row| matrix.extend(columns.iter().map(|column| column[row])));
    }
    let about: Vec<Column> = slots.iter().map(|&slot| Column::about(&model.registry[slot], false)).collect();
    let found = reduce(&matrix, &about, Scaling::Norm, Criterion::Relative(DEFAULT_TOLERANCE));
    let name = |column: &usize| model.registry[slots[*column]].name.as_str();
    let _ =
        writeln!(out, "\nfree ({}): {}", slots.len(), (0..slots.len()).map(|k| name(&k)).collect::<Vec<_>>().join(" "));
    let _ = writeln!(
        out,
        "rank {}, kept ({}): {}",
        found.rank,
        found.kept.len(),
        found.kept.iter().map(name).collect::<Vec<_>>().join(" ")
    );
    Ok(out)
}

/// What a description declares apart from its model: gear ratios, payloads, sums in which results are reported.
pub fn apart_from_model(robot: &Robot) -> String {
    let mut out = String::new();
    for variable in &robot.variables {
        if let Some(ratio) = variable.gear_ratio {
            let _ = writeln!(out, "gear ratio {}: {}", variable.name, digits(&[ratio], 0.0));
        }
    }
    for (name, Payload { mass, com, frame }) in &robot.payloads {
        let frame = robot.frames.get(*frame).map_or("", |frame| &frame.name);
        let _ = writeln!(out, "payload {name} on {frame}: {} | {}", digits(&[*mass], 0.0), numbers(com.as_slice()));
    }
    for (set, sums) in &robot.calibration.combinations {
        for (name, sum) in sums {
            let of: Vec<String> =
                sum.of.iter().map(|(name, factor)| format!("{} {name}", digits(&[*factor], 0.0))).collect();
            let _ = writeln!(out, "combination {set} {name}: {}", of.join(" + "));
        }
    }
    out
}

/// The range of the readings by which a description was fitted: rad, m, N, N.m, kg, s; temperatures as the campaign had them.
pub fn range_of(validity: &RawValidity) -> String {
    let of = |what: &str, range: &[f64; 2]| format!("valid {what}: {}\n", digits(range, 0.0));
    let joints = validity.joints.iter().chain(&validity.loads).map(|(name, range)| of(name, range));
    let noted = [("time", validity.time), ("temperature", validity.temperature)];
    joints.chain(noted.into_iter().filter_map(|(name, range)| Some(of(name, &range?)))).collect()
}

/// How the tool gives at the sample configurations: by a unit of each load there, and under own weight. Nothing of a rigid
/// robot.
fn given(model: &Model, configurations: &[Vec<f64>]) -> Result<String, AssemblyError> {
    let mut out = String::new();
    let mechanics = Mechanics::new(model, &model.registry.nominal(), Loads { weight: true, wrench: true }, &[])?;
    if !mechanics.deflects() {
        return Ok(out);
    }
    out += "\nthe tool by a unit of each load, and under own weight\n";
    let mut state = mechanics.state();
    for q in configurations.iter().take(SAMPLES) {
        let _ = match mechanics.place(q, &mut state) {
            Ok(()) => {
                let point = mechanics.point(&state, None, &[0.0; 6]);
                let compliance = mechanics.compliance(&state, &point);
                let sag = mechanics.deflection(&state, &point).displacement;
                writeln!(out, "{} | {}", digits(compliance.diagonal().as_slice(), 0.0), digits(sag.as_slice(), 1e-15))
            }
            Err(error) => writeln!(out, "{error}"),
        };
    }
    Ok(out)
}

/// What the description declares, line by line.
fn declared(model: &Model) -> String {
    let mut out = String::from("\nparameters (* free): value, tolerance, bounds\n");
    for parameter in model.registry.all() {
        let least = if parameter.group == Group::Elastic { 0.0 } else { 1e-12 };
        if parameter.nominal.abs() > least || parameter.free {
            let star = if parameter.free { "*" } else { "" };
            let value = digits(&[parameter.shown(parameter.nominal)], least);
            let numbers = format!("{value} {}", digits(&[parameter.tolerance], 0.0));
            let bounds = digits(&parameter.bounds, 0.0);
            let _ = writeln!(out, "{}{star} {numbers} [{bounds}]", parameter.name);
        }
    }
    for marker in &model.markers {
        let _ = writeln!(out, "marker {} on {}", marker.name, model.frames[marker.frame].name);
    }
    for (name, anchor) in &model.anchors {
        let _ = writeln!(out, "anchor {name}: {}", numbers(anchor.as_slice()));
    }
    for variable in &model.variables {
        let _ = writeln!(out, "variable {}: {}", variable.name, limits(variable.limits));
    }
    for frame in model.frames.iter().filter(|frame| frame.limits.is_some()) {
        let _ = writeln!(out, "joint {}: {}", frame.name, limits(frame.limits));
    }
    for keep_out in &model.keep_out {
        let _ = writeln!(out, "keep out {}: {}", keep_out.name, numbers(keep_out.space.as_flattened()));
    }
    for sum in &model.limits {
        let _ = writeln!(out, "sum {}: {}", sum.name, numbers(&sum.limits));
    }
    structure(model, &mut out);
    for entry in model.effects.iter().map(|effect| effect.entry.raw(model)) {
        let values: Vec<String> = entry.parameters.iter().map(|(name, value)| format!("{name}={value}")).collect();
        let (effect, site) = (entry.effect.unwrap_or_default(), entry.site.unwrap_or_default());
        let _ = writeln!(out, "effect {effect}@{site}: {}", values.join(" "));
    }
    if let Some(axes) = model.fuzzy.as_ref().and_then(|fuzzy| fuzzy.axes) {
        let _ = writeln!(out, "rules: axes of {}", model.frames[axes].name);
    }
    for component in model.fuzzy.iter().flat_map(|fuzzy| &fuzzy.components) {
        rules(&Component::name(component.at), &component.rules, &mut out);
    }
    for (slot, own) in model.local_springs.iter().flat_map(|local| &local.springs) {
        rules(&model.registry[*slot].name, own, &mut out);
    }
    out
}

fn rules(name: &str, rules: &Rules, out: &mut String) {
    let premises: Vec<String> = match &rules.premise {
        Premise::Grid(modes) => modes.iter().map(|modes| digits(modes, 1e-12)).collect(),
        Premise::Tree(tree) => {
            let split =
                |split: &Split| format!("{} {} {:?}", split.input, digits(&split.between, 1e-12), split.branches);
            tree.splits.iter().map(split).collect()
        }
    };
    let _ = writeln!(out, "rules {name}: {} | {}", premises.join(" | "), digits(&rules.conclusions, 0.0));
}

/// Elements, springs and masses of the structure, where anything gives or weighs.
fn structure(model: &Model, out: &mut String) {
    let (structure, values) = (&model.structure, model.registry.nominal());
    let name = |vertex: usize| structure.vertices.get(vertex).map_or("", |vertex| vertex.name.as_str());
    let is_shown = |edge: &&Edge| {
        edge.element.is_active(&values) || edge.element.directions().iter().any(|own| *own != Direction::Flexible)
    };
    let shown: Vec<&Edge> = structure.edges().skip(1).filter(is_shown).collect();
    for edge in &shown {
        let element = &edge.element;
        let released: String =
            element.directions().iter().map(|own| if *own == Direction::Flexible { '-' } else { 'o' }).collect();
        let per_length = element.per_length(&values).unwrap_or_default();
        let [a, b] = edge.ends;
        let numbers = format!("{} {}", digits(&per_length.compliance, 0.0), digits(&[per_length.mass], 0.0));
        let numbers = if per_length == PerLength::default() { String::new() } else { format!(" {numbers}") };
        let _ = writeln!(out, "element {} from {} to {} {released}{numbers}", edge.name, name(a), name(b));
    }
    for (name, vertex) in &structure.nodes {
        let _ = writeln!(out, "node {name} at {}", numbers(structure.at_home(*vertex).as_slice()));
    }
    if !structure.masses.is_empty() || !shown.is_empty() {
        let _ = writeln!(out, "gravity {}", numbers(structure.gravity.as_slice()));
    }
}

fn limits(limits: Option<[f64; 2]>) -> String {
    limits.map_or("no limits".into(), |limits| numbers(&limits))
}

/// Seven digits, and zero below `least`.
fn digits(values: &[f64], least: f64) -> String {
    let shown = |v: &f64| if v.abs() <= least { "0".into() } else { format!("{v:.6e}") };
    values.iter().map(shown).collect::<Vec<_>>().join(" ")
}

/// Six decimals, without a negative zero.
fn numbers(values: &[f64]) -> String {
    let shown: Vec<String> = values.iter().map(|v| format!("{:.6}", if v.abs() < 5e-7 { 0.0 } else { *v })).collect();
    shown.join(" ")
}
