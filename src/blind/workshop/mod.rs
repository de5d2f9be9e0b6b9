//! The second generator: machines of any kind as a workshop measures them. Noise of several kinds, its size stated or not;
//! the last moves known; causes that no catalogue has, also next to one that it has; outliers hardly beyond the noise; and
//! readings that are not what they are said to be.

mod causes;
mod noise;
mod traps;

use nalgebra::Vector3;
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::causes::Drawing;
use super::design::{Bench, Design, normal};
use super::make::{Drawn, OUTLIER, drawn_causes};
use super::projection::Projection;
use super::shapes::Shape;
use super::truth::{Instrument, Kind, Truth, TruthCause};
use crate::description::campaign::Campaign;
use crate::model::Model;
use crate::prediction::PredictionError;
use causes::{of_catalogue, off_catalogue};
use noise::Noise;
use traps::spoil;

/// Share of the campaigns that have outliers in addition, and the most of them.
const WITH_OUTLIERS: f64 = 0.25;
const MOST_OUTLIERS: usize = 3;
/// Displacement of a small outlier, over the noise of a coordinate.
const SMALL_OUTLIER: [f64; 2] = [5.0, 8.0];

/// Draws a sealed campaign; whether its noise is stated.
///
/// # Errors
/// A configuration that cannot be assembled.
pub fn draw(
    design: &Design,
    name: &str,
    kind: Kind,
    is_stated: bool,
    random: &mut ChaCha8Rng,
) -> Result<Drawn, PredictionError> {
    let bench = Bench::draw(*design, random);
    let (mut campaign, mut fresh) = (planned(&bench, 0.0, random)?, planned(&bench, 0.5, random)?);
    let projection = Projection::new(design.model, &bench.values, &campaign)?;
    let next = |model: &Model, known: &[TruthCause], random: &mut ChaCha8Rng| -> Drawing {
        let is_odd = kind == Kind::Unknown || kind == Kind::Mixture && known.len() == 1;
        let of = if is_odd { off_catalogue } else { of_catalogue };
        of(model, design.is_deflection, random)
    };
    let (plant, mut causes) = drawn_causes(&bench, &campaign, &projection, kind, &next, random)?;
    let shown = plant.readings(&campaign, bench.sigma)?;
    for (k, cause) in causes.iter_mut().enumerate() {
        let mut others = plant.clone();
        others.causes.remove(k);
        let without = others.readings(&campaign, bench.sigma)?;
        cause.adds = shown.iter().zip(&without).flat_map(|(a, b)| (0..3).map(move |k| a[k] - b[k])).collect();
    }
    let outliers = if kind == Kind::Trap { Vec::new() } else { outliers(campaign.readings.len(), random) };
    let mut with_outliers = plant.clone();
    with_outliers.causes.push((Shape::Outliers(outliers.clone()), 1.0));
    let noise = Noise::draw(design.is_deflection, random);
    let left = projection.rms(&shown, &campaign);
    let shown = with_outliers.readings(&campaign, bench.sigma)?;
    let sigma = measure(&mut campaign, &shown, bench.sigma, noise, random);
    let shown = plant.readings(&fresh, bench.sigma)?;
    measure(&mut fresh, &shown, bench.sigma, noise, random);
    if kind == Kind::Trap {
        let effect = spoil([&mut campaign, &mut fresh], random).into();
        let (site, shape, adds) = (String::new(), String::new(), Vec::new());
        causes.push(TruthCause { effect, site, size: 1.0, gap: 0.0, shape, adds });
    }
    for of in [&mut campaign, &mut fresh] {
        of.state_noise(is_stated.then_some([sigma; 3]), None);
    }
    campaign.name = name.into();
    fresh.name = format!("{name}, afresh");
    let truth = Truth {
        name: name.into(),
        kind,
        robot: design.robot.into(),
        observes: if design.is_deflection { "deflection" } else { "position" }.into(),
        noise: sigma,
        gap: (1.0 + left.powi(2) / (3.0 * sigma.powi(2))).sqrt(),
        causes,
        outliers: outliers.iter().map(|(reading, _)| reading + 1).collect(),
        instrument: Some(Instrument { noise: noise.name().into(), is_stated }),
    };
    Ok(Drawn { campaign, fresh, truth })
}

/// A campaign with nothing measured yet, whose configurations follow one another: each variable comes from the side on which the
/// configuration before lies, from above after a negative move.
fn planned(bench: &Bench, late: f64, random: &mut ChaCha8Rng) -> Result<Campaign, PredictionError> {
    let mut campaign = bench.planned(late, random)?;
    if campaign.is_difference() {
        return Ok(campaign);
    }
    campaign.number_in_order();
    let conditions = &mut campaign.conditions;
    for (sides, moves) in conditions.approach.iter_mut().zip(&conditions.last_move) {
        let come = |(side, moved): (&mut f64, &f64)| {
            *side = if *moved == 0.0 || moved.is_nan() { *side } else { -moved.signum() }
        };
        sides.iter_mut().flatten().zip(moves).for_each(come);
    }
    Ok(campaign)
}

/// Fills a campaign with what a machine shows, and noise; the root mean square of that, a coordinate.
fn measure(campaign: &mut Campaign, shown: &[[f64; 3]], sigma: f64, noise: Noise, random: &mut ChaCha8Rng) -> f64 {
    let errors = noise.errors(campaign, shown, random);
    for ((reading, shown), error) in campaign.readings.iter_mut().zip(shown).zip(&errors) {
        (0..3).for_each(|k| reading.measured[k] = shown[k] + sigma * error[k]);
    }
    if noise != Noise::Distant {
        return sigma;
    }
    // What a laboratory would state for the whole.
    sigma * (errors.iter().map(Vector3::norm_squared).sum::<f64>() / (3.0 * errors.len().max(1) as f64)).sqrt()
}

/// Readings that are outliers, hardly beyond the noise or far, and their displacements over it.
fn outliers(readings: usize, random: &mut ChaCha8Rng) -> Vec<(usize, Vector3<f64>)> {
    if random.random::<f64>() >= WITH_OUTLIERS {
        return Vec::new();
    }
    let mut order: Vec<usize> = (0..readings).collect();
    order.shuffle(random);
    order.truncate(random.random_range(1..=MOST_OUTLIERS));
    order.sort_unstable();
    let mut one = |reading: usize| {
        let along = Vector3::from_fn(|_, _| normal(random)).normalize();
        let [least, more] =
            if random.random() { [SMALL_OUTLIER[0], SMALL_OUTLIER[1] - SMALL_OUTLIER[0]] } else { OUTLIER };
        (reading, along * (least + more * random.random::<f64>()))
    };
    order.into_iter().map(&mut one).collect()
}
