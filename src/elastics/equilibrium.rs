//! Equilibrium at the deflected pose: loads follow the points they act on, springs their anchors.
//!
//! Elements stay linear in their own axes, which turn with the bodies; bodies move by finite rotations. Rounds of linear
//! statics on the deflected geometry are repeated until nothing moves. Where the structure stiffens as it deflects they
//! swing about the answer without end, and are begun anew with damping (Aitken's factor, kept between 0 and 1, under
//! which what is unstable stays unstable: Irons and Tuck 1969). What does not settle is said, and so is what settles where
//! the tangent stiffness is not positive definite, as a column that stays straight beyond Euler's load.

use nalgebra::{Matrix3, Rotation3, Vector3, Vector6};

use super::response::Response;
use super::spatial;
use super::stability::greatest;
use super::statics::{ClosingKind, Elastics, Mechanism, Statics, rest_of};
use crate::kinematics::{Placements, rotation_vector};
use crate::model::VertexIndex;
use crate::model::{Element, Lumped, Spot};

/// Rounds after which the iteration is given up.
const MOST: usize = 200;
/// A round that moves nothing further than this (m, rad) ends the iteration.
const SETTLED: f64 = 1e-12;
/// Least share of a round's change that is taken over.
const LEAST: f64 = 0.05;
/// Step (m, rad) by which elements are strained to see how the loads answer.
const STEP: f64 = 1e-6;
/// The answer to a strain may exceed it by this before the equilibrium counts as unstable: what differences leave.
const NEUTRAL: f64 = 1e-6;

/// A deflected pose in equilibrium.
#[derive(Debug, Clone)]
pub struct Equilibrium {
    /// Displacement (m) of the loaded point, base axes.
    pub displacement: Vector3<f64>,
    /// Rotation vector of its body (rad), base axes.
    pub rotation: Vector3<f64>,
    /// Rounds needed.
    pub rounds: usize,
    /// By what all loads together could be multiplied until the stiffness at this pose is used up (buckling, where the
    /// structure has not bent before); infinite where they only stiffen it.
    pub load_factor: f64,
}

/// Finds the equilibrium at the deflected pose under a force and moment (constant in base axes) at a point (m, base
/// frame, before deflection) of a vertex's body, with own weight if asked.
///
/// # Errors
/// [`Mechanism`] for a mechanism, when the rounds do not settle, or when they settle at what is not stable.
pub fn equilibrium(
    elastics: &Elastics,
    placements: &Placements,
    vertex: VertexIndex,
    point: &Vector3<f64>,
    load: (&Vector3<f64>, &Vector3<f64>),
    weight: bool,
) -> Result<Equilibrium, Mechanism> {
    let pose = || Pose::new(elastics, placements, vertex, point, load, weight);
    let (mut pose, rounds) = pose()?.settled(false).or_else(|_| pose()?.settled(true))?;
    let now = elastics.carried(vertex, point, placements, &pose.turned[vertex], &pose.statics.points);
    let rotation = rotation_vector(&Rotation3::from_matrix_unchecked(pose.turned[vertex]));
    let answer = pose.answer()?;
    if answer > 1.0 + NEUTRAL {
        let factor = 1.0 / answer;
        return Err(Mechanism(format!(
            "the equilibrium found is not stable, its tangent stiffness is not positive definite: buckling begins at {factor:.3} of this load"
        )));
    }
    let load_factor = if answer > 0.0 { 1.0 / answer } else { f64::INFINITY };
    Ok(Equilibrium { displacement: now - point, rotation, rounds, load_factor })
}

/// A pose on its way to equilibrium.
struct Pose<'a> {
    elastics: &'a Elastics<'a>,
    placements: &'a Placements,
    vertex: VertexIndex,
    point: &'a Vector3<f64>,
    load: (&'a Vector3<f64>, &'a Vector3<f64>),
    rest: Vec<Vector3<f64>>,
    statics: Statics,
    response: Response,
    /// How the body of each vertex has turned.
    turned: Vec<Matrix3<f64>>,
    /// What each element gives, local axes.
    strains: Vec<Vector6<f64>>,
}

impl<'a> Pose<'a> {
    fn new(
        elastics: &'a Elastics<'a>,
        placements: &'a Placements,
        vertex: VertexIndex,
        point: &'a Vector3<f64>,
        load: (&'a Vector3<f64>, &'a Vector3<f64>),
        weight: bool,
    ) -> Result<Self, Mechanism> {
        let count = elastics.model.structure.vertices.len();
        let mut statics = Statics::new(weight);
        elastics.prepare(placements, &mut statics)?;
        Ok(Self {
            elastics,
            placements,
            vertex,
            point,
            load,
            rest: (0..count).map(|v| rest_of(elastics.model, v, placements)).collect(),
            statics,
            response: Response::new(elastics, vertex),
            turned: vec![Matrix3::identity(); count],
            strains: vec![Vector6::zeros(); count],
        })
    }

