//! Probes: local errors of every kind of site, free in every configuration. They locate a gap and are no causes.

use std::sync::Arc;

use nalgebra::Vector3;

use crate::effects::{Change, Changes, Effect, EffectParameter, Family, Nonlinear, Site, SiteKind};
use crate::model::Model;
use crate::parameter::Slot;
use crate::prediction::Term;

/// Lengths below this (m) have no error in proportion to them.
const LEAST_LENGTH: f64 = 1e-3;

/// A free error of a kind of site.
struct Probe(SiteKind);

/// Probes at all sites that a reading can depend on.
pub fn probes(model: &Model) -> Vec<Term> {
    let kinds = [SiteKind::Joint, SiteKind::Link, SiteKind::Base, SiteKind::Instrument];
    let of = |kind| {
        let probe: Arc<dyn Effect> = Arc::new(Probe(kind));
        model.sites(kind).into_iter().map(move |site| Term::new(model, &probe, &site, &Nonlinear::default()))
    };
    kinds.into_iter().flat_map(of).collect()
}

impl Effect for Probe {
    fn name(&self) -> &'static str {
        "probe"
    }

    fn family(&self, _nonlinear: &Nonlinear) -> Family {
        Family::Geometry
    }

    fn sits_at(&self) -> SiteKind {
        self.0
    }

    fn signature(&self) -> &'static str {
        ""
    }

    fn remedy(&self) -> &'static str {
        ""
    }

    fn parameters(&self, _model: &Model, _site: &Site, _nonlinear: &Nonlinear) -> Vec<EffectParameter> {
        let count = if self.0 == SiteKind::Base { 3 } else { 1 };
        vec![EffectParameter::new("free", "", 1.0); count]
    }

    fn changes(&self, model: &Model, site: &Site, _nonlinear: &Nonlinear) -> Changes {
        match self.0 {
            SiteKind::Joint => {
                let coordinate = site.coordinate;
                Arc::new(move |_, out| out.extend(coordinate.map(|own| (0, Change::Deflection(own, 1.0)))))
            }
            SiteKind::Link => {
                let lengths = lengths(model, site);
                Arc::new(move |_, out| {
                    out.extend(lengths.iter().map(|&(slot, length)| (0, Change::Slot(slot, length))));
                })
            }
            SiteKind::Instrument => {
                Arc::new(|context, out| out.push((0, Change::Point(context.position, Vector3::zeros()))))
            }
            _ => Arc::new(|context, out| {
                for k in 0..3 {
                    // It rocks about its foot; free to move in all six ways it could carry anything.
                    let axis = Vector3::ith(k, 1.0);
                    out.push((k, Change::Point(axis.cross(&(context.position - context.base)), axis)));
                }
            }),
        }
    }
}

/// Lengths of a link, m: constants d and r of the frames that it carries, but for those that move.
fn lengths(model: &Model, site: &Site) -> Vec<(Slot, f64)> {
    let carried = model.frames.iter().enumerate().skip(1);
    carried
        .filter(|(index, frame)| frame.antecedent == site.frame && *index != site.frame)
        .flat_map(|(_, frame)| {
            let moving = frame.moves().then(|| frame.moving_slot());
            [frame.slots[4], frame.slots[6]].into_iter().filter(move |slot| Some(*slot) != moving)
        })
        .map(|slot| (slot, model.registry[slot].nominal))
        .filter(|(_, length)| length.abs() > LEAST_LENGTH)
        .collect()
}
