//! Shares of the strain energy by element, and displacements of all nodes.

use indexmap::IndexMap;
use nalgebra::Vector6;

use super::compiled::Elastics;
use super::load_case::{Load, LoadCase};
use super::response::{Response, at_point};
use super::statics::Statics;

/// What each element contributes to a deflection.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Shares {
    /// Share of the strain energy by element and direction (`joint:2.kar`, `beam:b1`), adding up to one. Under a single
    /// wrench on the tool this is the element's share in the displacement along that wrench.
    pub energy: IndexMap<String, f64>,
    /// Displacement and rotation of each node, m and rad, base axes.
    pub nodes: IndexMap<String, [f64; 6]>,
    /// Strain energy, J.
    pub total: f64,
}

/// Shares and node displacements under a spatial wrench on the response's vertex, own weight added if asked.
pub fn shares(
    elastics: &Elastics,
    statics: &Statics,
    response: &Response,
    wrench: &Vector6<f64>,
    weight: bool,
) -> Shares {
    let structure = &elastics.model.structure;
    let case = LoadCase::new(elastics, statics, response, Load { wrench: *wrench, weight });
    let mut energy: IndexMap<String, f64> = IndexMap::new();
    let mut add = |name: String, work: f64| {
        if work != 0.0 {
            *energy.entry(name).or_default() += work;
        }
    };
    for (member, of) in elastics.members.iter().enumerate() {
        let forces = case.forces(member).total;
        // A beam's own weight bends it along its length: what end forces do with that counts whole, what they do themselves by half.
        let (sag, alone) = match case.load.weight {
            true => (elastics.sag(member, statics), elastics.sag_energy(member, statics)),
            false => (Vector6::zeros(), 0.0),
        };
        let mut strain = case.deformation(member).total - sag;
        if let Some(closing) = member.checked_sub(elastics.in_tree) {
            // The gap's rounding would do work against what is rigid.
            let own = statics.placed[member].flexibility.apply(&forces);
            let by_stiffness = |k| elastics.closings[closing].by_stiffness(k);
            strain = Vector6::from_fn(|k, _| if by_stiffness(k) { strain[k] } else { own[k] });
        }
        match of.edge.element.symbols() {
            Some(symbols) => symbols
                .iter()
                .enumerate()
                .for_each(|(k, symbol)| add(format!("{}.{symbol}", of.edge.name), 0.5 * forces[k] * strain[k])),
            None => add(of.edge.name.clone(), 0.5 * forces.dot(&strain) + forces.dot(&sag) + alone),
        }
    }
    let total: f64 = energy.values().sum();
    if total != 0.0 {
        energy.values_mut().for_each(|work| *work /= total);
        // What is rigid or free does no work but for rounding.
        energy.retain(|_, share| share.abs() > 1e-12);
    }
    energy.sort_by(|_, a, _, b| b.total_cmp(a));
    let twists = twists(elastics, statics, response, wrench, weight);
    let nodes = structure.nodes.iter().map(|(name, vertex)| {
        let (d, r) = at_point(&twists[*vertex], &statics.points[*vertex]);
        (name.clone(), [d.x, d.y, d.z, r.x, r.y, r.z])
    });
    Shares { energy, nodes: nodes.collect(), total }
}

/// Spatial twist of every vertex, by vertex, under a spatial wrench on the response's vertex, own weight added if asked.
pub fn twists(
    elastics: &Elastics,
    statics: &Statics,
    response: &Response,
    wrench: &Vector6<f64>,
    weight: bool,
) -> Vec<Vector6<f64>> {
    let case = LoadCase::new(elastics, statics, response, Load { wrench: *wrench, weight });
    let strains: Vec<Vector6<f64>> = (0..elastics.in_tree)
        .map(|member| statics.placed[member].local.tr_mul(&case.deformation(member).total))
        .collect();
    elastics.paths.iter().map(|path| path.iter().map(|&member| strains[member]).sum()).collect()
}
