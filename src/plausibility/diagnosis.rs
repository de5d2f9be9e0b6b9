//! What is to be said of a diagnosis before its answer.

use super::amount::{few_held_out, too_little};
use super::checks::judge_result;
use super::common_factor;
use super::deflections::show_the_springs;
use super::evidence::{Evidence, Limits};
use super::hypothesis::total_length;
use super::shown::mm;
use super::springs::is_too_soft;
use super::stated_noise::is_above_noise;
use super::step::OF_MARKER;
use crate::description::campaign::{Campaign, Reading};
use crate::description::resolve::heaviest;
use crate::diagnosis::{Cause, Diagnosis, Level, NoiseSource, Verdict};
use crate::diagnostic::{Code, Diagnostic, Severity};
use crate::effects::Family;
use crate::estimation::{CHECK, Calibration, SEED, Settings, calibrate, split};
use crate::math::quantiles::f_tail;
use crate::model::{EffectEntry, EffectParameter, Model};
use crate::observation::Purpose;
use crate::parameter::Slot;

/// Doubts about a diagnosis of a campaign: about the calibration that it starts from, and about what its readings can show.
pub fn doubts(model: &Model, campaign: &Campaign, found: &Diagnosis, limits: &Limits) -> Vec<Diagnostic> {
    let pulled = found.is_pulled.then(|| {
        Diagnostic::warning(
            "calibration with the readings alone does not converge: the tolerances of the description pull it",
        )
        .remedy("measure configurations that differ more, or hold base or tool if their place is known")
        .code(Code::WeakDirection)
    });
    // A diagnosis calibrates without angles and torques read alone, and without outliers.
    let fitted = campaign.select(|_, of| of.observes.length_rows() > 0 && !found.outliers.contains(&of.row));
    let calibration =
        calibration_of(found, &fitted).map(|of| judge_result(&Evidence::with(model, &fitted, of), limits));
    let held_out = calibration_of(found, &fitted).map(|of| {
        let is_held_out = |index: usize| of.holds_out(index);
        fitted.select(|index, _| is_held_out(index)).amount()
    });
    // What is too little is judged by the verdict's own limits.
    // What calibration leaves above the noise is the gap itself, of which the answer speaks where causes explain it.
    let is_explained = found.verdict == Verdict::Explained;
    let most = if is_explained { limits.noise_wrong } else { limits.noise[1] };
    let ratio = |diagnostic: &Diagnostic| diagnostic.figures.get("ratio").copied();
    let is_gap = |diagnostic: &Diagnostic| {
        let is_below = ratio(diagnostic).is_some_and(|ratio| ratio < most);
        is_above_noise(diagnostic) && is_below
    };
    let judged = || calibration.iter().flatten();
    // Constants that take up what load moves are far off without its springs, and not with them.
    let are_held = judged().any(|diagnostic| diagnostic.code == Code::SpringsHeld);
    let is_of_springs = is_explained && has_springs(found) && are_held;
    let weaker = |diagnostic: Diagnostic| match diagnostic.code {
        Code::MovedFar if are_held => Diagnostic { severity: Severity::Warning, ..diagnostic },
        Code::NoiseUnlikeStated if is_above_noise(&diagnostic) => diagnostic.remedy(OPEN),
        _ => diagnostic,
    };
    let is_explained = |diagnostic: &Diagnostic| match diagnostic.code {
        // Constants had taken up what the causes are, and do not with them.
        Code::UnlikeDescription | Code::WorseThanRegistered => is_explained,
        Code::MovedFar | Code::SpringsHeld => is_of_springs,
        _ => false,
    };
    // Readings after a marker slipped are far from those before.
    let is_slip = |diagnostic: &Diagnostic| diagnostic.code == Code::OutlyingReadings && has_slipped(found);
    let about_figures = |diagnostic: &Diagnostic| {
        let is_shown = diagnostic.code.is_about_figures() || diagnostic.code == Code::DependentReadings;
        let is_own = is_shown && diagnostic.code != Code::TooLittleData;
        let is_own = is_own && !(diagnostic.code == Code::MovedMidway && is_named(diagnostic, found));
        is_own && !is_gap(diagnostic) && !is_explained(diagnostic) && !is_slip(diagnostic)
    };
    let mut all: Vec<Diagnostic> = judged().filter(|own| about_figures(own)).cloned().map(weaker).collect();
    let (amount, parameters) = &found.evidence;
    let little = too_little(amount, *parameters, limits).or_else(|| {
        (found.verdict == Verdict::Undecided && found.hypotheses == 0).then(|| {
            Diagnostic::warning("no hypothesis of the catalogue could have shown in these readings")
                .code(Code::TooLittleData)
                .remedy(
                    "measure what effects show in: loads, other configurations, sides of approach, times, temperatures",
                )
        })
    });
    let nothing_found = matches!(found.verdict, Verdict::NoGap | Verdict::Undecided);
    let of_springs = || {
        let of = calibration_of(found, &fitted).filter(|_| nothing_found)?;
        show_the_springs(&Evidence::with(model, &fitted, of), limits).pop()
    };
    all.extend(little.or_else(|| undetermined(found, limits)).or_else(of_springs));
    all.extend(held_out.and_then(|amount| few_held_out(&amount)));
    all.extend(springs_held(model, campaign, found, limits));
    if !all.iter().any(|diagnostic| diagnostic.code == Code::WrongUnits) {
        all.extend(common_factor::of_causes(model, campaign, found, limits));
    }
    all.extend(refused_as_calibration(model, campaign, found, limits));
    all.extend(
        found.causes.iter().flat_map(|cause| &cause.entries).filter_map(|entry| impossible(model, entry, limits)),
    );
    all.extend(pulled);
    if !all.iter().any(|diagnostic| diagnostic.code == Code::NoiseUnlikeStated) {
        all.extend(unlike_noise(found, limits));
    }
    // What is doubted already is not written, and another calibration of all readings would not change that.
    // Readings that are far off may all have been set aside.
    let is_doubted = |known: &Diagnostic| known.code.forbids_saving() && known.code != Code::OutlyingReadings;
    if !all.iter().any(is_doubted) {
        for diagnostic in forbidden_to_identify(model, campaign, found, limits) {
            if all.iter().all(|known| known.code != diagnostic.code) {
                all.push(diagnostic);
            }
        }
    }
    all
}

