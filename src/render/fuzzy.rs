//! Fuzzy compliances in words and in JSON.

use std::fmt::Write;

use serde_json::{Value, json};

use super::identification::{errors_json, errors_table};
use super::table::{Screen, deg, mm};
use crate::description::campaign::Campaign;
use crate::description::fuzzy::{Component, Input};
use crate::estimation::fuzzy::{FuzzyFit, GreyFit, Level, Step};
use crate::math::mean_rms_max;
use crate::math::quantiles::normal95;

/// A value of an input in deg or mm.
pub(super) fn shown(value: f64, angle: bool) -> f64 {
    if angle { deg(value) } else { mm(value) }
}

/// Modal values of each rule, in the order of rules.
fn premises(modes: &[Vec<f64>]) -> Vec<Vec<f64>> {
    modes.iter().fold(vec![Vec::new()], |rules, own| {
        rules.iter().flat_map(|rule| own.iter().map(move |mode| [&rule[..], &[*mode]].concat())).collect()
    })
}

/// Text of `identify --what fuzzy`.
pub fn fuzzy_text(fit: &FuzzyFit, screen: Screen) -> String {
    let mut out = format!(
        "fuzzy compliance: rms error {:.4} mm on the fitted readings, {:.4} mm on those set aside\n\
         (a rigid robot: {:.4} and {:.4} mm)\n\n",
        mm(fit.errors[0].distance[1]),
        mm(fit.errors[1].distance[1]),
        mm(fit.rigid[0]),
        mm(fit.rigid[1])
    );
    out += &errors_table(&[("fit", &fit.errors[0]), ("check", &fit.errors[1])], screen);
    out += "\n";
    out += &rules_text(fit, screen);
    out += &levels_text(&fit.levels);
    out
}

/// Sets of each input and error, for what each step took; a line for what is fitted together.
fn grew(steps: &[Step]) -> String {
    let mut out = String::new();
    for group in steps.chunk_by(|a, b| (a.axis, &a.columns) == (b.axis, &b.columns)) {
        let names: Vec<String> =
            group[0].columns.iter().map(|&column| Component::name([group[0].axis, column])).collect();
        let own = group.iter().map(|step| {
            let sets: Vec<String> = step.sets.iter().map(ToString::to_string).collect();
            let of = match step.column {
                Some(column) if names.len() > 1 => format!("{} ", Component::name([step.axis, column])),
                _ => String::new(),
            };
            let sets = if step.sets.contains(&0) { "none".into() } else { sets.join("x") };
            format!("{of}{sets} {:.4}", mm(step.test))
        });
        let _ = writeln!(out, "  {}: {}", names.join(" and "), own.collect::<Vec<_>>().join("  ->  "));
    }
    out
}

/// What is being done, for a progress bar.
pub fn step_text(step: &Step) -> String {
    let names: Vec<String> = step.columns.iter().map(|&column| Component::name([step.axis, column])).collect();
    let sets: Vec<String> = step.sets.iter().map(ToString::to_string).collect();
    format!("rules for {}: {} sets, test error {:.4} mm", names.join(" and "), sets.join("x"), mm(step.test))
}

fn rules_text(fit: &FuzzyFit, screen: Screen) -> String {
    let (model, grown) = (&fit.model, &fit.grown);
    let Some(fuzzy) = &model.fuzzy else { return String::new() };
    let inputs: Vec<(&str, bool)> = fuzzy.inputs.iter().map(|&of| model.input(of)).collect();
    let mut out = format!("sets of each input, test error in mm:\n{}", grew(&grown.steps));
    for (component, own) in fuzzy.components.iter().zip(&grown.components) {
        out += "\n";
        let conclusion = format!("{} mm/kN", Component::name(component.at));
        let rows = premises(&component.modes).into_iter().enumerate().map(|(rule, modes)| {
            let sets = modes.iter().zip(&inputs).zip(&component.modes).filter(|(_, sets)| sets.len() > 1);
            let about: Vec<String> = sets
                .map(|((mode, (name, angle)), _)| {
                    format!("{name} is about {:.2} {}", shown(*mode, *angle), if *angle { "deg" } else { "mm" })
                })
                .collect();
            let data = if own.unseen.contains(&rule) { "none".into() } else { format!("{:.1}", own.support[rule]) };
            let about = if about.is_empty() { "always".into() } else { about.join(" and ") };
            vec![(rule + 1).to_string(), about, format!("{:.4}", 1e6 * component.conclusions[rule]), data]
        });
        out += &screen.table(&["rule", "if", &conclusion, "data"], rows);
        if !own.unseen.is_empty() {
            let rules: Vec<String> = own.unseen.iter().map(|rule| (rule + 1).to_string()).collect();
            let _ = writeln!(
                out,
                "no data reach rules {} of {}: their conclusions are those of their neighbours",
                rules.join(", "),
                Component::name(component.at)
            );
        }
    }
    out += "\n";
    let used = grown.used();
    for (k, &of) in fuzzy.inputs.iter().enumerate() {
        let (name, angle) = inputs[k];
        let [low, high] = used.get(k).map_or([f64::NAN; 2], |&k| grown.range[k]);
        let limits = match of {
            Input::Variable(k) => model.variables[k].limits,
            Input::Joint(k) => model.frames[k].limits,
        };
        let limits = limits.map_or(String::new(), |[low, high]| {
            format!(" (limits {:.1} to {:.1})", shown(low, angle), shown(high, angle))
        });
        let _ = writeln!(
            out,
            "measured for {name} from {:.2} to {:.2} {}{limits}; outside, the outermost rules hold",
            shown(low, angle),
            shown(high, angle),
            if angle { "deg" } else { "mm" }
        );
    }
    if grown.beyond > 0 {
        let _ = writeln!(out, "{} of the readings set aside are outside that range", grown.beyond);
    }
    out
}

