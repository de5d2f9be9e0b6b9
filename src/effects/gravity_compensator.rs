//! `gravity-compensator`: a spring to the previous link unloads a joint and adds stiffness that changes with its angle.

use super::{Change, Effect, EffectParameter, Form, Moment, Site, SiteKind, Survey};
use crate::model::Model;

/// Own weight on a joint that is worth a compensator, as a share of that on the most loaded joint.
const WORTH: f64 = 0.25;

/// See the module.
pub struct GravityCompensator;

impl Effect for GravityCompensator {
    fn name(&self) -> &'static str {
        "gravity-compensator"
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Joint
    }

    fn signature(&self) -> &'static str {
        "one joint is stiffer at some of its angles than at others"
    }

    fn remedy(&self) -> &'static str {
        "describe the compensator (`springs:`) and identify it (`compensator`)"
    }

    fn form_symbols(&self) -> &'static [&'static str] {
        &["harmonics"]
    }

    fn forms(&self, _model: &Model, site: &Site, survey: &Survey) -> Vec<Form> {
        // Nobody balances a joint that own weight hardly loads.
        let most = survey.greatest_own_load.iter().copied().fold(0.0, f64::max);
        if survey.greatest_own_load.get(site.variable).is_some_and(|own| *own < WORTH * most) {
            return Vec::new();
        }
        let form = |value: f64| Form { symbol: "harmonics", value, continuous: false };
        if survey.loaded || survey.greatest_load.iter().any(|load| *load > 0.0) {
            vec![form(1.0), form(2.0)]
        } else {
            Vec::new()
        }
    }

    fn parameters(&self, _model: &Model, _site: &Site, form: &Form) -> Vec<EffectParameter> {
        // Change of compliance over the joint's angle: the stiffness K a L eta(q) of a spring to the previous link, by
        // its first harmonics (its constant part is a joint compliance).
        let parameter = |symbol: String| EffectParameter { symbol, unit: "rad/(N.m)", scale: 3e-8, is_positive: false };
        (1..=form.value as usize).flat_map(|k| [format!("cos{k}"), format!("sin{k}")]).map(parameter).collect()
    }

    fn changes(&self, site: &Site, form: &Form, moment: &Moment, out: &mut Vec<(usize, Change)>) {
        let v = site.variable;
        let load = moment.load[v] - if moment.is_difference { moment.own_load[v] } else { 0.0 };
        for k in 0..form.value as usize {
            let (sine, cosine) = ((k + 1) as f64 * moment.joints[site.frame]).sin_cos();
            out.push((2 * k, Change::Yield(v, load * cosine)));
            out.push((2 * k + 1, Change::Yield(v, load * sine)));
        }
    }
}
