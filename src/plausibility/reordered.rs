//! Joint columns in another order: numbered from the tool, or with an external axis at the other end.

use std::f64::consts::PI;

use crate::model::Model;

/// In which order the columns of the joints are meant to stand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reordered {
    /// The way.
    pub order: Order,
    /// Lengths over angles of the columns, m/rad over the numbers as they are written: what a number that was read as a length
    /// counts as an angle.
    pub turn: f64,
}

/// An order of joint columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// The last one first.
    Reversed,
    /// Each joint's value stands so many columns further on, those at the end before the first.
    MovedOn(usize),
}

/// Angle over length units of tables: deg and mm, rad and m, deg and m, rad and mm.
pub const TURNS: [f64; 4] = [PI / 180.0 / 1e-3, 1.0, PI / 180.0, 1e3];

impl Order {
    /// The column in which the value of joint `k` of `count` stands.
    fn column(self, k: usize, count: usize) -> usize {
        match self {
            Self::Reversed => count - 1 - k,
            Self::MovedOn(by) => (k + by) % count,
        }
    }
}

impl Reordered {
    /// All orders of the joints of a robot; where angles and lengths change places, in each pair of units.
    pub fn all(model: &Model) -> Vec<Self> {
        let count = model.variables.len();
        // Two joints that change places are said as that.
        if count < 3 {
            return Vec::new();
        }
        let orders = std::iter::once(Order::Reversed).chain((1..count).map(Order::MovedOn));
        let is_angle = |k: usize| model.variables[k].is_angle;
        let with_turns = |order: Order| {
            let is_mixed = (0..count).any(|k| is_angle(k) != is_angle(order.column(k, count)));
            let turns = if is_mixed { &TURNS[..] } else { &TURNS[..1] };
            turns.iter().map(move |&turn| Self { order, turn })
        };
        orders.flat_map(with_turns).collect()
    }

    /// Puts the values of a configuration in their order.
    pub fn apply(&self, model: &Model, q: &mut [f64]) {
        let old = q.to_vec();
        let is_angle = |k: usize| model.variables[k].is_angle;
        for (k, value) in q.iter_mut().enumerate() {
            let column = self.order.column(k, old.len());
            let factor = match (is_angle(k), is_angle(column)) {
                (true, false) => self.turn,
                (false, true) => 1.0 / self.turn,
                _ => 1.0,
            };
            *value = factor * old[column];
        }
    }
}
