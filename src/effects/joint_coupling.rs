//! `joint-coupling`: a joint moves with another joint.

use std::sync::Arc;

use crate::model::{
    Change, Changes, Effect, EffectParameter, Model, Nonlinear, NonlinearKind, NonlinearParameter, NonlinearValue,
    Site, SiteKind, Survey,
};

static VARIABLE: NonlinearParameter = NonlinearParameter {
    name: "variable",
    kind: NonlinearKind::Variable,
    default: None,
    only_with: None,
    meaning: "`variable`: the one that the joint follows",
};

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

    fn nonlinear_parameters(&self) -> Vec<&'static NonlinearParameter> {
        vec![&VARIABLE]
    }

    fn candidates(&self, model: &Model, site: &Site, _survey: &Survey) -> Vec<Nonlinear> {
        let others = (0..model.variables.len()).filter(|&variable| variable != site.variable);
        others.map(|variable| Nonlinear::new([(&VARIABLE, NonlinearValue::Variable(variable))])).collect()
    }

    fn parameters(&self, _model: &Model, _site: &Site, _nonlinear: &Nonlinear) -> Vec<EffectParameter> {
        vec![EffectParameter::new("ratio", "1", 1e-3)]
    }

    fn changes(&self, _model: &Model, site: &Site, nonlinear: &Nonlinear) -> Changes {
        let variable = site.variable;
        match nonlinear.values()[..] {
            [NonlinearValue::Variable(other)] => {
                Arc::new(move |context, out| out.push((0, Change::Joint(variable, context.q[other]))))
            }
            _ => Arc::new(|_, _| {}),
        }
    }
}
