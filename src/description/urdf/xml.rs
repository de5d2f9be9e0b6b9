//! Numbers, names and rotations as a URDF spells them.

use std::f64::consts::FRAC_PI_2;
use std::fmt::Write;

use nalgebra::{Rotation3, Vector3};

use super::khalil_kleinfinger::{about_z, clean_angle};

/// Roll, pitch and yaw whose rotation is this one to round-off, at a pitch of 90 degrees too.
pub(super) fn roll_pitch_yaw(rotation: &Rotation3<f64>) -> Vector3<f64> {
    let m = rotation.matrix();
    let level = m[(0, 0)].hypot(m[(1, 0)]);
    // Any yaw does at a pitch of 90 degrees; roll and pitch are read from what remains once yaw is undone.
    let yaw = if level < 4e-16 { 0.0 } else { clean_angle(m[(1, 0)].atan2(m[(0, 0)])) };
    let unyawed = about_z(-yaw) * rotation;
    let unyawed = unyawed.matrix();
    let pitch = (-unyawed[(2, 0)]).atan2(unyawed[(0, 0)]).clamp(-FRAC_PI_2, FRAC_PI_2);
    let roll = (-unyawed[(1, 2)]).atan2(unyawed[(1, 1)]);
    Vector3::new(clean_angle(roll), clean_angle(pitch), yaw)
}

/// Writing to a string cannot fail.
pub(super) fn put(out: &mut String, text: std::fmt::Arguments) {
    out.write_fmt(text).unwrap_or_default();
}

pub(super) fn triple(vector: &Vector3<f64>) -> String {
    format!("{} {} {}", number(vector.x), number(vector.y), number(vector.z))
}

/// The shortest text that reads back as the same number.
pub(super) fn number(value: f64) -> String {
    let text = format!("{:?}", value + 0.0);
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

/// Whether XML 1.0 can hold the character.
pub(super) fn allowed(c: char) -> bool {
    matches!(c, '\t' | '\n' | '\r') || (c >= ' ' && !matches!(c, '\u{fffe}' | '\u{ffff}'))
}

/// Text as it stands within a quoted attribute.
pub(super) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\t' => out.push_str("&#9;"),
            '\n' => out.push_str("&#10;"),
            '\r' => out.push_str("&#13;"),
            _ => out.push(c),
        }
    }
    out
}
