//! The search: candidates drawn, exchanged (Fedorov 1972) and refined, and compared with random ones. SI, base frame.

use nalgebra::DMatrix;
use rand::seq::SliceRandom;
use rayon::prelude::*;

use super::criterion::{Target, join};
use super::error::PlanningError;
use super::exchange::{Candidate, Design};
use super::information::{Information, bare};
use super::place::{Rules, Station};
use super::refine::refine;
use super::request::Request;
use super::result::{Bought, Planned};
use crate::description::campaign::Campaign;
use crate::kinematics::{Geometry, Placements};
use crate::math::median;
use crate::model::Model;
use crate::simulation::{Loaded, draw_in_box, generator};

/// Plans measurements. `progress` is called with the share that is done.
///
/// # Errors
/// [`PlanningError`].
///
/// ```
/// use elastogeo::estimation::What;
/// use elastogeo::identifiability::{Criterion, DEFAULT_TOLERANCE, Scaling};
/// use elastogeo::observation::POSITION;
/// use elastogeo::planning::{Optimality, Request, plan};
/// use elastogeo::simulation::joint_box;
///
/// let model = elastogeo::files::load_robot("universal-ur5")?.model;
/// let request = Request {
///     count: 12,
///     what: What { geometric: true, elastic: false },
///     observes: POSITION,
///     markers: vec![None],
///     loads: Vec::new(),
///     repeats: 1,
///     sigma: 3e-5, // m
///     sigma_orientation: 0.0,
///     estimate: [true, true],
///     criterion: Optimality::TestError,
///     sight: None,
///     within: joint_box(&model, 1.0),
///     workspace: None,
///     apart: 0.0,
///     tests: Vec::new(),
///     tested_within: joint_box(&model, 0.5),
///     measured: None,
///     design: None,
///     hold: Vec::new(),
///     scaling: Scaling::Norm,
///     tolerance: Criterion::Relative(DEFAULT_TOLERANCE),
///     seed: 1,
///     settings: Default::default(),
/// };
/// let planned = plan(&model, &request, &mut |_| {})?;
/// assert_eq!(planned.stations.len(), 12);
/// assert!(planned.error < 2e-4); // m, at test poses
/// # Ok::<(), elastogeo::Error>(())
/// ```
pub fn plan(model: &Model, request: &Request, progress: &mut dyn FnMut(f64)) -> Result<Planned, PlanningError> {
    let values = request.design.as_ref().map_or_else(|| model.registry.nominal(), |design| design.values.clone());
    let geometry = Geometry::new(model, &values)?;
    let ways = ways(request);
    let loads = if request.loads.is_empty() { vec![[0.0; 6]] } else { request.loads.clone() };
    let rules = Rules::new(request, &geometry, &ways)?;
    let stations = draw(&rules, &loads)?;
    let candidates = stations.len() / loads.len() / rules.ways();
    let tests = tests(&rules, &loads)?;
    let information = Information::new(model, request, &stations)?;
    let weight = information.tests(&tests)?;
    let blocks = information.blocks(&stations)?;
    let measured = request.measured.as_ref();
    let before = measured.map_or(Ok(Vec::new()), |measured| measured_before(&rules, measured))?;
    let search = Search {
        request,
        pool: stations.into_iter().zip(blocks).map(|(station, block)| Candidate { station, block }).collect(),
        empty: Design {
            known: information.known.clone(),
            chosen: Vec::new(),
            before,
            apart: request.apart,
            worth: request.settings.worth,
            passes: request.settings.passes,
        },
        target: information.target(request.criterion, &weight),
        errors: Target::Trace(weight),
        parameters: information.identifiability.kept.len(),
    };
    let least = search.least(&information)?;
    let others = counts(request.count, least, search.pool.len());
    let steps = (others.len() + 6) as f64;
    let mut bought = search.bought(&others, &mut |k| progress((k + 1) as f64 / steps));
    let mut within = |part: f64| progress(((others.len() as f64 + part) / steps).min(1.0));
    let design = search.best(&rules, &information, &mut within)?;
    let m = design.information();
    if !information.is_whole(&m) {
        return Err(search.too_few(request.count + 1));
    }
    let error = search.errors.loss(&m).exp();
    let known = &search.empty.known;
    bought.push(Bought { count: request.count, planned: error, random: search.random(request.count) });
    bought.sort_by_key(|bought| bought.count);
    let stations: Vec<Station> = design.chosen.into_iter().map(|chosen| chosen.station).collect();
    let campaign = information.campaign(&stations);
    Ok(Planned {
        identifiability: information.reduced(request, &campaign)?,
        slots: information.slots.clone(),
        deviations: information.kept().zip(information.deviations(&m).unwrap_or_default()).collect(),
        campaign,
        stations,
        before: (measured.is_some() && information.is_whole(known)).then(|| search.errors.loss(known).exp()),
        error,
        bought,
        random_equal: search.random_equal(error),
        least,
        candidates,
    })
}

