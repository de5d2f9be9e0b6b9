//! Identifiability and identification as text. Lengths in mm, angles in deg, everything else in SI.

use std::fmt::Write;

use super::against::compared;
use super::plots::{bars, histogram};
use super::table::{Screen, number};
use crate::estimation::Together;
use crate::math::distinct;
use crate::results::units::{deg, mm};
use crate::results::{
    CombinedParameter, DescriptionResiduals, Dropped, ElasticSensitivity, Identification, MovedParameter,
    ParameterEstimate, PartErrors, ReadingErrors, Reduction, SchemeComparison, Sensitivities, Since, SpringGroup,
    WeightSource, WorstReading,
};

/// Factors below this are not shown.
const LEAST_FACTOR: f64 = 5e-4;
/// Most parameters shown into which a dropped one is merged.
const MOST_MERGED: usize = 8;

/// Text of the reduction.
pub fn reduction(found: &Reduction, screen: Screen) -> String {
    let limit = found.tolerance.map_or("at the noise".into(), |tolerance| format!("at tolerance {tolerance:.1e}"));
    let mut out = format!("{} columns, rank {} (exact), {} kept {limit}\n", found.columns, found.rank, found.kept);
    out += &conditioning(found);
    if let Some(own_weight) = found.own_weight {
        let _ = writeln!(out, "{}", own_weight.of_readings());
    }
    if found.dropped.is_empty() {
        return out;
    }
    let row = |d: &Dropped| vec![d.name.clone(), d.why.to_string(), format!("{:.1e}", d.remainder), merged(d)];
    out += "\n";
    out += &screen.table(&["dropped", "why", "remainder", "merged into (factor)"], found.dropped.iter().map(row));
    out
}

/// Condition number and observability indices; nothing where no parameter is kept.
pub(super) fn conditioning(found: &Reduction) -> String {
    let (Some(condition), Some(o)) = (found.condition, &found.observability) else { return String::new() };
    format!(
        "condition number {condition:.3e}; observability O1 {:.3e}  O2 {:.3e}  O3 {:.3e}  O4 {:.3e}  O5 {:.3e}\n",
        o.o1, o.o2, o.o3, o.o4, o.o5
    )
}

fn merged(dropped: &Dropped) -> String {
    let shown: Vec<String> = dropped
        .merged
        .iter()
        .filter(|merged| merged.factor.abs() >= LEAST_FACTOR)
        .take(MOST_MERGED)
        .map(|merged| {
            let unit = if merged.unit.is_empty() { String::new() } else { format!(" {}", merged.unit) };
            format!("{} ({:+.3}{unit})", merged.keeper, merged.factor)
        })
        .collect();
    match (shown.is_empty(), dropped.remainder == 0.0 && dropped.merged.is_empty()) {
        (true, true) => "nothing: it has no effect here".into(),
        (true, false) => "no other by more than 0.0005".into(),
        _ => shown.join(", "),
    }
}

/// Sensitivities, mm and deg per mm or deg.
pub fn sensitivities(found: &Sensitivities, screen: Screen) -> String {
    let rows = found.parameters.iter().map(|s| {
        let (per, size) = s.per;
        let position = |v: f64| format!("{:.4} mm/{per}", mm(v) * size);
        let orientation = |v: f64| format!("{:.4} deg/{per}", deg(v) * size);
        let (p, o) = (&s.position, &s.orientation);
        vec![s.name.clone(), position(p.mean), position(p.max), orientation(o.mean), orientation(o.max)]
    });
    let mut out = screen.table(&["parameter", "mu_P mean", "mu_P max", "mu_Phi mean", "mu_Phi max"], rows);
    // What moves nothing here is left out.
    let mut elastic: Vec<&ElasticSensitivity> = found.elastic.iter().filter(|s| s.position.max > 0.0).collect();
    if elastic.is_empty() {
        return out + "\n" + &found.own_weight.of_readings() + "\n";
    }
    elastic.sort_by(|a, b| b.of_value.mean.total_cmp(&a.of_value.mean));
    let rows = elastic.into_iter().map(|s| {
        let ten_percent = |m: f64| format!("{:.4} mm", 0.1 * mm(m));
        let turned = format!("{:.5} deg", 0.1 * deg(s.turn_of_value.mean));
        let of_value = match s.value == 0.0 {
            true => ["-", "-", "-"].map(String::from),
            false => [ten_percent(s.of_value.mean), ten_percent(s.of_value.max), turned],
        };
        let value = format!("{:.3e} {}", s.value, s.unit);
        let own =
            [s.name.clone(), value, format!("{:.3e} m", s.position.mean), format!("{:.3e} rad", s.orientation.mean)];
        own.into_iter().chain(of_value).collect()
    });
    out += "\nunder the campaign's loads: by one SI unit, and by 10 % of the value\n";
    let header =
        ["elastic parameter", "value", "mu_P mean", "mu_Phi mean", "10 %: mean", "10 %: max", "10 %: rotation mean"];
    out += &screen.table(&header, rows);
    out + "\n" + &found.own_weight.of_readings() + "\n"
}

