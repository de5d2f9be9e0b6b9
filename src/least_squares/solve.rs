//! The iteration.

use nalgebra::{DMatrix, DVector};

use super::bounds::Bounds;
use super::box_step::Region;
use super::linear::{Linear, Reduced, Step};
use super::loss::Losses;
use super::problem::{EvaluationError, Problem};
use super::settings::{Progress, Settings};
use super::solution::{Solution, Status, UsageError};
use super::trust_region::{GOOD, TrustRegion};

/// Largest correction of a step for curvature, as a part of the step.
const BEND: f64 = 0.5;

/// Cosine of a slope that is slight, when nothing better can be had.
const SLIGHT: f64 = 1e-4;

/// A reduction so many times larger than expected is no sign of the end, however small it is.
const SURPRISE: f64 = 10.0;

/// Minimises the cost of `problem` from `start` (n) within `bounds`.
///
/// A start outside the bounds is moved to the nearest point inside. Everything is sequential: the same question gives the
/// same answer.
///
/// # Errors
/// [`UsageError`] when the question is malformed: wrong lengths, a start that is not finite, bounds that leave no value, a
/// setting out of range, an array of the wrong shape from the problem. A disappointing answer is no error but a
/// [`Status`].
pub fn minimize(
    problem: &impl Problem,
    start: &[f64],
    bounds: &Bounds,
    settings: &Settings,
) -> Result<Solution, UsageError> {
    minimize_observed(problem, start, bounds, settings, &mut |_| {})
}

/// As [`minimize`], calling `observer` with every step tried.
///
/// # Errors
/// As [`minimize`].
pub fn minimize_observed(
    problem: &impl Problem,
    start: &[f64],
    bounds: &Bounds,
    settings: &Settings,
    observer: &mut dyn FnMut(&Progress),
) -> Result<Solution, UsageError> {
    check(problem, start, bounds, settings)?;
    let mut x = start.to_vec();
    bounds.clamp(&mut x);
    let mut search = Search::new(problem, bounds, settings, x);
    let linear = search.begin()?.map_err(UsageError::NoStart)?;
    let status = search.run(linear, observer)?;
    Ok(search.finish(status))
}

fn check(problem: &impl Problem, start: &[f64], bounds: &Bounds, settings: &Settings) -> Result<(), UsageError> {
    let expected = problem.parameters();
    let length = |what, found| {
        if found == expected { Ok(()) } else { Err(UsageError::Length { what, expected, found }) }
    };
    length("start", start.len())?;
    length("lower bounds", bounds.lower.len())?;
    length("upper bounds", bounds.upper.len())?;
    bounds.check()?;
    settings.check()?;
    match start.iter().enumerate().find(|(_, value)| !value.is_finite()) {
        Some((index, &value)) => Err(UsageError::Start { index, value }),
        None => Ok(()),
    }
}

/// Outer error: the caller's mistake. Inner error: no value at this point.
type Attempt<T> = Result<Result<T, EvaluationError>, UsageError>;

struct Search<'a, P> {
    problem: &'a P,
    bounds: &'a Bounds,
    settings: &'a Settings,
    losses: Losses,
    x: Vec<f64>,
    residual: DVector<f64>,
    jacobian: DMatrix<f64>,
    cost: f64,
    initial_cost: f64,
    region: TrustRegion,
    // Where a step is tried before it is taken.
    trial_residual: DVector<f64>,
    trial_jacobian: DMatrix<f64>,
    // Recycled by the reductions.
    memory: Vec<f64>,
    iterations: usize,
    evaluations: usize,
    jacobian_evaluations: usize,
}

impl<'a, P: Problem> Search<'a, P> {
    fn new(problem: &'a P, bounds: &'a Bounds, settings: &'a Settings, x: Vec<f64>) -> Self {
        let (m, n) = (problem.residuals(), problem.parameters());
        Self {
            problem,
            bounds,
            settings,
            losses: Losses::new(problem, settings.loss),
            x,
            residual: DVector::from_element(m, f64::NAN),
            jacobian: DMatrix::from_element(m, n, f64::NAN),
            cost: f64::NAN,
            initial_cost: f64::NAN,
            region: TrustRegion::new(&DVector::zeros(n), 0.0, &vec![0.0; n], settings.initial_radius),
            trial_residual: DVector::zeros(m),
            trial_jacobian: DMatrix::zeros(m, n),
            memory: Vec::new(),
            iterations: 0,
            evaluations: 0,
            jacobian_evaluations: 0,
        }
    }

    fn begin(&mut self) -> Attempt<Linear> {
        let x = self.x.clone();
        let reduced = match self.reduce(&x)? {
            Ok(reduced) => reduced,
            Err(reason) => return Ok(Err(reason)),
        };
        self.region = TrustRegion::new(&reduced.norms(), reduced.residual_norm, &x, self.settings.initial_radius);
        let linear = reduced.scaled(&self.region.scale, &x, self.bounds, self.problem.rounding());
        self.take(x);
        self.initial_cost = self.cost;
        Ok(Ok(linear))
    }

