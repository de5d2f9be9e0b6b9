//! Compliance at the configurations of a campaign, and the share of each element in the strain energy. SI, base axes.

use indexmap::IndexMap;
use nalgebra::Matrix6;

use crate::description::campaign::Campaign;
use crate::model::Model;
use crate::state::{Mechanics, State};

/// Most readings over which shares are taken.
const MOST: usize = 60;
/// Force that stands for a load where none was applied, N, base axes.
const PROBE: [f64; 6] = [0.0, 0.0, -1000.0, 0.0, 0.0, 0.0];

/// Shares of the elements in the strain energy over a campaign.
#[derive(Debug, Clone, PartialEq)]
pub struct StrainEnergy {
    /// Share of the strain energy by element, over all readings taken, the greatest first.
    pub shares: IndexMap<String, f64>,
    /// Whether the campaign's own wrenches load the robot; else 1 kN downwards at the tool.
    pub own_loads: bool,
    /// Readings taken.
    pub readings: usize,
}

/// Compliance at the tool centre point at the placed configuration, base axes, by springs and beams or by fuzzy rules; `None` where
/// the description declares nothing elastic.
pub fn compliance(mechanics: &Mechanics, state: &State) -> Option<Matrix6<f64>> {
    let found = mechanics.compliance(state, &mechanics.point(state, None, &[0.0; 6]));
    // Rules identified component by component are reciprocal only as far as the readings were.
    mechanics.deflects().then(|| 0.5 * (found + found.transpose()))
}

/// Shares of all elements in the strain energy over a campaign, by the loads alone; `None` where nothing is elastic, or rules
/// replace the elements.
pub fn strain_energy(mechanics: &Mechanics, campaign: &Campaign) -> Option<StrainEnergy> {
    if !mechanics.deflects() || mechanics.geometry.model.is_by_rules() {
        return None;
    }
    let own_loads = campaign.readings.iter().any(|reading| reading.wrench.iter().any(|w| *w != 0.0));
    let loaded: Vec<usize> = (0..campaign.readings.len())
        .filter(|&i| !own_loads || campaign.readings[i].wrench.iter().any(|w| *w != 0.0))
        .collect();
    let step = loaded.len().div_ceil(MOST).max(1);
    let mut energy: IndexMap<String, f64> = IndexMap::new();
    let mut state = mechanics.state();
    let mut readings = 0;
    for &index in loaded.iter().step_by(step) {
        let reading = &campaign.readings[index];
        if mechanics.place(campaign.configuration(index), &mut state).is_err() {
            continue;
        }
        let wrench = if own_loads { reading.wrench } else { PROBE };
        let found = mechanics.shares(&state, &mechanics.point(&state, reading.marker, &wrench));
        for (name, share) in &found.energy {
            *energy.entry(name.clone()).or_default() += share * found.total;
        }
        readings += 1;
    }
    let total: f64 = energy.values().sum();
    if total <= 0.0 {
        return None;
    }
    energy.values_mut().for_each(|work| *work /= total);
    energy.sort_by(|_, a, _, b| b.total_cmp(a));
    Some(StrainEnergy { shares: energy, own_loads, readings })
}

/// The reading whose configuration is nearest to the mean of all, each variable in its own spread.
pub fn typical(model: &Model, campaign: &Campaign) -> usize {
    let (width, count) = (model.variables.len(), campaign.readings.len().max(1) as f64);
    let mut mean = vec![0.0; width];
    for index in 0..campaign.readings.len() {
        mean.iter_mut().zip(campaign.configuration(index)).for_each(|(sum, q)| *sum += q / count);
    }
    let mut spread = vec![0.0; width];
    for index in 0..campaign.readings.len() {
        let own = campaign.configuration(index).iter().zip(&mean);
        spread.iter_mut().zip(own).for_each(|(sum, (q, m))| *sum += (q - m).powi(2) / count);
    }
    let far = |index: usize| -> f64 {
        let own = campaign.configuration(index).iter().zip(&mean).zip(&spread);
        own.map(|((q, m), s)| if *s > 0.0 { (q - m).powi(2) / s } else { 0.0 }).sum()
    };
    (0..campaign.readings.len()).min_by(|&a, &b| far(a).total_cmp(&far(b))).unwrap_or(0)
}
