//! Which hypotheses look alike: how much of what one changes in these readings another can imitate.

use nalgebra::DMatrix;

use super::evidence::Evidence;
use super::search::{GREATEST, Ground};

/// Most hypotheses compared.
const MOST: usize = 20;

/// Overlaps of hypotheses beside what is re-fitted whatever is tried.
#[derive(Debug, Clone, PartialEq)]
pub struct LookAlikes {
    /// Effect and site of each.
    pub names: Vec<(String, String)>,
    /// Share (0 to 1) of what the row's hypothesis changes in the readings that the column's can take up: the mean
    /// squared cosine of the row's directions with the column's space. Not symmetric where one has more parameters.
    pub overlap: DMatrix<f64>,
}

impl LookAlikes {
    /// Compares the causes with what came nearest to them, each effect at each site in its best form.
    pub fn of(ground: &Ground, members: &[usize], evidence: &Evidence) -> Self {
        let gains = ground.gains(&[], GREATEST);
        let mut order: Vec<usize> = (0..gains.len()).filter(|&h| ground.blocks[h].ncols() > 0).collect();
        order.sort_by(|&a, &b| gains[b].0.total_cmp(&gains[a].0));
        let mut chosen: Vec<usize> = Vec::new();
        for h in members.iter().copied().chain(order) {
            if chosen.len() == MOST {
                break;
            }
            if !chosen.iter().any(|&known| evidence.hypotheses[known].is_same(&evidence.hypotheses[h])) {
                chosen.push(h);
            }
        }
        let overlap = DMatrix::from_fn(chosen.len(), chosen.len(), |i, j| {
            let (own, other) = (&ground.blocks[chosen[i]], &ground.blocks[chosen[j]]);
            (own.tr_mul(other).norm_squared() / own.ncols().max(1) as f64).min(1.0)
        });
        let name = |&h: &usize| {
            let hypothesis = &evidence.hypotheses[h];
            (hypothesis.effect.name().to_string(), hypothesis.site.name.clone())
        };
        Self { names: chosen.iter().map(name).collect(), overlap }
    }
}
