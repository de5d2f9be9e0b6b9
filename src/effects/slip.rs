//! `joint-slip`, `tool-slip`: a joint or the tool sits elsewhere from one moment on (a belt that jumped a tooth, a gripper or
//! marker that was knocked). The base's is the jump of `frame-drift`.

use std::sync::Arc;

use super::frame_drift::jumps;
use super::law::{Law, nothing, tool_moves};
use crate::model::{
    Change, Changes, Condition, EffectParameter, Nonlinear, NonlinearKind, NonlinearParameter, NonlinearValue,
    ReadingContext, SiteKind,
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

/// A joint's zero.
pub(super) static JOINT: Law = Law {
    name: "joint-slip",
    sits_at: SiteKind::Joint,
    signature: "an angle of one joint that jumps at one time and stays",
    remedy: "look at belt, coupling and encoder of the joint; master it anew",
    parameters: Some(|model, site, _| {
        let turns = model.frames[site.frame].joint == crate::description::raw::JointKind::Revolute;
        vec![EffectParameter::new("offset", if turns { "rad" } else { "m" }, 3e-4)]
    }),
    changes: |_, site, nonlinear| {
        let Some(variable) = site.coordinate else { return nothing() };
        after(nonlinear, move |_, amount, out| out.push((0, Change::Joint(variable, amount))))
    },
    ..SLIP
};

/// The tool's points, in the tool's frame. A tool that slipped is the tool of that day.
pub(super) static TOOL: Law = Law {
    name: "tool-slip",
    sits_at: SiteKind::Tool,
    signature: "the tool's point jumps at one time and stays, with the tool",
    remedy: "fasten tool and markers; measure the tool anew",
    is_of_the_measurement: true,
    parameters: Some(|_, _, _| ["x", "y", "z"].map(|symbol| EffectParameter::new(symbol, "m", 1e-4)).to_vec()),
    changes: |_, _, nonlinear| after(nonlinear, |context, amount, out| tool_moves(context, amount, 0, out)),
    ..SLIP
};

const SLIP: Law = Law {
    reads: &[Condition::Time],
    nonlinear: &[&SLIP_AT],
    cancels_in_differences: true,
    candidates: |_, _, survey| {
        jumps(survey, MOST_TIMES).map(|at| Nonlinear::new([(&SLIP_AT, NonlinearValue::Real(at))])).collect()
    },
    ..Law::NOTHING
};

/// What one unit changes from the time of the slip on, given 0 before and 1 after.
fn after(
    nonlinear: &Nonlinear,
    change: impl Fn(&ReadingContext, f64, &mut Vec<(usize, Change)>) + Send + Sync + 'static,
) -> Changes {
    let [NonlinearValue::Real(at)] = nonlinear.values()[..] else { return nothing() };
    Arc::new(move |context, out| {
        change(context, f64::from(u8::from(context.time.is_some_and(|time| time >= at))), out);
    })
}
