//! `free-compliance`: what hangs on a body moves in proportion to the load that the body carries, in any way.
//!
//! The compliance of an elastic body between two points is a symmetric matrix of six by six (Maxwell and Betti): bearings, gears and links
//! next to each other are each a part of it, and so is whatever else gives there. It says where something gives, and no more.

use std::sync::Arc;

use nalgebra::Vector3;

use super::law::Law;
use crate::model::{Change, EffectParameter, Family, Model, Site, SiteKind, Stage};

/// Directions, a force or a moment along each of which moves what hangs on the body along every other.
const DIRECTIONS: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];
/// Common size of an amount: rad/(N.m), as the drives of small arms have, and m/N.
const SCALE: [f64; 2] = [1e-5, 1e-6];

pub(super) static LAW: Law = Law {
    name: "free-compliance",
    sits_at: SiteKind::Link,
    family: Some(|_| Family::Elastic),
    signature: "under load the parts after one body move in proportion to what it carries; what gives there is not known",
    remedy: "measure with loads in several directions, or with indicators on either side of the joint, to find what gives",
    is_free_form: true,
    sites: Some(|model| {
        let all = [SiteKind::Base, SiteKind::Link].into_iter().flat_map(|kind| model.sites(kind));
        all.filter(|site| carries_joint(model, site) && is_in_no_loop(model, site)).collect()
    }),
    // The axis of the joint before a link is fixed in it, and so is that of the joint after it.
    covers: Some(|model, site| {
        let is_held = |joint: &Site| joint.frame == site.frame || comes_next(model, site, joint.frame);
        let joints = model.sites(SiteKind::Joint).into_iter().filter(is_held);
        std::iter::once(site.name.clone()).chain(joints.map(|joint| joint.name)).collect()
    }),
    parameters: Some(|_, _, _| {
        let of = |(a, b): (usize, usize)| {
            let (unit, scale) = match (a < 3, b < 3) {
                (true, true) => ("m/N", SCALE[1]),
                (false, false) => ("rad/(N.m)", SCALE[0]),
                _ => ("rad/N", (SCALE[0] * SCALE[1]).sqrt()),
            };
            EffectParameter::new(format!("{}_{}", DIRECTIONS[a], DIRECTIONS[b]), unit, scale)
        };
        entries().map(of).collect()
    }),
    changes: |_, site, _| {
        let frame = site.frame;
        Arc::new(move |context, out| {
            let Some(body) = context.carried.get(frame).filter(|body| body.carries_point) else { return };
            let arm = context.position - body.origin;
            let moved = |direction: usize, amount: f64| {
                let axis = body.axes * Vector3::ith(direction % 3, amount);
                if direction < 3 {
                    Change::Point(axis, Vector3::zeros())
                } else {
                    Change::Point(axis.cross(&arm), axis)
                }
            };
            for (k, (a, b)) in entries().enumerate() {
                out.push((k, moved(a, body.wrench[b])));
                if a != b {
                    out.push((k, moved(b, body.wrench[a])));
                }
            }
        })
    },
    ..Law::NOTHING
};

/// Row and column of each entry of the upper triangle.
fn entries() -> impl Iterator<Item = (usize, usize)> {
    (0..6).flat_map(|a| (a..6).map(move |b| (a, b)))
}

/// Whether a joint comes next after the body of a site.
fn carries_joint(model: &Model, site: &Site) -> bool {
    (1..model.frames.len()).any(|frame| model.frames[frame].moves() && comes_next(model, site, frame))
}

/// Whether a frame hangs on the body of a site with no joint between.
fn comes_next(model: &Model, site: &Site, frame: usize) -> bool {
    let mut before = model.frames[frame].antecedent;
    while before != 0 && before != site.frame && !model.frames[before].moves() {
        before = model.frames[before].antecedent;
    }
    frame != 0 && before == site.frame
}

/// Whether all that hangs on the body of a site hangs on nothing else: no loop joins it to what comes before.
fn is_in_no_loop(model: &Model, site: &Site) -> bool {
    let hangs = |mut frame: usize| {
        while frame != 0 && frame != site.frame {
            frame = model.frames[frame].antecedent;
        }
        frame == site.frame
    };
    let groups = model.stages.iter().filter_map(|stage| match stage {
        Stage::Loops(group) => Some(group),
        _ => None,
    });
    groups.flat_map(|group| &group.loops).all(|closed| {
        let mut all = closed.branches.iter().flatten().map(|&frame| frame != site.frame && hangs(frame));
        let first = all.next();
        all.all(|own| Some(own) == first)
    })
}
