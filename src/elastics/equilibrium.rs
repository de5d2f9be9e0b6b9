//! Equilibrium at the deflected pose: loads follow the points they act on.
//!
//! Elements stay linear in their own axes, which turn with the bodies; bodies move by finite rotations. The energy of a joint
//! is quadratic in slide and rotation vector, and springs between bodies pull along the line between their anchors as these
//! have moved: where only these deform, the equilibrium is exact. Linear statics on the
//! deflected geometry are repeated until nothing moves. Where the structure stiffens as it deflects these iterations swing
//! about the answer without end, and are begun anew with damping (Aitken's factor, kept between 0 and 1, under which what is
//! unstable stays unstable: Irons and Tuck 1969). What does not settle is an error, and so is what settles where the tangent
//! stiffness is not positive definite, as a column that stays straight beyond Euler's load.

use nalgebra::{Matrix3, Rotation3, Vector3, Vector6};

use super::compiled::Elastics;
use super::response::Response;
use super::stability::greatest;
use super::statics::{Mechanism, Statics};
use crate::elements::{Configuration, Deflected, VertexIndex, spatial};
use crate::kinematics::{Placements, rotation_vector};
use crate::math::left_jacobian;

/// Iterations after which it is given up.
const MOST: usize = 200;
/// An iteration that moves nothing further than this (m, rad) is the last.
const SETTLED: f64 = 1e-12;
/// Least share of an iteration's change that is taken over.
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
    /// Iterations needed.
    pub iterations: usize,
    /// By what all loads together could be multiplied until the stiffness at this pose is used up (buckling, where the
    /// structure has not bent before); infinite where they only stiffen it.
    pub load_factor: f64,
}

/// A force and moment, constant in base axes, at a point of a vertex's body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointLoad {
    /// The vertex.
    pub vertex: VertexIndex,
    /// The point with nothing deflected, m, base frame.
    pub point: Vector3<f64>,
    /// N.
    pub force: Vector3<f64>,
    /// N.m.
    pub moment: Vector3<f64>,
    /// Forces (N) at other points of the same body, and where these are with nothing deflected (m, base frame): they turn with it.
    pub elsewhere: [(Vector3<f64>, Vector3<f64>); 2],
}

impl PointLoad {
    /// A force (N) and a moment (N.m) at a point (m, base frame) of a vertex's body.
    pub fn at(vertex: VertexIndex, point: Vector3<f64>, force: Vector3<f64>, moment: Vector3<f64>) -> Self {
        Self { vertex, point, force, moment, elsewhere: [(Vector3::zeros(), Vector3::zeros()); 2] }
    }
}

/// Finds the equilibrium at the deflected pose under a load, with own weight if asked.
///
/// # Errors
/// [`Mechanism`] for a mechanism, when the iterations do not settle, or when they settle at what is not stable.
pub fn equilibrium(
    elastics: &Elastics,
    placements: &Placements,
    load: &PointLoad,
    weight: bool,
) -> Result<Equilibrium, Mechanism> {
    let (mut pose, iterations) = Pose::at_rest(elastics, placements, load, weight)?;
    let [displacement, rotation] = pose.deflection();
    let growth = pose.growth()?;
    if growth > 1.0 + NEUTRAL {
        let factor = 1.0 / growth;
        return Err(Mechanism::Moves(format!(
            "the equilibrium found is not stable, its tangent stiffness is not positive definite: buckling begins at {factor:.3} of this load"
        )));
    }
    let load_factor = if growth > NEUTRAL { 1.0 / growth } else { f64::INFINITY };
    Ok(Equilibrium { displacement, rotation, iterations, load_factor })
}

/// Displacement (m) and rotation vector (rad), base axes, of the loaded point at the equilibrium, whether or not it is stable: a
/// fraction of the effort of [`equilibrium`].
///
/// # Errors
/// [`Mechanism`] for a mechanism, and when the iterations do not settle.
pub fn deflection_at_rest(
    elastics: &Elastics,
    placements: &Placements,
    load: &PointLoad,
    weight: bool,
) -> Result<[Vector3<f64>; 2], Mechanism> {
    Ok(Pose::at_rest(elastics, placements, load, weight)?.0.deflection())
}

