//! What did not become a cause: hypotheses that would do in place of one, those rejected, and how alike they look.

use super::hypothesis::Hypothesis;
use super::projection::Subset;
use super::result::{EffectAtSite, LookAlikes, Rejected};
use super::selection::Selector;
use super::settings::RivalSettings;

/// A hypothesis that would do in place of a cause.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rival {
    /// The hypothesis, by index.
    pub hypothesis: usize,
    /// Information criterion of the cause's subset, less that of the rival's.
    pub loss: f64,
    /// Whether it stands for the like of it at all joints.
    pub is_of_joints: bool,
}

impl Rival {
    /// Effect and site by name; `joints` of all of them.
    pub fn named(&self, hypotheses: &[Hypothesis]) -> EffectAtSite {
        let named = hypotheses[self.hypothesis].named();
        if self.is_of_joints { EffectAtSite { site: "joints".into(), ..named } } else { named }
    }
}

/// Rivals of every member of a subset whatever their amounts, the nearest first, each effect at each site once. `per_pose`
/// are the rows of one configuration.
pub fn rivals(selector: &Selector, fit: &Subset, per_pose: f64, settings: &RivalSettings) -> Vec<Vec<Rival>> {
    (0..fit.members.len()).map(|at| rivals_of(selector, fit, at, per_pose, settings)).collect()
}

fn rivals_of(selector: &Selector, fit: &Subset, at: usize, per_pose: f64, settings: &RivalSettings) -> Vec<Rival> {
    let hypotheses = &selector.projection.problem.hypotheses;
    let (own, others) = (fit.members[at], fit.without(at));
    let before = selector.fit(&others);
    let gains = selector.projection.gains(&others, f64::INFINITY, f64::INFINITY);
    let criterion = selector.criterion(fit);
    let is_same = |a: usize, b: usize| hypotheses[a].is_same(&hypotheses[b]);
    let free = |h: usize| {
        gains[h].directions > 0
            && !hypotheses[h].is_free()
            && !is_same(own, h)
            && !others.iter().any(|&m| is_same(m, h))
    };
    let loss = |h: usize| criterion - selector.criterion(&selector.extended_by(&before, h, gains[h]));
    let candidates = (0..gains.len()).filter(|&h| free(h)).map(|h| (h, -loss(h)));
    let mut found = best_variants(hypotheses, candidates);
    found.sort_by(|a, b| b.1.total_cmp(&a.1));
    let found = found
        .into_iter()
        .map(|(hypothesis, merit)| Rival { hypothesis, loss: -merit, is_of_joints: false })
        .enumerate();
    // What readings of one configuration share counts once: beyond the sharp margin, as many as fill a group.
    let near = settings.margin * per_pose / 3.0;
    found
        .filter(|(k, rival)| rival.loss < settings.margin || k + 1 < settings.group && rival.loss < near)
        .map(|(_, rival)| rival)
        .take(settings.most)
        .collect()
}

/// Hypotheses that were not selected, each effect at each site in its best variant, with it alone. And what no effect at
/// all leaves: root mean square errors (m) of all readings, by degree of freedom.
/// `tied` are the rivals of the members.
pub fn rejected(selector: &Selector, members: &[usize], tied: &[Vec<Rival>]) -> (Vec<Rejected>, f64) {
    let problem = selector.projection.problem;
    let gains = selector.gains(&[]);
    let is_member = |h: usize| members.iter().any(|&m| problem.hypotheses[m].is_same(&problem.hypotheses[h]));
    let candidates =
        (0..gains.len()).filter(|&h| !is_member(h) && !problem.hypotheses[h].is_free()).map(|h| (h, gains[h].squares));
    let mut best = best_variants(&problem.hypotheses, candidates);
    best.sort_by(|a, b| b.1.total_cmp(&a.1));
    let (size, squares) = (problem.error_of_one_sigma(), selector.projection.squares());
    let is_tied = |h: usize| {
        tied.iter().flatten().any(|rival| problem.hypotheses[rival.hypothesis].is_same(&problem.hypotheses[h]))
    };
    let left = |gain: f64| ((squares - gain).max(0.0) / selector.projection.freedom).sqrt() * size;
    let rejected = best.into_iter().map(|(h, gain)| {
        let EffectAtSite { effect, site } = problem.hypotheses[h].named();
        let why = if gains[h].directions == 0 {
            "calibration reproduces it entirely, or its sign is not possible"
        } else if selector.is_chance(gains[h]) {
            "no more than chance"
        } else if members.is_empty() && gain > 0.5 * squares {
            "it explains most of the gap, and whether it is its law is not certain"
        } else if members.is_empty() {
            "it explains a part, and most of the gap stays"
        } else if is_tied(h) {
            "not distinguishable from a named cause"
        } else {
            "the causes found do better"
        };
        Rejected { effect, site, rms: left(gain), why }
    });
    (rejected.collect(), left(0.0))
}

/// Compares the causes with at most `most` hypotheses that come nearest to them, each effect at each site in its best
/// variant.
pub fn look_alikes(selector: &Selector, members: &[usize], most: usize) -> LookAlikes {
    let (hypotheses, blocks) = (&selector.projection.problem.hypotheses, &selector.projection.blocks);
    let gains = selector.gains(&[]);
    let mut order: Vec<usize> =
        (0..gains.len()).filter(|&h| blocks[h].ncols() > 0 && !hypotheses[h].is_free()).collect();
    order.sort_by(|&a, &b| gains[b].squares.total_cmp(&gains[a].squares));
    let mut chosen: Vec<usize> = Vec::new();
    for h in members.iter().copied().chain(order) {
        if chosen.len() < most && !chosen.iter().any(|&known| hypotheses[known].is_same(&hypotheses[h])) {
            chosen.push(h);
        }
    }
    let overlap = |&i: &usize, &j: &usize| {
        (blocks[i].tr_mul(&blocks[j]).norm_squared() / blocks[i].ncols().max(1) as f64).min(1.0)
    };
    LookAlikes {
        hypotheses: chosen.iter().map(|&h| hypotheses[h].named()).collect(),
        overlap: chosen.iter().map(|i| chosen.iter().map(|j| overlap(i, j)).collect()).collect(),
    }
}

/// Of all variants of an effect at a site the one with the greatest merit: hypothesis, merit.
fn best_variants(hypotheses: &[Hypothesis], all: impl Iterator<Item = (usize, f64)>) -> Vec<(usize, f64)> {
    let mut best: Vec<(usize, f64)> = Vec::new();
    for (h, merit) in all {
        match best.iter_mut().find(|(known, _)| hypotheses[*known].is_same(&hypotheses[h])) {
            Some(known) if known.1 < merit => *known = (h, merit),
            Some(_) => {}
            None => best.push((h, merit)),
        }
    }
    best
}
