//! Stiffness over a slice of the workspace: the two variables that sweep the greatest area in the plane of distance from
//! the base's axis and height are swept, the others stand still.

use nalgebra::{Matrix3, Point3, Vector2};
use rayon::prelude::*;

use super::strain_energy::compliance;
use crate::kinematics::Placements;
use crate::state::{Mechanics, State};

/// Values of each swept variable.
const STEPS: usize = 25;
/// The same while variables are chosen.
const COARSE: usize = 6;
/// Furthest that an angle is swept to either side, rad.
const FURTHEST: f64 = std::f64::consts::FRAC_PI_2;

/// One configuration of a slice.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// Values of the two swept variables, rad or m.
    pub q: [f64; 2],
    /// Distance from the base's z axis and height of the tool centre point, m.
    pub at: [f64; 2],
    /// Least translational stiffness in any direction, free to turn, N/m.
    pub least: f64,
    /// Displacement in the slice's plane (away from the axis, up) by a force of 1 N in any direction: semi-axes (m/N) as
    /// vectors.
    pub ellipse: [[f64; 2]; 2],
}

/// Stiffness over a slice.
#[derive(Debug, Clone, PartialEq)]
pub struct Slice {
    /// The two variables, by index.
    pub swept: [usize; 2],
    /// Nodes, rows along the first variable; `None` where the robot cannot be assembled or a joint leaves its limits.
    pub nodes: Vec<Vec<Option<Node>>>,
}

impl Slice {
    /// Segments of the line on which the least stiffness is `level` (N/m), in the plane of distance and height, m.
    pub fn iso(&self, level: f64) -> Vec<[[f64; 2]; 2]> {
        let mut segments = Vec::new();
        for rows in self.nodes.windows(2) {
            for k in 0..rows[0].len().saturating_sub(1) {
                let corners = [&rows[0][k], &rows[0][k + 1], &rows[1][k + 1], &rows[1][k]];
                let Some(corners) = corners.into_iter().map(Option::as_ref).collect::<Option<Vec<&Node>>>() else {
                    continue;
                };
                // Two triangles a cell: no ambiguity.
                for triangle in [[0, 1, 2], [0, 2, 3]] {
                    let mut crossed = Vec::new();
                    for edge in 0..3 {
                        let (a, b) = (corners[triangle[edge]], corners[triangle[(edge + 1) % 3]]);
                        if (a.least < level) != (b.least < level) {
                            let share = (level - a.least) / (b.least - a.least);
                            crossed.push([0, 1].map(|k| a.at[k] + share * (b.at[k] - a.at[k])));
                        }
                    }
                    if let [a, b] = crossed[..] {
                        segments.push([a, b]);
                    }
                }
            }
        }
        segments
    }
}

/// Stiffness over the slice through a configuration; `None` where nothing is elastic, or fewer than two variables move the tool.
pub fn slice(mechanics: &Mechanics, q: &[f64]) -> Option<Slice> {
    let (geometry, model) = (&mechanics.geometry, mechanics.geometry.model);
    let mut state = mechanics.state();
    mechanics.place(q, &mut state).ok()?;
    compliance(mechanics, &state)?;
    let range = |k: usize| {
        let variable = &model.variables[k];
        let [low, high] = variable.limits.filter(|l| l.iter().all(|v| v.is_finite())).unwrap_or([-10.0, 10.0]);
        if variable.is_angle { [low.max(q[k] - FURTHEST), high.min(q[k] + FURTHEST)] } else { [low, high] }
    };
    let at = |q: &[f64], placements: &mut Placements| -> Option<Vector2<f64>> {
        geometry.place(q, placements).ok()?;
        let point = (placements.frames[model.tool.0] * Point3::from(geometry.tool().translation.vector)).coords;
        Some(Vector2::new(point.x.hypot(point.y), point.z))
    };
    let value = |k: usize, step: usize, steps: usize| {
        let [low, high] = range(k);
        low + (high - low) * step as f64 / (steps - 1) as f64
    };
    // The pair that sweeps the greatest area.
    let swept = |&(i, j): &(usize, usize)| -> f64 {
        let mut placements = Placements::default();
        let mut own = q.to_vec();
        let mut grid = [[None; COARSE]; COARSE];
        for (a, row) in grid.iter_mut().enumerate() {
            for (b, cell) in row.iter_mut().enumerate() {
                (own[i], own[j]) = (value(i, a, COARSE), value(j, b, COARSE));
                *cell = at(&own, &mut placements);
            }
        }
        let cells = (0..COARSE - 1).flat_map(|a| (0..COARSE - 1).map(move |b| (a, b)));
        let area = cells.filter_map(|(a, b)| {
            let (here, along, across) = (grid[a][b]?, grid[a + 1][b]?, grid[a][b + 1]?);
            Some((along - here).perp(&(across - here)).abs())
        });
        area.sum()
    };
    let pairs = (0..q.len()).flat_map(|i| (i + 1..q.len()).map(move |j| (i, j)));
    let areas: Vec<((usize, usize), f64)> = pairs.map(|pair| (pair, swept(&pair))).collect();
    let &((first, second), area) = areas.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    if area < 1e-9 {
        return None;
    }
    let nodes: Vec<Vec<Option<Node>>> = (0..STEPS)
        .into_par_iter()
        .map(|i| {
            let mut state = mechanics.state();
            let node = |j: usize| {
                let mut own = q.to_vec();
                own[first] = value(first, i, STEPS);
                own[second] = value(second, j, STEPS);
                node(mechanics, &own, [own[first], own[second]], &mut state)
            };
            (0..STEPS).map(node).collect()
        })
        .collect();
    Some(Slice { swept: [first, second], nodes })
}

fn node(mechanics: &Mechanics, q: &[f64], swept: [f64; 2], state: &mut State) -> Option<Node> {
    mechanics.place(q, state).ok()?;
    let inside = |(frame, joint): (&crate::model::Frame, &f64)| {
        frame.limits.is_none_or(|[low, high]| (low - 1e-9..=high + 1e-9).contains(joint) || !frame.moves())
    };
    if !mechanics.geometry.model.frames.iter().zip(&state.placements.joints).all(inside) {
        return None;
    }
    let compliance = compliance(mechanics, state)?;
    let translation: Matrix3<f64> = compliance.fixed_view::<3, 3>(0, 0).into_owned();
    let greatest = translation.symmetric_eigenvalues().max();
    if !(greatest.is_finite() && greatest > 0.0) {
        return None;
    }
    let point = mechanics.point(state, None, &[0.0; 6]).position;
    let radius = point.x.hypot(point.y);
    let away = if radius > 1e-9 { [point.x / radius, point.y / radius] } else { [1.0, 0.0] };
    // Rows: displacement away from the axis and up, by a force in any direction.
    let plane = nalgebra::Matrix2x3::new(away[0], away[1], 0.0, 0.0, 0.0, 1.0) * translation;
    let squares = (plane * plane.transpose()).symmetric_eigen();
    let ellipse = [0, 1].map(|k| {
        let axis = squares.eigenvectors.column(k) * squares.eigenvalues[k].max(0.0).sqrt();
        [axis[0], axis[1]]
    });
    Some(Node { q: swept, at: [radius, point.z], least: greatest.recip(), ellipse })
}
