//! A gravity compensator, in text and JSON.

use std::fmt::Write;

use serde_json::{Value, json};

use super::table::Screen;
use crate::estimation::compensator::{self, Elasticity, JointCompliance, Mounting, Triangle};
use crate::results::units::{deg, mm};

/// What `compensator` found.
#[derive(Debug, Clone, Default)]
pub struct Compensator {
    /// Where the spring is hung, if it was measured.
    pub mounting: Option<Mounting>,
    /// L, ax, ay as measured or given.
    pub triangle: Option<Triangle>,
    /// Compliances of the joint.
    pub compliances: Vec<JointCompliance>,
    /// What the spring is.
    pub elasticity: Option<Elasticity>,
}

/// Symbol, unit, value and half width of its interval in that unit.
fn values(found: &Compensator) -> Vec<(&'static str, &'static str, f64, Option<f64>)> {
    let scaled = |name, unit, value: compensator::Value, size: f64| {
        (name, unit, value.value / size, value.ci95.map(|ci95| ci95 / size))
    };
    let mut all = Vec::new();
    if let Some(mounting) = &found.mounting {
        all.push(scaled("L", "mm", mounting.lever, 1e-3));
        for (name, value) in ["ax", "ay"].into_iter().zip(mounting.anchor.into_iter().flatten()) {
            all.push(scaled(name, "mm", value, 1e-3));
        }
    }
    if let Some(elasticity) = &found.elasticity {
        all.push(scaled("k2_0", "1e-6 rad/(N.m)", elasticity.joint, 1e-6));
        all.push(scaled("kc", "1e-6 m/N", elasticity.spring, 1e-6));
        all.push(scaled("s0", "mm", elasticity.free_length, 1e-3));
    }
    all
}

/// Compliances of the joint: angle, given, fitted.
fn fitted(found: &Compensator) -> Vec<[f64; 3]> {
    let (Some(triangle), Some(elasticity)) = (&found.triangle, &found.elasticity) else { return Vec::new() };
    let row = |k: &JointCompliance| [k.angle, k.compliance, elasticity.compliance(triangle, k.angle)];
    found.compliances.iter().map(row).collect()
}

/// JSON of `compensator`.
pub fn compensator_json(found: &Compensator) -> Value {
    let mut map = serde_json::Map::new();
    for (name, unit, value, ci95) in values(found) {
        map.insert(name.into(), json!({"value": value, "ci95": ci95, "unit": unit}));
    }
    if let Some(mounting) = &found.mounting {
        let (centre, axis) = (mounting.circle.centre * 1e3, mounting.circle.axes.column(2).into_owned());
        map.insert("centre".into(), json!({"value": centre.as_slice(), "unit": "mm"}));
        map.insert("axis".into(), json!(axis.as_slice()));
        map.insert("sigma".into(), json!({"value": mounting.sigma.map(mm), "unit": "mm"}));
    }
    if let Some(triangle) = &found.triangle {
        map.insert("a".into(), json!({"value": mm(triangle.base()), "unit": "mm"}));
        map.insert("phi".into(), json!({"value": deg(triangle.phase()), "unit": "deg"}));
    }
    let rows = fitted(found);
    if let Some(elasticity) = &found.elasticity {
        let rows: Vec<Value> =
            rows.iter().map(|[q, k, fit]| json!({"q": deg(*q), "k2": k * 1e6, "fitted": fit * 1e6})).collect();
        map.insert("compliances".into(), json!({"unit": "deg, 1e-6 rad/(N.m)", "rows": rows}));
        map.insert("rms".into(), json!({"value": elasticity.rms * 1e6, "unit": "1e-6 rad/(N.m)"}));
    }
    Value::Object(map)
}

/// Text of `compensator`.
pub fn compensator_text(found: &Compensator, screen: Screen) -> String {
    let width = |value: Option<f64>| value.map_or_else(|| "unknown".into(), |value| format!("{value:.4}"));
    let rows = values(found);
    let mut out = String::new();
    if !rows.is_empty() {
        out += &screen.table(
            &["", "value", "95 % +-", "unit"],
            rows.iter().map(|(name, unit, value, ci95)| {
                vec![(*name).into(), format!("{value:.4}"), width(*ci95), (*unit).into()]
            }),
        );
    }
    if let Some(mounting) = &found.mounting {
        let (c, n) = (mounting.circle.centre * 1e3, mounting.circle.axes.column(2).into_owned());
        let _ = writeln!(
            out,
            "\naxis of the joint through ({:.3}, {:.3}, {:.3}) mm, along ({:.6}, {:.6}, {:.6})",
            c.x, c.y, c.z, n.x, n.y, n.z
        );
        let _ = writeln!(
            out,
            "points lie {} mm about the circles (one sigma of a coordinate)",
            width(mounting.sigma.map(mm))
        );
    }
    if let Some(triangle) = &found.triangle {
        let _ = writeln!(out, "a = {:.3} mm, phi = {:.3} deg", mm(triangle.base()), deg(triangle.phase()));
    }
    if let Some(elasticity) = &found.elasticity {
        out += "\n";
        out += &screen.table(
            &["q deg", "k2 1e-6 rad/(N.m)", "fitted"],
            fitted(found).iter().map(|[q, k, fit]| {
                vec![format!("{:.3}", deg(*q)), format!("{:.5}", k * 1e6), format!("{:.5}", fit * 1e6)]
            }),
        );
        let _ = writeln!(out, "rms of what is left: {:.5} 1e-6 rad/(N.m)", elasticity.rms * 1e6);
    }
    out
}
