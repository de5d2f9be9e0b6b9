//! The competition: all hypotheses alone and stepwise together, on what calibration leaves.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::algebra::{orthonormal, rest};
use super::evidence::Evidence;

/// Most effects named together.
const MOST: usize = 4;
/// An effect is named below this probability of its gain by chance, times the number of hypotheses tried.
const CHANCE: f64 = 5e-3;
/// Sets of each size that are grown further.
const BEAM: usize = 6;
/// Merit that a set must gain if no smaller one was worth anything by itself.
const HIDDEN: f64 = 10.0;
/// Cosine beside the nuisance from which two effects at one site are laws of the same thing.
const ALIKE: f64 = 0.6;
/// No parameter is off by more than this many times its common size.
pub const GREATEST: f64 = 60.0;
/// What a further effect must contribute at least, root mean square over the rows, in sigmas of what is left.
const LEAST: f64 = 0.25;

/// A set of hypotheses fitted together with the nuisance.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// Hypotheses, by index.
    pub members: Vec<usize>,
    /// Sum of squares left.
    pub squares: f64,
    /// Directions used by the members.
    pub directions: usize,
}

/// The competition's ground: residual and columns less what the nuisance takes up.
pub struct Ground<'a> {
    evidence: &'a Evidence,
    /// Orthonormal basis of the nuisance.
    pub basis: DMatrix<f64>,
    /// Residual beside it.
    pub residual: DVector<f64>,
    /// For each hypothesis an orthonormal basis of what is its own beside the nuisance.
    pub blocks: Vec<DMatrix<f64>>,
}

impl<'a> Ground<'a> {
    /// Projects the nuisance out.
    pub fn new(evidence: &'a Evidence) -> Self {
        let basis = orthonormal(&evidence.nuisance, None);
        let residual = rest(&evidence.residual, &basis);
        let blocks = evidence.hypotheses.par_iter().map(|h| orthonormal(&h.columns, Some(&basis))).collect();
        Self { evidence, basis, residual, blocks }
    }

    /// Degrees of freedom left by the nuisance.
    pub fn freedom(&self) -> f64 {
        (self.evidence.rows() - self.basis.ncols()).max(1) as f64
    }

    /// Fits a set of hypotheses.
    pub fn fit(&self, members: &[usize]) -> Fitted {
        let mut residual = self.residual.clone();
        let mut used: Option<DMatrix<f64>> = None;
        for &member in members {
            let own = match &used {
                Some(used) => orthonormal(&self.blocks[member], Some(used)),
                None => self.blocks[member].clone(),
            };
            residual = rest(&residual, &own);
            used = Some(match used {
                Some(used) => join(&used, &own),
                None => own,
            });
        }
        let directions = used.map_or(0, |used| used.ncols());
        Fitted { members: members.to_vec(), squares: residual.norm_squared(), directions }
    }

    /// Gain of every hypothesis beside those fitted: sum of squares taken up and directions used; nothing where an amount
    /// would be more than `greatest` times its common size.
    pub fn gains(&self, members: &[usize], greatest: f64) -> Vec<(f64, usize)> {
        let mut used: Option<DMatrix<f64>> = None;
        for &member in members {
            let own = orthonormal(&self.blocks[member], used.as_ref());
            used = Some(used.map_or(own.clone(), |used| join(&used, &own)));
        }
        let residual = used.as_ref().map_or_else(|| self.residual.clone(), |used| rest(&self.residual, used));
        self.blocks
            .par_iter()
            .enumerate()
            .map(|(h, block)| {
                let own = match &used {
                    Some(used) => orthonormal(block, Some(used)),
                    None => block.clone(),
                };
                let along = own.tr_mul(&residual);
                if !self.is_plausible(h, &own, &along, greatest) {
                    return (0.0, 0);
                }
                (along.norm_squared(), own.ncols())
            })
            .collect()
    }

    /// Whether the amounts by which a hypothesis would fit can be: compliances of what is rigid are positive, and nothing
    /// is off by many times what it commonly is.
    fn is_plausible(&self, h: usize, own: &DMatrix<f64>, along: &DVector<f64>, greatest: f64) -> bool {
        let hypothesis = &self.evidence.hypotheses[h];
        let columns = &hypothesis.columns;
        if own.ncols() < columns.ncols() {
            return !hypothesis.is_positive;
        }
        let Some(amounts) = own.tr_mul(columns).lu().solve(along) else { return false };
        let can_be = |(amount, parameter): (&f64, &crate::effects::EffectParameter)| match hypothesis.is_positive {
            true => *amount >= 0.0,
            false => amount.abs() <= greatest * parameter.scale,
        };
        amounts.iter().zip(&hypothesis.parameters).all(can_be)
    }

