//! A structure at a configuration under load, for the tests of deflections; and a second way to compute it: beams and
//! joint springs assembled by the displacement method.

use elastogeo::elastics::{Elastics, Mechanism, Response, Shares, Statics, at_point, shares, spatial};
use elastogeo::kinematics::{Geometry, Placements};
use elastogeo::model::Model;
use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Point3, SMatrix, Vector3, Vector6};

pub fn placed(model: &Model, values: &[f64], q: &[f64]) -> Placements {
    let mut placements = Placements::default();
    Geometry::new(model, values).expect("assembled").place(q, &mut placements).expect("placed");
    placements
}

pub fn node(model: &Model, name: &str) -> usize {
    model.structure.nodes.iter().find(|(known, _)| known == name).expect("a node").1
}

/// Statics and the response of one vertex.
pub fn respond<'m>(
    model: &'m Model,
    values: &[f64],
    q: &[f64],
    vertex: usize,
    weight: bool,
) -> Result<(Elastics<'m>, Statics, Response), Mechanism> {
    let placements = placed(model, values, q);
    let elastics = Elastics::new(model, values, &[]);
    let mut statics = Statics::new(weight);
    elastics.prepare(&placements, &mut statics)?;
    let mut response = Response::new(&elastics, vertex);
    response.evaluate(&elastics, &mut statics);
    Ok((elastics, statics, response))
}

/// Displacement and rotation of a point of a frame by a wrench on it, base axes.
pub fn deflection(
    model: &Model,
    values: &[f64],
    q: &[f64],
    (frame, local): (&str, [f64; 3]),
    wrench: &[f64],
    weight: bool,
) -> Vector6<f64> {
    let frame = model.frame(frame).expect("a frame");
    let local = Vector3::from(local);
    let point = (placed(model, values, q).frames[frame] * Point3::from(local)).coords;
    let (_, _, response) =
        respond(model, values, q, model.structure.carrier(frame, &local), weight).expect("no mechanism");
    let load = spatial(&point, &Vector3::from_column_slice(&wrench[..3]), &Vector3::from_column_slice(&wrench[3..6]));
    let (d, r) = at_point(&response.twist(&load, weight), &point);
    Vector6::new(d.x, d.y, d.z, r.x, r.y, r.z)
}

/// Displacements of all nodes under wrenches at some of them (base axes, by name), own weight if asked.
pub fn node_displacements(
    model: &Model,
    q: &[f64],
    loads: &[(&str, Vector6<f64>)],
    weight: bool,
) -> Vec<(String, Vector6<f64>)> {
    let values = model.registry.nominal();
    let mut all: Vec<(String, Vector6<f64>)> =
        model.structure.nodes.iter().map(|(name, _)| (name.clone(), Vector6::zeros())).collect();
    let mut add = |found: Shares| {
        for (sum, (name, own)) in all.iter_mut().zip(found.nodes) {
            assert_eq!(sum.0, name);
            sum.1 += Vector6::from(own);
        }
    };
    for (name, load) in loads {
        let (elastics, statics, response) = respond(model, &values, q, node(model, name), false).expect("no mechanism");
        let (force, moment) = (load.fixed_rows::<3>(0).into_owned(), load.fixed_rows::<3>(3).into_owned());
        let load = spatial(&statics.points[response.vertex], &force, &moment);
        add(shares(&elastics, &statics, &response, &load, false));
    }
    if weight {
        let (elastics, statics, response) = respond(model, &values, q, 1, true).expect("no mechanism");
        add(shares(&elastics, &statics, &response, &Vector6::zeros(), true));
    }
    all
}

/// A beam's 12x12 stiffness in local axes from textbook entries (Przemieniecki 1968), shear areas infinite for
/// Euler-Bernoulli.
pub fn beam_stiffness(e: f64, g: f64, [a, iy, iz, j]: [f64; 4], [asy, asz]: [f64; 2], l: f64) -> SMatrix<f64, 12, 12> {
    let mut k = SMatrix::<f64, 12, 12>::zeros();
    let mut pair = |p: usize, q: usize, value: f64| {
        k[(p, q)] = value;
        k[(q, p)] = value;
    };
    for (first, value) in [(0, e * a / l), (3, g * j / l)] {
        pair(first, first, value);
        pair(first + 6, first + 6, value);
        pair(first, first + 6, -value);
    }
    // Bending in x-y (v, phi_z) and x-z (w, phi_y), which differ by the sign of the coupling.
    for (v, phi, i, area, sign) in [(1, 5, iz, asy, 1.0), (2, 4, iy, asz, -1.0)] {
        let phi_s = 12.0 * e * i / (g * area * l * l);
        let b = e * i / (l * l * l * (1.0 + phi_s));
        for (end, other, direction) in [(0, 6, 1.0), (6, 0, -1.0)] {
            pair(v + end, v + end, 12.0 * b);
            pair(phi + end, phi + end, (4.0 + phi_s) * l * l * b);
            pair(v + end, phi + end, sign * direction * 6.0 * l * b);
            pair(v + end, phi + other, sign * direction * 6.0 * l * b);
        }
        pair(v, v + 6, -12.0 * b);
        pair(phi, phi + 6, (2.0 - phi_s) * l * l * b);
    }
    k
}

