//! Where a gravity compensator is hung and what its spring is, against those of machines.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use nalgebra::Vector3;

use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::compensator::{
    Circle, Elasticity, JointCompliance, Mounting, Triangle, Value, circle, elasticity,
};
use crate::math::extremes;
use crate::math::quantiles::{f_tail, normal95};

/// Levers of compensators, m: from a fitting on a desktop arm's link to one on the largest palletiser's.
const LEVER: RangeInclusive<f64> = 0.01..=3.0;
/// Distances of a compensator's anchor from the joint, m.
const BASE: RangeInclusive<f64> = 0.01..=10.0;
/// Compliances of joints, rad/(N.m). Joints of arms that need a compensator have 1e3 to 1e8 N.m/rad; ten times as much on both
/// sides. A judgement, as the other ranges are: they tell units from each other, not good joints from bad ones.
const JOINT: RangeInclusive<f64> = 1e-9..=1e-2;
/// Compliances of springs, m/N: from a bar of steel (1e9 N/m and more) to one that 10 N stretch by a metre.
const SPRING: RangeInclusive<f64> = 1e-10..=0.1;
/// A free length over the greatest length of the spring at the angles given; one with initial tension may be below 0.
const FREE_LENGTH: RangeInclusive<f64> = -1.0..=3.0;
/// Distance of measured points from where the angles put them on their circle, over its radius: two degrees.
const OFF_CIRCLE: f64 = 0.035;
/// How much better they agree when the angles are read otherwise.
const FALL: f64 = 4.0;

/// Where the spring is hung: lengths as of machines, and points that turn by the angles given (rad).
pub fn of_mounting(
    points: &[(f64, Vector3<f64>)],
    mounting: Option<&Mounting>,
    triangle: Option<&Triangle>,
) -> Vec<Diagnostic> {
    let lever = mounting.map(|found| found.lever.value).or(triangle.map(|triangle| triangle.lever));
    let lengths = [("the lever L", lever, LEVER), ("a, from joint to anchor,", triangle.map(Triangle::base), BASE)];
    let far = lengths.into_iter().filter_map(|(name, value, range)| {
        let value = value.filter(|value| !range.contains(value))?;
        let message =
            format!("{name} is {:.4} mm; typical are {} to {} mm", 1e3 * value, 1e3 * range.start(), 1e3 * range.end());
        Some(Diagnostic::error(message).code(Code::WrongUnits).figure("metres", value).remedy("give coordinates in mm"))
    });
    let far: Vec<Diagnostic> = far.collect();
    let turned = mounting.and_then(|found| turned(points, &found.circle, !far.is_empty()));
    match turned {
        Some(turned) => vec![turned],
        None => far,
    }
}

/// Points that do not turn by the angles given with them; where their lengths are far off, only with what explains it.
fn turned(points: &[(f64, Vector3<f64>)], found: &Circle, is_far: bool) -> Option<Diagnostic> {
    let off = off(points, found);
    let share = off / found.radius.abs().max(f64::MIN_POSITIVE);
    let read = |factor: f64| {
        let points: Vec<_> = points.iter().map(|(q, p)| (q * factor, *p)).collect();
        circle(&points).is_ok_and(|other| self::off(&points, &other) * FALL < off)
    };
    if share <= OFF_CIRCLE && !is_far {
        return None;
    }
    let message = format!(
        "the points of --circle are {:.3} mm ({:.1} % of the lever) from where their angles q put them, most the one at {:.2} deg",
        1e3 * off,
        1e2 * share,
        farthest(points, found).to_degrees()
    );
    let found = Diagnostic::error(message).figure("metres", off);
    match (read(1f64.to_degrees()), read(1f64.to_radians())) {
        (true, _) => Some(found.code(Code::WrongUnits).remedy("with q read in rad they agree: give deg")),
        (_, true) => Some(found.code(Code::WrongUnits).remedy("they agree with q divided by 57.3: convert it once")),
        _ if share <= OFF_CIRCLE => None,
        _ => {
            Some(found.code(Code::Misread).remedy("look at the order of the rows, and whether q is the joint's angle"))
        }
    }
}

/// Angle (rad) of the point without which the others agree best.
fn farthest(points: &[(f64, Vector3<f64>)], all: &Circle) -> f64 {
    let without = |k: usize| {
        let others: Vec<_> = points.iter().enumerate().filter(|(other, _)| *other != k).map(|(_, at)| *at).collect();
        let own = circle(&others).unwrap_or(*all);
        off(&others, &own)
    };
    let best = (0..points.len()).min_by(|&a, &b| without(a).total_cmp(&without(b)));
    best.and_then(|k| points.get(k)).map_or(0.0, |(q, _)| *q)
}

/// Root mean square distance of points from their places on the circle, m.
fn off(points: &[(f64, Vector3<f64>)], circle: &Circle) -> f64 {
    let square = |(q, p): &(f64, Vector3<f64>)| {
        let place = circle.centre + circle.axes * Vector3::new(q.cos(), q.sin(), 0.0) * circle.radius;
        (p - place).norm_squared()
    };
    let mean = points.iter().map(square).sum::<f64>() / points.len().max(1) as f64;
    mean.sqrt()
}

