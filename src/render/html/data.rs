//! The data of a report, as `report.json` holds it.

use serde_json::{Map, Value, json};

use super::drawing::Shot;
use crate::description::campaign::Campaign;
use crate::diagnosis::Diagnosis;
use crate::estimation::Calibration;
use crate::model::Model;
use crate::render::diagnosis::diagnosis_json;
use crate::render::identification::calibration_json;
use crate::render::table::mm;
use crate::review::{Readings, Slice, Yielding};
use crate::scene::Scene;

/// Most arrows that are drawn; those left out are said.
const ARROWS: usize = 1500;

/// What a report is written from.
pub struct Report<'a> {
    /// The campaign as it was asked for on the command line, with the flags that go with it.
    pub given: String,
    /// The robot's description as it would be asked for.
    pub robot: String,
    /// The model.
    pub model: &'a Model,
    /// The campaign.
    pub campaign: &'a Campaign,
    /// Readings that the calibration set aside.
    pub aside: &'a [bool],
    /// The calibration and its seconds, or why there is none.
    pub calibration: Result<(Calibration, f64), String>,
    /// The diagnosis.
    pub diagnosis: Diagnosis,
    /// Its seconds.
    pub seconds: f64,
    /// Residuals stage by stage.
    pub readings: Readings,
    /// Stiffness over a slice of the workspace, through the typical configuration.
    pub slice: Option<Slice>,
    /// Shares of elements.
    pub yielding: Option<Yielding>,
    /// The robot as it is drawn.
    pub scene: &'a Scene,
    /// Configurations of the campaign that are drawn, the typical one first.
    pub shots: Vec<Shot>,
    /// Proposed configurations.
    pub next: Vec<Shot>,
}

impl Report<'_> {
    /// By which figures of the calibration it is judged: those of readings set aside, if there are any.
    pub fn judged(&self) -> &'static str {
        match &self.calibration {
            Ok((found, _)) if found.after.check.readings > 0 => "check_",
            _ => "",
        }
    }

    /// Sites of the causes.
    pub fn suspects(&self) -> Vec<String> {
        self.diagnosis.causes.iter().map(|cause| cause.site.clone()).collect()
    }

    /// What a stage is called.
    pub fn stage_label(key: &str) -> &'static str {
        match key {
            "described" => "description as it is",
            "registered" => "base, tool and markers fitted alone",
            "calibrated" => "calibrated (identify)",
            "competed" => "calibrated, what effects compete for (diagnose)",
            _ => "with the effects added (diagnose)",
        }
    }
}

/// The data of a report: what `identify` and `diagnose` print, and what only a report shows.
pub fn report_json(report: &Report) -> Value {
    let (model, campaign) = (report.model, report.campaign);
    let (identify, why) = match &report.calibration {
        Ok((found, seconds)) => (calibration_json(model, campaign, found, *seconds), Value::Null),
        Err(why) => (Value::Null, json!(why)),
    };
    let given = &report.given;
    json!({
        "campaign": {
            "name": campaign.name, "robot": model.name, "observes": campaign.observes.name(),
            "readings": campaign.readings.len(), "poses": poses(campaign),
            "set_aside": report.aside.iter().filter(|aside| **aside).count(),
            "sigma": campaign.sigma.map(|sigma| sigma.map(mm)), "unit": "mm", "calibrate": campaign.calibrate, "without": campaign.without,
            "estimate_base": campaign.estimate_base, "estimate_tool": campaign.estimate_tool,
        },
        "sources": {
            "identify": format!("elastogeo identify {given}"), "diagnose": format!("elastogeo diagnose {given}"),
            "stiffness": format!("elastogeo stiffness {} --joints ..", report.robot),
            "residuals": format!("elastogeo residuals {} {given}", report.robot),
            "report": format!("elastogeo report {given}"),
        },
        "identify": identify,
        "identify_why": why,
        "diagnose": diagnosis_json(model, &report.diagnosis, report.seconds),
        "waterfall": waterfall(report),
        "stages": report.readings.stages.iter()
            .map(|stage| json!({"key": stage.key, "label": Report::stage_label(stage.key)})).collect::<Vec<_>>(),
        "stiffness": {
            "slice": report.slice.as_ref().map(|slice| slice_json(model, slice)),
            "shares": report.yielding.as_ref().map(|y| &y.shares),
            "own_loads": report.yielding.as_ref().map(|y| y.own_loads),
            "readings": report.yielding.as_ref().map(|y| y.readings),
        },
        "readings": rows(report),
    })
}

fn poses(campaign: &Campaign) -> usize {
    let mut poses: Vec<usize> = campaign.readings.iter().map(|reading| reading.pose).collect();
    poses.sort_unstable();
    poses.dedup();
    poses.len()
}

