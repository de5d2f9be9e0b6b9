//! A robot over time as text.

use std::fmt::Write;

use super::table::{Screen, number};
use crate::results::{Track, TrackedChange, TrackedCheck, TrackedNext};

/// Most parameters listed of the next check.
const NEXT: usize = 8;

/// Text of `track`.
pub fn track(found: &Track, screen: Screen) -> String {
    let mut out = format!("{}\n\n{}\n\n", found.robot, found.answer);
    let header = ["check", "date", "poses", "T2", "limit", "base", "tool", "held out mm", "shows"];
    let has_dates = found.checks.iter().any(|check| check.date.is_some());
    let drop = |cells: Vec<String>| -> Vec<String> {
        cells.into_iter().enumerate().filter(|(k, _)| *k != 1 || has_dates).map(|(_, cell)| cell).collect()
    };
    let kept: Vec<&str> =
        header.into_iter().enumerate().filter(|(k, _)| *k != 1 || has_dates).map(|(_, h)| h).collect();
    out += &screen.table(&kept, found.checks.iter().map(|check| drop(row(check))));
    let _ = writeln!(
        out,
        "\ncompared with {} and the checks since the last change; at most {:.0} % of a year of {:.0} checks of a robot that\nstands still raise any alarm\n",
        found.reference,
        100.0 * found.level,
        found.checks_a_year
    );
    let _ = writeln!(out, "{}\n", found.own_weight.of_readings());
    for check in &found.checks {
        out += &event(check, screen);
    }
    out + &next(found, screen)
}

fn row(check: &TrackedCheck) -> Vec<String> {
    let some = |value: Option<f64>, digits: usize| value.map_or("-".into(), |value| format!("{value:.digits$}"));
    let moved = |moved: Option<bool>| match moved {
        None => "-",
        Some(true) => "moved",
        Some(false) => "as before",
    };
    let shows = check.event.as_ref().map_or(String::new(), |event| match &event.part_of {
        Some(_) => format!("{}, part of growth", event.kind),
        None => event.kind.to_string(),
    });
    vec![
        check.name.clone(),
        check.date.clone().unwrap_or_default(),
        check.poses.to_string(),
        some(check.statistic, 1),
        some(check.limit, 1),
        moved(check.base_moved).into(),
        moved(check.tool_moved).into(),
        some(check.check_rms, 4),
        shows,
    ]
}

/// What a check shows, in full.
fn event(check: &TrackedCheck, screen: Screen) -> String {
    let Some(event) = &check.event else { return String::new() };
    let mut out = format!("{} ({}, since {}): {}\n", check.name, event.kind, event.since, event.words);
    let row = |change: &TrackedChange| {
        let unit = change.per.map_or(change.unit.to_string(), |per| format!("{}/{per}", change.unit));
        vec![change.name.clone(), unit, number(change.unit, change.change), number(change.unit, change.ci95)]
    };
    if !event.changes.is_empty() {
        out += &screen.table(&["parameter", "unit", "change", "95 % +-"], event.changes.iter().map(row));
    }
    if !event.indistinguishable_from.is_empty() {
        let _ = writeln!(out, "nearly as well explained by {} alone", event.indistinguishable_from.join(", "));
    }
    if let Some(diagnosis) = &event.diagnosis {
        let _ = writeln!(out, "diagnose: {diagnosis}");
    }
    out + "\n"
}

fn next(found: &Track, screen: Screen) -> String {
    let mut hardest: Vec<&TrackedNext> = found.next.iter().collect();
    hardest.sort_by_key(|next| std::cmp::Reverse(next.poses.unwrap_or(usize::MAX)));
    let Some(most) = hardest.first() else { return String::new() };
    let power = 100.0 * found.power;
    let mut out = match most.poses {
        Some(poses) => {
            format!("next check: {poses} poses like the last ones show each of these changes with {power:.0} %\n")
        }
        None => format!(
            "next check: not all of these changes can be shown with {power:.0} %: the checks before are not certain enough\n"
        ),
    };
    let more = hardest.len().saturating_sub(NEXT);
    let row = |next: &TrackedNext| {
        let poses = next.poses.map_or("-".into(), |poses| poses.to_string());
        vec![next.name.clone(), next.unit.to_string(), number(next.unit, next.change), poses]
    };
    out += &screen.table(&["parameter", "unit", "change", "poses"], hardest.into_iter().take(NEXT).map(row));
    if more > 0 {
        let _ = writeln!(out, "and {more} that need fewer");
    }
    out
}
