//! Calibrated values against declared ones.

use super::evidence::{Evidence, Limits};
use super::hypothesis::own_slots;
use super::shown::mm;
use crate::diagnostic::{Code, Diagnostic};
use crate::estimation::Estimate;
use crate::math::median;
use crate::parameter::{Group, Kind, Parameter, Slot};

/// Most parameters named in one message.
const NAMED: usize = 4;

/// An identified constant of the robot.
struct Moved<'a> {
    estimate: &'a Estimate,
    parameter: &'a Parameter,
    /// Column among the candidates.
    column: usize,
    /// Half widths of its 95 % interval by which it moved.
    widths: f64,
    /// One standard deviation of where it may be by the tolerances: its own, and those of the constants that are merged into it.
    tolerance: f64,
    /// The same without merged springs: what readings hardly show of one is merged by factors of metres, which a length need not move by.
    of_geometry: f64,
    /// What the other lengths add for which it stands, of parallel axes, m.
    merged: f64,
}

fn moved<'a>(evidence: &'a Evidence) -> impl Iterator<Item = Moved<'a>> {
    let registry = &evidence.model.registry;
    evidence.found.into_iter().flat_map(move |found| {
        let all = found.estimates.iter().enumerate();
        all.filter_map(move |(column, estimate)| {
            let parameter = &registry[estimate.slot];
            let width = estimate.ci95.filter(|width| width.is_finite())?;
            let widths = (estimate.value - estimate.nominal).abs() / width.max(f64::MIN_POSITIVE);
            let merged = found.identifiability.combinations.iter().filter(|(kept, _)| *kept == column);
            let of_merged = |(dropped, factor): &(usize, f64)| {
                let own = found.slots.get(*dropped).map(|&slot| &registry[slot]);
                let variance =
                    |own: &Parameter| (factor * if own.tolerance.is_finite() { own.tolerance } else { 0.0 }).powi(2);
                let is_spring = own.is_some_and(|own| own.group == Group::Elastic);
                (is_spring, own.map_or(0.0, variance))
            };
            let length_of = |(dropped, factor): &(usize, f64)| {
                let own = found.slots.get(*dropped).map(|&slot| &registry[slot]);
                own.filter(|own| own.kind == Kind::Length && own.group == Group::Geometry)
                    .map(|own| factor * own.nominal)
            };
            let lengths = merged.clone().flat_map(|(_, terms)| terms).filter_map(length_of).sum();
            let merged: Vec<(bool, f64)> = merged.flat_map(|(_, terms)| terms).map(of_merged).collect();
            let with = |counts: &dyn Fn(bool) -> bool| {
                let counted = merged.iter().filter(|(is_spring, _)| counts(*is_spring)).map(|(_, variance)| variance);
                (parameter.tolerance.powi(2) + counted.sum::<f64>()).sqrt()
            };
            let (tolerance, of_geometry) = (with(&|_| true), with(&|is_spring| !is_spring));
            let own = Moved { estimate, parameter, column, widths, tolerance, of_geometry, merged: lengths };
            (parameter.group == Group::Geometry).then_some(own)
        })
    })
}

pub(super) fn near_their_description(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let mut far: Vec<(f64, String, bool)> = moved(evidence)
        .filter_map(|Moved { estimate, parameter, widths, tolerance, of_geometry, .. }| {
            let by = (estimate.value - estimate.nominal).abs();
            let tolerances = by / of_geometry;
            let is_hopeless = match parameter.kind {
                Kind::Angle => by > limits.turned,
                _ => by / tolerance > limits.moved_hopelessly,
            };
            let is_far = widths > limits.significant && (tolerances > limits.moved || is_hopeless);
            is_far.then(|| (tolerances, described(estimate, parameter), is_hopeless))
        })
        .collect();
    far.sort_by(|a, b| b.0.total_cmp(&a.0));
    let Some((tolerances, ..)) = far.first() else { return Vec::new() };
    let named: Vec<&str> = far.iter().take(NAMED).map(|(_, shown, _)| shown.as_str()).collect();
    let more = if far.len() > NAMED { format!(", and {} more", far.len() - NAMED) } else { String::new() };
    // A turn is far whatever the tolerance.
    let by_tolerances = match *tolerances > limits.moved {
        true => format!(" (up to {tolerances:.0} times its tolerance)"),
        false => String::new(),
    };
    let message =
        format!("calibrated constants are far from the description{by_tolerances}: {}{more}", named.join(", "));
    let is_hopeless = far.iter().any(|(.., is_hopeless)| *is_hopeless);
    let diagnostic = if is_hopeless { Diagnostic::error(message) } else { Diagnostic::warning(message) };
    let remedy = "look at zeros, signs and lengths of the description there; if its numbers are guesses, say so: \
                  `calibration: {tolerances: {..}}`";
    vec![
        diagnostic
            .code(Code::MovedFar)
            .remedy(remedy)
            .figure("tolerances", *tolerances)
            .figure("parameters", far.len() as f64),
    ]
}

