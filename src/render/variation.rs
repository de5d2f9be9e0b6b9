//! `compensate --vary` as text. Lengths in mm.

use super::table::Screen;
use crate::results::units::mm;
use crate::results::{PathDeviations, Variation, Varied};

/// Text of `compensate --vary`.
pub fn variation(found: &Variation, screen: Screen) -> String {
    let header = [
        "varied",
        "by",
        "rms mm",
        "greatest",
        "rms x",
        "rms y",
        "rms z",
        "greatest x",
        "greatest y",
        "greatest z",
        "elasticity",
    ];
    let row = |what: &str, by: String, of: &PathDeviations, elasticity: Option<f64>| {
        let mut row = vec![what.to_string(), by];
        let all = [of.distance.rms, of.distance.max].into_iter().chain(of.rms).chain(of.greatest);
        row.extend(all.map(|v| format!("{:.4}", mm(v))));
        row.push(elasticity.map_or_else(String::new, |v| format!("{v:+.3}")));
        row
    };
    let by = |varied: &Varied| match (varied.factor, varied.moved) {
        (Some(factor), _) => format!("x {factor}"),
        (None, moved) => format!("{:+} mm", mm(moved.unwrap_or_default())),
    };
    let first = std::iter::once(row("as declared", String::new(), &found.declared, None));
    let rows = first.chain(found.varied.iter().map(|of| row(&of.what, by(of), &of.deviations, of.elasticity)));
    let mut out = format!("{}: how far what pushes on the tool moves it along the path, uncorrected\n\n", found.robot);
    out += &screen.table(&header, rows);
    out += "\nelasticity: change of the logarithm of the rms over that of the factor\n";
    let lost = |of: &PathDeviations| of.points.iter().filter(|point| point.is_none()).count();
    for (what, by, of) in std::iter::once(("as declared", String::new(), &found.declared))
        .chain(found.varied.iter().map(|of| (of.what.as_str(), by(of), &of.deviations)))
        .filter(|(.., of)| lost(of) > 0)
    {
        let count = of.points.len();
        out += &format!("{what} {by}: {} of {count} points have no equilibrium and are not counted\n", lost(of));
    }
    out
}
