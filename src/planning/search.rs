//! The search as a whole, and what it buys.

use nalgebra::DMatrix;
use rand::seq::SliceRandom;
use rayon::prelude::*;

use super::criterion::{Target, join};
use super::error::PlanningError;
use super::exchange::{Candidate, Design};
use super::information::Information;
use super::place::{Rules, Station};
use super::refine::refine;
use super::request::Request;
use super::result::{Bought, Planned, SETS};
use crate::description::campaign::Campaign;
use crate::kinematics::{Geometry, Placements};
use crate::math::median;
use crate::model::Model;
use crate::simulation::{Loaded, draw_in_box, generator};

/// Configurations drawn to choose from.
const DRAWN: usize = 300;
/// Random sets from which the exchange starts beside the greedy one.
const STARTS: u64 = 8;
/// Most rounds of moving the joints and exchanging again.
const ROUNDS: u32 = 8;
/// Test poses drawn where none are given.
const TESTS: usize = 100;

/// Plans measurements. `progress` hears the share that is done.
///
/// # Errors
/// [`PlanningError`].
pub fn plan(model: &Model, request: &Request, progress: &mut dyn FnMut(f64)) -> Result<Planned, PlanningError> {
    let geometry = Geometry::nominal(model)?;
    let loads = if request.loads.is_empty() { vec![[0.0; 6]] } else { request.loads.clone() };
    let rules = Rules::new(request, &geometry);
    let stations = draw(&rules, &loads)?;
    let candidates = stations.len() / loads.len();
    let tests = tests(&rules, &loads)?;
    let information = Information::new(model, request, &stations)?;
    let weight = information.tests(&request.markers, &tests)?;
    let errors = Target::Trace(weight.clone());
    let target = information.target(request.criterion, &weight);
    let blocks = information.blocks(&stations)?;
    let pool: Vec<Candidate> =
        stations.into_iter().zip(blocks).map(|(station, block)| Candidate { station, block }).collect();

    let before = match &request.measured {
        Some(measured) => already(&rules, measured)?,
        None => Vec::new(),
    };
    let empty = Design { known: information.known.clone(), chosen: Vec::new(), before, apart: request.apart };

    let least = least(&empty, &pool);
    let parameters = information.identifiability.kept.len();
    let count = request.count;
    let least = match least {
        Some(least) if count >= least => least,
        Some(least) => return Err(PlanningError::TooFew { count, parameters, least }),
        None => {
            // Either the distance leaves too little room, or the candidates all together tell too little.
            if request.apart > 0.0 {
                let mut room = empty.clone();
                room.grow(&Target::Determinant, &pool, count);
                if room.chosen.len() < count {
                    return Err(PlanningError::TooNear { found: room.chosen.len(), count, apart: request.apart });
                }
            }
            let least = parameters.div_ceil(pool.iter().map(|c| c.block.ncols()).max().unwrap_or(1));
            return Err(PlanningError::TooFew { count, parameters, least: least.max(pool.len() + 1) });
        }
    };
    let others = counts(count, least, pool.len());
    let steps = (others.len() + 6) as f64;
    let mut bought = Vec::new();
    for (k, &other) in others.iter().enumerate() {
        let (design, _) = chosen(&empty, &pool, &target, other, 0, request.seed);
        let planned = errors.loss(&design.information()).exp();
        bought.push(Bought { count: other, planned, random: random(&empty, &pool, &errors, other, request.seed) });
        progress((k + 1) as f64 / steps);
    }
    let (mut design, mut loss) = chosen(&empty, &pool, &target, count, STARTS, request.seed);
    if design.chosen.len() < count {
        return Err(PlanningError::TooNear { found: design.chosen.len(), count, apart: request.apart });
    }
    let mut within = |part: f64| progress(((others.len() as f64 + part) / steps).min(1.0));
    within(1.0);
    let mut drawn = generator(request.seed ^ 0x5EED);
    for round in 0..ROUNDS {
        let refined = refine(&rules, &information, &target, &mut design, &mut drawn);
        within(2.0 + 4.0 * f64::from(round + 1) / f64::from(ROUNDS));
        let gained = loss - refined;
        loss = design.exchange(&target, &pool);
        if gained < 1e-3 {
            break;
        }
    }
    in_order(&mut design);
    let m = design.information();
    if !Information::is_whole(&m) {
        return Err(PlanningError::TooFew { count, parameters, least: count + 1 });
    }
    let error = errors.loss(&m).exp();
    let before = Information::is_whole(&empty.known).then(|| errors.loss(&empty.known).exp());
    let random_here = random(&empty, &pool, &errors, count, request.seed);
    bought.push(Bought { count, planned: error, random: random_here });
    bought.sort_by_key(|bought| bought.count);
    let chosen: Vec<Station> = design.chosen.into_iter().map(|chosen| chosen.station).collect();
    let campaign = information.campaign(&chosen);
    Ok(Planned {
        identifiability: information.reduced(request, &campaign)?,
        slots: information.slots.clone(),
        deviations: information.kept().zip(information.deviations(&m)).collect(),
        campaign,
        stations: chosen,
        before,
        error,
        bought,
        random_equal: random_equal(&empty, &pool, &errors, count, error, request.seed),
        least,
        candidates,
    })
}