/// How a direction of a joint is put into the assembly.
#[derive(Clone, Copy, PartialEq)]
pub enum Held {
    /// Not at all.
    Free,
    /// By a spring of its own unknown.
    By(f64),
    /// Exactly.
    Rigid,
}

/// Beams and joints assembled by the displacement method.
pub struct Assembly {
    /// Displacement of each node by the generalised unknowns.
    nodes: Vec<DMatrix<f64>>,
    stiffness: DMatrix<f64>,
    load: DVector<f64>,
}

impl Assembly {
    /// Nodes with six unknowns each, but for slaves `(node, master, axes, directions)`: these follow their master, and
    /// have an unknown in each direction that is not rigid.
    pub fn new(count: usize, slaves: &[(usize, usize, Matrix3<f64>, [Held; 6])]) -> Self {
        let own = |node: usize| slaves.iter().find(|slave| slave.0 == node);
        let unknowns: usize = (0..count)
            .map(|node| own(node).map_or(6, |slave| slave.3.iter().filter(|held| **held != Held::Rigid).count()))
            .sum();
        let mut assembly = Self {
            nodes: vec![DMatrix::zeros(6, unknowns); count],
            stiffness: DMatrix::zeros(unknowns, unknowns),
            load: DVector::zeros(unknowns),
        };
        let mut next = 0;
        for node in (0..count).filter(|node| own(*node).is_none()) {
            (0..6).for_each(|k| assembly.nodes[node][(k, next + k)] = 1.0);
            next += 6;
        }
        for (node, master, axes, held) in slaves {
            assembly.nodes[*node] = assembly.nodes[*master].clone();
            for (k, held) in held.iter().enumerate().filter(|(_, held)| **held != Held::Rigid) {
                let block = 3 * (k / 3);
                (0..3).for_each(|row| assembly.nodes[*node][(block + row, next)] = axes[(row, k % 3)]);
                if let Held::By(stiffness) = held {
                    assembly.stiffness[(next, next)] += stiffness;
                }
                next += 1;
            }
        }
        assembly
    }

    /// Adds a beam, its local axes the columns of `axes`; `weight` per length along its length, base axes.
    pub fn beam(
        &mut self,
        [a, b]: [usize; 2],
        axes: &Matrix3<f64>,
        k: &SMatrix<f64, 12, 12>,
        weight: (f64, Vector3<f64>),
    ) {
        let unknowns = self.load.len();
        let mut local = DMatrix::zeros(12, unknowns);
        for (block, node) in [(0, a), (3, a), (6, b), (9, b)] {
            let part = axes.transpose() * self.nodes[node].fixed_rows::<3>(block % 6);
            local.fixed_rows_mut::<3>(block).copy_from(&part);
        }
        self.stiffness += local.transpose() * k * &local;
        let (length, force) = weight;
        let half = axes.transpose() * force * (0.5 * length);
        let turn = Vector3::x().cross(&half) * (length / 6.0);
        let mut load = DVector::zeros(12);
        for (block, part) in [(0, half), (3, turn), (6, half), (9, -turn)] {
            load.fixed_rows_mut::<3>(block).copy_from(&part);
        }
        self.load += local.transpose() * load;
    }

    /// Adds springs between two nodes at one point, along and about the columns of `axes`.
    pub fn springs(&mut self, [a, b]: [usize; 2], axes: &Matrix3<f64>, k: [f64; 6]) {
        let relative = &self.nodes[b] - &self.nodes[a];
        let mut local = relative.clone();
        for block in [0, 3] {
            let part = axes.transpose() * relative.fixed_rows::<3>(block);
            local.fixed_rows_mut::<3>(block).copy_from(&part);
        }
        let diagonal = DMatrix::from_diagonal(&DVector::from_row_slice(&k));
        self.stiffness += local.transpose() * diagonal * &local;
    }

    /// Compliance of a node and its displacement under own weight, the first six unknowns held.
    pub fn solve(&self, node: usize) -> (Matrix6<f64>, Vector6<f64>) {
        let free = self.load.len() - 6;
        let factored = self.stiffness.view((6, 6), (free, free)).into_owned().lu();
        let to_node = self.nodes[node].columns(6, free).into_owned();
        let by_unit = factored.solve(&to_node.transpose()).expect("regular");
        let by_weight = factored.solve(&self.load.rows(6, free).into_owned()).expect("regular");
        let compliance = &to_node * by_unit;
        let displacement = &to_node * by_weight;
        (Matrix6::from_fn(|i, j| compliance[(i, j)]), Vector6::from_fn(|i, _| displacement[i]))
    }
}