/// What is said where calibration leaves nothing but noise of the readings that it fitted, and far more of others.
fn undetermined(found: &Diagnosis, limits: &Limits) -> Option<Diagnostic> {
    let [_, most] = limits.noise;
    let is_far = found.gap.rms > most * found.gap.noise && found.noise_source != NoiseSource::Residual;
    (found.verdict == Verdict::Undecided && is_far).then(|| {
        let message = format!(
            "readings that were not fitted are {} mm off, where their noise is {} mm and no more is left of those that were: these are too few to \
             determine what is fitted",
            mm(found.gap.rms),
            mm(found.gap.noise)
        );
        let remedy = "measure more configurations that differ (`plan` chooses them)";
        Diagnostic::warning(message).code(Code::TooLittleData).remedy(remedy)
    })
}

/// What to do about residuals far above the stated noise that causes do not explain.
const OPEN: &str = "the answer says what stays open, and where it lies; or state the noise under `instrument:` in the campaign's units";

/// The calibration that a diagnosis starts from, where it is of these readings.
fn calibration_of<'f>(found: &'f Diagnosis, fitted: &Campaign) -> Option<&'f Calibration> {
    found.calibration.as_ref().filter(|of| of.held_out.len() == fitted.readings.len())
}

/// Whether a gap is so great that the stated noise is doubted, where nothing was calibrated that shows it, or what causes leave so
/// little.
fn unlike_noise(found: &Diagnosis, limits: &Limits) -> Option<Diagnostic> {
    if found.noise_source != NoiseSource::Stated {
        return None;
    }
    let [before, after] = [found.gap.rms, found.rms_after].map(|rms| rms / found.gap.noise);
    let least = limits.noise[0];
    let (message, ratio) = if found.calibration.is_none() && before > limits.noise_wrong {
        (
            format!(
                "the error is {before:.0} times the stated noise: this may not be the robot, or the load, of the description"
            ),
            before,
        )
    } else if after < least {
        (
            format!("residuals are {after:.2} times the stated noise: no instrument is that much better than stated"),
            after,
        )
    } else {
        return None;
    };
    let diagnostic = Diagnostic::warning(message).code(Code::NoiseUnlikeStated).figure("ratio", ratio);
    Some(diagnostic.remedy("state the noise under `instrument: {sigma: ..}`, in the campaign's units; look at signs and order of columns, loads included"))
}

/// Whether a cause goes with time: it is itself the step or drift that calibration leaves. One marker of several is a site of its own.
fn is_named(step: &Diagnostic, found: &Diagnosis) -> bool {
    let is_there = |entry: &EffectEntry| match step.figures.get(OF_MARKER) {
        Some(marker) => entry.site.marker.is_some_and(|own| own as f64 == *marker),
        None => entry.site.marker.is_none(),
    };
    let of_time = |cause: &&Cause| cause.family == Family::Time;
    found.causes.iter().filter(of_time).any(|cause| cause.entries.iter().any(is_there))
}