/// What a parameter was and is.
fn described(estimate: &Estimate, parameter: &Parameter) -> String {
    let name = &parameter.name;
    match parameter.kind {
        Kind::Angle => {
            let [from, to] = [estimate.nominal, estimate.value].map(f64::to_degrees);
            format!("`{name}` {from:.2} -> {to:.2} deg")
        }
        Kind::Length => format!("`{name}` {} -> {} mm", mm(estimate.nominal), mm(estimate.value)),
        kind => format!("`{name}` {:.3e} -> {:.3e} {}", estimate.nominal, estimate.value, kind.unit()),
    }
}

/// Least squares of all calibrated lengths against the declared ones: a factor that is not one is a scale or a unit.
pub(super) fn of_the_same_size(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let Some(found) = evidence.found else { return Vec::new() };
    let is_own = own_slots(evidence.model, Kind::Length);
    let lengths: Vec<Moved> = moved(evidence)
        .filter(|one| one.parameter.kind == Kind::Length && is_own.contains(&one.estimate.slot))
        .collect();
    // Of parallel axes one length stands for several.
    let nominal = |one: &Moved| one.estimate.nominal + one.merged;
    let value = |one: &Moved| one.estimate.value + one.merged;
    let count = lengths.iter().filter(|one| nominal(one).abs() > limits.moved * one.parameter.tolerance).count();
    let squares: f64 = lengths.iter().map(|one| nominal(one).powi(2)).sum();
    if count < 2 || squares <= 0.0 {
        return Vec::new();
    }
    let product: f64 = lengths.iter().map(|one| value(one) * nominal(one)).sum();
    let factor = product / squares;
    let spread: f64 = lengths.iter().map(|one| (nominal(one) * one.tolerance).powi(2)).sum();
    // A factor is of all of them: half as clear, it is still there without any one.
    let is_of_others = |one: &Moved| {
        let [nominal, value] = [nominal(one), value(one)];
        let others = squares - nominal.powi(2);
        let expected = (spread - (nominal * one.tolerance).powi(2)).max(0.0).sqrt() / others;
        ((product - value * nominal) / others - 1.0).abs() > 0.5 * limits.scale[0] * expected
    };
    if !lengths.iter().all(is_of_others) {
        return Vec::new();
    }
    // Lengths that the readings hardly tell apart are uncertain together.
    let place = |one: &Moved| found.identifiability.kept.iter().position(|&kept| kept == one.column);
    let parts: Vec<(usize, f64)> =
        lengths.iter().filter_map(|one| Some((place(one)?, nominal(one) * one.estimate.ci95.unwrap_or(0.0)))).collect();
    let pairs = parts.iter().flat_map(|a| parts.iter().map(move |b| (a, b)));
    let certain: f64 =
        pairs.map(|((i, a), (j, b))| a * b * found.correlation.get((*i, *j)).copied().unwrap_or(0.0)).sum();
    let [expected, width] = [spread, certain].map(|sum: f64| sum.max(0.0).sqrt() / squares);
    let off = (factor - 1.0).abs();
    if off <= limits.scale[0] * expected || off <= limits.significant * width {
        return Vec::new();
    }
    let message = format!(
        "the robot's lengths came out {factor:.3} times the declared ones, where its tolerances allow {:.2} %",
        100.0 * expected
    );
    let remedy = match evidence.campaign.readings.iter().all(|reading| reading.observes.touches()) {
        true => "look at `units:` of campaign and description, and at the known `distances:` between contacts",
        false => {
            "look at `units:` of campaign and description, and at the scale of the instrument (`estimate: {scale: true}`)"
        }
    };
    let is_hopeless = off > limits.scale[1] * expected;
    let diagnostic = if is_hopeless { Diagnostic::error(message) } else { Diagnostic::warning(message) };
    vec![diagnostic.code(Code::MovedFar).remedy(remedy).figure("factor", factor)]
}

