//! `transmission-error`: periodic error of the joint angle (eccentricity, gear mesh).

use std::sync::Arc;

use crate::model::{
    Change, Changes, Effect, EffectParameter, Model, Nonlinear, NonlinearKind, NonlinearParameter, NonlinearValue,
    Site, SiteKind, Survey,
};

pub(super) static ORDER: NonlinearParameter = NonlinearParameter {
    name: "order",
    kind: NonlinearKind::Real { unit: "1", is_continuous: true, is_positive: false },
    default: None,
    only_with: None,
    meaning: "`order`: periods in a turn of the joint",
};

/// Orders that are tried: eccentricities and the wave generator of a strain wave gear (1, 2) to slow meshes (20). Those
/// of faster meshes would need more configurations than a campaign has.
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

    fn nonlinear_parameters(&self) -> Vec<&'static NonlinearParameter> {
        vec![&ORDER]
    }

    fn candidates(&self, model: &Model, site: &Site, _survey: &Survey) -> Vec<Nonlinear> {
        let turns = model.frames[site.frame].joint == crate::description::raw::JointKind::Revolute;
        let of = |order: f64| Nonlinear::new([(&ORDER, NonlinearValue::Real(order))]);
        if turns { ORDERS.map(of).to_vec() } else { Vec::new() }
    }

    fn parameters(&self, _model: &Model, _site: &Site, _nonlinear: &Nonlinear) -> Vec<EffectParameter> {
        ["cos", "sin"].map(|symbol| EffectParameter::new(symbol, "rad", 3e-4)).to_vec()
    }

    fn changes(&self, _model: &Model, site: &Site, nonlinear: &Nonlinear) -> Changes {
        let [NonlinearValue::Real(order)] = nonlinear.values()[..] else { return Arc::new(|_, _| {}) };
        periodic(site, order)
    }
}

/// A joint's angle swings so many times in its turn: by cosine and sine, rad.
pub(super) fn periodic(site: &Site, order: f64) -> Changes {
    let (variable, joint) = (site.variable, site.frame);
    Arc::new(move |context, out| {
        let (sine, cosine) = (order * context.joints[joint]).sin_cos();
        out.push((0, Change::Joint(variable, cosine)));
        out.push((1, Change::Joint(variable, sine)));
    })
}
