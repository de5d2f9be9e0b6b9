//! Identifiability and identification, in text and JSON.

use std::fmt::Write;

use serde_json::{Map, Value, json};

use super::plots::{bars, histogram};
use super::springs::{any_value, equivalence_json, equivalence_text, insensitive, insensitive_text};
use super::table::{Screen, deg, mm, number, unit};
use crate::description::campaign::Campaign;
use crate::estimation::{Calibration, Comparison, Errors, Estimate, Figures, PredictedError};
use crate::identifiability::{Identifiability, Sensitivity, Why};
use crate::model::Model;
use crate::parameter::Slot;

fn name<'m>(model: &'m Model, slots: &[Slot], column: usize) -> &'m str {
    &model.registry[slots[column]].name
}

fn why(why: Why) -> &'static str {
    match why {
        Why::Exact => "exact",
        Why::Weak => "weak",
        Why::Held => "held",
    }
}

/// JSON of the reduction, the common part of `identifiability` and `identify`. Factors are in SI units.
pub fn identifiability_json(model: &Model, slots: &[Slot], found: &Identifiability) -> Map<String, Value> {
    let combinations: Map<String, Value> = found
        .combinations
        .iter()
        .map(|(keeper, terms)| {
            let terms: Map<String, Value> =
                terms.iter().map(|&(column, factor)| (name(model, slots, column).into(), json!(factor))).collect();
            (name(model, slots, *keeper).into(), Value::Object(terms))
        })
        .collect();
    let dropped: Vec<Value> = found
        .dropped
        .iter()
        .map(|&(column, reason)| json!({"name": name(model, slots, column), "why": why(reason)}))
        .collect();
    let mut map = Map::new();
    map.insert("columns".into(), json!(found.columns));
    map.insert("rank".into(), json!(found.rank));
    map.insert("kept".into(), json!(found.kept.len()));
    map.insert("tolerance".into(), found.tolerance.map_or(json!("noise"), |tolerance| json!(tolerance)));
    map.insert("dropped".into(), json!(dropped));
    map.insert("combinations".into(), Value::Object(combinations));
    map.insert("condition".into(), json!(found.condition));
    let indices: Map<String, Value> =
        found.observability.iter().enumerate().map(|(k, v)| (format!("O{}", k + 1), json!(v))).collect();
    map.insert("observability".into(), Value::Object(indices));
    map.insert("singular_values".into(), json!(found.singular_values));
    map.insert("kept_parameters".into(), json!(found.kept.iter().map(|&c| name(model, slots, c)).collect::<Vec<_>>()));
    map
}

/// Text of the reduction.
pub fn identifiability_text(model: &Model, slots: &[Slot], found: &Identifiability, screen: Screen) -> String {
    let limit = found.tolerance.map_or("at the noise".into(), |tolerance| format!("at tolerance {tolerance:.1e}"));
    let mut out =
        format!("{} columns, rank {} (exact), {} kept {limit}\n", found.columns, found.rank, found.kept.len());
    let [o1, o2, o3, o4, o5] = found.observability;
    let _ = writeln!(
        out,
        "condition number {:.3e}; observability O1 {o1:.3e}  O2 {o2:.3e}  O3 {o3:.3e}  O4 {o4:.3e}  O5 {o5:.3e}",
        found.condition
    );
    if found.dropped.is_empty() {
        return out;
    }
    out += "\n";
    out += &screen.table(
        &["dropped", "why", "remainder", "merged into (factor)"],
        found.dropped.iter().map(|&(column, reason)| {
            let unit_of = |column: usize| unit(model.registry[slots[column]].kind);
            let mut terms: Vec<(usize, f64)> = found
                .combinations
                .iter()
                .flat_map(|(keeper, terms)| terms.iter().filter(|term| term.0 == column).map(|term| (*keeper, term.1)))
                .collect();
            terms.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
            let shown: Vec<String> = terms
                .iter()
                .map(|&(keeper, factor)| {
                    let ((to, to_size), (from, from_size)) = (unit_of(keeper), unit_of(column));
                    let units = if to == from { String::new() } else { format!(" {to}/{from}") };
                    (
                        factor * from_size / to_size,
                        format!("{} ({:+.3}{units})", name(model, slots, keeper), factor * from_size / to_size),
                    )
                })
                .filter(|(factor, _)| factor.abs() >= 5e-4)
                .map(|(_, text)| text)
                .take(8)
                .collect();
            let merged = match (shown.is_empty(), found.remainder[column] == 0.0 && terms.is_empty()) {
                (true, true) => "nothing: it has no effect here".into(),
                (true, false) => "no other by more than 0.0005".into(),
                _ => shown.join(", "),
            };
            vec![
                name(model, slots, column).into(),
                why(reason).into(),
                format!("{:.1e}", found.remainder[column]),
                merged,
            ]
        }),
    );
    out
}

