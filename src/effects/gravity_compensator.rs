//! `gravity-compensator`: a spring to the previous link unloads a joint and adds stiffness that changes with its angle.

use std::sync::Arc;

use crate::model::{
    Change, Changes, Effect, EffectParameter, Family, Model, Nonlinear, NonlinearKind, NonlinearParameter,
    NonlinearValue, Site, SiteKind, Survey,
};

static HARMONICS: NonlinearParameter = NonlinearParameter {
    name: "harmonics",
    kind: NonlinearKind::Count(MOST_HARMONICS),
    default: None,
    only_with: None,
    meaning: "`harmonics`: how many harmonics of the joint's angle its compliance has, 1 or 2",
};
/// Two harmonics follow the stiffness of a spring between two links to within a few per cent.
const MOST_HARMONICS: usize = 2;
/// Least load of own weight on a joint that has a compensator, as a share of that on the most loaded joint: builders
/// balance the joints that carry the arm, and no others.
const LEAST_SHARE: f64 = 0.25;

/// See the module.
pub struct GravityCompensator;

impl Effect for GravityCompensator {
    fn name(&self) -> &'static str {
        "gravity-compensator"
    }

    fn family(&self, _nonlinear: &Nonlinear) -> Family {
        Family::Elastic
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

    fn nonlinear_parameters(&self) -> Vec<&'static NonlinearParameter> {
        vec![&HARMONICS]
    }

    fn candidates(&self, _model: &Model, site: &Site, survey: &Survey) -> Vec<Nonlinear> {
        let most = survey.greatest_own_load.iter().copied().fold(0.0, f64::max);
        let is_light = survey.greatest_own_load.get(site.variable).is_some_and(|own| *own < LEAST_SHARE * most);
        let is_loaded = survey.loaded || survey.greatest_load.iter().any(|load| *load > 0.0);
        if is_light || !is_loaded {
            return Vec::new();
        }
        (1..=MOST_HARMONICS).map(|count| Nonlinear::new([(&HARMONICS, NonlinearValue::Count(count))])).collect()
    }

    fn parameters(&self, _model: &Model, _site: &Site, nonlinear: &Nonlinear) -> Vec<EffectParameter> {
        // Change of compliance over the joint's angle: the stiffness K a L eta(q) of a spring to the previous link, by
        // its first harmonics (its constant part is a joint compliance).
        let symbols = (1..=harmonics(nonlinear)).flat_map(|k| [format!("cos{k}"), format!("sin{k}")]);
        symbols.map(|symbol| EffectParameter::new(symbol, "rad/(N.m)", 3e-8)).collect()
    }

    fn changes(&self, _model: &Model, site: &Site, nonlinear: &Nonlinear) -> Changes {
        let (v, joint, count) = (site.variable, site.frame, harmonics(nonlinear));
        Arc::new(move |context, out| {
            let load = context.of_load(v, |load| load);
            for k in 0..count {
                let (sine, cosine) = ((k + 1) as f64 * context.joints[joint]).sin_cos();
                out.push((2 * k, Change::Deflection(v, load * cosine)));
                out.push((2 * k + 1, Change::Deflection(v, load * sine)));
            }
        })
    }
}

fn harmonics(nonlinear: &Nonlinear) -> usize {
    match nonlinear.values()[..] {
        [NonlinearValue::Count(count)] => count,
        _ => 1,
    }
}