/// Candidates: every configuration drawn under every load.
fn draw(rules: &Rules, loads: &[[f64; 6]]) -> Result<Vec<Station>, PlanningError> {
    let (request, geometry) = (rules.request, rules.geometry);
    let wanted = DRAWN.max(3 * request.count);
    let accepted = |q: &[f64], placements: &Placements| rules.seen(q, placements).is_some();
    let (drawn, error) = draw_in_box(geometry, &request.within, wanted, &mut generator(request.seed), accepted);
    if drawn.len() < request.count.max(1) {
        return match error {
            Some(error) if drawn.is_empty() && request.sight.is_none() && request.workspace.is_none() => {
                Err(error.into())
            }
            _ => Err(PlanningError::NoRoom { found: drawn.len(), tried: 1000 * wanted }),
        };
    }
    let mut placements = Placements::default();
    let all = drawn.iter().flat_map(|q| loads.iter().map(move |load| (q, *load)));
    Ok(all.filter_map(|(q, load)| rules.station(&mut placements, q, load)).collect())
}

/// Test poses as given, or drawn in the box under loads in turns.
fn tests(rules: &Rules, loads: &[[f64; 6]]) -> Result<Vec<Loaded>, PlanningError> {
    let (request, geometry) = (rules.request, rules.geometry);
    let mut placements = Placements::default();
    if !request.tests.is_empty() {
        for (row, (q, _)) in request.tests.iter().enumerate() {
            geometry.place(q, &mut placements).map_err(|source| PlanningError::Test { row: row + 1, source })?;
        }
        return Ok(request.tests.clone());
    }
    // Another stream than the candidates': the plan must not be tested where it may measure.
    let accepted = |q: &[f64], placements: &Placements| rules.seen_from_anywhere(q, placements);
    let (drawn, _) = draw_in_box(geometry, &request.tested_within, TESTS, &mut generator(!request.seed), accepted);
    if drawn.is_empty() {
        return Err(PlanningError::NoTest { tried: 1000 * TESTS });
    }
    Ok(drawn.into_iter().enumerate().map(|(k, q)| (q, loads[k % loads.len()])).collect())
}

/// Where readings have been made.
fn already(rules: &Rules, measured: &Campaign) -> Result<Vec<Station>, PlanningError> {
    let mut placements = Placements::default();
    let mut stations: Vec<Station> = Vec::new();
    for (index, reading) in measured.readings.iter().enumerate() {
        let q = measured.configuration(index).to_vec();
        rules.geometry.place(&q, &mut placements)?;
        let station = Station { q, load: reading.wrench, markers: Vec::new(), at: rules.tool(&placements) };
        if !stations.contains(&station) {
            stations.push(station);
        }
    }
    Ok(stations)
}