/// A table of errors, one row a set of readings; sets of no readings are left out.
pub fn errors(rows: &[(&str, &Option<ReadingErrors>)], screen: Screen) -> String {
    let rows = || rows.iter().filter_map(|(what, errors)| Some((*what, errors.as_ref()?)));
    let lengths =
        |e: &ReadingErrors| e.has_lengths().then_some(vec![e.mean, e.rms, e.max, e.coordinate.rms, e.coordinate.max]);
    type Values<'a> = &'a dyn Fn(&ReadingErrors) -> Option<Vec<f64>>;
    let columns: [(&[&str], usize, Values); 3] = [
        (&["mean mm", "rms mm", "max mm", "coordinate rms mm", "coordinate max mm"], 4, &lengths),
        (&["orientation rms deg", "orientation max deg"], 4, &|e| e.orientation.map(|o| vec![o.rms, o.max])),
        (&["torque rms N.m", "torque max N.m"], 3, &|e| e.load.map(|load| vec![load.rms, load.max])),
    ];
    let shown = || columns.iter().filter(|(.., values)| rows().any(|(_, errors)| values(errors).is_some()));
    let header: Vec<&str> =
        ["residuals", "readings"].into_iter().chain(shown().flat_map(|(names, ..)| names.iter().copied())).collect();
    let row = |(what, e): (&str, &ReadingErrors)| {
        let mut row = vec![what.to_string(), e.readings.to_string()];
        for (names, digits, values) in shown() {
            match values(e) {
                Some(values) => row.extend(values.iter().map(|value| format!("{value:.digits$}"))),
                None => row.extend(names.iter().map(|_| String::new())),
            }
        }
        row
    };
    screen.table(&header, rows().map(row))
}

/// Text of `identify`.
pub fn identification(found: &Identification, screen: Screen) -> String {
    let mut out = format!("{}\n\n", found.campaign);
    if found.refusals.is_empty() {
        out += &judgement(found, screen);
    } else {
        for refusal in &found.refusals {
            let _ = writeln!(out, "NO RESULT: {}", refusal.message);
            refusal.remedy.iter().for_each(|remedy| out += &format!("  {remedy}\n"));
        }
        out += "\nwhere the fit stopped, which is no estimate:\n";
    }
    out += "\n";
    out += &reduction(&found.reduction, screen);
    out += "\n";
    out += &screen.table(
        &["parameter", "unit", "nominal", "value", "change", "95 % +-", ""],
        found.parameters.iter().filter(|p| p.identifiable || p.is_held_elsewhere()).map(|p| parameter_row(found, p)),
    );
    for set in &found.conventions {
        let row = |p: &CombinedParameter| {
            let shown = |value: f64| number(p.unit, value);
            vec![p.name.clone(), p.unit.into(), shown(p.value), p.ci95.map_or(String::new(), shown)]
        };
        let _ = writeln!(out, "\nchanges as {}", set.convention);
        out += &screen.table(&["parameter", "unit", "change", "95 % +-"], set.parameters.iter().map(row));
    }
    out += &spring_groups(&found.equivalences, screen);
    out += &found.since.as_ref().map_or(String::new(), |since| moved(since, screen));
    out += &found.against.as_ref().map_or(String::new(), |against| compared(against, screen));
    out += &insensitive(found);
    let strongest = strongest_correlations(found);
    if !strongest.is_empty() {
        let _ = writeln!(out, "strongest correlations: {}", strongest.join(", "));
    }
    let converged = if found.converged { "" } else { " (NOT converged)" };
    let _ = writeln!(out, "{}", found.own_weight.of_readings());
    let _ = writeln!(out, "{} iterations; ended by: {}{converged}", found.iterations, found.ending);
    out
}

