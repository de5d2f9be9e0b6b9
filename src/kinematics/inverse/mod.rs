//! The inverse model of any robot: which variables bring the tool centre point to a target.
//!
//! Numerical, on the values that a [`Geometry`] holds, so that a calibrated robot is inverted as exactly as a nominal
//! one: Levenberg's damped Gauss-Newton steps (Levenberg 1944; damping in proportion to the squared error, after
//! Yamashita and Fukushima 2001) on the analytic Jacobian, from many starts. Nothing is specific to a kind of robot;
//! the price is that the list of branches is complete only in probability.

mod descent;
mod least_step;
mod target;

pub use least_step::LeastSteps;
pub use target::{Hold, InverseError, InverseSettings, Solution, Target};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::geometry::{Geometry, Placements};
use super::keep_out::entered;
use super::limits::beyond_limits;
use crate::description::robot::Motion;
use descent::{Memory, Problem, Within};

/// Starts tried together; fixed, so that threads change nothing.
const BATCH: usize = 32;
/// Batches are at most this many times what `restarts` asks for.
const PATIENCE: usize = 12;
/// By what starts about a declared branch are drawn nearer to it.
const NEARER: f64 = 0.9;
/// Variables (in their scale) that differ by less belong to one solution.
const SAME: f64 = 1e-4;

/// Finds the configurations that bring the tool centre point to a target, in ascending distance from `from` or from 0.
///
/// Without [`InverseSettings::from`]: every branch found, or samples far apart where the target leaves motions free.
/// With it: the nearest solution; where motions are free, the one that shortest steps from there lead to.
///
/// # Errors
/// [`InverseError`] if the input is unsound, the mechanism cannot be put together or no start reaches the target.
///
/// ```
/// use elastogeo::kinematics::{Geometry, Hold, InverseSettings, Placements, Target, solve};
///
/// let robot = elastogeo::files::load_robot("universal-ur5")?;
/// let geometry = Geometry::nominal(&robot.model)?;
/// let mut placements = Placements::default();
/// geometry.place(&[0.3, -1.2, 1.3, 0.4, 0.9, 0.2], &mut placements)?;
/// let tool = placements.frames[robot.model.tool.0] * geometry.tool();
/// let target = Target { position: tool.translation.vector.into(), rotation: Some(tool.rotation), hold: Hold::POSE };
/// let branches = solve(&geometry, &target, &InverseSettings::default())?;
/// assert_eq!(branches.len(), 8);
/// assert!(branches.iter().all(|solution| solution.position_error < 1e-9 && solution.self_motions == 0));
/// # Ok::<(), elastogeo::Error>(())
/// ```
pub fn solve(geometry: &Geometry, target: &Target, settings: &InverseSettings) -> Result<Vec<Solution>, InverseError> {
    check(geometry, target, settings)?;
    let mut first = settings.from.clone().unwrap_or_else(|| geometry.model.middle());
    let mut placements = Placements::default();
    if let Err(why) = geometry.place(&first, &mut placements) {
        let declared = placeable(geometry, &mut placements).ok_or(InverseError::Assembly(why))?;
        if settings.from.is_none() {
            first = declared;
        }
    }
    let homes = (0..geometry.model.variables.len()).map(|k| home(geometry, k)).collect();
    let search = Search { problem: Problem::new(geometry, target, &placements), settings, first, homes };
    search.run()
}

fn check(geometry: &Geometry, target: &Target, settings: &InverseSettings) -> Result<(), InverseError> {
    let input = |text: &str| Err(InverseError::Input(text.into()));
    let finite = target.position.iter().all(|v| v.is_finite())
        && target.rotation.is_none_or(|r| r.matrix().iter().all(|v| v.is_finite()));
    if !finite {
        return input("the target is not finite");
    }
    if !(settings.tolerance > 0.0 && settings.tolerance.is_finite()) {
        return input("the tolerance must be finite and above 0");
    }
    if geometry.model.variables.is_empty() {
        return input("the robot has no variable that could move");
    }
    if let Some(from) = &settings.from {
        if from.len() != geometry.model.variables.len() {
            let (expected, found) = (geometry.model.variables.len(), from.len());
            return input(&format!("the start has {found} values where {expected} variables are declared"));
        }
        if from.iter().any(|v| !v.is_finite()) {
            return input("the start is not finite");
        }
    }
    Ok(())
}

