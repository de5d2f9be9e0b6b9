//! The search over placements and postures: starts drawn, the best moved on, the best of those met at every point.

use nalgebra::{Point3, Vector3};
use rand::RngExt;
use rayon::prelude::*;

use super::arm::Arm;
use super::pattern::{At, Pattern, descend};
use super::{Moved, Placed, StiffestError, Stop, Wanted, Way, Work};
use crate::model::Model;
use crate::prediction::SinglePredictor;
use crate::simulation::generator;

/// How often points that the best way cannot take are added to those tried.
const REPEATS: usize = 6;

/// Finds where the workpiece deflects the arm least, and the postures there. `predictor` has a reading of the tool centre point for
/// each point of the path. `progress` is called with the share that is done.
///
/// # Errors
/// [`StiffestError`].
pub fn place(
    predictor: &SinglePredictor,
    work: &Work,
    wanted: &Wanted,
    progress: &mut dyn FnMut(f64),
) -> Result<Placed, StiffestError> {
    let arm = Arm { predictor, work, wanted, scale: scales(predictor.geometry().model) };
    let count = work.targets.len();
    let search = &wanted.search;
    let thin = |k: usize| k * (count - 1) / (search.points.min(count) - 1).max(1);
    let mut points: Vec<usize> =
        if count == 0 { Vec::new() } else { (0..search.points.min(count)).map(thin).collect() };
    points.dedup();
    let mut tried = 0;
    let mut last = None;
    for _ in 0..REPEATS {
        let search = Searched { arm: &arm, points: &points, middle: middle(work) };
        let mut ways = search.ways(&mut tried, progress)?;
        ways.sort_by(|a, b| search.value(a).total_cmp(&search.value(b)));
        let given = ways.iter().find(|way| way.moved.by == [0.0; 6]).map(|way| search.everywhere(way, count));
        let mut failed = Vec::new();
        for way in &ways {
            match search.everywhere(way, count) {
                Ok(best) => {
                    let given = given.and_then(Result::ok);
                    // All points count at the end.
                    let least = |way: &Way| wanted.least.of(way.postures.iter().map(|posture| posture.counted));
                    let best = match &given {
                        Some(given) if least(given) <= least(&best) => given.clone(),
                        _ => best,
                    };
                    return Ok(Placed { given, best, tried });
                }
                Err((point, why)) => failed.push((point, why)),
            }
        }
        points.extend(failed.iter().map(|(point, _)| *point));
        points.sort_unstable();
        points.dedup();
        last = failed.into_iter().next();
    }
    let (point, why) = last.unwrap_or((0, Stop::Condition { condition: f64::INFINITY }));
    Err(StiffestError::Nowhere { tried, point, why })
}

/// The path where it is given, at given configurations, whatever limits they keep; none where one cannot be placed.
pub fn as_given(predictor: &SinglePredictor, work: &Work, wanted: &Wanted, joints: Vec<Vec<f64>>) -> Option<Way> {
    let arm = Arm { predictor, work, wanted, scale: scales(predictor.geometry().model) };
    let moved = Moved { by: [0.0; 6], about: middle(work) };
    let (motion, mut memory) = (moved.motion(), predictor.workspace());
    let postures = joints.into_iter().enumerate().map(|(index, q)| arm.loaded(index, &motion, q, &mut memory).ok());
    Some(Way { moved, postures: postures.collect::<Option<_>>()? })
}

/// A search at some points of the path.
struct Searched<'a> {
    arm: &'a Arm<'a>,
    points: &'a [usize],
    middle: Point3<f64>,
}

