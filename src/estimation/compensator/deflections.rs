//! The compensator and the joint that it unloads from deflections: KR-270 paper, eq. (12) and Tables VI and VII. In two steps, a
//! compliance of the joint at each of its angles and then the law through them, and in one, everything in one fit.

use nalgebra::{DMatrix, DVector, Vector3};

use super::law::{Elasticity, JointCompliance, Misfit, Triangle, elasticity_within};
use super::value::{CompensatorError, Value, refuse};
use crate::description::campaign::Campaign;
use crate::description::parameters::Owner;
use crate::elements::Spring;
use crate::estimation::problem::row_sigmas;
use crate::estimation::result::Estimate;
use crate::estimation::settings::{Settings, What};
use crate::estimation::{calibrate, candidates};
use crate::kinematics::{Geometry, Placements};
use crate::math::least_squares;
use crate::math::linear::cofactor;
use crate::math::quantiles::t95;
use crate::model::Model;
use crate::parameter::Slot;
use crate::prediction::{PredictionError, Predictor, residuals};

/// Readings at one angle of the joint.
#[derive(Debug, Clone, PartialEq)]
pub struct AtAngle {
    /// Mean angle (rad) and the compliance found there; its interval is there.
    pub compliance: JointCompliance,
    /// Number of readings.
    pub readings: usize,
}

/// One way to the compensator.
#[derive(Debug, Clone, PartialEq)]
pub struct Way {
    /// Joint and spring.
    pub elasticity: Elasticity,
    /// The other compliances found, by slot.
    pub others: Vec<(Slot, Value)>,
    /// Root mean square residual of the coordinates with what was found, m.
    pub residual: f64,
}

/// Both ways, on the same readings.
#[derive(Debug, Clone, PartialEq)]
pub struct FromDeflections {
    /// Where the spring is hung.
    pub triangle: Triangle,
    /// The joint by its angle, without a law: the first of the two steps.
    pub angles: Vec<AtAngle>,
    /// Root mean square residual with these, m.
    pub residual: f64,
    /// How far the law is from them.
    pub misfit: Option<Misfit>,
    /// In two steps.
    pub two_steps: Way,
    /// In one.
    pub one_step: Way,
}

/// Angles (rad) of readings of one group lie no farther apart.
pub const TOGETHER: f64 = 0.035;

/// Compensator `spring` of a model from the deflections of a campaign; angles within `together` (rad) of each other count as one.
///
/// # Errors
/// Readings that are no deflections, too few angles, or that do not determine joint and spring.
pub fn from_deflections(
    model: &Model,
    campaign: &Campaign,
    spring: &Spring,
    together: f64,
) -> Result<FromDeflections, CompensatorError> {
    if !campaign.is_difference() {
        return refuse(format!("{} readings are no deflections", campaign.observes.name()));
    }
    let [rate, length, ..] = spring.slots;
    let joint = Owner::Joint(&model.frames[spring.pivot].name).parameter("kar");
    let Some(joint) = model.registry.slot(&joint) else {
        return refuse(format!(
            "the description gives no `{joint}`: the joint that the spring unloads has no spring of its own"
        ));
    };
    if spring.spring.free_length.is_none() {
        return refuse("the description gives the spring no free length to start from");
    }
    let nominal = model.registry.nominal();
    let triangle = hung(model, spring, &nominal)?;
    let groups = groups(model, campaign, spring, together)?;
    if groups.len() < 3 {
        return refuse(format!(
            "the readings lie at {} angles of the joint (those within {:.2} deg count as one), and three or more are needed",
            groups.len(),
            together.to_degrees()
        ));
    }

    let own = [joint, rate, length];
    let mut one_step = in_one_step(model, campaign, own)?;
    let others: Vec<Slot> = one_step.others.iter().map(|(slot, _)| *slot).collect();
    let first = by_angle(model, campaign, &groups, joint, &others, &with(&nominal, &[(rate, 0.0)]))?;
    let (mut elasticity, misfit) =
        elasticity_within(&triangle, &first.compliances(), &first.covariance, first.freedom)?;
    let law = |of: &Elasticity| {
        let all = first
            .angles
            .iter()
            .map(|at| (at.compliance.compliance - of.compliance(&triangle, at.compliance.angle)).powi(2));
        (all.sum::<f64>() / first.angles.len() as f64).sqrt()
    };
    elasticity.rms = law(&elasticity);
    one_step.elasticity.rms = law(&one_step.elasticity);
    let residual = left_by(model, campaign, own, &elasticity, &first.others)?;
    let two_steps = Way { elasticity, others: first.others.clone(), residual };
    Ok(FromDeflections { triangle, residual: first.residual, angles: first.angles, misfit, two_steps, one_step })
}

