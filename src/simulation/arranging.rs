//! Where things stand that a campaign leaves unknown: bases, tools, and what readings refer to, drawn as a laboratory might have
//! them. Fixtures for contacts stand where the ball gets at with many orientations of the tool.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector, Point3, UnitVector3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::campaigns::{draw_configurations_in, joint_box, within_limits};
use crate::description::campaign::{Between, Campaign, Constraint, InSession, Reading, Target};
use crate::kinematics::{AssemblyError, Geometry, Placements};
use crate::math::linear::least_norm;
use crate::model::Model;
use crate::observation::TargetValues;
use crate::parameter::Kind;
use crate::prediction::{SinglePredictor, Toucher, earlier_normal, target_values};

// A made-up laboratory has no source: the sizes are those of bench-top fixtures and of trackers near a robot. What is
// simulated with them is judged against its own truth, so no result depends on them.

/// Largest offset of a base in the measurement frame, m and rad.
const BASE: f64 = 0.5;
const BASE_TURN: f64 = 0.3;
/// One sigma of a marker or tool from where it is described, m.
const TOOL: f64 = 2e-3;
/// Where a fixture stands from where the campaign says that it is about, one sigma, m.
const NEAR: f64 = 5e-3;
/// Distance of two contacts of one fixture where the campaign does not say it, m.
const APART: f64 = 0.06;
/// Radius of a sphere, with that of the ball, where it is not known, m.
const RADIUS: f64 = 0.03;
/// Places tried for a fixture, configurations tried at each, and the share of them that has to touch.
const PLACES: usize = 60;
/// Arrangements of all fixtures that are tried.
const LAYOUTS: usize = 10;
const TRIALS: usize = 12;
const SHARE: f64 = 0.4;

fn normal(random: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(random)
}

/// A unit vector, all directions alike.
pub fn direction(random: &mut ChaCha8Rng) -> Vector3<f64> {
    let drawn = Vector3::from_fn(|_, _| normal(random));
    UnitVector3::try_new(drawn, f64::MIN_POSITIVE).map_or_else(Vector3::z, UnitVector3::into_inner)
}

/// Puts the base somewhere (`unknown[0]`), and the points measured by millimetres (`unknown[1]`).
pub fn set_up(
    model: &Model,
    markers: &[Option<usize>],
    of: InSession,
    unknown: [bool; 2],
    values: &mut [f64],
    random: &mut ChaCha8Rng,
) {
    if unknown[0] {
        for (k, size) in [BASE, BASE, BASE, BASE_TURN, BASE_TURN, BASE_TURN].into_iter().enumerate() {
            values[model.base_slot(of) + k] += size * (2.0 * random.random::<f64>() - 1.0);
        }
    }
    if unknown[1] {
        let points = markers.iter().map(|marker| model.point_slot(*marker, of));
        for slot in points.flat_map(|slot| slot..slot + 3) {
            values[slot] += TOOL * normal(random);
        }
    }
}

/// Draws what readings refer to, as far as it is unknown, into `values`: fixtures where the ball can touch them, at the known
/// distances and angles; other values near what is usual. `exact` puts what the campaign says is near somewhere exactly there.
///
/// # Errors
/// The loops cannot be assembled with these values, or no configuration can be.
pub fn lay_out(
    model: &Model,
    campaign: &Campaign,
    exact: bool,
    values: &mut [f64],
    random: &mut ChaCha8Rng,
) -> Result<(), AssemblyError> {
    if !campaign.targets.iter().any(Target::is_estimated) {
        return Ok(());
    }
    let held = values.to_vec();
    let geometry = Geometry::new(model, &held)?;
    let layout = Layout {
        model,
        campaign,
        exact,
        held: &held,
        toucher: Toucher::new(model, &held, campaign)?,
        drawn: draw_configurations_in(&geometry, &joint_box(model, 0.6), TRIALS, random)?,
        geometry: &geometry,
    };
    for _ in 0..LAYOUTS {
        layout.draw(values, random)?;
        // Known distances may have moved a fixture to where the ball does not get.
        if layout.touchable().all(|(target, reading)| layout.can_touch(reading, target, values)) {
            break;
        }
    }
    Ok(())
}

/// Where a campaign's fixtures are drawn.
struct Layout<'a> {
    model: &'a Model,
    campaign: &'a Campaign,
    exact: bool,
    /// Values before anything was drawn.
    held: &'a [f64],
    toucher: Toucher<'a>,
    /// Configurations of the robot.
    drawn: Vec<Vec<f64>>,
    geometry: &'a Geometry<'a>,
}

