//! Compliance at the configurations of a campaign, and the share of each element in the strain energy. SI, base axes.

use indexmap::IndexMap;
use nalgebra::{Matrix6, Point3, Vector3};

use crate::description::campaign::Campaign;
use crate::elastics::{Elastics, Mechanism, Response, Statics, shares, spatial};
use crate::fuzzy;
use crate::kinematics::{Geometry, Placements};
use crate::model::Model;

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

/// Compliance at the tool centre point at a placed configuration, base axes, by springs and beams or by rules; `None` where
/// the description declares nothing elastic.
///
/// # Errors
/// A structure that can move without any force.
pub fn compliance(geometry: &Geometry, q: &[f64], placements: &Placements) -> Result<Option<Matrix6<f64>>, Mechanism> {
    let elastics = Elastics::new(geometry.model, geometry.values(), &[]);
    if !elastics.is_compliant() && geometry.model.fuzzy.is_none() {
        return Ok(None);
    }
    let local = geometry.tool().translation.vector;
    let frame = geometry.model.tool.0;
    let mut statics = Statics::new(false);
    elastics.prepare(placements, &mut statics)?;
    let mut response = Response::new(&elastics, geometry.model.structure.carrier(frame, &local));
    response.evaluate(&elastics, &mut statics);
    fuzzy::put(geometry, q, placements, &mut response);
    let found = response.compliance_at(&(placements.frames[frame] * Point3::from(local)).coords);
    // Rules identified component by component are reciprocal only as far as the readings were.
    Ok(Some(0.5 * (found + found.transpose())))
}

/// Shares of all elements in the strain energy over a campaign; `None` where nothing is elastic, or rules replace the
/// elements.
pub fn strain_energy(geometry: &Geometry, campaign: &Campaign) -> Option<StrainEnergy> {
    let model = geometry.model;
    let elastics = Elastics::new(model, geometry.values(), &[]);
    if !elastics.is_compliant() || model.is_by_rules() {
        return None;
    }
    let own_loads = campaign.readings.iter().any(|reading| reading.wrench.iter().any(|w| *w != 0.0));
    let loaded: Vec<usize> = (0..campaign.readings.len())
        .filter(|&i| !own_loads || campaign.readings[i].wrench.iter().any(|w| *w != 0.0))
        .collect();
    let step = loaded.len().div_ceil(MOST).max(1);
    let mut energy: IndexMap<String, f64> = IndexMap::new();
    let (mut placements, mut statics) = (Placements::default(), Statics::new(false));
    let mut readings = 0;
    for &index in loaded.iter().step_by(step) {
        let reading = &campaign.readings[index];
        let (frame, local) = match reading.marker {
            Some(marker) => (model.markers[marker].frame, geometry.marker(marker).coords),
            None => (model.tool.0, geometry.tool().translation.vector),
        };
        if geometry.place(campaign.configuration(index), &mut placements).is_err()
            || elastics.prepare(&placements, &mut statics).is_err()
        {
            continue;
        }
        let mut response = Response::new(&elastics, model.structure.carrier(frame, &local));
        response.evaluate(&elastics, &mut statics);
        let [fx, fy, fz, mx, my, mz] = if own_loads { reading.wrench } else { PROBE };
        let at = (placements.frames[frame] * Point3::from(local)).coords;
        let load = spatial(&at, &Vector3::new(fx, fy, fz), &Vector3::new(mx, my, mz));
        let found = shares(&elastics, &statics, &response, &load, false);
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
