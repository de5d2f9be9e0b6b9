//! `frame-drift`: the measurement frame moves with time, or jumps.

use nalgebra::Vector3;

use super::{Change, Effect, EffectParameter, Form, Moment, Site, SiteKind, Survey};
use crate::model::Model;

/// Most places of a jump that are tried.
const PLACES: usize = 24;

/// See the module.
pub struct FrameDrift;

impl Effect for FrameDrift {
    fn name(&self) -> &'static str {
        "frame-drift"
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Base
    }

    fn is_of_the_measurement(&self) -> bool {
        true
    }

    fn signature(&self) -> &'static str {
        "all readings move together with time, steadily or at one moment, whatever the posture"
    }

    fn remedy(&self) -> &'static str {
        "fasten tracker and robot; measure a fixed target between poses"
    }

    fn form_symbols(&self) -> &'static [&'static str] {
        &["jump_at"]
    }

    fn forms(&self, _model: &Model, _site: &Site, survey: &Survey) -> Vec<Form> {
        let (Some(&first), Some(&last)) = (survey.times.first(), survey.times.last()) else { return Vec::new() };
        if survey.is_difference || last <= first {
            return Vec::new();
        }
        // Steady drift, then jumps between two configurations. A negative time stands for no jump.
        let mut forms = vec![Form { symbol: "jump_at", value: -1.0, continuous: false }];
        let count = survey.times.len();
        for k in 1..=PLACES.min(count.saturating_sub(6)) {
            let at = 3 + (count - 6) * k / (PLACES.min(count - 6) + 1);
            let value = 0.5 * (survey.times[at - 1] + survey.times[at]);
            forms.push(Form { symbol: "jump_at", value, continuous: false });
        }
        forms
    }

    fn parameters(&self, _model: &Model, _site: &Site, form: &Form) -> Vec<EffectParameter> {
        let steady = form.value < 0.0;
        let parameter = |symbol: &str, turn: bool| EffectParameter {
            symbol: symbol.into(),
            unit: match (steady, turn) {
                (true, false) => "m/s",
                (true, true) => "rad/s",
                (false, false) => "m",
                (false, true) => "rad",
            },
            scale: if steady { 1e-8 } else { 1e-4 },
            is_positive: false,
        };
        [("x", false), ("y", false), ("z", false), ("rx", true), ("ry", true), ("rz", true)]
            .map(|(symbol, turn)| parameter(symbol, turn))
            .to_vec()
    }

    fn changes(&self, _site: &Site, form: &Form, moment: &Moment, out: &mut Vec<(usize, Change)>) {
        let Some(time) = moment.time else { return };
        let amount = if form.value < 0.0 { time } else { f64::from(u8::from(time >= form.value)) };
        for k in 0..3 {
            let mut axis = Vector3::zeros();
            axis[k] = amount;
            out.push((k, Change::Point(axis, Vector3::zeros())));
            out.push((k + 3, Change::Point(axis.cross(&(moment.position - moment.base)), axis)));
        }
    }
}
