//! Selection of the hypotheses that explain the residuals together: beam search over subsets, compared by the Bayesian
//! information criterion, accepted by F tests.
//!
//! Source: Schwarz, *Estimating the dimension of a model*, Ann. Statist. 6, 1978; Miller, *Subset Selection in
//! Regression*, ch. 3 and 4.

use super::linear_problem::LinearProblem;
use super::projection::{Gain, Projection, Subset};
use super::settings::SelectionSettings;
use crate::math::quantiles::f_tail;

/// Compares and selects subsets.
pub struct Selector<'a> {
    /// The projected problem.
    pub projection: Projection<'a>,
    settings: &'a SelectionSettings,
}

impl<'a> Selector<'a> {
    /// Projects the nuisance off.
    pub fn new(problem: &'a LinearProblem, settings: &'a SelectionSettings) -> Self {
        Self { projection: Projection::new(problem), settings }
    }

    /// Fits a set of hypotheses.
    pub fn fit(&self, members: &[usize]) -> Subset {
        self.projection.fit(members)
    }

    /// Gain of every hypothesis over some, amounts in their common range.
    pub fn gains(&self, members: &[usize]) -> Vec<Gain> {
        self.projection.gains(members, self.settings.greatest_amount, self.settings.greatest_slope)
    }

    /// The same, of curves by their shapes.
    pub fn gains_of_shapes(&self, members: &[usize]) -> Vec<Gain> {
        self.projection.gains_of_shapes(members, self.settings.greatest_amount, self.settings.greatest_slope)
    }

    /// Bayesian information criterion of a fit, the greater the better; every variant tried counts.
    pub fn criterion(&self, fitted: &Subset) -> f64 {
        let n = self.projection.freedom;
        let variants = |&h: &usize| 2.0 * (self.projection.problem.hypotheses[h].variants.max(1) as f64).ln();
        let tried: f64 = fitted.members.iter().map(variants).sum();
        -n * (fitted.squares.max(f64::MIN_POSITIVE) / n).ln() - fitted.directions as f64 * n.ln() - tried
    }

    /// Probability of a gain by chance, over all hypotheses tried, `squares` being left and `used` directions fitted.
    fn chance(&self, gain: Gain, squares: f64, used: usize) -> f64 {
        let freedom = (self.projection.freedom - (used + gain.directions) as f64).max(1.0);
        let directions = gain.directions.max(1) as f64;
        let ratio = (gain.squares / directions) / (squares / freedom).max(f64::MIN_POSITIVE);
        (f_tail(ratio, directions, freedom) * self.projection.problem.named() as f64).min(1.0)
    }

    /// Whether a gain of one hypothesis alone could be chance.
    pub fn is_chance(&self, gain: Gain) -> bool {
        self.chance(gain, (self.projection.squares() - gain.squares).max(0.0), 0) >= self.settings.chance
    }

    /// The subset that explains best, as the sequence in which its members enter, from the empty one. The best few subsets
    /// of every size are extended, so that members which hide one another are found together. A subset is accepted if it
    /// gains enough over the smaller one, and every member over the others.
    pub fn search(&self, noise: Option<f64>) -> Vec<Subset> {
        let mut accepted = self.fit(&[]);
        let mut beam = vec![accepted.clone()];
        for _ in 0..self.settings.most {
            beam = self.extended(&beam);
            let Some(best) = beam.first() else { break };
            let is_hidden = best.members.len() - accepted.members.len() > 1;
            let margin = if is_hidden { self.settings.hidden_margin } else { 0.0 };
            if self.is_worth(&accepted, best, noise)
                && self.criterion(best) > self.criterion(&accepted) + margin
                && self.each_is_worth(best, noise)
            {
                accepted = best.clone();
            }
        }
        self.ordered(accepted.members)
    }

    /// The best subsets of one member more, best first; the first one cannot be bettered by an exchange.
    fn extended(&self, beam: &[Subset]) -> Vec<Subset> {
        let mut grown: Vec<Subset> = Vec::new();
        for fit in beam.iter().flat_map(|set| self.additions(&set.members, self.settings.beam)) {
            if !grown.iter().any(|known| known.is_same(&fit)) {
                grown.push(fit);
            }
        }
        grown.sort_by(|a, b| self.criterion(b).total_cmp(&self.criterion(a)));
        grown.truncate(self.settings.beam);
        if let Some(first) = grown.first().cloned() {
            let best = self.exchanged(first);
            grown.retain(|known| !known.is_same(&best));
            grown.insert(0, best);
            grown.truncate(self.settings.beam);
        }
        grown
    }