/// Joint, rate and free length of the spring (`own`) with all other springs that the readings determine, in one fit of the
/// deflections.
fn in_one_step(model: &Model, campaign: &Campaign, own: [Slot; 3]) -> Result<Way, CompensatorError> {
    let [joint, rate, length] = own;
    let elastic = What { geometric: false, elastic: true };
    let mut slots = candidates(model, campaign, elastic).map_err(failed)?;
    slots.extend(own.into_iter().filter(|slot| !slots.contains(slot)).collect::<Vec<_>>());
    let settings = Settings { only: Some(slots), ..Settings::default() };
    let found =
        calibrate(model, campaign, &vec![false; campaign.readings.len()], &settings, &mut |_| {}).map_err(failed)?;
    let estimate = |slot: Slot| -> Result<Value, CompensatorError> {
        match found.estimates.iter().find(|estimate| estimate.slot == slot) {
            Some(&Estimate { value, ci95: Some(ci95), .. }) => Ok(Value { value, ci95: Some(ci95) }),
            _ => refuse(format!("the readings do not determine `{}`", model.registry[slot].name)),
        }
    };
    if !found.converged() {
        return refuse(format!("the fit in one step did not converge ({})", found.ending));
    }
    let kept = found.estimates.iter().filter(|of| of.identifiable() && !own.contains(&of.slot));
    let others: Vec<Slot> = kept.map(|of| of.slot).collect();
    let stiffness = estimate(rate)?;
    let elasticity = Elasticity {
        joint: estimate(joint)?,
        spring: Value { value: 1.0 / stiffness.value, ci95: stiffness.ci95.map(|ci95| ci95 / stiffness.value.powi(2)) },
        free_length: estimate(length)?,
        rms: 0.0,
    };
    Ok(Way {
        others: others.iter().map(|&slot| Ok((slot, estimate(slot)?))).collect::<Result<_, CompensatorError>>()?,
        residual: found.after.fit.coordinate[0],
        elasticity,
    })
}

/// Root mean square of what a law and other springs leave of the deflections, m.
fn left_by(
    model: &Model,
    campaign: &Campaign,
    [joint, rate, length]: [Slot; 3],
    elasticity: &Elasticity,
    others: &[(Slot, Value)],
) -> Result<f64, CompensatorError> {
    let mut values = model.registry.nominal();
    others.iter().for_each(|(slot, value)| values[*slot] = value.value);
    let all = [
        (joint, elasticity.joint.value),
        (rate, 1.0 / elasticity.spring.value),
        (length, elasticity.free_length.value),
    ];
    let left = residuals(model, campaign, &with(&values, &all)).map_err(failed)?;
    Ok(crate::estimation::errors_of(campaign, &left, |_| true).coordinate[0])
}

fn failed(error: impl std::fmt::Display) -> CompensatorError {
    CompensatorError(error.to_string())
}

fn with(values: &[f64], changed: &[(Slot, f64)]) -> Vec<f64> {
    let mut values = values.to_vec();
    changed.iter().for_each(|&(slot, value)| values[slot] = value);
    values
}

/// Where the spring is hung, as the law counts it, from its anchors about the joint's axis.
fn hung(model: &Model, spring: &Spring, values: &[f64]) -> Result<Triangle, CompensatorError> {
    let geometry = Geometry::new(model, values).map_err(failed)?;
    let mut placements = Placements::default();
    geometry.place(&vec![0.0; model.variables.len()], &mut placements).map_err(failed)?;
    let axis = placements.frames[spring.pivot];
    let at = |k: usize| {
        axis.inverse()
            * (placements.frames[spring.spring.bodies[k]] * nalgebra::Point3::from(anchor(spring, values, k)))
    };
    let moves_with_joint = |frame: usize| model.path(frame).contains(&spring.pivot);
    let [fixed, moving] = if moves_with_joint(spring.spring.bodies[1]) { [at(0), at(1)] } else { [at(1), at(0)] };
    let (a, l) = (-fixed.xy().coords, moving.xy().coords);
    if (fixed.z - moving.z).abs() > 1e-3 * a.norm() {
        return refuse("the spring is not in a plane across the joint's axis: the law of eq. (10) does not hold");
    }
    let alpha = (a.x * l.y - a.y * l.x).atan2(a.dot(&l));
    let phase = alpha - placements.joints[spring.pivot];
    Ok(Triangle { lever: l.norm(), ax: -a.norm() * phase.sin(), ay: a.norm() * phase.cos() })
}

fn anchor(spring: &Spring, values: &[f64], body: usize) -> Vector3<f64> {
    Vector3::from_fn(|k, _| values[spring.slots[2 + 3 * body + k]])
}

/// Readings by the angle of the joint: mean angle, and which.
fn groups(
    model: &Model,
    campaign: &Campaign,
    spring: &Spring,
    together: f64,
) -> Result<Vec<(f64, Vec<usize>)>, CompensatorError> {
    let geometry = Geometry::nominal(model).map_err(failed)?;
    let mut placements = Placements::default();
    let mut angles = Vec::with_capacity(campaign.readings.len());
    for index in 0..campaign.readings.len() {
        geometry.place(campaign.configuration(index), &mut placements).map_err(failed)?;
        angles.push((placements.joints[spring.pivot], index));
    }
    angles.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut groups: Vec<Vec<(f64, usize)>> = Vec::new();
    for at in angles {
        match groups.last_mut() {
            Some(group) if at.0 - group[0].0 <= together => group.push(at),
            _ => groups.push(vec![at]),
        }
    }
    let mean = |group: &[(f64, usize)]| group.iter().map(|at| at.0).sum::<f64>() / group.len() as f64;
    Ok(groups.into_iter().map(|group| (mean(&group), group.into_iter().map(|at| at.1).collect())).collect())
}

