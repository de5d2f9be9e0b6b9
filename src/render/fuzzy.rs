//! Fuzzy compliances as text.

use std::fmt::Write;

use super::identification::errors;
use super::table::Screen;
use crate::results::units::{shown, shown_unit};
use crate::results::{
    AfterFit, ComponentRules, FuzzyCompliance, GreyCompliance, GrowthStep, LoadLevel, MethodComparison,
};

/// Root mean square errors of the fitted readings and of those held out; 0 of none.
fn rms(after: &AfterFit) -> [f64; 2] {
    [&after.after, &after.check_after].map(|errors| errors.as_ref().map_or(0.0, |errors| errors.rms))
}

/// Modal values of each rule, in the order of rules.
fn premises(modes: &[Vec<f64>]) -> Vec<Vec<f64>> {
    modes.iter().fold(vec![Vec::new()], |rules, own| {
        rules.iter().flat_map(|rule| own.iter().map(move |mode| [&rule[..], &[*mode]].concat())).collect()
    })
}

/// Text of `identify --what fuzzy`.
pub fn fuzzy(found: &FuzzyCompliance, screen: Screen) -> String {
    let [fit, check] = rms(&found.residuals);
    let mut out = format!(
        "fuzzy compliance: rms error {fit:.4} mm on the fitted readings, {check:.4} mm on those held out\n\
         (a rigid robot: {:.4} and {:.4} mm)\n\n",
        found.rigid.fit, found.rigid.check
    );
    out += &errors(&[("fit", &found.residuals.after), ("check", &found.residuals.check_after)], screen);
    out += "\n";
    out += &rules(found, screen);
    out += &levels(&found.levels);
    out
}

/// Sets of each input and error, for each step; a line for what is fitted together.
fn growth(steps: &[GrowthStep]) -> String {
    let mut out = String::new();
    for group in steps.chunk_by(|a, b| a.components == b.components) {
        let Some(first) = group.first() else { continue };
        let own = group.iter().map(|step| {
            let of = match &step.component {
                Some(component) if first.components.len() > 1 => format!("{component} "),
                _ => String::new(),
            };
            let sets = if step.sets.contains(&0) { "none".into() } else { sets(step) };
            format!("{of}{sets} {:.4}", step.test)
        });
        let _ = writeln!(out, "  {}: {}", first.components.join(" and "), own.collect::<Vec<_>>().join("  ->  "));
    }
    out
}

fn sets(step: &GrowthStep) -> String {
    step.sets.iter().map(ToString::to_string).collect::<Vec<_>>().join("x")
}

/// The step at hand, for a progress bar.
pub fn step(step: &GrowthStep) -> String {
    format!("rules for {}: {} sets, test error {:.4} mm", step.components.join(" and "), sets(step), step.test)
}

fn rules(found: &FuzzyCompliance, screen: Screen) -> String {
    let mut out = format!("sets of each input, test error in mm:\n{}", growth(&found.steps));
    for component in &found.components {
        out += "\n";
        out += &component_rules(found, component, screen);
    }
    out += "\n";
    for input in &found.described {
        let at = |value: f64| shown(value, input.is_angle);
        let range = input.range.map_or("-".into(), |[low, high]| format!("{:.2} to {:.2}", at(low), at(high)));
        let limits =
            input.limits.map_or(String::new(), |[low, high]| format!(" (limits {:.1} to {:.1})", at(low), at(high)));
        let _ = writeln!(
            out,
            "measured for {} from {range} {}{limits}; outside, the outermost rules hold",
            input.name,
            shown_unit(input.is_angle)
        );
    }
    if found.outside > 0 {
        let _ = writeln!(out, "{} of the readings held out are outside that range", found.outside);
    }
    out
}

fn component_rules(found: &FuzzyCompliance, component: &ComponentRules, screen: Screen) -> String {
    let conclusion = format!("{} mm/kN", component.name);
    let rows = premises(&component.modes).into_iter().enumerate().map(|(rule, modes)| {
        let sets = modes.iter().zip(&found.described).zip(&component.modes).filter(|(_, sets)| sets.len() > 1);
        let about: Vec<String> = sets
            .map(|((mode, input), _)| {
                format!("{} is about {:.2} {}", input.name, shown(*mode, input.is_angle), shown_unit(input.is_angle))
            })
            .collect();
        let data =
            if component.unseen.contains(&rule) { "none".into() } else { format!("{:.1}", component.support[rule]) };
        let about = if about.is_empty() { "always".into() } else { about.join(" and ") };
        vec![(rule + 1).to_string(), about, format!("{:.4}", 1e6 * component.conclusions[rule]), data]
    });
    let mut out = screen.table(&["rule", "if", &conclusion, "data"], rows);
    if !component.unseen.is_empty() {
        let rules: Vec<String> = component.unseen.iter().map(|rule| (rule + 1).to_string()).collect();
        let _ = writeln!(
            out,
            "no data reach rules {} of {}: their conclusions are those of their neighbours",
            rules.join(", "),
            component.name
        );
    }
    out
}

fn levels(levels: &[LoadLevel]) -> String {
    let mut out = String::new();
    for level in levels {
        let bent = match level.linear {
            Some(linear) if level.is_bent => format!(
                "; {:.3} +- {:.3} next to loads of other sizes in the same directions: NOT linear in the load",
                linear.gain, linear.ci95
            ),
            _ => String::new(),
        };
        let _ = writeln!(
            out,
            "at {:.0} N: {} readings, measured {:.3} +- {:.3} times what is predicted{bent}",
            level.force, level.readings, level.gain, level.ci95
        );
    }
    if levels.iter().all(|level| level.linear.is_none()) {
        out += "no direction was loaded by several sizes: whether the arm is linear in the load is not tested\n";
    }
    out
}

/// Text of `identify --what grey`.
pub fn grey(found: &GreyCompliance, screen: Screen) -> String {
    let [fit, check] = rms(&found.parametric);
    let mut out = format!(
        "springs alone: rms error {fit:.4} mm on the fitted readings, {check:.4} mm on those held out\n\
         correction, over parts of the fitted readings left out in turns: {:.4} -> {:.4} mm\n",
        found.cross_validated.without, found.cross_validated.with
    );
    match &found.correction {
        Some(correction) => {
            let [fit, check] = rms(&correction.residuals);
            let _ =
                writeln!(out, "kept: with it {fit:.4} mm on the fitted readings, {check:.4} mm on those held out\n");
            out += &rules(correction, screen);
            out += &levels(&correction.levels);
        }
        None => out += "not kept: it does not help readings that it has not seen\n",
    }
    out
}

/// Methods by load.
pub fn methods(found: &MethodComparison, screen: Screen) -> String {
    let which = if found.check { "readings held out" } else { "fitted readings; none were held out" };
    let rows = found.methods.iter().flat_map(|method| {
        method.rows.iter().map(|row| {
            let load = row.load.map_or("all".into(), |size| size.to_string());
            let mut cells = vec![method.method.to_string(), load, row.readings.to_string()];
            cells.extend([row.rms, row.max, row.max_x, row.max_y, row.max_z].map(|v| format!("{v:.4}")));
            cells
        })
    });
    let header = ["method", "load N", "readings", "rms mm", "max mm", "max x mm", "max y mm", "max z mm"];
    format!("{which}\n\n{}", screen.table(&header, rows))
}
