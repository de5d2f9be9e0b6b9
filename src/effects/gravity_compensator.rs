//! `gravity-compensator`: a spring to the previous link unloads a joint and adds stiffness that changes with its angle.

use std::sync::Arc;

use super::law::{Law, nothing};
use crate::model::{Change, EffectParameter, Family, Nonlinear, NonlinearKind, NonlinearValue, SiteKind};

nonlinear! {
    HARMONICS "harmonics", NonlinearKind::Count(MOST_HARMONICS) =>
        "how many harmonics of the joint's angle its compliance has, 1 or 2";
}
/// Two harmonics follow the stiffness of a spring between two links to within a few per cent.
const MOST_HARMONICS: usize = 2;
/// Least load of own weight on a joint that has a compensator, as a share of that on the most loaded joint: builders
/// balance the joints that carry the arm, and no others.
const LEAST_SHARE: f64 = 0.25;

pub(super) static LAW: Law = Law {
    name: "gravity-compensator",
    sits_at: SiteKind::Joint,
    family: Some(|_| Family::Elastic),
    signature: "one joint is stiffer at some of its angles than at others",
    remedy: "describe the compensator (`springs:`) and identify it (`compensator`)",
    nonlinear: &[&HARMONICS],
    candidates: |_, site, survey| {
        let most = survey.greatest_own_load.iter().copied().fold(0.0, f64::max);
        let is_light = site.of(&survey.greatest_own_load).is_some_and(|own| *own < LEAST_SHARE * most);
        let is_loaded = survey.loaded || survey.greatest_load.iter().any(|load| *load > 0.0);
        if is_light || !is_loaded {
            return Vec::new();
        }
        (1..=MOST_HARMONICS).map(|count| Nonlinear::new([(&HARMONICS, NonlinearValue::Count(count))])).collect()
    },
    parameters: Some(|_, _, nonlinear| {
        // Change of compliance over the joint's angle: the stiffness K a L eta(q) of a spring to the previous link, by
        // its first harmonics (its constant part is a joint compliance).
        let symbols = (1..=harmonics(nonlinear)).flat_map(|k| [format!("cos{k}"), format!("sin{k}")]);
        symbols.map(|symbol| EffectParameter::new(symbol, "rad/(N.m)", 3e-8)).collect()
    }),
    compliance: Some(|site, nonlinear, joints| of_angle(harmonics(nonlinear), joints[site.frame]).collect()),
    changes: |_, site, nonlinear| {
        let (Some(v), joint, count) = (site.coordinate, site.frame, harmonics(nonlinear)) else { return nothing() };
        Arc::new(move |context, out| {
            let load = context.of_load(v, |load| load);
            let changes = of_angle(count, context.joints[joint]).enumerate();
            out.extend(changes.map(|(k, change)| (k, Change::Deflection(v, load * change))));
        })
    },
    ..Law::NOTHING
};

/// Cosine and sine of each harmonic of a joint's angle.
fn of_angle(count: usize, joint: f64) -> impl Iterator<Item = f64> {
    (1..=count).flat_map(move |k| {
        let (sine, cosine) = (k as f64 * joint).sin_cos();
        [cosine, sine]
    })
}

fn harmonics(nonlinear: &Nonlinear) -> usize {
    match nonlinear.values()[..] {
        [NonlinearValue::Count(count)] => count,
        _ => 1,
    }
}
