//! Whether the amount of a law is one and the same in all configurations.
//!
//! A law that stands in for another one fits better in one region than in another: its amount changes with where the robot is. An error
//! that goes with the product of two angles is a coupling whose ratio changes along the other joint. Chosen on workshops of seeds
//! 71 to 73, judged on seed 91. Frictions that go with the load of another joint it does not show.
//!
//! Source: Hastie and Tibshirani, *Varying-coefficient models*, J. R. Stat. Soc. B 55, 1993.

use nalgebra::{DMatrix, DVector};

use super::compared::Compared;
use super::held_out::paired;
use crate::effects::SiteKind;
use crate::math::quantiles::normal_of_any;

impl Compared<'_> {
    /// Whether readings that were not fitted get certainly better, and by much, where the amounts of a law at a joint may change
    /// linearly with the position of one joint.
    pub fn is_uneven(&self, at: usize) -> bool {
        let [own] = self.sets[at][..] else { return false };
        let (problem, settings) = (self.forward.problem, self.forward.settings);
        let law = &problem.hypotheses[own];
        if law.site.kind != SiteKind::Joint || law.is_free() {
            return false;
        }
        let readings = self.tests.readings;
        let changing: Vec<DMatrix<f64>> = (0..readings.campaign.variables)
            .filter_map(|variable| {
                let along = self.standardised(&readings.positions(variable))?;
                let columns = &law.columns;
                let (rows, width) = columns.shape();
                Some(DMatrix::from_fn(rows, 2 * width, |row, k| {
                    along[row].powi((k / width) as i32) * columns[(row, k % width)]
                }))
            })
            .collect();
        let certain = normal_of_any(settings.of_any, changing.len().max(1)).max(settings.paired_t);
        let losses = self.forward.folds.losses(&self.additions.with(&changing));
        losses.with.iter().any(|changed| {
            paired(&self.losses.with[at], changed).t > certain
                && self.gain(at) < settings.of_free * paired(&self.losses.base, changed).sum
        })
    }

    /// Values of configurations by row, of mean 0 and deviation 1; 0 where they are not known. `None` where they are all the same.
    fn standardised(&self, values: &[Option<f64>]) -> Option<DVector<f64>> {
        let problem = self.forward.problem;
        let [mean, deviation] = mean_and_deviation(values)?;
        let of = |pose: usize| values.get(pose).copied().flatten().map_or(0.0, |q| (q - mean) / deviation);
        Some(DVector::from_iterator(problem.rows(), problem.numbered().0.into_iter().map(of)))
    }
}

/// Mean and standard deviation of the values that are known; `None` where these are all the same.
pub fn mean_and_deviation(values: &[Option<f64>]) -> Option<[f64; 2]> {
    let known: Vec<f64> = values.iter().flatten().copied().collect();
    let count = known.len().max(1) as f64;
    let mean = known.iter().sum::<f64>() / count;
    let deviation = (known.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt();
    (deviation > 0.0).then_some([mean, deviation])
}
