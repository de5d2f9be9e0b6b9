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
/// No parameter is off by more than this many times its common size.
const GREATEST: f64 = 60.0;
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

    /// Gain of every hypothesis beside those fitted: sum of squares taken up and directions used.
    pub fn gains(&self, members: &[usize]) -> Vec<(f64, usize)> {
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
                if !self.is_plausible(h, &own, &along) {
                    return (0.0, 0);
                }
                (along.norm_squared(), own.ncols())
            })
            .collect()
    }

    /// Whether the amounts by which a hypothesis would fit can be: compliances of what is rigid are positive, and nothing
    /// is off by many times what it commonly is.
    fn is_plausible(&self, h: usize, own: &DMatrix<f64>, along: &DVector<f64>) -> bool {
        let hypothesis = &self.evidence.hypotheses[h];
        let columns = &hypothesis.columns;
        if own.ncols() < columns.ncols() {
            return !hypothesis.is_positive;
        }
        let Some(amounts) = own.tr_mul(columns).lu().solve(along) else { return false };
        let can_be = |(amount, parameter): (&f64, &crate::effects::EffectParameter)| match hypothesis.is_positive {
            true => *amount >= 0.0,
            false => amount.abs() <= GREATEST * parameter.scale,
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

    /// The set that explains best: stepwise, each member tried against all others, and pairs of the strongest tried
    /// together where no single one does.
    pub fn search(&self, noise: Option<f64>) -> Vec<Fitted> {
        let mut path = vec![self.fit(&[])];
        for _ in 0..MOST {
            let Some(last) = path.last().cloned() else { break };
            let mut next = self.best_addition(&last.members);
            next = next.map(|fit| self.exchange(fit));
            if last.members.is_empty()
                && let Some(pair) = self.best_pair()
                && let Some(single) = &next
                && self.is_worth(&path[0], &pair, noise)
            {
                // A pair that hides its members from a stepwise search.
                let beside = self.best_addition(&single.members).map(|fit| self.exchange(fit));
                if beside.is_none_or(|fit| self.merit(&pair) > self.merit(&fit) + 6.0)
                    && self.merit(&pair) > self.merit(single) + 10.0
                {
                    let mut members = pair.members.clone();
                    members.sort_by(|a, b| self.fit(&[*a]).squares.total_cmp(&self.fit(&[*b]).squares));
                    path.push(self.fit(&members[..1]));
                    path.push(self.fit(&members));
                    continue;
                }
            }
            match next {
                Some(fit) if self.is_worth(&last, &fit, noise) => path.push(fit),
                _ => break,
            }
        }
        // The order in which members are told: each the best addition to those before it.
        let Some(all) = path.last().map(|fit| fit.members.clone()) else { return path };
        let mut told: Vec<Fitted> = vec![self.fit(&[])];
        let mut left = all;
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

    /// Whether a fit gains enough over a smaller one: not by chance, and not a trifle beside the noise.
    pub fn is_worth(&self, before: &Fitted, after: &Fitted, noise: Option<f64>) -> bool {
        let gain = before.squares - after.squares;
        let directions = after.directions.saturating_sub(before.directions).max(1);
        let freedom = (self.freedom() - after.directions as f64).max(1.0);
        let left = (after.squares / freedom).max(noise.unwrap_or(0.0).powi(2));
        let chance = self.chance(gain, directions, after.squares.max(left * freedom), before.directions);
        chance < CHANCE && gain / self.freedom() > LEAST * LEAST * left && self.merit(after) > self.merit(before)
    }

    fn best_addition(&self, members: &[usize]) -> Option<Fitted> {
        let before = self.fit(members);
        let gains = self.gains(members);
        (0..gains.len())
            .filter(|&h| gains[h].1 > 0 && !members.iter().any(|&m| self.excludes(m, h)))
            .map(|h| {
                let (gain, directions) = gains[h];
                let squares = (before.squares - gain).max(0.0);
                let fit =
                    Fitted { members: [members, &[h]].concat(), squares, directions: before.directions + directions };
                (self.merit(&fit), fit)
            })
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, fit)| fit)
    }

    fn excludes(&self, a: usize, b: usize) -> bool {
        self.evidence.hypotheses[a].excludes(&self.evidence.hypotheses[b])
    }

    fn is_same(&self, a: usize, b: usize) -> bool {
        self.evidence.hypotheses[a].is_same(&self.evidence.hypotheses[b])
    }

    /// Replaces single members by better ones until none is.
    fn exchange(&self, mut fit: Fitted) -> Fitted {
        if fit.members.len() < 2 {
            return fit;
        }
        for _ in 0..8 {
            let best = (0..fit.members.len())
                .filter_map(|at| {
                    let mut others = fit.members.clone();
                    others.remove(at);
                    self.best_addition(&others)
                })
                .max_by(|a, b| self.merit(a).total_cmp(&self.merit(b)));
            match best {
                Some(better) if self.merit(&better) > self.merit(&fit) + 1e-9 => fit = better,
                _ => break,
            }
        }
        fit
    }

    /// The best pair among the strongest single hypotheses and all others.
    fn best_pair(&self) -> Option<Fitted> {
        let gains = self.gains(&[]);
        let mut order: Vec<usize> = (0..gains.len()).filter(|&h| gains[h].1 > 0).collect();
        order.sort_by(|&a, &b| gains[b].0.total_cmp(&gains[a].0));
        // One form of each is enough to begin with.
        let mut leaders: Vec<usize> = Vec::new();
        for h in order {
            if leaders.len() < 16 && !leaders.iter().any(|&l| self.is_same(l, h)) {
                leaders.push(h);
            }
        }
        leaders
            .into_par_iter()
            .filter_map(|h| self.best_addition(&[h]))
            .max_by(|a, b| self.merit(a).total_cmp(&self.merit(b)))
    }

    /// Other hypotheses that would do in place of one member: index, merit less than that of the member's set.
    pub fn rivals(&self, fit: &Fitted, at: usize) -> Vec<(usize, f64)> {
        let mut others = fit.members.clone();
        let own = others.remove(at);
        let before = self.fit(&others);
        let gains = self.gains(&others);
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

fn join(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut joined = DMatrix::zeros(a.nrows(), a.ncols() + b.ncols());
    joined.columns_mut(0, a.ncols()).copy_from(a);
    joined.columns_mut(a.ncols(), b.ncols()).copy_from(b);
    joined
}
