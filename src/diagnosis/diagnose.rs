//! The diagnosis from beginning to end: competitions until no outlier is new, then the conclusion.

use std::borrow::Cow;

use rand::seq::SliceRandom;

use super::competition::Competition;
use super::conclusion::conclude;
use super::inputs::Inputs;
use super::level::Level;
use super::outliers::{are_of_one_move, are_of_one_place, outliers, stand_apart};
use super::result::{Diagnosis, Verdict};
use super::settings::Settings;
use crate::description::campaign::{Campaign, Reading};
use crate::estimation::{self, CalibrationError, held_springs, predicts_as_well, run_away};
use crate::math::distinct;
use crate::model::Model;
use crate::model::nuisance;
use crate::simulation::generator;

/// Diagnoses a campaign against a model, by its readings that hold lengths: those of angles or torques alone are left out. Of more configurations
/// than fit into the memory meant for the hypotheses a part is drawn with the seed. Readings marked in `held_out` are not fitted: the figures are theirs. `progress`
/// receives each stage in words.
///
/// # Errors
/// As [`crate::estimation::calibrate`]: readings that cannot be predicted, or too few of them.
///
/// ```
/// use elastogeo::diagnosis::{Settings, Verdict, diagnose};
/// use elastogeo::estimation::split;
///
/// // A KR-270 whose description has joint 1 rigid.
/// let loaded = elastogeo::files::load_campaign("kr270-rigid-joint-1", None)?;
/// let held_out = split(&loaded.campaign, 0.25, 1);
/// let settings = Settings::new(&loaded.campaign, 1);
/// let found = diagnose(&loaded.robot.model, &loaded.campaign, &held_out, &settings, &mut |_| {})?;
/// assert_eq!(found.verdict, Verdict::Explained);
/// let cause = &found.causes[0];
/// assert_eq!((cause.effect.as_str(), cause.site.as_str()), ("joint-compliance", "joint:1"));
/// assert!(cause.rms_after < 0.1 * cause.rms_before);
/// # Ok::<(), elastogeo::Error>(())
/// ```
pub fn diagnose(
    model: &Model,
    campaign: &Campaign,
    held_out: &[bool],
    settings: &Settings,
    progress: &mut dyn FnMut(&str),
) -> Result<Diagnosis, CalibrationError> {
    let has_lengths = |reading: &Reading| reading.observes.length_rows() > 0;
    if !campaign.readings.iter().all(has_lengths) {
        let with_lengths = campaign.select(|_, reading| has_lengths(reading));
        if with_lengths.readings.is_empty() {
            let why =
                "the readings hold no lengths, in which a diagnosis compares effects: `identify` takes angles alone";
            return Err(CalibrationError::Malformed(why.into()));
        }
        let both = campaign.readings.iter().zip(held_out);
        let own: Vec<bool> = both.filter(|(reading, _)| has_lengths(reading)).map(|(_, held_out)| *held_out).collect();
        return diagnose(model, &with_lengths, &own, settings, progress);
    }
    let nuisance = nuisance(model, campaign, &settings.known);
    let asked = estimation::Settings { only: Some(nuisance.clone()), ..estimation::Settings::default() };
    // The weight of angles whose noise is not stated is estimated once; a robot with nothing to calibrate leaves it as assumed.
    let campaign = &*estimation::weighed(model, campaign, held_out, &asked).unwrap_or(Cow::Borrowed(campaign));
    let mut inputs = Inputs { model, campaign, held_out, settings, nuisance };
    let none = vec![false; campaign.readings.len()];
    let mut competition = match Competition::new(&inputs, &none, progress) {
        Err(CalibrationError::TooMuch { megabytes, most }) => {
            let share = MARGIN * most as f64 / megabytes as f64;
            let Some((some, own, drawn_from)) = drawn(campaign, held_out, share, settings.seed) else {
                return Err(CalibrationError::TooMuch { megabytes, most });
            };
            progress("configurations drawn");
            let found = diagnose(model, &some, &own, settings, progress)?;
            return Ok(Diagnosis { drawn_from: Some(drawn_from), ..found });
        }
        other => other?,
    };
    if let Some((held, other)) = with_constants_held(&inputs, &competition, progress) {
        (inputs, competition) = (held, other);
    }
    let (competition, marked) = without_outliers(&inputs, competition, progress)?;
    let found = conclude(&inputs, &competition, &marked, progress)?;
    if found.verdict == Verdict::NoGap
        && let Some(held) = with_springs_held(&inputs, &competition, &marked, progress)
    {
        return Ok(held);
    }
    // To a curve, or to what nothing explains, those are outliers that it fits worst.
    let is_open = matches!(found.verdict, Verdict::Unexplained | Verdict::PartlyExplained)
        || found.causes.iter().any(|cause| cause.level != Level::Law);
    if is_open && marked.contains(&true) && !stand_apart(&competition, &marked, &settings.outliers) {
        let competition = Competition::new(&inputs, &none, progress)?;
        return conclude(&inputs, &competition, &none, progress);
    }
    Ok(found)
}

