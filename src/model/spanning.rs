//! A spanning tree of the elastic structure, from the ground; what is left closes its loops.

use std::sync::Arc;

use super::Fault;
use super::assemble::Builder;
use super::structure::{Edge, Spot, Structure};
use crate::description::elastic::BASE_SYMBOLS;
use crate::diagnostic::Diagnostic;
use crate::elements::{Direction, Lumped, VertexIndex};

impl Builder<'_> {
    /// How readily an element becomes part of the tree: rigid first, released last.
    fn rank(&self, edge: &Edge, nominal: &[f64]) -> u8 {
        if edge.element.directions().iter().any(|direction| *direction != Direction::Flexible) {
            2
        } else {
            u8::from(!edge.element.is_rigid(nominal))
        }
    }

    /// A spanning tree from the ground, vertices renumbered so that each comes after the one it hangs on.
    pub(super) fn hang(mut self) -> Result<Structure, Vec<Fault>> {
        let count = self.structure.vertices.len();
        let mut order: Vec<usize> = (0..self.edges.len()).collect();
        let nominal = self.model.registry.nominal();
        let rank = |edge: usize| self.rank(&self.edges[edge], &nominal);
        order.sort_by_key(|&edge| rank(edge));
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
                rigid_joins += usize::from(rank(edge) == 0);
                in_tree.push(edge);
            }
        }
        let mut number = vec![usize::MAX; count];
        let mut sequence = vec![0];
        number[0] = 0;
        let void = Arc::new(Lumped::rigid(0, BASE_SYMBOLS));
        let mut tree = vec![Edge { name: String::new(), ends: [0, 0], element: void }];
        let mut at = 0;
        while let Some(&vertex) = sequence.get(at) {
            for &edge in &in_tree {
                let [a, b] = self.edges[edge].ends;
                let other = if a == vertex { b } else { a };
                if (a == vertex || b == vertex) && number[other] == usize::MAX {
                    number[other] = sequence.len();
                    sequence.push(other);
                    let ends = [number[vertex], number[other]];
                    tree.push(Edge { ends, ..self.edges[edge].clone() });
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
        let released_ends = self.edges.iter().filter(|edge| edge.element.released_end_of().is_some());
        let (ends, released) = released_ends.fold((0, 0), |(count, directions), edge| {
            let free = edge.element.directions().iter().filter(|direction| **direction != Direction::Flexible).count();
            (count + 1, directions + free)
        });
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
        for vertex in &mut structure.vertices {
            if let Spot::Between(ends, _) = &mut vertex.spot {
                *ends = ends.map(|end| number[end]);
            }
        }
        let list = |vertices: &mut Vec<VertexIndex>| vertices.iter_mut().for_each(|v| *v = number[*v]);
        structure.bodies.iter_mut().for_each(list);
        structure.nodes.iter_mut().for_each(|node| node.1 = number[node.1]);
        structure.masses.iter_mut().for_each(|mass| mass.vertex = number[mass.vertex]);
        Ok(structure)
    }
}
