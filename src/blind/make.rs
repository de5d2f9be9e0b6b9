//! Draws a machine, causes whose gap after calibration has a given size, and two campaigns of it.

use nalgebra::{DVector, Vector3};
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::causes::{Drawing, known, unknown};
use super::design::{Bench, Design, normal};
use super::odd::Odd;
use super::plant::Plant;
use super::projection::{Projection, each_shows};
use super::shapes::Shape;
use super::truth::{Kind, Truth, TruthCause};
use crate::description::campaign::Campaign;
use crate::model::Model;
use crate::prediction::PredictionError;

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

/// Least and greatest gap after calibration, over the noise: from hardly visible to plain.
const GAPS: [f64; 2] = [1.2, 6.0];
/// How much greater the gap of each of several causes is, which hide behind each other.
const OF_SEVERAL: f64 = 1.2;
/// Causes that are drawn before a campaign goes with fewer than it should have.
const MOST_DRAWS: usize = 400;
/// Least load of own weight on a joint that a spring balances, as a share of that on the most loaded joint.
const BALANCED: f64 = 0.25;
/// Least load on a joint whose compliance shows, as a share of that on the most loaded joint.
const LOADED: f64 = 0.02;
/// Share of nulls and of single causes that have outliers in addition.
const WITH_OUTLIERS: [f64; 2] = [0.4, 0.06];
/// Displacement of an outlier: least, and how much more at most, over the noise.
pub(super) const OUTLIER: [f64; 2] = [15.0, 60.0];

/// Draws a sealed campaign.
///
/// # Errors
/// A configuration that cannot be assembled.
pub fn draw(design: &Design, name: &str, kind: Kind, random: &mut ChaCha8Rng) -> Result<Drawn, PredictionError> {
    let bench = Bench::draw(*design, random);
    let mut campaign = bench.planned(0.0, random)?;
    let mut fresh = bench.planned(0.5, random)?;
    let projection = Projection::new(design.model, &bench.values, &campaign)?;
    let next = |model: &Model, drawn: &[TruthCause], random: &mut ChaCha8Rng| match kind {
        Kind::Unknown => unknown(model, design.is_deflection, random),
        Kind::Mixture if drawn.len() == 1 => unknown(model, design.is_deflection, random),
        _ => known(model, design.is_deflection, random),
    };
    let (plant, causes) = drawn_causes(&bench, &campaign, &projection, kind, &next, random)?;
    let outliers = drawn_outliers(kind, campaign.readings.len(), random);
    let mut with_outliers = plant.clone();
    with_outliers.causes.push((Shape::Outliers(outliers.clone()), 1.0));
    let left = projection.rms(&plant.readings(&campaign, bench.sigma)?, &campaign);
    let shown = with_outliers.readings(&campaign, bench.sigma)?;
    bench.measure(&mut campaign, &shown, random);
    let shown = plant.readings(&fresh, bench.sigma)?;
    bench.measure(&mut fresh, &shown, random);
    campaign.name = name.into();
    fresh.name = format!("{name}, afresh");
    let truth = Truth {
        name: name.into(),
        kind,
        robot: design.robot.into(),
        observes: if design.is_deflection { "deflection" } else { "position" }.into(),
        noise: bench.sigma,
        gap: (1.0 + (left / bench.noise()).powi(2)).sqrt(),
        causes,
        outliers: outliers.iter().map(|(reading, _)| reading + 1).collect(),
        instrument: None,
    };
    Ok(Drawn { campaign, fresh, truth })
}

/// Draws the next cause, given those before.
type Next<'n> = dyn Fn(&Model, &[TruthCause], &mut ChaCha8Rng) -> Drawing + 'n;

/// The machine with its causes, each as large as leaves a drawn gap and showing something that the others do not.
pub(super) fn drawn_causes<'a>(
    bench: &Bench<'a>,
    campaign: &Campaign,
    projection: &Projection,
    kind: Kind,
    next: &Next,
    random: &mut ChaCha8Rng,
) -> Result<(Plant<'a>, Vec<TruthCause>), PredictionError> {
    let Design { model, .. } = bench.design;
    let mut plant = Plant { model, values: bench.values.clone(), causes: Vec::new() };
    let (weight, load) = (plant.own_loads(campaign)?, plant.all_loads(campaign)?);
    let mut left_by_each: Vec<DVector<f64>> = Vec::new();
    let mut truth: Vec<TruthCause> = Vec::new();
    for _ in 0..MOST_DRAWS {
        if truth.len() == kind.causes() {
            break;
        }
        let Some((effect, site, shape)) = next(model, &truth, random) else { continue };
        if truth.iter().any(|known| known.effect == effect || known.site == site) {
            continue;
        }
        let several = if kind.causes() > 1 { OF_SEVERAL } else { 1.0 };
        let gap = GAPS[0] * ((GAPS[1] / GAPS[0]).ln() * random.random::<f64>()).exp() * several;
        let unseen = bench.noise() * (gap.min(GAPS[1]).powi(2) - 1.0).sqrt();
        if !can_show(&shape, &weight, &load) {
            continue;
        }
        let Some((size, left)) = projection.size(&plant, campaign, &shape, bench.sigma, unseen)? else { continue };
        let together: Vec<DVector<f64>> = left_by_each.iter().cloned().chain([left]).collect();
        if !each_shows(&together) {
            continue;
        }
        left_by_each = together;
        let has_sign = matches!(shape, Shape::Gain | Shape::Scale | Shape::Growth(_));
        let size = if has_sign && random.random() { -size } else { size };
        let (effect, shown) = (effect.into(), format!("{shape:?}"));
        truth.push(TruthCause { effect, site, size, gap, shape: shown, adds: Vec::new() });
        plant.causes.push((shape, size));
    }
    Ok((plant, truth))
}

/// Whether a joint is loaded enough for a shape, given the greatest loads by own weight and by all, by variable.
fn can_show(shape: &Shape, weight: &[f64], load: &[f64]) -> bool {
    let reaches =
        |all: &[f64], variable: usize, share: f64| all[variable] >= share * all.iter().copied().fold(0.0, f64::max);
    match *shape {
        // Builders balance the joints that carry the arm, and no others.
        Shape::Spring { variable, .. } => reaches(weight, variable, BALANCED),
        Shape::Odd(Odd::DeadZone { variable, .. } | Odd::Stop { variable, .. })
        | Shape::WindUp { variable, .. }
        | Shape::Compliant { variable, .. }
        | Shape::Pressed { variable, .. } => reaches(load, variable, LOADED),
        _ => true,
    }
}

/// Readings that are outliers, and their displacements over the noise.
fn drawn_outliers(kind: Kind, readings: usize, random: &mut ChaCha8Rng) -> Vec<(usize, Vector3<f64>)> {
    let mut outliers = Vec::new();
    let has_any = kind == Kind::Null && random.random::<f64>() < WITH_OUTLIERS[0]
        || kind == Kind::Single && random.random::<f64>() < WITH_OUTLIERS[1];
    if has_any {
        let count = random.random_range(1..5);
        let mut order: Vec<usize> = (0..readings).collect();
        order.shuffle(random);
        for &reading in &order[..count] {
            let along = Vector3::from_fn(|_, _| normal(random)).normalize();
            outliers.push((reading, along * (OUTLIER[0] + OUTLIER[1] * random.random::<f64>())));
        }
        outliers.sort_by_key(|outlier| outlier.0);
    }
    outliers
}
