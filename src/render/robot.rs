//! A robot as text. Lengths in mm, angles in deg, springs in SI.

use std::fmt::Write;

use indexmap::IndexMap;

use super::table::Screen;
use crate::description::raw::{JointKind, RawAmount, RawEffect, RawRobot};
use crate::description::robot::Variable;
use crate::model::{Model, Stage};
use crate::parameter::{Group, Kind, Parameter};
use crate::results::units::{shown, shown_unit, unit};
use crate::results::{BodySummary, RobotSummary};

/// An effect with its site and amounts.
fn switched_on(entry: &RawEffect) -> Option<String> {
    let shown = |(name, value): (&String, &RawAmount)| match value {
        RawAmount::Number(value) => format!("{name}={value:e}"),
        RawAmount::Name(_) | RawAmount::Numbers(_) => format!("{name}={value}"),
    };
    let amounts: Vec<String> = entry.parameters.iter().map(shown).collect();
    let site = entry.site.as_ref().map_or(String::new(), |site| format!("@{site}"));
    Some(format!("{}{site} ({})", entry.effect.as_ref()?, amounts.join(", ")))
}

/// Row of a compliant spring; `None` for other parameters and of what is rigid.
fn spring(parameter: &Parameter) -> Option<Vec<String>> {
    let value = parameter.nominal;
    let (stiffness, compliance, kind) = match parameter.kind {
        Kind::LinearCompliance | Kind::RotationalCompliance => (1.0 / value, value, parameter.kind),
        Kind::LinearStiffness | Kind::RotationalStiffness => (value, 1.0 / value, parameter.kind.inverse()),
        _ => return None,
    };
    (parameter.group == Group::Elastic && compliance > 0.0 && compliance.is_finite()).then(|| {
        vec![
            parameter.name.clone(),
            format!("{stiffness:.4e}"),
            kind.inverse().unit().into(),
            format!("{compliance:.4e}"),
            kind.unit().into(),
        ]
    })
}

/// Text of `check`.
pub fn robot(found: &RobotSummary, model: &Model, raw: &RawRobot, screen: Screen) -> String {
    let (freedoms, frames) = (found.degrees_of_freedom, found.frames.len());
    let mut out = format!("{}: {freedoms} degrees of freedom, {frames} frames\n\n", found.robot);
    let variable_row = |variable: &Variable| {
        let at = |value: f64| shown(value, variable.is_angle);
        let unit = shown_unit(variable.is_angle);
        let limits =
            variable.limits.map_or("none".into(), |[low, high]| format!("{:.2} .. {:.2} {unit}", at(low), at(high)));
        vec![variable.name.clone(), limits]
    };
    let other = found.other_limits.iter().map(|of| {
        let (name, limits) = (format!("({})", of.name), of.limits);
        variable_row(&Variable { name, is_angle: of.unit == "rad", limits, gear_ratio: None })
    });
    out += &screen.table(&["variable", "limits"], model.variables.iter().map(variable_row).chain(other));
    out += "\n";
    out += &frames_table(found, model, screen);
    for stage in &model.stages {
        if let Stage::Loops(group) = stage {
            for plan in &group.loops {
                let names = |side: usize| {
                    plan.branches[side].iter().map(|&i| model.frames[i].name.as_str()).collect::<Vec<_>>().join(" ")
                };
                let _ = writeln!(out, "\nloop {}: {:?}, branches {} | {}", plan.name, plan.kind, names(0), names(1));
            }
        }
    }
    let free: Vec<&str> = model.free_slots().iter().map(|&slot| model.registry[slot].name.as_str()).collect();
    let _ = writeln!(out, "\ntool: frame {}{}", found.tool, tool_offset(&found.tool_offset));
    out += &gravity(&found.gravity);
    if !found.markers.is_empty() {
        let _ = writeln!(out, "markers: {}", found.markers.join(", "));
    }
    let _ = writeln!(out, "free in calibration ({}): {}", free.len(), free.join(" "));
    out + &elastic(found, model, raw, screen)
}

/// The tool centre point in its frame, as far as it is not the frame itself.
fn tool_offset(offset: &[f64; 6]) -> String {
    let three = |first: usize, factor: f64| [0, 1, 2].map(|k| format!("{:.3}", offset[first + k] * factor)).join(", ");
    let mut out = String::new();
    if offset[..3].iter().any(|value| *value != 0.0) {
        let _ = write!(out, ", centre point at {} mm", three(0, 1e3));
    }
    if offset[3..].iter().any(|value| *value != 0.0) {
        let _ = write!(out, ", axes turned by {} deg", three(3, 1f64.to_degrees()));
    }
    out
}

