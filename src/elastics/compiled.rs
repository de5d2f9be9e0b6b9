//! The structure with one vector of values put in: what deforms, what closes loops, and the unknowns of the force method.

use std::borrow::Cow;

use nalgebra::Vector3;

use crate::elements::{Configuration, Deflected, Direction, PerLength, VertexIndex};
use crate::fuzzy;
use crate::kinematics::Placements;
use crate::model::{Edge, Model};
use crate::parameter::Slot;

/// The elastic structure of a model with one vector of values; immutable, shared between threads.
#[derive(Debug, Clone)]
pub struct Elastics<'m> {
    /// The model.
    pub model: &'m Model,
    pub(super) values: Vec<f64>,
    /// Elements of the tree that deform, or whose derivative is asked for, in tree order; then those that close loops.
    pub(super) members: Vec<Member<'m>>,
    /// How many members belong to the tree.
    pub(super) in_tree: usize,
    /// What is known of each closing member.
    pub(super) closings: Vec<Closing>,
    /// Those that close a loop in its plane only.
    pub(super) planar: Vec<usize>,
    /// Released directions of the tree.
    pub(super) releases: Vec<Release>,
    /// Number of unknowns.
    pub(super) unknowns: usize,
    /// For each vertex the tree members between it and the ground, from the vertex on.
    pub(super) paths: Vec<Vec<usize>>,
    /// For each vertex the tree member that ends there.
    pub(super) ending_at: Vec<Option<usize>>,
    /// Elements with a mass per length: vertices, kg/m.
    pub(super) heavy: Vec<([VertexIndex; 2], f64)>,
}

/// An element that takes part.
#[derive(Debug, Clone)]
pub(super) struct Member<'m> {
    pub edge: &'m Edge,
    /// Of a straight uniform element.
    pub per_length: Option<PerLength>,
}

/// A closing member: its cycle in the tree, its unknown forces.
#[derive(Debug, Clone)]
pub(super) struct Closing {
    /// Tree members of its cycle, +1 towards its second end, -1 towards its first.
    pub cycle: Vec<(usize, f64)>,
    /// How its directions are held.
    pub held: [Direction; 6],
    /// Number of its unknown in each direction; none where it carries nothing.
    pub unknown: [Option<usize>; 6],
    /// For each closing: the positions of members that both cycles have, in this one's and in that one's.
    pub shared: Vec<Vec<(usize, usize)>>,
    /// Releases within its cycle: position in it, release.
    pub releases: Vec<(usize, usize)>,
}

/// A released direction of a tree member.
#[derive(Debug, Clone, Copy)]
pub(super) struct Release {
    pub member: usize,
    pub direction: usize,
    pub slot: Option<Slot>,
    pub unknown: usize,
}

impl Closing {
    /// Its unknowns: direction, number.
    pub fn unknowns(&self) -> impl Iterator<Item = (usize, usize)> {
        self.unknown.iter().enumerate().filter_map(|(direction, unknown)| Some((direction, (*unknown)?)))
    }

    /// Whether a direction is a spring (force by gap) rather than a compliance (gap by force).
    pub fn by_stiffness(&self, direction: usize) -> bool {
        self.held[direction] != Direction::Flexible
    }
}

impl<'m> Elastics<'m> {
    /// Values at a placed configuration where springs depend on it; empty where none does.
    pub(super) fn local_values(&self, placements: &Placements, x: &mut Vec<f64>, out: &mut Vec<f64>) {
        let Some(local) = &self.model.local_springs else { return };
        fuzzy::inputs(&local.inputs, placements, x);
        out.clear();
        out.extend_from_slice(&self.values);
        for (slot, rules) in &local.springs {
            out[*slot] = fuzzy::value(rules, x);
        }
    }

