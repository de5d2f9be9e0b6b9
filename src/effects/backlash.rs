//! `backlash`: lost motion of a joint, by the side of approach or by the sign of the load.

use super::{Change, Effect, EffectParameter, Form, Moment, Site, SiteKind, Survey};
use crate::model::Model;

/// Form: the joint lies on the flank it came from.
const BY_SIDE: f64 = 0.0;
/// Other forms: the load presses it on a flank, the sooner the smaller this load; as shares of the greatest.
const SOFT: [f64; 4] = [0.01, 0.02, 0.04, 0.07];

/// See the module.
pub struct Backlash;

impl Effect for Backlash {
    fn name(&self) -> &'static str {
        "backlash"
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Joint
    }

    fn signature(&self) -> &'static str {
        "two populations of one joint: the angle jumps with the side of approach, or with the sign of the load"
    }

    fn remedy(&self) -> &'static str {
        "approach from one side only; readjust the gear or belt"
    }

    fn form_symbols(&self) -> &'static [&'static str] {
        &["changes_at"]
    }

    fn forms(&self, _model: &Model, site: &Site, survey: &Survey) -> Vec<Form> {
        let mut forms = Vec::new();
        let mut add = |value: f64| forms.push(Form { symbol: "changes_at", value, continuous: value > 0.0 });
        if survey.sides.get(site.variable) == Some(&true) && !survey.is_difference {
            add(BY_SIDE);
        }
        if let Some(&load) = survey.greatest_load.get(site.variable).filter(|load| **load > 0.0) {
            SOFT.iter().for_each(|share| add(share * load));
        }
        forms
    }

    fn parameters(&self, _model: &Model, _site: &Site, _form: &Form) -> Vec<EffectParameter> {
        vec![EffectParameter { symbol: "half_width".into(), unit: "rad", scale: 3e-4, is_positive: false }]
    }

    fn changes(&self, site: &Site, form: &Form, moment: &Moment, out: &mut Vec<(usize, Change)>) {
        let v = site.variable;
        if form.value == BY_SIDE {
            out.push((0, Change::Joint(v, moment.side[v])));
        } else {
            let sign = |load: f64| (load / form.value).tanh();
            let rest = if moment.is_difference { sign(moment.own_load[v]) } else { 0.0 };
            out.push((0, Change::Yield(v, sign(moment.load[v]) - rest)));
        }
    }
}
