//! Stiffness at a point, in text and JSON.

use std::fmt::Write;

use nalgebra::Matrix6;
use serde_json::{Map, Value, json};

use super::table::Screen;
use crate::elastics::Shares;
use crate::model::Model;
use crate::results::units::{deg, mm};

/// What `stiffness` found.
#[derive(Debug, Clone)]
pub struct Stiffness {
    /// Frame or marker.
    pub at: String,
    /// (dP, rotation vector) by (force, moment) at the point, base axes, SI.
    pub compliance: Matrix6<f64>,
    /// Displacement (m) and rotation vector (rad) under the load.
    pub deflection: [f64; 6],
    /// Who gives how much.
    pub shares: Shares,
    /// At equilibrium: by what the loads could grow until the stiffness there is used up.
    pub load_factor: Option<f64>,
    /// Whether there is a load.
    pub is_loaded: bool,
    /// Whether rules stand in the place of springs and beams.
    pub by_rules: bool,
}

impl Stiffness {
    /// The inverse of the compliance; `None` where a direction is rigid.
    fn stiffness(&self) -> Option<Matrix6<f64>> {
        // Forces and moments to the same size first.
        let scale =
            Matrix6::from_diagonal(&self.compliance.diagonal().map(|c| if c > 0.0 { c.sqrt().recip() } else { 0.0 }));
        let even = scale * self.compliance * scale;
        let least = even.symmetric_eigenvalues().min();
        (least > 1e-12).then(|| even.try_inverse().map(|inverse| scale * inverse * scale)).flatten()
    }
}

fn rows(matrix: &Matrix6<f64>) -> Value {
    json!((0..6).map(|i| (0..6).map(|j| matrix[(i, j)]).collect::<Vec<f64>>()).collect::<Vec<_>>())
}

/// JSON of `stiffness`, SI.
pub fn stiffness_json(found: &Stiffness) -> Value {
    let shares: Map<String, Value> = match found.by_rules {
        true => Map::new(),
        false => found.shares.energy.iter().map(|(name, share)| (name.clone(), json!(share))).collect(),
    };
    json!({"at": found.at, "compliance": rows(&found.compliance), "stiffness": found.stiffness().map(|k| rows(&k)),
           "deflection": found.deflection, "load_factor": found.load_factor.filter(|factor| factor.is_finite()),
           "shares": shares, "nodes": found.shares.nodes})
}

/// Text of `stiffness`.
pub fn stiffness_text(model: &Model, found: &Stiffness, screen: Screen) -> String {
    let mut out = format!("{}: compliance at {}, base axes\n\n", model.name, found.at);
    let labels = ["x", "y", "z", "rx", "ry", "rz"];
    // um per kN, um per kN.m = mrad per MN..., urad per kN.m: one size of unit for each block.
    let row = |i: usize| {
        let mut row = vec![format!("{} {}", labels[i], if i < 3 { "um" } else { "urad" })];
        row.extend((0..6).map(|j| format!("{:.3}", found.compliance[(i, j)] * 1e9)));
        row
    };
    out += &screen.table(&["", "per kN fx", "fy", "fz", "per kN.m mx", "my", "mz"], (0..6).map(row));
    match found.stiffness() {
        Some(stiffness) => {
            let translational = stiffness.fixed_view::<3, 3>(0, 0).into_owned();
            let own = (0..3).map(|k| format!("{:.3}", 1e-6 / found.compliance[(k, k)])).collect::<Vec<_>>().join(", ");
            let held = (0..3).map(|k| format!("{:.3}", translational[(k, k)] * 1e-6)).collect::<Vec<_>>().join(", ");
            let _ = writeln!(out, "\nstiffness along x, y, z: {own} N/um free to turn, {held} N/um held from turning");
        }
        None => out += "\nsome direction is rigid: there is no finite stiffness matrix\n",
    }
    if found.is_loaded {
        let d = found.deflection;
        let norm = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
        let _ = writeln!(
            out,
            "deflection {:.4} mm: x {:.4}, y {:.4}, z {:.4} mm; rx {:.5}, ry {:.5}, rz {:.5} deg\n",
            mm(norm),
            mm(d[0]),
            mm(d[1]),
            mm(d[2]),
            deg(d[3]),
            deg(d[4]),
            deg(d[5])
        );
        if let Some(factor) = found.load_factor.filter(|factor| *factor < 100.0) {
            let _ = writeln!(out, "the loads may grow {factor:.2} fold before they use up the stiffness (buckling)\n");
        }
        if found.by_rules {
            out += "by rules (`fuzzy`), in the place of springs and beams: no element has a share\n";
            return out;
        }
        let shares =
            found.shares.energy.iter().map(|(name, share)| vec![name.clone(), format!("{:.2}", 100.0 * share)]);
        out += &screen.table(&["element", "% of the deflection"], shares);
        if !found.shares.nodes.is_empty() {
            out += "\n";
            out += &screen.table(
                &["node", "x mm", "y mm", "z mm", "rx deg", "ry deg", "rz deg"],
                found.shares.nodes.iter().map(|(name, d)| {
                    let mut row = vec![name.clone()];
                    row.extend(d[..3].iter().map(|v| format!("{:.4}", mm(*v))));
                    row.extend(d[3..].iter().map(|v| format!("{:.5}", deg(*v))));
                    row
                }),
            );
        }
    }
    out
}