/// Sensitivities, mm and deg per mm or deg.
pub fn sensitivity_text(model: &Model, found: &[Sensitivity], screen: Screen) -> String {
    let rows = found.iter().map(|s| {
        let (per, size) = unit(model.registry[s.slot].kind);
        let position = |v: f64| format!("{:.4} mm/{per}", mm(v) * size);
        let orientation = |v: f64| format!("{:.4} deg/{per}", deg(v) * size);
        vec![
            model.registry[s.slot].name.clone(),
            position(s.position[0]),
            position(s.position[1]),
            orientation(s.orientation[0]),
            orientation(s.orientation[1]),
        ]
    });
    screen.table(&["parameter", "mu_P mean", "mu_P max", "mu_Phi mean", "mu_Phi max"], rows)
}

/// Sensitivities, SI.
pub fn sensitivity_json(model: &Model, found: &[Sensitivity]) -> Value {
    let each = |s: &Sensitivity| {
        json!({"name": model.registry[s.slot].name, "mu_P": {"mean": s.position[0], "max": s.position[1]},
               "mu_Phi": {"mean": s.orientation[0], "max": s.orientation[1]}})
    };
    json!({"unit": "m or rad per m or rad", "parameters": found.iter().map(each).collect::<Vec<_>>()})
}

/// Figures of a set of readings, mm and deg.
pub fn errors_json(errors: &Errors) -> Value {
    if errors.readings == 0 {
        return Value::Null;
    }
    let [mean, rms, max] = errors.distance.map(mm);
    let mut value = json!({"readings": errors.readings, "mean": mean, "rms": rms, "max": max,
                           "coordinate": {"rms": mm(errors.coordinate[0]), "max": mm(errors.coordinate[1])}});
    if let Some(orientation) = errors.orientation {
        let [mean, rms, max] = orientation.map(deg);
        value["orientation"] = json!({"unit": "deg", "mean": mean, "rms": rms, "max": max});
    }
    value
}

/// A table of figures, one row a set of readings.
pub fn errors_table(rows: &[(&str, &Errors)], screen: Screen) -> String {
    let turned = rows.iter().any(|(_, errors)| errors.orientation.is_some());
    let mut header =
        vec!["residuals", "readings", "mean mm", "rms mm", "max mm", "coordinate rms mm", "coordinate max mm"];
    if turned {
        header.extend(["orientation rms deg", "orientation max deg"]);
    }
    let row = |(what, errors): &(&str, &Errors)| {
        let mut row = vec![(*what).to_string(), errors.readings.to_string()];
        row.extend(errors.distance.iter().chain(&errors.coordinate).map(|v| format!("{:.4}", mm(*v))));
        row.extend(errors.orientation.iter().flat_map(|o| o[1..].iter().map(|v| format!("{:.4}", deg(*v)))));
        row
    };
    screen.table(&header, rows.iter().filter(|(_, errors)| errors.readings > 0).map(row))
}