/// The headline, and the errors that it rests on.
fn judgement(found: &Identification, screen: Screen) -> String {
    let mut out = String::new();
    let [_, registration, after] = found.judged();
    let unit = found.judged_unit();
    let _ = writeln!(
        out,
        "rms error {registration:.4} {unit} {} -> {after:.4} {unit} calibrated ({})\n",
        if found.is_registered() { "with base and tool fitted alone" } else { "with the description as it is" },
        if found.is_checked() { "readings the fit did not see" } else { "the fitted readings; none were held out" },
    );
    let r = &found.residuals;
    let mut rows = vec![
        ("fit: description as it is", &r.before),
        ("fit: registration only", &r.registration),
        ("fit: calibrated", &r.after),
        ("check: description as it is", &r.check_before),
        ("check: registration only", &r.check_registration),
        ("check: calibrated", &r.check_after),
    ];
    if !found.is_registered() {
        rows = vec![rows[0], rows[2], rows[3], rows[5]];
    }
    out += &errors(&rows, screen);
    let which = if found.is_checked() { "check" } else { "fit" };
    let named = |part: &PartErrors| format!("{which}: {} {}", part.part, part.name);
    let parts: Vec<(String, Option<ReadingErrors>)> =
        found.parts.iter().map(|part| (named(part), Some(part.errors))).collect();
    if !parts.is_empty() {
        let rows: Vec<(&str, &Option<ReadingErrors>)> = parts.iter().map(|(name, e)| (name.as_str(), e)).collect();
        out += &errors(&rows, screen);
    }
    out += &worst(&found.worst);
    out += "\n";
    out += &steps(found, screen);
    out += "\n";
    out + &certainty(found)
}

/// How far the errors of unseen readings are as predicted, and what is known of the noise.
fn certainty(found: &Identification) -> String {
    let mut out = String::new();
    if let Some(predicted) = &found.predicted_error {
        let _ = writeln!(
            out,
            "position error predicted by the parameters' covariance {:.4} mm, with the residual noise {:.4} mm; observed {:.4} mm (rms, check)",
            predicted.parameters_rms, predicted.with_noise_rms, predicted.observed_rms
        );
    }
    if !found.configurations.is_empty() {
        let within = found.configurations.iter().filter(|of| of.within).count();
        let all = found.configurations.len();
        let _ = writeln!(
            out,
            "the error of {within} of the {all} configurations held out lies in its predicted 95 % interval"
        );
    }
    let shown_by = found.noise_sources.position.shown_by();
    if found.noise_sources.position == WeightSource::Residuals {
        out += "noise not known: the model's own leftover stands for it in all intervals\n";
    }
    if let (Some(shown_by), Some(noise)) = (shown_by, found.noise) {
        let _ = writeln!(out, "noise not stated: {noise:.4} mm (rms of a reading) from {shown_by}");
    }
    if found.noise_sources.orientation == Some(WeightSource::Residuals) {
        out += "noise of orientations not stated: estimated from their residuals\n";
    }
    if let Some(ratio) = found.noise_ratio {
        let noise = if shown_by.is_some() { "that" } else { "the stated" };
        let _ = writeln!(out, "residuals are {ratio:.2} times {noise} noise");
        if ratio > 2.0 {
            out += "  something else than what was fitted is left: intervals cover its scatter, not its shape\n";
        }
    }
    out
}

fn parameter_row(found: &Identification, p: &ParameterEstimate) -> Vec<String> {
    let is_merged = found.equivalences.iter().any(|group| group.members.first() == Some(&p.name));
    let note = match (p.at_bound, is_merged) {
        _ if p.insensitive == Some(true) => any_value(p),
        _ if !p.identifiable => "dropped: the others hold with this value".to_string(),
        (true, _) => "at its bound".to_string(),
        (_, true) => "with its group, below".to_string(),
        _ if p.interval.is_some() => {
            let ends = p.interval.map(|ends| ends.map(|end| number(p.unit, end)).join(" to "));
            ends.unwrap_or_default()
        }
        _ if p.is_uncertain_by_dropped() => "+- mostly by dropped ones".to_string(),
        _ => String::new(),
    };
    let shown = |value: f64| number(p.unit, value);
    let width = p.ci95.map_or(String::new(), shown);
    let [nominal, change] =
        [p.nominal, p.nominal.map(|nominal| p.value - nominal)].map(|v| v.map_or(String::new(), shown));
    vec![p.name.clone(), p.unit.into(), nominal, shown(p.value), change, width, note]
}

