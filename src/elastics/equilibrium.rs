//! Equilibrium at the deflected pose: loads follow the points they act on, springs their anchors.
//!
//! Elements stay linear in their own axes, which turn with the bodies; bodies move by finite rotations. Rounds of linear
//! statics on the deflected geometry are repeated until nothing moves. Where the structure stiffens as it deflects they
//! swing about the answer without end, and are begun anew with damping (Aitken's factor, kept between 0 and 1, under
//! which what is unstable stays unstable: Irons and Tuck 1969). What does not settle is said.

use nalgebra::{Matrix3, Rotation3, Vector3, Vector6};

use super::response::Response;
use super::spatial;
use super::statics::{ClosingKind, Elastics, Mechanism, Statics, rest_of};
use crate::kinematics::{Placements, rotation_vector};
use crate::model::VertexIndex;
use crate::model::{Element, Spot};

/// Rounds after which the iteration is given up.
const MOST: usize = 200;
/// A round that moves nothing further than this (m, rad) ends the iteration.
const SETTLED: f64 = 1e-12;
/// Least share of a round's change that is taken over.
const LEAST: f64 = 0.05;

/// A deflected pose in equilibrium.
#[derive(Debug, Clone)]
pub struct Equilibrium {
    /// Displacement (m) of the loaded point, base axes.
    pub displacement: Vector3<f64>,
    /// Rotation vector of its body (rad), base axes.
    pub rotation: Vector3<f64>,
    /// Rounds needed.
    pub rounds: usize,
}

/// Finds the equilibrium at the deflected pose under a force and moment (constant in base axes) at a point (m, base
/// frame, before deflection) of a vertex's body, with own weight if asked.
///
/// # Errors
/// [`Mechanism`] for a mechanism, or when the rounds do not settle.
pub fn equilibrium(
    elastics: &Elastics,
    placements: &Placements,
    vertex: VertexIndex,
    point: &Vector3<f64>,
    load: (&Vector3<f64>, &Vector3<f64>),
    weight: bool,
) -> Result<Equilibrium, Mechanism> {
    settle(elastics, placements, vertex, point, load, weight, false)
        .or_else(|_| settle(elastics, placements, vertex, point, load, weight, true))
}

fn settle(
    elastics: &Elastics,
    placements: &Placements,
    vertex: VertexIndex,
    point: &Vector3<f64>,
    load: (&Vector3<f64>, &Vector3<f64>),
    weight: bool,
    damped: bool,
) -> Result<Equilibrium, Mechanism> {
    let structure = &elastics.model.structure;
    let count = structure.vertices.len();
    let mut statics = Statics::new(weight);
    let mut response = Response::new(elastics, vertex);
    elastics.prepare(placements, &mut statics)?;
    let rest: Vec<Vector3<f64>> = (0..count).map(|v| rest_of(elastics.model, v, placements)).collect();
    let mut turned = vec![Matrix3::identity(); count];
    let mut last = f64::INFINITY;
    let mut strains: Vec<Vector6<f64>> = vec![Vector6::zeros(); count];
    let mut changes = strains.clone();
    let mut share = 1.0;
    for round in 1..=MOST {
        response.evaluate(elastics, &mut statics);
        let at = elastics.carried(vertex, point, placements, &turned[vertex], &statics.points);
        let wrench = spatial(&at, load.0, load.1);
        // By how much each element gives otherwise than it was taken to.
        let (mut along, mut square) = (0.0, 0.0);
        for &v in &elastics.active {
            let mut change = response.strains[v] * wrench - strains[v];
            if statics.weight.active {
                change += statics.weight.strains[v];
            }
            let difference = change - changes[v];
            along += changes[v].dot(&difference);
            square += difference.norm_squared();
            changes[v] = change;
        }
        if damped && round > 1 && square > 0.0 {
            share = (-share * along / square).clamp(LEAST, 1.0);
        }
        for &v in &elastics.active {
            strains[v] += changes[v] * share;
        }
        // Each body is placed against the one that carries it, by what the element between gives.
        let (mut points, mut turns) = (rest.clone(), vec![Matrix3::identity(); count]);
        for v in 1..count {
            let edge = &structure.tree[v];
            let parent = edge.ends[0];
            let pivot = match &edge.element {
                Element::Lumped(of) => match of.spot {
                    Spot::At(frame, local) => (placements.frames[frame] * nalgebra::Point3::from(local)).coords,
                    Spot::Between([a, b], share) => rest[a].lerp(&rest[b], share),
                },
                _ => rest[v],
            };
            let active = elastics.active.binary_search(&v).is_ok();
            let strain = strains[v];
            // The element's axes turn with the body that carries it.
            let axes = if active { statics.local[v].fixed_view::<3, 3>(0, 0).transpose() } else { Matrix3::identity() };
            let axes = turns[parent] * turned[parent].transpose() * axes;
            let slide = axes * strain.fixed_rows::<3>(0);
            let turn = Rotation3::new(axes * strain.fixed_rows::<3>(3)).into_inner();
            turns[v] = turn * turns[parent];
            points[v] = points[parent] + turns[parent] * (pivot - rest[parent]) + slide + turns[v] * (rest[v] - pivot);
        }
        let moved = (0..count)
            .map(|v| (points[v] - statics.points[v]).norm().max((turns[v] - turned[v]).norm()))
            .fold(0.0_f64, f64::max)
            / share;
        // What the linear closure leaves open on finite motions is closed in the next round.
        for (index, closing) in elastics.closings.iter().enumerate() {
            let state = &statics.closings[index];
            let linear: Vector6<f64> =
                closing.cycle.iter().zip(&state.forces).map(|((v, _), f)| f.tr_mul(&strains[*v])).sum();
            let axes: Matrix3<f64> = state.local.fixed_view::<3, 3>(0, 0).transpose();
            let [a, b] = closing.ends;
            let origin = match closing.kind {
                ClosingKind::Element(which) => match &structure.closures[which].element {
                    Element::Lumped(of) => match of.spot {
                        Spot::At(frame, local) => (placements.frames[frame] * nalgebra::Point3::from(local)).coords,
                        Spot::Between([p, q], share) => rest[p].lerp(&rest[q], share),
                    },
                    _ => rest[b],
                },
                ClosingKind::Spring(_) => continue,
            };
            let reach = |v: usize| points[v] + turns[v] * (origin - rest[v]);
            let open = axes.transpose() * (reach(b) - reach(a));
            let turn =
                axes.transpose() * rotation_vector(&Rotation3::from_matrix_unchecked(turns[b] * turns[a].transpose()));
            let exact = Vector6::new(open.x, open.y, open.z, turn.x, turn.y, turn.z);
            statics.defects.resize(elastics.closings.len(), Vector6::zeros());
            statics.defects[index] = exact - linear;
        }
        statics.points.copy_from_slice(&points);
        turned.copy_from_slice(&turns);
        let now = elastics.carried(vertex, point, placements, &turned[vertex], &statics.points);
        if !moved.is_finite() || now.iter().any(|v| !v.is_finite()) || round > 20 && moved > 10.0 * last {
            break;
        }
        if moved < SETTLED {
            let rotation = rotation_vector(&Rotation3::from_matrix_unchecked(turned[vertex]));
            return Ok(Equilibrium { displacement: now - point, rotation, rounds: round });
        }
        last = moved;
        elastics.prepare_at(placements, Some(&turned), &mut statics)?;
    }
    Err(Mechanism(format!(
        "no equilibrium at the deflected pose: the last round still moved it by {last:.1e} m or rad; the load is near or beyond buckling"
    )))
}