/// What is to be explained can move constants that readings hardly tell to where no arm has them. They are then held as described, and the
/// competition is held so, where that predicts readings held out no worse.
fn with_constants_held<'a>(
    inputs: &Inputs<'a>,
    competition: &Competition,
    progress: &mut dyn FnMut(&str),
) -> Option<(Inputs<'a>, Competition)> {
    let found = competition.calibration.as_ref()?;
    let hidden = run_away(inputs.model, &competition.campaign, found);
    if hidden.is_empty() {
        return None;
    }
    let held = inputs.without(&hidden);
    // What cannot be computed so stays as it is.
    let other = Competition::new(&held, &vec![false; inputs.campaign.readings.len()], progress).ok()?;
    let is_as_good = other.calibration.as_ref().is_some_and(|other| predicts_as_well(other, found));
    is_as_good.then_some((held, other))
}

/// Where nothing is to be explained, the same with springs held as described that an identification holds so, because the readings hardly
/// tell them: where that leaves no gap either, and predicts readings held out no worse.
fn with_springs_held(
    inputs: &Inputs,
    competition: &Competition,
    outliers: &[bool],
    progress: &mut dyn FnMut(&str),
) -> Option<Diagnosis> {
    let found = competition.calibration.as_ref()?;
    let held = held_springs(inputs.model, &competition.campaign, found, &inputs.nuisance);
    if held.is_empty() {
        return None;
    }
    let inputs = inputs.without(&held);
    let other = Competition::new(&inputs, outliers, progress).ok()?;
    let is_as_good = other.calibration.as_ref().is_some_and(|other| predicts_as_well(other, found));
    let concluded = is_as_good.then(|| conclude(&inputs, &other, outliers, progress))?.ok()?;
    (concluded.verdict == Verdict::NoGap).then_some(concluded)
}

/// Outliers are those of what explains the other readings, and are left out of the next competition: the last one, and which they are.
fn without_outliers(
    inputs: &Inputs,
    mut competition: Competition,
    progress: &mut dyn FnMut(&str),
) -> Result<(Competition, Vec<bool>), CalibrationError> {
    let settings = &inputs.settings.outliers;
    let none = vec![false; inputs.campaign.readings.len()];
    let mut marked = none.clone();
    for _ in 0..settings.competitions {
        let found = outliers(&competition, &marked, settings);
        if found == marked {
            break;
        }
        if are_of_one_move(inputs.campaign, &found) || are_of_one_place(inputs, &competition, &found)? {
            // Nothing is wrong with them: the robot itself is off there.
            if marked.contains(&true) {
                competition = Competition::new(inputs, &none, progress)?;
            }
            return Ok((competition, none));
        }
        marked = found;
        progress("outliers left out");
        competition = Competition::new(inputs, &marked, progress)?;
    }
    Ok((competition, marked))
}

/// Part of the memory that configurations drawn from many take up.
const MARGIN: f64 = 0.95;

/// About a share of the configurations, drawn with a seed, with the marks of their readings held out, and how many of how many these are;
/// `None` where that is none, or all.
fn drawn(campaign: &Campaign, held_out: &[bool], share: f64, seed: u64) -> Option<(Campaign, Vec<bool>, [usize; 2])> {
    let mut poses = distinct(campaign.readings.iter().map(|reading| reading.pose));
    let all = poses.len();
    poses.shuffle(&mut generator(seed));
    poses.truncate((share * all as f64) as usize);
    let mut is_kept = vec![false; campaign.poses.len()];
    poses.iter().for_each(|pose| is_kept[*pose] = true);
    let some = campaign.select(|_, reading| is_kept[reading.pose]);
    let both = campaign.readings.iter().zip(held_out);
    let own = both.filter(|(reading, _)| is_kept[reading.pose]).map(|(_, held_out)| *held_out).collect();
    (!poses.is_empty() && poses.len() < all).then_some((some, own, [poses.len(), all]))
}
