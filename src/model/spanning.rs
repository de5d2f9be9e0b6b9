//! A spanning tree of the elastic structure, from the ground; what is left closes its loops.

use nalgebra::Vector3;

use super::Fault;
use super::assemble::Builder;
use super::structure::{Axes, BeamElement, Edge, Element, Law, Lumped, Rigidity, Spot, Structure, VertexIndex};
use crate::description::elastic::BASE_SYMBOLS;
use crate::diagnostic::Diagnostic;
use crate::parameter::Slot;

impl Builder<'_> {
    /// How readily an element becomes part of the tree: rigid first, released last.
    fn weight(&self, edge: &Edge) -> u8 {
        let Element::Lumped(lumped) = &edge.element else { return 1 };
        let value = |slot: Slot| self.model.registry[slot].nominal;
        let rigid = |law: &Law| match *law {
            Law::Rigid => true,
            Law::Compliance(slot) => value(slot) == 0.0,
            Law::Driven { own, axial, .. } => value(own) == 0.0 && value(axial) == 0.0,
            Law::Released(_) => false,
        };
        if lumped.laws.iter().any(|law| matches!(law, Law::Released(_))) {
            2
        } else {
            u8::from(!lumped.laws.iter().all(rigid))
        }
    }

    /// A spanning tree from the ground, vertices renumbered so that each comes after the one it hangs on.
    pub(super) fn hang(mut self) -> Result<Structure, Vec<Fault>> {
        let count = self.structure.vertices.len();
        let mut order: Vec<usize> = (0..self.edges.len()).collect();
        order.sort_by_key(|&edge| self.weight(&self.edges[edge]));
        let mut set: Vec<usize> = (0..count).collect();
        fn find(set: &mut [usize], mut vertex: usize) -> usize {
            while set[vertex] != vertex {
                set[vertex] = set[set[vertex]];
                vertex = set[vertex];
            }
            vertex
        }
        let (mut in_tree, mut rigid_joins, mut closing) = (Vec::new(), 0, Vec::new());
        for edge in order {
            let [a, b] = self.edges[edge].ends.map(|vertex| find(&mut set, vertex));
            if a == b {
                closing.push(edge);
            } else {
                set[a] = b;
                rigid_joins += usize::from(self.weight(&self.edges[edge]) == 0);
                in_tree.push(edge);
            }
        }
        let mut number = vec![usize::MAX; count];
        let mut sequence = vec![0];
        number[0] = 0;
        let void = Element::Lumped(Lumped {
            spot: Spot::At(0, Vector3::zeros()),
            axes: Axes::Frame(0),
            laws: [Law::Rigid; 6],
            symbols: BASE_SYMBOLS,
        });
        let mut tree = vec![Edge { name: String::new(), ends: [0, 0], element: void }];
        let mut at = 0;
        while let Some(&vertex) = sequence.get(at) {
            for &edge in &in_tree {
                let [a, b] = self.edges[edge].ends;
                let other = if a == vertex { b } else { a };
                if (a == vertex || b == vertex) && number[other] == usize::MAX {
                    number[other] = sequence.len();
                    sequence.push(other);
                    let mut edge = self.edges[edge].clone();
                    if edge.ends[0] != vertex
                        && let Element::Beam(BeamElement { rigidity: Rigidity::Section { share, .. }, .. }) =
                            &mut edge.element
                    {
                        share.reverse();
                    }
                    edge.ends = [number[vertex], number[other]];
                    tree.push(edge);
                }
            }
            at += 1;
        }
        for vertex in (0..count).filter(|&vertex| number[vertex] == usize::MAX) {
            let name = self.structure.vertices[vertex].name.clone();
            let message =
                format!("node `{name}` hangs on nothing: no beam, joint or support leads from it to the ground");
            let diagnostic =
                Diagnostic::error(message).remedy("lay a beam to it, or give the joint that holds it `at: <node>`");
            self.faults.push(Fault::new(&["nodes", &name], diagnostic));
        }
        if !self.faults.is_empty() {
            return Err(self.faults);
        }
        let renumber = |edge: &Edge| Edge { ends: edge.ends.map(|vertex| number[vertex]), ..edge.clone() };
        let mut structure = self.structure;
        // The end of a beam that is released has only what it is released in beyond its node's.
        let (ends, released) =
            self.edges.iter().filter_map(Edge::released_end).fold((0, 0), |(n, of), k| (n + 1, of + k));
        let free = 6 * (count - rigid_joins - ends) + released;
        structure.freedom = [free, free - 6];
        structure.closures = closing
            .iter()
            .map(|&edge| renumber(&self.edges[edge]))
            .chain(self.only_closing.iter().map(renumber))
            .collect();
        structure.tree = tree;
        let old = structure.vertices;
        structure.vertices = sequence.iter().map(|&vertex| old[vertex].clone()).collect();
        for edge in structure.tree.iter_mut().chain(&mut structure.closures) {
            if let Element::Lumped(Lumped { axes: Axes::Beam { ends, .. }, .. }) = &mut edge.element {
                *ends = ends.map(|end| number[end]);
            }
        }
        for vertex in &mut structure.vertices {
            if let Spot::Between(ends, _) = &mut vertex.spot {
                *ends = ends.map(|end| number[end]);
            }
        }
        let list = |vertices: &mut Vec<VertexIndex>| vertices.iter_mut().for_each(|v| *v = number[*v]);
        structure.bodies.iter_mut().for_each(list);
        structure.nodes.iter_mut().for_each(|node| node.1 = number[node.1]);
        structure.springs.iter_mut().for_each(|spring| spring.ends = spring.ends.map(|end| number[end]));
        structure.masses.iter_mut().for_each(|mass| mass.vertex = number[mass.vertex]);
        Ok(structure)
    }
}