impl Searched<'_> {
    fn value(&self, way: &Way) -> f64 {
        self.arm.wanted.least.of(way.postures.iter().map(|posture| posture.counted))
    }

    fn moved(&self, by: &[f64]) -> Moved {
        Moved { by: std::array::from_fn(|k| by.get(k).copied().unwrap_or(0.0)), about: self.middle }
    }

    /// Ways through the points: the best at the placement given, and the best found from each start.
    fn ways(&self, tried: &mut usize, progress: &mut dyn FnMut(f64)) -> Result<Vec<Way>, StiffestError> {
        let wanted = self.arm.wanted;
        let search = &wanted.search;
        let axes = wanted.within.iter().filter(|[low, high]| high > low).count();
        let mut random = generator(wanted.seed);
        let mut starts = vec![[0.0; 6]];
        for _ in 0..axes * search.starts {
            starts.push(wanted.within.map(|[low, high]| low + (high - low) * random.random::<f64>()));
        }
        let middle = wanted.within.map(|[low, high]| 0.5 * (low + high));
        if middle != [0.0; 6] {
            starts.push(middle);
        }
        let each: Vec<Result<Vec<Way>, (usize, Stop)>> = starts
            .par_iter()
            .enumerate()
            .map(|(k, by)| self.at(self.moved(by), search.samples[usize::from(k > 0)], k == 0))
            .collect();
        progress(0.3);
        *tried += each.iter().flatten().map(Vec::len).sum::<usize>();
        let mut why = None;
        let mut given = None;
        let mut drawn = Vec::new();
        for (k, found) in each.into_iter().enumerate() {
            match found {
                Ok(ways) if k == 0 => {
                    given = ways.first().cloned();
                    drawn.extend(ways);
                }
                Ok(ways) => drawn.extend(ways),
                Err(stop) if k == 0 => why = Some(stop),
                Err(_) => {}
            }
        }
        drawn.sort_by(|a, b| self.value(a).total_cmp(&self.value(b)));
        drawn.truncate(search.kept);
        if drawn.is_empty() && given.is_none() {
            let (point, why) = why.unwrap_or((0, Stop::Condition { condition: f64::INFINITY }));
            return Err(StiffestError::Nowhere { tried: starts.len(), point: self.points[point], why });
        }
        let pattern = Pattern { steps: search.steps, directions: search.directions, worth: search.worth };
        let mut ways: Vec<Way> = given.into_iter().collect();
        let parts = drawn.len() as f64;
        for (k, way) in drawn.into_iter().enumerate() {
            if axes > 0 {
                let start = At { point: way.moved.by.to_vec(), value: self.value(&way), found: way };
                let (at, more) = descend(start, &wanted.within, &pattern, &mut random, |by, way| {
                    let mut work = self.arm.predictor.workspace();
                    let way = self.arm.carry(way, self.moved(by), self.points, &mut work)?;
                    Some((self.value(&way), way))
                });
                *tried += more;
                ways.push(at.found);
            }
            progress(0.3 + 0.7 * (k as f64 + 1.0) / parts);
        }
        Ok(ways)
    }

    /// Ways through the points at a placement, one for each posture found at the first, the best first.
    fn at(&self, moved: Moved, samples: usize, is_given: bool) -> Result<Vec<Way>, (usize, Stop)> {
        let mut work = self.arm.predictor.workspace();
        let motion = moved.motion();
        let first = self.points.first().copied().unwrap_or(0);
        let anywhere = self.arm.anywhere(first, &motion, samples, &mut work);
        let near = match &self.arm.work.from {
            Some(from) if is_given => self.arm.near(first, &motion, from.clone(), &mut work).ok(),
            _ => None,
        };
        let mut firsts = match anywhere {
            Ok(firsts) => firsts,
            Err(why) if near.is_none() => return Err((0, why)),
            Err(_) => Vec::new(),
        };
        firsts.extend(near);
        let [sought, followed, moved_on] = self.arm.wanted.search.self_motions;
        // Steps are those of a posture that is sought where the place is final, and coarse ones where it will be moved on.
        let steps = if is_given { [sought, followed] } else { [sought.get(..3).unwrap_or(sought), moved_on] };
        let each: Vec<Result<Way, (usize, Stop)>> = firsts
            .into_par_iter()
            .map_init(
                || self.arm.predictor.workspace(),
                |work, first| self.arm.follow(moved, self.points, first, steps, work),
            )
            .collect();
        let (mut ways, mut farthest) = (Vec::new(), None::<(usize, Stop)>);
        for way in each {
            match way {
                Ok(way) => ways.push(way),
                Err(stop) if farthest.as_ref().is_none_or(|(point, _)| stop.0 > *point) => farthest = Some(stop),
                Err(_) => {}
            }
        }
        ways.sort_by(|a, b| self.value(a).total_cmp(&self.value(b)));
        match farthest {
            Some(stop) if ways.is_empty() => Err(stop),
            _ => Ok(ways),
        }
    }

    /// A way through some points, through all: each from the posture of the last of them before it.
    fn everywhere(&self, way: &Way, count: usize) -> Result<Way, (usize, Stop)> {
        let motion = way.moved.motion();
        let steps = self.arm.wanted.search.self_motions[1];
        let mut work = self.arm.predictor.workspace();
        let mut postures = Vec::with_capacity(count);
        let mut last: Option<Vec<f64>> = None;
        for index in 0..count {
            let known = self.points.iter().position(|&point| point == index).and_then(|k| way.postures.get(k));
            let from = known.map(|posture| posture.joints.clone()).or(last);
            let from = from.unwrap_or_else(|| self.arm.predictor.geometry().model.middle());
            let posture = self.arm.near(index, &motion, from, &mut work).map_err(|why| (index, why))?;
            let posture = self.arm.settle(index, &motion, posture, steps, &mut work);
            last = Some(posture.joints.clone());
            postures.push(posture);
        }
        Ok(Way { moved: way.moved, postures })
    }
}

/// The middle of the path's points.
fn middle(work: &Work) -> Point3<f64> {
    let sum: Vector3<f64> = work.targets.iter().map(|target| target.translation.vector).sum();
    Point3::from(sum / (work.targets.len().max(1) as f64))
}

/// A unit of each variable: 1 rad, or half the range of a length (1 m without).
fn scales(model: &Model) -> Vec<f64> {
    let scale = |variable: &crate::description::robot::Variable| match variable.limits {
        Some([low, high]) if !variable.is_angle && (high - low).is_finite() => 0.5 * (high - low),
        _ => 1.0,
    };
    model.variables.iter().map(scale).collect()
}
