//! A diagnosis in words and in JSON.

use std::fmt::Write;

use serde_json::{Map, Value, json};

use super::plots::bars;
use super::table::{Screen, mm};
use crate::description::raw::RawAmount;
use crate::diagnosis::{Autocorrelation, Cause, CauseParameter, Diagnosis, EffectAtSite, NoiseSource, Verdict};
use crate::model::Model;

/// JSON of `diagnose`; lengths in mm.
pub fn diagnosis_json(model: &Model, found: &Diagnosis, seconds: f64) -> Value {
    let gap = &found.gap;
    let conditions: Vec<Value> = found
        .location
        .regions
        .iter()
        .map(|c| json!({"when": c.when, "rms": mm(c.rms), "elsewhere": mm(c.elsewhere)}))
        .collect();
    let [x, y, z] = found.location.directions.map(mm);
    let next: Vec<Value> = found
        .next_poses
        .iter()
        .map(|pose| {
            let joints: Map<String, Value> =
                model.variables.iter().zip(&pose.q).map(|(variable, q)| (variable.name.clone(), json!(q))).collect();
            json!({"joints": joints, "wrench": pose.wrench, "separates": pose.separates, "apart": mm(pose.apart),
                   "sigmas": pose.sigmas})
        })
        .collect();
    let rejected: Vec<Value> = found
        .rejected
        .iter()
        .map(|r| json!({"effect": r.effect, "site": r.site, "rms_after": mm(r.rms), "why": r.why}))
        .collect();
    json!({
        "gap": {"rms": mm(gap.rms), "max": mm(gap.max), "noise": mm(gap.noise), "closable": mm(gap.closable),
                "unit": "mm", "significant": gap.is_significant,
                "registration": gap.registration.map(mm)},
        "where": {"sites": found.location.sites, "conditions": conditions,
                  "directions": {"x": x, "y": y, "z": z}, "yielding": found.location.excess_compliance},
        "verdict": found.verdict,
        "causes": found.causes.iter().map(cause_json).collect::<Vec<_>>(),
        "rejected": rejected,
        "with_none": mm(found.rms_with_none),
        "after_all": {"rms": mm(found.rms_after), "rms_ci95": ends(found.rms_after_ci95).map(|v| v.map(mm)),
                      "shrinkage": found.shrinkage.value, "shrinkage_ci95": ends(found.shrinkage.ci95)},
        "structure": found.autocorrelation,
        "next_poses": next,
        "look_alikes": found.look_alikes,
        "outliers": found.outliers,
        "hypotheses": found.hypotheses,
        "notes": {"noise": noise_source(found.noise_source)},
        "seconds": seconds,
    })
}

fn cause_json(cause: &Cause) -> Value {
    json!({"effect": cause.effect, "site": cause.site, "probability": cause.probability, "parameters": cause.parameters,
           "rms_before": mm(cause.rms_before), "rms_after": mm(cause.rms_after), "shrinkage": cause.shrinkage.value,
           "shrinkage_ci95": ends(cause.shrinkage.ci95), "indistinguishable_from": cause.rivals,
           "signature": cause.signature, "remedy": cause.remedy})
}

/// Both ends of an interval, null where there is none.
fn ends(interval: Option<[f64; 2]>) -> [Option<f64>; 2] {
    interval.map_or([None; 2], |ends| ends.map(Some))
}

fn noise_source(source: NoiseSource) -> &'static str {
    match source {
        NoiseSource::Stated => "as the campaign states",
        NoiseSource::Repeated => "from repeated readings",
        NoiseSource::Residual => "from what the best explanation leaves",
    }
}

