//! The list of checks, and what is done with what they find.

use super::evidence::{Evidence, Limits};
use super::outlying::far_readings;
use super::{
    amount, another_robot, approach, beyond, common_factor, constraints, deflections, instrument, lengths_under_load,
    midway, nearer, numerics, other_joints, outlying, own_weight, parameters, payload, placement,
    places_and_deflections, points, readings, sessions, springs, stated_noise, torques, unfitted_springs,
};
use crate::description::campaign::Campaign;
use crate::diagnostic::{Code, Diagnostic, Diagnostics, Severity};
use crate::estimation::{RegistrationSettings, registered};
use crate::math::distinct;
use crate::model::Model;
use crate::parameter::Group;

/// One check. Those that look at a calibration find nothing where there is none.
pub struct Check {
    /// Codes of what it finds; the first where it says nothing else.
    pub codes: &'static [Code],
    /// Whether it looks at a calibration, not only at readings and description.
    pub of_result: bool,
    /// What it compares with what, and why.
    pub about: &'static str,
    /// What it finds.
    pub find: fn(&Evidence, &Limits) -> Vec<Diagnostic>,
}

/// Makes [`CHECKS`] of rows: what finds, with which codes, and what it compares.
macro_rules! checks {
    ($(of_result: $of_result:literal { $($find:path: [$($code:ident),*] $about:literal,)* })*) => {
        /// All checks, in the order in which they speak.
        pub const CHECKS: &[Check] = &[$($(
            Check { codes: &[$(Code::$code),*], of_result: $of_result, about: $about, find: $find },
        )*)*];
    };
}

