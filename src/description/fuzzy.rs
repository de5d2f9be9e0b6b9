//! A fuzzy compliance as declared: names resolved, SI.

/// What a compliance depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Input {
    /// The joint variable of a frame, by index: rad or m.
    Joint(usize),
    /// An actuated variable, by index: rad or m.
    Variable(usize),
}

/// A Takagi-Sugeno model of order zero of the compliance of a point of the tool.
///
/// Source: IR663 calibration paper, eq. (33) to (38) and (70).
#[derive(Debug, Clone, PartialEq)]
pub struct Fuzzy {
    /// Inputs in the order of modes.
    pub inputs: Vec<Input>,
    /// The marker whose displacement it gives; `None` is the tool centre point.
    pub at: Option<usize>,
    /// Whether it is added to the springs and beams.
    pub adds: bool,
    /// Its components.
    pub components: Vec<Component>,
}

/// One component of the compliance.
#[derive(Debug, Clone, PartialEq)]
pub struct Component {
    /// Row (x, y, z, rx, ry, rz) and column (fx, .., mz).
    pub at: [usize; 2],
    /// Modal values of each input, ascending, rad or m.
    pub modes: Vec<Vec<f64>>,
    /// Conclusions, m or rad per N or N.m; the last input's sets count fastest.
    pub conclusions: Vec<f64>,
}

/// Displacements, by row.
pub const DISPLACEMENTS: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];
/// Loads, by column.
pub const LOADS: [&str; 6] = ["fx", "fy", "fz", "mx", "my", "mz"];

impl Component {
    /// Name of the component at a row and column.
    pub fn name(at: [usize; 2]) -> String {
        format!("{}.{}", DISPLACEMENTS[at[0] % 6], LOADS[at[1] % 6])
    }
}
