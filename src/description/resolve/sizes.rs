//! Lengths and angles that no robot has: mostly those of a file that does not say its units.

use crate::description::raw::{JointKind, RawRobot};
use crate::description::units::{Angle, Length};
use crate::diagnostic::Diagnostic;

use crate::diagnostic::Locate;

/// Greatest sum of the lengths of a robot's frames, m.
const LONGEST: f64 = 50.0;
/// Greatest limit of an angle, rad: a bit more than three turns.
const WIDEST: f64 = 20.0;

/// Warnings where a description in m and rad reads like one in mm and deg.
pub fn doubtful_sizes(raw: &RawRobot, locate: Locate) -> Vec<Diagnostic> {
    let cure = "lengths here are in m and angles in rad; if they are not, declare them: \
                `units: {length: mm, angle: deg}`";
    let mut diagnostics = Vec::new();
    if raw.units.length == Length::Metre {
        let lengths = raw.frames.iter().flat_map(|(name, frame)| {
            let of = [("b", frame.b), ("d", frame.d), ("r", frame.r)];
            of.into_iter().filter_map(move |(key, value)| Some((name, key, value?.abs())))
        });
        let sum: f64 = lengths.clone().map(|(_, _, length)| length).sum();
        let longest = lengths.max_by(|a, b| a.2.total_cmp(&b.2));
        if let Some((name, key, _)) = longest.filter(|_| sum > LONGEST && sum.is_finite()) {
            let diagnostic = Diagnostic::warning(format!("the lengths of the frames add up to {} m", rounded(sum)));
            diagnostics.push(diagnostic.at(locate(&["frames", name, key])).remedy(cure));
        }
    }
    if raw.units.angle == Angle::Radian {
        let wide = raw.frames.iter().find_map(|(name, frame)| {
            let limits = frame.limits.filter(|_| frame.joint == Some(JointKind::Revolute))?;
            let widest = limits.into_iter().filter(|v| v.is_finite()).fold(0.0, |most: f64, v| most.max(v.abs()));
            (widest > WIDEST).then_some((name, widest))
        });
        if let Some((name, widest)) = wide {
            let diagnostic = Diagnostic::warning(format!("joint `{name}` may turn by {} rad", rounded(widest)));
            diagnostics.push(diagnostic.at(locate(&["frames", name, "limits"])).remedy(cure));
        }
    }
    diagnostics
}

fn rounded(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}
