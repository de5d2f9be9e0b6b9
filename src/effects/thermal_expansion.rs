//! `thermal-expansion`: the length of a link follows temperature.

use std::sync::Arc;

use crate::model::{
    Change, Changes, Condition, Effect, EffectParameter, Model, Nonlinear, NonlinearKind, NonlinearParameter,
    NonlinearValue, Site, SiteKind, Survey,
};
use crate::parameter::Slot;

/// The default is what versions up to 0.1 assumed. A diagnosis takes the mean of the campaign, in whatever unit its
/// temperatures are, so that the effect leaves the mean lengths as calibrated.
static REFERENCE: NonlinearParameter = NonlinearParameter {
    name: "reference",
    kind: NonlinearKind::Real { unit: "degC or K as measured", is_continuous: false, is_positive: false },
    default: Some(NonlinearValue::Real(20.0)),
    only_with: None,
    meaning: "`reference`: the temperature at which the lengths of the description hold",
};
/// Lengths below this one, m, expand by nothing that shows.
const LEAST_LENGTH: f64 = 1e-3;

/// See the module.
pub struct ThermalExpansion;

impl Effect for ThermalExpansion {
    fn name(&self) -> &'static str {
        "thermal-expansion"
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Link
    }

    fn signature(&self) -> &'static str {
        "a link grows in step with the temperature, or as the robot warms up"
    }

    fn remedy(&self) -> &'static str {
        "warm the robot up; measure temperatures and scale the link"
    }

    fn reads(&self) -> &'static [Condition] {
        &[Condition::Temperature]
    }

    fn nonlinear_parameters(&self) -> Vec<&'static NonlinearParameter> {
        vec![&REFERENCE]
    }

    fn candidates(&self, model: &Model, site: &Site, survey: &Survey) -> Vec<Nonlinear> {
        let mean = survey.mean_temperature(site).filter(|_| !lengths(model, site).is_empty());
        mean.map(|mean| Nonlinear::new([(&REFERENCE, NonlinearValue::Real(mean))])).into_iter().collect()
    }

    fn parameters(&self, _model: &Model, _site: &Site, _nonlinear: &Nonlinear) -> Vec<EffectParameter> {
        vec![EffectParameter::new("expansion", "1/K", 1.2e-5)]
    }

    fn changes(&self, model: &Model, site: &Site, nonlinear: &Nonlinear) -> Changes {
        let [NonlinearValue::Real(reference)] = nonlinear.values()[..] else { return Arc::new(|_, _| {}) };
        let lengths = lengths(model, site);
        Arc::new(move |context, out| {
            let Some(temperature) = context.temperature else { return };
            out.extend(
                lengths.iter().map(|&(slot, length)| (0, Change::Slot(slot, length * (temperature - reference)))),
            );
        })
    }
}

/// Lengths of a link, m: constants b, d and r of the frames that it carries.
pub(super) fn lengths(model: &Model, site: &Site) -> Vec<(Slot, f64)> {
    let carried = model.frames.iter().enumerate().skip(1).filter(|(_, frame)| frame.antecedent == site.frame);
    carried
        .flat_map(|(_, frame)| {
            let prismatic = frame.joint == crate::description::raw::JointKind::Prismatic;
            [Some(frame.slots[2]), Some(frame.slots[4]), (!prismatic).then_some(frame.slots[6])]
        })
        .flatten()
        .map(|slot| (slot, model.registry[slot].nominal))
        .filter(|(_, length)| length.abs() > LEAST_LENGTH)
        .collect()
}
