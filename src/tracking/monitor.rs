//! Check by check: is the robot still the one of the checks before?
//!
//! Each check spends an equal part of the level of a year. It asks, of the checks since the last change: did a step occur at
//! this check or at one of the two before; does a line through all checks rise; each for every parameter alone and for all
//! together; and does this fit leave more than the earlier ones. The part is divided by the number of these tests (Bonferroni),
//! so that a robot that stands still raises an alarm in a year with at most that level, whatever the correlations.
//!
//! After a change comparison starts anew at it, so that each change is told once.

use nalgebra::DVector;

use super::check::Check;
use super::contrast::{Amount, Contrast, Scaled, inverse, p_of_t2};
use super::error::TrackingError;
use super::settings::Settings;
use crate::math::quantiles::f_tail;

/// How a change goes with time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// At once, between the check before and this one.
    Step {
        /// First check after it.
        at: usize,
    },
    /// Steadily, from one check to another.
    Line {
        /// First check of the line.
        from: usize,
    },
    /// No constant: the fit leaves more than before.
    Residuals,
}

/// A change that a check shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// How it goes with time.
    pub shape: Shape,
    /// Which parameters changed and by how much: by steps, or in a unit of time. SI.
    pub changes: Vec<Amount>,
    /// Parameters any of which alone would explain it nearly as well as the one named.
    pub rivals: Vec<usize>,
    /// Whether the fit leaves more than the earlier ones.
    pub worse: bool,
    /// Smallest probability among the tests, to be compared with [`Settings::of_test`].
    pub p: f64,
}

/// What one check says.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// T2 of its difference from the mean of the checks before it, since the last change.
    pub t2: Option<f64>,
    /// Value that T2 passes at the level of one test.
    pub limit: Option<f64>,
    /// Probability of such a T2 by chance.
    pub p: Option<f64>,
    /// What has changed, where that is shown.
    pub event: Option<Event>,
    /// Probability of the change of base, and of tool, from the check before; `None` where one of the two does not estimate it.
    pub placed: [Option<f64>; 2],
}

impl Finding {
    /// Whether this check shows a change of the robot.
    pub fn alarm(&self) -> bool {
        self.event.is_some()
    }
}

/// All checks, compared.
#[derive(Debug, Clone)]
pub struct History {
    /// Of each check.
    pub findings: Vec<Finding>,
    /// First check of those that the next one is compared with.
    pub since: usize,
    /// Size of one in which parameters were compared: the first check's deviations.
    pub(super) scale: DVector<f64>,
    /// Estimates in that size.
    pub(super) scaled: Vec<Scaled>,
}

/// Compares checks of the same parameters, in the order of time.
///
/// # Errors
/// [`TrackingError::OneCheck`], [`TrackingError::Singular`].
pub fn monitor(checks: &[Check], settings: &Settings) -> Result<History, TrackingError> {
    let Some(first) = checks.first().filter(|_| checks.len() > 1) else { return Err(TrackingError::OneCheck) };
    let scale = first.robot.covariance.diagonal().map(|variance| variance.max(f64::MIN_POSITIVE).sqrt());
    let scaled: Vec<Scaled> = checks.iter().map(|check| in_sizes(check, &scale)).collect::<Result<_, _>>()?;
    let mut since = 0;
    let mut findings = Vec::with_capacity(checks.len());
    for k in 0..checks.len() {
        let singular = || TrackingError::Singular { check: checks.get(k).map_or_else(String::new, |c| c.name.clone()) };
        let finding = Asked { checks, scaled: &scaled, settings, since, now: k }.finding().ok_or_else(singular)?;
        if let Some(event) = &finding.event {
            since = match event.shape {
                Shape::Step { at } => at,
                Shape::Line { .. } | Shape::Residuals => k,
            };
        }
        findings.push(finding);
    }
    // Changes are told in SI.
    for change in findings.iter_mut().filter_map(|found| found.event.as_mut()).flat_map(|event| &mut event.changes) {
        let size = scale.get(change.parameter).copied().unwrap_or(1.0);
        change.change *= size;
        change.sigma *= size;
    }
    Ok(History { findings, since, scale, scaled })
}