/// Fewest stations that tell the parameters apart: chosen for that alone.
fn least(empty: &Design, pool: &[Candidate]) -> Option<usize> {
    let mut design = empty.clone();
    let mut m = design.known.clone();
    loop {
        if Information::is_whole(&m) {
            return Some(design.chosen.len().max(1));
        }
        let (k, _) = design.best(&Target::Determinant, &m, pool, usize::MAX)?;
        join(&mut m, &pool[k].block);
        design.chosen.push(pool[k].clone());
    }
}

/// Numbers of configurations to compare with.
fn counts(count: usize, least: usize, most: usize) -> Vec<usize> {
    let parts = [0.5, 0.75, 1.5, 2.0];
    let mut all: Vec<usize> = parts.iter().map(|part| (part * count as f64).round() as usize).collect();
    all.push(least);
    all.retain(|other| (least..=most).contains(other) && *other != count);
    all.sort_unstable();
    all.dedup();
    all
}

/// The best stations found by exchange from a greedy start and from random ones, and their loss.
fn chosen(empty: &Design, pool: &[Candidate], target: &Target, count: usize, starts: u64, seed: u64) -> (Design, f64) {
    let mut best = empty.clone();
    best.grow(target, pool, count);
    let mut least = best.exchange(target, pool);
    for start in 0..starts {
        let mut design = empty.clone();
        let mut order: Vec<usize> = (0..pool.len()).collect();
        order.shuffle(&mut generator(seed.wrapping_add(1 + start)));
        for k in order {
            if design.chosen.len() < count && design.admits(&pool[k].station, usize::MAX) {
                design.chosen.push(pool[k].clone());
            }
        }
        let loss = design.exchange(target, pool);
        if design.chosen.len() >= best.chosen.len() && loss < least {
            (best, least) = (design, loss);
        }
    }
    (best, least)
}

/// Error at the test poses with random stations: median of [`SETS`] sets.
fn random(empty: &Design, pool: &[Candidate], errors: &Target, count: usize, seed: u64) -> f64 {
    let one = |set: u64| {
        let mut order: Vec<usize> = (0..pool.len()).collect();
        order.shuffle(&mut generator(seed.wrapping_add(1 + set)));
        let mut m: DMatrix<f64> = empty.known.clone();
        for &k in order.iter().take(count) {
            join(&mut m, &pool[k].block);
        }
        errors.loss(&m).exp()
    };
    let mut found: Vec<f64> = (0..SETS).into_par_iter().map(one).collect();
    median(&mut found)
}

/// Fewest random stations that do as well as `error`, by bisection.
fn random_equal(
    empty: &Design,
    pool: &[Candidate],
    errors: &Target,
    count: usize,
    error: f64,
    seed: u64,
) -> Option<usize> {
    let (mut few, mut enough) = (count, pool.len());
    if random(empty, pool, errors, enough, seed) > error {
        return None;
    }
    if random(empty, pool, errors, few, seed) <= error {
        return Some(few);
    }
    while enough - few > 1 {
        let middle = usize::midpoint(few, enough);
        if random(empty, pool, errors, middle, seed) <= error {
            enough = middle;
        } else {
            few = middle;
        }
    }
    Some(enough)
}

/// Neighbours in the first joints follow each other, so that the robot (and the reflector) moves little.
fn in_order(design: &mut Design) {
    let mut left = std::mem::take(&mut design.chosen);
    left.sort_by(|a, b| a.station.q.partial_cmp(&b.station.q).unwrap_or(std::cmp::Ordering::Equal));
    if left.is_empty() {
        return;
    }
    let mut ordered = vec![left.remove(0)];
    while let Some(last) = ordered.last().filter(|_| !left.is_empty()) {
        let away = |candidate: &Candidate| {
            let by = candidate.station.q.iter().zip(&last.station.q).map(|(a, b)| (a - b).abs());
            by.fold(0.0, f64::max)
        };
        let next = (0..left.len()).min_by(|&a, &b| away(&left[a]).total_cmp(&away(&left[b]))).unwrap_or(0);
        ordered.push(left.remove(next));
    }
    design.chosen = ordered;
}
