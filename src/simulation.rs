//! Campaigns made by the model itself: prediction plus noise, for planning and for checks whose truth is known.

use indexmap::IndexMap;
use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::description::campaign::{Campaign, Observes, Reading};
use crate::kinematics::{AssemblyError, Geometry, Placements, rotation_vector};
use crate::model::Model;
use crate::prediction::{Deflections, PredictionError, predict, rest};

/// What is measured, where and how well.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Configurations, rad and m.
    pub configurations: Vec<Vec<f64>>,
    /// Markers read at each; `None` is the tool centre point.
    pub markers: Vec<Option<usize>>,
    /// Readings of each marker at each configuration.
    pub repeats: usize,
    /// Wrenches applied at each marker, one reading each: force and moment, N and N.m, base axes; none where empty.
    pub wrenches: Vec<[f64; 6]>,
    /// What a reading is.
    pub observes: Observes,
    /// One sigma of a coordinate or distance, m.
    pub sigma: f64,
    /// One sigma of a component of the orientation, rad.
    pub sigma_orientation: f64,
    /// Whether base and tool are declared unknown in the campaign.
    pub estimate: [bool; 2],
}

/// The generator of a seed; the stream does not change between versions.
pub fn generator(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// Configurations drawn uniformly from the middle `share` of each variable's limits (a turn where it has none), as far
/// as they can be assembled and keep the limits of joints.
///
/// # Errors
/// The last assembly error if hardly any configuration can be assembled.
pub fn draw_configurations(
    geometry: &Geometry,
    count: usize,
    share: f64,
    random: &mut ChaCha8Rng,
) -> Result<Vec<Vec<f64>>, AssemblyError> {
    let model = geometry.model;
    let turn = std::f64::consts::PI;
    let mut placements = Placements::default();
    let mut drawn = Vec::with_capacity(count);
    let mut last = None;
    for _ in 0..1000 * count.max(1) {
        if drawn.len() == count {
            break;
        }
        let q: Vec<f64> = model
            .variables
            .iter()
            .map(|variable| {
                let [low, high] = variable.limits.filter(|l| l.iter().all(|v| v.is_finite())).unwrap_or([-turn, turn]);
                0.5 * (low + high) + share * (high - low) * (random.random::<f64>() - 0.5)
            })
            .collect();
        match geometry.place(&q, &mut placements) {
            Ok(()) => {
                let inside = model.frames.iter().zip(&placements.joints).all(|(frame, joint)| {
                    frame.limits.is_none_or(|[low, high]| (low..=high).contains(joint) || !frame.moves())
                });
                if inside {
                    drawn.push(q);
                }
            }
            Err(error) => last = Some(error),
        }
    }
    match last {
        Some(error) if drawn.len() < count => Err(error),
        _ => Ok(drawn),
    }
}

/// Values with every parameter that calibration frees off by its tolerance times a normal number, the geometry's times
/// `geometry`, those of what gives times `elastic`.
pub fn draw_errors(model: &Model, geometry: f64, elastic: f64, random: &mut ChaCha8Rng) -> Vec<f64> {
    let mut values = model.registry.nominal();
    let all = model.free_slots().into_iter().map(|slot| (slot, geometry));
    for (slot, scale) in all.chain(model.elastic_slots().into_iter().map(|slot| (slot, elastic))) {
        let draw: f64 = StandardNormal.sample(random);
        let [low, high] = model.registry[slot].bounds;
        values[slot] = (values[slot] + scale * model.registry[slot].tolerance * draw).clamp(low, high);
    }
    values
}

/// The campaign that a robot of these `values` would give.
///
/// # Errors
/// A configuration that cannot be assembled, or a structure that can move without force.
pub fn simulate(
    model: &Model,
    values: &[f64],
    plan: &Plan,
    random: &mut ChaCha8Rng,
) -> Result<Campaign, PredictionError> {
    let geometry = Geometry::new(model, values)?;
    let mut campaign = Campaign {
        name: format!("{}, simulated", model.name),
        observes: plan.observes,
        sigma: (plan.sigma > 0.0).then_some([plan.sigma; 3]),
        sigma_orientation: (plan.sigma_orientation > 0.0).then_some(plan.sigma_orientation),
        estimate_base: plan.estimate[0],
        estimate_tool: plan.estimate[1],
        calibrate: match plan.observes {
            Observes::Deflection => vec!["joint-compliance".into()],
            _ => vec!["geometry".into(), "joint-offset".into()],
        },
        without: Vec::new(),
        anchors: model.anchors.clone(),
        poses: Vec::new(),
        variables: model.variables.len(),
        joints: Vec::new(),
        readings: Vec::new(),
        conditions: IndexMap::new(),
    };
    let mut placements = Placements::default();
    let unloaded = [[0.0; 6]];
    let wrenches = if plan.wrenches.is_empty() { &unloaded[..] } else { &plan.wrenches };
    // Whether anything loads the structure is seen from the readings; these stand for all.
    campaign.readings = wrenches.iter().map(|wrench| Reading { wrench: *wrench, ..BLANK }).collect();
    let deflections = Deflections::new(model, values, &campaign, &[]);
    campaign.readings.clear();
    let mut loaded = deflections.work();
    let anchors = if plan.observes == Observes::Distance { campaign.anchors.len().max(1) } else { 1 };
    for (pose, q) in plan.configurations.iter().enumerate() {
        let name = format!("p{:03}", pose + 1);
        let row = campaign.readings.len() + 1;
        geometry.place(q, &mut placements).map_err(|source| PredictionError::Assembly {
            row,
            pose: name.clone(),
            source,
        })?;
        deflections.place(&placements, &mut loaded).map_err(|source| PredictionError::Mechanism {
            row,
            pose: name.clone(),
            source,
        })?;
        campaign.poses.push(name);
        for _ in 0..plan.repeats {
            for &marker in &plan.markers {
                for (anchor, &wrench) in (0..anchors).flat_map(|anchor| wrenches.iter().map(move |w| (anchor, w))) {
                    let row = campaign.readings.len() + 1;
                    let mut reading = Reading { row, pose, marker, anchor, wrench, ..BLANK };
                    let point = rest(&geometry, &placements, &reading);
                    let deflected = deflections.of(&loaded, &reading, &point);
                    let predicted = predict(&geometry, &campaign, &placements, &reading, &deflected);
                    reading.measured = predicted.measured(&campaign);
                    disturb(&mut reading.measured, plan, random);
                    campaign.joints.extend_from_slice(q);
                    campaign.readings.push(reading);
                }
            }
        }
    }
    Ok(campaign)
}

const BLANK: Reading =
    Reading { row: 0, pose: 0, marker: None, measured: [0.0; 6], anchor: 0, wrench: [0.0; 6], check: None };

fn disturb(measured: &mut [f64; 6], plan: &Plan, random: &mut ChaCha8Rng) {
    let mut normal = || -> f64 { StandardNormal.sample(random) };
    let components = if plan.observes == Observes::Distance { 1 } else { 3 };
    for value in &mut measured[..components] {
        *value += plan.sigma * normal();
    }
    if plan.observes == Observes::Pose {
        let noise = Vector3::from_fn(|_, _| plan.sigma_orientation * normal());
        let turn = Rotation3::new(noise) * Rotation3::new(Vector3::new(measured[3], measured[4], measured[5]));
        measured[3..].copy_from_slice(rotation_vector(&turn).as_slice());
    }
}
