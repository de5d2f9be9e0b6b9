//! `payload`: mass or centre of mass of what is carried, or the applied wrench, mis-stated.

use nalgebra::Vector3;

use super::{Change, Effect, EffectParameter, Form, Moment, Site, SiteKind, Survey, of_slots};
use crate::model::Model;
use crate::parameter::Slot;

/// Form: what is carried weighs more.
const MASS: f64 = 0.0;
/// Form: the wrench is in proportion greater than stated.
const GAIN: f64 = 1.0;

/// See the module.
pub struct Payload;

impl Effect for Payload {
    fn name(&self) -> &'static str {
        "payload"
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

    fn form_symbols(&self) -> &'static [&'static str] {
        &["of_wrench"]
    }

    fn forms(&self, model: &Model, _site: &Site, survey: &Survey) -> Vec<Form> {
        let form = |value: f64| Form { symbol: "of_wrench", value, continuous: false };
        let mut forms = Vec::new();
        if survey.loaded {
            forms.push(form(GAIN));
        }
        if carried(model).is_some() && !survey.is_difference && survey.greatest_load.iter().any(|load| *load > 0.0) {
            forms.push(form(MASS));
        }
        forms
    }

    fn constants(&self, model: &Model, _site: &Site, form: &Form) -> Vec<Slot> {
        let of_mass = |slot: Slot| (slot..slot + 4).collect();
        if form.value == GAIN { Vec::new() } else { carried(model).map_or_else(Vec::new, of_mass) }
    }

    fn parameters(&self, model: &Model, site: &Site, form: &Form) -> Vec<EffectParameter> {
        if form.value == GAIN {
            return vec![EffectParameter { symbol: "gain".into(), unit: "1", scale: 0.02, is_positive: false }];
        }
        of_slots(model, &self.constants(model, site, form))
    }

    fn changes(&self, _site: &Site, form: &Form, moment: &Moment, out: &mut Vec<(usize, Change)>) {
        if form.value == GAIN {
            out.push((0, Change::Point(moment.deflection, Vector3::zeros())));
        }
    }
}

/// First slot of the mass that the description puts on the tool's frame, if any.
fn carried(model: &Model) -> Option<usize> {
    model.registry.slot(&format!("body{}.mass", model.frames[model.tool.0].name))
}
