//! Draws a machine, causes whose gap after calibration has a given size, and two campaigns of it.

use nalgebra::{DVector, Vector3};
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::causes::{known, unknown};
use super::ground::{Ground, each_shows};
use super::plant::Plant;
use super::score::{Truth, TruthCause};
use super::shapes::Shape;
use crate::description::campaign::{Campaign, Conditions, Reading};
use crate::effects::Nonlinear;
use crate::kinematics::Geometry;
use crate::model::Model;
use crate::observation::{DEFLECTION, POSITION};
use crate::prediction::PredictionError;
use crate::simulation::{draw_configurations, draw_errors};

/// What a sealed campaign hides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// One effect.
    Single,
    /// Two.
    Pair,
    /// Three.
    Triple,
    /// None.
    Null,
    /// What no catalogue knows.
    Unknown,
}

impl Kind {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Single => "single",
            Self::Pair => "pair",
            Self::Triple => "triple",
            Self::Null => "null",
            Self::Unknown => "unknown",
        }
    }
}

/// A sealed campaign, its hold-out and its truth.
#[derive(Debug, Clone)]
pub struct Drawn {
    /// What is diagnosed.
    pub campaign: Campaign,
    /// The same machine at other configurations.
    pub fresh: Campaign,
    /// What is behind it.
    pub truth: Truth,
}

/// Least and greatest gap after calibration, over the noise.
const GAPS: [f64; 2] = [1.2, 6.0];

/// Draws a campaign of a kind. `deflection`: of deflections under three loads, else absolute positions.
///
/// # Errors
/// A configuration that cannot be assembled.
pub fn draw(
    model: &Model,
    robot: &str,
    name: &str,
    kind: Kind,
    deflection: bool,
    poses: usize,
    random: &mut ChaCha8Rng,
) -> Result<Drawn, PredictionError> {
    let sigma = 3e-5 + 1e-5 * random.random::<f64>();
    // What the campaign does not calibrate is as described, so that a null is one.
    let (geometry, elastic) = if deflection { (0.0, 1.0) } else { (1.0, 0.0) };
    let mut values = draw_errors(model, geometry, elastic, random);
    if let Some(effect) = model.catalogue.get("joint-compliance") {
        let calibrated: Vec<usize> =
            effect.sites(model).iter().flat_map(|site| effect.constants(model, site, &Nonlinear::default())).collect();
        for slot in model.elastic_slots().into_iter().filter(|slot| !calibrated.contains(slot)) {
            values[slot] = model.registry[slot].nominal;
        }
    }
    if !deflection {
        for (k, size) in [0.5, 0.5, 0.5, 0.3, 0.3, 0.3].into_iter().enumerate() {
            values[model.base + k] += size * (2.0 * random.random::<f64>() - 1.0);
        }
        for slot in model.markers.iter().flat_map(|marker| marker.slot..marker.slot + 3) {
            let draw: f64 = StandardNormal.sample(random);
            values[slot] += 2e-3 * draw;
        }
    }
    let wrenches: Vec<[f64; 6]> = (0..3)
        .map(|k| {
            let size = 800.0 + 1800.0 * random.random::<f64>();
            let along = Vector3::from_fn(|_, _| -> f64 { StandardNormal.sample(random) });
            let along = (along.normalize() - Vector3::z() * if k == 0 { 2.0 } else { 0.6 }).normalize() * size;
            [along.x.round(), along.y.round(), along.z.round(), 0.0, 0.0, 0.0]
        })
        .collect();
    let mut campaign = plan(model, &values, deflection, poses, &wrenches, sigma, 0.0, random)?;
    let fresh = plan(model, &values, deflection, poses, &wrenches, sigma, 0.5, random)?;
    campaign.name = name.into();
    let ground = Ground::new(model, &values, &campaign)?;
    let wanted = match kind {
        Kind::Null => 0,
        Kind::Single | Kind::Unknown => 1,
        Kind::Pair => 2,
        Kind::Triple => 3,
    };
    let mut plant = Plant { model, values, causes: Vec::new() };
    let (weight, load) = (plant.own_loads(&campaign)?, plant.all_loads(&campaign)?);
    let mut beside: Vec<DVector<f64>> = Vec::new();
    let mut told: Vec<TruthCause> = Vec::new();
    for _ in 0..400 {
        if told.len() == wanted {
            break;
        }
        let drawn =
            if kind == Kind::Unknown { unknown(model, deflection, random) } else { known(model, deflection, random) };
        let Some((effect, site, shape)) = drawn else { continue };
        if told.iter().any(|known| known.effect == effect || known.site == site) {
            continue;
        }
        let spread = (GAPS[1] / GAPS[0]).ln();
        let gap = GAPS[0] * (spread * random.random::<f64>()).exp() * if wanted > 1 { 1.2 } else { 1.0 };
        let unseen = sigma * 3.0_f64.sqrt() * (gap.min(GAPS[1]).powi(2) - 1.0).sqrt();
        // Nobody balances a joint that own weight hardly loads.
        if let Shape::Spring { variable, .. } = shape
            && weight[variable] < 0.25 * weight.iter().copied().fold(0.0, f64::max)
        {
            continue;
        }
        // A joint that nothing loads shows no spring, however soft.
        if let Shape::WindUp { variable, .. } | Shape::Gives { variable, .. } | Shape::Pressed { variable, .. } = shape
            && load[variable] < 0.02 * load.iter().copied().fold(0.0, f64::max)
        {
            continue;
        }
        let Some((size, own)) = ground.size(&plant, &campaign, &shape, sigma, unseen)? else { continue };
        let together: Vec<DVector<f64>> = beside.iter().cloned().chain([own]).collect();
        if !each_shows(&together) {
            continue;
        }
        beside = together;
        let size = if matches!(shape, Shape::Gain | Shape::Scale | Shape::Growth(_)) && random.random() {
            -size
        } else {
            size
        };
        told.push(TruthCause { effect: effect.into(), site, size, gap, shape: format!("{shape:?}") });
        plant.causes.push((shape, size));
    }
    let mut outliers = Vec::new();
    if kind == Kind::Null && random.random::<f64>() < 0.4 || kind == Kind::Single && random.random::<f64>() < 0.06 {
        let count = random.random_range(1..5);
        let mut order: Vec<usize> = (0..campaign.readings.len()).collect();
        order.shuffle(random);
        for &reading in &order[..count] {
            let along = Vector3::from_fn(|_, _| -> f64 { StandardNormal.sample(random) }).normalize();
            outliers.push((reading, along * (15.0 + 60.0 * random.random::<f64>())));
        }
        outliers.sort_by_key(|o| o.0);
    }
    let mut machine = plant.clone();
    machine.causes.push((Shape::Wrong(outliers.clone()), 1.0));
    let clean = plant.readings(&campaign, sigma)?;
    let total = ground.left(&clean, &campaign);
    let rows = outliers.iter().map(|(reading, _)| reading + 1).collect();
    let seen = machine.readings(&campaign, sigma)?;
    measure(&mut campaign, &seen, sigma, random);
    let mut held = fresh;
    let seen = plant.readings(&held, sigma)?;
    measure(&mut held, &seen, sigma, random);
    held.name = format!("{name}, afresh");
    let unit = sigma * 3.0_f64.sqrt();
    let truth = Truth {
        name: name.into(),
        kind: kind.name().into(),
        robot: robot.into(),
        observes: if deflection { "deflection" } else { "position" }.into(),
        noise: sigma,
        gap: (1.0 + (total / unit).powi(2)).sqrt(),
        causes: told,
        outliers: rows,
    };
    Ok(Drawn { campaign, fresh: held, truth })
}