    /// The order in which members are reported: each the best addition to those before it.
    fn ordered(&self, mut left: Vec<usize>) -> Vec<Subset> {
        let mut path = vec![self.fit(&[])];
        let mut members: Vec<usize> = Vec::new();
        while !left.is_empty() {
            let with = |h: usize| self.fit(&[members.as_slice(), &[h]].concat());
            let candidates = left.iter().map(|&h| with(h)).enumerate();
            let Some((at, fit)) = candidates.min_by(|a, b| a.1.squares.total_cmp(&b.1.squares)) else { break };
            members.push(left.remove(at));
            path.push(fit);
        }
        path
    }

    /// Whether no member of a subset could be left out.
    fn each_is_worth(&self, fit: &Subset, noise: Option<f64>) -> bool {
        let is_worth = |at| self.is_worth(&self.fit(&fit.without(at)), fit, noise);
        fit.members.len() < 2 || (0..fit.members.len()).all(is_worth)
    }

    /// Whether a fit gains enough over a smaller one: not by chance, and not negligible compared with the noise.
    pub fn is_worth(&self, before: &Subset, after: &Subset, noise: Option<f64>) -> bool {
        let squares = before.squares - after.squares;
        let directions = after.directions.saturating_sub(before.directions).max(1);
        let freedom = (self.projection.freedom - after.directions as f64).max(1.0);
        let variance = (after.squares / freedom).max(noise.unwrap_or(0.0).powi(2));
        let left = after.squares.max(variance * freedom);
        self.chance(Gain { squares, directions }, left, before.directions) < self.settings.chance
            && squares / self.projection.freedom > self.settings.least_contribution.powi(2) * variance
            && self.criterion(after) > self.criterion(before)
    }

    /// A subset with one hypothesis more, from its gain.
    pub fn extended_by(&self, before: &Subset, h: usize, gain: Gain) -> Subset {
        Subset {
            members: [before.members.as_slice(), &[h]].concat(),
            squares: (before.squares - gain.squares).max(0.0),
            directions: before.directions + gain.directions,
        }
    }

    /// The best subsets of one member more, at most `count`, best first, with one variant of each effect at each site.
    fn additions(&self, members: &[usize], count: usize) -> Vec<Subset> {
        let hypotheses = &self.projection.problem.hypotheses;
        let before = self.fit(members);
        let mut all: Vec<(f64, usize, Subset)> = self
            .gains(members)
            .into_iter()
            .enumerate()
            .filter(|&(h, gain)| {
                gain.directions > 0 && !hypotheses[h].is_free() && !members.iter().any(|&m| self.excludes(m, h))
            })
            .map(|(h, gain)| {
                let fit = self.extended_by(&before, h, gain);
                (self.criterion(&fit), h, fit)
            })
            .collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut added: Vec<usize> = Vec::new();
        let mut chosen: Vec<Subset> = Vec::new();
        for (_, h, fit) in all {
            if chosen.len() < count && !added.iter().any(|&known| hypotheses[known].is_same(&hypotheses[h])) {
                added.push(h);
                chosen.push(fit);
            }
        }
        chosen
    }

    /// Whether two cannot be causes together: the same effect with the same nonlinear parameter or other constants, or two
    /// laws of one site that look alike, of which the second would only correct the shape of the first.
    pub fn excludes(&self, a: usize, b: usize) -> bool {
        let [one, other] = [a, b].map(|h| &self.projection.problem.hypotheses[h]);
        one.excludes(other)
            || one.site == other.site
                && one.effect.name() != other.effect.name()
                && self.projection.alignment(a, b) > self.settings.alike
    }

    /// Replaces single members by better ones until none is.
    fn exchanged(&self, mut fit: Subset) -> Subset {
        if fit.members.len() < 2 {
            return fit;
        }
        for _ in 0..self.settings.exchanges {
            let best = (0..fit.members.len())
                .filter_map(|at| self.additions(&fit.without(at), 1).into_iter().next())
                .max_by(|a, b| self.criterion(a).total_cmp(&self.criterion(b)));
            match best {
                Some(better) if self.criterion(&better) > self.criterion(&fit) + 1e-9 => fit = better,
                _ => break,
            }
        }
        fit
    }
}
