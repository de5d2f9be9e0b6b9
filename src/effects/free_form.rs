//! `free-form`: a curve of what a joint, the base, the tool or the instrument follows, its law not known.
//!
//! A natural cubic spline through amounts at knots. It says where something happens and what it goes with, and no more.

use std::sync::Arc;

use nalgebra::Vector3;

use super::law::{Law, base_moves, nothing, tool_moves};
use crate::math::NaturalSpline;
use crate::model::{Change, Driver, EffectParameter, Family, Nonlinear, NonlinearKind, NonlinearValue, SiteKind};

nonlinear! {
    FOLLOWS "follows", NonlinearKind::Driver =>
        "what the curve goes with (`q3`, `own-load.q3`, `load.q3`, `move.q3`, `time`, `order`, `height`)";
    AT "at", NonlinearKind::Knots =>
        "increasing values of what the curve follows, SI";
}

/// Components of the base that moves: along and about the axes of the measurement frame.
const BASE: &[(&str, &str)] = &[("x", "m"), ("y", "m"), ("z", "m"), ("rx", "rad"), ("ry", "rad"), ("rz", "rad")];
/// Of the tool's point: along the axes of the body that carries it.
const TOOL: &[(&str, &str)] = &[("x", "m"), ("y", "m"), ("z", "m")];
/// Common size of an amount, rad or m.
const SCALE: f64 = 3e-4;
/// Of an instrument, in parts of the distance. A judgement.
const INSTRUMENT_SCALE: f64 = 1e-4;

pub(super) static LAW: Law = Law {
    name: "free-form",
    sits_at: SiteKind::Joint,
    family: Some(|nonlinear| match law(nonlinear) {
        Some((Driver::Angle(_), _)) | None => Family::Kinematic,
        Some((Driver::OwnLoad(_) | Driver::Load(_), _)) => Family::Elastic,
        Some((Driver::LastMove(_), _)) => Family::History,
        Some((Driver::Time | Driver::SessionTime | Driver::Order, _)) => Family::Time,
        Some((Driver::Temperature, _)) => Family::Temperature,
        Some((Driver::Range | Driver::Height, _)) => Family::Instrument,
    }),
    signature: "a curve at one site whose law is not known",
    remedy: "compensate by the curve within the range where it was found; measure there more densely to find its law",
    nonlinear: &[&FOLLOWS, &AT],
    is_free_form: true,
    sites: Some(|model| {
        let kinds = [SiteKind::Joint, SiteKind::Base, SiteKind::Tool, SiteKind::Instrument];
        kinds.into_iter().flat_map(|kind| model.sites(kind)).collect()
    }),
    misplaced: |site, nonlinear| {
        let (driver, _) = law(nonlinear)?;
        let is_where_it_looks = matches!(driver, Driver::Range | Driver::Height);
        let is_of_instrument = site.kind == SiteKind::Instrument;
        (is_where_it_looks && !is_of_instrument)
            .then_some(("follows", "only the instrument's curve can follow `range` or `height` (`site: instrument`)"))
    },
    // Every driver of every joint; of base and tool time and temperature; of the instrument, where it looks. A difference of two
    // readings shows loads alone.
    candidates: |_, site, survey| {
        let is_possible = |driver: Driver| match (site.kind, driver) {
            (SiteKind::Joint, Driver::OwnLoad(v)) => {
                Some(v) == site.coordinate && !survey.is_difference && survey.loaded
            }
            (SiteKind::Joint, Driver::Load(v)) => Some(v) == site.coordinate,
            (SiteKind::Joint, Driver::LastMove(v)) => Some(v) == site.coordinate && !survey.is_difference,
            (_, Driver::Range | Driver::Height) => site.kind == SiteKind::Instrument && !survey.is_difference,
            (SiteKind::Joint, _) => !survey.is_difference,
            (
                SiteKind::Base | SiteKind::Tool,
                Driver::Time | Driver::SessionTime | Driver::Order | Driver::Temperature,
            ) => !survey.is_difference,
            _ => false,
        };
        let of = |(driver, at): &(Driver, Vec<f64>)| {
            let (driver, at) = (NonlinearValue::Driver(*driver), NonlinearValue::Knots(at.as_slice().into()));
            Nonlinear::new([(&FOLLOWS, driver), (&AT, at)])
        };
        survey.knots.iter().filter(|(driver, _)| is_possible(*driver)).map(of).collect()
    },
    parameters: Some(|model, site, nonlinear| {
        let Some((_, knots)) = law(nonlinear) else { return Vec::new() };
        if site.kind == SiteKind::Joint {
            let turns = model.frames[site.frame].joint == crate::description::raw::JointKind::Revolute;
            let unit = if turns { "rad" } else { "m" };
            return (1..=knots.len()).map(|k| EffectParameter::new(format!("k{k}"), unit, SCALE)).collect();
        }
        if site.kind == SiteKind::Instrument {
            return (1..=knots.len()).map(|k| EffectParameter::new(format!("k{k}"), "1", INSTRUMENT_SCALE)).collect();
        }
        let components = if site.kind == SiteKind::Tool { TOOL } else { BASE };
        let of = |k: usize| {
            components.iter().map(move |(symbol, unit)| EffectParameter::new(format!("{symbol}{k}"), unit, SCALE))
        };
        (1..=knots.len()).flat_map(of).collect()
    }),
    changes: |_, site, nonlinear| {
        let Some((driver, knots)) = law(nonlinear) else { return nothing() };
        let Some(spline) = NaturalSpline::new(&knots) else { return nothing() };
        let own = site.coordinate.filter(|_| site.kind == SiteKind::Joint);
        let kind = site.kind;
        Arc::new(move |context, out| {
            if context.is_difference && !matches!(driver, Driver::Load(_)) {
                return;
            }
            let Some(value) = context.driver(driver) else { return };
            let Some(variable) = own else {
                spline.weights(value, |knot, weight| match kind {
                    SiteKind::Tool => tool_moves(context, weight, TOOL.len() * knot, out),
                    // Distances are read too long by a part that changes with where the point is.
                    SiteKind::Instrument => {
                        out.push((knot, Change::Point(weight * context.position, Vector3::zeros())));
                    }
                    _ => base_moves(context, weight, BASE.len() * knot, out),
                });
                return;
            };
            if let Driver::Load(of) = driver {
                spline.weights(value, |knot, weight| out.push((knot, Change::Deflection(variable, weight))));
                if context.is_difference {
                    let before = context.own_load.get(of).copied().unwrap_or_default();
                    spline.weights(before, |knot, weight| out.push((knot, Change::Deflection(variable, -weight))));
                }
            } else if let Driver::OwnLoad(_) = driver {
                spline.weights(value, |knot, weight| out.push((knot, Change::Deflection(variable, weight))));
            } else {
                spline.weights(value, |knot, weight| out.push((knot, Change::Joint(variable, weight))));
            }
        })
    },
    ..Law::NOTHING
};

/// What the curve follows, and its knots.
fn law(nonlinear: &Nonlinear) -> Option<(Driver, Arc<[f64]>)> {
    match &nonlinear.values()[..] {
        [NonlinearValue::Driver(driver), NonlinearValue::Knots(knots)] => Some((*driver, knots.clone())),
        _ => None,
    }
}
