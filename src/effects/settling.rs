//! `settling`: a joint was read before it had come to rest after its last move.

use std::sync::Arc;

use crate::model::{Change, Changes, Condition, Effect, EffectParameter, Model, Nonlinear, Site, SiteKind, Survey};

/// See the module.
pub struct Settling;

impl Effect for Settling {
    fn name(&self) -> &'static str {
        "settling"
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Joint
    }

    fn signature(&self) -> &'static str {
        "an angle of one joint in proportion to its last move"
    }

    fn remedy(&self) -> &'static str {
        "wait longer before reading; evaluate at the commanded joints"
    }

    fn reads(&self) -> &'static [Condition] {
        &[Condition::LastMove]
    }

    /// Only where the campaign gives the order of its readings: that of rows may be any.
    fn candidates(&self, _model: &Model, site: &Site, survey: &Survey) -> Vec<Nonlinear> {
        match survey.moves.get(site.variable) {
            Some(true) if !survey.is_difference => vec![Nonlinear::default()],
            _ => Vec::new(),
        }
    }

    fn parameters(&self, _model: &Model, _site: &Site, _nonlinear: &Nonlinear) -> Vec<EffectParameter> {
        vec![EffectParameter::new("share", "1", 1e-3)]
    }

    fn changes(&self, _model: &Model, site: &Site, _nonlinear: &Nonlinear) -> Changes {
        let variable = site.variable;
        Arc::new(move |context, out| out.push((0, Change::Joint(variable, context.last_move[variable]))))
    }
}
