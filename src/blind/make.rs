//! Draws a machine, causes whose gap after calibration has a given size, and two campaigns of it.

use indexmap::IndexMap;
use nalgebra::{DMatrix, DVector, Vector3};
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::plant::{Plant, joint_of, lengths_of};
use super::score::{Truth, TruthCause};
use super::shapes::Shape;
use crate::description::campaign::{Campaign, Observes, Reading};
use crate::diagnosis::nuisance;
use crate::effects::Form;
use crate::kinematics::Geometry;
use crate::model::Model;
use crate::parameter;
use crate::prediction::{Linearised, PredictionError, Predictor};
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
/// A cause that must displace readings further than this (m) to leave such a gap is drawn again.
const FURTHEST: f64 = 0.012;

/// No mass is further off than this, kg.
const HEAVIEST: f64 = 300.0;
/// No joint, bearing or base is softer than this, rad/(N.m).
const SOFTEST: f64 = 1e-4;
/// What each of several causes must show beside the others, as a share of what it leaves.
const OWN: f64 = 0.4;

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
    if let Some(effect) = crate::effects::by_name("joint-compliance") {
        let calibrated: Vec<usize> =
            effect.sites(model).iter().flat_map(|site| effect.constants(model, site, &Form::ONLY)).collect();
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
        observes: if deflection { Observes::Deflection } else { Observes::Position },
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
        conditions: IndexMap::new(),
    };
    let none = [[0.0; 6]];
    let mut conditions: IndexMap<String, Vec<f64>> = IndexMap::new();
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
                    conditions.entry("time".into()).or_default().push(time);
                    conditions.entry("temperature".into()).or_default().push((warm * 100.0).round() / 100.0);
                    for (variable, side) in model.variables.iter().zip(&sides) {
                        conditions.entry(format!("approach.{}", variable.name)).or_default().push(*side);
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

/// What calibration of a campaign takes up, linear about the true values.
struct Ground {
    basis: DMatrix<f64>,
    still: Vec<[f64; 3]>,
}

impl Ground {
    fn new(model: &Model, values: &[f64], campaign: &Campaign) -> Result<Self, PredictionError> {
        let mut slots = nuisance(model, campaign, &campaign.calibrate);
        if campaign.estimate_base {
            slots.extend(model.base..model.base + 6);
            slots.extend(model.markers.iter().flat_map(|marker| marker.slot..marker.slot + 3));
        }
        let predictor = Predictor::new(model, campaign, slots.clone())?;
        let mut found = Linearised::default();
        predictor.linearise(values, true, &mut found)?;
        let columns = slots.len();
        let mut matrix = DMatrix::from_row_slice(predictor.rows(), columns, &found.jacobian);
        for mut column in matrix.column_iter_mut() {
            let norm = column.norm();
            if norm > 0.0 {
                column /= norm;
            }
        }
        let split = matrix.svd(true, false);
        let most = split.singular_values.max();
        let kept: Vec<usize> =
            (0..split.singular_values.len()).filter(|&k| split.singular_values[k] > 1e-6 * most).collect();
        let basis = split.u.map_or_else(|| DMatrix::zeros(predictor.rows(), 0), |u| u.select_columns(&kept));
        let still = Plant { model, values: values.to_vec(), causes: Vec::new() }.readings(campaign, 0.0)?;
        Ok(Self { basis, still })
    }

    /// What calibration leaves of readings that differ from the machine's without causes, m.
    fn rest(&self, seen: &[[f64; 3]]) -> DVector<f64> {
        let moved = self.moved(seen);
        &moved - &self.basis * self.basis.tr_mul(&moved)
    }

    /// Its root mean square over the readings, m.
    fn left(&self, seen: &[[f64; 3]], campaign: &Campaign) -> f64 {
        let left = self.rest(seen);
        let freedom = (left.len() - self.basis.ncols()) as f64 / left.len() as f64;
        (left.norm_squared() / (campaign.readings.len() as f64 * freedom)).sqrt()
    }

    fn moved(&self, seen: &[[f64; 3]]) -> DVector<f64> {
        let moved = seen.iter().zip(&self.still).flat_map(|(a, b)| (0..3).map(move |k| a[k] - b[k]));
        DVector::from_iterator(3 * seen.len(), moved)
    }

    /// Size at which a shape alone leaves `unseen`, and what it leaves; none if it would have to be too great.
    fn size(
        &self,
        plant: &Plant,
        campaign: &Campaign,
        shape: &Shape,
        sigma: f64,
        unseen: f64,
    ) -> Result<Option<(f64, DVector<f64>)>, PredictionError> {
        let mut size = 1e-9;
        let mut alone = Plant { causes: Vec::new(), ..plant.clone() };
        for round in 0..8 {
            alone.causes = vec![(shape.clone(), size)];
            // A great change of a constant may leave a linkage that cannot be assembled.
            let Ok(seen) = alone.readings(campaign, sigma) else { return Ok(None) };
            let left = self.left(&seen, campaign);
            let moved = self.moved(&seen).norm() / (campaign.readings.len() as f64).sqrt();
            let factor = unseen / left;
            if !factor.is_finite() || moved * factor > FURTHEST {
                return Ok(None);
            }
            if round > 0 && (factor - 1.0).abs() < 0.02 {
                // What hardly grows with its size any more is no machine: a spring so soft that the loop carries all.
                alone.causes = vec![(shape.clone(), 0.5 * size)];
                let Ok(half) = alone.readings(campaign, sigma) else { return Ok(None) };
                let grows = (0.3..0.7).contains(&(self.left(&half, campaign) / unseen));
                return Ok(grows.then(|| (size, self.rest(&seen))));
            }
            size *= factor;
            let heavy = |slot: usize, share: f64| match plant.model.registry[slot].kind {
                parameter::Kind::Mass => size * share > HEAVIEST,
                parameter::Kind::RotationalCompliance => size * share > SOFTEST,
                _ => false,
            };
            if let Shape::Constants(slots) = shape
                && slots
                    .iter()
                    .any(|&(slot, share)| plant.values[slot] + size * share < 0.0 && share < 0.0 || heavy(slot, share))
            {
                return Ok(None);
            }
        }
        // A cause that cannot leave as much, however great it is.
        Ok(None)
    }
}

/// Whether each of several causes leaves something of its own beside the others: two that do the same cannot be told.
fn each_shows(causes: &[DVector<f64>]) -> bool {
    (0..causes.len()).all(|k| {
        let others: Vec<DVector<f64>> = (0..causes.len()).filter(|i| *i != k).map(|i| causes[i].clone()).collect();
        if others.is_empty() {
            return true;
        }
        let basis = DMatrix::from_columns(&others).qr().q();
        let own = &causes[k] - &basis * basis.tr_mul(&causes[k]);
        own.norm() > OWN * causes[k].norm()
    })
}

type Named = Option<(&'static str, String, Shape)>;

/// An effect of the catalogue at a site, in a shape of its own.
fn known(model: &Model, deflection: bool, random: &mut ChaCha8Rng) -> Named {
    let count = model.variables.len();
    let variable = random.random_range(0..count);
    let joint = joint_of(model, variable);
    let at_joint = format!("joint:{}", model.frames[joint].name);
    let frame = random.random_range(1..model.frames.len());
    let at_link = format!("link:{}", model.frames[frame].name);
    let is_serial = model.actuators.is_empty();
    let mut within = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
    let slot = |name: String| model.registry.slot(&name);
    let constants = |names: Vec<(String, f64)>| -> Option<Shape> {
        let slots: Vec<_> = names.into_iter().filter_map(|(name, share)| Some((slot(name)?, share))).collect();
        (!slots.is_empty()).then_some(Shape::Constants(slots))
    };
    let name = &model.frames[frame].name;
    let turn = std::f64::consts::TAU;
    let of_load = |draw: usize, within: &mut dyn FnMut(f64, f64) -> f64| -> Named {
        Some(match draw {
            0 => ("joint-stiffening", at_joint.clone(), Shape::WindUp { variable, soft: within(0.06, 0.5) }),
            1 if is_serial => {
                ("bearing-compliance", at_joint.clone(), Shape::Tilt { frame: joint, unequal: within(-0.25, 0.25) })
            }
            1 => {
                let joint = &model.frames[joint].name;
                ("bearing-compliance", at_joint.clone(), constants(vec![(format!("joint{joint}.krr"), 1.0)])?)
            }
            2 => {
                let shares = [within(0.6, 1.4), within(0.6, 1.4)];
                ("base-compliance", "base".into(), Shape::Rocking { shares, more: within(-0.2, 0.3) })
            }
            3 => {
                let bending = [within(0.5, 1.5), within(0.5, 1.5), within(0.0, 1.0)];
                let names = ["bending_y", "bending_z", "torsion"].iter().zip(bending);
                let names = names.map(|(symbol, share)| (format!("link{name}.{symbol}"), share)).collect();
                ("link-compliance", at_link.clone(), constants(names)?)
            }
            _ => ("backlash", at_joint.clone(), Shape::Pressed { variable, soft: within(0.01, 0.03) }),
        })
    };
    if deflection {
        return match within(0.0, 9.0) as usize {
            draw @ 0..=4 => of_load(draw, &mut within),
            5 | 6 if is_serial => {
                let variable = usize::from(within(0.0, 3.0) > 1.0);
                let variable = variable + usize::from(variable == 1 && within(0.0, 3.0) > 2.0);
                let at = format!("joint:{}", model.frames[joint_of(model, variable)].name);
                let (a, b) = (within(0.3, 0.9), within(0.1, 0.3));
                let (angle, free) = (within(0.0, turn), within(0.5, 0.9) * (a - b));
                let compliance = slot(format!("joint{}.kar", model.frames[joint_of(model, variable)].name))
                    .map_or(1e-6, |slot| model.registry[slot].nominal.max(1e-8));
                Some((
                    "gravity-compensator",
                    at,
                    Shape::Spring { variable, compliance, a, b, angle, free, rate: 1e-3 / compliance },
                ))
            }
            5 | 6 => {
                let actuator = model.actuators.get(usize::from(within(0.0, 1.0) > 0.5))?;
                let shape = constants(vec![(format!("{}.axial", actuator.name), 1.0)])?;
                Some(("actuator-compliance", format!("actuator:{}", actuator.name), shape))
            }
            7 => Some(("payload", "tool".into(), Shape::Gain)),
            _ => Some(("instrument-scale", "instrument".into(), Shape::Scale)),
        };
    }
    match within(0.0, 16.0) as usize {
        draw @ 0..=3 => of_load(draw, &mut within),
        4 | 5 => {
            let orders = [1.0, 2.0, 2.0, 3.0, 4.0, 5.0, 7.0];
            let order = orders[(within(0.0, 7.0) as usize).min(6)];
            let second = [within(0.05, 0.3), within(0.0, turn)];
            Some(("transmission-error", at_joint, Shape::Swing { variable, order, phase: within(0.0, turn), second }))
        }
        6 | 7 => Some(("backlash", at_joint, Shape::Play { variable, by_load: within(-0.3, 0.3) })),
        8 => Some(("gear-ratio", at_joint, Shape::Ratio { variable, zero: within(-1.0, 1.0) })),
        9 => {
            let other = (variable + 1 + within(0.0, (count - 1) as f64) as usize) % count;
            (other != variable).then_some(("joint-coupling", at_joint, Shape::Follows { variable, other }))
        }
        10 => Some(("joint-compliance", at_joint, Shape::Gives { variable, less: within(0.0, 0.2) })),
        11 => {
            let names = [("mass", 1.0), ("x", within(-5e-3, 5e-3)), ("y", within(-5e-3, 5e-3))];
            let names = names.map(|(symbol, share)| (format!("body{name}.{symbol}"), share)).to_vec();
            (frame != model.tool.0).then_some(())?;
            Some(("link-weight", at_link, constants(names)?))
        }
        12 => {
            let tool = &model.frames[model.tool.0].name;
            let names = [("mass", 1.0), ("z", within(0.0, 3e-3))];
            let names = names.map(|(symbol, share)| (format!("body{tool}.{symbol}"), share)).to_vec();
            Some(("payload", "tool".into(), constants(names)?))
        }
        13 => {
            let lengths = lengths_of(model, frame);
            (!lengths.is_empty()).then_some(("thermal-expansion", at_link, Shape::Growth(lengths)))
        }
        14 => {
            let jump = within(0.0, 1.0) > 0.5;
            let mut normal = |size: f64| size * (within(0.0, 1.0) + within(0.0, 1.0) + within(0.0, 1.0) - 1.5);
            let mut knot = || [1.0, 1.0, 1.0, 0.4, 0.4, 0.4].map(&mut normal);
            let knots = if jump {
                vec![[0.0; 6], knot()]
            } else {
                // A walk that keeps on in the main, with turns.
                let (trend, mut at) = (knot(), [0.0; 6]);
                (0..5)
                    .map(|_| {
                        let step = knot();
                        let before = at;
                        (0..6).for_each(|k| at[k] += trend[k] + 0.5 * step[k]);
                        before
                    })
                    .collect()
            };
            Some(("frame-drift", "base".into(), Shape::Wanders { knots, jump }))
        }
        _ => Some(("instrument-scale", "instrument".into(), Shape::Scale)),
    }
}

/// Something that the catalogue does not know.
fn unknown(model: &Model, deflection: bool, random: &mut ChaCha8Rng) -> Named {
    let count = model.variables.len();
    let variable = random.random_range(0..count);
    let none = String::new;
    let draw = random.random_range(0..4);
    let mut within = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
    match draw {
        0 => {
            let a = within(0.0, count as f64) as usize % count;
            let b = (a + 1 + within(0.0, count as f64 - 1.0) as usize) % count;
            Some(("product of two joints", none(), Shape::Product { variable, of: [a, b], yields: deflection }))
        }
        1 => Some(("hoses", none(), Shape::Hoses { variable, of: [0, 3.min(count - 1)], yields: deflection })),
        2 => {
            let waves = (0..12)
                .map(|_| {
                    let w = (0..count).map(|_| within(-1.5, 1.5)).collect();
                    let along = Vector3::new(within(-1.0, 1.0), within(-1.0, 1.0), within(-1.0, 1.0));
                    (w, within(0.0, 6.3), along)
                })
                .collect();
            Some(("smooth function", none(), Shape::Smooth { waves, by_force: deflection }))
        }
        _ => {
            let marker = within(0.0, model.markers.len() as f64) as usize % model.markers.len();
            let by = Vector3::new(within(-1.0, 1.0), within(-1.0, 1.0), within(-1.0, 1.0));
            Some(("slipped marker", none(), Shape::Slip { marker, at: within(0.25, 0.75), by }))
        }
    }
}
