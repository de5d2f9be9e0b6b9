//! A diagnosis as text: finding, evidence, what to do. Lengths in mm.

use std::fmt::Write;

use super::identification::moved;
use super::plots::bars;
use super::table::Screen;
use crate::description::raw::RawAmount;
use crate::diagnosis::{
    Autocorrelation, CauseParameter, Curve, EffectAtSite, Excluded, FewAngles, Level, Stability, Verdict,
};
use crate::model::Family;
use crate::results::{Cause, Diagnosis, Location, NextPose, NoiseFrom, Refitted, Rejected, ShownNoise, WeightSource};

/// Most outliers listed.
const OUTLIERS: usize = 20;
/// Most sites of the gap listed.
const SITES: usize = 8;
/// Most rejected hypotheses listed.
const REJECTED: usize = 6;

/// Text of `diagnose`.
pub fn diagnosis(found: &Diagnosis, screen: Screen) -> String {
    let mut out = format!("{}\n\n{}\n\n", found.campaign, finding(found));
    let of_one = found.causes.chunk_by(is_of_one).flat_map(|own| own.iter().map(move |one| (one, own)));
    for (k, (one, own)) in of_one.enumerate() {
        out += &cause(k + 1, one, own);
    }
    if !found.causes.is_empty() {
        let row = |what: String, rms: f64| (what, rms, format!("{rms:.4} mm"));
        let first = if found.gap.without_outliers.is_some() { "calibrated, with the outliers" } else { "calibrated" };
        let mut rows = vec![row(first.into(), found.gap.rms)];
        rows.extend(found.causes.iter().map(|c| row(format!("+ {}", short(c)), c.rms_after)));
        rows.push(row("noise".into(), found.gap.noise));
        let _ = writeln!(out, "rms error, unseen readings\n{}", bars(&rows, screen));
    }
    if !found.outliers.is_empty() {
        let more = found.outliers_at.len().saturating_sub(OUTLIERS);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        let places: Vec<&str> = found.outliers_at.iter().take(OUTLIERS).map(String::as_str).collect();
        let _ = writeln!(out, "outliers, excluded: {}{more}\n", places.join(", "));
    }
    out += &location(&found.location, screen);
    if !found.structure.is_empty() {
        let one = |s: &Autocorrelation| format!("{} {:+.2} (p {:.3})", s.against, s.correlation, s.p);
        let all: Vec<String> = found.structure.iter().map(one).collect();
        let _ = writeln!(out, "residual autocorrelation between neighbours: {}", all.join(", "));
        if !found.causes.is_empty() && found.structure.iter().any(|own| own.p < STRUCTURED) {
            let _ = match &found.rest.allowed_for {
                None => writeln!(
                    out,
                    "what is left is not all noise: intervals of the amounts cover its scatter, not its shape"
                ),
                Some(site) => writeln!(
                    out,
                    "what is left is not all noise: intervals of the amounts allow for as much again of the curve at {site} that is left"
                ),
            };
        }
    }
    out += &open(found);
    out.push('\n');
    out += &found.since.as_ref().map_or(String::new(), |since| moved(since, screen));
    if !found.rejected.is_empty() {
        let _ = writeln!(out, "all readings, by degree of freedom: {:.4} mm with no effect", found.with_none);
        let row = |r: &Rejected| vec![r.effect.clone(), r.site.clone(), format!("{:.4}", r.rms_after), r.why.into()];
        let header = ["rejected", "at", "rms with it alone mm", "why"];
        out += &screen.table(&header, found.rejected.iter().take(REJECTED).map(row));
    }
    // The best pose of all for the first pair.
    out + &found.next_poses.first().map_or(String::new(), next)
}

