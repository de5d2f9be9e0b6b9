//! Campaigns made by the model itself: prediction plus noise, for planning and for checks whose truth is known.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::description::campaign::{Campaign, LoadPoint, Reading, Target};
use crate::description::robot::Motion;
use crate::effects::Condition;
use crate::kinematics::{AssemblyError, Geometry, Placements, beyond_limits, entered};
use crate::model::Model;
use crate::observation::{Noise, Observes, POSE, Purpose};
use crate::prediction::{PredictionError, Predictor, with_holding_loads};

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
    /// Whether side of approach, time and temperature are recorded.
    pub conditions: bool,
    /// What a reading is.
    pub observes: Observes,
    /// One sigma of a coordinate or distance, m.
    pub sigma: f64,
    /// One sigma of a component of the orientation, rad.
    pub sigma_orientation: f64,
    /// Whether base and tool are declared unknown in the campaign.
    pub estimate: [bool; 2],
}

/// A configuration (rad, m) and the load on it (N, N.m, base axes).
pub type Loaded = (Vec<f64>, [f64; 6]);

/// The generator of a seed; the stream does not change between versions.
pub fn generator(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// The middle `share` of each variable's limits (of a turn where it has none), rad and m.
pub fn joint_box(model: &Model, share: f64) -> Vec<[f64; 2]> {
    let turn = std::f64::consts::PI;
    let side = |variable: &crate::description::robot::Variable| {
        let [low, high] = variable.limits.filter(|l| l.iter().all(|v| v.is_finite())).unwrap_or([-turn, turn]);
        let (middle, half) = (0.5 * (low + high), 0.5 * share * (high - low));
        [middle - half, middle + half]
    };
    model.variables.iter().map(side).collect()
}

/// Whether a placed configuration `q` (rad and m) keeps the limits of all joints and of sums of joints, and out of the boxes
/// declared.
pub fn within_limits(geometry: &Geometry, q: &[f64], placements: &Placements) -> bool {
    let model = geometry.model;
    let driven = model.frames.iter().zip(&placements.joints);
    driven
        .filter(|(frame, _)| matches!(frame.motion, Motion::Variable { .. }))
        .all(|(frame, joint)| frame.limits.is_none_or(|[low, high]| (low..=high).contains(joint)))
        && beyond_limits(model, q, placements).next().is_none()
        && entered(geometry, placements).next().is_none()
}

/// Configurations drawn uniformly from a box of the variables (rad, m), as far as they can be assembled, keep the limits
/// of joints and are accepted: fewer than `count` if too few do, and the last assembly error if there was one.
pub fn draw_in_box(
    geometry: &Geometry,
    within: &[[f64; 2]],
    count: usize,
    random: &mut ChaCha8Rng,
    mut accepted: impl FnMut(&[f64], &Placements) -> bool,
) -> (Vec<Vec<f64>>, Option<AssemblyError>) {
    let mut placements = Placements::default();
    let mut drawn = Vec::with_capacity(count);
    let mut last = None;
    for _ in 0..1000 * count.max(1) {
        if drawn.len() == count {
            break;
        }
        let q: Vec<f64> = within
            .iter()
            .map(|[low, high]| 0.5 * (low + high) + (high - low) * (random.random::<f64>() - 0.5))
            .collect();
        match geometry.place(&q, &mut placements) {
            Ok(()) => {
                if within_limits(geometry, &q, &placements) && accepted(&q, &placements) {
                    drawn.push(q);
                }
            }
            Err(error) => last = Some(error),
        }
    }
    (drawn, last)
}

/// Configurations drawn uniformly from the middle `share` of each variable's limits (a turn where it has none), as far
/// as they can be assembled and keep the limits of joints.
///
/// # Errors
/// The last assembly error if hardly any configuration can be assembled.
///
/// ```
/// use elastogeo::kinematics::Geometry;
/// use elastogeo::simulation::{draw_configurations, generator};
///
/// let model = elastogeo::files::load_robot("kuka-kr270")?.model;
/// let geometry = Geometry::nominal(&model)?;
/// let drawn = draw_configurations(&geometry, 5, 0.5, &mut generator(1))?;
/// assert_eq!(drawn, draw_configurations(&geometry, 5, 0.5, &mut generator(1))?); // the same for a seed
/// # Ok::<(), elastogeo::Error>(())
/// ```
pub fn draw_configurations(
    geometry: &Geometry,
    count: usize,
    share: f64,
    random: &mut ChaCha8Rng,
) -> Result<Vec<Vec<f64>>, AssemblyError> {
    draw_configurations_in(geometry, &joint_box(geometry.model, share), count, random)
}

/// The same from a box of the variables (rad, m). Where joints follow others, the robot with its nominal values takes them too.
///
/// # Errors
/// As [`draw_configurations`].
pub fn draw_configurations_in(
    geometry: &Geometry,
    within: &[[f64; 2]],
    count: usize,
    random: &mut ChaCha8Rng,
) -> Result<Vec<Vec<f64>>, AssemblyError> {
    // The robot as described has to take what a real one takes, or nothing could be fitted to it.
    let nominal = Geometry::nominal(geometry.model).ok().filter(|_| !geometry.model.stages.is_empty());
    let mut placements = Placements::default();
    let accepted = |q: &[f64], _: &Placements| {
        nominal
            .as_ref()
            .is_none_or(|nominal| nominal.place(q, &mut placements).is_ok() && within_limits(nominal, q, &placements))
    };
    match draw_in_box(geometry, within, count, random, accepted) {
        (drawn, Some(error)) if drawn.len() < count => Err(error),
        (drawn, _) => Ok(drawn),
    }
}

/// Values with every parameter that calibration frees off by its tolerance times a normal number, the geometry's times
/// `geometry`, those of springs times `elastic`.
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

/// Effects that a campaign of this kind of readings usually re-fits with whatever is tried, as `calibrate:` names them.
pub fn usually_calibrated(observes: Observes) -> Vec<String> {
    let effects: &[&str] = match observes.purpose() {
        Purpose::Geometry => &["geometry", "joint-offset"],
        Purpose::Stiffness => &["joint-compliance"],
    };
    effects.iter().map(ToString::to_string).collect()
}

/// A plan as a campaign in which nothing is measured yet.
pub fn unmeasured(model: &Model, plan: &Plan) -> Campaign {
    let mut campaign = Campaign {
        name: format!("{}, simulated", model.name),
        observes: plan.observes,
        sigma: (plan.sigma > 0.0).then_some([plan.sigma; 3]),
        sigma_orientation: (plan.sigma_orientation > 0.0).then_some(plan.sigma_orientation),
        estimate_base: plan.estimate[0],
        estimate_tool: plan.estimate[1],
        calibrate: usually_calibrated(plan.observes),
        targets: model.anchors.iter().map(|(name, at)| Target::anchor(name, at)).collect(),
        variables: model.variables.len(),
        ..Campaign::default()
    };
    let unloaded = [[0.0; 6]];
    let wrenches = if plan.wrenches.is_empty() { &unloaded[..] } else { &plan.wrenches };
    let (targets, blank) = (campaign.targets_per_point(), campaign.blank());
    for (pose, q) in plan.configurations.iter().enumerate() {
        campaign.poses.push(format!("p{:03}", pose + 1));
        for _ in 0..plan.repeats {
            for &marker in &plan.markers {
                for (target, &wrench) in targets.iter().flat_map(|&target| wrenches.iter().map(move |w| (target, w))) {
                    let row = campaign.readings.len() + 1;
                    campaign.readings.push(Reading { row, pose, marker, target, wrench, ..blank });
                    campaign.joints.extend_from_slice(q);
                }
            }
        }
    }
    campaign
}

/// One unloaded configuration at which the poses of the tool centre point, then of every marker, would be read: the
/// readings that a [`crate::prediction::SinglePredictor`] needs to say where loads put them.
pub fn all_points(model: &Model) -> Campaign {
    let plan = Plan {
        configurations: vec![model.middle()],
        markers: std::iter::once(None).chain((0..model.markers.len()).map(Some)).collect(),
        repeats: 1,
        wrenches: Vec::new(),
        conditions: false,
        observes: POSE,
        sigma: 0.0,
        sigma_orientation: 0.0,
        estimate: [false, false],
    };
    let mut campaign = unmeasured(model, &plan);
    campaign.readings.iter_mut().for_each(|reading| reading.load_point = LoadPoint::Marker(None));
    campaign
}

/// The campaign that a robot of these `values` would give; effects that the model has switched on are in it.
///
/// # Errors
/// A configuration that cannot be assembled, or a structure that can move without force.
///
/// ```
/// use elastogeo::kinematics::Geometry;
/// use elastogeo::observation::POSITION;
/// use elastogeo::simulation::{Plan, draw_configurations, draw_errors, generator, simulate};
///
/// let model = elastogeo::files::load_robot("universal-ur5")?.model;
/// let mut random = generator(7);
/// let truth = draw_errors(&model, 1.0, 0.0, &mut random);
/// let plan = Plan {
///     configurations: draw_configurations(&Geometry::nominal(&model)?, 20, 0.8, &mut random)?,
///     markers: vec![None],
///     repeats: 1,
///     wrenches: Vec::new(),
///     conditions: false,
///     observes: POSITION,
///     sigma: 3e-5, // m
///     sigma_orientation: 0.0,
///     estimate: [true, true],
/// };
/// let campaign = simulate(&model, &truth, &plan, &mut random)?;
/// assert_eq!(campaign.readings.len(), 20);
/// # Ok::<(), elastogeo::Error>(())
/// ```
pub fn simulate(
    model: &Model,
    values: &[f64],
    plan: &Plan,
    random: &mut ChaCha8Rng,
) -> Result<Campaign, PredictionError> {
    carry_out(model, values, plan, unmeasured(model, plan), random)
}

/// The same for the readings of a campaign made by [`unmeasured`], of which some may have been taken out.
///
/// # Errors
/// As [`simulate`].
pub fn carry_out(
    model: &Model,
    values: &[f64],
    plan: &Plan,
    mut campaign: Campaign,
    random: &mut ChaCha8Rng,
) -> Result<Campaign, PredictionError> {
    if plan.conditions {
        conditions(model, &mut campaign, random);
    }
    measure(model, values, campaign, [plan.sigma, plan.sigma_orientation], random)
}

/// A campaign measured anew: its readings are what a robot of these `values` would give, with noise of one sigma (m of a
/// coordinate, rad of a component of the orientation).
///
/// # Errors
/// As [`simulate`].
pub fn measure(
    model: &Model,
    values: &[f64],
    campaign: Campaign,
    sigma: [f64; 2],
    random: &mut ChaCha8Rng,
) -> Result<Campaign, PredictionError> {
    let noise = Noise::of([sigma[0]; 3], sigma[1]);
    measure_with(model, values, campaign, |_| noise, random)
}

/// The same with a noise for each reading.
///
/// # Errors
/// As [`simulate`].
pub fn measure_with(
    model: &Model,
    values: &[f64],
    mut campaign: Campaign,
    noise: impl Fn(&Reading) -> Noise,
    random: &mut ChaCha8Rng,
) -> Result<Campaign, PredictionError> {
    let reads_moves = model.effects.iter().any(|on| on.entry.effect.reads().contains(&Condition::LastMove));
    if reads_moves && campaign.conditions.last_move.is_empty() {
        campaign.number_in_order();
    }
    if campaign.conditions.session_time.is_none() {
        campaign.count_session_time();
    }
    // Motors hold the robot that stands there, not the described one.
    let mut campaign = with_holding_loads(model, &campaign, values)?.into_owned();
    let found = Predictor::new(model, &campaign, Vec::new())?.linearised(values)?;
    for (reading, value) in campaign.readings.iter_mut().zip(found.predicted) {
        reading.measured = value;
        let noise = noise(reading).at(&*reading.observes, &value);
        reading.observes.disturb(&mut reading.measured, &noise, &mut || StandardNormal.sample(random));
    }
    Ok(campaign)
}

/// Time (s) from one configuration to the next.
const PACE: f64 = 80.0;

/// Sides of approach at random, time by configuration, a temperature (degC) that settles from 20 towards 35.
pub fn conditions(model: &Model, campaign: &mut Campaign, random: &mut ChaCha8Rng) {
    let poses = campaign.poses.len();
    let by_pose = |campaign: &Campaign, values: &[f64]| campaign.readings.iter().map(|r| values[r.pose]).collect();
    let times: Vec<f64> = (0..poses).map(|pose| PACE * (pose + 1) as f64).collect();
    let last = PACE * poses as f64;
    let warm: Vec<f64> = times.iter().map(|time| 35.0 - 15.0 * (-3.0 * time / last).exp()).collect();
    campaign.conditions.time = Some(by_pose(campaign, &times));
    campaign.conditions.temperature = Some(by_pose(campaign, &warm));
    for variable in 0..model.variables.len() {
        let sides: Vec<f64> = (0..poses).map(|_| if random.random::<bool>() { 1.0 } else { -1.0 }).collect();
        let sides = by_pose(campaign, &sides);
        campaign.conditions.set_sides(variable, sides);
    }
}
