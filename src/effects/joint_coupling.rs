//! `joint-coupling`: a joint moves with another joint.

use super::{Change, Effect, EffectParameter, Form, Moment, Site, SiteKind, Survey};
use crate::model::Model;

/// See the module.
pub struct JointCoupling;

impl Effect for JointCoupling {
    fn name(&self) -> &'static str {
        "joint-coupling"
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Joint
    }

    fn signature(&self) -> &'static str {
        "an angle of one joint that grows in proportion to another joint"
    }

    fn remedy(&self) -> &'static str {
        "check the coupling matrix of the wrist or linkage in the controller"
    }

    fn form_symbols(&self) -> &'static [&'static str] {
        &["variable"]
    }

    fn forms(&self, model: &Model, site: &Site, _survey: &Survey) -> Vec<Form> {
        let others = (0..model.variables.len()).filter(|&variable| variable != site.variable);
        others.map(|variable| Form { symbol: "variable", value: variable as f64, continuous: false }).collect()
    }

    fn parameters(&self, _model: &Model, _site: &Site, _form: &Form) -> Vec<EffectParameter> {
        vec![EffectParameter { symbol: "ratio".into(), unit: "1", scale: 1e-3, is_positive: false }]
    }

    fn changes(&self, site: &Site, form: &Form, moment: &Moment, out: &mut Vec<(usize, Change)>) {
        let other = moment.q.get(form.value as usize).copied().unwrap_or_default();
        out.push((0, Change::Joint(site.variable, other)));
    }
}
