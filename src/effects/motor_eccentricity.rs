//! `motor-eccentricity`: periodic error of the motor's side of a gear: its shaft, its encoder, the first pinion.
//!
//! Once or twice a turn of the motor: that many times the gear ratio in a turn of the joint, which is seldom a whole number. Only
//! where the description gives the ratio: searched for blindly, some such order fits any noise.

use std::sync::Arc;

use super::transmission_error::{ORDER, periodic};
use crate::model::{
    Changes, Condition, Effect, EffectParameter, Model, Nonlinear, NonlinearParameter, NonlinearValue, Site, SiteKind,
    Survey,
};

/// Periods in a turn of the motor: an eccentric shaft, and an elliptic one or a bent coupling.
const PERIODS: [f64; 2] = [1.0, 2.0];

/// See the module.
pub struct MotorEccentricity;

impl Effect for MotorEccentricity {
    fn name(&self) -> &'static str {
        "motor-eccentricity"
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Joint
    }

    fn signature(&self) -> &'static str {
        "an angle of one joint that swings once or twice a turn of its motor"
    }

    fn remedy(&self) -> &'static str {
        "measure the joint over one turn of its motor in small steps; look at coupling, encoder and first gear stage"
    }

    fn reads(&self) -> &'static [Condition] {
        &[Condition::GearRatio]
    }

    fn nonlinear_parameters(&self) -> Vec<&'static NonlinearParameter> {
        vec![&ORDER]
    }

    fn candidates(&self, model: &Model, site: &Site, survey: &Survey) -> Vec<Nonlinear> {
        let ratio = model.variables.get(site.variable).and_then(|variable| variable.gear_ratio);
        let Some(ratio) = ratio.filter(|_| !survey.is_difference) else { return Vec::new() };
        PERIODS.map(|periods| Nonlinear::new([(&ORDER, NonlinearValue::Real(periods * ratio))])).to_vec()
    }

    fn parameters(&self, _model: &Model, _site: &Site, _nonlinear: &Nonlinear) -> Vec<EffectParameter> {
        ["cos", "sin"].map(|symbol| EffectParameter::new(symbol, "rad", 1e-4)).to_vec()
    }

    fn changes(&self, _model: &Model, site: &Site, nonlinear: &Nonlinear) -> Changes {
        let [NonlinearValue::Real(order)] = nonlinear.values()[..] else { return Arc::new(|_, _| {}) };
        periodic(site, order)
    }
}