/// Places the robot at the configuration at which a loop's branch is declared, which it returns.
fn placeable(geometry: &Geometry, placements: &mut Placements) -> Option<Vec<f64>> {
    let mut declared = geometry.loops.iter().map(|closed| &closed.group().at);
    declared.find(|at| geometry.place(at, placements).is_ok()).cloned()
}

/// Where a variable is when the branch of a loop that it drives is declared: the loop closes about there.
fn home(geometry: &Geometry, variable: usize) -> Option<f64> {
    let drives = |joint: &usize| matches!(geometry.model.frames[*joint].motion, Motion::Variable { index, .. } if index == variable);
    let mut groups = geometry.loops.iter().map(|closed| closed.group());
    groups.find(|group| group.inputs.iter().any(drives))?.at.get(variable).copied()
}

struct Search<'a> {
    problem: Problem<'a>,
    settings: &'a InverseSettings,
    first: Vec<f64>,
    /// Of each variable, as [`home`].
    homes: Vec<Option<f64>>,
}

/// What a start led to.
enum Outcome {
    Solved(Solution),
    /// Closest approach: squared weighted error, then as in a solution.
    Short(f64, Solution),
    /// The start cannot be put together.
    Nowhere,
}

impl Search<'_> {
    fn run(&self) -> Result<Vec<Solution>, InverseError> {
        let mut found: Vec<Solution> = Vec::new();
        let mut closest: Option<(f64, Solution)> = None;
        let mut fruitless = 0;
        if self.settings.from.is_some()
            && let Outcome::Solved(solution) = self.attempt(Start::Given)
            && solution.self_motions > 0
        {
            return Ok(vec![solution]);
        }
        for batch in 0.. {
            let starts = self.starts(batch);
            let outcomes: Vec<Outcome> = starts.into_par_iter().map(|start| self.attempt(start)).collect();
            for outcome in outcomes {
                fruitless += 1;
                match outcome {
                    Outcome::Solved(solution) => {
                        if !found.iter().any(|known| self.same(&known.joints, &solution.joints)) {
                            found.push(solution);
                            fruitless = 0;
                        }
                    }
                    Outcome::Short(merit, solution) => {
                        if closest.as_ref().is_none_or(|(least, _)| merit < *least) {
                            closest = Some((merit, solution));
                        }
                    }
                    Outcome::Nowhere => {}
                }
            }
            let continuum = found.first().is_some_and(|solution| solution.self_motions > 0);
            let most = PATIENCE * self.settings.restarts;
            let tried = batch * BATCH + 1;
            if continuum || fruitless >= self.settings.restarts || tried >= most {
                break;
            }
        }
        if !found.is_empty() {
            return Ok(self.reported(found));
        }
        let Some((_, short)) = closest else { return Err(self.nothing_to_compare()) };
        Err(InverseError::OutOfReach {
            position_error: short.position_error,
            orientation_error: short.orientation_error,
            limits: self.limits_that_stop(&short.joints),
            joints: short.joints,
        })
    }

    /// Why no start led anywhere: nothing can be put together, or only beyond the limits of passive joints.
    fn nothing_to_compare(&self) -> InverseError {
        let mut memory = self.problem.memory();
        match self.problem.errors(&self.first, &mut memory) {
            Some(errors) => InverseError::OutOfReach {
                position_error: errors.position.norm(),
                orientation_error: errors.orientation.norm(),
                joints: self.first.clone(),
                limits: self.limits_that_stop(&self.first),
            },
            None => match self.problem.geometry.place(&self.first, &mut memory.placements) {
                Err(why) => InverseError::Assembly(why),
                Ok(()) => InverseError::Input("the target is too large a number to compute with".into()),
            },
        }
    }

    /// Orders and thins what was found.
    fn reported(&self, mut found: Vec<Solution>) -> Vec<Solution> {
        let anchor = self.settings.from.clone().unwrap_or_else(|| vec![0.0; self.first.len()]);
        found.sort_by(|a, b| self.distance(&a.joints, &anchor).total_cmp(&self.distance(&b.joints, &anchor)));
        if self.settings.from.is_some() {
            found.truncate(1);
        }
        if found.iter().all(|solution| solution.self_motions == 0) || found.len() <= self.settings.samples {
            return found;
        }
        // The nearest, then always the one farthest from those taken.
        let mut rest = found.split_off(1);
        while found.len() < self.settings.samples {
            let apart = |solution: &Solution| {
                found.iter().map(|taken| self.distance(&taken.joints, &solution.joints)).fold(f64::INFINITY, f64::min)
            };
            let next = rest.iter().enumerate().max_by(|a, b| apart(a.1).total_cmp(&apart(b.1)).then(b.0.cmp(&a.0)));
            let Some(next) = next.map(|(k, _)| k) else { break };
            found.push(rest.swap_remove(next));
        }
        found
    }

    /// Starts of a batch, each from a random stream of its own.
    fn starts(&self, batch: usize) -> Vec<Start> {
        let streams = batch * BATCH..(batch + 1) * BATCH;
        let mut starts: Vec<Start> = streams.map(|stream| Start::Random(stream as u64)).collect();
        if batch == 0 {
            starts[0] = Start::Given;
            if self.settings.restarts == 0 {
                starts.truncate(1);
            }
        }
        starts
    }

    /// Descends from a start: first without limits of angles, which whole turns may bring back, then within all limits.
    fn attempt(&self, start: Start) -> Outcome {
        let mut memory = self.problem.memory();
        let Some(start) = self.place(start, &mut memory) else { return Outcome::Nowhere };
        let mut closest: Option<(f64, Solution)> = None;
        // A redundant robot keeps its limits best by never leaving them.
        let order = match self.problem.geometry.model.variables.len() > 6 || self.settings.from.is_some() {
            true => [Within::Limits, Within::Lengths],
            false => [Within::Lengths, Within::Limits],
        };
        for within in order {
            let mut q = start.clone();
            if self.problem.descend(&mut q, within, &mut memory).is_none() || !self.bring_back(&mut q) {
                continue;
            }
            let Some((merit, mut solution)) = self.measure(q, &mut memory) else { continue };
            let tolerance = self.settings.tolerance;
            if solution.position_error <= tolerance && solution.orientation_error <= tolerance {
                solution.self_motions = self.problem.self_motions(&solution.joints, &mut memory);
                return Outcome::Solved(solution);
            }
            if closest.as_ref().is_none_or(|(least, _)| merit < *least) {
                closest = Some((merit, solution));
            }
        }
        closest.map_or(Outcome::Nowhere, |(merit, solution)| Outcome::Short(merit, solution))
    }

    /// Errors of a configuration that keeps all limits, and their weighted square.
    fn measure(&self, joints: Vec<f64>, memory: &mut Memory) -> Option<(f64, Solution)> {
        let errors = self.problem.errors(&joints, memory)?;
        let within = self.problem.passive_within(&joints, &memory.placements)
            && entered(self.problem.geometry, &memory.placements).next().is_none();
        let solution = Solution {
            joints,
            position_error: errors.position.norm(),
            orientation_error: errors.orientation.norm(),
            self_motions: 0,
        };
        let merit = errors.weighted(self.problem.length).norm_squared();
        within.then_some((merit, solution))
    }

    /// A start that can be put together: random ones are drawn again as long as they cannot.
    fn place(&self, start: Start, memory: &mut Memory) -> Option<Vec<f64>> {
        let Start::Random(stream) = start else {
            return self.problem.errors(&self.first, memory).map(|_| self.first.clone());
        };
        let mut random = ChaCha8Rng::seed_from_u64(self.settings.seed);
        random.set_stream(stream);
        for trial in 0..40 {
            let q: Vec<f64> = (0..self.first.len())
                .map(|k| {
                    let ([low, high], part) = (self.span(k, trial), random.random::<f64>());
                    low + part * (high - low)
                })
                .collect();
            if self.problem.errors(&q, memory).is_some() {
                return Some(q);
            }
        }
        None
    }

    /// Where random starts of a variable lie: its limits; one turn, or the reach to both sides, where they are wider. A loop closes
    /// about where its branch is declared: a joint in it that no limit keeps starts within half a turn of there, nearer after
    /// every start that cannot be put together.
    fn span(&self, k: usize, trial: i32) -> [f64; 2] {
        let [low, high] = self.problem.limits[k];
        let is_open = self.problem.geometry.model.variables[k].is_angle && !(high - low).is_finite();
        if let Some(at) = self.homes[k].filter(|_| is_open) {
            let half = std::f64::consts::PI * NEARER.powi(trial);
            return [(at - half).max(low), (at + half).min(high)];
        }
        let half = if self.problem.turns[k] {
            std::f64::consts::PI
        } else if self.problem.geometry.model.variables[k].is_angle {
            std::f64::consts::TAU
        } else {
            self.problem.length
        };
        if self.problem.turns[k] || !(high - low).is_finite() {
            let from = (-half).max(low).min(high - 2.0 * half).max(low);
            [from, (from + 2.0 * half).min(high)]
        } else {
            [low, high]
        }
    }

    /// Brings angles back by whole turns, as near as limits allow to `from`, to where a loop closes, or to 0; whether all variables keep their limits.
    fn bring_back(&self, q: &mut [f64]) -> bool {
        let turn = std::f64::consts::TAU;
        for (k, value) in q.iter_mut().enumerate() {
            let [low, high] = self.problem.limits[k];
            if self.problem.turns[k] {
                let anchor = self.settings.from.as_ref().map(|from| from[k]).or(self.homes[k]).unwrap_or(0.0);
                let least = ((low - 1e-12 - *value) / turn).ceil();
                let most = ((high + 1e-12 - *value) / turn).floor();
                *value += turn * ((anchor - *value) / turn).round().max(least).min(most);
            }
            if !(low - 1e-12 <= *value && *value <= high + 1e-12) {
                return false;
            }
            *value = value.max(low).min(high);
        }
        true
    }

    fn difference(&self, k: usize, a: f64, b: f64) -> f64 {
        let turn = std::f64::consts::TAU;
        let difference = a - b;
        let whole = if self.problem.turns[k] { turn * (difference / turn).round() } else { 0.0 };
        ((difference - whole) / self.problem.scale[k]).abs()
    }

    fn same(&self, a: &[f64], b: &[f64]) -> bool {
        a.iter().zip(b).enumerate().all(|(k, (a, b))| self.difference(k, *a, *b) < SAME)
    }

    /// Distance between configurations in scaled variables; whole turns count, as the robot would have to turn them.
    fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).zip(&self.problem.scale).map(|((a, b), scale)| ((a - b) / scale).powi(2)).sum::<f64>().sqrt()
    }

    /// Names of the variables and joints whose limits keep the target out of reach: none if it is so without limits too.
    fn limits_that_stop(&self, closest: &[f64]) -> Vec<String> {
        let mut memory = self.problem.memory();
        let tries = self.settings.restarts.min(2 * BATCH) as u64;
        let starts = (0..tries).filter_map(|stream| {
            let mut memory = self.problem.memory();
            self.place(Start::Random(stream), &mut memory)
        });
        let mut best: Option<(usize, Vec<String>)> = None;
        for start in std::iter::once(closest.to_vec()).chain(starts) {
            let mut q = start;
            let Some(errors) = self.problem.descend(&mut q, Within::Nothing, &mut memory) else { continue };
            let tolerance = self.settings.tolerance;
            if errors.position.norm() > tolerance || errors.orientation.norm() > tolerance {
                continue;
            }
            let broken = self.broken(&q, &mut memory);
            if best.as_ref().is_none_or(|(count, _)| broken.len() < *count) {
                best = Some((broken.len(), broken));
            }
        }
        best.map_or(Vec::new(), |(_, names)| names)
    }

    /// Names of the variables, and of the joints without a variable, whose limits a configuration breaks.
    fn broken(&self, q: &[f64], memory: &mut Memory) -> Vec<String> {
        let model = self.problem.geometry.model;
        let mut names = Vec::new();
        for (k, variable) in model.variables.iter().enumerate() {
            let mut alone = self.first.clone();
            alone.iter_mut().zip(&self.problem.limits).for_each(|(v, [low, high])| *v = v.max(*low).min(*high));
            alone[k] = q[k];
            if !self.bring_back(&mut alone) {
                names.push(variable.name.clone());
            }
        }
        if self.problem.errors(q, memory).is_some() {
            names.extend(beyond_limits(model, q, &memory.placements).map(|beyond| beyond.name.to_owned()));
            let boxes = entered(self.problem.geometry, &memory.placements)
                .map(|entered| format!("keep_out `{}`", entered.keep_out));
            names.extend(boxes);
            names.dedup();
        }
        names
    }
}

/// A start of a descent.
enum Start {
    /// `from`, or the middle of the limits.
    Given,
    /// A point of the variables' box, from the stream of this number.
    Random(u64),
}
