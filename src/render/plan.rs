//! A plan as text. Errors in mm, joints in deg or mm, loads in N and N.m.

use std::fmt::Write;

use super::identification::conditioning;
use super::table::{Screen, number};
use crate::results::units::{shown, shown_unit};
use crate::results::{Plan, PlannedPose};

/// Text of `plan`.
pub fn plan(found: &Plan, screen: Screen) -> String {
    let count = found.poses.len();
    let random =
        found.bought.iter().find(|b| b.poses == count).map_or("unknown".into(), |b| format!("{:.4}", b.random));
    let mut out = format!(
        "{count} configurations leave {:.4} mm of position error after compensation (rms at the test poses, by the\n\
         covariance of {} parameters); as many at random leave {random} mm (median of {} sets)",
        found.error.planned,
        found.parameters.len(),
        found.random_sets,
    );
    let _ = match found.random_equal {
        Some(equal) if equal > count => writeln!(out, ",\nand it takes {equal} at random to do as well"),
        Some(_) => writeln!(out),
        None => writeln!(out, ",\nand not all the candidates together do as well"),
    };
    if let Some(before) = found.error.before {
        let _ = writeln!(out, "what is measured already leaves {before:.4} mm");
    }
    out += "\n";
    out += &poses(found, screen);
    out += "\n";
    let bought =
        |b: &crate::results::Bought| vec![b.poses.to_string(), format!("{:.4}", b.planned), format!("{:.4}", b.random)];
    out += &screen.table(&["configurations", "planned mm", "random mm"], found.bought.iter().map(bought));
    let _ = writeln!(out, "fewest that tell the parameters apart: {}\n", found.least);
    out += &screen.table(
        &["parameter", "unit", "95 % +-"],
        found.parameters.iter().map(|p| vec![p.name.clone(), p.unit.into(), number(p.unit, p.ci95)]),
    );
    out += &conditioning(&found.identifiability);
    out + &found.own_weight.of_readings() + "\n"
}

fn poses(found: &Plan, screen: Screen) -> String {
    let under_load = found.poses.iter().any(|pose| pose.wrench != [0.0; 6]);
    let all_seen = found.poses.iter().all(|pose| pose.markers.len() == found.markers);
    let units: Vec<String> =
        found.variables.iter().map(|(name, is_angle)| format!("{name} {}", shown_unit(*is_angle))).collect();
    let mut header = vec!["pose"];
    header.extend(units.iter().map(String::as_str));
    if under_load {
        header.extend(["fx N", "fy N", "fz N", "mx N.m", "my N.m", "mz N.m"]);
    }
    let mut columns: Vec<&str> = Vec::new();
    for name in found.poses.iter().flat_map(|pose| pose.names.keys()) {
        if !columns.contains(&name.as_str()) {
            columns.push(name);
        }
    }
    header.extend(&columns);
    // What all rows share goes without saying.
    let read: Vec<[String; 2]> = found.poses.iter().map(PlannedPose::kinds_and_files).collect();
    let differs = |k: usize| read.iter().any(|own| own[k] != read[0][k] || own[k].contains(' '));
    let varying: Vec<usize> =
        (0..2).filter(|&k| differs(k) || k == 1 && read.iter().any(|own| !own[1].is_empty())).collect();
    header.extend(varying.iter().map(|&k| ["observes", "file"][k]));
    if !all_seen {
        header.push("seen");
    }
    let row = |(pose, read): (&PlannedPose, &[String; 2])| {
        let mut row = vec![pose.pose.clone()];
        let joints = pose.joints.values().zip(&found.variables);
        row.extend(joints.map(|(q, (_, is_angle))| format!("{:.2}", shown(*q, *is_angle))));
        if under_load {
            row.extend(pose.wrench.iter().map(|w| format!("{w}")));
        }
        row.extend(columns.iter().map(|name| pose.names.get(*name).cloned().unwrap_or_default()));
        row.extend(varying.iter().map(|&k| read[k].clone()));
        if !all_seen {
            row.push(pose.markers.join(" "));
        }
        row
    };
    screen.table(&header, found.poses.iter().zip(&read).map(row))
}
