//! `transmission-error`: periodic error of the joint angle (eccentricity, gear mesh).

use super::{Change, Effect, EffectParameter, Form, Moment, Site, SiteKind, Survey};
use crate::model::Model;

/// Periods in a turn that are tried; gear meshes of high order need readings closer than theirs.
const ORDERS: [f64; 14] = [1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 16.0, 20.0];

/// See the module.
pub struct TransmissionError;

impl Effect for TransmissionError {
    fn name(&self) -> &'static str {
        "transmission-error"
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Joint
    }

    fn signature(&self) -> &'static str {
        "an angle of one joint that swings with the joint, once or several times a turn"
    }

    fn remedy(&self) -> &'static str {
        "measure the joint over a turn and map it in the controller; inspect bearing seats and gear mesh"
    }

    fn form_symbols(&self) -> &'static [&'static str] {
        &["order"]
    }

    fn forms(&self, model: &Model, site: &Site, _survey: &Survey) -> Vec<Form> {
        let turns = model.frames[site.frame].joint == crate::description::raw::JointKind::Revolute;
        let form = |&order: &f64| Form { symbol: "order", value: order, continuous: true };
        if turns { ORDERS.iter().map(form).collect() } else { Vec::new() }
    }

    fn parameters(&self, _model: &Model, _site: &Site, _form: &Form) -> Vec<EffectParameter> {
        let parameter =
            |symbol: &str| EffectParameter { symbol: symbol.into(), unit: "rad", scale: 3e-4, is_positive: false };
        vec![parameter("cos"), parameter("sin")]
    }

    fn changes(&self, site: &Site, form: &Form, moment: &Moment, out: &mut Vec<(usize, Change)>) {
        let (sine, cosine) = (form.value * moment.joints[site.frame]).sin_cos();
        out.push((0, Change::Joint(site.variable, cosine)));
        out.push((1, Change::Joint(site.variable, sine)));
    }
}