/// What must be added to the forces on an element, reduced to its first end, for its linear law to give the deformation
/// (slide d, rotation vector phi) of which it stores energy: the moment that works on phi is `J' (m - d x f)`, with J the left
/// Jacobian of the turn and m about the first end. Without a turn about more than one axis nothing.
fn turned_moment(strain: &Vector6<f64>, forces: &Vector6<f64>) -> Vector6<f64> {
    let [slide, turn] = [0, 3].map(|k| Vector3::from(strain.fixed_rows::<3>(k)));
    let [force, moment] = [0, 3].map(|k| Vector3::from(forces.fixed_rows::<3>(k)));
    let works = left_jacobian(&turn).tr_mul(&(moment - slide.cross(&force)));
    let added = works - moment;
    Vector6::new(0.0, 0.0, 0.0, added.x, added.y, added.z)
}

/// A pose on its way to equilibrium.
struct Pose<'a> {
    elastics: &'a Elastics<'a>,
    placements: &'a Placements,
    load: &'a PointLoad,
    undeflected: Vec<Vector3<f64>>,
    statics: Statics,
    response: Response,
    /// How the body of each vertex has turned.
    turned: Vec<Matrix3<f64>>,
    /// Deformation of each tree member, local axes.
    strains: Vec<Vector6<f64>>,
    /// What a finite turn of a member adds to that.
    bent: Vec<Vector6<f64>>,
}

impl<'a> Pose<'a> {
    /// The pose in equilibrium, and the iterations to it.
    fn at_rest(
        elastics: &'a Elastics<'a>,
        placements: &'a Placements,
        load: &'a PointLoad,
        weight: bool,
    ) -> Result<(Self, usize), Mechanism> {
        let pose = || Self::new(elastics, placements, load, weight);
        pose()?.settled(false).or_else(|_| pose()?.settled(true))
    }

    /// Displacement (m) and rotation vector (rad) of the loaded point.
    fn deflection(&self) -> [Vector3<f64>; 2] {
        let turned = Rotation3::from_matrix_unchecked(self.turned[self.load.vertex]);
        [self.loaded_point() - self.load.point, rotation_vector(&turned)]
    }

    fn new(
        elastics: &'a Elastics<'a>,
        placements: &'a Placements,
        load: &'a PointLoad,
        weight: bool,
    ) -> Result<Self, Mechanism> {
        let mut statics = Statics::new(weight);
        elastics.prepare(placements, &mut statics)?;
        let count = statics.points.len();
        Ok(Self {
            elastics,
            placements,
            load,
            undeflected: statics.points.clone(),
            statics,
            response: Response::new(elastics, load.vertex),
            turned: vec![Matrix3::identity(); count],
            strains: vec![Vector6::zeros(); elastics.in_tree],
            bent: vec![Vector6::zeros(); elastics.in_tree],
        })
    }

    /// Statics at the deflected geometry.
    fn prepare(&mut self) -> Result<(), Mechanism> {
        let deflected = Deflected { undeflected: &self.undeflected, turned: &self.turned };
        self.elastics.prepare_at(self.placements, Some(deflected), &mut self.statics)
    }

    /// The whole load at the pose, spatial.
    fn wrench(&self) -> Vector6<f64> {
        let elsewhere = self.load.elsewhere.iter().filter(|(force, _)| *force != Vector3::zeros());
        let elsewhere = elsewhere.map(|(force, point)| spatial(&self.carried(point), force, &Vector3::zeros()));
        spatial(&self.loaded_point(), &self.load.force, &self.load.moment) + elsewhere.sum::<Vector6<f64>>()
    }

    /// Where the loaded point is.
    fn loaded_point(&self) -> Vector3<f64> {
        self.carried(&self.load.point)
    }

