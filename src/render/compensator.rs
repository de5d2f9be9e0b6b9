//! A gravity compensator as text.

use std::fmt::Write;

use super::table::{Screen, number};
use crate::results::{BothWays, Compensator, CompensatorWay, CompliancePoint, Estimated, LawMisfit};

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
    if let Some(both) = &found.deflections {
        out += &both_ways(both, screen);
    } else if !rows.is_empty() {
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
        let with_deflections = found.deflections.is_some();
        let row = |p: &CompliancePoint| {
            let mut row = vec![format!("{:.3}", p.q), format!("{:.5}", p.k2), format!("{:.5}", p.fitted)];
            if let (true, Some(one), Some(readings)) = (with_deflections, p.one_step, p.readings) {
                row.insert(1, readings.to_string());
                row.insert(3, width(p.ci95));
                row.push(format!("{one:.5}"));
            }
            row
        };
        let header: &[&str] = match with_deflections {
            true => &["q deg", "readings", "k2 1e-6 rad/(N.m)", "95 % +-", "two steps", "one step"],
            false => &["q deg", "k2 1e-6 rad/(N.m)", "fitted"],
        };
        out += "\n";
        out += &screen.table(header, compliances.rows.iter().map(row));
        let _ = writeln!(out, "rms of what is left: {:.5} 1e-6 rad/(N.m)", rms.value);
    }
    out
}

/// Joint and spring from deflections, in two steps and in one.
fn both_ways(both: &BothWays, screen: Screen) -> String {
    let shown =
        |of: &Estimated| [format!("{:.4}", of.value), of.ci95.map_or(String::new(), |ci95| format!("{ci95:.4}"))];
    let row = |name: &str, of: fn(&CompensatorWay) -> Estimated| {
        let (two, one) = (of(&both.two_steps), of(&both.one_step));
        [vec![name.to_string()], shown(&two).to_vec(), shown(&one).to_vec(), vec![two.unit.to_string()]].concat()
    };
    let mut rows = vec![row("k2_0", |way| way.k2_0), row("kc", |way| way.kc), row("s0", |way| way.s0)];
    rows.extend(both.two_steps.others.iter().zip(&both.one_step.others).map(|(two, one)| {
        let number = |value: f64| number(two.found.unit, value);
        let shown = |of: &Estimated| vec![number(of.value), of.ci95.map_or(String::new(), number)];
        [vec![two.name.clone()], shown(&two.found), shown(&one.found), vec![two.found.unit.to_string()]].concat()
    }));
    let mut out = screen.table(&["", "two steps", "95 % +-", "one step", "95 % +-", "unit"], rows);
    let _ = writeln!(
        out,
        "rms residual of the deflections: {:.4} mm in two steps, {:.4} mm in one, {:.4} mm with a compliance for each angle",
        both.two_steps.residual.value, both.one_step.residual.value, both.residual_by_angle.value
    );
    if let Some(LawMisfit { ratio, degrees_of_freedom: [a, b], p }) = both.misfit {
        let _ = writeln!(
            out,
            "the law through the compliances by angle: F = {ratio:.2} with {a:.0} and {b:.0} degrees of freedom, chance {p:.2}"
        );
    }
    out
}