/// The worst readings, three of them.
fn worst(readings: &[WorstReading]) -> String {
    let shown = |worst: &WorstReading| {
        let error = match (worst.error, worst.orientation_error_deg) {
            (Some(error), _) => format!("{error:.4} mm"),
            (None, Some(error)) => format!("{error:.4} deg"),
            (None, None) => format!("{:.1} sigma", worst.sigmas),
        };
        let of = worst.target.as_ref().map_or(String::new(), |target| format!(", {target}"));
        format!("worst reading: {}, pose {}, {}{of}: {error}\n", worst.at, worst.pose, worst.marker)
    };
    readings.iter().take(3).map(shown).collect()
}

/// The note on a parameter that moves no reading.
fn any_value(p: &ParameterEstimate) -> String {
    let moves = format!("moves no reading by more than {:.0e} mm", p.moves.unwrap_or_default());
    match p.least_stiffness {
        Some((least, unit)) => format!("{moves}: any stiffness above {least:.1e} {unit} fits"),
        None => format!("{moves}: any value near it fits"),
    }
}

/// The elastic parameters that were dropped and would show nothing if they were not.
fn insensitive(found: &Identification) -> String {
    let rows = found.parameters.iter().filter(|p| !p.identifiable && p.insensitive == Some(true));
    let shown: Vec<String> = rows.map(|p| format!("{} {:.0e} mm", p.name, p.moves.unwrap_or_default())).collect();
    if shown.is_empty() {
        return String::new();
    }
    format!("move no reading by more than: {}; any value as stiff or stiffer fits\n", shown.join(", "))
}

/// A table of springs that act as one.
fn spring_groups(groups: &[SpringGroup], screen: Screen) -> String {
    if groups.is_empty() {
        return String::new();
    }
    let rows = groups.iter().map(|group| {
        let how = if group.kind == Together::Series { "in series" } else { "side by side" };
        let note = if group.insensitive { "moves no reading: any stiffer fits" } else { "" };
        let [value, ci95] = [format!("{:.4e}", group.equivalent), format!("{:.1e}", group.ci95)];
        vec![group.members.join(", "), how.into(), value, ci95, group.unit.into(), note.into()]
    });
    let table = screen.table(&["members", "act", "as one of", "95 % +-", "unit", ""], rows);
    let mut out = format!("\nsprings that these readings see as one\n{table}");
    // Groups within each other, and members that count more or less than once.
    for group in groups.iter().filter(|group| group.formula.contains(['(', '*'])) {
        let sums = group.formula.matches('(').count();
        if sums > 1
            || group.kind == Together::Parallel
            || group.weights.iter().any(|weight| (weight - 1.0).abs() > 1e-3)
        {
            let _ = writeln!(out, "{:.4e} {} = {}", group.equivalent, group.unit, group.formula);
        }
    }
    out
}

/// The rms error step by step down to the noise, and the coordinates that are left, as bars.
fn steps(found: &Identification, screen: Screen) -> String {
    let unit = found.judged_unit();
    let row = |what: &str, rms: f64| (what.to_string(), rms, format!("{rms:.4} {unit}"));
    let [before, registration, after] = found.judged();
    let mut rows = vec![row("description as it is", before)];
    if found.is_registered() {
        rows.push(row("registration only", registration));
    }
    rows.push(row("calibrated", after));
    let is_stated = found.noise_sources.position == WeightSource::Stated;
    let name = if is_stated { "stated noise" } else { "noise" };
    rows.extend(found.noise.filter(|_| found.has_lengths()).map(|noise| row(name, noise)));
    let which = if found.is_checked() { "readings the fit did not see" } else { "fitted readings" };
    let mut out = format!("rms error, {which}\n{}", bars(&rows, screen));
    let drawn = histogram(&found.left, screen);
    if !drawn.is_empty() {
        let what = found.observes.residuals_named();
        let _ = write!(out, "\n{what} of all readings after calibration, number by error\n{drawn}");
    }
    out
}

/// What has moved since an earlier description: all parameters compared, what has moved first.
pub(super) fn moved(since: &Since, screen: Screen) -> String {
    let row = |p: &MovedParameter| {
        let shown = |value: f64| number(p.unit, value);
        let flag = if p.moved { "moved" } else { "" };
        let z = p.z.map_or(String::new(), |z| format!("{z:+.1}"));
        let chance = format!("{:.1e}", p.p);
        vec![p.name.clone(), p.unit.into(), shown(p.difference), shown(p.sigma), z, chance, flag.into()]
    };
    let mut all: Vec<&MovedParameter> = since.parameters.iter().collect();
    all.sort_by_key(|p| !p.moved);
    let which = if since.moved.is_empty() { "nothing".into() } else { since.moved.join(", ") };
    let table =
        screen.table(&["parameter", "unit", "difference", "sigma", "z", "chance (Holm)", ""], all.into_iter().map(row));
    let mut out = format!(
        "\nmoved since {}: {which} (at most {:.0} % that anything is named that has not)\n{table}",
        since.description,
        100.0 * since.level
    );
    if !since.not_compared.is_empty() {
        let parts = distinct(since.not_compared.iter().map(|name| name.split('.').next().unwrap_or(name)));
        let _ = writeln!(out, "not compared, since {} does not state them: {}", since.description, parts.join(", "));
    }
    out
}

