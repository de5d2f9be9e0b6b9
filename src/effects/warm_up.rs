//! `link-warm-up`, `base-warm-up`, `tool-warm-up`: something comes to its temperature after the start, and no thermometer is
//! there.
//!
//! One time constant (a body that heats evenly) is exponential; heat that spreads into a long or thick body goes on with the
//! logarithm of time.

use std::sync::Arc;

use nalgebra::Vector3;

use super::thermal_expansion::lengths;
use crate::model::{
    Change, Changes, Condition, Effect, EffectParameter, Model, Nonlinear, NonlinearKind, NonlinearParameter,
    NonlinearValue, Site, SiteKind, Survey,
};

const EXPONENTIAL: &str = "exponential";
const LOGARITHMIC: &str = "logarithmic";
static COURSE: NonlinearParameter = NonlinearParameter {
    name: "course",
    kind: NonlinearKind::Choice(&[EXPONENTIAL, LOGARITHMIC]),
    default: Some(NonlinearValue::Choice(EXPONENTIAL)),
    only_with: None,
    meaning: "`course`: towards an end, 1 - exp(-t / T), or ever more slowly, ln(1 + t / T), t from the start of the session",
};
static TIME_CONSTANT: NonlinearParameter = NonlinearParameter {
    name: "time_constant",
    kind: NonlinearKind::Real { unit: "s", is_continuous: true, is_positive: true },
    default: None,
    only_with: None,
    meaning: "`time_constant`: T, s",
};

/// Time constants that are tried, as shares of the longest session: shorter ones are over before much is read, longer
/// ones are a steady drift.
const SHARES: [f64; 3] = [0.05, 0.15, 0.4];

/// What warms up.
#[derive(Clone, Copy, PartialEq)]
pub enum WarmUp {
    /// The lengths of a link grow.
    Link,
    /// The base moves.
    Base,
    /// The tool's points move in the tool's frame.
    Tool,
}

impl Effect for WarmUp {
    fn name(&self) -> &'static str {
        match self {
            Self::Link => "link-warm-up",
            Self::Base => "base-warm-up",
            Self::Tool => "tool-warm-up",
        }
    }

    fn sits_at(&self) -> SiteKind {
        match self {
            Self::Link => SiteKind::Link,
            Self::Base => SiteKind::Base,
            Self::Tool => SiteKind::Tool,
        }
    }

    fn is_of_the_measurement(&self) -> bool {
        *self == Self::Base
    }

    fn signature(&self) -> &'static str {
        match self {
            Self::Link => "a link grows fast after the start and slowly later",
            Self::Base => "the base moves fast after the start and slowly later, whatever the posture",
            Self::Tool => "the tool's point moves fast after the start and slowly later, with the tool",
        }
    }

    fn remedy(&self) -> &'static str {
        "let the robot run until it is warm before measuring; read a thermometer there"
    }

    fn reads(&self) -> &'static [Condition] {
        &[Condition::Time]
    }

    fn nonlinear_parameters(&self) -> Vec<&'static NonlinearParameter> {
        vec![&COURSE, &TIME_CONSTANT]
    }

    fn candidates(&self, model: &Model, site: &Site, survey: &Survey) -> Vec<Nonlinear> {
        let is_possible = !survey.is_difference && (*self != Self::Link || !lengths(model, site).is_empty());
        let Some(longest) = survey.longest_session.filter(|_| is_possible) else { return Vec::new() };
        let of = |course: &'static str, share: f64| {
            let (course, constant) = (NonlinearValue::Choice(course), NonlinearValue::Real(share * longest));
            Nonlinear::new([(&COURSE, course), (&TIME_CONSTANT, constant)])
        };
        // The logarithm of one time constant is nearly that of another: one is enough to start from.
        let courses = SHARES.iter().map(|share| of(EXPONENTIAL, *share));
        courses.chain(std::iter::once(of(LOGARITHMIC, SHARES[0]))).collect()
    }

    /// What takes longer than the session is a steady drift.
    fn is_another_at_ends(&self, nonlinear: &Nonlinear) -> [bool; 2] {
        [false, nonlinear.values().first() == Some(&NonlinearValue::Choice(EXPONENTIAL))]
    }

    fn parameters(&self, _model: &Model, _site: &Site, _nonlinear: &Nonlinear) -> Vec<EffectParameter> {
        let length = |symbol| EffectParameter::new(symbol, "m", 1e-4);
        match self {
            // As much as 10 K do to steel.
            Self::Link => vec![EffectParameter::new("growth", "1", 1.2e-4)],
            Self::Tool => ["x", "y", "z"].map(length).to_vec(),
            Self::Base => {
                let turns = ["rx", "ry", "rz"].map(|symbol| EffectParameter::new(symbol, "rad", 1e-4));
                ["x", "y", "z"].map(length).into_iter().chain(turns).collect()
            }
        }
    }

    fn changes(&self, model: &Model, site: &Site, nonlinear: &Nonlinear) -> Changes {
        let [NonlinearValue::Choice(course), NonlinearValue::Real(constant)] = nonlinear.values()[..] else {
            return Arc::new(|_, _| {});
        };
        let warmth = move |time: f64| match course {
            LOGARITHMIC => (time.max(0.0) / constant).ln_1p(),
            _ => 1.0 - (-time.max(0.0) / constant).exp(),
        };
        let what = *self;
        let lengths = if what == Self::Link { lengths(model, site) } else { Vec::new() };
        Arc::new(move |context, out| {
            let Some(amount) = context.session_time.map(warmth) else { return };
            match what {
                Self::Link => {
                    out.extend(lengths.iter().map(|&(slot, length)| (0, Change::Slot(slot, length * amount))));
                }
                Self::Tool => {
                    let moved = |k| context.body * Vector3::ith(k, amount);
                    out.extend((0..3).map(|k| (k, Change::Point(moved(k), Vector3::zeros()))));
                }
                Self::Base => {
                    for k in 0..3 {
                        let axis = Vector3::ith(k, amount);
                        out.push((k, Change::Point(axis, Vector3::zeros())));
                        out.push((k + 3, Change::Point(axis.cross(&(context.position - context.base)), axis)));
                    }
                }
            }
        })
    }
}
