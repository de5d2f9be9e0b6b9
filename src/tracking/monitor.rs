//! Check by check: is the robot still the one of the checks before?
//!
//! Each check spends an equal part of the level of a year. It asks, of the checks since the last change: did a step occur at
//! this check or at one of the two before; does a line through all checks rise; each for every parameter alone and for all
//! together; and does this fit leave more than the earlier ones. The part is divided by the number of these tests (Bonferroni),
//! so that a robot that stands still raises an alarm in a year with at most that level, whatever the correlations.
//!
//! After a jump comparison starts anew at it, so that each change is reported once. After growth the next checks are compared with the
//! line as it goes on. When growth was first reported as jumps, which two or three checks cannot tell from it, a later check that shows
//! more of it tells the growth in their place, if a line explains the checks since as well as the jumps do: by Schwarz's criterion
//! (*Ann. Stat.* 6, 1978) `chi2 + q ln n` of `n` checks, in which each size, slope and time of a change counts in `q`.

use nalgebra::DVector;

use super::check::Check;
use super::contrast::{Amount, Contrast, Scaled, inverse, misfit, p_of_t2};
use super::error::TrackingError;
use super::settings::Settings;
use super::stretch::{Stretch, Term};
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
    /// Of growth: whether it is a new rate of what grew before.
    pub bent: bool,
    /// Of growth: checks at which it was reported as jumps.
    pub revises: Vec<usize>,
    /// Of a jump: the check at which it turns out to be part of growth.
    pub part_of: Option<usize>,
}

impl Event {
    /// Parameters that changed or cannot be distinguished from the one that did.
    fn suspects(&self) -> impl Iterator<Item = usize> {
        self.changes.iter().map(|change| change.parameter).chain(self.rivals.iter().copied())
    }

    /// How a parameter changes.
    fn change(&self, parameter: usize) -> Option<f64> {
        self.changes.iter().find(|change| change.parameter == parameter).map(|change| change.change)
    }

    /// Whether a jump may be part of this growth: of a constant that grows or cannot be distinguished from it, and not the other way.
    fn has_part(&self, jump: &Event) -> bool {
        let is_against = |change: &Amount| self.change(change.parameter).is_some_and(|own| own * change.change < 0.0);
        self.suspects().any(|own| jump.suspects().any(|theirs| own == theirs)) && !jump.changes.iter().any(is_against)
    }
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
    /// What the next check is compared with.
    pub(super) stretch: Stretch,
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
    let start = &first.robot.values;
    let scaled: Vec<Scaled> = checks.iter().map(|check| in_sizes(check, start, &scale)).collect::<Result<_, _>>()?;
    let mut asked = Asked {
        checks,
        scaled: &scaled,
        settings,
        stretch: Stretch::level(0),
        jumps: Vec::new(),
        fitted_since: 0,
        now: 0,
    };
    let mut findings: Vec<Finding> = Vec::with_capacity(checks.len());
    for k in 0..checks.len() {
        asked.now = k;
        let singular = || TrackingError::Singular { check: checks.get(k).map_or_else(String::new, |c| c.name.clone()) };
        let finding = asked.finding().ok_or_else(singular)?;
        if let Some(event) = &finding.event {
            for part in &event.revises {
                if let Some(jump) = findings.get_mut(*part).and_then(|found| found.event.as_mut()) {
                    jump.part_of = Some(k);
                }
            }
            asked.go_on(event);
        }
        findings.push(finding);
    }
    let stretch = asked.stretch;
    // Changes are reported in SI.
    for change in findings.iter_mut().filter_map(|found| found.event.as_mut()).flat_map(|event| &mut event.changes) {
        let size = scale.get(change.parameter).copied().unwrap_or(1.0);
        change.change *= size;
        change.sigma *= size;
    }
    Ok(History { findings, since: stretch.since(), stretch, scale, scaled })
}

/// Estimates less those of the start, which keeps digits.
fn in_sizes(check: &Check, start: &DVector<f64>, scale: &DVector<f64>) -> Result<Scaled, TrackingError> {
    let robot = &check.robot;
    let values = (&robot.values - start).component_div(scale);
    let covariance = robot.covariance.component_div(&(scale * scale.transpose()));
    let information = inverse(&covariance).ok_or_else(|| TrackingError::Singular { check: check.name.clone() })?;
    Ok(Scaled { time: check.time, values, covariance, information, freedom: robot.freedom })
}

/// A jump that was reported, and what was expected before it.
struct Jump {
    before: Stretch,
    reported: usize,
    event: Event,
}

