//! Errors that are free in every configuration: how much of a residual each site could carry.

use nalgebra::{DMatrix, DVector};

use super::linear_problem::LinearProblem;
use super::probe::probes;
use crate::description::campaign::Campaign;
use crate::math::{orthonormal, project_off};
use crate::model::Model;
use crate::prediction::{PredictionError, effect_columns};

/// Rows of a configuration from which on a rigid motion of the tool is seen whole.
const RIGID: usize = 6;

/// Squares of one configuration under one load.
pub struct Squares {
    /// Taken up by the free error, less those of noise and of chance.
    pub carried: f64,
    /// Above the noise.
    pub total: f64,
}

/// Squares that free errors at the sites carry in every configuration under one load.
pub struct FreeErrors<'a> {
    problem: &'a LinearProblem,
    names: Vec<(String, usize)>,
    columns: (Vec<f64>, usize),
    blocks: Vec<Vec<usize>>,
}

impl<'a> FreeErrors<'a> {
    /// Probes at all sites, for the readings of a campaign at calibrated `values`; `problem` holds these readings.
    ///
    /// # Errors
    /// A configuration that cannot be assembled.
    pub fn new(
        model: &Model,
        campaign: &Campaign,
        values: &[f64],
        problem: &'a LinearProblem,
    ) -> Result<Self, PredictionError> {
        let terms = probes(model);
        let names = terms.iter().map(|term| (term.site.name.clone(), term.parameters.len())).collect();
        let columns = effect_columns(model, campaign, values, terms)?;
        // Constraints are no readings, and carry no load.
        let load = |row: usize| campaign.readings.get(problem.reading[row]).map(|reading| reading.wrench);
        let rows: Vec<usize> = (0..problem.rows()).collect();
        let is_one = |a: &usize, b: &usize| problem.pose[*a] == problem.pose[*b] && load(*a) == load(*b);
        let blocks = rows.chunk_by(is_one).map(<[usize]>::to_vec).collect();
        Ok(Self { problem, names, columns, blocks })
    }

    /// By site: the squares of a residual in each block. `noise` is over the sigmas.
    pub fn squares(&self, residual: &DVector<f64>, noise: f64) -> impl Iterator<Item = (&str, Vec<Squares>)> {
        self.by_site(move |rows, columns| squares(columns, &residual.select_rows(rows), noise))
    }

    /// By site of one direction: what is left of columns where errors there are free in every block.
    pub fn off(&self, columns: &DMatrix<f64>) -> impl Iterator<Item = (&str, DMatrix<f64>)> {
        let of_block =
            |rows: &Vec<usize>, own: &DMatrix<f64>| project_off(&columns.select_rows(rows), &orthonormal(own, None));
        let names = self.names.iter().map(|(_, count)| *count == 1);
        names.zip(self.by_site(of_block)).filter(|(is_one, _)| *is_one).map(|(_, (site, blocks))| {
            let mut left = columns.clone();
            for (rows, block) in self.blocks.iter().zip(blocks) {
                rows.iter().enumerate().for_each(|(at, &row)| left.set_row(row, &block.row(at)));
            }
            (site, left)
        })
    }

    /// By site: what becomes of the columns of its errors in each block, of which the rows are given.
    fn by_site<T>(&self, of: impl Fn(&Vec<usize>, &DMatrix<f64>) -> T) -> impl Iterator<Item = (&str, Vec<T>)> {
        let (all, width) = &self.columns;
        let mut first = 0;
        self.names.iter().map(move |(site, count)| {
            let start = first;
            first += count;
            let of_block = |rows: &Vec<usize>| {
                let column = |i: usize, k: usize| all[rows[i] * width + start + k] / self.problem.sigmas[rows[i]];
                of(rows, &DMatrix::from_fn(rows.len(), *count, column))
            };
            (site.as_str(), self.blocks.iter().map(of_block).collect())
        })
    }

