//! Why a mechanism cannot be put together.

/// The mechanism cannot be put together.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AssemblyError {
    /// A closed loop does not close.
    #[error("loop {} cannot close{branch}: the frames that should meet stay {gap} apart", quoted(name, others))]
    Loop {
        /// The loop, or the first of those that are closed together.
        name: String,
        /// The others that are closed together with it.
        others: Vec<String>,
        /// Smallest gap reached.
        gap: Gap,
        /// What was said about the branch.
        branch: &'static str,
    },
    /// A closed loop's declared assembly branch does not lead there: two assemblies meet on the way.
    #[error(
        "loop {} {} (passive joints {}); on which assembly it goes on is not known",
        quoted(name, others),
        reached(inputs),
        joints(passive)
    )]
    Singular {
        /// The loop, or the first of those that are closed together.
        name: String,
        /// The others that are closed together with it.
        others: Vec<String>,
        /// Joints of the loops that had moved when it was reached.
        inputs: Vec<At>,
        /// Its passive joints there.
        passive: Vec<At>,
    },
    /// A slider-crank's triangle does not close.
    #[error(
        "the triangle of actuator `{name}` cannot close at stroke {stroke:.6} m: its length is {gap:.3e} m out of reach"
    )]
    SliderCrank {
        /// The actuator.
        name: String,
        /// Commanded stroke, m.
        stroke: f64,
        /// Missing length, m.
        gap: f64,
    },
    /// A value or joint is not a finite number.
    #[error("`{0}` is not a finite number")]
    NotFinite(String),
    /// A configuration has the wrong number of joints.
    #[error("a configuration of {expected} variables was expected, and {found} given")]
    WrongLength {
        /// Number of variables of the model.
        expected: usize,
        /// Number given.
        found: usize,
    },
}

/// How far the frames of a loop are from meeting: the greatest components of what stays between them.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Gap {
    /// m.
    pub length: f64,
    /// rad; 0 where the loop meets at points alone.
    pub angle: f64,
}

impl Gap {
    /// The greater of both numbers.
    pub fn greatest(&self) -> f64 {
        self.length.max(self.angle)
    }

    /// Counts a component of what stays open.
    pub(super) fn add(&mut self, component: f64, is_angle: bool) {
        let size = if component.is_nan() { f64::INFINITY } else { component.abs() };
        let own = if is_angle { &mut self.angle } else { &mut self.length };
        *own = own.max(size);
    }
}

impl std::fmt::Display for Gap {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match (self.length, self.angle) {
            (length, 0.0) => write!(f, "{length:.3e} m"),
            (0.0, angle) => write!(f, "{angle:.3e} rad"),
            (length, angle) => write!(f, "{length:.3e} m and {angle:.3e} rad"),
        }
    }
}

/// A joint and its value.
#[derive(Debug, Clone, PartialEq)]
pub struct At {
    /// Name of its frame.
    pub joint: String,
    /// Joint variable, rad or m.
    pub value: f64,
    /// Whether it is an angle.
    pub is_angle: bool,
}

/// Where two assemblies of a loop meet.
fn reached(inputs: &[At]) -> String {
    const MEET: &str = "a singular position, or close to one, where two of its assemblies meet";
    match inputs.is_empty() {
        true => format!("is declared at {MEET}"),
        false => format!("comes to {MEET}, on the way there from where its branch is declared: at {}", joints(inputs)),
    }
}

fn joints(all: &[At]) -> String {
    let shown = |at: &At| match at.is_angle {
        true => format!("`{}` = {:.1} deg", at.joint, at.value.to_degrees()),
        false => format!("`{}` = {:.4} m", at.joint, at.value),
    };
    all.iter().map(shown).collect::<Vec<_>>().join(", ")
}

fn quoted(name: &str, others: &[String]) -> String {
    let names = std::iter::once(name).chain(others.iter().map(String::as_str));
    names.map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}