/// Whether a compliance is named with its law.
fn has_springs(found: &Diagnosis) -> bool {
    found.causes.iter().any(|cause| cause.family == Family::Elastic && cause.level == Level::Law)
}

/// Whether a marker is named as having moved on its body.
fn has_slipped(found: &Diagnosis) -> bool {
    found.causes.iter().flat_map(|cause| &cause.entries).any(|entry| entry.site.marker.is_some())
}

/// Where causes leave a gap, or readings were set aside and are not named as a cause: what forbids `identify` to write its calibration of
/// all readings, those that the diagnosis set aside included.
/// Outliers may hide a step, and a calibration that the tolerances pull is not judged.
fn forbidden_to_identify(model: &Model, campaign: &Campaign, found: &Diagnosis, limits: &Limits) -> Vec<Diagnostic> {
    let names_outliers = found.causes.iter().any(|cause| cause.family == Family::Gross);
    let is_open = matches!(found.verdict, Verdict::Unexplained | Verdict::PartlyExplained)
        || !found.outliers.is_empty() && !names_outliers;
    let fits_as_identify = campaign.purpose() == Purpose::Geometry || !campaign.calibrate.is_empty();
    if !is_open || !fits_as_identify {
        return Vec::new();
    }
    let held_out = split(campaign, CHECK, SEED);
    let asked = Settings { second_order: false, ..Settings::default() };
    let Ok(calibrated) = calibrate(model, campaign, &held_out, &asked, &mut |_| {}) else { return Vec::new() };
    let forbids = |diagnostic: &Diagnostic| match diagnostic.code {
        Code::MovedMidway => !is_named(diagnostic, found),
        Code::OutlyingReadings if has_slipped(found) => false,
        // Of the amount the verdict has its own limits.
        Code::TooLittleData => false,
        code => code.forbids_saving(),
    };
    let judged = judge_result(&Evidence::with(model, campaign, &calibrated), limits);
    let weaker = |diagnostic: Diagnostic| Diagnostic { severity: Severity::Warning, ..diagnostic };
    judged.into_iter().filter(forbids).map(weaker).collect()
}

/// Share of a declared compliance below which nothing of it is left: it ends at the bound beyond which it would be negative.
const RIGID: f64 = 1e-3;

/// An amount of a cause that no machine has: what is negative there or rigid against the description, longer than the robot,
/// turned further than any part is mounted off, or heavier than the robot.
fn impossible(model: &Model, entry: &EffectEntry, limits: &Limits) -> Option<Diagnostic> {
    let own = entry.to_string();
    let remedy = "the cause stands in for something else: look at signs (sides of approach, loads, gravity), masses and units of description \
                  and campaign";
    let reported = |message: String| Diagnostic::warning(message).code(Code::Implausible).remedy(remedy);
    if let Some(negative) = entry.doubt(model).filter(|_| !entry.amounts.is_empty()) {
        return Some(reported(format!("{own}: {}", negative.message)));
    }
    let size = total_length(model);
    let parameters = entry.effect.parameters(model, &entry.site, &entry.nonlinear);
    let rigid = parameters.iter().find_map(|parameter| {
        let constant = &model.registry[model.registry.slot(&parameter.symbol)?];
        let (declared, amount) = (constant.nominal, *entry.amounts.get(&parameter.symbol)?);
        let is_compliance = constant.kind.is_compliance();
        let is_none = is_compliance && declared > 0.0 && declared + amount <= RIGID * declared;
        is_none.then_some(&parameter.symbol)
    });
    if let Some(symbol) = rigid {
        return Some(reported(format!("{own}: `{symbol}` comes out rigid, and readings contradict what is declared")));
    }
    let soft = parameters.iter().find_map(|parameter| {
        let constant = &model.registry[model.registry.slot(&parameter.symbol)?];
        let compliance = constant.nominal + *entry.amounts.get(&parameter.symbol)?;
        is_too_soft(model, constant.kind, compliance, limits).then(|| {
            let (symbol, unit) = (&parameter.symbol, constant.kind.unit());
            reported(format!("{own}: `{symbol}` is {compliance:.2e} {unit}, softer than any arm of this size"))
        })
    });
    if soft.is_some() {
        return soft;
    }
    if let Some((symbol, unit, amount)) = parameters.iter().find_map(|parameter| too_warm(entry, parameter)) {
        return Some(reported(format!(
            "{own}: `{symbol}` is {amount:.2e} {unit}, and metals grow by 1.2e-5 to 2.4e-5 of their length with each K"
        )));
    }
    parameters.iter().find_map(|parameter| {
        let amount = *entry.amounts.get(&parameter.symbol)?;
        let most = match parameter.unit {
            "m" => size,
            "rad" => limits.turned,
            "kg" => heaviest(size),
            _ => return None,
        };
        let is_much = most > 0.0 && amount.abs() > most;
        is_much.then(|| {
            let (symbol, unit) = (&parameter.symbol, parameter.unit);
            reported(format!(
                "{own}: `{symbol}` is {amount:.3e} {unit}, in a robot whose lengths add up to {size:.2} m"
            ))
        })
    })
}

