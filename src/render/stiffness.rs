//! Stiffness at a point as text. Base axes.

use std::fmt::Write;

use super::table::Screen;
use crate::results::Stiffness;
use crate::results::units::{deg, mm};

/// Load factors from here on are not worth a line.
const FAR_FROM_BUCKLING: f64 = 100.0;

/// Displacement in mm and rotation vector in deg, as cells of a table.
pub fn displacement(d: &[f64; 6]) -> impl Iterator<Item = String> {
    let translation = d[..3].iter().map(|v| format!("{:.4}", mm(*v)));
    translation.chain(d[3..].iter().map(|v| format!("{:.5}", deg(*v)))).collect::<Vec<_>>().into_iter()
}

/// Text of `stiffness`.
pub fn stiffness(found: &Stiffness, screen: Screen) -> String {
    let mut out = format!("{}: compliance at {}, base axes\n\n", found.robot, found.at);
    let labels = ["x", "y", "z", "rx", "ry", "rz"];
    // um per kN, um per kN.m, urad per kN, urad per kN.m: one size of unit for each block.
    let row = |i: usize| {
        let mut row = vec![format!("{} {}", labels[i], if i < 3 { "um" } else { "urad" })];
        row.extend(found.compliance[i].iter().map(|c| format!("{:.3}", c * 1e9)));
        row
    };
    out += &screen.table(&["", "per kN fx", "fy", "fz", "per kN.m mx", "my", "mz"], (0..6).map(row));
    match &found.stiffness {
        Some(stiffness) => {
            let joined = |of: &dyn Fn(usize) -> f64| [0, 1, 2].map(|k| format!("{:.3}", of(k))).join(", ");
            let own = joined(&|k| 1e-6 / found.compliance[k][k]);
            let held = joined(&|k| stiffness[k][k] * 1e-6);
            let _ = writeln!(out, "\nstiffness along x, y, z: {own} N/um free to turn, {held} N/um held from turning");
        }
        None => out += "\nsome direction is rigid: there is no finite stiffness matrix\n",
    }
    if found.is_loaded {
        out += &under_load(found, screen);
    } else {
        let _ = writeln!(out, "{}", found.own_weight.words("`--weight` adds its deflection"));
    }
    out
}

fn under_load(found: &Stiffness, screen: Screen) -> String {
    let d = found.deflection;
    let norm = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
    let [x, y, z] = [d[0], d[1], d[2]].map(mm);
    let [rx, ry, rz] = [d[3], d[4], d[5]].map(deg);
    let mut out = format!(
        "deflection {:.4} mm: x {x:.4}, y {y:.4}, z {z:.4} mm; rx {rx:.5}, ry {ry:.5}, rz {rz:.5} deg\n{}\n\n",
        mm(norm),
        found.own_weight.words("--weight adds it")
    );
    if let Some(factor) = found.load_factor.filter(|factor| *factor < FAR_FROM_BUCKLING) {
        let _ = writeln!(out, "buckling load factor {factor:.2}\n");
    }
    if found.by_rules {
        return out + "fuzzy compliance replaces springs and beams: no strain-energy shares\n";
    }
    let shares = found.shares.iter().map(|(name, share)| vec![name.clone(), format!("{:.2}", 100.0 * share)]);
    out += &screen.table(&["element", "% of the deflection"], shares);
    if !found.nodes.is_empty() {
        let row = |(name, d): (&String, &[f64; 6])| std::iter::once(name.clone()).chain(displacement(d)).collect();
        out += "\n";
        out +=
            &screen.table(&["node", "x mm", "y mm", "z mm", "rx deg", "ry deg", "rz deg"], found.nodes.iter().map(row));
    }
    out
}
