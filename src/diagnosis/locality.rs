//! Whether an error at a joint is of a few of its angles only: a worn or broken tooth, a dent in a bearing ring.
//!
//! A law that goes on over the whole range, as a swing of the joint's angle does, can be fitted to one such place and predicts errors
//! where there are none. One window of the joint's angle that predicts readings held out certainly better, and by much, shows it; what
//! such a law is called is then not known, and a curve at the joint stands for it.

use nalgebra::{DMatrix, DVector};

use super::compared::Compared;
use super::held_out::paired;
use super::windows::windows;
use crate::effects::{Family, SiteKind};
use crate::math::quantiles::normal_of_any;

impl Compared<'_> {
    /// Whether readings that were not fitted get certainly better, and by much, with one window of the joint's angle in the place of a
    /// law at a joint that turns.
    pub fn is_local(&self, at: usize) -> bool {
        let [own] = self.sets[at][..] else { return false };
        let (problem, settings, readings) = (self.forward.problem, self.forward.settings, self.tests.readings);
        let law = &problem.hypotheses[own];
        let is_turned = law.site.kind == SiteKind::Joint && law.family() == Family::Kinematic && !law.is_free();
        let Some(coordinate) = law.site.coordinate.filter(|_| is_turned) else { return false };
        if !readings.model.variables.get(coordinate).is_some_and(|variable| variable.is_angle) {
            return false;
        }
        let Some(joint) = self.tests.free_errors.column(&law.site.name) else { return false };
        let angles = readings.positions(coordinate);
        let poses = problem.poses();
        let of_row: Vec<Option<f64>> = (0..problem.rows())
            .map(|row| angles.get(poses.partition_point(|pose| *pose < problem.pose[row])).copied().flatten())
            .collect();
        let known: Vec<f64> = angles.iter().flatten().copied().collect();
        let windows: Vec<DMatrix<f64>> = windows(&known)
            .into_iter()
            .map(|window| {
                let column = |row: usize| joint[row] * of_row[row].map_or(0.0, |angle| window.weight(angle));
                DMatrix::from_columns(&[DVector::from_fn(problem.rows(), |row, _| column(row))])
            })
            .collect();
        let certain = normal_of_any(settings.of_any, windows.len().max(1)).max(settings.paired_t);
        let losses = self.forward.folds.losses(&self.additions.with(&windows));
        losses.with.iter().any(|local| {
            paired(&self.losses.with[at], local).t > certain
                && self.gain(at) < settings.of_free * paired(&self.losses.base, local).sum
        })
    }
}