/// One check, and those it is compared with.
struct Asked<'a> {
    checks: &'a [Check],
    scaled: &'a [Scaled],
    settings: &'a Settings,
    /// What the checks are expected to show.
    stretch: Stretch,
    /// Jumps since growth was reported.
    jumps: Vec<Jump>,
    /// First check with whose residuals those of this one are compared.
    fitted_since: usize,
    now: usize,
}

impl Asked<'_> {
    fn finding(&self) -> Option<Finding> {
        let placed = self.placed();
        if self.now == self.stretch.since() {
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

    /// Takes what is expected after an event of this check.
    fn go_on(&mut self, event: &Event) {
        self.fitted_since = self.now;
        match event.shape {
            Shape::Step { at } => {
                self.fitted_since = at;
                let after = self.stretch.after_jump(at);
                let before = std::mem::replace(&mut self.stretch, after);
                self.jumps.push(Jump { before, reported: self.now, event: event.clone() });
            }
            Shape::Residuals => {
                self.stretch = self.stretch.after_jump(self.now);
                self.jumps.clear();
            }
            Shape::Line { from } => {
                if from != self.stretch.from() || !event.revises.is_empty() {
                    let known = if event.bent { self.stretch.grows().to_vec() } else { Vec::new() };
                    self.stretch = Stretch::growing(from, known);
                }
                // Were another of those the one that grows, its slope would be missing.
                self.stretch.grow(&event.suspects().collect::<Vec<_>>());
                self.jumps.clear();
            }
        }
    }

    /// The comparison that a shape asks for, of the present stretch.
    fn contrast(&self, shape: Shape) -> Option<Contrast> {
        self.contrast_of(&self.stretch, shape)
    }

    /// The comparison that a shape asks for, of the checks from a stretch on.
    fn contrast_of(&self, stretch: &Stretch, shape: Shape) -> Option<Contrast> {
        let own = self.scaled.get(stretch.from()..=self.now)?;
        let goes_on = matches!(shape, Shape::Line { from } if from == stretch.from());
        let size = own.first()?.values.len();
        // What grows along this line already has its slope.
        let of: Vec<usize> = (0..size).filter(|k| !(goes_on && stretch.grows().contains(k))).collect();
        let expected = stretch.expected(self.scaled, self.now, &[])?;
        Contrast::new(own, &expected, &of, &self.course(stretch, shape)?)
    }

    /// The course of a shape at the checks from a stretch on.
    fn course(&self, stretch: &Stretch, shape: Shape) -> Option<Vec<f64>> {
        let times = (stretch.from()..=self.now).map(|k| Some((k, self.scaled.get(k)?.time)));
        let start = match shape {
            Shape::Line { from } => self.scaled.get(from)?.time,
            Shape::Step { .. } | Shape::Residuals => 0.0,
        };
        let of = |(k, time): (usize, f64)| match shape {
            Shape::Step { at } => f64::from(u8::from(k >= at)),
            Shape::Line { .. } => (time - start).max(0.0),
            Shape::Residuals => 0.0,
        };
        times.map(|time| time.map(of)).collect()
    }

    /// The change that is shown at this level of each test; an inner `None` where none is, an outer one where a covariance is singular.
    fn event(&self, level: f64) -> Option<Option<Event>> {
        let worse = self.p_of_residuals().filter(|p| *p < level);
        let mut best: Option<(f64, Shape)> = None;
        for shape in self.shapes(self.settings.steps) {
            let contrast = self.contrast(shape)?;
            let each = contrast.p_of_each(&[])?.into_iter().map(|(_, p)| p);
            let p = each.chain([contrast.p_of_all()]).fold(1.0, f64::min);
            if p < level && best.is_none_or(|(known, _)| p < known) {
                best = Some((p, shape));
            }
        }
        let reported = |shape: Shape, p: f64| Event {
            shape,
            changes: Vec::new(),
            rivals: Vec::new(),
            worse: worse.is_some(),
            p: p.min(worse.unwrap_or(1.0)),
            bent: false,
            revises: Vec::new(),
            part_of: None,
        };
        let Some((p, shape)) = best else { return Some(worse.map(|p| reported(Shape::Residuals, p))) };
        let chosen = self.chosen(&self.contrast(shape)?, level)?;
        // When, and whether at once, is what explains most with these parameters.
        let mut best = (f64::NEG_INFINITY, shape);
        for shape in self.shapes(usize::MAX).into_iter().chain(self.bends(&chosen)) {
            // A line is of those that do not grow yet.
            let gain = self.contrast(shape)?.gain(&chosen).unwrap_or(f64::NEG_INFINITY);
            if gain > best.0 {
                best = (gain, shape);
            }
        }
        let shape = best.1;
        let event = self.described(&self.stretch, reported(shape, p), level)?;
        Some(Some(self.grown(&event, level).unwrap_or(event)))
    }

    /// An event of a shape with what changes, by the checks from a stretch on.
    fn described(&self, stretch: &Stretch, event: Event, level: f64) -> Option<Event> {
        let contrast = self.contrast_of(stretch, event.shape)?;
        let chosen = self.chosen(&contrast, level)?;
        let rivals = self.rivals(&contrast, &chosen)?;
        let bent = match event.shape {
            Shape::Line { from } => {
                (from != stretch.from() && chosen.iter().any(|own| stretch.grows().contains(own))).then_some(from)
            }
            Shape::Step { .. } | Shape::Residuals => None,
        };
        let changes = match bent {
            // The new rate, and not by how much it differs from the one before.
            Some(from) => self.contrast_of(&Stretch::level(from), Shape::Line { from })?.amounts(&chosen)?,
            None => contrast.amounts(&chosen)?,
        };
        Some(Event { changes, rivals, bent: bent.is_some(), ..event })
    }

    /// Growth in the place of jumps that were reported and of what this check shows, where a line explains them as well.
    fn grown(&self, event: &Event, level: f64) -> Option<Event> {
        self.jumps.iter().enumerate().find_map(|(first, jump)| {
            let before = &jump.before;
            let replaced = self.jumps.get(first..)?;
            let reported: Vec<&Event> = replaced.iter().map(|jump| &jump.event).chain([event]).collect();
            let known = (self.now + 1 - before.from()) as f64;
            // Each parameter has a size or slope, and all of an event one time.
            let as_reported = self.misfit_of(before, &reported)?
                + reported.iter().map(|event| event.changes.len() + 1).sum::<usize>() as f64 * known.ln();
            let mut best: Option<(f64, Event)> = None;
            for from in before.since()..self.now.saturating_sub(1) {
                // What grows already has the slope of the first check.
                if from == before.from() && !before.grows().is_empty() {
                    continue;
                }
                let line = Event { shape: Shape::Line { from }, ..event.clone() };
                let Some(line) = self.described(before, line, level) else { continue };
                let Some(left) = self.misfit_of(before, &[&line]) else { continue };
                let knee = usize::from(from != before.since());
                let criterion = left + (line.changes.len() + knee) as f64 * known.ln();
                let is_whole = reported.iter().all(|jump| line.has_part(jump));
                if is_whole && criterion <= as_reported && best.as_ref().is_none_or(|(known, _)| criterion < *known) {
                    best = Some((criterion, line));
                }
            }
            let revises = replaced.iter().map(|jump| jump.reported).collect();
            best.map(|(_, line)| Event { revises, ..line })
        })
    }

    /// Squares that events leave of the checks from a stretch on.
    fn misfit_of(&self, stretch: &Stretch, events: &[&Event]) -> Option<f64> {
        let mut terms = Vec::new();
        for event in events {
            let course = self.course(stretch, event.shape)?;
            terms.extend(
                event.changes.iter().map(|change| Term { parameter: change.parameter, course: course.clone() }),
            );
        }
        let own = self.scaled.get(stretch.from()..=self.now)?;
        misfit(own, &stretch.expected(self.scaled, self.now, &terms)?)
    }

    /// Shapes with steps at the last so many checks.
    fn shapes(&self, steps: usize) -> Vec<Shape> {
        let earliest = (self.stretch.since() + 1).max((self.now + 1).saturating_sub(steps));
        let mut shapes: Vec<Shape> = (earliest..=self.now).map(|at| Shape::Step { at }).collect();
        let from = self.stretch.from();
        let all_grow = self.scaled.first().is_some_and(|check| self.stretch.grows().len() >= check.values.len());
        if self.now + 1 - from >= self.settings.line && !all_grow {
            shapes.push(Shape::Line { from });
        }
        shapes
    }

    /// New rates, where one of those that changed was growing; from two checks on, since one is as well a jump.
    fn bends(&self, chosen: &[usize]) -> Vec<Shape> {
        if !chosen.iter().any(|own| self.stretch.grows().contains(own)) {
            return Vec::new();
        }
        let knees = self.stretch.since()..self.now.saturating_sub(1);
        knees.filter(|from| *from != self.stretch.from()).map(|from| Shape::Line { from }).collect()
    }

    /// Parameters that change: the strongest, then others as long as one is significant in addition to those, or what is left is.
    fn chosen(&self, contrast: &Contrast, level: f64) -> Option<Vec<usize>> {
        let mut chosen = Vec::new();
        while chosen.len() < contrast.parameters() {
            let each = contrast.p_of_each(&chosen)?;
            let left = each.len() as f64;
            let Some((parameter, p)) = each.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)) else { break };
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
        for &other in contrast.of().iter().filter(|other| *other != own) {
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
        let before = self.checks.get(self.fitted_since..self.now)?.iter().filter_map(|check| check.residuals);
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
