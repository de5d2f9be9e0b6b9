//! A robot in words and numbers: what `check` prints.

use std::fmt::Write;

use serde_json::{Value, json};

use super::table::Screen;
use crate::description::raw::{JointKind, RawAmount, RawEffect, RawRobot};
use crate::description::robot::Motion;
use crate::model::{Model, Stage};
use crate::parameter::{Group, Kind, Parameter};
use crate::results::units::unit;

fn motion(model: &Model, index: usize) -> String {
    let frame = &model.frames[index];
    match frame.motion {
        Motion::Fixed => "fixed".into(),
        Motion::Variable { index, direction } => {
            format!("{}{}", if direction < 0.0 { "-" } else { "" }, model.variables[index].name)
        }
        Motion::Actuator(which) => {
            let actuator = &model.actuators[which];
            format!("{} ({})", actuator.name, model.variables[actuator.variable].name)
        }
        Motion::Coupling(which) => {
            let terms: Vec<String> = model.couplings[which]
                .iter()
                .map(|(factor, joint)| format!("{factor} * {}", model.frames[*joint].name))
                .collect();
            terms.join(" + ")
        }
        Motion::Passive => "passive".into(),
    }
}

fn elastic(raw: &RawRobot) -> Vec<(&'static str, Vec<String>)> {
    let keys = |names: Vec<&String>| names.into_iter().cloned().collect::<Vec<_>>();
    vec![
        ("bodies with mass", keys(raw.bodies.keys().collect())),
        ("beams", keys(raw.beams.keys().collect())),
        ("joint stiffness", keys(raw.joint_stiffness.keys().collect())),
        ("springs", keys(raw.springs.keys().collect())),
        ("effects switched on", raw.effects.iter().filter_map(|e| e.effect.clone()).collect()),
    ]
}

/// An effect with its site and amounts.
fn switched_on(entry: &RawEffect) -> Option<String> {
    let shown = |(name, value): (&String, &RawAmount)| match value {
        RawAmount::Number(value) => format!("{name}={value:e}"),
        RawAmount::Name(value) => format!("{name}={value}"),
    };
    let amounts: Vec<String> = entry.parameters.iter().map(shown).collect();
    let site = entry.site.as_ref().map_or(String::new(), |site| format!("@{site}"));
    Some(format!("{}{site} ({})", entry.effect.as_ref()?, amounts.join(", ")))
}

/// Row of a spring that gives; none of other parameters and of what is rigid.
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

/// What `check` prints.
pub fn text(model: &Model, raw: &RawRobot, screen: Screen) -> String {
    let mut out =
        format!("{}: {} degrees of freedom, {} frames\n\n", model.name, model.variables.len(), model.frames.len() - 1);
    let variable_row = |variable: &crate::description::robot::Variable| {
        let (name, factor) =
            unit(if variable.is_angle { crate::parameter::Kind::Angle } else { crate::parameter::Kind::Length });
        let limits = variable
            .limits
            .map_or("none".into(), |[low, high]| format!("{:.2} .. {:.2} {name}", low / factor, high / factor));
        vec![variable.name.clone(), limits]
    };
    out += &screen.table(&["variable", "limits"], model.variables.iter().map(variable_row));
    out += "\n";
    let value = |index: usize, k: usize| {
        let parameter = &model.registry[model.frames[index].slots[k]];
        let value = parameter.nominal / unit(parameter.kind).1;
        if value == 0.0 { "0".into() } else { format!("{value:.3}") }
    };
    out += &screen.table(
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
        (1..model.frames.len()).map(|index| {
            let frame = &model.frames[index];
            let joint = match frame.joint {
                JointKind::Revolute => "revolute",
                JointKind::Prismatic => "prismatic",
                JointKind::Fixed => "fixed",
            };
            let mut row = vec![
                frame.name.clone(),
                model.frames[frame.antecedent].name.clone(),
                joint.into(),
                motion(model, index),
            ];
            row.extend((0..7).map(|k| value(index, k)));
            row
        }),
    );
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
    let _ = writeln!(out, "\ntool: frame {}", model.frames[model.tool.0].name);
    if !model.markers.is_empty() {
        let names: Vec<&str> = model.markers.iter().map(|marker| marker.name.as_str()).collect();
        let _ = writeln!(out, "markers: {}", names.join(", "));
    }
    let _ = writeln!(out, "free in calibration ({}): {}", free.len(), free.join(" "));
    let springs: Vec<Vec<String>> = model.registry.all().iter().filter_map(spring).collect();
    if !springs.is_empty() {
        out += "\n";
        out += &screen.table(&["spring", "stiffness", "unit", "compliance", "unit"], springs);
        out += "\n";
    }
    for (what, names) in elastic(raw).into_iter().filter(|(what, names)| !names.is_empty() && !what.contains("effects"))
    {
        let _ = writeln!(out, "{what}: {}", names.join(" "));
    }
    let effects: Vec<String> = raw.effects.iter().filter_map(switched_on).collect();
    if !effects.is_empty() {
        let _ = writeln!(out, "effects switched on: {}", effects.join("; "));
    }
    if let Some(fuzzy) = &raw.fuzzy {
        let rules = fuzzy.components.iter().map(|(name, component)| format!("{name} {}", component.conclusions.len()));
        let _ = writeln!(
            out,
            "compliance by rules of {} {}: inputs {}; rules of each component: {}",
            fuzzy.at.as_deref().map_or("the tool centre point".into(), |marker| format!("marker {marker}")),
            if fuzzy.adds { "(added to springs and beams)" } else { "(in place of springs and beams)" },
            fuzzy.inputs.join(" "),
            rules.collect::<Vec<_>>().join(", ")
        );
    }
    out
}