/// A campaign with nothing measured yet.
#[allow(clippy::too_many_arguments)] // all that is drawn
fn plan(
    model: &Model,
    values: &[f64],
    deflection: bool,
    poses: usize,
    wrenches: &[[f64; 6]],
    sigma: f64,
    late: f64,
    random: &mut ChaCha8Rng,
) -> Result<Campaign, PredictionError> {
    let geometry = Geometry::new(model, values)?;
    let configurations = draw_configurations(&geometry, poses, 0.8, random)?;
    let mut campaign = Campaign {
        name: String::new(),
        observes: if deflection { DEFLECTION } else { POSITION },
        sigma: Some([sigma; 3]),
        sigma_orientation: None,
        estimate_base: !deflection,
        estimate_tool: !deflection,
        calibrate: if deflection {
            vec!["joint-compliance".into()]
        } else {
            vec!["geometry".into(), "joint-offset".into()]
        },
        without: Vec::new(),
        anchors: model.anchors.clone(),
        poses: (1..=configurations.len()).map(|k| format!("p{k:03}")).collect(),
        variables: model.variables.len(),
        joints: Vec::new(),
        readings: Vec::new(),
        conditions: Conditions::default(),
    };
    let none = [[0.0; 6]];
    let mut conditions = Conditions { approach: vec![None; model.variables.len()], ..Conditions::default() };
    for (pose, q) in configurations.iter().enumerate() {
        let time = (300.0 * (pose as f64 + late)).round();
        let share = time / (300.0 * poses as f64);
        let warm = 20.0 + 9.0 * (1.0 - (-3.0 * share).exp()) + 2.0 * (9.0 * share).sin();
        let sides: Vec<f64> = model.variables.iter().map(|_| if random.random() { 1.0 } else { -1.0 }).collect();
        for marker in 0..model.markers.len() {
            for &wrench in if deflection { wrenches } else { &none[..] } {
                let row = campaign.readings.len() + 1;
                let marker = Some(marker);
                let check = Some(false);
                campaign.readings.push(Reading { row, pose, marker, measured: [0.0; 6], anchor: 0, wrench, check });
                campaign.joints.extend_from_slice(q);
                if !deflection {
                    conditions.time.get_or_insert_default().push(time);
                    conditions.temperature.get_or_insert_default().push((warm * 100.0).round() / 100.0);
                    for (column, side) in conditions.approach.iter_mut().zip(&sides) {
                        column.get_or_insert_default().push(*side);
                    }
                }
            }
        }
    }
    campaign.conditions = conditions;
    Ok(campaign)
}

fn measure(campaign: &mut Campaign, seen: &[[f64; 3]], sigma: f64, random: &mut ChaCha8Rng) {
    for (reading, seen) in campaign.readings.iter_mut().zip(seen) {
        for (measured, seen) in reading.measured.iter_mut().zip(seen) {
            let noise: f64 = StandardNormal.sample(random);
            *measured = seen + sigma * noise;
        }
    }
}
