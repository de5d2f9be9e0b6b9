//! A gravity compensator as text.

use std::fmt::Write;

use super::table::Screen;
use crate::results::{Compensator, CompliancePoint};

/// Text of `compensator`.
pub fn compensator(found: &Compensator, screen: Screen) -> String {
    let width = |value: Option<f64>| value.map_or_else(|| "unknown".into(), |value| format!("{value:.4}"));
    let values = [
        ("L", found.lever),
        ("ax", found.ax),
        ("ay", found.ay),
        ("k2_0", found.k2_0),
        ("kc", found.kc),
        ("s0", found.s0),
    ];
    let rows = values.into_iter().filter_map(|(name, value)| {
        let value = value?;
        Some(vec![name.into(), format!("{:.4}", value.value), width(value.ci95), value.unit.into()])
    });
    let rows: Vec<Vec<String>> = rows.collect();
    let mut out = String::new();
    if !rows.is_empty() {
        out += &screen.table(&["", "value", "95 % +-", "unit"], rows);
    }
    if let (Some(centre), Some([nx, ny, nz]), Some(sigma)) = (found.centre, found.axis, found.sigma) {
        let [x, y, z] = centre.value;
        let _ =
            writeln!(out, "\naxis of the joint through ({x:.3}, {y:.3}, {z:.3}) mm, along ({nx:.6}, {ny:.6}, {nz:.6})");
        let _ = writeln!(out, "points lie {} mm about the circles (one sigma of a coordinate)", width(sigma.value));
    }
    if let (Some(a), Some(phi)) = (found.a, found.phi) {
        let _ = writeln!(out, "a = {:.3} mm, phi = {:.3} deg", a.value, phi.value);
    }
    if let (Some(compliances), Some(rms)) = (&found.compliances, found.rms) {
        let row = |p: &CompliancePoint| vec![format!("{:.3}", p.q), format!("{:.5}", p.k2), format!("{:.5}", p.fitted)];
        out += "\n";
        out += &screen.table(&["q deg", "k2 1e-6 rad/(N.m)", "fitted"], compliances.rows.iter().map(row));
        let _ = writeln!(out, "rms of what is left: {:.5} 1e-6 rad/(N.m)", rms.value);
    }
    out
}