fn levels_text(levels: &[Level]) -> String {
    let mut out = String::new();
    for level in levels {
        let bent = |[gain, sigma]: [f64; 2]| (gain - 1.0).abs() > 3.0 * sigma && (gain - 1.0).abs() > 0.02;
        let _ = writeln!(
            out,
            "at {:.0} N: {} readings, measured {:.3} +- {:.3} times what is predicted{}",
            level.force,
            level.readings,
            level.gain,
            normal95() * level.sigma,
            match level.linear {
                Some(linear) if bent(linear) => format!(
                    "; {:.3} +- {:.3} beside loads of other sizes in the same directions: NOT linear in the load",
                    linear[0],
                    normal95() * linear[1]
                ),
                _ => String::new(),
            }
        );
    }
    if levels.iter().all(|level| level.linear.is_none()) {
        out += "no direction was loaded by several sizes: whether the arm is linear in the load is not tested\n";
    }
    out
}

/// JSON of `identify --what fuzzy`: SI, errors in mm.
pub fn fuzzy_json(fit: &FuzzyFit) -> Value {
    let (model, grown) = (&fit.model, &fit.grown);
    let fuzzy = model.fuzzy.as_ref();
    let inputs: Vec<&str> = fuzzy.iter().flat_map(|f| &f.inputs).map(|&of| model.input(of).0).collect();
    let components: Vec<Value> = fuzzy
        .iter()
        .flat_map(|fuzzy| &fuzzy.components)
        .zip(&grown.components)
        .map(|(c, own)| {
            json!({"name": Component::name(c.at), "modes": c.modes, "conclusions": c.conclusions,
                   "support": own.support, "unseen": own.unseen})
        })
        .collect();
    let steps: Vec<Value> = grown
        .steps
        .iter()
        .map(|s| {
            let names: Vec<String> = s.columns.iter().map(|&column| Component::name([s.axis, column])).collect();
            json!({"components": names, "component": s.column.map(|column| Component::name([s.axis, column])),
                   "sets": s.sets,
                   "fit": s.fitted.map(mm), "test": mm(s.test)})
        })
        .collect();
    let levels: Vec<Value> = fit
        .levels
        .iter()
        .map(|l| {
            json!({"force": l.force, "readings": l.readings, "gain": l.gain, "ci95": normal95() * l.sigma,
                   "linear": l.linear.map(|[gain, sigma]| json!({"gain": gain, "ci95": normal95() * sigma}))})
        })
        .collect();
    let range: Vec<[f64; 2]> = grown.used().into_iter().map(|k| grown.range[k]).collect();
    json!({"inputs": inputs, "components": components, "range": range, "outside": grown.beyond, "steps": steps, "levels": levels, "unit": "mm",
           "rigid": {"fit": mm(fit.rigid[0]), "check": mm(fit.rigid[1])},
           "residuals": {"after": errors_json(&fit.errors[0]), "check_after": errors_json(&fit.errors[1])}})
}

