//! Who gives how much: shares of the strain energy, and displacements of all nodes.

use indexmap::IndexMap;
use nalgebra::Vector6;

use super::at_point;
use super::response::{Response, twist_of};
use super::statics::{ClosingKind, Elastics, Statics};
use crate::model::Element;

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
    let weight = weight && statics.weight.active;
    let strain = |vertex: usize| -> Vector6<f64> {
        let own = response.strains[vertex] * wrench;
        if weight { own + statics.weight.strains[vertex] } else { own }
    };
    let force = |vertex: usize| -> Vector6<f64> {
        let own = response.forces[vertex] * wrench;
        if weight { own + statics.weight.forces[vertex] } else { own }
    };
    let mut energy: IndexMap<String, f64> = IndexMap::new();
    let mut add = |name: String, work: f64| {
        if work != 0.0 {
            *energy.entry(name).or_default() += work;
        }
    };
    // Springs at a point by direction, all else whole; the parts of a beam are one.
    let mut lumped = |name: &str, element: Option<&Element>, force: &Vector6<f64>, strain: &Vector6<f64>| match element
    {
        Some(Element::Lumped(of)) => {
            (0..6).for_each(|k| add(format!("{name}.{}", of.symbols[k]), 0.5 * force[k] * strain[k]));
        }
        _ => add(name.split('/').next().unwrap_or(name).to_string(), 0.5 * force.dot(strain)),
    };
    for &vertex in &elastics.active {
        let edge = &structure.tree[vertex];
        lumped(&edge.name, Some(&edge.element), &force(vertex), &strain(vertex));
    }
    for (closing, state) in elastics.closings.iter().zip(&statics.closings) {
        let mut forces = response.closing_forces(closing) * wrench;
        if weight {
            forces += statics.closing_forces(closing);
        }
        let gap: Vector6<f64> =
            closing.cycle.iter().zip(&state.forces).map(|((vertex, _), f)| f.tr_mul(&strain(*vertex))).sum();
        match closing.kind {
            ClosingKind::Element(which) => {
                let edge = &structure.closures[which];
                let mut own = state.flexibility.apply(&forces);
                for k in 0..6 {
                    if elastics.by_stiffness(closing, k) {
                        own[k] = -gap[k];
                    }
                }
                lumped(&edge.name, Some(&edge.element), &forces, &own);
            }
            ClosingKind::Spring(which) => {
                let name = format!("spring:{}", structure.springs[which].spring.name);
                lumped(&name, None, &-forces, &gap);
            }
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
    let nodes = structure
        .nodes
        .iter()
        .map(|(name, vertex)| {
            let (d, r) = at_point(&twists[*vertex], &statics.points[*vertex]);
            (name.clone(), [d.x, d.y, d.z, r.x, r.y, r.z])
        })
        .collect();
    Shares { energy, nodes, total }
}

/// Spatial twist of every vertex, by vertex, under a spatial wrench on the response's vertex, own weight added if asked.
pub fn twists(
    elastics: &Elastics,
    statics: &Statics,
    response: &Response,
    wrench: &Vector6<f64>,
    weight: bool,
) -> Vec<Vector6<f64>> {
    let weight = weight && statics.weight.active;
    let strain = |vertex: usize| -> Vector6<f64> {
        let own = response.strains[vertex] * wrench;
        if weight { own + statics.weight.strains[vertex] } else { own }
    };
    (0..elastics.model.structure.vertices.len()).map(|vertex| twist_of(elastics, statics, vertex, strain)).collect()
}
