//! Errors, factors and units as they are said.

use super::evidence::Limits;
use crate::description::campaign::{Campaign, Reading};

/// A factor as it is said.
pub(super) fn number(factor: f64) -> String {
    if factor >= 1.0 {
        format!("{}", (factor * 1e3).round() / 1e3)
    } else {
        format!("{}", (factor * 1e5).round() / 1e5)
    }
}

/// What a factor on lengths means: the unit in which they are recorded, and the one declared.
pub(super) fn recorded(factor: f64) -> String {
    let names: &[[&str; 2]] = match factor {
        f if near(f, 1e3) => &[["m", "mm"], ["mm", "um"]],
        f if near(f, 1e-3) => &[["mm", "m"], ["um", "mm"]],
        f if near(f, 25.4) => &[["inches", "mm"]],
        f if near(f, 1.0 / 25.4) => &[["mm", "inches"]],
        f if near(f, 10.0) => &[["cm", "mm"]],
        f if near(f, 0.1) => &[["mm", "cm"]],
        f if near(f, 100.0) => &[["m", "cm"]],
        f if near(f, 0.01) => &[["cm", "m"]],
        f if near(f, 304.8) => &[["feet", "mm"]],
        f if near(f, 1.0 / 304.8) => &[["mm", "feet"]],
        f if near(f, 1.0 / 0.0254) => &[["m", "inches"]],
        _ => &[["inches", "m"]],
    };
    let units: Vec<String> = names.iter().map(|[is, was]| format!("in {is}, and declared in {was}")).collect();
    units.join(" (or ") + if units.len() > 1 { ")" } else { "" }
}

pub(super) fn near(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() < 1e-6
}

/// How errors (m, rotations and loads by what they are at the end of [`Limits::arm`]) are shown: a factor before [`mm`], and the unit.
/// Readings without lengths are of angles or of loads alone.
pub(super) fn unit_of(campaign: &Campaign) -> (f64, &'static str) {
    let arm = Limits::default().arm;
    let all = |is: fn(&Reading) -> bool| !campaign.readings.is_empty() && campaign.readings.iter().all(is);
    if all(|reading| reading.observes.by_variable().is_some()) {
        (1e-3 / arm, "N.m")
    } else if all(|reading| reading.observes.length_rows() == 0) {
        ((1e-3 / arm).to_degrees(), "deg")
    } else {
        (1.0, "mm")
    }
}

/// Errors of positions (m) and of orientations (rad): `1.72 mm and 0.05 deg`.
pub(super) fn both([lengths, rotations]: [f64; 2]) -> String {
    format!("{} mm and {} deg", mm(lengths), digits(rotations.to_degrees()))
}

/// A length in mm, three digits.
pub(super) fn mm(metres: f64) -> String {
    digits(1e3 * metres)
}

fn digits(value: f64) -> String {
    match value.abs() {
        size if size >= 99.95 => format!("{value:.0}"),
        size if size >= 9.995 => format!("{value:.1}"),
        // Small errors with two digits; below 5e-7 it is rounding.
        size if size < 0.0995 && size > 5e-7 => {
            format!("{value:.0$}", (1.0 - size.log10().floor()).max(2.0) as usize)
        }
        _ => format!("{value:.2}"),
    }
}