impl Layout<'_> {
    /// Draws everything that is unknown.
    fn draw(&self, values: &mut [f64], random: &mut ChaCha8Rng) -> Result<(), AssemblyError> {
        let (model, campaign) = (self.model, self.campaign);
        let reader = SinglePredictor::new(model, self.held, campaign)?;
        let mut workspace = reader.workspace();
        // Points of the faces, through which they still go when their angles are right.
        let mut faces: BTreeMap<usize, Vector3<f64>> = BTreeMap::new();
        for (index, target) in campaign.targets.iter().enumerate().filter(|(_, target)| target.is_estimated()) {
            let Some(reading) = self.reading_of(index).filter(|_| is_point(target)) else {
                ordinary(model, target, index, self.exact, values, random);
                continue;
            };
            let mate = mate(campaign, index);
            let wrench = campaign.readings[reading].wrench;
            let mut seen = |q: &[f64]| {
                let placed = reader.place(q, &mut workspace);
                let seen = placed.and_then(|()| reader.see(reading, &wrench, &mut workspace)).ok()?;
                Some(seen.real.translation.vector)
            };
            for _ in 0..PLACES {
                let at = if target.is_near {
                    let spread = if self.exact { 0.0 } else { NEAR };
                    near(model, campaign, index, self.held) + Vector3::from_fn(|_, _| spread * normal(random))
                } else if let Some((other, distance)) = mate {
                    point_of(&target_values(model, campaign, other, values), &campaign.targets[other])
                        + direction(random) * distance
                } else if target.is_anchor() {
                    // Off the arm, as the frame of a draw wire stands.
                    direction(random).component_mul(&Vector3::new(1.5, 1.5, 0.5))
                } else {
                    let Some(place) = in_reach(&self.drawn, &mut seen, random) else { continue };
                    (self.geometry.base() * Point3::from(place)).coords
                };
                if target.is_face() {
                    faces.insert(index, at);
                }
                let own = match earlier_normal(model, campaign, index, values) {
                    Some(n) => [n.x, n.y, n.z, n.dot(&at)],
                    None => values_at(target, &at, random),
                };
                for (slot, own) in model.target_values(index).iter().zip(own) {
                    slot.iter().for_each(|&slot| values[slot] = own);
                }
                if target.is_anchor() || self.can_touch(reading, index, values) {
                    break;
                }
            }
        }
        keep_apart(model, campaign, &faces, values);
        Ok(())
    }

    /// The first reading of a target.
    fn reading_of(&self, index: usize) -> Option<usize> {
        let target = &self.campaign.targets[index];
        let is_own = |r: &Reading| r.target == Some(index) && r.observes.target_column() == Some(target.column);
        self.campaign.readings.iter().position(is_own)
    }

    /// Contacts that were drawn, each with its first reading.
    fn touchable(&self) -> impl Iterator<Item = (usize, usize)> {
        let targets = self.campaign.targets.iter().enumerate();
        let drawn = targets.filter(|(_, target)| target.is_estimated() && target.is_contact());
        drawn.filter_map(|(index, _)| Some((index, self.reading_of(index)?)))
    }

    /// Whether the ball can be brought to a target from enough configurations.
    fn can_touch(&self, reading: usize, target: usize, values: &[f64]) -> bool {
        let fixture = target_values(self.model, self.campaign, target, values);
        let mut placements = Placements::default();
        let mut is_taken = |q: &Vec<f64>| {
            self.geometry.place(q, &mut placements).is_ok() && within_limits(self.geometry, q, &placements)
        };
        let touching = self.drawn.iter().filter_map(|q| self.toucher.touching(reading, &fixture, q, &[0.0; 6]));
        touching.filter(|q| is_taken(q)).count() as f64 >= SHARE * self.drawn.len() as f64
    }
}

/// Brings targets to the known distances and angles; `faces` go through their points again.
fn keep_apart(model: &Model, campaign: &Campaign, faces: &BTreeMap<usize, Vector3<f64>>, values: &mut [f64]) {
    hold_constraints(model, campaign, values, |constraint| constraint.length.is_none());
    // Unknown distances as the known ones leave them.
    for constraint in campaign.declared.iter().rev() {
        let length = constraint.length.and_then(|length| model.target_values(length).first().copied().flatten());
        let [a, b] = constraint.targets.map(|target| target_values(model, campaign, target, values));
        length.iter().for_each(|&slot| values[slot] = constraint.of([&a, &b], 0.0).0);
    }
    hold_constraints(model, campaign, values, |_| true);
    for (face, at) in faces {
        if let [Some(x), Some(y), Some(z), Some(offset)] = *model.target_values(*face) {
            let n = Vector3::new(values[x], values[y], values[z]).normalize();
            [(x, n.x), (y, n.y), (z, n.z), (offset, n.dot(at))].iter().for_each(|&(slot, value)| values[slot] = value);
        }
    }
    // Their distances, now that their directions are right.
    hold_constraints(model, campaign, values, |_| true);
}

