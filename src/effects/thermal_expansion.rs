//! `thermal-expansion`: the length of a link follows temperature.

use super::{Change, Effect, EffectParameter, Form, Moment, Site, SiteKind, Survey};
use crate::model::Model;

/// Temperature at which the description's lengths hold; a calibrated geometry makes its choice immaterial.
const REFERENCE: f64 = 20.0;

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

    fn forms(&self, model: &Model, site: &Site, survey: &Survey) -> Vec<Form> {
        if survey.temperatures && !lengths(model, site).is_empty() { vec![Form::ONLY] } else { Vec::new() }
    }

    fn parameters(&self, _model: &Model, _site: &Site, _form: &Form) -> Vec<EffectParameter> {
        vec![EffectParameter { symbol: "expansion".into(), unit: "1/K", scale: 1.2e-5, is_positive: false }]
    }

    fn changes(&self, site: &Site, _form: &Form, moment: &Moment, out: &mut Vec<(usize, Change)>) {
        let Some(temperature) = moment.temperature else { return };
        for slot in lengths(moment.model, site) {
            let length = moment.model.registry[slot].nominal;
            out.push((0, Change::Slot(slot, length * (temperature - REFERENCE))));
        }
    }
}

/// Lengths of a link: constants b, d and r of the frames that it carries.
fn lengths(model: &Model, site: &Site) -> Vec<usize> {
    let carried = model.frames.iter().enumerate().skip(1).filter(|(_, frame)| frame.antecedent == site.frame);
    carried
        .flat_map(|(_, frame)| {
            let prismatic = frame.joint == crate::description::raw::JointKind::Prismatic;
            [Some(frame.slots[2]), Some(frame.slots[4]), (!prismatic).then_some(frame.slots[6])]
        })
        .flatten()
        .filter(|&slot| model.registry[slot].nominal.abs() > 1e-3)
        .collect()
}