/// JSON of `identify`.
pub fn calibration_json(model: &Model, campaign: &Campaign, found: &Calibration, seconds: f64) -> Value {
    let mut map = identifiability_json(model, &found.slots, &found.identifiability);
    let parameters: Vec<Value> = found
        .estimates
        .iter()
        .map(|estimate| {
            let parameter = &model.registry[estimate.slot];
            let (unit, size) = unit(parameter.shown_kind());
            let shown = |value: f64| parameter.shown(value) / size;
            let ci95 = estimate.ci95.map(|ci95| parameter.shown_width(estimate.value, ci95) / size);
            let mut entry = json!({"name": parameter.name, "unit": unit, "nominal": shown(estimate.nominal),
                                   "value": shown(estimate.value), "ci95": ci95, "identifiable": estimate.identifiable(),
                                   "at_bound": estimate.at_bound});
            if let Some(moves) = estimate.moves {
                entry["moves"] = json!(mm(moves));
                entry["insensitive"] = json!(insensitive(campaign, estimate));
            }
            entry
        })
        .collect();
    map.insert("parameters".into(), json!(parameters));
    let equivalences: Vec<Value> =
        found.equivalences.iter().map(|group| equivalence_json(model, campaign, found, group)).collect();
    map.insert("equivalences".into(), json!(equivalences));
    let residuals = json!({
        "before": errors_json(&found.before.fit), "registration": errors_json(&found.registration.fit), "after": errors_json(&found.after.fit),
        "check_before": errors_json(&found.before.check), "check_registration": errors_json(&found.registration.check),
        "check_after": errors_json(&found.after.check),
    });
    map.insert("residuals".into(), residuals);
    let predicted = found.predicted.map(|p| json!({"parameters_rms": mm(p.parameters), "with_noise_rms": mm(p.with_noise), "observed_rms": mm(found.after.check.distance[1])}));
    map.insert("predicted_error".into(), json!(predicted));
    map.insert("noise_ratio".into(), json!(campaign.sigma.map(|_| found.noise_ratio)));
    map.insert("direction_noise".into(), json!(found.direction_noise.map(mm)));
    map.insert(
        "correlation".into(),
        json!(
            (0..found.correlation.nrows())
                .map(|i| found.correlation.row(i).iter().copied().collect::<Vec<f64>>())
                .collect::<Vec<_>>()
        ),
    );
    map.insert("unit".into(), json!("mm"));
    map.insert("iterations".into(), json!(found.iterations));
    map.insert("ending".into(), json!(found.ending.to_string()));
    map.insert("converged".into(), json!(found.converged()));
    map.insert("seconds".into(), json!(seconds));
    Value::Object(map)
}

/// Whether base or tool have a say in the readings: not in deflections.
fn registers(campaign: &Campaign) -> bool {
    !campaign.observes.is_difference()
}

/// Text of `identify`.
pub fn calibration_text(model: &Model, campaign: &Campaign, found: &Calibration, screen: Screen) -> String {
    let mut out = format!("{}\n\n", campaign.name);
    let (after, registration) = (&found.after, &found.registration);
    let judged = if after.check.readings > 0 {
        (&registration.check, &after.check, "readings the fit did not see")
    } else {
        (&registration.fit, &after.fit, "the fitted readings; none were set aside")
    };
    let _ = writeln!(
        out,
        "rms error {:.4} mm {} -> {:.4} mm calibrated ({})\n",
        mm(judged.0.distance[1]),
        if registers(campaign) { "with base and tool fitted alone" } else { "with the description as it is" },
        mm(judged.1.distance[1]),
        judged.2
    );
    let rows = [
        ("fit: description as it is", &found.before.fit),
        ("fit: registration only", &registration.fit),
        ("fit: calibrated", &after.fit),
        ("check: description as it is", &found.before.check),
        ("check: registration only", &registration.check),
        ("check: calibrated", &after.check),
    ];
    let shown = |(name, _): &&(&str, &Errors)| registers(campaign) || !name.contains("registration");
    out += &errors_table(&rows.iter().filter(shown).copied().collect::<Vec<_>>(), screen);
    out += "\n";
    out += &steps(campaign, found, screen);
    out += "\n";
    if let Some(PredictedError { parameters, with_noise: all }) = found.predicted {
        let _ = writeln!(
            out,
            "position error foretold by the parameters' covariance {:.4} mm, with the residual noise {:.4} mm; observed {:.4} mm (rms, check)",
            mm(parameters),
            mm(all),
            mm(after.check.distance[1])
        );
    }
    if campaign.sigma.is_some() {
        let _ = writeln!(out, "residuals are {:.2} times the stated noise", found.noise_ratio);
        if found.noise_ratio > 2.0 {
            let _ = writeln!(
                out,
                "  something else than what was fitted is left: intervals cover its scatter, not its shape"
            );
        }
    }
    out += "\n";
    out += &identifiability_text(model, &found.slots, &found.identifiability, screen);
    out += "\n";
    out += &screen.table(
        &["parameter", "unit", "nominal", "value", "change", "95 % +-", ""],
        found.estimates.iter().filter(|e| e.identifiable()).map(|estimate| {
            let parameter = &model.registry[estimate.slot];
            let kind = parameter.shown_kind();
            let shown = |value: f64| number(kind, parameter.shown(value));
            let change = parameter.shown(estimate.value) - parameter.shown(estimate.nominal);
            let merged = found.equivalences.iter().any(|group| group.springs.members[0].0 == estimate.slot);
            let diagnostic = match (estimate.at_bound, merged) {
                _ if insensitive(campaign, estimate) => any_value(parameter, estimate),
                (true, _) => "at its bound".to_string(),
                (_, true) => "with its group, below".to_string(),
                _ => String::new(),
            };
            vec![
                parameter.name.clone(),
                unit(kind).0.into(),
                shown(estimate.nominal),
                shown(estimate.value),
                number(kind, change),
                estimate
                    .ci95
                    .map_or_else(String::new, |ci95| number(kind, parameter.shown_width(estimate.value, ci95))),
                diagnostic,
            ]
        }),
    );
    out += &equivalence_text(model, campaign, found, screen);
    out += &insensitive_text(model, campaign, found);
    let strongest = strongest_correlations(model, found);
    if !strongest.is_empty() {
        let _ = writeln!(out, "strongest correlations: {}", strongest.join(", "));
    }
    let _ = writeln!(
        out,
        "{} iterations; ended by: {}{}",
        found.iterations,
        found.ending,
        if found.converged() { "" } else { " (NOT converged)" }
    );
    out
}

