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
    /// Frame, by index, whose axes the components have; `None` is the base.
    pub axes: Option<usize>,
    /// Whether the components are added to the springs and beams.
    pub adds: bool,
    /// Components of the compliance.
    pub components: Vec<Component>,
}

/// One component of the compliance.
#[derive(Debug, Clone, PartialEq)]
pub struct Component {
    /// Row (x, y, z, rx, ry, rz) and column (fx, .., mz).
    pub at: [usize; 2],
    /// Its rules; conclusions in m or rad per N or N.m.
    pub rules: Rules,
}

/// Springs whose compliance depends on the configuration: local springs, blended by the weights of rules.
///
/// Source: IR663 calibration paper, outlook (rules between parametric models).
#[derive(Debug, Clone, PartialEq)]
pub struct SpringRules {
    /// Inputs of the rules.
    pub inputs: Vec<Input>,
    /// Parameter (`joint2.kar`) and its rules; conclusions are stiffnesses in the unit of the description, infinite where
    /// rigid.
    pub springs: Vec<(String, Rules)>,
    /// SI units in the description's unit of a translational and of a rotational stiffness.
    pub units: [f64; 2],
}

/// Rules: premises whose weights sum to one, and the conclusion of each.
#[derive(Debug, Clone, PartialEq)]
pub struct Rules {
    /// Premises.
    pub premise: Premise,
    /// Conclusion of each rule.
    pub conclusions: Vec<f64>,
}

/// Premises of rules.
#[derive(Debug, Clone, PartialEq)]
pub enum Premise {
    /// All combinations of the sets of each input: modal values, ascending, rad or m; the last input's sets count fastest.
    Grid(Vec<Vec<f64>>),
    /// Splits along one input each.
    Tree(Tree),
}

/// A binary tree whose leaves are the rules, numbered in the order in which splits name them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tree {
    /// Splits, the first one the root; without any there is one rule.
    pub splits: Vec<Split>,
}

/// A split: the weight goes linearly from `below` to `above`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Split {
    /// Which input.
    pub input: usize,
    /// Between which values of it, rad or m.
    pub between: [f64; 2],
    /// What holds below and above.
    pub branches: [Branch; 2],
}

/// What a split leads to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Branch {
    /// A split that stands later in the list.
    Split(usize),
    /// A rule.
    Rule(usize),
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

impl Premise {
    /// Values of an input at which the rules change, ascending, rad or m: modal values, or ends of splits. A single one or
    /// none where the input has no influence.
    pub fn marks(&self, input: usize) -> Vec<f64> {
        match self {
            Self::Grid(modes) => modes.get(input).cloned().unwrap_or_default(),
            Self::Tree(tree) => {
                let mut marks: Vec<f64> =
                    tree.splits.iter().filter(|split| split.input == input).flat_map(|split| split.between).collect();
                marks.sort_by(f64::total_cmp);
                marks.dedup();
                marks
            }
        }
    }
}

impl Rules {
    /// The same rules over some of their inputs, where the others have no influence.
    #[must_use]
    pub fn over(&self, inputs: &[usize]) -> Self {
        let premise = match &self.premise {
            Premise::Grid(modes) => Premise::Grid(inputs.iter().filter_map(|&k| modes.get(k).cloned()).collect()),
            Premise::Tree(tree) => {
                let kept = |split: &Split| {
                    let input = inputs.iter().position(|k| *k == split.input).unwrap_or(split.input);
                    Split { input, ..*split }
                };
                Premise::Tree(Tree { splits: tree.splits.iter().map(kept).collect() })
            }
        };
        Self { premise, conclusions: self.conclusions.clone() }
    }
}
