//! `payload`: mass or centre of mass of what is carried, or the applied wrench, mis-stated.

use std::sync::Arc;

use nalgebra::Vector3;

use crate::model::{
    Change, Changes, Effect, EffectParameter, Family, Model, Nonlinear, NonlinearKind, NonlinearParameter,
    NonlinearValue, Site, SiteKind, Survey,
};
use crate::parameter::Slot;

const MASS: &str = "mass";
const WRENCH: &str = "wrench";
static MISSTATED: NonlinearParameter = NonlinearParameter {
    name: "misstated",
    kind: NonlinearKind::Choice(&[MASS, WRENCH]),
    default: Some(NonlinearValue::Choice(MASS)),
    only_with: None,
    meaning: "`misstated`: the mass of what is carried, or the size of the applied wrench",
};

/// See the module.
pub struct Payload;

impl Effect for Payload {
    fn name(&self) -> &'static str {
        "payload"
    }

    fn family(&self, _nonlinear: &Nonlinear) -> Family {
        Family::Elastic
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Tool
    }

    fn signature(&self) -> &'static str {
        "all deflections under the applied load are in proportion too great or small; or the arm sags as if the tool weighed more"
    }

    fn remedy(&self) -> &'static str {
        "weigh the tool; calibrate the load cell or the pulley"
    }

    fn nonlinear_parameters(&self) -> Vec<&'static NonlinearParameter> {
        vec![&MISSTATED]
    }

    fn candidates(&self, model: &Model, site: &Site, survey: &Survey) -> Vec<Nonlinear> {
        let of = |what| Nonlinear::new([(&MISSTATED, NonlinearValue::Choice(what))]);
        let carries = !self.constants(model, site, &of(MASS)).is_empty();
        let shows_mass = carries && !survey.is_difference && survey.greatest_load.iter().any(|load| *load > 0.0);
        let wrench = survey.loaded.then(|| of(WRENCH));
        wrench.into_iter().chain(shows_mass.then(|| of(MASS))).collect()
    }

    fn constants(&self, model: &Model, _site: &Site, nonlinear: &Nonlinear) -> Vec<Slot> {
        if is_of_wrench(nonlinear) {
            return Vec::new();
        }
        let tool = &model.frames[model.tool.0].name;
        model.slots_named(["mass", "x", "y", "z"].map(|symbol| format!("body{tool}.{symbol}")))
    }

    fn parameters(&self, model: &Model, site: &Site, nonlinear: &Nonlinear) -> Vec<EffectParameter> {
        if is_of_wrench(nonlinear) {
            return vec![EffectParameter::new("gain", "1", 0.02)];
        }
        model.shifts_of(&self.constants(model, site, nonlinear))
    }

    fn changes(&self, _model: &Model, _site: &Site, nonlinear: &Nonlinear) -> Changes {
        if !is_of_wrench(nonlinear) {
            return Arc::new(|_, _| {});
        }
        Arc::new(|context, out| out.push((0, Change::Point(context.deflection, Vector3::zeros()))))
    }
}

fn is_of_wrench(nonlinear: &Nonlinear) -> bool {
    nonlinear.values()[..] == [NonlinearValue::Choice(WRENCH)]
}
