//! Probes: local errors of every kind of site, free in every configuration. They locate a gap and are no causes.

use nalgebra::Vector3;

use crate::effects::{Change, Effect, EffectParameter, Form, Moment, Site, SiteKind};
use crate::model::Model;

/// Lengths below this (m) have no error in proportion to them.
const LEAST_LENGTH: f64 = 1e-3;

/// A free error of a kind of site.
struct Probe(SiteKind);

/// One probe for each kind of site that a reading can depend on.
pub static PROBES: [&dyn Effect; 4] =
    [&Probe(SiteKind::Joint), &Probe(SiteKind::Link), &Probe(SiteKind::Base), &Probe(SiteKind::Instrument)];

impl Effect for Probe {
    fn name(&self) -> &'static str {
        "probe"
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

    fn parameters(&self, _model: &Model, _site: &Site, _form: &Form) -> Vec<EffectParameter> {
        let count = if self.0 == SiteKind::Base { 3 } else { 1 };
        vec![EffectParameter { symbol: "free".into(), unit: "", scale: 1.0, is_positive: false }; count]
    }

    fn changes(&self, site: &Site, _form: &Form, moment: &Moment, out: &mut Vec<(usize, Change)>) {
        match self.0 {
            SiteKind::Joint => out.push((0, Change::Yield(site.variable, 1.0))),
            SiteKind::Link => {
                for (index, frame) in moment.model.frames.iter().enumerate().skip(1) {
                    if frame.antecedent == site.frame && index != site.frame {
                        for slot in [frame.slots[4], frame.slots[6]] {
                            let length = moment.model.registry[slot].nominal;
                            if length.abs() > LEAST_LENGTH && Some(slot) != frame.moves().then(|| frame.moving_slot()) {
                                out.push((0, Change::Slot(slot, length)));
                            }
                        }
                    }
                }
            }
            SiteKind::Instrument => out.push((0, Change::Point(moment.position, Vector3::zeros()))),
            _ => {
                for k in 0..3 {
                    // It rocks about its foot; free to move in all six ways it could carry anything.
                    let axis = Vector3::ith(k, 1.0);
                    out.push((k, Change::Point(axis.cross(&(moment.position - moment.base)), axis)));
                }
            }
        }
    }
}