    /// Merit of a fit: Bayesian information criterion, with the forms that were tried.
    pub fn merit(&self, fitted: &Fitted) -> f64 {
        let n = self.freedom();
        let tried: f64 =
            fitted.members.iter().map(|&h| 2.0 * (self.evidence.hypotheses[h].forms.max(1) as f64).ln()).sum();
        -n * (fitted.squares.max(f64::MIN_POSITIVE) / n).ln() - fitted.directions as f64 * n.ln() - tried
    }

    /// Probability of a gain by chance, over all hypotheses tried.
    pub fn chance(&self, gain: f64, directions: usize, left: f64, used: usize) -> f64 {
        let freedom = (self.freedom() - (used + directions) as f64).max(1.0);
        let ratio = (gain / directions.max(1) as f64) / (left / freedom).max(f64::MIN_POSITIVE);
        let tail = FisherSnedecor::new(directions.max(1) as f64, freedom).map_or(1.0, |f| f.sf(ratio));
        (tail * self.evidence.hypotheses.len() as f64).min(1.0)
    }

    /// Whether a gain of one hypothesis alone could be chance.
    pub fn is_chance(&self, gain: f64, directions: usize) -> bool {
        self.chance(gain, directions, (self.residual.norm_squared() - gain).max(0.0), 0) >= CHANCE
    }

    /// The set that explains best. The strongest few sets of every size are grown, so that members which hide one another
    /// are found together; a set counts if it gains enough over the smaller one, and every member of it over the rest.
    pub fn search(&self, noise: Option<f64>) -> Vec<Fitted> {
        let empty = self.fit(&[]);
        let mut accepted = empty.clone();
        let mut beam = vec![empty.clone()];
        for _ in 0..MOST {
            let mut grown: Vec<Fitted> = Vec::new();
            for set in &beam {
                for fit in self.additions(&set.members, BEAM) {
                    if !grown.iter().any(|known| is_same_set(&known.members, &fit.members)) {
                        grown.push(fit);
                    }
                }
            }
            grown.sort_by(|a, b| self.merit(b).total_cmp(&self.merit(a)));
            grown.truncate(BEAM);
            let Some(first) = grown.first().cloned() else { break };
            let best = self.exchange(first);
            if grown.iter().all(|known| !is_same_set(&known.members, &best.members)) {
                grown.insert(0, best.clone());
                grown.truncate(BEAM);
            }
            let hidden = best.members.len() - accepted.members.len() > 1;
            let margin = if hidden { HIDDEN } else { 0.0 };
            if self.is_worth(&accepted, &best, noise)
                && self.merit(&best) > self.merit(&accepted) + margin
                && self.each_is_worth(&best, noise)
            {
                accepted = best;
            }
            beam = grown;
        }
        // The order in which members are told: each the best addition to those before it.
        let mut told: Vec<Fitted> = vec![empty];
        let mut left = accepted.members;
        while !left.is_empty() {
            let so_far = told.last().map(|fit| fit.members.clone()).unwrap_or_default();
            let with = |h: usize| self.fit(&[so_far.clone(), vec![h]].concat());
            let Some(at) = (0..left.len()).min_by(|&a, &b| with(left[a]).squares.total_cmp(&with(left[b]).squares))
            else {
                break;
            };
            told.push(with(left.remove(at)));
        }
        told
    }

    /// Whether no member of a set could be left out.
    fn each_is_worth(&self, fit: &Fitted, noise: Option<f64>) -> bool {
        fit.members.len() < 2
            || (0..fit.members.len()).all(|at| {
                let mut others = fit.members.clone();
                others.remove(at);
                self.is_worth(&self.fit(&others), fit, noise)
            })
    }

    /// Whether a fit gains enough over a smaller one: not by chance, and not a trifle beside the noise.
    pub fn is_worth(&self, before: &Fitted, after: &Fitted, noise: Option<f64>) -> bool {
        let gain = before.squares - after.squares;
        let directions = after.directions.saturating_sub(before.directions).max(1);
        let freedom = (self.freedom() - after.directions as f64).max(1.0);
        let left = (after.squares / freedom).max(noise.unwrap_or(0.0).powi(2));
        let chance = self.chance(gain, directions, after.squares.max(left * freedom), before.directions);
        chance < CHANCE && gain / self.freedom() > LEAST * LEAST * left && self.merit(after) > self.merit(before)
    }

