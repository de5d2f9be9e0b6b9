//! Configurations that a description does not allow: passive joints, followers and sums of joints beyond their limits, and links
//! in boxes kept out of.

use crate::description::campaign::Campaign;
use crate::description::limits::{READINGS, beyond};
use crate::description::robot::Motion;
use crate::description::units::Units;
use crate::diagnostic::{Code, Diagnostic, Place};
use crate::kinematics::{Geometry, Limited, Placements, entered, limited};
use crate::model::Model;

/// One warning a joint without a variable of its own, or a sum of joints, that some of the `configurations` (rad, m) take beyond
/// its limits, and one a box kept out of that links pass through. `of` says what the configurations are, `units` are those
/// in which they were given, `place` says where a row's joint stands. What cannot be assembled is refused elsewhere.
pub fn not_allowed<'a>(
    model: &Model,
    units: &Units,
    of: &str,
    configurations: impl Iterator<Item = &'a [f64]> + Clone,
    place: impl Fn(usize, &str) -> Option<Place>,
) -> Vec<Diagnostic> {
    let of_joints = model
        .frames
        .iter()
        .any(|frame| frame.limits.is_some() && !matches!(frame.motion, Motion::Variable { .. } | Motion::Fixed));
    let has_limits = of_joints || !model.limits.is_empty();
    let Some(geometry) = Geometry::nominal(model).ok().filter(|_| has_limits || !model.keep_out.is_empty()) else {
        return Vec::new();
    };
    let mut diagnostics = match has_limits {
        true => beyond_limits(&geometry, units, of, configurations.clone(), place),
        false => Vec::new(),
    };
    if !model.keep_out.is_empty() {
        diagnostics.extend(kept_out(&geometry, of, configurations));
    }
    diagnostics
}

fn beyond_limits<'a>(
    geometry: &Geometry,
    units: &Units,
    of: &str,
    configurations: impl Iterator<Item = &'a [f64]>,
    place: impl Fn(usize, &str) -> Option<Place>,
) -> Vec<Diagnostic> {
    let (mut placements, mut joints, mut all) = (Placements::default(), Vec::new(), Vec::new());
    for q in configurations {
        let mut values = Vec::new();
        if geometry.place(q, &mut placements).is_ok() {
            let found: Vec<Limited> = limited(geometry.model, q, &placements).collect();
            values.extend(found.iter().map(|limited| limited.value));
            if joints.is_empty() {
                joints.extend(found.iter().map(Limited::variable));
            }
        }
        all.push(values);
    }
    beyond(&joints, units, of, all.iter().map(Vec::as_slice), place)
}

/// A warning where the robot as described cannot stand at some configurations of a campaign: how many, and why at the first.
pub fn cannot_stand(model: &Model, campaign: &Campaign) -> Option<Diagnostic> {
    let geometry = Geometry::nominal(model).ok()?;
    let mut placements = Placements::default();
    let mut last: Option<(&[f64], bool)> = None;
    let (mut count, mut first) = (0, None);
    for (index, reading) in campaign.readings.iter().enumerate() {
        let q = campaign.configuration(index);
        // Readings of one configuration follow one another.
        let stands = match last {
            Some((known, stands)) if known == q => stands,
            _ => match geometry.place(q, &mut placements) {
                Ok(()) => true,
                Err(error) => {
                    first.get_or_insert_with(|| (campaign.address(reading), error));
                    false
                }
            },
        };
        count += usize::from(!stands);
        last = Some((q, stands));
    }
    let (at, error) = first?;
    let all = campaign.readings.len();
    let message = format!("the robot as described cannot stand at {count} of {all} readings; the first, {at}: {error}");
    let remedy = "look at the joints of that row (signs, columns, units) and at the lengths of the loop; no fit takes such readings";
    Some(Diagnostic::warning(message).code(Code::NotComputed).remedy(remedy))
}

/// One warning a box that links pass through at some of the `configurations` (rad, m): how many, and the first.
/// `of` says what they are.
fn kept_out<'a>(geometry: &Geometry, of: &str, configurations: impl Iterator<Item = &'a [f64]>) -> Vec<Diagnostic> {
    let model = geometry.model;
    let mut placements = Placements::default();
    // Of each box: how many configurations, and what is said of the first.
    let mut found: Vec<Option<(usize, usize, String)>> = vec![None; model.keep_out.len()];
    let mut all = 0;
    for (row, q) in configurations.enumerate() {
        all += 1;
        // What cannot be placed is refused where it is.
        if geometry.place(q, &mut placements).is_err() {
            continue;
        }
        for (keep_out, found) in model.keep_out.iter().zip(&mut found) {
            let Some(entered) = entered(geometry, &placements).find(|own| own.keep_out == keep_out.name) else {
                continue;
            };
            match found {
                Some((count, ..)) => *count += 1,
                None => *found = Some((1, row, entered.link.to_string())),
            }
        }
    }
    let found = model.keep_out.iter().zip(found).filter_map(|(keep_out, found)| Some((keep_out, found?)));
    found
        .map(|(keep_out, (count, row, link))| {
            let name = &keep_out.name;
            let message = match all {
                1 => format!("{link} passes through `{name}`"),
                _ => format!("`{name}` is entered in {count} of {all} {of}; the first: {link} in row {}", row + 1),
            };
            let remedy =
                if of == READINGS { "check the campaign's joints, or" } else { "choose other joints, or check" };
            Diagnostic::warning(message).remedy(format!("{remedy} `keep_out` of the description"))
        })
        .collect()
}
