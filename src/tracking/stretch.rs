//! What the checks since the last change are expected to show: a level, and the growth that was reported.

use nalgebra::{DMatrix, DVector};

use super::contrast::{Design, Scaled, inverse};

/// A course of one parameter in addition to its level.
#[derive(Debug, Clone)]
pub struct Term {
    /// Which.
    pub parameter: usize,
    /// At each check of the stretch.
    pub course: Vec<f64>,
}

/// Checks that belong together: constants keep their levels or grow steadily.
#[derive(Debug, Clone)]
pub struct Stretch {
    /// First check of each level: one, unless constants jumped while one was growing.
    levels: Vec<usize>,
    /// Constants that grow; the slope is one for all levels.
    grows: Vec<usize>,
}

impl Stretch {
    /// Constants keep their level from this check on.
    pub fn level(from: usize) -> Self {
        Self { levels: vec![from], grows: Vec::new() }
    }

    /// These constants grow steadily from this check on.
    pub fn growing(from: usize, grows: Vec<usize>) -> Self {
        Self { levels: vec![from], grows }
    }

    /// First check of all.
    pub fn from(&self) -> usize {
        self.levels.first().copied().unwrap_or(0)
    }

    /// First check of the present level.
    pub fn since(&self) -> usize {
        self.levels.last().copied().unwrap_or(0)
    }

    /// Constants that grow.
    pub fn grows(&self) -> &[usize] {
        &self.grows
    }

    /// These constants grow too.
    pub fn grow(&mut self, more: &[usize]) {
        self.grows.extend(more);
        self.grows.sort_unstable();
        self.grows.dedup();
    }

    /// The stretch after a jump at this check: levels anew. What grows goes on growing.
    pub fn after_jump(&self, at: usize) -> Self {
        let mut after = if self.grows.is_empty() { Self { levels: Vec::new(), ..self.clone() } } else { self.clone() };
        after.levels.push(at);
        after
    }

    /// What the check `k` of `all` at a time is expected to show.
    fn at(&self, all: &[Scaled], k: usize, time: f64) -> Option<Design> {
        let first = all.get(self.from())?;
        let size = first.values.len();
        let own = self.levels.iter().rposition(|from| *from <= k)? * size;
        let slopes = self.levels.len() * size;
        let mut design = DMatrix::zeros(size, slopes + self.grows.len());
        design.view_mut((0, own), (size, size)).fill_with_identity();
        for (column, parameter) in self.grows.iter().enumerate() {
            *design.get_mut((*parameter, slopes + column))? = time - first.time;
        }
        Some(design)
    }

    /// What its checks as far as `now` are expected to show, with further courses.
    pub fn expected(&self, all: &[Scaled], now: usize, terms: &[Term]) -> Option<Vec<Design>> {
        let one = |k: usize| {
            let mut design = self.at(all, k, all.get(k)?.time)?;
            for term in terms {
                let at = design.ncols();
                design = design.insert_column(at, 0.0);
                *design.get_mut((term.parameter, at))? = *term.course.get(k - self.from())?;
            }
            Some(design)
        };
        (self.from()..=now).map(one).collect()
    }

    /// Covariance of what a next check after the last of `all` is expected to show, as long after it as that was after the one before.
    pub fn covariance_of_next(&self, all: &[Scaled]) -> Option<DMatrix<f64>> {
        let last = all.len().checked_sub(1)?;
        let time = |k: usize| all.get(k).map(|check| check.time);
        let next = 2.0 * time(last)? - time(last.checked_sub(1)?)?;
        let own = all.get(self.from()..)?.iter().zip(self.expected(all, last, &[])?);
        let known = own.map(|(check, n)| n.transpose() * &check.information * n).reduce(|a, b| a + b)?;
        // Times and levels are of different size.
        let size = known.diagonal().map(|own| own.max(f64::MIN_POSITIVE).sqrt());
        let size: DMatrix<f64> = &size * DVector::transpose(&size);
        let covariance = inverse(&known.component_div(&size))?.component_div(&size);
        let design = self.at(all, last, next)?;
        Some(&design * covariance * design.transpose())
    }
}
