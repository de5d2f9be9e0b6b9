//! A diagnosis in words and in JSON.

use std::fmt::Write;

use serde_json::{Map, Value, json};

use super::plots::bars;
use super::table::{Screen, mm};
use crate::diagnosis::{Cause, Diagnosis, Structure, Verdict};
use crate::model::Model;

fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NoGap => "no-gap",
        Verdict::Explained => "explained",
        Verdict::PartlyExplained => "partly-explained",
        Verdict::Unexplained => "unexplained",
    }
}

/// JSON of `diagnose`; lengths in mm.
pub fn diagnosis_json(model: &Model, found: &Diagnosis, seconds: f64) -> Value {
    let gap = &found.gap;
    let site = |s: &crate::diagnosis::SiteShare| json!({"site": s.site, "share": s.share, "ci95": s.ci95});
    let conditions: Vec<Value> = found
        .location
        .conditions
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
    let yielding =
        found.location.yielding.as_ref().map(|y| json!({"when": y.when, "excess": y.excess, "elsewhere": y.elsewhere}));
    let structure: Vec<Value> =
        found.structure.iter().map(|s| json!({"against": s.against, "correlation": s.correlation, "p": s.p})).collect();
    let rejected: Vec<Value> = found
        .rejected
        .iter()
        .map(|r| json!({"effect": r.effect, "site": r.site, "rms_after": mm(r.rms), "why": r.why}))
        .collect();
    let alike = &found.look_alikes;
    let look_alikes = json!({
        "hypotheses": alike.names.iter().map(|(effect, site)| json!({"effect": effect, "site": site})).collect::<Vec<_>>(),
        "overlap": (0..alike.overlap.nrows())
            .map(|i| alike.overlap.row(i).iter().copied().collect::<Vec<f64>>())
            .collect::<Vec<_>>(),
    });
    json!({
        "gap": {"rms": mm(gap.rms), "max": mm(gap.max), "noise": mm(gap.noise), "closable": mm(gap.closable),
                "unit": "mm", "significant": gap.is_significant,
                "registration": if gap.registration.is_finite() { json!(mm(gap.registration)) } else { Value::Null }},
        "where": {"sites": found.location.sites.iter().map(site).collect::<Vec<_>>(), "conditions": conditions,
                  "directions": {"x": x, "y": y, "z": z}, "yielding": yielding},
        "verdict": verdict(found.verdict),
        "causes": found.causes.iter().map(cause_json).collect::<Vec<_>>(),
        "rejected": rejected,
        "with_none": mm(found.with_none),
        "after_all": {"rms": mm(found.after.0), "rms_ci95": found.after.1.map(mm), "shrinkage": found.shrinkage.value,
                      "shrinkage_ci95": found.shrinkage.ci95},
        "structure": structure,
        "next_poses": next,
        "look_alikes": look_alikes,
        "outliers": found.outliers,
        "hypotheses": found.hypotheses,
        "notes": found.notes,
        "seconds": seconds,
    })
}

fn cause_json(cause: &Cause) -> Value {
    let parameters: Vec<Value> = cause
        .parameters
        .iter()
        .map(|p| json!({"name": p.name, "unit": p.unit, "value": p.value, "ci95": p.ci95}))
        .collect();
    let rivals: Vec<Value> =
        cause.rivals.iter().map(|(effect, site)| json!({"effect": effect, "site": site})).collect();
    json!({"effect": cause.effect, "site": cause.site, "probability": cause.probability, "parameters": parameters,
           "rms_before": mm(cause.rms[0]), "rms_after": mm(cause.rms[1]), "shrinkage": cause.shrinkage.value,
           "shrinkage_ci95": cause.shrinkage.ci95, "indistinguishable_from": rivals,
           "signature": cause.words[0], "remedy": cause.words[1]})
}

/// Text of `diagnose`: finding, evidence, what to do.
pub fn diagnosis_text(name: &str, found: &Diagnosis, screen: Screen) -> String {
    let gap = &found.gap;
    let mut out = format!("{name}\n\n");
    let after = mm(found.after.0);
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
        let [low, high] = cause.shrinkage.ci95;
        let _ = writeln!(out, "{}. {} at {}", k + 1, cause.effect, cause.site);
        let _ = writeln!(
            out,
            "   evidence  {:.4} -> {:.4} mm, {:.0} % less ({:.0} to {:.0} %); probability {:.2}",
            mm(cause.rms[0]),
            mm(cause.rms[1]),
            100.0 * cause.shrinkage.value,
            100.0 * low,
            100.0 * high,
            cause.probability
        );
        let _ = writeln!(out, "   pattern   {}", cause.words[0]);
        for p in &cause.parameters {
            if p.name == "count" {
                let _ = writeln!(out, "   {:<9} {:.0}", p.name, p.value);
                continue;
            }
            let width = if p.ci95.is_finite() { format!(" +- {:.1e} {}", p.ci95, p.unit) } else { String::new() };
            let _ = writeln!(out, "   {:<9} {:+.4e}{width}", p.name, p.value);
        }
        if !cause.rivals.is_empty() {
            let rivals: Vec<String> = cause.rivals.iter().map(|(e, s)| format!("{e} at {s}")).collect();
            let _ = writeln!(out, "   these readings cannot tell it from: {}", rivals.join(", "));
        }
        let _ = writeln!(out, "   to do     {}\n", cause.words[1]);
    }
    if !found.causes.is_empty() {
        let row = |what: String, rms: f64| (what, rms, format!("{:.4} mm", mm(rms)));
        let mut rows = vec![row("calibrated".into(), gap.rms)];
        rows.extend(found.causes.iter().map(|c| row(format!("+ {} at {}", c.effect, c.site), c.rms[1])));
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
    for condition in &found.location.conditions {
        let _ = writeln!(
            out,
            "{:.4} mm where {}, {:.4} mm elsewhere",
            mm(condition.rms),
            condition.when,
            mm(condition.elsewhere)
        );
    }
    if let Some(found) = &found.location.yielding {
        let said = |v: f64| format!("{:.1} % {}", 100.0 * v.abs(), if v < 0.0 { "less" } else { "more" });
        let (inside, outside) = (said(found.excess), said(found.elsewhere));
        let _ = writeln!(out, "the robot yields {inside} than predicted where {}, {outside} elsewhere", found.when);
    }
    let [x, y, z] = found.location.directions.map(mm);
    let _ = writeln!(out, "all readings, by direction: x {x:.4}, y {y:.4}, z {z:.4} mm");
    if !found.structure.is_empty() {
        let one = |s: &Structure| format!("{} {:+.2} (p {:.3})", s.against, s.correlation, s.p);
        let all: Vec<String> = found.structure.iter().map(one).collect();
        let _ = writeln!(out, "correlation left between neighbours: {}", all.join(", "));
    }
    out.push('\n');
    if !found.rejected.is_empty() {
        let _ = writeln!(out, "all readings, by degree of freedom: {:.4} mm with no effect", mm(found.with_none));
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
