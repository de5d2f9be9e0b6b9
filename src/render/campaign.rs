//! A campaign as text, before anything is fitted. Lengths in mm, angles in deg.

use std::fmt::Write;

use super::table::Screen;
use crate::results::{CampaignCheck, JointRange, NoiseFigure};

/// Text of `check` of a campaign.
pub fn campaign(found: &CampaignCheck, screen: Screen) -> String {
    let mut out = format!("{}\n{}, {} readings", found.campaign, found.robot, found.readings);
    let kinds = match found.kinds.len() {
        0 | 1 => found.observes.name().to_string(),
        _ => found.kinds.iter().map(|(name, count)| format!("{name} {count}")).collect::<Vec<_>>().join(", "),
    };
    let _ = writeln!(out, " ({kinds}) at {} configurations", found.configurations);
    let markers: Vec<String> = found.markers.iter().map(|(name, count)| format!("{name} {count}")).collect();
    let _ = writeln!(out, "readings by marker: {}", markers.join(", "));
    let sets = [("fit", found.sets.fit), ("check", found.sets.check), ("unassigned", found.sets.unassigned)];
    let sets: Vec<String> =
        sets.iter().filter(|(_, count)| *count > 0).map(|(name, count)| format!("{name} {count}")).collect();
    let _ = writeln!(out, "readings by set: {}", sets.join(", "));
    out += &parts(found);
    let _ = writeln!(out, "order of the readings: {}\n", order(found));
    let header = ["variable", "unit", "least", "most", "limits", "covered", "beyond"];
    out += &screen.table(&header, found.joints.iter().map(|(name, range)| row(name, range)));
    out += "\n";
    if let (Some(source), Some(first)) = (found.evaluated_at, found.joints.keys().next()) {
        let _ = match source {
            "plain" => writeln!(
                out,
                "evaluated at the plain columns (`{first}`); `joints: commanded` or `joints: recorded` chooses the others"
            ),
            source => writeln!(out, "evaluated at the columns `{source}.{first}` .., as `joints: {source}` says"),
        };
    }
    out += &noise(found);
    if let Some(loads) = &found.loads {
        let _ = writeln!(
            out,
            "loaded readings: {}, up to {:.1} N and {:.1} N.m",
            loads.readings, loads.greatest_force, loads.greatest_moment
        );
    }
    for (what, names) in
        [("conditions", &found.conditions), ("calibrate", &found.calibrate), ("without", &found.without)]
    {
        if !names.is_empty() {
            let _ = writeln!(out, "{what}: {}", names.join(", "));
        }
    }
    let _ = writeln!(out, "{}", found.own_weight.of_readings());
    out + &estimated(found)
}

/// Readings of sessions, stations, files, contacts and placements, with the configurations at which they were taken.
fn parts(found: &CampaignCheck) -> String {
    let mut lines: Vec<(&str, Vec<String>)> = Vec::new();
    for own in &found.parts {
        let shown = format!("{} {} ({})", own.name, own.readings, own.configurations);
        match lines.last_mut().filter(|(part, _)| *part == own.part) {
            Some((_, all)) => all.push(shown),
            None => lines.push((&own.part, vec![shown])),
        }
    }
    lines.into_iter().map(|(part, all)| format!("readings by {part} (configurations): {}\n", all.join(", "))).collect()
}

/// What says which reading came before which.
fn order(found: &CampaignCheck) -> &'static str {
    match found.order.by {
        "order" => "the column `order`",
        "time" => "the column `time`",
        "time-and-rows" => "the column `time`, and the rows of the files where configurations have the same time",
        "stated-rows" => "the rows of the files, as `order: rows` says",
        "unknown" => "not known, as `order: unknown` says",
        _ => "the rows of the files, since nothing says another (a column `order` or `time`, or `order: unknown`)",
    }
}

/// The noise stated, and what is known of it without the robot.
fn noise(found: &CampaignCheck) -> String {
    let mut out = String::new();
    let _ = match &found.noise {
        Some(noise) => {
            let range = noise.range.map_or(String::new(), |[least, most]| format!(" rms ({least:.4} to {most:.4} mm)"));
            let lengths = noise.position.map(|[x, y, z]| match x == y && y == z {
                true => format!("{x:.4} mm{range}"),
                false => format!("{x:.4}, {y:.4}, {z:.4} mm"),
            });
            let angles = noise.orientation.map(|deg| format!("{deg:.4} deg"));
            let torques = noise.torque.map(|torque| format!("{torque:.4} N.m"));
            let stated: Vec<String> = [lengths, angles, torques].into_iter().flatten().collect();
            let open = match (noise.position, noise.orientation) {
                (Some(_), None) if found.has_orientations => {
                    "; of orientations none: they are weighed by what a fit leaves"
                }
                (None, Some(_)) if found.has_orientations && found.has_lengths => {
                    "; of lengths none: they are weighed by what a fit leaves"
                }
                _ => "",
            };
            writeln!(out, "noise stated, one sigma: {}{open}", stated.join(", "))
        }
        None => match found.without_robot.taken {
            Some(sigma) => {
                writeln!(out, "noise stated: none; that which the readings show counts instead, {sigma:.4} mm")
            }
            None => writeln!(out, "noise stated: none; intervals come from the residuals alone"),
        },
    };
    let seen = &found.without_robot;
    for (what, figure) in [
        ("distances between rigid markers", seen.rigid_markers),
        ("readings repeated in place", seen.repeats),
        ("fixed reflectors", seen.references),
    ] {
        if let Some(NoiseFigure { sigma, degrees_of_freedom }) = figure {
            let _ = writeln!(
                out,
                "noise without the robot, from {what}: {sigma:.4} mm ({degrees_of_freedom:.0} degrees of freedom)"
            );
        }
    }
    if let Some(motion) = seen.motion {
        let _ = writeln!(
            out,
            "fixed reflectors against the instrument: {:.4} mm rms, {:.4} mm at most, {:.4} mm from first to last (chance {:.1e})",
            motion.rms, motion.greatest, motion.drift, motion.p
        );
    }
    out
}

fn row(name: &str, range: &JointRange) -> Vec<String> {
    let limits = range.limits.map_or("none".into(), |[low, high]| format!("{low:.2} .. {high:.2}"));
    let covered = range.covered.map_or(String::new(), |share| format!("{:.0} %", 100.0 * share));
    let beyond = if range.beyond > 0 { format!("{} readings", range.beyond) } else { String::new() };
    let [least, most] = [range.least, range.most].map(|v| format!("{v:.2}"));
    vec![name.into(), range.unit.into(), least, most, limits, covered, beyond]
}

fn estimated(found: &CampaignCheck) -> String {
    let estimate = &found.estimate;
    if let Some(why) = &estimate.none {
        return format!("`identify` will estimate nothing: {why}\n");
    }
    let groups = [
        ("base", &estimate.base),
        ("tool and markers", &estimate.tool),
        ("geometry", &estimate.geometry),
        ("springs", &estimate.elastic),
        ("effects", &estimate.effects),
        ("contacts, anchors, sensors", &estimate.targets),
    ];
    let mut out = "\n`identify` will estimate, as far as the readings separate it (`identifiability`)\n".to_string();
    for (what, names) in groups.into_iter().filter(|(_, names)| !names.is_empty()) {
        let _ = writeln!(out, "{what} ({}): {}", names.len(), names.join(" "));
    }
    out
}
