//! The design of a sealed campaign: the machine's true values, the loads, and the configurations with their conditions.
//! Lengths in m, angles in rad, forces in N along base axes, temperatures in degC.

use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::calibrated::joint_compliances;
use crate::description::campaign::{Campaign, Conditions, Reading};
use crate::kinematics::Geometry;
use crate::model::Model;
use crate::observation::{DEFLECTION, POSITION};
use crate::prediction::PredictionError;
use crate::simulation::{draw_configurations, draw_errors};

/// Noise of a coordinate, one sigma: least, and how much more at most (m), as of laser trackers and photogrammetry at 2 m.
const SIGMA: [f64; 2] = [3e-5, 1e-5];
/// How far the base may be from where the description has it: m, m, m, rad, rad, rad.
const BASE: [f64; 6] = [0.5, 0.5, 0.5, 0.3, 0.3, 0.3];
/// One sigma of where the markers are on their bodies, m.
const MARKERS: f64 = 2e-3;
/// Applied forces: how many, the least, and how much more at most (N); loads that move a heavy robot by some tenths of a mm.
const FORCES: usize = 3;
const FORCE: [f64; 2] = [800.0, 1800.0];
/// Share of the joints' range in which configurations are drawn.
const RANGE: f64 = 0.8;
/// Between configurations, s.
const INTERVAL: f64 = 300.0;
/// Temperature at the start, by how much the machine warms up, and the swing of the hall.
const TEMPERATURE: [f64; 3] = [20.0, 9.0, 2.0];

/// A robot and how it is measured.
#[derive(Debug, Clone, Copy)]
pub struct Design<'a> {
    /// The robot.
    pub model: &'a Model,
    /// Its name.
    pub robot: &'a str,
    /// Whether deflections under three loads are measured, else absolute positions.
    pub is_deflection: bool,
    /// Number of configurations.
    pub poses: usize,
}

/// What is measured: true values of the machine, noise and loads.
pub(super) struct Bench<'a> {
    pub design: Design<'a>,
    /// True values by slot.
    pub values: Vec<f64>,
    /// Noise of a coordinate, one sigma, m.
    pub sigma: f64,
    /// Applied wrenches.
    wrenches: Vec<[f64; 6]>,
}

impl<'a> Bench<'a> {
    pub fn draw(design: Design<'a>, random: &mut ChaCha8Rng) -> Self {
        let model = design.model;
        let sigma = SIGMA[0] + SIGMA[1] * random.random::<f64>();
        // What the campaign does not calibrate is as described, so that a null is one.
        let (geometry, elastic) = if design.is_deflection { (0.0, 1.0) } else { (1.0, 0.0) };
        let mut values = draw_errors(model, geometry, elastic, random);
        let calibrated = joint_compliances(model);
        for slot in model.elastic_slots().into_iter().filter(|slot| !calibrated.contains(slot)) {
            values[slot] = model.registry[slot].nominal;
        }
        if !design.is_deflection {
            for (k, size) in BASE.into_iter().enumerate() {
                values[model.base + k] += size * (2.0 * random.random::<f64>() - 1.0);
            }
            for slot in model.markers.iter().flat_map(|marker| marker.slot..marker.slot + 3) {
                values[slot] += MARKERS * normal(random);
            }
        }
        let wrenches = (0..FORCES).map(|k| wrench(k == 0, random)).collect();
        Self { design, values, sigma, wrenches }
    }

    /// A campaign with nothing measured yet; `late` is by how many intervals it starts later.
    pub fn planned(&self, late: f64, random: &mut ChaCha8Rng) -> Result<Campaign, PredictionError> {
        let Design { model, is_deflection, poses, .. } = self.design;
        let geometry = Geometry::new(model, &self.values)?;
        let configurations = draw_configurations(&geometry, poses, RANGE, random)?;
        let calibrate = if is_deflection { &["joint-compliance"][..] } else { &["geometry", "joint-offset"] };
        let mut campaign = Campaign {
            name: String::new(),
            observes: if is_deflection { DEFLECTION } else { POSITION },
            sigma: Some([self.sigma; 3]),
            sigma_orientation: None,
            estimate_base: !is_deflection,
            estimate_tool: !is_deflection,
            calibrate: calibrate.iter().map(ToString::to_string).collect(),
            poses: (1..=configurations.len()).map(|k| format!("p{k:03}")).collect(),
            variables: model.variables.len(),
            conditions: Conditions { approach: vec![None; model.variables.len()], ..Conditions::default() },
            ..Campaign::default()
        };
        let wrenches = if is_deflection { &self.wrenches[..] } else { &[[0.0; 6]] };
        for (pose, q) in configurations.iter().enumerate() {
            let time = (INTERVAL * (pose as f64 + late)).round();
            let temperature = warm_up(time / (INTERVAL * poses as f64));
            let sides: Vec<f64> = model.variables.iter().map(|_| if random.random() { 1.0 } else { -1.0 }).collect();
            let points =
                if model.markers.is_empty() { vec![None] } else { (0..model.markers.len()).map(Some).collect() };
            for marker in points {
                for &wrench in wrenches {
                    let row = campaign.readings.len() + 1;
                    let check = Some(false);
                    let blank = campaign.blank();
                    campaign.readings.push(Reading { row, pose, marker, wrench, check, ..blank });
                    campaign.joints.extend_from_slice(q);
                    if !is_deflection {
                        note(&mut campaign.conditions, time, temperature, &sides);
                    }
                }
            }
        }
        Ok(campaign)
    }

    /// Fills a campaign with what a machine shows, and noise.
    pub fn measure(&self, campaign: &mut Campaign, shown: &[[f64; 3]], random: &mut ChaCha8Rng) {
        for (reading, shown) in campaign.readings.iter_mut().zip(shown) {
            for (measured, shown) in reading.measured.iter_mut().zip(shown) {
                *measured = shown + self.sigma * normal(random);
            }
        }
    }

    /// Root mean square length of the noise of a reading, m.
    pub fn noise(&self) -> f64 {
        self.sigma * 3.0_f64.sqrt()
    }
}

/// A draw of the standard normal distribution.
pub(super) fn normal(random: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(random)
}

/// A force in a random direction, in the main downwards.
fn wrench(is_first: bool, random: &mut ChaCha8Rng) -> [f64; 6] {
    let size = FORCE[0] + FORCE[1] * random.random::<f64>();
    let along = Vector3::from_fn(|_, _| normal(random));
    let along = (along.normalize() - Vector3::z() * if is_first { 2.0 } else { 0.6 }).normalize() * size;
    [along.x.round(), along.y.round(), along.z.round(), 0.0, 0.0, 0.0]
}

/// Temperature at a share of the campaign's length, to a hundredth of a degree.
fn warm_up(share: f64) -> f64 {
    let [start, rise, swing] = TEMPERATURE;
    let temperature = start + rise * (1.0 - (-3.0 * share).exp()) + swing * (9.0 * share).sin();
    (temperature * 100.0).round() / 100.0
}

/// Adds the conditions of one reading.
fn note(conditions: &mut Conditions, time: f64, temperature: f64, sides: &[f64]) {
    conditions.time.get_or_insert_default().push(time);
    conditions.temperature.get_or_insert_default().push(temperature);
    for (column, side) in conditions.approach.iter_mut().zip(sides) {
        column.get_or_insert_default().push(*side);
    }
}
