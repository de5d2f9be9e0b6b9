//! `link-warm-up`, `base-warm-up`, `tool-warm-up`: something comes to its temperature after the start, and no thermometer is
//! there.
//!
//! One time constant (a body that heats evenly) is exponential; heat that spreads into a long or thick body goes on with the
//! logarithm of time.

use std::sync::Arc;

use super::law::{Law, base_moves, nothing, tool_moves};
use super::thermal_expansion::lengths;
use crate::model::{
    Change, Changes, Condition, EffectParameter, Nonlinear, NonlinearKind, NonlinearValue, ReadingContext, SiteKind,
    Survey,
};

const EXPONENTIAL: &str = "exponential";
const LOGARITHMIC: &str = "logarithmic";
nonlinear! {
    COURSE "course", NonlinearKind::Choice(&[EXPONENTIAL, LOGARITHMIC]), or NonlinearValue::Choice(EXPONENTIAL) =>
        "towards an end, 1 - exp(-t / T), or ever more slowly, ln(1 + t / T), t from the start of the session";
    TIME_CONSTANT "time_constant", NonlinearKind::Real { unit: "s", is_continuous: true, is_positive: true } =>
        "T, s";
}

/// Time constants that are tried, as shares of the longest session: shorter ones are over before much is read, longer
/// ones are a steady drift.
const SHARES: [f64; 3] = [0.05, 0.15, 0.4];

/// The lengths of a link grow; by as much as 10 K do to steel.
pub(super) static LINK: Law = Law {
    name: "link-warm-up",
    sits_at: SiteKind::Link,
    recurs: true,
    signature: "a link grows fast after the start and slowly later",
    candidates: |model, site, survey| {
        if lengths(model, site).is_empty() { Vec::new() } else { candidates(survey) }
    },
    parameters: Some(|_, _, _| vec![EffectParameter::new("growth", "1", 1.2e-4)]),
    changes: |model, site, nonlinear| {
        let lengths = lengths(model, site);
        warming(nonlinear, move |_, amount, out| {
            out.extend(lengths.iter().map(|&(slot, length)| (0, Change::Slot(slot, length * amount))));
        })
    },
    ..WARM_UP
};

/// The base moves.
pub(super) static BASE: Law = Law {
    name: "base-warm-up",
    sits_at: SiteKind::Base,
    signature: "the base moves fast after the start and slowly later, whatever the posture",
    is_of_the_measurement: true,
    parameters: Some(|_, _, _| {
        let units = [("x", "m"), ("y", "m"), ("z", "m"), ("rx", "rad"), ("ry", "rad"), ("rz", "rad")];
        units.map(|(symbol, unit)| EffectParameter::new(symbol, unit, 1e-4)).to_vec()
    }),
    changes: |_, _, nonlinear| warming(nonlinear, |context, amount, out| base_moves(context, amount, 0, out)),
    ..WARM_UP
};

/// The tool's points move in the tool's frame.
pub(super) static TOOL: Law = Law {
    name: "tool-warm-up",
    sits_at: SiteKind::Tool,
    recurs: true,
    signature: "the tool's point moves fast after the start and slowly later, with the tool",
    parameters: Some(|_, _, _| ["x", "y", "z"].map(|symbol| EffectParameter::new(symbol, "m", 1e-4)).to_vec()),
    changes: |_, _, nonlinear| warming(nonlinear, |context, amount, out| tool_moves(context, amount, 0, out)),
    ..WARM_UP
};

const WARM_UP: Law = Law {
    remedy: "let the robot run until it is warm before measuring; read a thermometer there",
    reads: &[Condition::Time],
    nonlinear: &[&COURSE, &TIME_CONSTANT],
    cancels_in_differences: true,
    candidates: |_, _, survey| candidates(survey),
    // What takes longer than the session is a steady drift.
    is_another_at_ends: |nonlinear| [false, nonlinear.values().first() == Some(&NonlinearValue::Choice(EXPONENTIAL))],
    ..Law::NOTHING
};

fn candidates(survey: &Survey) -> Vec<Nonlinear> {
    let Some(longest) = survey.longest_session else { return Vec::new() };
    let of = |course: &'static str, share: f64| {
        let (course, constant) = (NonlinearValue::Choice(course), NonlinearValue::Real(share * longest));
        Nonlinear::new([(&COURSE, course), (&TIME_CONSTANT, constant)])
    };
    // The logarithm of one time constant is nearly that of another: one is enough to start from.
    let courses = SHARES.iter().map(|share| of(EXPONENTIAL, *share));
    courses.chain(std::iter::once(of(LOGARITHMIC, SHARES[0]))).collect()
}

/// What one unit changes, given how far it has come by the time of the reading.
fn warming(
    nonlinear: &Nonlinear,
    change: impl Fn(&ReadingContext, f64, &mut Vec<(usize, Change)>) + Send + Sync + 'static,
) -> Changes {
    let [NonlinearValue::Choice(course), NonlinearValue::Real(constant)] = nonlinear.values()[..] else {
        return nothing();
    };
    let warmth = move |time: f64| match course {
        LOGARITHMIC => (time.max(0.0) / constant).ln_1p(),
        _ => 1.0 - (-time.max(0.0) / constant).exp(),
    };
    Arc::new(move |context, out| {
        if let Some(amount) = context.session_time.map(warmth) {
            change(context, amount, out);
        }
    })
}
