//! Fuzzy compliance in place of springs and beams: Takagi-Sugeno models of order zero, in rad, m, N and base axes.
//!
//! A rule is "if x1 is about c1 and .. then the compliance is b"; how near the inputs are is read from strong
//! triangular partitions (memberships sum to one, neighbours cross at one half) that hold their outermost value outside,
//! and rules are joined by products, so that their weights sum to one too and the answer is the plain weighted sum.
//!
//! Source: IR663 calibration paper, eq. (33) to (38); deflections are linear in the load, eq. (70).

use nalgebra::{Matrix6, Vector3};

use crate::description::fuzzy::{Component, Fuzzy, Input};
use crate::diagnostic::Diagnostic;
use crate::elastics::Response;
use crate::kinematics::{Geometry, Placements};
use crate::model::Model;

/// Membership of `x` in a strong triangular partition: the lower of the two sets that share it, and the weight of the
/// upper one.
///
/// ```
/// // Between the sets about 10 and 20, a quarter of the way up.
/// assert_eq!(elastogeo::fuzzy::membership(&[0.0, 10.0, 20.0], 12.5), (1, 0.25));
/// ```
pub fn membership(modes: &[f64], x: f64) -> (usize, f64) {
    let above = modes.partition_point(|mode| *mode <= x);
    match above {
        0 => (0, 0.0),
        _ if above >= modes.len() => (modes.len().saturating_sub(1), 0.0),
        _ => (above - 1, (x - modes[above - 1]) / (modes[above] - modes[above - 1])),
    }
}

/// Hands the rules that fire at `x` with their weights, which sum to one, to `each`.
pub fn firing(modes: &[Vec<f64>], x: &[f64], each: &mut dyn FnMut(usize, f64)) {
    fn descend(modes: &[Vec<f64>], x: &[f64], rule: usize, weight: f64, each: &mut dyn FnMut(usize, f64)) {
        let (Some((own, modes)), Some((at, x))) = (modes.split_first(), x.split_first()) else {
            return each(rule, weight);
        };
        let (lower, upper) = membership(own, *at);
        let first = rule * own.len() + lower;
        if upper < 1.0 {
            descend(modes, x, first, weight * (1.0 - upper), each);
        }
        if upper > 0.0 {
            descend(modes, x, first + 1, weight * upper, each);
        }
    }
    descend(modes, x, 0, 1.0, each);
}

/// A component's value, m or rad per N or N.m, at inputs in rad or m.
///
/// ```
/// use elastogeo::description::fuzzy::Component;
///
/// // x by fx: 1 um/N up to 0 rad, 3 um/N from 1 rad on, linear between.
/// let component = Component { at: [0, 0], modes: vec![vec![0.0, 1.0]], conclusions: vec![1e-6, 3e-6] };
/// assert!((elastogeo::fuzzy::value(&component, &[0.25]) - 1.5e-6).abs() < 1e-18);
/// ```
pub fn value(component: &Component, x: &[f64]) -> f64 {
    let mut sum = 0.0;
    firing(&component.modes, x, &mut |rule, weight| sum += weight * component.conclusions[rule]);
    sum
}

/// Inputs at a placed configuration, rad and m.
pub fn inputs(of: &[Input], q: &[f64], placements: &Placements, out: &mut Vec<f64>) {
    out.clear();
    out.extend(of.iter().map(|input| match *input {
        Input::Joint(frame) => placements.joints[frame],
        Input::Variable(index) => q[index],
    }));
}

/// Compliance at the model's point, base axes.
pub fn compliance(fuzzy: &Fuzzy, x: &[f64]) -> Matrix6<f64> {
    let mut matrix = Matrix6::zeros();
    for component in &fuzzy.components {
        matrix[(component.at[0], component.at[1])] += value(component, x);
    }
    matrix
}

/// Puts the geometry's fuzzy compliance, if it has one, into the response of a point of the tool: in place of that of
/// the springs and beams, or added to it. Their deflection under own weight stays.
pub fn put(geometry: &Geometry, q: &[f64], placements: &Placements, response: &mut Response) {
    let Some(fuzzy) = &geometry.model.fuzzy else { return };
    let mut x = Vec::new();
    inputs(&fuzzy.inputs, q, placements, &mut x);
    let (frame, point) = match fuzzy.at {
        Some(marker) => (geometry.model.markers[marker].frame, geometry.marker(marker)),
        None => (geometry.model.tool.0, geometry.tool().translation.vector.into()),
    };
    let point = (placements.frames[frame] * point).coords;
    let spatial = at_origin(&compliance(fuzzy, &x), &point);
    if fuzzy.adds {
        response.compliance += spatial;
    } else {
        response.compliance = spatial;
    }
}

/// Share of the span of an input's sets by which configurations may lie outside before a warning: fitted readings seldom
/// reach the ends of the span that a user has in mind.
const BEYOND: f64 = 0.1;

/// Warnings where rules are asked for more than they hold: configurations (rad, m) with the point of each (a
/// marker; `Some(None)` is the tool centre point, `None` any other).
pub fn doubts(model: &Model, geometry: &Geometry, asked: &[(&[f64], Option<Option<usize>>)]) -> Vec<Diagnostic> {
    let Some(fuzzy) = &model.fuzzy else { return Vec::new() };
    let mut diagnostics = Vec::new();
    let turns = fuzzy.components.iter().any(|component| component.at[0] >= 3);
    if !turns && asked.iter().any(|(_, point)| *point != Some(fuzzy.at)) {
        let own = fuzzy.at.map_or("the tool centre point", |marker| model.markers[marker].name.as_str());
        let text = format!(
            "the rules (`fuzzy`) are those of {own}, and say nothing of rotation: another point is taken to move alike"
        );
        diagnostics.push(Diagnostic::warning(text).remedy("ask for the point of the rules, or fit rules there"));
    }
    let mut placements = Placements::default();
    let placed = asked.iter().filter_map(|(q, _)| {
        geometry.place(q, &mut placements).ok()?;
        let mut x = Vec::new();
        inputs(&fuzzy.inputs, q, &placements, &mut x);
        Some(x)
    });
    let placed: Vec<Vec<f64>> = placed.collect();
    for (k, input) in fuzzy.inputs.iter().enumerate() {
        let own = fuzzy.components.iter().map(|component| &component.modes[k]).filter(|modes| modes.len() > 1);
        let [low, high] = own.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], modes| {
            [low.min(modes[0]), high.max(modes[modes.len() - 1])]
        });
        let margin = BEYOND * (high - low);
        let count = placed.iter().filter(|x| x[k] < low - margin || x[k] > high + margin).count();
        let (name, angle) = model.input(*input);
        let (unit, size) = if angle { ("deg", 1f64.to_radians()) } else { ("mm", 1e-3) };
        if count > 0 {
            let text = format!(
                "the rules (`fuzzy`) hold for `{name}` from {:.1} to {:.1} {unit}, and {count} of {} configurations are outside: \
                 the compliance is held there at its last value",
                low / size,
                high / size,
                asked.len()
            );
            diagnostics.push(Diagnostic::warning(text).remedy("measure deflections there, and fit the rules again"));
        }
    }
    diagnostics
}

/// A compliance at a point (m) as one of spatial wrenches and twists.
fn at_origin(compliance: &Matrix6<f64>, point: &Vector3<f64>) -> Matrix6<f64> {
    let mut from_point = Matrix6::identity();
    from_point.fixed_view_mut::<3, 3>(0, 3).copy_from(&point.cross_matrix());
    from_point * compliance * from_point.transpose()
}
