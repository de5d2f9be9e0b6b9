//! A spanning tree of the elastic structure, from the ground; what is left closes its loops.

use std::sync::Arc;

use super::Fault;
use super::builder::Builder;
use super::structure::{Edge, Spot, Structure};
use crate::description::elastic::BASE_SYMBOLS;
use crate::diagnostic::Diagnostic;
use crate::elements::{Direction, Lumped, VertexIndex};

/// Edges by what they are for.
#[derive(Default)]
struct Sorted {
    in_tree: Vec<usize>,
    closing: Vec<usize>,
    /// How many of the tree's are rigid.
    rigid: usize,
}

/// Vertices and edges of the tree in the order in which they are reached from the ground.
struct Reached {
    /// New number of each vertex; `usize::MAX` where nothing leads to it.
    number: Vec<usize>,
    /// Vertices in their new order.
    sequence: Vec<usize>,
    tree: Vec<Edge>,
}

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
        let sorted = self.sort();
        let Reached { number, sequence, tree } = self.reach(&sorted.in_tree);
        self.report_loose(&number);
        if !self.faults.is_empty() {
            return Err(self.faults);
        }
        let freedom = self.freedom(sorted.rigid);
        let closing = sorted.closing.iter().filter_map(|&edge| self.edges.get(edge)).chain(&self.only_closing);
        let renumber = |edge: &Edge| Edge { ends: edge.ends.map(|vertex| number[vertex]), ..edge.clone() };
        let closures = closing.map(renumber).collect();
        let old = &self.structure.vertices;
        let vertices = sequence.iter().map(|&vertex| old[vertex].clone()).collect();
        let mut structure = Structure { freedom, closures, tree, vertices, ..self.structure };
        for vertex in &mut structure.vertices {
            if let Spot::Between(ends, _) = &mut vertex.spot {
                *ends = ends.map(|end| number[end]);
            }
        }
        let list = |vertices: &mut Vec<VertexIndex>| vertices.iter_mut().for_each(|v| *v = number[*v]);
        structure.bodies.iter_mut().for_each(list);
        structure.nodes.iter_mut().for_each(|node| node.1 = number[node.1]);
        structure.booms.iter_mut().for_each(|boom| boom.ends = boom.ends.map(|end| number[end]));
        structure.masses.iter_mut().for_each(|mass| mass.vertex = number[mass.vertex]);
        Ok(structure)
    }

    /// Sorts the edges into those of a spanning tree, rigid ones first (Kruskal), and those that close its loops.
    fn sort(&self) -> Sorted {
        fn find(set: &mut [usize], mut vertex: usize) -> usize {
            while set[vertex] != vertex {
                set[vertex] = set[set[vertex]];
                vertex = set[vertex];
            }
            vertex
        }
        let nominal = self.model.registry.nominal();
        let rank = |edge: usize| self.rank(&self.edges[edge], &nominal);
        let mut order: Vec<usize> = (0..self.edges.len()).collect();
        order.sort_by_key(|&edge| rank(edge));
        let mut set: Vec<usize> = (0..self.structure.vertices.len()).collect();
        let mut sorted = Sorted::default();
        for edge in order {
            let [a, b] = self.edges[edge].ends.map(|vertex| find(&mut set, vertex));
            if a == b {
                sorted.closing.push(edge);
            } else {
                set[a] = b;
                sorted.rigid += usize::from(rank(edge) == 0);
                sorted.in_tree.push(edge);
            }
        }
        sorted
    }

    /// Follows the edges of the tree from the ground.
    fn reach(&self, in_tree: &[usize]) -> Reached {
        let mut number = vec![usize::MAX; self.structure.vertices.len()];
        let mut sequence = vec![0];
        number[0] = 0;
        let void = Arc::new(Lumped::rigid(0, BASE_SYMBOLS));
        let mut tree = vec![Edge { name: String::new(), ends: [0, 0], element: void }];
        let mut at = 0;
        while let Some(&vertex) = sequence.get(at) {
            for &edge in in_tree {
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
        Reached { number, sequence, tree }
    }

    /// Faults of the nodes to which nothing leads from the ground.
    fn report_loose(&mut self, number: &[usize]) {
        for (vertex, _) in self.structure.vertices.iter().zip(number).filter(|(_, number)| **number == usize::MAX) {
            let name = &vertex.name;
            let message =
                format!("node `{name}` hangs on nothing: no beam, joint or support leads from it to the ground");
            let diagnostic =
                Diagnostic::error(message).remedy("lay a beam to it, or give the joint that holds it `at: <node>`");
            self.faults.push(Fault::new(&["nodes", name], diagnostic));
        }
    }

    /// Degrees of freedom, and those left with the ground held, of a tree with so many rigid edges.
    fn freedom(&self, rigid: usize) -> [usize; 2] {
        // The end of a beam that is released has only what it is released in beyond its node's.
        let released_ends = self.edges.iter().filter(|edge| edge.element.released_end_of().is_some());
        let (ends, released) = released_ends.fold((0, 0), |(count, directions), edge| {
            let free = edge.element.directions().iter().filter(|direction| **direction != Direction::Flexible).count();
            (count + 1, directions + free)
        });
        let free = 6 * (self.structure.vertices.len() - rigid - ends) + released;
        [free, free - 6]
    }
}