/// The problem that all searches share.
struct Search<'a> {
    request: &'a Request,
    pool: Vec<Candidate>,
    /// Nothing chosen yet.
    empty: Design,
    /// The criterion asked for.
    target: Target,
    /// The error at the test poses.
    errors: Target,
    /// Number of identifiable parameters.
    parameters: usize,
}

impl Search<'_> {
    /// The error at the test poses that other numbers of configurations buy.
    fn bought(&self, counts: &[usize], done: &mut dyn FnMut(usize)) -> Vec<Bought> {
        let mut bought = Vec::with_capacity(counts.len() + 1);
        for (k, &count) in counts.iter().enumerate() {
            let (design, _) = self.chosen(count, 0);
            let planned = self.errors.loss(&design.information()).exp();
            bought.push(Bought { count, planned, random: self.random(count) });
            done(k);
        }
        bought
    }

    fn too_few(&self, least: usize) -> PlanningError {
        PlanningError::TooFew { count: self.request.count, parameters: self.parameters, least }
    }

    fn too_near(&self, found: usize) -> PlanningError {
        PlanningError::TooNear { found, count: self.request.count, apart: self.request.apart }
    }

    /// Fewest configurations that separate the parameters; an error where more are needed than asked for.
    fn least(&self, information: &Information) -> Result<usize, PlanningError> {
        let count = self.request.count;
        match fewest(information, &self.empty, &self.pool) {
            Some(least) if count >= least => Ok(least),
            Some(least) => Err(self.too_few(least)),
            None => {
                // Either the distance excludes too many, or all candidates together do not separate the parameters.
                if self.request.apart > 0.0 {
                    let mut spread = self.empty.clone();
                    spread.grow(&Target::Determinant, &self.pool, count);
                    if spread.chosen.len() < count {
                        return Err(self.too_near(spread.chosen.len()));
                    }
                }
                let rows = self.pool.iter().map(|candidate| candidate.block.ncols()).max().unwrap_or(1);
                Err(self.too_few(self.parameters.div_ceil(rows).max(self.pool.len() + 1)))
            }
        }
    }

    /// The best design: exchanged from several starts, its joints moved, and ordered.
    fn best(
        &self,
        rules: &Rules,
        information: &Information,
        within: &mut dyn FnMut(f64),
    ) -> Result<Design, PlanningError> {
        let (mut design, mut loss) = self.chosen(self.request.count, self.request.settings.starts);
        if design.chosen.len() < self.request.count {
            return Err(self.too_near(design.chosen.len()));
        }
        within(1.0);
        let mut drawn = generator(self.request.seed ^ 0x5EED);
        let most = self.request.settings.refinements;
        for refinement in 0..most {
            let refined = refine(rules, information, &self.target, &mut design, &mut drawn);
            within(2.0 + 4.0 * f64::from(refinement + 1) / f64::from(most));
            let gained = loss - refined;
            loss = design.exchange(&self.target, &self.pool);
            if gained < self.request.settings.least_refinement {
                break;
            }
        }
        in_order(&mut design);
        Ok(design)
    }

    /// The best stations found by exchange from a greedy start and from random ones, and their loss.
    fn chosen(&self, count: usize, starts: u64) -> (Design, f64) {
        let mut best = self.empty.clone();
        best.grow(&self.target, &self.pool, count);
        let mut least = best.exchange(&self.target, &self.pool);
        for start in 0..starts {
            let mut design = self.empty.clone();
            for k in self.shuffled(start) {
                if design.chosen.len() < count && design.admits(&self.pool[k].station, usize::MAX) {
                    design.chosen.push(self.pool[k].clone());
                }
            }
            let loss = design.exchange(&self.target, &self.pool);
            if design.chosen.len() >= best.chosen.len() && loss < least {
                (best, least) = (design, loss);
            }
        }
        (best, least)
    }

    /// Candidates in the random order of a draw.
    fn shuffled(&self, draw: u64) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.pool.len()).collect();
        order.shuffle(&mut generator(self.request.seed.wrapping_add(1 + draw)));
        order
    }

    /// Error at the test poses with random stations: median of [`super::Settings::random_sets`].
    fn random(&self, count: usize) -> f64 {
        let one = |set: u64| {
            let mut m: DMatrix<f64> = self.empty.known.clone();
            for &k in self.shuffled(set).iter().take(count) {
                join(&mut m, &self.pool[k].block);
            }
            self.errors.loss(&m).exp()
        };
        let mut found: Vec<f64> = (0..self.request.settings.random_sets).into_par_iter().map(one).collect();
        median(&mut found).unwrap_or(f64::INFINITY)
    }

    /// Fewest random stations that do as well as `error`, by bisection.
    fn random_equal(&self, error: f64) -> Option<usize> {
        let (mut few, mut enough) = (self.request.count, self.pool.len());
        if self.random(enough) > error {
            return None;
        }
        if self.random(few) <= error {
            return Some(few);
        }
        while enough - few > 1 {
            let middle = usize::midpoint(few, enough);
            if self.random(middle) <= error { enough = middle } else { few = middle }
        }
        Some(enough)
    }
}

