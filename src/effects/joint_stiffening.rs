//! `joint-stiffening`: a joint spring that is not linear in the torque: soft at small loads, stiff once wound up.

use super::{Change, Effect, EffectParameter, Form, Moment, Site, SiteKind, Survey};
use crate::model::Model;

/// Loads at which the soft part is wound up, as shares of the greatest.
const SHARES: [f64; 8] = [0.07, 0.1, 0.15, 0.22, 0.33, 0.5, 0.8, 1.2];

/// See the module.
pub struct JointStiffening;

impl Effect for JointStiffening {
    fn name(&self) -> &'static str {
        "joint-stiffening"
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Joint
    }

    fn signature(&self) -> &'static str {
        "an angle of one joint that grows with small loads and then hardly any more"
    }

    fn remedy(&self) -> &'static str {
        "preload the gear; identify at the loads of the process"
    }

    fn form_symbols(&self) -> &'static [&'static str] {
        &["wound_up_at"]
    }

    fn forms(&self, _model: &Model, site: &Site, survey: &Survey) -> Vec<Form> {
        let greatest = survey.greatest_load.get(site.variable).copied().unwrap_or_default();
        let form = |share: &f64| Form { symbol: "wound_up_at", value: share * greatest, continuous: true };
        if greatest > 0.0 { SHARES.iter().map(form).collect() } else { Vec::new() }
    }

    fn parameters(&self, _model: &Model, _site: &Site, _form: &Form) -> Vec<EffectParameter> {
        vec![EffectParameter { symbol: "wind_up".into(), unit: "rad", scale: 3e-4, is_positive: false }]
    }

    fn changes(&self, site: &Site, form: &Form, moment: &Moment, out: &mut Vec<(usize, Change)>) {
        let v = site.variable;
        let shape = |load: f64| (load / form.value.max(f64::MIN_POSITIVE)).tanh();
        let rest = if moment.is_difference { shape(moment.own_load[v]) } else { 0.0 };
        out.push((0, Change::Yield(v, shape(moment.load[v]) - rest)));
    }
}