    /// Tries steps until a test is met.
    fn run(&mut self, mut linear: Linear, observer: &mut dyn FnMut(&Progress)) -> Result<Status, UsageError> {
        loop {
            if let Some(status) = self.ended(&linear) {
                return Ok(status);
            }
            let region = self.region.region(&self.x, self.bounds);
            let radius = self.region.radius;
            let step = linear.step(&region, radius);
            let end = self.region.apply(&self.x, &step.z, self.bounds);
            let negligible = self.negligible(&linear, &step);
            if end == self.x || step.reduction <= 0.0 {
                return Ok(negligible.unwrap_or(stopped(&linear, &step)));
            }
            self.iterations += 1;
            let mut trial = self.evaluate(end)?;
            if trial.as_ref().is_some_and(|trial| trial.reduction < GOOD * step.reduction) && negligible.is_none() {
                trial = self.bent(trial, &linear, &step, &region)?;
            }
            let reduction = trial.as_ref().map(|trial| trial.reduction);
            // Below the rounding of the cost a good step and a bad one look alike; the prediction is still good, so such a
            // step is taken, but after a failure it is the last.
            let hidden = is_hidden(&linear, &step);
            let unseen = if hidden { linear.visible() } else { 0.0 };
            let last = negligible.is_some() || hidden;
            let succeeds = |reduction: f64| TrustRegion::accepts(reduction / step.reduction);
            let worthwhile = |trial: &Trial| succeeds(trial.reduction) || last && trial.reduction >= -unseen;
            let next = match trial.filter(worthwhile) {
                Some(trial) => self.advance(trial.x)?,
                None => Next::Stay,
            };
            observer(&Progress {
                iteration: self.iterations,
                cost: self.cost,
                step: step.length,
                radius,
                gain: reduction.map(|reduction| reduction / step.reduction),
                accepted: matches!(next, Next::Moved(_)),
            });
            let (Some(reduction), Next::Moved(_) | Next::Stay) = (reduction, &next) else {
                // The derivative may fail where the residual does not: that is the edge of the domain too.
                self.region.retreat(&step);
                continue;
            };
            self.region.adapt(&step, reduction);
            if let Next::Moved(moved) = next {
                self.memory = std::mem::replace(&mut linear, *moved).recycle();
            }
            // A step that achieves far more than it promised was no sign of the end.
            let surprise = reduction > SURPRISE * step.reduction.max(self.settings.cost_tolerance * self.cost);
            if let Some(status) = negligible.filter(|_| !surprise) {
                return Ok(status);
            }
            if hidden && !succeeds(reduction) {
                return Ok(Status::Cost);
            }
        }
    }

    /// Why no step is to be tried from here.
    fn ended(&self, linear: &Linear) -> Option<Status> {
        if self.cost <= self.settings.cost_floor {
            Some(Status::PerfectFit)
        } else if linear.cosine() <= self.settings.gradient_tolerance {
            Some(Status::Gradient)
        } else {
            (self.iterations >= self.settings.max_iterations).then_some(Status::IterationLimit)
        }
    }

    /// The better of a step that disappointed and the same step corrected for the curvature that it revealed.
    fn bent(
        &mut self,
        straight: Option<Trial>,
        linear: &Linear,
        step: &Step,
        region: &Region,
    ) -> Result<Option<Trial>, UsageError> {
        let Some(straight) = straight else { return Ok(None) };
        let shift = DVector::from_iterator(self.x.len(), straight.x.iter().zip(&self.x).map(|(end, x)| end - x));
        let curvature = &straight.residual - &self.residual - &self.jacobian * shift;
        let z = linear.bent_step(curvature, region, self.region.radius);
        // Where the bend is as large as the step, third derivatives dominate and the correction is not to be trusted.
        if (&z - &step.z).norm() > BEND * step.length {
            return Ok(Some(straight));
        }
        let bent = self.evaluate(self.region.apply(&self.x, &z, self.bounds))?;
        Ok([Some(straight), bent].into_iter().flatten().max_by(|a, b| a.reduction.total_cmp(&b.reduction)))
    }

    /// The residual at `x`; `None` where the model has no value.
    fn evaluate(&mut self, x: Vec<f64>) -> Result<Option<Trial>, UsageError> {
        self.evaluations += 1;
        let mut residual = DVector::zeros(self.problem.residuals());
        if evaluate(self.problem, &x, &mut residual, None)?.is_err() {
            return Ok(None);
        }
        let reduction = self.losses.reduction(&self.residual, &residual);
        Ok(reduction.is_finite().then_some(Trial { x, residual, reduction }))
    }

    /// Moves to `x` if the derivative exists there.
    fn advance(&mut self, x: Vec<f64>) -> Result<Next, UsageError> {
        Ok(match self.reduce(&x)? {
            Ok(reduced) => {
                self.region.rescale(&reduced.norms());
                let linear = reduced.scaled(&self.region.scale, &x, self.bounds, self.problem.rounding());
                self.take(x);
                Next::Moved(Box::new(linear))
            }
            Err(_) => Next::NoValue,
        })
    }