/// Candidates: every configuration drawn under every load.
fn draw(rules: &Rules, loads: &[[f64; 6]]) -> Result<Vec<Station>, PlanningError> {
    let (request, geometry) = (rules.request, rules.geometry);
    let wanted = request.settings.drawn.max(3 * request.count);
    if (0..rules.ways()).any(|way| rules.touches(way)) {
        return draw_touching(rules, loads, wanted);
    }
    let accepted = |q: &[f64], placements: &Placements| rules.seen(q, placements).is_some();
    let (drawn, error) = draw_in_box(geometry, &request.within, wanted, &mut generator(request.seed), accepted);
    if drawn.len() < request.count.max(1) {
        return match error {
            Some(error) if drawn.is_empty() && request.sight.is_none() && request.workspace.is_none() => {
                Err(error.into())
            }
            _ => Err(PlanningError::TooFewAllowed { found: drawn.len(), tried: 1000 * wanted }),
        };
    }
    let mut placements = Placements::default();
    let ways = (0..rules.ways()).flat_map(|way| loads.iter().map(move |load| (way, *load)));
    let all = drawn.iter().flat_map(|q| ways.clone().map(move |(way, load)| (q, way, load)));
    Ok(all.filter_map(|(q, way, load)| rules.station(&mut placements, q, load, way)).collect())
}

/// Candidates of which some touch something: each way has its share of the configurations.
fn draw_touching(rules: &Rules, loads: &[[f64; 6]], wanted: usize) -> Result<Vec<Station>, PlanningError> {
    let (request, geometry) = (rules.request, rules.geometry);
    let each = wanted.div_ceil(rules.ways()).max(request.count.min(50));
    let mut placements = Placements::default();
    let mut all = Vec::new();
    for way in 0..rules.ways() {
        let mut random = generator(request.seed ^ (way as u64) << 32);
        let (drawn, _) = draw_in_box(geometry, &request.within, 8 * each, &mut random, |_, _| true);
        let mut found = 0;
        for q in drawn {
            let own: Vec<Station> =
                loads.iter().filter_map(|load| rules.station(&mut placements, &q, *load, way)).collect();
            found += usize::from(!own.is_empty());
            all.extend(own);
            if found == each {
                break;
            }
        }
    }
    match all.len() < request.count.max(1) {
        true => Err(PlanningError::TooFewAllowed { found: all.len(), tried: 8 * each * rules.ways() }),
        false => Ok(all),
    }
}

/// The readings of all ways, one after the other, as a campaign.
fn ways(request: &Request) -> Campaign {
    let Some(design) = &request.design else { return Campaign::default() };
    let readings: Vec<_> = design.ways.iter().flatten().copied().collect();
    Campaign { joints: vec![0.0; readings.len() * design.campaign.variables], readings, ..bare(&design.campaign) }
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
    let wanted = request.settings.tests;
    // Another stream than the candidates': the plan must not be tested where it may measure.
    let accepted = |q: &[f64], placements: &Placements| rules.seen_from_anywhere(q, placements);
    let (drawn, _) = draw_in_box(geometry, &request.tested_within, wanted, &mut generator(!request.seed), accepted);
    if drawn.is_empty() {
        return Err(PlanningError::NoTest { tried: 1000 * wanted });
    }
    Ok(drawn.into_iter().enumerate().map(|(k, q)| (q, loads[k % loads.len()])).collect())
}

/// Where readings have been made.
fn measured_before(rules: &Rules, measured: &Campaign) -> Result<Vec<Station>, PlanningError> {
    let mut placements = Placements::default();
    let mut stations: Vec<Station> = Vec::new();
    for (index, reading) in measured.readings.iter().enumerate() {
        let q = measured.configuration(index).to_vec();
        rules.geometry.place(&q, &mut placements)?;
        let station = Station { q, load: reading.wrench, markers: Vec::new(), at: rules.tool(&placements), way: 0 };
        if !stations.contains(&station) {
            stations.push(station);
        }
    }
    Ok(stations)
}

/// Fewest stations that separate the parameters: chosen for that alone.
fn fewest(information: &Information, empty: &Design, pool: &[Candidate]) -> Option<usize> {
    let mut design = empty.clone();
    let mut m = design.known.clone();
    loop {
        if information.is_whole(&m) {
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

/// Neighbours in the first joints follow each other, so that the robot (and the reflector) moves little.
fn in_order(design: &mut Design) {
    let mut waiting = std::mem::take(&mut design.chosen);
    waiting.sort_by(|a, b| a.station.q.partial_cmp(&b.station.q).unwrap_or(std::cmp::Ordering::Equal));
    if waiting.is_empty() {
        return;
    }
    let mut ordered = vec![waiting.remove(0)];
    while let Some(last) = ordered.last().filter(|_| !waiting.is_empty()) {
        let away = |candidate: &Candidate| {
            let by = candidate.station.q.iter().zip(&last.station.q).map(|(a, b)| (a - b).abs());
            by.fold(0.0, f64::max)
        };
        let next = (0..waiting.len()).min_by(|&a, &b| away(&waiting[a]).total_cmp(&away(&waiting[b]))).unwrap_or(0);
        ordered.push(waiting.remove(next));
    }
    design.chosen = ordered;
}