/// Springs that came out tens of times softer or stiffer. Where all did, stiffness, loads or readings are in another unit; single
/// ones are declared wrong, or stand for something else.
pub(super) fn as_stiff_as_declared(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let Some(found) = evidence.found else { return Vec::new() };
    let softer = |estimate: &Estimate| {
        let parameter = &evidence.model.registry[estimate.slot];
        let is_certain = estimate.ci95.is_some_and(|width| width < 0.5 * estimate.value.abs());
        let is_sound = parameter.group == Group::Elastic && is_certain && !estimate.at_bound;
        let ratio =
            (is_sound && estimate.nominal > 0.0 && estimate.value > 0.0).then(|| estimate.value / estimate.nominal)?;
        match parameter.kind {
            Kind::LinearCompliance | Kind::RotationalCompliance => Some((parameter.name.as_str(), ratio.ln())),
            Kind::LinearStiffness | Kind::RotationalStiffness => Some((parameter.name.as_str(), -ratio.ln())),
            _ => None,
        }
    };
    let springs: Vec<(&str, f64)> = found.estimates.iter().filter_map(softer).collect();
    let count = springs.len();
    let Some(middle) = median(&mut springs.iter().map(|(_, softer)| *softer).collect::<Vec<f64>>()) else {
        return Vec::new();
    };
    let far = limits.stiffness_factor.ln();
    if middle.abs() < far {
        return single_springs(springs.into_iter().filter(|(_, softer)| softer.abs() >= far).collect())
            .into_iter()
            .collect();
    }
    let how = if middle > 0.0 { "softer" } else { "stiffer" };
    let message = format!(
        "springs came out {:.0} times {how} than declared (median of {count}): are stiffness, loads or readings in another unit?",
        middle.abs().exp()
    );
    let remedy = "state `stiffness`, `rotational_stiffness`, `force`, `torque` and `length` under `units:` as the files have them";
    vec![Diagnostic::error(message).code(Code::WrongUnits).remedy(remedy).figure("factor", middle.exp())]
}

/// Single springs that came out far from what is declared.
fn single_springs(mut far: Vec<(&str, f64)>) -> Option<Diagnostic> {
    far.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    let (_, most) = *far.first()?;
    let described = |(name, softer): &(&str, f64)| {
        format!("`{name}` {:.0} times {}", softer.abs().exp(), if *softer > 0.0 { "softer" } else { "stiffer" })
    };
    let named: Vec<String> = far.iter().take(NAMED).map(described).collect();
    let message = format!("springs came out far from the description: {}", named.join(", "));
    let remedy =
        "look at that spring's declared value and its unit; if it is right, something else gives way there: `diagnose`";
    Some(Diagnostic::warning(message).code(Code::MovedFar).remedy(remedy).figure("factor", most.abs().exp()))
}

/// Springs that ended rigid or free to any instrument although that contradicts what is declared for certain: those that readings do
/// not tell are held before.
pub(super) fn springs_within_their_range(evidence: &Evidence, _: &Limits) -> Vec<Diagnostic> {
    let Some(found) = evidence.found else { return Vec::new() };
    let registry = &evidence.model.registry;
    let is_end = |own: &&Estimate| {
        let parameter = &registry[own.slot];
        own.at_bound && parameter.group == Group::Elastic && !parameter.is_own_bound(own.value)
    };
    let named: Vec<String> = found
        .estimates
        .iter()
        .filter(is_end)
        .map(|own| {
            let parameter = &registry[own.slot];
            let is_compliance = parameter.kind.is_compliance();
            let is_rigid = is_compliance == (own.value < own.nominal);
            format!("`{}` {}", parameter.name, if is_rigid { "rigid" } else { "free" })
        })
        .collect();
    if named.is_empty() {
        return Vec::new();
    }
    let message = format!("springs ended at a limit: {}, and readings contradict what is declared", named.join(", "));
    let remedy =
        "look at signs and axes of loads, at gravity and masses; declare a joint rigid that is, or hold it (--hold)";
    vec![Diagnostic::warning(message).code(Code::Implausible).remedy(remedy)]
}

