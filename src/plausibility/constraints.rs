//! Known distances and angles between what a ball touches, against the contacts themselves.
//!
//! A datum whose angle or distance is declared wrong holds its faces where they are not, and nothing else in the campaign can give. Where all
//! that is declared is left free and most of the error goes, each is left free alone, and the one that takes it along is named.

use super::again::{Fall, again};
use super::evidence::{Evidence, Limits};
use super::outlying::HIDING;
use super::shown::mm;
use crate::description::campaign::{Between, Campaign, Constraint};
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::Calibration;
use crate::prediction::target_values;

pub(super) fn fit_the_contacts(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let is_known = |constraint: &Constraint| constraint.length.is_none();
    let known: Vec<usize> = (0..campaign.constraints.len()).filter(|&k| is_known(&campaign.constraints[k])).collect();
    let is_noise = |found: &Calibration| campaign.sigma.is_some() && found.noise_ratio < HIDING;
    let found = evidence.found.filter(|found| found.converged() && !is_noise(found));
    let Some(found) = found.filter(|_| !known.is_empty()) else { return Vec::new() };
    // What is left without some of the constraints, and the values with which it is.
    let without = |free: &[usize]| {
        let mut own: Campaign = campaign.clone();
        let freed: Vec<Constraint> = free.iter().map(|&k| campaign.constraints[k]).collect();
        // Those that hold are found anew among the declared ones where readings are left out.
        own.constraints.retain(|constraint| !freed.contains(constraint));
        own.declared.retain(|constraint| !freed.contains(constraint));
        let again = again(model, &own, found)?;
        let fall = Fall::between(found, &again);
        fall.is_by(limits.fall).then_some((fall, again.values))
    };
    let Some(all) = without(&known) else { return Vec::new() };
    let alone = known.iter().filter_map(|&k| Some((vec![k], without(&[k])?)));
    let (free, (fall, values)) = alone.min_by(|a, b| a.1.0.after.total_cmp(&b.1.0.after)).unwrap_or((known, all));
    let of = |&k: &usize| {
        let constraint = &campaign.constraints[k];
        let [a, b] = constraint.targets.map(|target| target_values(model, campaign, target, &values));
        let names = constraint.targets.map(|target| campaign.targets[target].name.as_str()).join("-");
        let shown = match constraint.of([&a, &b], constraint.value).0 {
            angle if constraint.between == Between::Normals => format!("{:.2} deg", angle.to_degrees()),
            distance => format!("{} mm", mm(distance)),
        };
        let declared = match constraint.between {
            Between::Normals => format!("{:.2} deg", constraint.value.to_degrees()),
            _ => format!("{} mm", mm(constraint.value)),
        };
        format!("`{names}` comes out at {shown} where {declared} is declared")
    };
    let with = fall.words("known distances or angles left free");
    let message = format!("{with}: {}", free.iter().map(of).collect::<Vec<_>>().join(", "));
    let diagnostic = Diagnostic::error(message).code(Code::Misread);
    vec![
        diagnostic
            .remedy("look at `distances:` and `angles:` of the campaign, and at their units; or leave one out that is not known")
            .figure("left_mm", 1e3 * fall.after),
    ]
}
