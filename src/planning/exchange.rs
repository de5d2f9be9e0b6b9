//! A set of stations chosen out of candidates: greedy, then exchanged one for another while that helps.

use nalgebra::DMatrix;

use super::criterion::{Target, join};
use super::place::Station;

/// A station with the whitened rows of its readings (p x rows).
#[derive(Clone)]
pub struct Candidate {
    pub station: Station,
    pub block: DMatrix<f64>,
}

/// Chosen stations.
#[derive(Clone)]
pub struct Design {
    /// Information without them.
    pub known: DMatrix<f64>,
    pub chosen: Vec<Candidate>,
    /// Tool centre points of what is measured already.
    pub before: Vec<Station>,
    pub apart: f64,
    /// As in [`super::Settings`].
    pub worth: f64,
    pub passes: usize,
}

impl Design {
    pub fn information(&self) -> DMatrix<f64> {
        self.without(usize::MAX)
    }

    /// Information with one of the chosen left out; summed anew, so that rounding does not gather.
    pub fn without(&self, left_out: usize) -> DMatrix<f64> {
        let mut m = self.known.clone();
        for (_, candidate) in self.chosen.iter().enumerate().filter(|(k, _)| *k != left_out) {
            join(&mut m, &candidate.block);
        }
        m
    }

    /// Whether a station may be added to all chosen but one.
    pub fn admits(&self, station: &Station, but: usize) -> bool {
        let others = self.chosen.iter().enumerate().filter(|(k, _)| *k != but).map(|(_, chosen)| &chosen.station);
        others.chain(&self.before).all(|other| station.goes_with(other, self.apart))
    }

    /// The best candidate to add to all chosen but one, and its loss.
    pub fn best(&self, target: &Target, m: &DMatrix<f64>, pool: &[Candidate], but: usize) -> Option<(usize, f64)> {
        let allowed: Vec<bool> = pool.iter().map(|candidate| self.admits(&candidate.station, but)).collect();
        let blocks: Vec<&DMatrix<f64>> = pool.iter().map(|candidate| &candidate.block).collect();
        let losses = target.joined(m, &blocks, &allowed).into_iter().enumerate();
        losses.filter(|(_, loss)| loss.is_finite()).min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Adds the best candidates until there are `count`; fewer where no more may be added.
    pub fn grow(&mut self, target: &Target, pool: &[Candidate], count: usize) {
        let mut m = self.information();
        while self.chosen.len() < count {
            let Some((k, _)) = self.best(target, &m, pool, usize::MAX) else { return };
            join(&mut m, &pool[k].block);
            self.chosen.push(pool[k].clone());
        }
    }

    /// Exchanges chosen stations for candidates while that helps; the loss at the end.
    pub fn exchange(&mut self, target: &Target, pool: &[Candidate]) -> f64 {
        let mut loss = target.loss(&self.information());
        for _ in 0..self.passes {
            let before = loss;
            for k in 0..self.chosen.len() {
                if let Some((better, new)) = self.best(target, &self.without(k), pool, k)
                    && new < loss - self.worth
                {
                    self.chosen[k] = pool[better].clone();
                    loss = new;
                }
            }
            if loss > before - self.worth {
                break;
            }
        }
        loss
    }
}