/// Steps from the description as it is down to the noise: rms position errors of readings that the fit did not see where
/// there are such, with what printed them.
fn waterfall(report: &Report) -> Value {
    let mut steps = Vec::new();
    let mut step = |key: &str, label: String, rms: f64, source: &str, on: &str| {
        steps.push(json!({"key": key, "label": label, "rms": mm(rms), "source": source, "on": on}));
    };
    let gap = &report.diagnosis.gap;
    let mut calibrated = f64::INFINITY;
    if let Ok((found, _)) = &report.calibration {
        let unseen = found.after.check.readings > 0;
        let on = if unseen { "readings set aside" } else { "fitted readings" };
        let of = |figures: &crate::estimation::Figures| {
            if unseen { figures.check.distance[1] } else { figures.fit.distance[1] }
        };
        let arranged = report.campaign.estimate_base || report.campaign.estimate_tool;
        step("described", "description as it is".into(), of(&found.before), "identify", on);
        if arranged {
            step("registered", Report::stage_label("registered").into(), of(&found.registration), "identify", on);
        }
        calibrated = of(&found.after);
        step("calibrated", "calibrated".into(), calibrated, "identify", on);
    }
    // The same thing, if both re-fit the same parameters and hold the same readings back.
    if (gap.rms - calibrated).abs() >= 5e-3 * gap.rms {
        let refitted = match (
            report.campaign.calibrate.join(", "),
            report.campaign.estimate_base || report.campaign.estimate_tool,
        ) {
            (list, _) if !list.is_empty() => format!("{list} re-fitted"),
            (_, true) => "base and tool re-fitted".into(),
            _ => "nothing re-fitted".into(),
        };
        step("competed", refitted, gap.rms, "diagnose", "held-out readings");
    }
    for cause in &report.diagnosis.causes {
        step("effect", format!("{} at {}", cause.effect, cause.site), cause.rms_after, "diagnose", "held-out readings");
    }
    step("noise", "noise".into(), gap.noise, "diagnose", "expected");
    json!(steps)
}

fn slice_json(model: &Model, slice: &Slice) -> Value {
    let variable = |k: usize| &model.variables[k];
    let shown = |k: usize, value: f64| if variable(k).is_angle { value.to_degrees() } else { mm(value) };
    let unit = |k: usize| if variable(k).is_angle { "deg" } else { "mm" };
    let nodes: Vec<Value> = slice
        .nodes
        .iter()
        .flatten()
        .flatten()
        .map(|node| {
            json!({"q": [shown(slice.swept[0], node.q[0]), shown(slice.swept[1], node.q[1])], "at": node.at.map(mm), "least": node.least * 1e-3,
                   "ellipse": node.ellipse.map(|axis| axis.map(|v| v * 1e6))})
        })
        .collect();
    json!({"swept": slice.swept.map(|k| json!({"name": variable(k).name, "unit": unit(k)})),
           "units": {"at": "mm", "least": "N/mm", "ellipse": "mm/kN"}, "nodes": nodes})
}

/// Every reading with its residuals at every stage, mm, measurement frame.
fn rows(report: &Report) -> Value {
    let (model, campaign) = (report.model, report.campaign);
    let components = campaign.components();
    let length = |all: &[f64], index: usize| -> Vec<f64> {
        all[index * components..(index + 1) * components].iter().take(3).map(|v| (v * 1e9).round() / 1e6).collect()
    };
    let row = |(index, reading): (usize, &crate::description::campaign::Reading)| {
        let errors: Map<String, Value> = report
            .readings
            .stages
            .iter()
            .map(|stage| (stage.key.into(), json!(length(&stage.residual, index))))
            .collect();
        let joints: Vec<f64> = campaign
            .configuration(index)
            .iter()
            .zip(&model.variables)
            .map(|(q, variable)| if variable.is_angle { q.to_degrees() } else { mm(*q) })
            .collect();
        let mut value = json!({"row": reading.row, "pose": campaign.poses[reading.pose],
            "marker": reading.marker.map(|m| &model.markers[m].name), "set_aside": report.aside[index], "joints": joints,
            "point": report.readings.points[index].map(|v| (v * 1e6).round() / 1e3).as_slice(), "errors": errors});
        if reading.wrench.iter().any(|w| *w != 0.0) {
            value["wrench"] = json!(reading.wrench);
        }
        if !report.readings.pattern.is_empty() {
            value["pattern"] = json!(length(&report.readings.pattern, index));
        }
        let name = |variable: usize| report.model.variables[variable].name.as_str();
        let conditions =
            campaign.conditions.columns().map(|(condition, all)| (condition.column(name), json!(all[index])));
        let conditions: Map<_, _> = conditions.collect();
        if !conditions.is_empty() {
            value["conditions"] = conditions.into();
        }
        value
    };
    json!(campaign.readings.iter().enumerate().map(row).collect::<Vec<_>>())
}

/// Arrows of the view: where, and the error at each stage, mm, base axes; the greatest first where some are left out.
pub fn arrows(report: &Report) -> Value {
    let campaign = report.campaign;
    if campaign.components() < 3 {
        return Value::Null;
    }
    let mut order: Vec<usize> = (0..campaign.readings.len()).collect();
    if order.len() > ARROWS {
        let step = order.len().div_ceil(ARROWS);
        order = order.into_iter().step_by(step).collect();
    }
    let errors: Map<String, Value> = report
        .readings
        .stages
        .iter()
        .map(|stage| {
            let all: Vec<[f64; 3]> = order
                .iter()
                .filter_map(|&index| report.readings.in_base(campaign, stage, index))
                .map(|e| [e.x, e.y, e.z].map(|v| (v * 1e7).round() / 1e4))
                .collect();
            (stage.key.into(), json!(all))
        })
        .collect();
    let points: Vec<[f64; 3]> = order
        .iter()
        .map(|&index| report.readings.points[index])
        .map(|p| [p.x, p.y, p.z].map(|v| (v * 1e5).round() / 1e5))
        .collect();
    json!({"points": points, "rows": order.iter().map(|&i| campaign.readings[i].row).collect::<Vec<_>>(), "errors": errors,
           "of": campaign.readings.len(), "noise": report.diagnosis.gap.noise * 1e3})
}