    /// Where a point (m, base frame, nothing deflected) of the loaded body is.
    fn carried(&self, point: &Vector3<f64>) -> Vector3<f64> {
        let deflected = Deflected { undeflected: &self.undeflected, turned: &self.turned };
        let at: Configuration =
            self.elastics.configuration(self.placements, &self.statics.points, &self.statics.local, Some(deflected));
        at.carried(self.load.vertex, point)
    }

    /// Iterations of statics and placing until nothing moves, and their number.
    fn settled(mut self, damped: bool) -> Result<(Self, usize), Mechanism> {
        let mut last = f64::INFINITY;
        let mut changes = self.strains.clone();
        let mut share = 1.0;
        for iteration in 1..=MOST {
            let found = self.deformations();
            // By how much each element deforms otherwise than it was taken to.
            let (mut along, mut square) = (0.0, 0.0);
            for ((found, strain), last) in found.iter().zip(&self.strains).zip(&mut changes) {
                let change = found - strain;
                let difference = change - *last;
                along += last.dot(&difference);
                square += difference.norm_squared();
                *last = change;
            }
            if damped && iteration > 1 && square > 0.0 {
                share = (-share * along / square).clamp(LEAST, 1.0);
            }
            for (strain, change) in self.strains.iter_mut().zip(&changes) {
                *strain += change * share;
            }
            let moved = self.place() / share;
            let diverges = iteration > 20 && moved > 10.0 * last;
            if !moved.is_finite() || self.loaded_point().iter().any(|v| !v.is_finite()) || diverges {
                break;
            }
            self.prepare()?;
            if moved < SETTLED {
                return Ok((self, iteration));
            }
            last = moved;
        }
        Err(Mechanism::Moves(format!(
            "no equilibrium at the deflected pose: the last iteration still moved it by {last:.1e} m or rad; the load is near or beyond buckling"
        )))
    }

    /// Deformations of the tree members under the loads at the pose.
    fn deformations(&mut self) -> Vec<Vector6<f64>> {
        self.response.evaluate(self.elastics, &mut self.statics);
        let wrench = self.wrench();
        let weight = &self.statics.weight;
        let own = |member: usize| if weight.active { weight.strains[member] } else { Vector6::zeros() };
        let strains = self.response.strains.iter().enumerate();
        let mut strains: Vec<Vector6<f64>> = strains.map(|(member, by_unit)| by_unit * wrench + own(member)).collect();
        let weight = &self.statics.weight;
        for (member, of) in self.elastics.members[..self.elastics.in_tree].iter().enumerate() {
            // A beam's elements are linear: the finer, the closer.
            if of.per_length.is_none() {
                let own = if weight.active { weight.forces[member] } else { Vector6::zeros() };
                let forces = self.response.forces[member] * wrench + own;
                let added = turned_moment(&self.strains[member], &forces);
                self.bent[member] = self.statics.placed[member].flexibility.apply(&added);
            }
        }
        strains.iter_mut().zip(&self.bent).for_each(|(strain, bent)| *strain += bent);
        strains
    }

    /// Places each body against the one that carries it, by the deformation of the element between; by how much that moved
    /// them at most (m, rad).
    fn place(&mut self) -> f64 {
        let (elastics, undeflected) = (self.elastics, &self.undeflected);
        let count = undeflected.len();
        let (mut points, mut turns) = (undeflected.clone(), vec![Matrix3::identity(); count]);
        for (v, edge) in elastics.model.structure.tree.iter().enumerate().skip(1) {
            let parent = edge.ends[0];
            let (mut slide, mut turn) = (Vector3::zeros(), Matrix3::identity());
            if let Some(member) = elastics.ending_at[v] {
                let strain = self.strains[member];
                // The element's axes turn with the body that carries it.
                let axes = self.statics.placed[member].local.fixed_view::<3, 3>(0, 0).transpose();
                let axes = turns[parent] * self.turned[parent].transpose() * axes;
                slide = axes * strain.fixed_rows::<3>(0);
                turn = Rotation3::new(axes * strain.fixed_rows::<3>(3)).into_inner();
            }
            let pivot = edge.element.pivot(&self.placements.frames, undeflected, edge.ends).unwrap_or(undeflected[v]);
            turns[v] = turn * turns[parent];
            points[v] = points[parent]
                + turns[parent] * (pivot - undeflected[parent])
                + slide
                + turns[v] * (undeflected[v] - pivot);
        }
        let moved = (0..count)
            .map(|v| (points[v] - self.statics.points[v]).norm().max((turns[v] - self.turned[v]).norm()))
            .fold(0.0_f64, f64::max);
        self.find_defects(&points, &turns);
        self.statics.points.copy_from_slice(&points);
        self.turned = turns;
        moved
    }