fn strongest_correlations(found: &Identification) -> Vec<String> {
    let names = &found.reduction.kept_parameters;
    let mut pairs: Vec<(f64, &String, &String)> = found
        .correlation
        .iter()
        .zip(names)
        .enumerate()
        .flat_map(|(i, (row, own))| row.iter().zip(names).take(i).map(move |(c, other)| (*c, other, own)))
        .filter(|(c, ..)| c.abs() > 0.9)
        .collect();
    pairs.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
    pairs.iter().take(5).map(|(c, one, other)| format!("{one} ~ {other} ({c:+.3})")).collect()
}

/// Ordinary and weighted least squares next to each other.
pub fn comparison(found: &SchemeComparison, screen: Screen) -> String {
    let mut out = String::from("ordinary (equal weights) and weighted least squares (noise by direction)\n\n");
    let (ols, wls) = (&found.ols, &found.wls);
    let [x, y, z] = ols.direction_noise.map(|s| s * 1e3);
    let _ = writeln!(out, "residual noise by direction: x {x:.1} um, y {y:.1} um, z {z:.1} um\n");
    let both = ols.parameters.iter().zip(&wls.parameters);
    let rows = both.filter_map(|(o, w)| {
        let shown = |value: f64| number(o.unit, value);
        let (o95, w95) = (o.ci95?, w.ci95?);
        Some(vec![o.name.clone(), o.unit.into(), shown(o.value), shown(o95), shown(w.value), shown(w95)])
    });
    out += &screen.table(&["parameter", "unit", "OLS", "+-", "WLS", "+-"], rows);
    out += &errors(
        &[
            ("check: OLS", &ols.residuals.check_after),
            ("check: WLS", &wls.residuals.check_after),
            ("fit: OLS", &ols.residuals.after),
            ("fit: WLS", &wls.residuals.after),
        ],
        screen,
    );
    out
}

/// Text of `residuals`.
pub fn residuals(found: &DescriptionResiduals, screen: Screen) -> String {
    let mut rows = vec![("all", &found.all), ("set fit", &found.fit), ("set check", &found.check)];
    rows.extend(found.markers.iter().map(|(name, errors)| (name.as_str(), errors)));
    let parts: Vec<_> = found.parts.iter().map(|of| (format!("{} {}", of.part, of.name), Some(of.errors))).collect();
    rows.extend(parts.iter().map(|(name, errors)| (name.as_str(), errors)));
    let mut out = match found.fitted.is_empty() {
        true => String::new(),
        false => format!(
            "unknown to the campaign, no part of the description, and fitted to these readings before they are compared ({}): {}\n\n",
            found.fitted.len(),
            owners(&found.fitted)
        ),
    };
    out += &errors(&rows, screen);
    out += &worst(&found.worst);
    if found.directions.len() > 1 {
        let axes = ["x", "y", "z"].iter().zip(&found.directions);
        let shown: Vec<String> = axes.map(|(axis, rms)| format!("{axis} {rms:.4} mm")).collect();
        let _ = writeln!(out, "rms by direction: {}", shown.join(", "));
    }
    if let Some(rms) = found.predicted_uncertainty {
        let _ = writeln!(
            out,
            "standard uncertainty of the predicted positions {rms:.4} mm rms, by the fit that the description states"
        );
    }
    out + &found.own_weight.of_readings() + "\n"
}

/// Names of parameters by what they belong to: `base@monday (x y z)`.
fn owners(names: &[String]) -> String {
    let mut owners: indexmap::IndexMap<&str, Vec<&str>> = indexmap::IndexMap::new();
    for name in names {
        let (owner, symbol) = name.rsplit_once('.').unwrap_or((name, ""));
        owners.entry(owner).or_default().push(symbol);
    }
    let shown = owners.into_iter().map(|(owner, symbols)| match symbols.iter().all(|symbol| symbol.is_empty()) {
        true => owner.to_string(),
        false => format!("{owner} ({})", symbols.join(" ")),
    });
    shown.collect::<Vec<_>>().join(", ")
}
