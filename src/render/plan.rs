//! A plan in words and in JSON.

use std::fmt::Write;

use serde_json::{Map, Value, json};

use super::identification::identifiability_json;
use super::table::{Screen, deg, mm, number, unit};
use crate::math::quantiles::normal95;
use crate::model::Model;
use crate::planning::{Planned, Request, SETS, Station};

fn marker(model: &Model, marker: Option<usize>) -> &str {
    marker.map_or("TCP", |m| &model.markers[m].name)
}

/// JSON of `plan`: configurations and loads in SI, errors in mm.
pub fn plan_json(model: &Model, request: &Request, planned: &Planned, seconds: f64) -> Value {
    let station = |(k, station): (usize, &Station)| {
        let joints: Map<String, Value> =
            model.variables.iter().zip(&station.q).map(|(v, q)| (v.name.clone(), json!(q))).collect();
        let markers: Vec<&str> = station.markers.iter().map(|&m| marker(model, m)).collect();
        json!({"pose": planned.campaign.poses[k], "joints": joints, "wrench": station.load, "markers": markers})
    };
    let bought: Vec<Value> = planned
        .bought
        .iter()
        .map(|b| json!({"poses": b.count, "planned": mm(b.planned), "random": mm(b.random)}))
        .collect();
    let deviations: Vec<Value> = planned
        .deviations
        .iter()
        .map(|&(slot, sigma)| {
            let parameter = &model.registry[slot];
            let (unit, size) = unit(parameter.shown_kind());
            let width = parameter.shown_width(parameter.nominal, normal95() * sigma) / size;
            json!({"name": parameter.name, "unit": unit, "ci95": width})
        })
        .collect();
    json!({
        "criterion": request.criterion.name(),
        "poses": planned.stations.iter().enumerate().map(station).collect::<Vec<_>>(),
        "unit": "mm",
        "error": {"before": planned.before.map(mm), "planned": mm(planned.error)},
        "bought": bought,
        "random_equal": planned.random_equal,
        "least": planned.least,
        "candidates": planned.candidates,
        "parameters": deviations,
        "identifiability": identifiability_json(model, &planned.slots, &planned.identifiability),
        "seconds": seconds,
    })
}

/// Text of `plan`.
pub fn plan_text(model: &Model, request: &Request, planned: &Planned, screen: Screen) -> String {
    let count = planned.stations.len();
    let random = planned.bought.iter().find(|b| b.count == count).map_or(f64::NAN, |b| b.random);
    let mut out = format!(
        "{count} configurations leave {:.4} mm of position error after compensation (rms at the test poses, by the\n\
         covariance of {} parameters); as many at random leave {:.4} mm (median of {SETS} sets)",
        mm(planned.error),
        planned.deviations.len(),
        mm(random)
    );
    let _ = match planned.random_equal {
        Some(equal) if equal > count => writeln!(out, ",\nand it takes {equal} at random to do as well"),
        Some(_) => writeln!(out),
        None => writeln!(out, ",\nand not all the candidates together do as well"),
    };
    if let Some(before) = planned.before {
        let _ = writeln!(out, "what is measured already leaves {:.4} mm", mm(before));
    }
    out += "\n";
    let under_load = planned.stations.iter().any(|station| station.load != [0.0; 6]);
    let all_seen = planned.stations.iter().all(|station| station.markers.len() == request.markers.len());
    let units: Vec<String> =
        model.variables.iter().map(|v| format!("{} {}", v.name, if v.is_angle { "deg" } else { "mm" })).collect();
    let mut header = vec!["pose"];
    header.extend(units.iter().map(String::as_str));
    if under_load {
        header.extend(["fx N", "fy N", "fz N", "mx N.m", "my N.m", "mz N.m"]);
    }
    if !all_seen {
        header.push("seen");
    }
    out += &screen.table(
        &header,
        planned.stations.iter().enumerate().map(|(k, station)| {
            let mut row = vec![planned.campaign.poses[k].clone()];
            row.extend(station.q.iter().zip(&model.variables).map(|(q, v)| {
                let value = if v.is_angle { deg(*q) } else { mm(*q) };
                format!("{value:.2}")
            }));
            if under_load {
                row.extend(station.load.iter().map(|w| format!("{w}")));
            }
            if !all_seen {
                row.push(station.markers.iter().map(|&m| marker(model, m)).collect::<Vec<_>>().join(" "));
            }
            row
        }),
    );
    out += "\n";
    out += &screen.table(
        &["configurations", "planned mm", "random mm"],
        planned
            .bought
            .iter()
            .map(|b| vec![b.count.to_string(), format!("{:.4}", mm(b.planned)), format!("{:.4}", mm(b.random))]),
    );
    let _ = writeln!(out, "fewest that tell the parameters apart: {}\n", planned.least);
    out += &screen.table(
        &["parameter", "unit", "95 % +-"],
        planned.deviations.iter().map(|&(slot, sigma)| {
            let parameter = &model.registry[slot];
            let kind = parameter.shown_kind();
            let width = parameter.shown_width(parameter.nominal, normal95() * sigma);
            vec![parameter.name.clone(), unit(kind).0.into(), number(kind, width)]
        }),
    );
    let [o1, o2, o3, o4, o5] = planned.identifiability.observability;
    let _ = writeln!(
        out,
        "condition number {:.3e}; observability O1 {o1:.3e}  O2 {o2:.3e}  O3 {o3:.3e}  O4 {o4:.3e}  O5 {o5:.3e}",
        planned.identifiability.condition
    );
    out
}