/// Greatest expansion, 1/K: ten times that of aluminium, as where the link warms ten times as much as the thermometer shows. And greatest growth of
/// a length that warms up: that of aluminium by 100 K. Judgements.
const MOST_EXPANSION: f64 = 2.4e-4;
const MOST_GROWTH: f64 = 2.4e-3;

/// A parameter by which a link grows more than any metal does: symbol, unit and amount.
fn too_warm<'p>(entry: &EffectEntry, parameter: &'p EffectParameter) -> Option<(&'p str, &'static str, f64)> {
    let amount = *entry.amounts.get(&parameter.symbol)?;
    let most = match (entry.effect.family(&entry.nonlinear), parameter.unit) {
        (Family::Temperature, "1/K") => MOST_EXPANSION,
        (Family::Time, "1") => MOST_GROWTH,
        _ => return None,
    };
    (amount.abs() > most).then_some((&parameter.symbol, parameter.unit, amount))
}

/// Why `identify` refuses the campaign where it calibrates the geometry that the diagnosis held: what bends constants to where no
/// robot has them bends causes as well.
fn refused_as_calibration(
    model: &Model,
    campaign: &Campaign,
    found: &Diagnosis,
    limits: &Limits,
) -> Option<Diagnostic> {
    let diagnosed = found.calibration.as_ref()?;
    if campaign.purpose() != Purpose::Geometry || !campaign.calibrate.is_empty() || found.causes.is_empty() {
        return None;
    }
    let asked = Settings { second_order: false, ..Settings::default() };
    let calibrated = calibrate(model, campaign, &diagnosed.held_out, &asked, &mut |_| {}).ok()?;
    let judged = judge_result(&Evidence::with(model, campaign, &calibrated), limits);
    let refuses = |diagnostic: &&Diagnostic| diagnostic.is_error() && diagnostic.code.is_plausibility();
    let why = judged.iter().find(refuses)?;
    let remedy = why.remedy.clone().unwrap_or_default();
    let message = format!(
        "`identify` refuses this campaign ({}): {}; the causes below may stand in for what is wrong there",
        why.code.name(),
        why.message
    );
    Some(Diagnostic::warning(message).code(Code::Implausible).remedy(remedy))
}

/// Springs that the description declares to be identified, and that the campaign does not name under `calibrate:`, where fitting
/// them too leaves nothing but noise: the causes found may stand in for them.
fn springs_held(model: &Model, campaign: &Campaign, found: &Diagnosis, limits: &Limits) -> Option<Diagnostic> {
    let fitted = found.calibration.as_ref().map_or(&[][..], |of| &of.slots);
    let is_held = |slot: &Slot| !fitted.contains(slot);
    let held: Vec<Slot> = model.elastic_slots().into_iter().filter(is_held).collect();
    if !campaign.is_difference() || campaign.sigma.is_none() || found.causes.is_empty() || held.is_empty() {
        return None;
    }
    let only = Some([&model.elastic_slots()[..], fitted].concat());
    let asked = Settings { only, second_order: false, ..Settings::default() };
    let is_out = |reading: &Reading| reading.check == Some(true) || found.outliers.contains(&reading.row);
    let held_out: Vec<bool> = match &found.calibration {
        Some(of) => of.held_out.clone(),
        None => campaign.readings.iter().map(is_out).collect(),
    };
    let fitted = calibrate(model, campaign, &held_out, &asked, &mut |_| {}).ok().filter(Calibration::converged)?;
    // As far above one as noise alone comes once in a thousand times.
    let freedom = fitted.degrees_of_freedom.max(1.0);
    let is_noise = f_tail(fitted.noise_ratio.powi(2), freedom, 1e9) > limits.chance;
    let names: Vec<&str> = held.iter().map(|&slot| model.registry[slot].name.as_str()).collect();
    is_noise.then(|| {
        let message = format!(
            "with the springs that the description declares to be identified fitted as well ({}) nothing but noise is left, as `identify` \
             finds: the causes below may stand in for them",
            names.join(", ")
        );
        Diagnostic::warning(message)
            .code(Code::SpringsHeld)
            .remedy("name what is re-fitted in the campaign: `calibrate: [joint-compliance, bearing-compliance, ..]`")
            .figure("noise_ratio", fitted.noise_ratio)
    })
}
