//! `joint-slip`, `tool-slip`, `marker-slip`: a joint, the tool or one of several markers sits elsewhere from one moment on (a belt that jumped
//! a tooth, a gripper or reflector that was knocked). The base's is the jump of `frame-drift`.

use std::sync::Arc;

use super::frame_drift::{MOST_TIMES, jumps};
use super::law::{Law, nothing, tool_moves};
use crate::model::{
    Change, Changes, Condition, EffectParameter, Nonlinear, NonlinearKind, NonlinearValue, ReadingContext, SiteKind,
    Survey,
};

nonlinear! {
    SLIP_AT "slip_at", NonlinearKind::Real { unit: "s", is_continuous: false, is_positive: false } =>
        "the time from which on it sits elsewhere, s";
}

/// Most times of all markers together: more would crowd out other hypotheses.
const MOST_OF_MARKERS: usize = 240;

/// A joint's zero.
pub(super) static JOINT: Law = Law {
    name: "joint-slip",
    sits_at: SiteKind::Joint,
    remains: Some("joint-offset"),
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
    parameters: Some(|_, _, _| displacement()),
    changes: |_, _, nonlinear| after(nonlinear, |context, amount, out| tool_moves(context, amount, 0, out)),
    ..SLIP
};

/// One marker of several, in the axes of the body that carries it. Of one marker alone it is that of the tool.
pub(super) static MARKER: Law = Law {
    name: "marker-slip",
    sits_at: SiteKind::Marker,
    signature: "readings of one marker jump at one time and stay, with its body",
    remedy: "fasten the marker; name sessions before and after, or leave out its readings from then on",
    is_of_the_measurement: true,
    candidates: |_, site, survey| {
        let is_one_of_several =
            survey.markers.len() > 1 && site.marker.is_some_and(|own| survey.markers.contains(&own));
        let most = MOST_TIMES.min(MOST_OF_MARKERS / survey.markers.len().max(1));
        if is_one_of_several { at_times(survey, most) } else { Vec::new() }
    },
    parameters: Some(|_, _, _| displacement()),
    changes: |_, site, nonlinear| {
        let own = site.marker;
        after(nonlinear, move |context, amount, out| {
            if own.is_some() && context.marker == own {
                tool_moves(context, amount, 0, out);
            }
        })
    },
    ..SLIP
};

/// Parameters of a displacement in axes of a body.
fn displacement() -> Vec<EffectParameter> {
    ["x", "y", "z"].map(|symbol| EffectParameter::new(symbol, "m", 1e-4)).to_vec()
}

const SLIP: Law = Law {
    reads: &[Condition::Time],
    nonlinear: &[&SLIP_AT],
    cancels_in_differences: true,
    candidates: |_, _, survey| at_times(survey, MOST_TIMES),
    ..Law::NOTHING
};

/// Slips at no more than so many times.
fn at_times(survey: &Survey, most: usize) -> Vec<Nonlinear> {
    jumps(survey, most).map(|at| Nonlinear::new([(&SLIP_AT, NonlinearValue::Real(at))])).collect()
}

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