/// The finding in a sentence or two.
pub fn finding(found: &Diagnosis) -> String {
    let gap = &found.gap;
    let (rms, noise) = (gap.rms, gap.noise);
    match found.verdict {
        Verdict::NoGap => format!(
            "No gap: calibration leaves {rms:.4} mm (rms, unseen readings), and noise alone gives {noise:.4} mm."
        ),
        Verdict::Undecided if found.noise.source == NoiseFrom::Leftover => format!(
            "Undecided: nothing in the catalogue takes a certain part of the {rms:.4} mm (rms) away that calibration leaves; the noise is \
             not known, so whether this is noise is undecided."
        ),
        Verdict::Undecided => format!(
            "Undecided: calibration leaves {rms:.4} mm (rms) and noise alone gives {noise:.4} mm, but these readings could not show a gap."
        ),
        Verdict::Unexplained => format!(
            "Unexplained: calibration leaves {rms:.4} mm where {} {noise:.4} mm, and none of the {} hypotheses explains it.",
            if found.noise.source == NoiseFrom::Leftover {
                "the noise is not known, the residuals by degree of freedom being"
            } else {
                "noise gives"
            },
            found.hypotheses
        ),
        Verdict::Explained | Verdict::PartlyExplained => {
            let named: Vec<String> = found.causes.chunk_by(is_of_one).map(|own| named(found, own)).collect();
            let (word, named) = (
                if found.verdict == Verdict::Explained { "Explained" } else { "Partly explained" },
                named.join(", then "),
            );
            let (after, unseen) = (found.after_all.rms, format!("(rms, unseen readings; noise {noise:.4} mm)"));
            // An outlier may be among the readings held out, or not: with them all readings are counted.
            // Outliers of which rotations alone are wrong leave lengths as they are.
            let shrinks = match gap.without_outliers.filter(|without| rms - without > UNSEEN * rms) {
                None => format!("The gap shrinks from {rms:.4} to {after:.4} mm {unseen}"),
                Some(without) if found.causes.len() > 1 => format!(
                    "The error of all readings shrinks from {rms:.4} mm to {without:.4} mm without the outliers, and the gap \
                     to {after:.4} mm {unseen}"
                ),
                Some(_) => format!(
                    "The error of all readings shrinks from {rms:.4} to {after:.4} mm without the outliers {unseen}"
                ),
            };
            let written = found.after_all.rms_of_robot.filter(|_| found.after_all.is_session_noticed());
            let written = written.map_or(String::new(), |written| {
                format!(" Without what belongs to the session, as `--apply` writes it, {written:.4} mm are left of these readings.")
            });
            format!("{word}: {named}. {shrinks}.{written}")
        }
    }
}

/// Whether two causes are the same law at two sites, neither tied with another.
fn is_of_one(a: &Cause, b: &Cause) -> bool {
    let is_alone = |cause: &Cause| cause.level == Level::Law && cause.indistinguishable_from.is_empty();
    a.effect == b.effect && is_alone(a) && is_alone(b)
}

/// Causes of one law by its name and their sites; of outliers, how many were set aside.
fn named(found: &Diagnosis, causes: &[Cause]) -> String {
    let count = found.outliers.len();
    match causes {
        [cause] if cause.family == Family::Gross => {
            format!("outliers ({count} reading{} excluded)", if count == 1 { "" } else { "s" })
        }
        [cause] => cause.claim.clone(),
        [others @ .., last] => {
            let sites: Vec<&str> = others.iter().map(|cause| cause.site.as_str()).collect();
            format!("{} at {} and {}", last.effect, sites.join(", "), last.site)
        }
        [] => String::new(),
    }
}

/// A cause in a few words, no more than is certain.
fn short(cause: &Cause) -> String {
    match cause.level {
        Level::Law => format!("{} at {}", cause.effect, cause.site),
        Level::Site => format!("something at {}", cause.site),
        Level::Family => cause.family.words().into(),
    }
}

