//! Fuzzy compliance of a point of the tool, in place of springs and beams or added to them: rad, m, N.
//!
//! Source: IR663 calibration paper, eq. (33) to (38); deflections are linear in the load, eq. (70).

use nalgebra::{Matrix6, Vector3};

use super::response::Response;
use crate::description::fuzzy::{Fuzzy, Input, Rules};
use crate::diagnostic::Diagnostic;
use crate::fuzzy::{inputs, value};
use crate::kinematics::{Geometry, Placements};
use crate::model::Model;

/// Compliance at the model's point, base axes.
fn compliance(fuzzy: &Fuzzy, placements: &Placements) -> Matrix6<f64> {
    let mut x = Vec::new();
    inputs(&fuzzy.inputs, placements, &mut x);
    let mut matrix = Matrix6::zeros();
    for component in &fuzzy.components {
        matrix[(component.at[0], component.at[1])] += value(&component.rules, &x);
    }
    let Some(axes) = fuzzy.axes else { return matrix };
    let mut turn = Matrix6::zeros();
    for k in [0, 3] {
        turn.fixed_view_mut::<3, 3>(k, k).copy_from(placements.frames[axes].rotation.matrix());
    }
    turn * matrix * turn.transpose()
}

/// Puts the geometry's fuzzy compliance, if it has one, into the response of a point of the tool: in place of that of
/// the springs and beams, or added to it. Their deflection under own weight stays.
pub fn put_fuzzy(geometry: &Geometry, placements: &Placements, response: &mut Response) {
    let Some(fuzzy) = &geometry.model.fuzzy else { return };
    let (frame, point) = match fuzzy.at {
        Some(marker) => (geometry.model.markers[marker].frame, geometry.marker(marker)),
        None => (geometry.model.tool.0, geometry.tool().translation.vector.into()),
    };
    let point = (placements.frames[frame] * point).coords;
    let spatial = at_origin(&compliance(fuzzy, placements), &point);
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
pub fn fuzzy_doubts(model: &Model, geometry: &Geometry, asked: &[(&[f64], Option<Option<usize>>)]) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    if let Some(fuzzy) = &model.fuzzy {
        let turns = fuzzy.components.iter().any(|component| component.at[0] >= 3);
        if !turns && asked.iter().any(|(_, point)| *point != Some(fuzzy.at)) {
            let own = fuzzy.at.map_or("the tool centre point", |marker| model.markers[marker].name.as_str());
            let text = format!(
                "the rules (`fuzzy`) are those of {own}, and say nothing of rotation: another point is taken to move alike"
            );
            diagnostics.push(Diagnostic::warning(text).remedy("ask for the point of the rules, or fit rules there"));
        }
        let rules: Vec<&Rules> = fuzzy.components.iter().map(|component| &component.rules).collect();
        diagnostics.extend(outside(geometry, &fuzzy.inputs, &rules, asked));
    }
    if let Some(local) = &model.local_springs {
        let rules: Vec<&Rules> = local.springs.iter().map(|(_, rules)| rules).collect();
        diagnostics.extend(outside(geometry, &local.inputs, &rules, asked));
    }
    diagnostics
}

/// Warnings of configurations outside what the sets of each input span.
fn outside(
    geometry: &Geometry,
    of: &[Input],
    rules: &[&Rules],
    asked: &[(&[f64], Option<Option<usize>>)],
) -> Vec<Diagnostic> {
    let mut placements = Placements::default();
    let placed = asked.iter().filter_map(|(q, _)| {
        geometry.place(q, &mut placements).ok()?;
        let mut x = Vec::new();
        inputs(of, &placements, &mut x);
        Some(x)
    });
    let placed: Vec<Vec<f64>> = placed.collect();
    let mut diagnostics = Vec::new();
    for (k, input) in of.iter().enumerate() {
        let marks = rules.iter().map(|rules| rules.premise.marks(k)).filter(|marks| marks.len() > 1);
        let [low, high] = marks.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], marks| {
            [low.min(marks[0]), high.max(marks[marks.len() - 1])]
        });
        let margin = BEYOND * (high - low);
        let is_outside = |x: &&Vec<f64>| low <= high && (x[k] < low - margin || x[k] > high + margin);
        let count = placed.iter().filter(is_outside).count();
        let (name, angle) = geometry.model.input(*input);
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