/// The same as JSON, SI.
pub fn json(model: &Model, raw: &RawRobot) -> Value {
    let frames: Vec<Value> = (1..model.frames.len())
        .map(|index| {
            let frame = &model.frames[index];
            let constants: serde_json::Map<String, Value> = crate::description::robot::FRAME_SYMBOLS
                .iter()
                .zip(frame.slots)
                .map(|(symbol, slot)| ((*symbol).to_string(), json!(model.registry[slot].nominal)))
                .collect();
            json!({"name": frame.name, "antecedent": model.frames[frame.antecedent].name, "joint": frame.joint,
                   "moved_by": motion(model, index), "constants": constants})
        })
        .collect();
    let variables: Vec<Value> = model
        .variables
        .iter()
        .map(|v| json!({"name": v.name, "unit": if v.is_angle { "rad" } else { "m" }, "limits": v.limits}))
        .collect();
    let loops: Vec<&str> = model
        .stages
        .iter()
        .filter_map(|s| if let Stage::Loops(g) = s { Some(&g.loops) } else { None })
        .flatten()
        .map(|l| l.name.as_str())
        .collect();
    let parameter = |p: &Parameter| json!({"name": p.name, "unit": if p.kind == crate::parameter::Kind::Angle { "rad" } else { "m" }, "nominal": p.nominal, "free": p.free, "tolerance": p.tolerance});
    let elastic: serde_json::Map<String, Value> =
        elastic(raw).into_iter().map(|(what, names)| (what.replace(' ', "_"), json!(names))).collect();
    let fuzzy = raw.fuzzy.as_ref().map(|fuzzy| {
        let rules = |(name, component): (&String, &crate::description::raw::RawFuzzyComponent)| {
            (name.clone(), json!(component.conclusions.len()))
        };
        let rules: serde_json::Map<String, Value> = fuzzy.components.iter().map(rules).collect();
        json!({"inputs": fuzzy.inputs, "at": fuzzy.at, "adds": fuzzy.adds, "rules": rules})
    });
    let mut told = json!({"robot": model.name, "degrees_of_freedom": model.variables.len(), "variables": variables, "frames": frames, "loops": loops,
           "tool": model.frames[model.tool.0].name, "markers": model.markers.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(),
           "parameters": model.registry.all().iter().map(parameter).collect::<Vec<_>>(), "elastic": elastic});
    if let Some(fuzzy) = fuzzy {
        told["fuzzy"] = fuzzy;
    }
    told
}