/// A cause, `of_one` being those that are reported as one with it.
fn cause(number: usize, cause: &Cause, of_one: &[Cause]) -> String {
    let mut out = match cause.family {
        Family::Gross => format!("{number}. outliers at {}\n", cause.site),
        _ => format!("{number}. {}\n", cause.claim),
    };
    let (before, after, less) = (cause.rms_before, cause.rms_after, less(cause.shrinkage, cause.shrinkage_ci95));
    if cause.family != Family::Gross || cause.implies.is_empty() {
        // One of several joints may add nothing certain once the others are in.
        let is_part = cause.shrinkage_ci95[0].is_some_and(|low| low <= 0.0);
        let together = match of_one {
            [first, .., last] if is_part => {
                format!("; together with the others of this law {:.4} -> {:.4} mm", first.rms_before, last.rms_after)
            }
            _ => String::new(),
        };
        let _ = writeln!(out, "   evidence  {before:.4} -> {after:.4} mm, {less}{together}");
    }
    if let Some(Stability { family, site, law, .. }) = cause.stability {
        let shown = |share: f64| format!("{:.0} %", 100.0 * share);
        let law = if cause.level == Level::Law { format!(", law {}", shown(law)) } else { String::new() };
        let (family, site) = (shown(family), shown(site));
        let _ = writeln!(out, "   stability family {family}, site {site}{law} of half-samples choose it");
    }
    for implied in &cause.implies {
        let _ = writeln!(out, "   implies   {implied}");
    }
    if let Some(curve) = &cause.curve {
        let _ = writeln!(out, "   curve     {}", curve_text(curve));
    }
    for (component, curve) in cause.curves.iter().filter(|(_, curve)| curve.is_certain()) {
        let _ = writeln!(out, "   curve {component:<3} {}", curve_text(curve));
    }
    let _ = writeln!(out, "   pattern   {}", cause.signature);
    // The amounts of a curve are in it, as far as they are known.
    let is_in_curve = |p: &CauseParameter| cause.curve.is_some() && p.ci95.is_some();
    for p in cause.parameters.iter().filter(|p| cause.curves.is_empty() && !is_in_curve(p)) {
        let CauseParameter { name, unit, value, ci95 } = p;
        let width = ci95.filter(|_| name != "count").map_or(String::new(), |ci95| format!(" +- {ci95:.1e} {unit}"));
        let value = match value {
            RawAmount::Number(count) if name == "count" => format!("{count:.0}"),
            RawAmount::Number(value) if ci95.is_none() => with_unit(*value, unit),
            RawAmount::Number(value) => format!("{value:+.4e}"),
            RawAmount::Numbers(_) => continue,
            RawAmount::Name(word) => word.clone(),
        };
        let _ = writeln!(out, "   {name:<9} {value}{width}");
    }
    if !cause.indistinguishable_from.is_empty() {
        let named = |EffectAtSite { effect, site }: &EffectAtSite| format!("{effect} at {site}");
        let rivals: Vec<String> = cause.indistinguishable_from.iter().map(named).collect();
        let _ = match cause.level {
            Level::Law => writeln!(out, "   not distinguishable by these readings from: {}", rivals.join(", ")),
            _ => writeln!(out, "   nearest   {}", rivals.join(", ")),
        };
    }
    let _ = writeln!(out, "   to do     {}\n", cause.remedy);
    out
}

/// A nonlinear value, which no interval follows, with its unit where it has one.
fn with_unit(value: f64, unit: &str) -> String {
    let value = if (1e-2..1e5).contains(&value.abs()) { format!("{value:+.3}") } else { format!("{value:+.4e}") };
    if unit == "1" { value } else { format!("{value} {unit}").trim_end().into() }
}

/// Share of an error that does not show in whole per cents.
const UNSEEN: f64 = 0.005;

/// A shrinkage in words, with its interval: a cause by itself may leave more, until others are added.
fn less(shrinkage: f64, ci95: [Option<f64>; 2]) -> String {
    // Adding zero takes the sign of what rounds to none.
    let percent = |share: f64| (100.0 * share).round() + 0.0;
    let is_less = percent(shrinkage) >= 0.0;
    let shown = |share: f64| percent(if is_less { share } else { -share });
    let interval = match if is_less { ci95 } else { [ci95[1], ci95[0]] } {
        [Some(low), Some(high)] => format!(" ({} to {} %)", shown(low), shown(high)),
        _ => String::new(),
    };
    format!("{} % {}{interval}", shown(shrinkage), if is_less { "less" } else { "more" })
}

/// A free curve: amounts with their bands in a unit of this size, at what it follows.
fn curve_text(curve: &Curve) -> String {
    let (unit, size) = curve.shown_in();
    let degrees = curve.unit == "rad";
    let at = |x: f64| match curve.unit {
        "1" => format!("{x:.0}"),
        _ if degrees => format!("{:.0} deg", x.to_degrees()),
        unit => format!("{x:.3} {unit}"),
    };
    let one =
        |((x, amount), band): ((&f64, &f64), &f64)| format!("{}: {:+.3} +- {:.3}", at(*x), size * amount, size * band);
    let all: Vec<String> = curve.at.iter().zip(&curve.amount).zip(&curve.band).map(one).collect();
    let line = if curve.is_without_line { ", less a straight line that calibration can stand for" } else { "" };
    let whole = if curve.is_certain() { "" } else { "; certain as a whole, and at no single point" };
    format!("({unit}{line}) {}{whole}", all.join("; "))
}

/// What explained gaps leave above the noise is reported from this part of the noise on: a quarter of its variance. A judgement.
const SHOWN_REST: f64 = 0.5;
/// Probability of as much autocorrelation by chance below which something else than noise is left; that of a cause.
const STRUCTURED: f64 = 0.01;