    /// The best sets of one member more, at most `count`, best first.
    fn additions(&self, members: &[usize], count: usize) -> Vec<Fitted> {
        let before = self.fit(members);
        let gains = self.gains(members, GREATEST);
        let mut all: Vec<(f64, Fitted)> = (0..gains.len())
            .filter(|&h| gains[h].1 > 0 && !members.iter().any(|&m| self.excludes(m, h)))
            .map(|h| {
                let (gain, directions) = gains[h];
                let squares = (before.squares - gain).max(0.0);
                let fit =
                    Fitted { members: [members, &[h]].concat(), squares, directions: before.directions + directions };
                (self.merit(&fit), fit)
            })
            .collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        // One form of each effect at each site is enough to begin with.
        let mut chosen: Vec<Fitted> = Vec::new();
        for (_, fit) in all {
            let own = *fit.members.last().unwrap_or(&0);
            if !chosen.iter().any(|known| self.is_same(*known.members.last().unwrap_or(&0), own)) {
                chosen.push(fit);
            }
            if chosen.len() >= count {
                break;
            }
        }
        chosen
    }

    /// Whether two cannot be causes together: the same thing in two selections or forms, or two laws of one site that
    /// look alike, of which the second would only mend the shape of the first.
    fn excludes(&self, a: usize, b: usize) -> bool {
        let [one, other] = [a, b].map(|h| &self.evidence.hypotheses[h]);
        one.excludes(other)
            || one.site == other.site
                && one.effect.name() != other.effect.name()
                && alignment(&self.blocks[a], &self.blocks[b]) > ALIKE
    }

    fn is_same(&self, a: usize, b: usize) -> bool {
        self.evidence.hypotheses[a].is_same(&self.evidence.hypotheses[b])
    }

    /// Replaces single members by better ones until none is.
    fn exchange(&self, mut fit: Fitted) -> Fitted {
        if fit.members.len() < 2 {
            return fit;
        }
        for _ in 0..6 {
            let best = (0..fit.members.len())
                .filter_map(|at| {
                    let mut others = fit.members.clone();
                    others.remove(at);
                    self.additions(&others, 1).into_iter().next()
                })
                .max_by(|a, b| self.merit(a).total_cmp(&self.merit(b)));
            match best {
                Some(better) if self.merit(&better) > self.merit(&fit) + 1e-9 => fit = better,
                _ => break,
            }
        }
        fit
    }

    /// Other hypotheses that would do in place of one member, whatever the amount: index, merit less than that of the
    /// member's set.
    pub fn rivals(&self, fit: &Fitted, at: usize) -> Vec<(usize, f64)> {
        let mut others = fit.members.clone();
        let own = others.remove(at);
        let before = self.fit(&others);
        let gains = self.gains(&others, f64::INFINITY);
        let merit = self.merit(fit);
        let mut best: Vec<(usize, f64)> = Vec::new();
        for (h, &(gain, directions)) in gains.iter().enumerate() {
            if directions == 0 || self.is_same(own, h) || others.iter().any(|&m| self.is_same(m, h)) {
                continue;
            }
            let members = [others.as_slice(), &[h]].concat();
            let squares = (before.squares - gain).max(0.0);
            let other = Fitted { members, squares, directions: before.directions + directions };
            let loss = merit - self.merit(&other);
            match best.iter_mut().find(|(known, _)| self.is_same(*known, h)) {
                Some(known) if known.1 > loss => *known = (h, loss),
                Some(_) => {}
                None => best.push((h, loss)),
            }
        }
        best.sort_by(|a, b| a.1.total_cmp(&b.1));
        best
    }
}

fn is_same_set(a: &[usize], b: &[usize]) -> bool {
    a.len() == b.len() && a.iter().all(|member| b.contains(member))
}

/// Cosine of the smallest angle between two orthonormal bases.
fn alignment(a: &DMatrix<f64>, b: &DMatrix<f64>) -> f64 {
    if a.ncols() == 0 || b.ncols() == 0 {
        return 0.0;
    }
    a.tr_mul(b).singular_values().max()
}

fn join(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut joined = DMatrix::zeros(a.nrows(), a.ncols() + b.ncols());
    joined.columns_mut(0, a.ncols()).copy_from(a);
    joined.columns_mut(a.ncols(), b.ncols()).copy_from(b);
    joined
}
