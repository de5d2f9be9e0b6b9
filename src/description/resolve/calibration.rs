//! Parameter names, tolerances and bounds of the `calibration:` block.

use indexmap::IndexMap;

use super::super::elastic::{BASE_SYMBOLS, JOINT_SYMBOLS, section_symbols};
use super::super::raw::RawRobot;
use super::super::robot::{Calibration, FRAME_SYMBOLS, PLACEMENT_SYMBOLS, SLIDER_CRANK_SYMBOLS, is_angle};
use super::Complaints;
use super::tree::Tree;
use crate::parameter::Kind;

pub fn resolve(raw: &RawRobot, tree: &Tree, diagnostics: &mut Complaints) -> Calibration {
    let (length, angle) = (raw.units.length.factor(), raw.units.angle.factor());
    let given = &raw.calibration;
    let valid = parameter_names(raw, tree);
    let mut known = |path: &[&str], name: &str| {
        let known = valid.iter().any(|valid| valid == name);
        if !known {
            diagnostics.unknown(path, "parameter", name, valid.iter().map(String::as_str));
        }
        known
    };
    for (key, list) in [("free", &given.free), ("fixed", &given.fixed)] {
        for (position, name) in list.iter().enumerate() {
            known(&["calibration", key, &position.to_string()], name);
        }
    }
    let factor = |name: &str| match name.rsplit_once('.') {
        Some((_, symbol)) if is_angle(symbol) => angle,
        Some((owner, symbol)) if spring_kind(symbol).is_some() => spring_factor(raw, owner, symbol),
        Some((_, "density" | "poisson")) => 1.0,
        Some((_, "young" | "shear")) => raw.units.pressure.factor(),
        Some((_, "mass")) => raw.units.mass.factor(),
        Some((_, "area")) => length.powi(2),
        Some((_, "iy" | "iz" | "j")) => length.powi(4),
        _ => length,
    };
    for (section, names) in
        [("tolerances", given.tolerances.keys().collect::<Vec<_>>()), ("bounds", given.bounds.keys().collect())]
    {
        for name in names {
            known(&["calibration", section, name], name);
        }
    }
    for (position, name) in given.fixed.iter().enumerate() {
        if given.free.contains(name) {
            let path = ["calibration", "fixed", &position.to_string()];
            diagnostics.error(&path, format!("`{name}` is both free and fixed")).remedy =
                Some("keep it in one list".into());
        }
    }
    let mut positive = |path: &[&str], value: f64, factor: f64| {
        if !(value.is_finite() && value * factor >= LEAST_TOLERANCE) {
            diagnostics.error(path, format!("tolerance `{value}` must be a finite number above 0"));
        }
        value * factor
    };
    let length_tolerance =
        given.length_tolerance.map_or(1e-3, |v| positive(&["calibration", "length_tolerance"], v, length));
    let angle_tolerance =
        given.angle_tolerance.map_or(1e-3, |v| positive(&["calibration", "angle_tolerance"], v, angle));
    let tolerances: IndexMap<String, f64> = given
        .tolerances
        .iter()
        .map(|(name, value)| (name.clone(), positive(&["calibration", "tolerances", name], *value, factor(name))))
        .collect();
    let bounds = given
        .bounds
        .iter()
        .filter_map(|(name, bounds)| {
            let path = ["calibration", "bounds", name.as_str()];
            diagnostics.interval(&path, Some(*bounds), factor(name), true).map(|bounds| (name.clone(), bounds))
        })
        .collect();
    Calibration {
        free: given.free.clone(),
        fixed: given.fixed.clone(),
        length_tolerance,
        angle_tolerance,
        tolerances,
        bounds,
    }
}

/// What a spring's symbol measures, as a stiffness.
fn spring_kind(symbol: &str) -> Option<Kind> {
    match symbol {
        "ka" | "kr" | "kx" | "ky" | "kz" | "axial" | "stiffness" => Some(Kind::LinearStiffness),
        "kar" | "krr" | "krx" | "kry" | "krz" => Some(Kind::RotationalStiffness),
        _ => None,
    }
}