    /// Puts `values` (by slot, SI) into the structure. Elements that cannot deform are passed over, unless they have a
    /// parameter among `by`.
    pub fn new(model: &'m Model, values: &[f64], by: &[Slot]) -> Self {
        let structure = &model.structure;
        let mut values = Cow::Borrowed(values);
        for (slot, rules) in model.local_springs.iter().flat_map(|local| &local.springs) {
            // Takes part if it is compliant anywhere.
            values.to_mut()[*slot] = rules.conclusions.iter().copied().fold(0.0, f64::max);
        }
        let values = &*values;
        let per_length = |edge: &Edge| edge.element.per_length(values);
        let member = |edge: &'m Edge| Member { edge, per_length: per_length(edge) };
        let asked = |edge: &Edge| {
            let released = edge.element.directions().into_iter().filter_map(|direction| match direction {
                Direction::Released(slot) => slot,
                _ => None,
            });
            edge.element.parameters().iter().map(|of| of.slot).chain(released).any(|slot| by.contains(&slot))
        };
        let takes_part = |edge: &Edge| edge.element.is_active(values) || asked(edge);
        let heavy = structure.edges().filter_map(|edge| {
            let mass = per_length(edge)?.mass;
            (mass != 0.0).then_some((edge.ends, mass))
        });
        let mut elastics = Self {
            model,
            values: values.to_vec(),
            members: Vec::new(),
            in_tree: 0,
            closings: Vec::new(),
            planar: Vec::new(),
            releases: Vec::new(),
            unknowns: 0,
            paths: Vec::new(),
            ending_at: vec![None; structure.tree.len()],
            heavy: heavy.collect(),
        };
        for (vertex, edge) in structure.tree.iter().enumerate().skip(1).filter(|(_, edge)| takes_part(edge)) {
            elastics.ending_at[vertex] = Some(elastics.members.len());
            elastics.members.push(member(edge));
        }
        elastics.in_tree = elastics.members.len();
        let path = |vertex| structure.path(vertex).filter_map(|v| elastics.ending_at[v]).collect();
        elastics.paths = (0..structure.vertices.len()).map(path).collect();
        for edge in &structure.closures {
            // A loop is closed by what is rigid too; a spring without a rate closes nothing.
            if edge.element.directions() != [Direction::Sprung; 6] || takes_part(edge) {
                elastics.close(member(edge), by);
            }
        }
        elastics.release();
        elastics.find_shared();
        elastics
    }

    fn close(&mut self, member: Member<'m>, by: &[Slot]) {
        let [a, b] = member.edge.ends.map(|end| &self.paths[end]);
        let own = |path: &[usize], other: &[usize], sign: f64| -> Vec<(usize, f64)> {
            path.iter().filter(|m| !other.contains(m)).map(|&m| (m, sign)).collect()
        };
        let cycle = [own(b, a, 1.0), own(a, b, -1.0)].concat();
        let held = member.edge.element.directions();
        let mut unknown = [None; 6];
        for (unknown, direction) in unknown.iter_mut().zip(held) {
            let carries = match direction {
                Direction::Flexible | Direction::Sprung => true,
                Direction::Released(None) => false,
                Direction::Released(Some(slot)) => self.values[slot] != 0.0 || by.contains(&slot),
            };
            if carries {
                *unknown = Some(self.unknowns);
                self.unknowns += 1;
            }
        }
        if member.edge.element.closes_in_plane() {
            self.planar.push(self.closings.len());
        }
        self.closings.push(Closing { cycle, held, unknown, shared: Vec::new(), releases: Vec::new() });
        self.members.push(member);
    }

    fn release(&mut self) {
        for (member, of) in self.members[..self.in_tree].iter().enumerate() {
            for (direction, held) in of.edge.element.directions().into_iter().enumerate() {
                if let Direction::Released(slot) = held {
                    self.releases.push(Release { member, direction, slot, unknown: self.unknowns });
                    self.unknowns += 1;
                }
            }
        }
    }

    fn find_shared(&mut self) {
        let cycles: Vec<Vec<usize>> =
            self.closings.iter().map(|closing| closing.cycle.iter().map(|of| of.0).collect()).collect();
        let position = |cycle: &[usize], member: usize| cycle.iter().position(|known| *known == member);
        for (own, closing) in cycles.iter().zip(&mut self.closings) {
            let with = |other: &Vec<usize>| {
                own.iter().enumerate().filter_map(|(at, &member)| Some((at, position(other, member)?))).collect()
            };
            closing.shared = cycles.iter().map(with).collect();
            let releases = self.releases.iter().enumerate();
            closing.releases =
                releases.filter_map(|(index, release)| Some((position(own, release.member)?, index))).collect();
        }
    }

    /// Values by slot.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Whether anything can deform.
    pub fn is_compliant(&self) -> bool {
        self.in_tree > 0
    }

    /// Masses spread over elements: vertices of its two ends, kg/m.
    pub fn masses_per_length(&self) -> &[([VertexIndex; 2], f64)] {
        &self.heavy
    }

    /// Whether own weight or preloads load the structure.
    pub fn is_loaded(&self) -> bool {
        let structure = &self.model.structure;
        structure.gravity.norm() > 0.0
            && (structure.masses.iter().any(|mass| self.values[mass.slot] != 0.0) || !self.heavy.is_empty())
            || structure.edges().any(|edge| edge.element.is_preloaded())
    }

    /// What elements see of a configuration.
    pub(super) fn configuration<'a>(
        &'a self,
        placements: &'a Placements,
        points: &'a [Vector3<f64>],
        local: &'a [f64],
        deflected: Option<Deflected<'a>>,
    ) -> Configuration<'a> {
        Configuration {
            values: if local.is_empty() { &self.values } else { local },
            frames: &placements.frames,
            joints: &placements.joints,
            points,
            deflected,
        }
    }
}
