//! `settling`: a joint, or all joints, were read before they had come to rest after their last move.
//!
//! What one joint lacks goes with its own move. All joints together are read by one clock: each lacks what it covers from then on, in
//! proportion to its speed. Joints that start and arrive together have speeds as their moves, and the one that moves farthest has the
//! speed of the robot (point-to-point moves with common duration; Siciliano et al., *Robotics*, sec. 4.2).

use std::sync::Arc;

use super::law::{Law, nothing};
use crate::description::raw::JointKind;
use crate::model::{Change, Condition, EffectParameter, Nonlinear, Site, SiteKind};

/// Common size of a share, and of what a joint lacks that moves farthest, rad or m.
const SCALE: f64 = 1e-3;

pub(super) static LAW: Law = Law {
    name: "settling",
    sits_at: SiteKind::Joint,
    signature: "an angle of one joint in proportion to its last move, or of all joints in proportion to their speed in it",
    remedy: "wait longer before reading; evaluate at the commanded joints",
    reads: &[Condition::LastMove],
    cancels_in_differences: true,
    sites: Some(|model| [SiteKind::Joint, SiteKind::Joints].into_iter().flat_map(|kind| model.sites(kind)).collect()),
    covers: Some(|model, site| match site.kind {
        SiteKind::Joints => model.sites(SiteKind::Joint).into_iter().map(|joint| joint.name).collect(),
        _ => vec![site.name.clone()],
    }),
    // Only where the campaign gives the order of its readings: that of rows may be any.
    candidates: |_, site, survey| {
        let is_known = match site.kind {
            SiteKind::Joints => survey.moves.iter().filter(|moves| **moves).count() > 1,
            _ => site.of(&survey.moves) == Some(&true),
        };
        if is_known { vec![Nonlinear::default()] } else { Vec::new() }
    },
    parameters: Some(|model, site, _| match site.kind {
        SiteKind::Joints => {
            let joints = model.sites(SiteKind::Joint);
            let of = |site: &Site| {
                let frame = &model.frames[site.frame];
                let unit = if frame.joint == JointKind::Revolute { "rad" } else { "m" };
                EffectParameter::new(format!("lag.{}", frame.name), unit, SCALE)
            };
            joints.iter().map(of).collect()
        }
        _ => vec![EffectParameter::new("share", "1", SCALE)],
    }),
    changes: |model, site, _| {
        if site.kind == SiteKind::Joints {
            let joints = model.sites(SiteKind::Joint);
            let turns = |site: &Site| model.frames[site.frame].joint == JointKind::Revolute;
            let of = |site: &Site| Some((site.coordinate?, turns(site)));
            let joints: Vec<(usize, bool)> = joints.iter().filter_map(of).collect();
            return Arc::new(move |context, out| {
                let moved = |variable: usize| context.last_move[variable];
                let farthest = |kind: bool| {
                    let own = joints.iter().filter(|(_, turns)| *turns == kind);
                    own.fold(0.0_f64, |most, (variable, _)| most.max(moved(*variable).abs()))
                };
                let farthest = [farthest(false), farthest(true)];
                for (parameter, &(variable, turns)) in joints.iter().enumerate() {
                    let of_kind = farthest[usize::from(turns)];
                    if of_kind > 0.0 {
                        out.push((parameter, Change::Joint(variable, moved(variable) / of_kind)));
                    }
                }
            });
        }
        let Some(variable) = site.coordinate else { return nothing() };
        Arc::new(move |context, out| out.push((0, Change::Joint(variable, context.last_move[variable]))))
    },
    ..Law::NOTHING
};
