//! Whether an error at a joint is of a few of its angles only: a worn or broken tooth, a dent in a bearing ring.
//!
//! A law that goes on over the whole range, as a swing of the joint's angle does, can be fitted to one such place and predicts errors
//! where there are none. One window of the joint's angle that predicts readings held out certainly better, and by much, shows it; what
//! such a law is called is then not known, and a curve at the joint stands for it.

use nalgebra::DMatrix;

use super::compared::Compared;
use super::held_out::paired;
use super::windows::{LEAST, of_joint};
use crate::effects::{Family, SiteKind};
use crate::math::quantiles::normal_of_any;

impl Compared<'_> {
    /// Whether readings that were not fitted get certainly better, and by much, with one window of the joint's angle in the place of a
    /// law at a joint that turns.
    pub fn is_local(&self, at: usize) -> bool {
        let [own] = self.sets[at][..] else { return false };
        let (problem, settings, readings) = (self.forward.problem, self.forward.settings, self.tests.readings);
        let law = &problem.hypotheses[own];
        let is_kinematic = law.site.kind == SiteKind::Joint && law.family() == Family::Kinematic && !law.is_free();
        if !is_kinematic {
            return false;
        }
        let mut windows: Vec<DMatrix<f64>> = Vec::new();
        let read = (readings.model, readings.campaign);
        of_joint(read, problem, self.forward.free_errors, (&law.site, LEAST), |_, column| {
            windows.push(DMatrix::from_columns(std::slice::from_ref(column)));
        });
        let certain = normal_of_any(settings.of_any, windows.len().max(1)).max(settings.paired_t);
        let losses = self.forward.folds.losses(&self.additions.with(&windows));
        losses.with.iter().any(|local| {
            paired(&self.losses.with[at], local).t > certain
                && self.gain(at) < settings.of_free * paired(&self.losses.base, local).sum
        })
    }
}
