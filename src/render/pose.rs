//! A pose as text: lengths in mm, angles in deg.

use std::fmt::Write;

use super::stiffness::displacement;
use super::table::Screen;
use crate::results::Pose;
use crate::results::units::{deg, mm, shown, shown_unit};

/// Text of `pose`.
pub fn pose(found: &Pose, screen: Screen) -> String {
    let joint = |((name, q), is_angle): ((&String, &f64), &bool)| {
        vec![name.clone(), format!("{:.4} {}", shown(*q, *is_angle), shown_unit(*is_angle))]
    };
    let mut out = screen.table(&["joint", "value"], found.joints.iter().zip(&found.angles).map(joint));
    let placed = |(name, at): &(String, [f64; 6])| {
        let mut row = vec![name.clone()];
        row.extend(at[..3].iter().map(|v| format!("{:.4}", mm(*v))));
        row.extend(at[3..].iter().map(|v| format!("{:.4}", deg(*v))));
        row
    };
    let marker = |(name, at): (&String, &[f64; 3])| {
        let mut row = vec![format!("marker {name}")];
        row.extend(at.iter().map(|v| format!("{:.4}", mm(*v))));
        row.extend(std::iter::repeat_n(String::new(), 3));
        row
    };
    let rows = found.placed.iter().map(placed).chain(found.markers.iter().map(marker));
    out += "\n";
    out += &screen.table(&["frame", "x mm", "y mm", "z mm", "rx deg", "ry deg", "rz deg"], rows);
    if let Some(uncertainty) = found.standard_uncertainty {
        let _ = writeln!(out, "standard uncertainty of the tool's position: {}", along_axes(uncertainty));
    }
    let _ = writeln!(out, "{}", found.own_weight.words("nothing above is deflected (--weight)"));
    if !found.effects_left_out.is_empty() {
        let _ =
            writeln!(out, "effects that are switched on are not in (--weight): {}", found.effects_left_out.join(", "));
    }
    if found.deflection.is_some() {
        let row =
            |(name, d): &(String, [f64; 6])| std::iter::once(name.clone()).chain(displacement(d)).collect::<Vec<_>>();
        let header = ["point", "dx mm", "dy mm", "dz mm", "rx deg", "ry deg", "rz deg"];
        out += "\ndeflected by own weight and the wrench\n";
        out += &screen.table(&header, found.deflected.iter().map(row));
    }
    out
}

/// Standard deviations (m) along the axes of the base, in words.
fn along_axes([x, y, z]: [f64; 3]) -> String {
    format!("{:.4}, {:.4}, {:.4} mm along x, y, z, by the fit that the description states", mm(x), mm(y), mm(z))
}