/// Text of `diagnose`: finding, evidence, what to do.
pub fn diagnosis_text(name: &str, found: &Diagnosis, screen: Screen) -> String {
    let gap = &found.gap;
    let mut out = format!("{name}\n\n");
    let after = mm(found.rms_after);
    let finding = match found.verdict {
        Verdict::NoGap => format!(
            "No gap: calibration leaves {:.4} mm (rms, unseen readings), and noise alone gives {:.4} mm.",
            mm(gap.rms),
            mm(gap.noise)
        ),
        Verdict::Unexplained => format!(
            "Unexplained: calibration leaves {:.4} mm where noise gives {:.4} mm, and none of the {} hypotheses explains it.",
            mm(gap.rms),
            mm(gap.noise),
            found.hypotheses
        ),
        Verdict::Explained | Verdict::PartlyExplained => {
            let named: Vec<String> = found.causes.iter().map(|c| format!("{} at {}", c.effect, c.site)).collect();
            format!(
                "{}: {}. The gap shrinks from {:.4} to {after:.4} mm (rms, unseen readings; noise {:.4} mm).",
                if found.verdict == Verdict::Explained { "Explained" } else { "Partly explained" },
                named.join(", then "),
                mm(gap.rms),
                mm(gap.noise)
            )
        }
    };
    let _ = writeln!(out, "{finding}\n");
    for (k, cause) in found.causes.iter().enumerate() {
        let interval = cause
            .shrinkage
            .ci95
            .map_or(String::new(), |[low, high]| format!(" ({:.0} to {:.0} %)", 100.0 * low, 100.0 * high));
        let probability =
            cause.probability.map_or(String::new(), |probability| format!("; probability {probability:.2}"));
        let _ = writeln!(out, "{}. {} at {}", k + 1, cause.effect, cause.site);
        let _ = writeln!(
            out,
            "   evidence  {:.4} -> {:.4} mm, {:.0} % less{interval}{probability}",
            mm(cause.rms_before),
            mm(cause.rms_after),
            100.0 * cause.shrinkage.value,
        );
        let _ = writeln!(out, "   pattern   {}", cause.signature);
        for CauseParameter { name, unit, value, ci95 } in &cause.parameters {
            let width = ci95.filter(|_| name != "count").map_or(String::new(), |ci95| format!(" +- {ci95:.1e} {unit}"));
            let value = match value {
                RawAmount::Number(count) if name == "count" => format!("{count:.0}"),
                RawAmount::Number(value) => format!("{value:+.4e}"),
                RawAmount::Name(word) => word.clone(),
            };
            let _ = writeln!(out, "   {name:<9} {value}{width}");
        }
        if !cause.rivals.is_empty() {
            let rivals: Vec<String> =
                cause.rivals.iter().map(|EffectAtSite { effect, site }| format!("{effect} at {site}")).collect();
            let _ = writeln!(out, "   these readings cannot tell it from: {}", rivals.join(", "));
        }
        let _ = writeln!(out, "   to do     {}\n", cause.remedy);
    }
    if !found.causes.is_empty() {
        let row = |what: String, rms: f64| (what, rms, format!("{:.4} mm", mm(rms)));
        let mut rows = vec![row("calibrated".into(), gap.rms)];
        rows.extend(found.causes.iter().map(|c| row(format!("+ {} at {}", c.effect, c.site), c.rms_after)));
        rows.push(row("noise".into(), gap.noise));
        let _ = writeln!(out, "rms error, unseen readings\n{}", bars(&rows, screen));
    }
    if !found.outliers.is_empty() {
        let rows: Vec<String> = found.outliers.iter().take(20).map(ToString::to_string).collect();
        let _ = writeln!(out, "wrong readings, by row: {}\n", rows.join(", "));
    }
    out += "where the gap lies\n";
    if found.location.sites.is_empty() {
        out += "no site could carry it by a free error\n";
    } else {
        out += &screen.table(
            &["a free error at", "could carry %", "95 % from", "to"],
            found.location.sites.iter().take(8).map(|s| {
                let shown = |v: f64| format!("{:.0}", 100.0 * v);
                vec![s.site.clone(), shown(s.share), shown(s.ci95[0]), shown(s.ci95[1])]
            }),
        );
    }
    for region in &found.location.regions {
        let _ =
            writeln!(out, "{:.4} mm where {}, {:.4} mm elsewhere", mm(region.rms), region.when, mm(region.elsewhere));
    }
    if let Some(found) = &found.location.excess_compliance {
        let said = |v: f64| format!("{:.1} % {}", 100.0 * v.abs(), if v < 0.0 { "less" } else { "more" });
        let (inside, outside) = (said(found.excess), said(found.elsewhere));
        let _ = writeln!(out, "the robot yields {inside} than predicted where {}, {outside} elsewhere", found.when);
    }
    let [x, y, z] = found.location.directions.map(mm);
    let _ = writeln!(out, "all readings, by direction: x {x:.4}, y {y:.4}, z {z:.4} mm");
    if !found.autocorrelation.is_empty() {
        let one = |s: &Autocorrelation| format!("{} {:+.2} (p {:.3})", s.against, s.correlation, s.p);
        let all: Vec<String> = found.autocorrelation.iter().map(one).collect();
        let _ = writeln!(out, "correlation left between neighbours: {}", all.join(", "));
    }
    out.push('\n');
    if !found.rejected.is_empty() {
        let _ = writeln!(out, "all readings, by degree of freedom: {:.4} mm with no effect", mm(found.rms_with_none));
        out += &screen.table(
            &["not taken", "at", "rms with it alone mm", "why"],
            found
                .rejected
                .iter()
                .take(6)
                .map(|r| vec![r.effect.clone(), r.site.clone(), format!("{:.4}", mm(r.rms)), r.why.to_string()]),
        );
    }
    // The best pose of all for the first pair.
    if let Some(pose) = found.next_poses.first().filter(|pose| pose.sigmas < 1.0) {
        let _ = writeln!(
            out,
            "\nno configuration within the limits tells {} from {} by as much as the noise",
            pose.separates[0], pose.separates[1]
        );
    } else if let Some(pose) = found.next_poses.first() {
        let _ = writeln!(
            out,
            "\nto tell {} from {}, measure where they differ by {:.3} mm ({:.0} sigma): see next_poses in --format json",
            pose.separates[0],
            pose.separates[1],
            mm(pose.apart),
            pose.sigmas
        );
    }
    out
}