    /// Residual and Jacobian at `x` into the trial buffers, and their reduced form.
    fn reduce(&mut self, x: &[f64]) -> Attempt<Reduced> {
        self.jacobian_evaluations += 1;
        if let Err(reason) = evaluate(self.problem, x, &mut self.trial_residual, Some(&mut self.trial_jacobian))? {
            return Ok(Err(reason));
        }
        let weights = self.losses.weights(&self.trial_residual);
        let memory = std::mem::take(&mut self.memory);
        let reduced = Reduced::new(&self.trial_jacobian, &self.trial_residual, weights.as_ref(), memory);
        let cost = self.losses.cost(&self.trial_residual);
        Ok(reduced
            .filter(|_| cost.is_finite())
            .ok_or_else(|| EvaluationError::new("the squares of the residuals or derivatives overflow")))
    }

    /// Makes the trial the current point.
    fn take(&mut self, x: Vec<f64>) {
        self.x = x;
        std::mem::swap(&mut self.residual, &mut self.trial_residual);
        std::mem::swap(&mut self.jacobian, &mut self.trial_jacobian);
        self.cost = self.losses.cost(&self.residual);
    }

    /// Whether this step, or any step from here, is too small to matter.
    fn negligible(&self, linear: &Linear, step: &Step) -> Option<Status> {
        if promised(linear, step) <= self.settings.cost_tolerance * self.cost {
            return Some(Status::Cost);
        }
        let small = step.length <= self.settings.step_tolerance * self.region.size(&self.x);
        (small && !step.limited).then_some(Status::Step)
    }

    fn finish(self, status: Status) -> Solution {
        let weights =
            self.losses.weights(&self.residual).unwrap_or_else(|| DVector::from_element(self.residual.len(), 1.0));
        Solution {
            gradient: self.jacobian.tr_mul(&weights.component_mul(&self.residual)),
            at_bound: self.bounds.touched(&self.x),
            x: self.x,
            residual: self.residual,
            jacobian: self.jacobian,
            weights,
            cost: self.cost,
            initial_cost: self.initial_cost,
            iterations: self.iterations,
            evaluations: self.evaluations,
            jacobian_evaluations: self.jacobian_evaluations,
            status,
        }
    }
}

/// The reduction of the cost to hope for.
fn promised(linear: &Linear, step: &Step) -> f64 {
    // A step cut short by the radius does not show how far the minimum is; the full step still does.
    if step.limited { linear.best_reduction } else { step.reduction }
}

/// Why a step that leads nowhere ends the search.
fn stopped(linear: &Linear, step: &Step) -> Status {
    match (step.limited, linear.cosine() <= SLIGHT) {
        (false, _) => Status::Step,
        (true, true) => Status::Cost,
        (true, false) => Status::Stalled,
    }
}

/// Whether rounding hides what this step does to the cost, at a place that is nearly stationary.
fn is_hidden(linear: &Linear, step: &Step) -> bool {
    let visible = linear.visible();
    // Where the residuals are large and curved the full step overshoots: the radius shrinks with the distance to the
    // minimum, and its steps vanish in the noise while the full step still promises much (for ever so at a minimum of n
    // residuals that is not a zero, where the Jacobian is singular). A wrong derivative ends in the same way, but not
    // with a small slope.
    promised(linear, step) <= visible || step.reduction <= visible && linear.cosine() <= SLIGHT
}

/// A point that might be next.
struct Trial {
    x: Vec<f64>,
    residual: DVector<f64>,
    /// By how much it lowers the cost.
    reduction: f64,
}

/// What became of a trial.
enum Next {
    Moved(Box<Linear>),
    Stay,
    NoValue,
}

/// Calls the problem and checks what it hands back.
fn evaluate(
    problem: &impl Problem,
    x: &[f64],
    residual: &mut DVector<f64>,
    mut jacobian: Option<&mut DMatrix<f64>>,
) -> Attempt<()> {
    let (m, n) = (problem.residuals(), problem.parameters());
    if let Err(reason) = problem.evaluate(x, residual, jacobian.as_deref_mut()) {
        return Ok(Err(reason));
    }
    if residual.len() != m {
        return Err(UsageError::Shape { what: "residual", expected: (m, 1), found: (residual.len(), 1) });
    }
    if let Some(row) = residual.iter().position(|r| !r.is_finite()) {
        return Ok(Err(EvaluationError::new(format!("residual {row} is {}", residual[row]))));
    }
    let Some(jacobian) = jacobian else { return Ok(Ok(())) };
    if jacobian.shape() != (m, n) {
        return Err(UsageError::Shape { what: "Jacobian", expected: (m, n), found: jacobian.shape() });
    }
    Ok(match jacobian.iter().position(|d| !d.is_finite()) {
        // Column by column; a position exists, so m is not 0.
        Some(at) => Err(EvaluationError::new(format!(
            "derivative of residual {} by parameter {} is {}",
            at % m,
            at / m,
            jacobian[at]
        ))),
        None => Ok(()),
    })
}