/// Compliances of the joint as of machines, at angles (rad) in deg: before a spring is fitted to them.
pub fn of_compliances(given: &[JointCompliance]) -> Vec<Diagnostic> {
    let [least, most] = extremes(given.iter().map(|k| k.compliance));
    let mut found = Vec::new();
    let is_usual = JOINT.contains(&least) && JOINT.contains(&most);
    if !is_usual && !given.is_empty() {
        let message = format!(
            "compliances k2 of {:.3e} to {:.3e} rad/(N.m); those of joints are {:e} to {:e}",
            least,
            most,
            JOINT.start(),
            JOINT.end()
        );
        let remedy = "give compliances (not stiffnesses) in 1e-6 rad/(N.m)";
        found.push(Diagnostic::error(message).code(Code::WrongUnits).figure("compliance", most).remedy(remedy));
    }
    let [least, most] = extremes(given.iter().map(|k| k.angle.to_degrees()));
    if given.len() > 2 && most - least <= TAU {
        let message =
            format!("the angles q of the compliances span {:.2} deg, from {least:.2} to {most:.2}", most - least);
        let remedy = "give q in deg; only angles far apart separate a spring from its joint";
        found.push(Diagnostic::error(message).code(Code::WrongUnits).figure("deg", most - least).remedy(remedy));
    }
    found
}

/// Joint and spring as of machines, and seen by the compliances given at angles (rad).
pub fn of_elasticity(triangle: &Triangle, given: &[JointCompliance], found: &Elasticity) -> Vec<Diagnostic> {
    let [_, longest] = extremes(given.iter().map(|at| triangle.length(at.angle)));
    let free = *FREE_LENGTH.start() * longest..=*FREE_LENGTH.end() * longest;
    let values: [(&str, &Value, RangeInclusive<f64>, &str, f64); 3] = [
        ("k2_0", &found.joint, JOINT, "1e-6 rad/(N.m)", 1e-6),
        ("kc", &found.spring, SPRING, "1e-6 m/N", 1e-6),
        ("s0", &found.free_length, free, "mm", 1e-3),
    ];
    let mut doubts: Vec<Diagnostic> =
        negated(triangle, given, found).into_iter().chain(misfit(triangle, given, found)).collect();
    for (name, value, range, unit, size) in values {
        let [at, low, high] = [value.value, *range.start(), *range.end()].map(|value| value / size);
        if !range.contains(&value.value) {
            let message = format!("{name} is {at:.4} {unit}; typical are {low:.4} to {high:.4}");
            let remedy = "look at the units of the compliances, at the angles and their sign, and at L, ax and ay";
            doubts.push(Diagnostic::error(message).code(Code::Implausible).figure("value", value.value).remedy(remedy));
        } else if let Some(wide) = value.ci95.filter(|width| *width >= value.value.abs()) {
            let message = format!("{name} is not determined: {at:.4} +- {:.4} {unit}", wide / size);
            let remedy = "measure at more angles, farther apart";
            doubts.push(Diagnostic::warning(message).code(Code::TooLittleData).figure("ci95", wide).remedy(remedy));
        }
    }
    doubts
}

/// Angles of the other sense, with which the law goes through the compliances.
fn negated(triangle: &Triangle, given: &[JointCompliance], found: &Elasticity) -> Option<Diagnostic> {
    let turned: Vec<JointCompliance> = given.iter().map(|at| JointCompliance { angle: -at.angle, ..*at }).collect();
    let other = elasticity(triangle, &turned).ok().filter(|other| given.len() > 3 && other.rms * FALL < found.rms)?;
    let [now, then] = [found.rms, other.rms].map(|rms| 1e6 * rms);
    let message = format!(
        "with the angles q negated the law leaves {then:.4} instead of {now:.4} 1e-6 rad/(N.m) of the compliances: of the other sense?"
    );
    let remedy = "count q as the joint's own angle, in the sense in which the mounting is given";
    Some(Diagnostic::error(message).code(Code::Misread).figure("rms", other.rms).remedy(remedy))
}

/// Probability of what the law leaves, by the stated intervals, below which it is reported: as of other doubts about noise.
const CHANCE: f64 = 1e-3;

/// Degrees of freedom of a variance that is known.
const MANY: f64 = 1e6;

/// Compliances through which the law does not go, by their own intervals.
fn misfit(triangle: &Triangle, given: &[JointCompliance], found: &Elasticity) -> Option<Diagnostic> {
    let ratio = |at: &JointCompliance| {
        let sigma = at.ci95? / normal95();
        Some(((at.compliance - found.compliance(triangle, at.angle)) / sigma).powi(2))
    };
    let squares: Vec<f64> = given.iter().map(ratio).collect::<Option<_>>()?;
    let freedom = given.len() as f64 - 3.0;
    let ratio = squares.iter().sum::<f64>() / freedom;
    if freedom <= 0.0 || f_tail(ratio, freedom, MANY) > CHANCE {
        return None;
    }
    let (worst, _) = given.iter().zip(&squares).max_by(|a, b| a.1.total_cmp(b.1))?;
    let message = format!(
        "the law is {:.0} times as far from the compliances as their intervals allow, most at q = {:.2} deg",
        ratio.sqrt(),
        worst.angle.to_degrees()
    );
    let remedy = "look at that compliance, and at L, ax and ay; or intervals are stated too narrow";
    Some(Diagnostic::warning(message).code(Code::NoiseUnlikeStated).figure("ratio", ratio.sqrt()).remedy(remedy))
}