/// What stays open, what was excluded, and what could not be tried.
fn open(found: &Diagnosis) -> String {
    let mut out = String::new();
    let rest = &found.rest;
    let is_open = matches!(found.verdict, Verdict::Unexplained | Verdict::PartlyExplained);
    let is_great = found.verdict == Verdict::Explained && rest.rms > SHOWN_REST * found.gap.noise;
    if is_open && rest.rms > 0.0 || is_great {
        let at = match (&rest.site, &rest.follows) {
            (Some(site), Some(follows)) => format!("most of it at {site}, going with {follows}"),
            _ => "no free curve at one site explains most of it".into(),
        };
        let _ = writeln!(out, "open: {:.4} mm above the noise (root of the difference of squares); {at}", rest.rms);
    }
    if let Some(few) = &rest.few_angles {
        let FewAngles { site, variable, at_deg, half_width_deg, amount_deg, share } = few;
        let _ = writeln!(
            out,
            "open at a few angles: {:.0} % of the residual variance above the noise lies at {site} where {variable} is within {at_deg:.0} +- \
             {half_width_deg:.0} deg ({amount_deg:+.3} deg at most): look at teeth and bearing rings there, and measure more of these angles",
            100.0 * share
        );
    }
    for Excluded { effect, site, by } in &found.excluded {
        let _ = writeln!(out, "excluded: {effect} at {site}: {by}");
    }
    if !found.not_tried.is_empty() {
        let all: Vec<String> = found.not_tried.iter().map(|one| format!("{} ({})", one.effect, one.needs)).collect();
        let _ = writeln!(out, "not tried, for what is missing: {}", all.join("; "));
    }
    if let Some(ShownNoise { value, source }) = found.noise.instrument {
        let by = source.shown_by().unwrap_or("other readings");
        let _ = writeln!(
            out,
            "noise of the instrument alone {value:.4} mm (rms of a reading, from {by}); what readings of one configuration share is in addition"
        );
    }
    if found.noise.source == NoiseFrom::Leftover {
        out += "noise not known: the model's own leftover stands for it, which cannot show that nothing is left\n";
    }
    if found.noise.orientation == Some(WeightSource::Residuals) {
        out += "noise of orientations not stated: estimated from their residuals\n";
    }
    if let Some([some, all]) = found.drawn_from {
        let _ =
            writeln!(out, "{some} of {all} configurations were drawn for it: all of them would take too much memory");
    }
    let Refitted { effects, parameters } = &found.refitted;
    if !parameters.is_empty() {
        let names = if effects.is_empty() { "base and tool alone".into() } else { effects.join(", ") };
        let _ = writeln!(out, "refitted with each hypothesis: {names} ({} parameters)", parameters.len());
    }
    out + &found.own_weight.of_readings() + "\n"
}

fn location(found: &Location, screen: Screen) -> String {
    let mut out = String::from("where the gap lies\n");
    if found.sites.is_empty() {
        out += "no error at a single site explains it\n";
    } else {
        let rows = found.sites.iter().take(SITES).map(|s| {
            let shown = |v: f64| format!("{:.0}", 100.0 * v);
            vec![s.site.clone(), shown(s.share), shown(s.ci95[0]), shown(s.ci95[1])]
        });
        out += &screen.table(&["a free error at", "could carry %", "95 % from", "to"], rows);
    }
    for region in &found.conditions {
        let _ = writeln!(out, "{:.4} mm where {}, {:.4} mm elsewhere", region.rms, region.when, region.elsewhere);
    }
    if let Some(excess) = &found.yielding {
        let shown = |v: f64| format!("{:.1} % {}", 100.0 * v.abs(), if v < 0.0 { "less" } else { "more" });
        let (inside, outside) = (shown(excess.excess), shown(excess.elsewhere));
        let _ = writeln!(out, "the robot deflects {inside} than predicted where {}, {outside} elsewhere", excess.when);
    }
    let d = found.directions;
    let _ = writeln!(out, "all readings, by direction: x {:.4}, y {:.4}, z {:.4} mm", d.x, d.y, d.z);
    out
}

fn next(pose: &NextPose) -> String {
    let [one, other] = &pose.separates;
    if pose.sigmas < 1.0 {
        return format!("\nno configuration within the limits separates {one} and {other} by more than the noise\n");
    }
    format!(
        "\nto distinguish {one} and {other}, measure where they differ by {:.3} mm ({:.0} sigma): see next_poses in --format json\n",
        pose.apart, pose.sigmas
    )
}
