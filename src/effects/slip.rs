//! `joint-slip`, `tool-slip`: a joint or the tool sits elsewhere from one moment on (a belt that jumped a tooth, a gripper or
//! marker that was knocked). The base's is the jump of `frame-drift`.

use std::sync::Arc;

use nalgebra::Vector3;

use super::frame_drift::jumps;
use crate::model::{
    Change, Changes, Condition, Effect, EffectParameter, Model, Nonlinear, NonlinearKind, NonlinearParameter,
    NonlinearValue, Site, SiteKind, Survey,
};

static SLIP_AT: NonlinearParameter = NonlinearParameter {
    name: "slip_at",
    kind: NonlinearKind::Real { unit: "s", is_continuous: false, is_positive: false },
    default: None,
    only_with: None,
    meaning: "`slip_at`: the time from which on it sits elsewhere, s",
};

/// Most times that are tried: readings between the true one and the nearest tried are outliers to the law.
const MOST_TIMES: usize = 60;

/// What slips.
#[derive(Clone, Copy, PartialEq)]
pub enum Slip {
    /// A joint's zero.
    Joint,
    /// The tool's points, in the tool's frame.
    Tool,
}

impl Effect for Slip {
    fn name(&self) -> &'static str {
        match self {
            Self::Joint => "joint-slip",
            Self::Tool => "tool-slip",
        }
    }

    fn sits_at(&self) -> SiteKind {
        match self {
            Self::Joint => SiteKind::Joint,
            Self::Tool => SiteKind::Tool,
        }
    }

    /// A tool that slipped is the tool of that day.
    fn is_of_the_measurement(&self) -> bool {
        *self == Self::Tool
    }

    fn signature(&self) -> &'static str {
        match self {
            Self::Joint => "an angle of one joint that jumps at one time and stays",
            Self::Tool => "the tool's point jumps at one time and stays, with the tool",
        }
    }

    fn remedy(&self) -> &'static str {
        match self {
            Self::Joint => "look at belt, coupling and encoder of the joint; master it anew",
            Self::Tool => "fasten tool and markers; measure the tool anew",
        }
    }

    fn reads(&self) -> &'static [Condition] {
        &[Condition::Time]
    }

    fn nonlinear_parameters(&self) -> Vec<&'static NonlinearParameter> {
        vec![&SLIP_AT]
    }

    fn candidates(&self, _model: &Model, _site: &Site, survey: &Survey) -> Vec<Nonlinear> {
        jumps(survey, MOST_TIMES).map(|at| Nonlinear::new([(&SLIP_AT, NonlinearValue::Real(at))])).collect()
    }

    fn parameters(&self, model: &Model, site: &Site, _nonlinear: &Nonlinear) -> Vec<EffectParameter> {
        let length = |symbol| EffectParameter::new(symbol, "m", 1e-4);
        match self {
            Self::Tool => ["x", "y", "z"].map(length).to_vec(),
            Self::Joint => {
                let turns = model.frames[site.frame].joint == crate::description::raw::JointKind::Revolute;
                vec![EffectParameter::new("offset", if turns { "rad" } else { "m" }, 3e-4)]
            }
        }
    }

    fn changes(&self, _model: &Model, site: &Site, nonlinear: &Nonlinear) -> Changes {
        let [NonlinearValue::Real(at)] = nonlinear.values()[..] else { return Arc::new(|_, _| {}) };
        let (variable, what) = (site.variable, *self);
        Arc::new(move |context, out| {
            let amount = f64::from(u8::from(context.time.is_some_and(|time| time >= at)));
            match what {
                Self::Joint => out.push((0, Change::Joint(variable, amount))),
                Self::Tool => {
                    let moved = |k| context.body * Vector3::ith(k, amount);
                    out.extend((0..3).map(|k| (k, Change::Point(moved(k), Vector3::zeros()))));
                }
            }
        })
    }
}