checks! {
    of_result: false {
        readings::fit_the_description: [UnlikeDescription, WrongUnits, Misread, OutlyingReadings, Implausible]
            "registration leaves what tolerances and noise allow; else the files are read in other ways",
        deflections::follow_their_loads: [Misread, WrongUnits]
            "deflections follow their loads as springs of the description can: else they are mirrored, the loads reversed, or the joints misread",
        deflections::as_large_as_declared: [WrongUnits]
            "deflections are of the order of those of the declared springs",
        beyond::within_reason: [Doubtful]
            "stated noise and applied loads are such as instruments and arms have",
        stated_noise::alike: [WrongUnits]
            "the noise stated for one reading is not a thousandth of that of the others",
        points::apart: [Implausible]
            "no two points of the robot were read in one place",
        instrument::instrument: [ReferencesMoved, NoiseDisagrees]
            "fixed reflectors stand still, and scatter as the stated noise allows; so do distances of rigid markers",
        sessions::agree: [SessionsDiffer]
            "sessions and files share base and tool where the campaign says so",
        amount::of_each_joint: [WeakDirection]
            "each joint moved in some of the readings",
        approach::goes_with_the_moves: [Doubtful]
            "sides of approach are not the reverse of the moves that led to the configurations",
        springs::as_declared: [WrongUnits]
            "where loads or masses bend it, the declared springs hold the arm as well as those of arms of its size",
        torques::hold_the_masses: [WrongUnits, Misread]
            "measured torques of each joint are those that hold the described masses",
    }
    of_result: true {
        numerics::converged: [NotConverged]
            "the fit ended at a minimum: elsewhere values are only where it stopped",
        constraints::fit_the_contacts: [Misread]
            "contacts agree with the distances and angles that are known between what they touch",
        numerics::finite: [NotComputed]
            "all values and errors are finite: what is not was never computed",
        numerics::within_reach: [Implausible]
            "base, tool and markers stand within the reach of an instrument",
        instrument::scale: [WrongUnits]
            "an estimated scale is one that an instrument can have",
        numerics::weak_directions: [WeakDirection]
            "base and tool are determined: what was held of them is named",
        numerics::dependent: [DependentReadings]
            "readings of one configuration scatter about the model as much as configurations do: repeats average out only what they do not share",
        placement::as_placed: [Misread]
            "with the last joint negated, or base or tool estimated as well, calibration leaves what it does without: the joints count, and base and tool are, as the description says",
        nearer::as_described: [MovedFar, Misread, WrongUnits]
            "constants that end far from the description do not stand for files that are to be read in another way: none leaves as little with constants that stay near it",
        sessions::agree_calibrated: [SessionsDiffer]
            "with a base or a tool of its own for each session calibration leaves as much as without",
        another_robot::is_the_same: [SessionsDiffer]
            "each session by itself, calibrated with constants of its own, leaves as much as all together",
        other_joints::as_declared: [OtherJoints]
            "with the other column of each joint (commanded for recorded) calibration leaves as much",
        unfitted_springs::are_as_declared: [SpringsHeld]
            "with the springs that the description declares calibration leaves as much as without",
        own_weight::as_declared: [Misread]
            "with gravity in another direction, or masses or centres of the bodies exchanged, in another place or another unit, calibration leaves as much",
        payload::as_declared: [WrongUnits, Misread]
            "with the payload's mass or centre in another unit, its centre on the other side, or two payloads exchanged, calibration leaves as much",
        readings::describes_the_readings: [UnlikeDescription]
            "calibration explains most of what registration leaves, where that is more than tolerances allow",
        outlying::after: [OutlyingReadings, UnlikeDescription]
            "no reading is far from the fit to the others, and no quarter of them is",
        midway::stands_still: [MovedMidway]
            "what is left does not step at one row of the files",
        lengths_under_load::as_described: [UnlikeDescription]
            "with one length or angle of the description fitted too, springs leave as much of the deflections as without",
        deflections::show_the_springs: [TooLittleData]
            "of some fitted spring more is known than its own size",
        places_and_deflections::are_explained: [UnlikeDescription]
            "fitted springs leave less than half of the deflections, or little more than noise",
        places_and_deflections::agree: [UnlikeDescription]
            "places and deflections together leave what each leaves alone: they show one set of springs",
        deflections::zeroed: [Misread]
            "deflections are not all shifted alike: the readings without load were of the unloaded robot",
        parameters::near_their_description: [MovedFar]
            "calibrated constants are within some tolerances of the description",
        parameters::of_the_same_size: [MovedFar]
            "calibrated lengths are together as long as the declared ones",
        parameters::as_stiff_as_declared: [WrongUnits, MovedFar]
            "springs are of the declared order of size",
        common_factor::of_calibration: [WrongUnits]
            "springs are not all softer or stiffer by one factor: masses, stiffnesses or wrenches are off by it",
        parameters::springs_within_their_range: [Implausible]
            "springs are neither free nor rigid to any instrument",
        parameters::free_lengths: [SpringsHeld]
            "springs are not fitted with a free length that is held",
        amount::of_sessions: [TooLittleData]
            "each session has more readings than a base or tool of its own has unknowns",
        stated_noise::as_noisy_as_stated: [NoiseUnlikeStated, Implausible]
            "residuals are of the order of the stated noise",
        parameters::better_than_registered: [WorseThanRegistered]
            "calibration makes readings better that it did not see",
        parameters::enough_readings: [TooLittleData]
            "there are more readings than parameters, of configurations that differ",
    }
}

/// What all checks find.
pub fn judge(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    found_by(CHECKS.iter(), evidence, limits)
}

/// What the checks of a calibration find, those of readings and description left out.
pub fn judge_result(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    found_by(CHECKS.iter().filter(|check| check.of_result), evidence, limits)
}

fn found_by<'c>(checks: impl Iterator<Item = &'c Check>, evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let mut all: Vec<(bool, Diagnostic)> = Vec::new();
    // Places and deflections are read wrongly in ways of their own.
    let halves = evidence.campaign.by_difference();
    let placed = halves.as_ref().map(|[places, _]| placed(evidence.model, places));
    let of_halves: Vec<Evidence> = match (&halves, &placed) {
        (Some([places, deflections]), Some(placed)) => {
            vec![Evidence::of(evidence.model, places), Evidence::of(placed, deflections)]
        }
        _ => Vec::new(),
    };
    for check in checks {
        let parts = if check.of_result || of_halves.is_empty() { std::slice::from_ref(evidence) } else { &of_halves };
        for found in parts.iter().flat_map(|part| (check.find)(part, limits)) {
            let is_own = check.codes.contains(&found.code);
            let usual = check.codes.first().copied().unwrap_or(found.code);
            let found = (check.of_result, if is_own { found } else { found.code(usual) });
            if !all.contains(&found) {
                all.push(found);
            }
        }
    }
    // Of a fit that did not end at a minimum nothing else can be said than why.
    let is_open = |diagnostic: &Diagnostic| matches!(diagnostic.code, Code::NotConverged | Code::NotComputed);
    if all.iter().any(|(_, diagnostic)| is_open(diagnostic)) {
        all.retain(|(of_result, diagnostic)| !of_result || is_open(diagnostic) || diagnostic.code == Code::Misread);
    }
    all.into_iter().map(|(_, diagnostic)| diagnostic).collect()
}

