//! Whether a result may be believed: a list of checks, each with its limit and the reason for it.
//!
//! A check looks at the evidence (model, campaign, calibration) and says what it finds as diagnostics with a code. An error
//! of the numerics ([`Code::NotConverged`]) means that there is no result. An error of plausibility
//! ([`Code::is_plausibility`]) means that there is one which no robot can have; [`forced`] makes it a warning. To add a
//! check: write a function of [`Evidence`] and [`Limits`], and put it into [`CHECKS`].

mod diagnosis;
mod evidence;
mod numerics;

pub use diagnosis::doubts;
pub use evidence::{Evidence, Limits};

use crate::diagnostic::{Code, Diagnostic, Severity};

/// One check.
pub struct Check {
    /// Code of what it finds.
    pub code: Code,
    /// What it compares with what, and why.
    pub about: &'static str,
    /// What it finds.
    pub find: fn(&Evidence, &Limits) -> Vec<Diagnostic>,
}

/// All checks, in the order in which they speak.
pub const CHECKS: &[Check] = &[
    Check {
        code: Code::NotConverged,
        about: "the fit ended at a minimum: elsewhere values are only where it stopped",
        find: numerics::converged,
    },
    Check {
        code: Code::NotComputed,
        about: "all values and errors are finite: what is not was never computed",
        find: numerics::finite,
    },
    Check {
        code: Code::Implausible,
        about: "base, tool and markers stand within the reach of an instrument",
        find: numerics::within_reach,
    },
    Check {
        code: Code::WeakDirection,
        about: "base and tool are determined: what was held of them is named",
        find: numerics::weak_directions,
    },
];

/// What all checks find.
pub fn judge(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    CHECKS
        .iter()
        .flat_map(|check| (check.find)(evidence, limits).into_iter().map(|found| found.code(check.code)))
        .collect()
}

/// The same where the user goes on all the same: errors of plausibility are warnings.
pub fn forced(found: Vec<Diagnostic>) -> Vec<Diagnostic> {
    let weaker = |diagnostic: Diagnostic| match diagnostic.code.is_plausibility() {
        true => Diagnostic { severity: Severity::Warning, ..diagnostic },
        false => diagnostic,
    };
    found.into_iter().map(weaker).collect()
}
