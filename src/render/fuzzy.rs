//! Fuzzy compliances as text.

use std::fmt::Write;

use super::identification::errors;
use super::table::Screen;
use crate::math::extremes;
use crate::results::units::{shown, shown_unit};
use crate::results::{
    AfterFit, ComponentRules, Condition, FuzzyCompliance, GreyCompliance, GrowthStep, LoadLevel, LocalSpringsFound,
    MethodComparison, RuleInput,
};

/// Root mean square errors of the fitted readings and of those held out; 0 of none.
fn rms(after: &AfterFit) -> [f64; 2] {
    [&after.after, &after.check_after].map(|errors| errors.as_ref().map_or(0.0, |errors| errors.rms))
}

/// Most rules of a component that text lists; more stand in the JSON and in what is saved.
const LISTED: usize = 12;

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
        // Of a tree the beginning and the end: it grows by one rule a step.
        let ends = [group.first(), group.last()].into_iter().flatten();
        let shown: Vec<&GrowthStep> = if first.sets.is_empty() { ends.collect() } else { group.iter().collect() };
        let own = shown.into_iter().map(|step| {
            let of = match &step.component {
                Some(component) if first.components.len() > 1 => format!("{component} "),
                _ => String::new(),
            };
            let sets = if step.sets.contains(&0) { "none".into() } else { sets(step) };
            format!("{of}{sets} {:.4}", step.test)
        });
        let steps = own.collect::<Vec<_>>().join("  ->  ");
        let unit = if first.of_rotations { " mrad" } else { "" };
        let _ = match first.components.join(" and ") {
            none if none.is_empty() => writeln!(out, "  {steps}"),
            all => writeln!(out, "  {all}: {steps}{unit}"),
        };
    }
    out
}

fn sets(step: &GrowthStep) -> String {
    if step.sets.is_empty() {
        return format!("{} {}", step.rules, if step.rules == 1 { "rule" } else { "rules" });
    }
    step.sets.iter().map(ToString::to_string).collect::<Vec<_>>().join("x")
}

/// The step at hand, for a progress bar.
pub fn step(step: &GrowthStep) -> String {
    format!("rules for {}: {}, cross-validated error {:.4} mm", step.components.join(" and "), sets(step), step.test)
}

fn rules(found: &FuzzyCompliance, screen: Screen) -> String {
    let mut out = String::from("sets of each input or rules, and the error of configurations left out in turns, mm:\n");
    out += &growth(&found.steps);
    if let Some(frame) = &found.axes {
        let _ = writeln!(out, "components along the axes of frame {frame}, which turn with it");
    }
    for component in &found.components {
        out += "\n";
        out += &component_rules(&found.described, component, screen);
    }
    out += "\n";
    out += &inputs(&found.described);
    if found.outside > 0 {
        let _ = writeln!(out, "{} of the readings held out are outside that range", found.outside);
    }
    out
}

/// Where inputs were measured.
fn inputs(described: &[RuleInput]) -> String {
    let mut out = String::new();
    for input in described.iter().filter(|input| input.range.is_some()) {
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
    out
}

/// A condition in words.
fn condition(described: &[RuleInput], condition: &Condition) -> String {
    let (input, is_angle) = match condition {
        Condition::About(input, _) | Condition::Towards(input, ..) => {
            described.get(*input).map_or(("", false), |of| (of.name.as_str(), of.is_angle))
        }
    };
    let (at, unit) = (|value: f64| shown(value, is_angle), shown_unit(is_angle));
    match *condition {
        Condition::About(_, mode) => format!("{input} is about {:.2} {unit}", at(mode)),
        Condition::Towards(_, [from, to], upper) => {
            let end = if upper { "high" } else { "low" };
            format!("{input} is {end} in {:.2} .. {:.2} {unit}", at(from), at(to))
        }
    }
}

fn component_rules(described: &[RuleInput], component: &ComponentRules, screen: Screen) -> String {
    let (unit, per_si) = component.shown_in;
    let conclusion = format!("{} {unit}", component.name);
    if component.conclusions.len() > LISTED {
        let values = component.conclusions.iter().map(|value| per_si * value);
        let [low, high] = extremes(values);
        return format!(
            "{conclusion}: {} rules, conclusions from {low:.4} to {high:.4} (all of them: --format json, --save)\n",
            component.conclusions.len()
        );
    }
    let rows = component.premises.iter().enumerate().map(|(rule, conditions)| {
        let about: Vec<String> = conditions.iter().map(|of| condition(described, of)).collect();
        let data =
            if component.unseen.contains(&rule) { "none".into() } else { format!("{:.1}", component.support[rule]) };
        let about = if about.is_empty() { "always".into() } else { about.join(" and ") };
        let value = per_si * component.conclusions[rule];
        let value = if value.abs() < 1e5 { format!("{value:.4}") } else { format!("{value:.4e}") };
        vec![(rule + 1).to_string(), about, value, data]
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

/// Text of `identify --what local`.
pub fn local(found: &LocalSpringsFound, screen: Screen) -> String {
    let [fit, check] = rms(&found.parametric);
    let mut out = format!(
        "springs alone: rms error {fit:.4} mm on the fitted readings, {check:.4} mm on those held out\n\
         rules between local springs, and the error of configurations left out in turns, mm:\n{}",
        growth(&found.steps)
    );
    if !found.kept {
        out +=
            "not kept: springs that differ by configuration do not help configurations that they were not fitted to\n";
        return out;
    }
    let [fit, check] = rms(&found.residuals);
    let _ = writeln!(out, "kept: with them {fit:.4} mm on the fitted readings, {check:.4} mm on those held out");
    for spring in &found.springs {
        out += "\n";
        out += &component_rules(&found.described, spring, screen);
    }
    out += "\n";
    out += &levels(&found.levels);
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