/// The model with base and tool described as its absolute readings place them: a deflection is read in the axes of the instrument.
fn placed(model: &Model, places: &Campaign) -> Model {
    let mut placed = model.clone();
    let found = registered(model, places, &model.registry.nominal(), &RegistrationSettings::default());
    for (parameter, value) in placed.registry.all_mut().iter_mut().zip(found.into_iter().flat_map(|(values, _)| values))
    {
        if matches!(parameter.group, Group::Base | Group::Tool) {
            parameter.nominal = value;
        }
    }
    placed
}

/// The same without readings that are far off both before and after a calibration: the greater number of them.
pub fn reported_once(mut found: Vec<Diagnostic>) -> Vec<Diagnostic> {
    let outlying = |diagnostic: &Diagnostic| diagnostic.code == Code::OutlyingReadings;
    let of = |diagnostic: &Diagnostic| Some((far_readings(diagnostic)?, diagnostic.clone()));
    let most = found.iter().filter_map(of).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, most)| most);
    let first = found.iter().position(outlying);
    found.retain(|diagnostic| !outlying(diagnostic));
    if let Some((first, most)) = first.zip(most) {
        found.insert(first, most);
    }
    found
}

/// The same where the user goes on all the same: errors of plausibility are warnings.
pub fn forced(found: Vec<Diagnostic>) -> Vec<Diagnostic> {
    let weaker = |diagnostic: Diagnostic| match diagnostic.code.is_plausibility() {
        true => Diagnostic { severity: Severity::Warning, ..diagnostic },
        false => diagnostic,
    };
    found.into_iter().map(weaker).collect()
}

/// How files must be read otherwise to fit the description, where that is known, or that they are of another robot: for commands that
/// fit nothing.
pub fn misread(model: &Model, campaign: &Campaign) -> Vec<Diagnostic> {
    let limits = Limits::default();
    // A few configurations fit however they are read.
    let poses = distinct(campaign.readings.iter().map(|reading| reading.pose));
    if poses.len() < limits.least_configurations {
        return Vec::new();
    }
    let mut found = judge(&Evidence::of(model, campaign), &limits);
    let is_of_files = |code: Code| matches!(code, Code::WrongUnits | Code::Misread | Code::UnlikeDescription);
    found.retain(|diagnostic| diagnostic.is_error() && is_of_files(diagnostic.code));
    found
}

/// Why a calibration could not be computed, where readings or description say why: readings that are simply wrong bend a fit to where
/// nothing can be computed, and content that makes no sense may not even be computed with. `error` is what the fit said.
pub fn why_not_computed(
    failure: &Diagnostics,
    evidence: &Evidence,
    limits: &Limits,
    force: bool,
) -> Option<Vec<Diagnostic>> {
    let judged = judge(evidence, limits);
    let is_wrong = |found: &&Diagnostic| found.code == Code::OutlyingReadings;
    let diagnostic = judged.iter().find(is_wrong).cloned();
    if let Some(wrong) = diagnostic.or_else(|| outlying::before_failure(evidence, limits)) {
        return Some(std::iter::once(wrong).chain(failure.iter().cloned()).collect());
    }
    refusing(judged, force)
}

/// All that was found, where an error of plausibility is among it and the user does not go on all the same.
pub fn refusing(found: Vec<Diagnostic>, force: bool) -> Option<Vec<Diagnostic>> {
    let refuses = |diagnostic: &Diagnostic| diagnostic.is_error() && diagnostic.code.is_plausibility();
    (!force && found.iter().any(refuses)).then_some(found)
}
