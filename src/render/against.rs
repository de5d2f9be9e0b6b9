//! The identified parameters compared with another set, as text.

use super::table::{Screen, number};
use crate::results::{AgainstOther, Before, Difference, FitOrCheck, SetErrors};

/// Text of `identify --against`: errors with both sets, then the parameters that both have.
pub fn compared(found: &AgainstOther, screen: Screen) -> String {
    let which = match found.judged_by {
        FitOrCheck::Check => "readings the fit did not see",
        FitOrCheck::Fit => "the fitted readings",
    };
    let (before, anew) = match found.before_is {
        Before::Measured => ("as measured", ""),
        Before::Registration => ("registration only", "; base and tool fitted anew for both"),
    };
    let other = found.description.as_str();
    let sets = [&found.before, &found.other, &found.identified];
    let row = |(what, values): (String, [f64; 3])| {
        let factor = |after: f64| if after > 0.0 { format!("{:.1}", values[0] / after) } else { String::new() };
        let shown = values.map(|value| format!("{value:.4}"));
        [what].into_iter().chain(shown).chain([factor(values[1]), factor(values[2])]).collect::<Vec<String>>()
    };
    let header = ["residuals", before, other, "identified", "better by", "identified by"];
    let mut out = format!("\nagainst {other} ({which}{anew})\n");
    out += &screen.table(&header, errors(sets).into_iter().map(row));
    let closer = &found.closer;
    out += &format!(
        "the identified set is closer in {} of {} configurations (chance {:.2} were both as good)\n",
        closer.identified_closer, closer.configurations, closer.chance
    );
    if !found.parameters.is_empty() {
        let header = ["parameter", "unit", other, "identified", "difference", "95 % +-", ""];
        out += &screen.table(&header, found.parameters.iter().map(parameter));
    }
    if !found.alone.is_empty() {
        out += &format!("not in {other}: {}\n", found.alone.join(", "));
    }
    out
}

/// What is compared, and its value with each of the sets.
fn errors(sets: [&SetErrors; 3]) -> Vec<(String, [f64; 3])> {
    let mut rows: Vec<(String, [f64; 3])> = Vec::new();
    let mut of = |what: String, value: &dyn Fn(&SetErrors) -> Option<f64>| {
        if let [Some(before), Some(other), Some(identified)] = sets.map(value) {
            rows.push((what, [before, other, identified]));
        }
    };
    for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
        of(format!("{axis} rms mm"), &|set| Some(set.directions.get(k)?.rms));
        of(format!("{axis} max mm"), &|set| Some(set.directions.get(k)?.max));
    }
    // Of angles or torques alone there are no lengths.
    let has_lengths = sets.iter().any(|set| set.errors.max > 0.0);
    of("mean mm".into(), &|set| has_lengths.then_some(set.errors.mean));
    of("rms mm".into(), &|set| has_lengths.then_some(set.errors.rms));
    of("max mm".into(), &|set| has_lengths.then_some(set.errors.max));
    of("orientation rms deg".into(), &|set| Some(set.errors.orientation?.rms));
    of("orientation max deg".into(), &|set| Some(set.errors.orientation?.max));
    of("torque rms N.m".into(), &|set| Some(set.errors.load?.rms));
    of("torque max N.m".into(), &|set| Some(set.errors.load?.max));
    for (k, part) in sets[2].parts.iter().enumerate() {
        let rms = |set: &SetErrors| Some(set.parts.get(k).filter(|_| has_lengths)?.errors.rms);
        of(format!("{} {}: rms mm", part.part, part.name), &rms);
    }
    rows
}

fn parameter(p: &Difference) -> Vec<String> {
    let shown = |value: f64| number(p.unit, value);
    let flag = if p.differs { "differs" } else { "" };
    let numbers = [p.other, p.identified, p.difference, p.ci95].map(shown);
    [p.name.clone(), p.unit.into()].into_iter().chain(numbers).chain([flag.into()]).collect()
}