/// Text of `identify --what grey`.
pub fn grey_text(fit: &GreyFit, screen: Screen) -> String {
    let after = &fit.parametric.after;
    let [without, with] = fit.cross_validated.map(mm);
    let mut out = format!(
        "springs alone: rms error {:.4} mm on the fitted readings, {:.4} mm on those set aside\n\
         correction, over parts of the fitted readings left out in turns: {without:.4} -> {with:.4} mm\n",
        mm(after.fit.distance[1]),
        mm(after.check.distance[1])
    );
    match &fit.correction {
        Some(correction) => {
            let _ = writeln!(
                out,
                "kept: with it {:.4} mm on the fitted readings, {:.4} mm on those set aside\n",
                mm(correction.errors[0].distance[1]),
                mm(correction.errors[1].distance[1])
            );
            out += &rules_text(correction, screen);
            out += &levels_text(&correction.levels);
        }
        None => out += "not kept: it does not help readings that it has not seen\n",
    }
    out
}

/// JSON of `identify --what grey`.
pub fn grey_json(fit: &GreyFit) -> Value {
    let after = &fit.parametric.after;
    json!({"parametric": {"after": errors_json(&after.fit), "check_after": errors_json(&after.check)},
           "cross_validated": {"without": mm(fit.cross_validated[0]), "with": mm(fit.cross_validated[1])},
           "kept": fit.correction.is_some(), "correction": fit.correction.as_ref().map(fuzzy_json), "unit": "mm"})
}

/// A fitted model's residuals, three a reading.
pub struct Method {
    /// Name.
    pub name: &'static str,
    /// As [`crate::prediction::Linearised::residual`].
    pub residual: Vec<f64>,
}

/// A row of the table: load (N; none for all), rms and greatest distance, greatest x, y, z, m.
type Row = (Option<i64>, usize, [f64; 5]);

fn rows(campaign: &Campaign, among: &[bool], method: &Method) -> Vec<Row> {
    let force = |k: usize| {
        let w = &campaign.readings[k].wrench;
        w[..3].iter().map(|v| v * v).sum::<f64>().sqrt().round() as i64
    };
    let mut sizes: Vec<i64> = (0..among.len()).filter(|&k| among[k]).map(force).collect();
    sizes.sort_unstable();
    sizes.dedup();
    let row = |size: Option<i64>| {
        let of: Vec<&[f64]> = method
            .residual
            .chunks(3)
            .enumerate()
            .filter(|(k, _)| among[*k] && size.is_none_or(|size| force(*k) == size))
            .map(|(_, r)| r)
            .collect();
        let [_, rms, max] = mean_rms_max(of.iter().map(|r| r.iter().map(|v| v * v).sum::<f64>().sqrt()));
        let axis = |k: usize| of.iter().map(|r| r[k].abs()).fold(0.0, f64::max);
        (size, of.len(), [rms, max, axis(0), axis(1), axis(2)])
    };
    sizes.iter().map(|size| row(Some(*size))).chain([row(None)]).collect()
}

/// Readings set aside, or all where there are none.
fn judged(aside: &[bool]) -> Vec<bool> {
    if aside.iter().any(|aside| *aside) { aside.to_vec() } else { vec![true; aside.len()] }
}

/// Methods by load, as Table 5 of the IR663 calibration paper.
pub fn comparison_text(campaign: &Campaign, aside: &[bool], methods: &[Method], screen: Screen) -> String {
    let among = judged(aside);
    let which = if aside.contains(&true) { "readings set aside" } else { "fitted readings; none were set aside" };
    let mut out = format!("{which}\n\n");
    let all = methods.iter().flat_map(|method| {
        rows(campaign, &among, method).into_iter().map(|(size, readings, figures)| {
            let load = size.map_or("all".into(), |size| size.to_string());
            let mut row = vec![method.name.to_string(), load, readings.to_string()];
            row.extend(figures.iter().map(|v| format!("{:.4}", mm(*v))));
            row
        })
    });
    out +=
        &screen.table(&["method", "load N", "readings", "rms mm", "max mm", "max x mm", "max y mm", "max z mm"], all);
    out
}

/// The same in JSON.
pub fn comparison_json(campaign: &Campaign, aside: &[bool], methods: &[Method]) -> Value {
    let among = judged(aside);
    let one = |method: &Method| {
        let rows: Vec<Value> = rows(campaign, &among, method)
            .into_iter()
            .map(|(size, readings, f)| {
                json!({"load": size, "readings": readings, "rms": mm(f[0]), "max": mm(f[1]),
                       "max_x": mm(f[2]), "max_y": mm(f[3]), "max_z": mm(f[4])})
            })
            .collect();
        json!({"method": method.name, "rows": rows})
    };
    json!({"unit": "mm", "check": aside.contains(&true), "methods": methods.iter().map(one).collect::<Vec<_>>()})
}