    /// What the linear closures leave open on finite motions is closed in the next iteration.
    fn find_defects(&mut self, points: &[Vector3<f64>], turns: &[Matrix3<f64>]) {
        let (elastics, undeflected, statics) = (self.elastics, &self.undeflected, &mut self.statics);
        for (index, closing) in elastics.closings.iter().enumerate() {
            let edge = elastics.members[elastics.in_tree + index].edge;
            let forces = &statics.closings[index].forces;
            let linear: Vector6<f64> =
                closing.cycle.iter().zip(forces).map(|((member, _), f)| f.tr_mul(&self.strains[*member])).sum();
            let bent: Vector6<f64> =
                closing.cycle.iter().zip(forces).map(|((member, _), f)| f.tr_mul(&self.bent[*member])).sum();
            statics.defects.resize(elastics.closings.len(), Vector6::zeros());
            let Some(origin) = edge.element.pivot(&self.placements.frames, undeflected, edge.ends) else {
                // A spring holds nothing together: its force is that of the pose, and gaps count from there.
                statics.defects[index] = bent - linear;
                continue;
            };
            let local = statics.placed[elastics.in_tree + index].local;
            let to_local: Matrix3<f64> = local.fixed_view::<3, 3>(0, 0).into_owned();
            let [a, b] = edge.ends;
            let reach = |v: usize| points[v] + turns[v] * (origin - undeflected[v]);
            let open = to_local * (reach(b) - reach(a));
            let turn = to_local * rotation_vector(&Rotation3::from_matrix_unchecked(turns[b] * turns[a].transpose()));
            let exact = Vector6::new(open.x, open.y, open.z, turn.x, turn.y, turn.z);
            statics.defects[index] = exact + bent - linear;
        }
    }

    /// By how much the loads strain the settled pose further per strain of the worst kind: from 1 on nothing brings it back.
    fn growth(&mut self) -> Result<f64, Mechanism> {
        let (points, turned) = (self.statics.points.clone(), self.turned.clone());
        let (strains, defects) = (self.strains.clone(), self.statics.defects.clone());
        let mut strained = |by: &[f64], step: f64| -> Result<Vec<Vector6<f64>>, Mechanism> {
            self.statics.points.copy_from_slice(&points);
            self.turned.copy_from_slice(&turned);
            self.statics.defects.clone_from(&defects);
            self.strains.copy_from_slice(&strains);
            self.prepare()?;
            for (strain, by) in self.strains.iter_mut().zip(by.chunks(6)) {
                *strain += Vector6::from_column_slice(by) * step;
            }
            // A beam's axes follow its ends: the second placing has them where the first left these.
            for _ in 0..2 {
                self.place();
                self.prepare()?;
            }
            Ok(self.deformations())
        };
        greatest(6 * strains.len(), |by, out| {
            let (up, down) = (strained(by, STEP)?, strained(by, -STEP)?);
            for (out, (up, down)) in out.chunks_mut(6).zip(up.iter().zip(&down)) {
                out.copy_from_slice(((up - down) / (2.0 * STEP)).as_slice());
            }
            Ok(())
        })
    }
}
