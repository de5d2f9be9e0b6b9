//! Whether deflections grow as the load does: measured over predicted displacement, by size and direction of the force.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::description::campaign::Campaign;

/// Steps of a direction cosine: forces that agree to a degree or so have one direction.
const DIRECTIONS: f64 = 50.0;

/// Whether displacements measured under loads of one size are as large as the model, linear in the load, predicts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level {
    /// Force, N.
    pub force: f64,
    /// Number of readings.
    pub readings: usize,
    /// Measured over predicted displacement, by least squares.
    pub gain: f64,
    /// Its standard error.
    pub sigma: f64,
    /// The same relative to loads of other sizes in the same directions, and its standard error: 1 if linear. `None` where
    /// no direction was loaded by several sizes.
    pub linear: Option<[f64; 2]>,
}

/// Sums by which a gain is fitted: measured times predicted, predicted squared, measured squared, and number of rows.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    dot: f64,
    predicted: f64,
    measured: f64,
    rows: f64,
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.dot += other.dot;
        self.predicted += other.predicted;
        self.measured += other.measured;
        self.rows += other.rows;
    }

    /// Gain and its standard error.
    fn gain(&self) -> [f64; 2] {
        let gain = self.dot / self.predicted;
        let residual = (self.measured - gain * self.dot).max(0.0);
        [gain, (residual / (self.rows - 1.0).max(1.0) / self.predicted).sqrt()]
    }
}

/// Readings by the size of their force (whole newtons), from residuals of the model.
pub fn levels(campaign: &Campaign, residual: &[f64]) -> Vec<Level> {
    // By size, and among these by direction (to a degree or so).
    let mut cells: BTreeMap<(i64, [i64; 3]), Sums> = BTreeMap::new();
    let width = campaign.observes.rows();
    for (k, reading) in campaign.readings.iter().enumerate() {
        let force = Vector3::from_column_slice(&reading.wrench[..3]);
        let size = force.norm();
        let way = force.map(|f| if size > 0.0 { (DIRECTIONS * f / size).round() as i64 } else { 0 });
        let measured = Vector3::from_column_slice(&reading.measured[..3]);
        let predicted = measured - Vector3::from_column_slice(&residual[width * k..width * k + 3]);
        cells.entry((size.round() as i64, way.into())).or_default().add(&Sums {
            dot: measured.dot(&predicted),
            predicted: predicted.norm_squared(),
            measured: measured.norm_squared(),
            rows: 3.0,
        });
    }
    // An error of the model in a direction is the same at all sizes: only what differs between sizes is not linear.
    let mut ways: BTreeMap<[i64; 3], (usize, Sums)> = BTreeMap::new();
    for ((_, way), sums) in &cells {
        let own = ways.entry(*way).or_default();
        own.0 += 1;
        own.1.add(sums);
    }
    // Under a force by which nothing is predicted to move there is nothing to compare with.
    let is_predicted = |size: &i64| cells.iter().any(|((own, _), sums)| own == size && sums.predicted > 0.0);
    let mut sizes: Vec<i64> = cells.keys().map(|(size, _)| *size).filter(is_predicted).collect();
    sizes.dedup();
    let level = |size: i64| {
        let (mut all, mut compared) = (Sums::default(), Sums::default());
        for ((_, way), sums) in cells.iter().filter(|((own, _), _)| *own == size) {
            all.add(sums);
            let Some((_, common)) = ways.get(way).filter(|(count, sums)| *count > 1 && sums.predicted > 0.0) else {
                continue;
            };
            let [gain, _] = common.gain();
            compared.add(&Sums { dot: gain * sums.dot, predicted: gain * gain * sums.predicted, ..*sums });
        }
        let [gain, sigma] = all.gain();
        let linear = (compared.rows > 0.0).then(|| compared.gain());
        Level { force: size as f64, readings: (all.rows / 3.0).round() as usize, gain, sigma, linear }
    };
    sizes.into_iter().map(level).collect()
}