/// Springs whose rate was identified with their free length held: intervals, also those of the joints that they span, take the
/// length as exact.
pub(super) fn free_lengths(evidence: &Evidence, _: &Limits) -> Vec<Diagnostic> {
    let Some(found) = evidence.found else { return Vec::new() };
    let registry = &evidence.model.registry;
    let kept: Vec<Slot> = found.kept_slots();
    let springs = evidence.model.structure.springs.iter().filter(|spring| spring.spring.free_length.is_some());
    let held = springs.map(|spring| (spring.slots[0], spring.slots[1]));
    let held = held.filter(|(rate, length)| kept.contains(rate) && !found.slots.contains(length));
    held.map(|(rate, length)| {
        let [rate, name] = [rate, length].map(|slot| &registry[slot].name);
        let value = mm(registry[length].nominal);
        Diagnostic::warning(format!(
            "`{name}` is held at {value} mm: intervals of `{rate}` and of the joints that the spring spans take it as exact"
        ))
        .remedy(format!("if it is not known to a tenth of a millimetre or so, free it: `calibration: {{free: [{name}]}}`"))
    })
    .collect()
}

/// Calibrated errors against registered ones, on readings that were held out.
pub(super) fn better_than_registered(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let Some(found) = evidence.found else { return Vec::new() };
    let (before, after) = (&found.registration.check, &found.after.check);
    let ratio = |k: usize| after.distance[k] / before.distance[k];
    // The root mean square is what is shown; of mean and root mean square one wrong reading decides neither alone.
    let (shown, worse) = (ratio(1), ratio(0).min(ratio(1)));
    // Where the fit leaves more than the noise, its parameters take up what the description does not have, and are good for nothing
    // where they do not make unseen readings better.
    // What noise alone would leave is not known where none is stated.
    let is_open = evidence.campaign.sigma.is_none() || found.noise_ratio > limits.noise[1];
    let is_worse = if is_open { worse > limits.worse_open } else { shown > limits.worse[0] };
    if after.readings == 0 || !shown.is_finite() || !is_worse {
        return Vec::new();
    }
    let [from, to] = [before.distance[1], after.distance[1]].map(mm);
    let fits = match evidence.campaign.sigma {
        None => "it fits noise, or takes up what is held or not described",
        Some(_) if is_open => "what is fitted takes up what is held or not described",
        Some(_) => "it fits noise",
    };
    let message = format!("calibration makes readings that it did not see worse, from {from} to {to} mm: {fits}");
    let diagnostic = if worse > limits.worse[1] { Diagnostic::error(message) } else { Diagnostic::warning(message) };
    let held = if is_open { "free what is held and may differ (`calibrate:`, geometry first), " } else { "" };
    let register = if evidence.campaign.is_difference() { "" } else { ", or use `register`" };
    let remedy = format!(
        "{held}measure more configurations, hold parameters (`--hold`), let tolerances pull (`--prior`){register}"
    );
    vec![diagnostic.code(Code::WorseThanRegistered).remedy(remedy).figure("ratio", shown)]
}

/// Whether there are enough readings for what was fitted.
pub(super) fn enough_readings(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let Some(found) = evidence.found else { return Vec::new() };
    let fitted = found.fitted(evidence.campaign);
    // Constants that the noise hides count: the readings decide which of them are held.
    let (amount, kept) = (fitted.amount(), found.identifiability.rank);
    let held_out = evidence.campaign.select(|index, _| found.holds_out(index));
    let few = super::amount::few_held_out(&held_out.amount());
    super::amount::too_little(&amount, kept, limits).into_iter().chain(few).collect()
}