/// Gravity in base axes, with its direction in words where it is along one of them.
fn gravity(acceleration: &[f64; 3]) -> String {
    if acceleration.iter().all(|value| *value == 0.0) {
        return "gravity: none declared, so that masses weigh nothing\n".into();
    }
    let [x, y, z] = acceleration;
    format!("gravity: {x:.3}, {y:.3}, {z:.3} m/s2 in base axes\n")
}

/// Frames with what moves them and their Khalil-Kleinfinger constants.
fn frames_table(found: &RobotSummary, model: &Model, screen: Screen) -> String {
    let value = |index: usize, k: usize| {
        let parameter = &model.registry[model.frames[index].slots[k]];
        let value = parameter.nominal / unit(parameter.kind).1;
        if value == 0.0 { "0".into() } else { format!("{value:.3}") }
    };
    screen.table(
        &[
            "frame",
            "in",
            "joint",
            "moved by",
            "beta deg",
            "gamma deg",
            "b mm",
            "alpha deg",
            "d mm",
            "theta deg",
            "r mm",
        ],
        found.frames.iter().enumerate().map(|(k, frame)| {
            let joint = match frame.joint {
                JointKind::Revolute => "revolute",
                JointKind::Prismatic => "prismatic",
                JointKind::Fixed => "fixed",
            };
            let mut row = vec![frame.name.clone(), frame.antecedent.clone(), joint.into(), frame.moved_by.clone()];
            row.extend((0..7).map(|constant| value(k + 1, constant)));
            row
        }),
    )
}

/// What is elastic, and the effects that are switched on.
fn elastic(found: &RobotSummary, model: &Model, raw: &RawRobot, screen: Screen) -> String {
    let mut out = String::new();
    let springs: Vec<Vec<String>> = model.registry.all().iter().filter_map(spring).collect();
    if !springs.is_empty() {
        out += "\n";
        out += &screen.table(&["spring", "stiffness", "unit", "compliance", "unit"], springs);
        out += "\n";
    }
    let elastic = &found.elastic;
    if !elastic.masses.is_empty() {
        let row = |(name, body): (&String, &BodySummary)| {
            let at = body.com.map(|value| format!("{:.1}", 1e3 * value));
            let mass = if body.mass.abs() < 1e5 { format!("{:.3}", body.mass) } else { format!("{:.3e}", body.mass) };
            [vec![name.clone(), mass], at.to_vec()].concat()
        };
        out += &screen.table(&["body with mass", "kg", "centre x mm", "y", "z"], elastic.masses.iter().map(row));
        let total: f64 = elastic.masses.values().map(|body| body.mass).sum();
        let _ = writeln!(out, "{total:.3} kg in all");
    }
    let declared =
        [("beams", &elastic.beams), ("joint stiffness", &elastic.joint_stiffness), ("springs", &elastic.springs)];
    for (what, names) in declared.into_iter().filter(|(_, names)| !names.is_empty()) {
        let _ = writeln!(out, "{what}: {}", names.join(" "));
    }
    let effects: Vec<String> = raw.effects.iter().filter_map(switched_on).collect();
    if !effects.is_empty() {
        let _ = writeln!(out, "effects switched on: {}", effects.join("; "));
    }
    if let Some(fuzzy) = &found.fuzzy {
        let counts = |of: &IndexMap<String, usize>| {
            of.iter().map(|(name, count)| format!("{name} {count}")).collect::<Vec<_>>().join(", ")
        };
        if !fuzzy.rules.is_empty() {
            let _ = writeln!(
                out,
                "fuzzy compliance of {} {}{}: inputs {}; rules of each component: {}",
                fuzzy.at.as_deref().map_or("the tool centre point".into(), |marker| format!("marker {marker}")),
                if fuzzy.adds { "(added to springs and beams)" } else { "(in place of springs and beams)" },
                fuzzy.axes.as_deref().map_or(String::new(), |frame| format!(", axes of {frame}")),
                fuzzy.inputs.join(" "),
                counts(&fuzzy.rules)
            );
        }
        if !fuzzy.springs.is_empty() {
            let inputs = fuzzy.inputs.join(" ");
            let _ = writeln!(out, "fuzzy springs: inputs {inputs}; rules of each: {}", counts(&fuzzy.springs));
        }
    }
    out
}
