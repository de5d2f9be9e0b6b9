//! `payload`: mass or centre of mass of what is carried, or the applied wrench, mis-stated.

use std::sync::Arc;

use nalgebra::Vector3;

use super::law::{Law, nothing};
use crate::model::{Change, EffectParameter, Family, Nonlinear, NonlinearKind, NonlinearValue, SiteKind};

const MASS: &str = "mass";
const WRENCH: &str = "wrench";
nonlinear! {
    MISSTATED "misstated", NonlinearKind::Choice(&[MASS, WRENCH]), or NonlinearValue::Choice(MASS) =>
        "the mass of what is carried, or the size of the applied wrench";
}

pub(super) static LAW: Law = Law {
    name: "payload",
    sits_at: SiteKind::Tool,
    family: Some(|_| Family::Elastic),
    signature: "all deflections under the applied load are in proportion too great or small; or the arm sags as if the tool weighed more",
    remedy: "weigh the tool; calibrate the load cell or the pulley",
    nonlinear: &[&MISSTATED],
    candidates: |model, site, survey| {
        let of = |what| Nonlinear::new([(&MISSTATED, NonlinearValue::Choice(what))]);
        let carries = !(LAW.constants)(model, site, &of(MASS)).is_empty();
        let shows_mass = carries && !survey.is_difference && survey.greatest_load.iter().any(|load| *load > 0.0);
        let wrench = survey.loaded.then(|| of(WRENCH));
        wrench.into_iter().chain(shows_mass.then(|| of(MASS))).collect()
    },
    constants: |model, _, nonlinear| {
        if is_of_wrench(nonlinear) {
            return Vec::new();
        }
        let tool = &model.frames[model.tool.0].name;
        model.slots_named(["mass", "x", "y", "z"].map(|symbol| format!("body{tool}.{symbol}")))
    },
    parameters: Some(|model, site, nonlinear| {
        if is_of_wrench(nonlinear) {
            return vec![EffectParameter::new("gain", "1", 0.02)];
        }
        model.shifts_of(&(LAW.constants)(model, site, nonlinear))
    }),
    changes: |_, _, nonlinear| {
        if !is_of_wrench(nonlinear) {
            return nothing();
        }
        Arc::new(|context, out| out.push((0, Change::Point(context.deflection, Vector3::zeros()))))
    },
    ..Law::NOTHING
};

fn is_of_wrench(nonlinear: &Nonlinear) -> bool {
    nonlinear.values()[..] == [NonlinearValue::Choice(WRENCH)]
}
