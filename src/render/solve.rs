//! Solutions of the inverse model as text.

use super::table::Screen;
use crate::math::norm;
use crate::results::InverseSolutions;
use crate::results::units::{shown, shown_unit};

/// Text of `solve`.
pub fn solutions(found: &InverseSolutions, screen: Screen) -> String {
    let columns = found.angles.iter().map(|(name, is_angle)| format!("{name} {}", shown_unit(*is_angle)));
    let mut header = vec!["solution".to_string()];
    header.extend(columns);
    header.push("position error um".into());
    let is_fitted = found.solutions.iter().any(|solution| solution.standard_uncertainty.is_some());
    if is_fitted {
        header.push("standard uncertainty um".into());
    }
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let rows = found.solutions.iter().enumerate().map(|(n, solution)| {
        let joints = solution.joints.values().zip(found.angles.values());
        let mut row = vec![(n + 1).to_string()];
        row.extend(joints.map(|(q, is_angle)| format!("{:.4}", shown(*q, *is_angle))));
        row.push(format!("{:.1e}", solution.position_error * 1e6));
        row.extend(solution.standard_uncertainty.map(|u| format!("{:.1}", norm(&u) * 1e6)));
        row
    });
    let mut out = screen.table(&header, rows);
    if found.solutions.iter().any(|solution| solution.self_motions > 0) {
        out += "the robot can move while its tool stands still: these are samples of a continuum\n";
    }
    out + &found.own_weight.words("the tool is at the target undeflected (--weight)") + "\n"
}