    /// Rounds of statics and placing until nothing moves, and their number.
    fn settled(mut self, damped: bool) -> Result<(Self, usize), Mechanism> {
        let mut last = f64::INFINITY;
        let mut changes = self.strains.clone();
        let mut share = 1.0;
        for round in 1..=MOST {
            let given = self.given();
            // By how much each element gives otherwise than it was taken to.
            let (mut along, mut square) = (0.0, 0.0);
            for (&v, given) in self.elastics.active.iter().zip(&given) {
                let change = given - self.strains[v];
                let difference = change - changes[v];
                along += changes[v].dot(&difference);
                square += difference.norm_squared();
                changes[v] = change;
            }
            if damped && round > 1 && square > 0.0 {
                share = (-share * along / square).clamp(LEAST, 1.0);
            }
            for &v in &self.elastics.active {
                self.strains[v] += changes[v] * share;
            }
            let moved = self.place() / share;
            let now = self.elastics.carried(
                self.vertex,
                self.point,
                self.placements,
                &self.turned[self.vertex],
                &self.statics.points,
            );
            if !moved.is_finite() || now.iter().any(|v| !v.is_finite()) || round > 20 && moved > 10.0 * last {
                break;
            }
            self.elastics.prepare_at(self.placements, Some(&self.turned), &mut self.statics)?;
            if moved < SETTLED {
                return Ok((self, round));
            }
            last = moved;
        }
        Err(Mechanism(format!(
            "no equilibrium at the deflected pose: the last round still moved it by {last:.1e} m or rad; the load is near or beyond buckling"
        )))
    }

    /// What each active element gives under the loads at the pose.
    fn given(&mut self) -> Vec<Vector6<f64>> {
        let (elastics, vertex) = (self.elastics, self.vertex);
        self.response.evaluate(elastics, &mut self.statics);
        let at = elastics.carried(vertex, self.point, self.placements, &self.turned[vertex], &self.statics.points);
        let wrench = spatial(&at, self.load.0, self.load.1);
        let weight = &self.statics.weight;
        let own = |v: VertexIndex| if weight.active { weight.strains[v] } else { Vector6::zeros() };
        elastics.active.iter().map(|&v| self.response.strains[v] * wrench + own(v)).collect()
    }

    /// Places each body against the one that carries it, by what the element between gives; by how much that moved
    /// them at most (m, rad).
    fn place(&mut self) -> f64 {
        let (elastics, rest, statics) = (self.elastics, &self.rest, &mut self.statics);
        let structure = &elastics.model.structure;
        let count = rest.len();
        let spot = |of: &Lumped| match of.spot {
            Spot::At(frame, local) => (self.placements.frames[frame] * nalgebra::Point3::from(local)).coords,
            Spot::Between([a, b], share) => rest[a].lerp(&rest[b], share),
        };
        let (mut points, mut turns) = (rest.clone(), vec![Matrix3::identity(); count]);
        for v in 1..count {
            let edge = &structure.tree[v];
            let parent = edge.ends[0];
            let pivot = match &edge.element {
                Element::Lumped(of) => spot(of),
                _ => rest[v],
            };
            let active = elastics.active.binary_search(&v).is_ok();
            let strain = self.strains[v];
            // The element's axes turn with the body that carries it.
            let axes = if active { statics.local[v].fixed_view::<3, 3>(0, 0).transpose() } else { Matrix3::identity() };
            let axes = turns[parent] * self.turned[parent].transpose() * axes;
            let slide = axes * strain.fixed_rows::<3>(0);
            let turn = Rotation3::new(axes * strain.fixed_rows::<3>(3)).into_inner();
            turns[v] = turn * turns[parent];
            points[v] = points[parent] + turns[parent] * (pivot - rest[parent]) + slide + turns[v] * (rest[v] - pivot);
        }
        let moved = (0..count)
            .map(|v| (points[v] - statics.points[v]).norm().max((turns[v] - self.turned[v]).norm()))
            .fold(0.0_f64, f64::max);
        // What the linear closure leaves open on finite motions is closed in the next round.
        for (index, closing) in elastics.closings.iter().enumerate() {
            let state = &statics.closings[index];
            let linear: Vector6<f64> =
                closing.cycle.iter().zip(&state.forces).map(|((v, _), f)| f.tr_mul(&self.strains[*v])).sum();
            let axes: Matrix3<f64> = state.local.fixed_view::<3, 3>(0, 0).transpose();
            let [a, b] = closing.ends;
            let origin = match closing.kind {
                ClosingKind::Element(which) => match &structure.closures[which].element {
                    Element::Lumped(of) => spot(of),
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
        self.turned = turns;
        moved
    }

    /// How much further the loads strain the settled pose per strain of the worst kind: from 1 on nothing brings it back.
    fn answer(&mut self) -> Result<f64, Mechanism> {
        let (points, turned) = (self.statics.points.clone(), self.turned.clone());
        let (strains, defects) = (self.strains.clone(), self.statics.defects.clone());
        let active = self.elastics.active.clone();
        let mut strained = |by: &[f64], step: f64| -> Result<Vec<Vector6<f64>>, Mechanism> {
            self.statics.points.copy_from_slice(&points);
            self.turned.copy_from_slice(&turned);
            self.statics.defects.clone_from(&defects);
            self.strains.copy_from_slice(&strains);
            self.elastics.prepare_at(self.placements, Some(&self.turned), &mut self.statics)?;
            for (&v, by) in active.iter().zip(by.chunks(6)) {
                self.strains[v] += Vector6::from_column_slice(by) * step;
            }
            // A beam's axes follow its ends: the second placing has them where the first left these.
            for _ in 0..2 {
                self.place();
                self.elastics.prepare_at(self.placements, Some(&self.turned), &mut self.statics)?;
            }
            Ok(self.given())
        };
        greatest(6 * active.len(), |by, out| {
            let (up, down) = (strained(by, STEP)?, strained(by, -STEP)?);
            for (out, (up, down)) in out.chunks_mut(6).zip(up.iter().zip(&down)) {
                out.copy_from_slice(((up - down) / (2.0 * STEP)).as_slice());
            }
            Ok(())
        })
    }
}