/// SI units in the file's unit of a spring: of a compliance where it is declared as one.
fn spring_factor(raw: &RawRobot, owner: &str, symbol: &str) -> f64 {
    let Some(kind) = spring_kind(symbol) else { return 1.0 };
    let base = raw.base_stiffness.as_ref();
    let joint = owner.strip_prefix("joint").and_then(|joint| raw.joint_stiffness.get(joint));
    let given = match symbol {
        "ka" => joint.and_then(|joint| joint.ka.as_ref()),
        "kr" => joint.and_then(|joint| joint.kr.as_ref()),
        "kar" => joint.and_then(|joint| joint.kar.as_ref()),
        "krr" => joint.and_then(|joint| joint.krr.as_ref()),
        "kx" => base.and_then(|base| base.kx.as_ref()),
        "ky" => base.and_then(|base| base.ky.as_ref()),
        "kz" => base.and_then(|base| base.kz.as_ref()),
        "krx" => base.and_then(|base| base.krx.as_ref()),
        "kry" => base.and_then(|base| base.kry.as_ref()),
        "krz" => base.and_then(|base| base.krz.as_ref()),
        "axial" => raw.actuators.get(owner).and_then(|actuator| actuator.axial.as_ref()),
        _ => raw.springs.get(owner).and_then(|spring| spring.rate.as_ref()),
    };
    let as_compliance = given.is_some_and(|given| given.compliance.is_some());
    raw.units.of(if as_compliance { kind.inverse() } else { kind })
}

/// Tolerances below this (m or rad) are nothing but zero.
const LEAST_TOLERANCE: f64 = 1e-15;

/// Every parameter a description of this shape has.
fn parameter_names(raw: &RawRobot, tree: &Tree) -> Vec<String> {
    let all =
        |owner: &str, symbols: &[&str]| -> Vec<String> { symbols.iter().map(|s| format!("{owner}.{s}")).collect() };
    let mut names = all("base", &PLACEMENT_SYMBOLS);
    names.extend(tree.frames.iter().skip(1).flat_map(|frame| all(&frame.name, &FRAME_SYMBOLS)));
    names.extend(tree.actuators.iter().flat_map(|actuator| all(&actuator.name, &SLIDER_CRANK_SYMBOLS)));
    names.extend(all("tool", &PLACEMENT_SYMBOLS));
    names.extend(raw.markers.keys().flat_map(|marker| all(marker, &PLACEMENT_SYMBOLS[..3])));
    names.extend(raw.joint_stiffness.keys().flat_map(|joint| all(&format!("joint{joint}"), &JOINT_SYMBOLS)));
    names.extend(raw.base_stiffness.iter().flat_map(|_| all("base", &BASE_SYMBOLS)));
    names.extend(raw.actuators.keys().map(|actuator| format!("{actuator}.axial")));
    const ANCHORS: [&str; 6] = ["x1", "y1", "z1", "x2", "y2", "z2"];
    names.extend(raw.springs.iter().flat_map(|(spring, given)| {
        // Without a free length the spring's tension is unknown, and nothing depends on a length it does not have.
        let length = given.free_length.is_some() || given.preload.is_some();
        let own = ["stiffness"].into_iter().chain(length.then_some("free_length"));
        all(spring, &own.chain(ANCHORS).collect::<Vec<_>>())
    }));
    names.extend(raw.materials.iter().flat_map(|(material, given)| {
        all(material, &["young", if given.shear.is_some() { "shear" } else { "poisson" }, "density"])
    }));
    names.extend(raw.sections.iter().flat_map(|(section, given)| all(section, section_symbols(given.shape))));
    names.extend(raw.bodies.keys().flat_map(|body| all(&format!("body{body}"), &["mass", "x", "y", "z"])));
    names
}