/// The first step.
struct ByAngle {
    angles: Vec<AtAngle>,
    others: Vec<(Slot, Value)>,
    /// Of the compliances by angle.
    covariance: DMatrix<f64>,
    freedom: f64,
    residual: f64,
}

impl ByAngle {
    fn compliances(&self) -> Vec<JointCompliance> {
        self.angles.iter().map(|at| at.compliance).collect()
    }
}

/// Residuals of all groups of readings, each at its own values, over their noise; and their derivatives by a compliance of
/// each group, then by what all groups have in common.
fn linearised(
    predictors: &[Predictor],
    values: impl Fn(usize) -> Vec<f64>,
    sigmas: &[f64],
    right: &mut DVector<f64>,
    jacobian: &mut DMatrix<f64>,
) -> Result<(), CompensatorError> {
    let mut row = 0;
    for (group, predictor) in predictors.iter().enumerate() {
        let found = predictor.linearised(&values(group)).map_err(failed)?;
        for (residual, derivatives) in found.residual.iter().zip(found.jacobian.chunks(predictor.slots.len())) {
            right[row] = residual / sigmas[row];
            jacobian[(row, group)] = derivatives[0] / sigmas[row];
            for (k, derivative) in derivatives[1..].iter().enumerate() {
                jacobian[(row, predictors.len() + k)] = derivative / sigmas[row];
            }
            row += 1;
        }
    }
    Ok(())
}

/// Most Gauss-Newton steps: deflections are linear in the compliances but for second-order terms.
const STEPS: usize = 30;

/// A compliance of the joint for each group of readings, and the others for all: eq. (12).
fn by_angle(
    model: &Model,
    campaign: &Campaign,
    groups: &[(f64, Vec<usize>)],
    joint: Slot,
    others: &[Slot],
    start: &[f64],
) -> Result<ByAngle, CompensatorError> {
    let slots: Vec<Slot> = std::iter::once(joint).chain(others.iter().copied()).collect();
    let parts: Vec<Campaign> = groups.iter().map(|(_, own)| campaign.select(|index, _| own.contains(&index))).collect();
    let predictors = parts
        .iter()
        .map(|part| Predictor::new(model, part, slots.clone()))
        .collect::<Result<Vec<_>, PredictionError>>();
    let predictors = predictors.map_err(failed)?;
    let sigmas: Vec<f64> = parts.iter().flat_map(row_sigmas).collect();
    let count = groups.len();
    let mut x: Vec<f64> =
        std::iter::repeat_n(start[joint], count).chain(others.iter().map(|&slot| start[slot])).collect();
    let mut jacobian = DMatrix::zeros(sigmas.len(), count + others.len());
    let mut right = DVector::zeros(sigmas.len());
    for step in 0..=STEPS {
        let values = |group: usize| {
            let own = std::iter::once(x[group]).chain(x[count..].iter().copied());
            with(start, &slots.iter().copied().zip(own).collect::<Vec<_>>())
        };
        linearised(&predictors, values, &sigmas, &mut right, &mut jacobian)?;
        // Residuals are measured less predicted, derivatives those of the predictions.
        let change = least_squares(&jacobian, &right);
        if x.iter().zip(&change).all(|(x, change)| change.abs() <= 1e-9 * x.abs()) {
            break;
        }
        if step == STEPS {
            return refuse(format!("the compliances by angle did not settle within {STEPS} Gauss-Newton steps"));
        }
        x.iter_mut().zip(&change).for_each(|(x, change)| *x += change);
    }
    let freedom = sigmas.len() as f64 - x.len() as f64;
    if freedom < 1.0 {
        return refuse(format!("{} coordinates do not determine {} compliances", sigmas.len(), x.len()));
    }
    let variance = right.norm_squared() / freedom;
    let covariance = cofactor(&jacobian) * variance;
    let value = |k: usize| Value { value: x[k], ci95: Some(t95(freedom) * covariance[(k, k)].max(0.0).sqrt()) };
    let angles = groups.iter().enumerate().map(|(k, (angle, own))| AtAngle {
        compliance: JointCompliance { angle: *angle, compliance: x[k], ci95: value(k).ci95 },
        readings: own.len(),
    });
    let squares: f64 = right.iter().zip(&sigmas).map(|(residual, sigma)| (residual * sigma).powi(2)).sum();
    Ok(ByAngle {
        angles: angles.collect(),
        others: others.iter().enumerate().map(|(k, &slot)| (slot, value(count + k))).collect(),
        covariance: covariance.view((0, 0), (count, count)).into_owned(),
        freedom,
        residual: (squares / sigmas.len() as f64).sqrt(),
    })
}