fn in_sizes(check: &Check, scale: &DVector<f64>) -> Result<Scaled, TrackingError> {
    let robot = &check.robot;
    let values = robot.values.component_div(scale);
    let covariance = robot.covariance.component_div(&(scale * scale.transpose()));
    let information = inverse(&covariance).ok_or_else(|| TrackingError::Singular { check: check.name.clone() })?;
    Ok(Scaled { time: check.time, values, covariance, information, freedom: robot.freedom })
}

/// One check, and those it is compared with.
struct Asked<'a> {
    checks: &'a [Check],
    scaled: &'a [Scaled],
    settings: &'a Settings,
    since: usize,
    now: usize,
}

impl Asked<'_> {
    fn finding(&self) -> Option<Finding> {
        let placed = self.placed();
        if self.now == self.since {
            return Some(Finding { t2: None, limit: None, p: None, event: None, placed });
        }
        let last = self.contrast(Shape::Step { at: self.now })?;
        let level = self.settings.of_test(last.parameters());
        let (t2, freedom) = (last.t2(), last.freedom());
        Some(Finding {
            t2: Some(t2),
            limit: Some(limit(last.parameters(), freedom, level)),
            p: Some(last.p_of_all()),
            event: self.event(level)?,
            placed,
        })
    }

    /// The comparison that a shape asks for.
    fn contrast(&self, shape: Shape) -> Option<Contrast> {
        let own = self.scaled.get(self.since..=self.now)?;
        match shape {
            Shape::Step { at } => {
                let (before, after) = own.split_at_checked(at.checked_sub(self.since)?)?;
                Contrast::step(before, after)
            }
            Shape::Line { .. } => Contrast::line(own),
            Shape::Residuals => None,
        }
    }

    /// The change that is shown at this level of each test; an inner `None` where none is, an outer one where a covariance is singular.
    fn event(&self, level: f64) -> Option<Option<Event>> {
        let worse = self.p_of_residuals().filter(|p| *p < level);
        let mut best: Option<(f64, Shape)> = None;
        for shape in self.shapes(self.settings.steps) {
            let contrast = self.contrast(shape)?;
            let each = contrast.p_of_each(&[])?;
            let p = each.into_iter().chain([contrast.p_of_all()]).fold(1.0, f64::min);
            if p < level && best.is_none_or(|(known, _)| p < known) {
                best = Some((p, shape));
            }
        }
        let Some((p, shape)) = best else {
            let event = worse.map(|p| Event {
                shape: Shape::Residuals,
                changes: Vec::new(),
                rivals: Vec::new(),
                worse: true,
                p,
            });
            return Some(event);
        };
        let chosen = self.chosen(&self.contrast(shape)?, level)?;
        // When, and whether at once, is what explains most with these parameters.
        let mut best = (f64::NEG_INFINITY, shape);
        for shape in self.shapes(usize::MAX) {
            let gain = self.contrast(shape)?.gain(&chosen)?;
            if gain > best.0 {
                best = (gain, shape);
            }
        }
        let shape = best.1;
        let contrast = self.contrast(shape)?;
        let chosen = self.chosen(&contrast, level)?;
        let rivals = self.rivals(&contrast, &chosen)?;
        let changes = contrast.amounts(&chosen)?;
        Some(Some(Event { shape, changes, rivals, worse: worse.is_some(), p: p.min(worse.unwrap_or(1.0)) }))
    }

    /// Shapes with steps at the last so many checks.
    fn shapes(&self, steps: usize) -> Vec<Shape> {
        let earliest = (self.since + 1).max((self.now + 1).saturating_sub(steps));
        let mut shapes: Vec<Shape> = (earliest..=self.now).map(|at| Shape::Step { at }).collect();
        if self.now + 1 - self.since >= self.settings.line {
            shapes.push(Shape::Line { from: self.since });
        }
        shapes
    }

    /// Parameters that change: the strongest, then others as long as one is significant beside those, or what is left is.
    fn chosen(&self, contrast: &Contrast, level: f64) -> Option<Vec<usize>> {
        let mut chosen = Vec::new();
        while chosen.len() < contrast.parameters() {
            let each = contrast.p_of_each(&chosen)?;
            let left = (contrast.parameters() - chosen.len()) as f64;
            let best = each.iter().enumerate().filter(|(k, _)| !chosen.contains(k)).min_by(|a, b| a.1.total_cmp(b.1));
            let Some((parameter, p)) = best else { break };
            let is_shown = p * left < self.settings.of_check() || contrast.p_of_rest(&chosen)? < level;
            if !is_shown && !chosen.is_empty() {
                break;
            }
            chosen.push(parameter);
        }
        chosen.sort_unstable();
        Some(chosen)
    }

    /// Parameters that explain nearly as much as a single one that was chosen.
    fn rivals(&self, contrast: &Contrast, chosen: &[usize]) -> Option<Vec<usize>> {
        let [own] = chosen else { return Some(Vec::new()) };
        let most = contrast.gain(chosen)?;
        let mut found: Vec<(usize, f64)> = Vec::new();
        for other in (0..contrast.parameters()).filter(|other| other != own) {
            let gain = contrast.gain(&[other])?;
            if gain > most - self.settings.rival {
                found.push((other, gain));
            }
        }
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        Some(found.into_iter().map(|(other, _)| other).collect())
    }

    /// Probability that the residuals of this check are greater than those before by chance.
    fn p_of_residuals(&self) -> Option<f64> {
        let now = self.checks.get(self.now)?.residuals?;
        let before = self.checks.get(self.since..self.now)?.iter().filter_map(|check| check.residuals);
        let (mut squares, mut freedom) = (0.0, 0.0);
        for residuals in before.filter(|before| before.stated == now.stated) {
            squares += residuals.ratio.powi(2) * residuals.freedom;
            freedom += residuals.freedom;
        }
        (freedom > 0.0).then(|| f_tail(now.ratio.powi(2) * freedom / squares, now.freedom, freedom))
    }

    /// Probability of the differences of base and of tool from the check before.
    fn placed(&self) -> [Option<f64>; 2] {
        let of = |which: usize| {
            let before = self.checks.get(self.now.checked_sub(1)?)?.placed.get(which)?.as_ref()?;
            let now = self.checks.get(self.now)?.placed.get(which)?.as_ref()?;
            let common: Vec<String> = now.names.iter().filter(|name| before.names.contains(name)).cloned().collect();
            let (before, now) = (before.only(&common)?, now.only(&common)?);
            let difference = &now.values - &before.values;
            let covariance = &now.covariance + &before.covariance;
            let scale = covariance.diagonal().map(|variance| variance.max(f64::MIN_POSITIVE).sqrt());
            let inverse = inverse(&covariance.component_div(&(&scale * scale.transpose())))?;
            let difference = difference.component_div(&scale);
            let t2 = difference.dot(&(inverse * &difference));
            Some(p_of_t2(t2, common.len(), now.freedom.min(before.freedom)))
        };
        [of(0), of(1)]
    }
}

/// The T2 whose probability is `level`, by bisection.
fn limit(parameters: usize, freedom: f64, level: f64) -> f64 {
    root(|t2| p_of_t2(t2, parameters, freedom) - level)
}

/// Where a falling function passes zero, from 0 upwards.
pub fn root(falling: impl Fn(f64) -> f64) -> f64 {
    let mut ends = [0.0, 1.0];
    while falling(ends[1]) > 0.0 && ends[1] < 1e12 {
        ends = [ends[1], 2.0 * ends[1]];
    }
    for _ in 0..60 {
        let middle = 0.5 * (ends[0] + ends[1]);
        if falling(middle) > 0.0 { ends[0] = middle } else { ends[1] = middle }
    }
    0.5 * (ends[0] + ends[1])
}