/// Where the point is at one of these configurations, base frame; not under the robot: of two the one farther from its foot.
fn in_reach(
    drawn: &[Vec<f64>],
    seen: &mut dyn FnMut(&[f64]) -> Option<Vector3<f64>>,
    random: &mut ChaCha8Rng,
) -> Option<Vector3<f64>> {
    let places = [(); 2].map(|()| seen(&drawn[random.random_range(0..drawn.len())]));
    places.into_iter().flatten().max_by(|a, b| a.norm().total_cmp(&b.norm()))
}

/// An earlier target near which one stands, and their distance, m: the one to which its distance is constrained, else one of the
/// same placement of a fixture.
fn mate(campaign: &Campaign, index: usize) -> Option<(usize, f64)> {
    let target = &campaign.targets[index];
    let constrained = campaign.declared.iter().filter(|c| c.between == Between::Points).find_map(|c| {
        let [a, b] = c.targets;
        let other = if b == index { a } else { b };
        let distance = if c.length.is_some() { APART } else { c.value };
        ((a == index || b == index) && other < index).then_some((other, distance))
    });
    let fellow = (0..index).find(|&other| {
        let known = &campaign.targets[other];
        known.column == target.column && target.member.1.is_some() && known.member.1 == target.member.1
    });
    constrained.or(fellow.map(|other| (other, APART)))
}

/// Values of a target at a point: a face with any direction upwards, the zero of a draw wire, the radius of a sphere.
fn values_at(target: &Target, at: &Vector3<f64>, random: &mut ChaCha8Rng) -> [f64; 4] {
    if target.is_face() {
        let n = direction(random);
        let n = if n.z < 0.0 { -n } else { n };
        [n.x, n.y, n.z, n.dot(at)]
    } else if target.is_anchor() {
        [at.x, at.y, at.z, NEAR * normal(random)]
    } else {
        [at.x, at.y, at.z, RADIUS * (1.0 + 0.3 * normal(random)).abs()]
    }
}

/// Whether the first values of a target place it.
fn is_point(target: &Target) -> bool {
    target.is_anchor() || target.is_contact()
}

/// Where the campaign says that a target is about.
fn near(model: &Model, campaign: &Campaign, index: usize, values: &[f64]) -> Vector3<f64> {
    point_of(&target_values(model, campaign, index, values), &campaign.targets[index])
}

/// A point of a target.
fn point_of(values: &TargetValues, target: &Target) -> Vector3<f64> {
    let first = Vector3::from_column_slice(&values[..3]);
    if target.is_face() { first * (values[3] / first.norm_squared().max(f64::MIN_POSITIVE)) } else { first }
}

/// Gains, offsets, angles of mounting, unknown distances.
fn ordinary(model: &Model, target: &Target, index: usize, exact: bool, values: &mut [f64], random: &mut ChaCha8Rng) {
    for (slot, value) in model.target_values(index).iter().zip(&target.values) {
        let size = match value.kind {
            Kind::Length => 0.1 * APART,
            Kind::Angle => 0.05,
            Kind::Other("1") => 0.1,
            _ => 1.0,
        };
        let start = if value.kind == Kind::Length { APART } else { value.value };
        let drawn = if exact { 0.0 } else { size * normal(random) };
        slot.iter().for_each(|&slot| values[slot] = start + drawn);
    }
}

/// Moves targets as little as brings them to those of the distances and angles that are held (Gauss-Newton).
fn hold_constraints(model: &Model, campaign: &Campaign, values: &mut [f64], is_held: impl Fn(&Constraint) -> bool) {
    let constraints: Vec<&Constraint> = campaign.declared.iter().filter(|constraint| is_held(constraint)).collect();
    for _ in 0..30 {
        let count = constraints.len();
        let mut slots: Vec<usize> = Vec::new();
        let (mut entries, mut gaps) = (Vec::new(), DVector::zeros(count));
        for (row, constraint) in constraints.iter().enumerate() {
            let own = constraint.targets.map(|target| target_values(model, campaign, target, values));
            let length = constraint.length.and_then(|length| model.target_values(length).first().copied().flatten());
            let expected = length.map_or(constraint.value, |slot| values[slot]);
            let (found, by) = constraint.of([&own[0], &own[1]], expected);
            gaps[row] = found - expected;
            for (target, by) in constraint.targets.into_iter().zip(by) {
                for (k, slot) in model.target_values(target).iter().take(4).enumerate() {
                    let Some(slot) = *slot else { continue };
                    let column = slots.iter().position(|known| *known == slot).unwrap_or_else(|| {
                        slots.push(slot);
                        slots.len() - 1
                    });
                    entries.push((row, column, by[k]));
                }
            }
        }
        if count == 0 || gaps.amax() < 1e-12 || slots.is_empty() {
            return;
        }
        let mut jacobian = DMatrix::zeros(count, slots.len());
        entries.into_iter().for_each(|(row, column, value)| jacobian[(row, column)] += value);
        let step = least_norm(jacobian, &gaps);
        slots.iter().zip(step.iter()).for_each(|(&slot, step)| values[slot] += step);
    }
}