    /// Errors over their sigmas at a site of one direction, by configuration of the problem: what each of its readings shows of
    /// them together. `None` where there is no such site, or it has several directions.
    pub fn amounts(&self, site: &str, residual: &DVector<f64>) -> Option<Vec<f64>> {
        let (pose, poses) = self.problem.numbered();
        self.amounts_of(site, residual, poses, |row| pose[row])
    }

    /// The same by configuration and load, as [`FreeErrors::first_readings`].
    pub fn amounts_by_load(&self, site: &str, residual: &DVector<f64>) -> Option<Vec<f64>> {
        let firsts: Vec<usize> = self.blocks.iter().map(|rows| rows[0]).collect();
        self.amounts_of(site, residual, firsts.len(), |row| firsts.partition_point(|first| *first <= row) - 1)
    }

    fn amounts_of(
        &self,
        site: &str,
        residual: &DVector<f64>,
        count: usize,
        of_row: impl Fn(usize) -> usize,
    ) -> Option<Vec<f64>> {
        let column = self.column(site)?;
        let mut sums = vec![(0.0, 0.0); count];
        for row in 0..residual.len() {
            let own = column[row];
            let sum = &mut sums[of_row(row)];
            *sum = (sum.0 + own * residual[row], sum.1 + own * own);
        }
        let amount = |(product, square): (f64, f64)| product / square.sqrt().max(f64::MIN_POSITIVE);
        Some(sums.into_iter().map(amount).collect())
    }

    /// The first reading of each configuration under each load; constraints count behind the readings.
    pub fn first_readings(&self) -> impl Iterator<Item = usize> {
        self.blocks.iter().map(|rows| self.problem.reading[rows[0]])
    }

    /// Errors over their sigmas of each configuration of the problem, in the order of its rows, zero where one has fewer than another.
    pub fn by_configuration(&self, residual: &DVector<f64>) -> Vec<Vec<f64>> {
        let (pose, poses) = self.problem.numbered();
        let mut errors = vec![Vec::new(); poses];
        residual.iter().zip(pose).for_each(|(error, pose)| errors[pose].push(*error));
        let most = errors.iter().map(Vec::len).max().unwrap_or_default();
        errors.iter_mut().for_each(|own| own.resize(most, 0.0));
        errors
    }

    /// What an error of one direction at a site moves each row by, over its sigma. `None` as for [`FreeErrors::amounts`].
    pub fn column(&self, site: &str) -> Option<DVector<f64>> {
        let (all, width) = &self.columns;
        let at = self.names.iter().position(|(name, count)| name == site && *count == 1)?;
        let column: usize = self.names.iter().take(at).map(|(_, count)| count).sum();
        let sigmas = &self.problem.sigmas;
        Some(DVector::from_fn(sigmas.len(), |row, _| all[row * width + column] / sigmas[row]))
    }

    /// Squares above the noise that a free error at one site carries; `None` where there is no such site, or where too few
    /// rows of a configuration tell it from other motions.
    pub fn carried(&self, site: &str, residual: &DVector<f64>, noise: f64) -> Option<f64> {
        if self.blocks.iter().any(|rows| rows.len() < RIGID) {
            return None;
        }
        let found = self.squares(residual, noise).find(|(own, _)| *own == site)?;
        Some(found.1.iter().map(|own| own.carried).sum())
    }
}

fn squares(columns: &DMatrix<f64>, residual: &DVector<f64>, noise: f64) -> Squares {
    let basis = orthonormal(columns, None);
    let (rows, directions, variance) = (residual.len(), basis.ncols() as f64, noise * noise);
    let taken = residual.norm_squared() - project_off(residual, &basis).norm_squared();
    let total = residual.norm_squared() - rows as f64 * variance;
    // What as many directions would carry of any motion of the tool, which has six.
    let chance = directions / rows.clamp(1, RIGID) as f64;
    Squares { carried: (taken - directions * variance - chance * total) / (1.0 - chance).max(0.1), total }
}