/// The rms error step by step down to the noise, and the coordinates that are left, as bars.
fn steps(campaign: &Campaign, found: &Calibration, screen: Screen) -> String {
    let seen = found.after.check.readings == 0;
    let of = |figures: &Figures| if seen { figures.fit.distance[1] } else { figures.check.distance[1] };
    let row = |what: &str, rms: f64| (what.to_string(), rms, format!("{:.4} mm", mm(rms)));
    let mut rows = vec![row("description as it is", of(&found.before))];
    if registers(campaign) {
        rows.push(row("registration only", of(&found.registration)));
    }
    rows.push(row("calibrated", of(&found.after)));
    let lengths = campaign.observes.length_rows();
    if campaign.sigma.is_some() {
        let sigmas = campaign.observes.sigmas(&campaign.noise());
        rows.push(row("stated noise", sigmas[..lengths].iter().map(|s| s * s).sum::<f64>().sqrt()));
    }
    let which = if seen { "fitted readings" } else { "readings the fit did not see" };
    let mut out = format!("rms error, {which}\n{}", bars(&rows, screen));
    let readings = found.residual.chunks(campaign.components());
    let left: Vec<f64> = readings.flat_map(|reading| &reading[..lengths]).copied().collect();
    let drawn = histogram(&left, screen);
    if !drawn.is_empty() {
        let what = campaign.observes.residuals_named();
        let _ = write!(out, "\n{what} of all readings after calibration, number by error\n{drawn}");
    }
    out
}

fn strongest_correlations(model: &Model, found: &Calibration) -> Vec<String> {
    let n = found.correlation.nrows();
    let mut pairs: Vec<(f64, usize, usize)> =
        (0..n).flat_map(|i| (0..i).map(move |j| (found.correlation[(i, j)], j, i))).collect();
    pairs.retain(|(c, ..)| c.abs() > 0.9);
    pairs.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
    let name = |k: usize| name(model, &found.slots, found.identifiability.kept[k]);
    pairs.iter().take(5).map(|&(c, i, j)| format!("{} ~ {} ({c:+.3})", name(i), name(j))).collect()
}

/// Ordinary and weighted least squares side by side.
pub fn comparison_text(model: &Model, found: &Comparison, screen: Screen) -> String {
    let mut out = String::from("ordinary (equal weights) and weighted least squares (noise by direction)\n\n");
    let [x, y, z] = found.ols.direction_noise.map(|s| s * 1e6);
    let _ = writeln!(out, "residual noise by direction: x {x:.1} um, y {y:.1} um, z {z:.1} um\n");
    out += &screen.table(
        &["parameter", "unit", "OLS", "+-", "WLS", "+-"],
        found.ols.estimates.iter().zip(&found.wls.estimates).filter(|(o, w)| o.identifiable() && w.identifiable()).map(
            |(o, w)| {
                let parameter = &model.registry[o.slot];
                let kind = parameter.shown_kind();
                let shown = |e: &Estimate| number(kind, parameter.shown(e.value));
                let width = |e: &Estimate| {
                    e.ci95.map_or_else(String::new, |ci95| number(kind, parameter.shown_width(e.value, ci95)))
                };
                vec![parameter.name.clone(), unit(kind).0.into(), shown(o), width(o), shown(w), width(w)]
            },
        ),
    );
    out += &errors_table(
        &[
            ("check: OLS", &found.ols.after.check),
            ("check: WLS", &found.wls.after.check),
            ("fit: OLS", &found.ols.after.fit),
            ("fit: WLS", &found.wls.after.fit),
        ],
        screen,
    );
    out
}
