//! Outliers: readings that lie many robust sigmas from the best explanation when it is fitted without them.
//!
//! Source: Rousseeuw and Leroy, *Robust Regression and Outlier Detection*, sec. 5.1 (median absolute deviation).

use indexmap::IndexMap;
use nalgebra::DVector;

use super::competition::Competition;
use super::free_errors::FreeErrors;
use super::heavy_tail;
use super::inputs::Inputs;
use super::level::Level;
use super::linear_fit::{LinearFit, entry};
use super::refit::with_nuisance;
use super::result::{Cause, CauseParameter, Shrinkage};
use super::settings::OutlierSettings;
use super::windows::{self, LEAST};
use crate::description::campaign::Campaign;
use crate::effects::{Condition, Family};
use crate::estimation::{CalibrationError, errors_of};
use crate::math::quantiles::OF_MEDIAN;
use crate::math::{distinct, least_squares, median};
use crate::prediction;

/// Which readings are outliers; `marked` were left out of the competition.
pub fn outliers(competition: &Competition, marked: &[bool], settings: &OutlierSettings) -> Vec<bool> {
    let mut marked = marked.to_vec();
    let most = (settings.most * marked.len() as f64) as usize;
    for _ in 0..settings.passes {
        let (distances, sigma) = distances(competition, &marked);
        let unmarked = distances.iter().zip(&marked).filter(|(_, marked)| !**marked).map(|(distance, _)| *distance);
        let greatest = unmarked.fold(0.0, f64::max);
        let found: Vec<bool> = distances
            .iter()
            .zip(&marked)
            .map(|(&distance, &marked)| {
                distance > settings.robust_sigmas * sigma && (marked || distance > settings.worst_first * greatest)
            })
            .collect();
        if found == marked || found.iter().filter(|outlier| **outlier).count() > most {
            break;
        }
        marked = found;
    }
    marked
}

/// Whether the marked readings stand apart from all others: a tail of what is not explained does not.
pub fn stand_apart(competition: &Competition, marked: &[bool], settings: &OutlierSettings) -> bool {
    let (distances, _) = distances(competition, marked);
    let of = |outlier: bool| distances.iter().zip(marked).filter(move |(_, m)| **m == outlier).map(|(d, _)| *d);
    of(true).fold(f64::INFINITY, f64::min) > settings.apart * of(false).fold(0.0, f64::max)
}

/// Share of the configurations with marked readings whose squares fall by half and more with one error at a few angles of one joint,
/// from which on these are no outliers: with one amount for all, outliers share neither direction nor size. A
/// judgement; tried on random outliers and on teeth of 10 to 30 deg.
const OF_ONE_PLACE: f64 = 0.7;
/// Configurations of which all of several points are wrong that show as much: rows of two falling by half by chance, with one amount, is one
/// in thousands.
const PAIR: usize = 2;
/// The fall of a configuration's squares that counts.
const BY_HALF: f64 = 0.5;

/// Whether the marked readings are wrong by what one joint does at a few of its angles.
///
/// # Errors
/// A configuration that cannot be assembled.
pub fn are_of_one_place(inputs: &Inputs, competition: &Competition, marked: &[bool]) -> Result<bool, CalibrationError> {
    let (model, campaign, all) = (inputs.model, inputs.campaign, &competition.all);
    let is_marked = |row: &usize| marked.get(all.reading[*row]) == Some(&true);
    let rows: Vec<usize> = (0..all.rows()).filter(is_marked).collect();
    let poses: Vec<&[usize]> = rows.chunk_by(|a, b| all.pose[*a] == all.pose[*b]).collect();
    // Of a wrong reading the other points of its configuration know nothing: where all of several are wrong, two configurations tell.
    let is_whole = |pose: &&[usize]| {
        let own = (0..all.rows()).filter(|&row| all.pose[row] == all.pose[pose[0]]);
        let mut readings: Vec<usize> = own.map(|row| all.reading[row]).collect();
        readings.dedup();
        readings.len() > 1 && readings.iter().all(|&reading| marked.get(reading) == Some(&true))
    };
    let least = if poses.iter().all(is_whole) { PAIR } else { LEAST };
    if poses.len() < least {
        return Ok(false);
    }
    let free = FreeErrors::new(model, campaign, &competition.values, all)?;
    let (residual, _) = residuals(competition, marked);
    let most = (OF_ONE_PLACE * poses.len() as f64).ceil() as usize;
    let mut are = false;
    windows::each((model, campaign), all, &free, least, |_, _, column| {
        let size = column.norm_squared();
        if are || size == 0.0 {
            return;
        }
        let amount = column.dot(&residual) / size;
        let falls = |pose: &&&[usize]| {
            let squares = |by: f64| pose.iter().map(|&row| (residual[row] - by * column[row]).powi(2)).sum::<f64>();
            squares(amount) < BY_HALF * squares(0.0)
        };
        are = poses.iter().filter(falls).count() >= most.max(least);
    });
    Ok(are)
}

/// Readings at an end of the campaign, at least, that are no outliers where nearly all of them are marked: two or three may be chance.
const LEAST_AT_END: usize = 5;
/// Share of them that is marked, and share of all that is marked among them, at least. Outliers have neither; what moved has both, but
/// for readings next to the moment at which it did. A judgement.
const NEARLY_ALL: f64 = 0.9;

/// Whether the marked readings are those of one marker, or all, from one reading on or up to one, in the order of measurement: it
/// was moved, and nothing is wrong with them.
pub fn are_of_one_move(campaign: &Campaign, marked: &[bool]) -> bool {
    let all = marked.iter().filter(|marked| **marked).count();
    let markers = distinct(campaign.readings.iter().map(|reading| reading.marker));
    let of_one = markers.iter().map(|marker| Some(*marker)).filter(|_| markers.len() > 1);
    std::iter::once(None).chain(of_one).any(|marker| {
        let is_own = |index: &usize| marker.is_none_or(|own| campaign.readings[*index].marker == own);
        let mut own: Vec<usize> = (0..campaign.readings.len()).filter(is_own).collect();
        own.sort_by(|&a, &b| campaign.rank(a).total_cmp(&campaign.rank(b)));
        let ends = |order: &[usize]| {
            let is_marked = order.iter().map(|index| usize::from(marked.get(*index) == Some(&true)));
            let counts = is_marked.scan(0, |count, marked| {
                *count += marked;
                Some(*count)
            });
            counts.enumerate().any(|(before, count)| {
                let (count, length) = (count as f64, before + 1);
                let is_rest = length < order.len();
                is_rest
                    && length >= LEAST_AT_END
                    && count >= NEARLY_ALL * length as f64
                    && count >= NEARLY_ALL * all as f64
            })
        };
        let from_start = ends(&own);
        own.reverse();
        from_start || ends(&own)
    })
}

/// Weighted residuals, nuisance and members fitted to the readings that are not marked; and the rows of these.
fn residuals(competition: &Competition, marked: &[bool]) -> (DVector<f64>, Vec<usize>) {
    let all = &competition.all;
    let design = all.design(competition.members());
    let rows: Vec<usize> = (0..all.rows()).filter(|&row| marked.get(all.reading[row]) != Some(&true)).collect();
    let x = least_squares(&design.select_rows(&rows), &all.residual.select_rows(&rows));
    (&all.residual - design * x, rows)
}

/// Greatest weighted residual of each reading, nuisance and members fitted to those that are not marked; and the robust
/// sigma of these.
fn distances(competition: &Competition, marked: &[bool]) -> (Vec<f64>, f64) {
    let all = &competition.all;
    let (residual, rows) = residuals(competition, marked);
    let mut used: Vec<f64> = rows.iter().map(|&row| residual[row].abs()).collect();
    let sigma = (OF_MEDIAN * median(&mut used).unwrap_or(0.0)).max(competition.noise.unwrap_or(0.0));
    let mut distances = vec![0.0_f64; marked.len()];
    for (value, &reading) in residual.iter().zip(&all.reading) {
        // What is known of the arrangement is no reading, and no outlier.
        distances.get_mut(reading).into_iter().for_each(|distance| *distance = distance.max(value.abs()));
    }
    (distances, sigma)
}

/// Whether the marked readings are no further off than the tail of the noise that the others show.
fn are_of_the_noise(competition: &Competition, marked: &[bool], settings: &OutlierSettings) -> bool {
    let (residual, rows) = residuals(competition, marked);
    let (distances, _) = distances(competition, marked);
    let farthest = distances.iter().zip(marked).filter(|(_, marked)| **marked).map(|(distance, _)| *distance);
    let sizes = rows.iter().map(|&row| residual[row].abs()).collect();
    heavy_tail::reaches(sizes, farthest.fold(0.0, f64::max), settings.tail_chance)
}

/// Outliers as a cause.
pub struct SetAside {
    pub cause: Cause,
    /// Root mean square and greatest error of all readings, m, where outliers are part of the gap; `None` where a greater gap hides them.
    pub with_all: Option<[f64; 2]>,
}

/// The cause `outliers`. Where they are part of the gap, with nothing but the calibration
/// fitted they are set aside first, which leaves the first of `left` (m); the second is what all causes leave. Where a
/// greater gap hides them, the cause is what they add to the latter. No cause
/// where there is no outlier, where they are no further off than noise with tails as heavy as the others show, or just beyond what noise does,
/// and explain no gap.
///
/// # Errors
/// A configuration that cannot be assembled.
pub fn cause(
    inputs: &Inputs,
    competition: &Competition,
    members: &[usize],
    marked: &[bool],
    left: [f64; 2],
) -> Result<Option<SetAside>, CalibrationError> {
    // Of a reading whose predecessor is not known a law of the last move cannot say what it should be.
    let effects = members.iter().map(|&member| &competition.problem.hypotheses[member].effect);
    let is_of_moves = effects.into_iter().any(|effect| effect.reads().contains(&Condition::LastMove));
    let moves = &inputs.campaign.conditions.last_move;
    let is_unknown =
        |reading: usize| is_of_moves && moves.iter().all(|all| all.get(reading).is_none_or(|v| v.is_nan()));
    let count = (0..marked.len()).filter(|&reading| marked[reading] && !is_unknown(reading)).count();
    if count == 0 || are_of_the_noise(competition, marked, &inputs.settings.outliers) {
        return Ok(None);
    }
    // By how much their error shrinks, to what is left without the outliers.
    let shrinkage = |residual: &[f64], left: f64| {
        let [_, rms, max] = errors_of(inputs.campaign, residual, |_| true).distance;
        let rms = rms.max(left);
        (1.0 - left / rms, [rms, max])
    };
    let turned = |residual: &[f64]| {
        let of = |among: &dyn Fn(usize) -> bool| errors_of(inputs.campaign, residual, among).orientation;
        let [all, others] = [of(&|_| true)?, of(&|reading| marked.get(reading) != Some(&true))?];
        Some([all[1], others[1]].map(f64::to_degrees))
    };
    let [alone, after] = left;
    let explained = left_of_all(inputs, competition, members)?;
    let least = inputs.settings.outliers.least_shrinkage;
    let of_rest = shrinkage(&explained, after);
    if of_rest.0 < least {
        return Ok(None);
    }
    let calibrated = left_of_all(inputs, competition, &[])?;
    let of_gap = shrinkage(&calibrated, alone);
    let is_hidden = of_gap.0 < least;
    let (value, errors) = if is_hidden { of_rest } else { of_gap };
    // Rotations alone may be what is wrong.
    let rotations = turned(&calibrated).filter(|_| is_hidden).map(|[all, others]| {
        format!("errors of orientations (rms) fall from {all:.4} to {others:.4} deg without these readings")
    });
    let effect = inputs.model.catalogue.get("outliers");
    let cause = Cause {
        effect: "outliers".into(),
        site: "instrument".into(),
        is_free: false,
        probability: None,
        parameters: vec![CauseParameter {
            name: "count".into(),
            unit: "1",
            value: (count as f64).into(),
            ci95: Some(0.0),
        }],
        rms_before: errors[0],
        rms_after: if is_hidden { after } else { alone },
        shrinkage: Shrinkage { value, ci95: Some([value; 2]) },
        rivals: Vec::new(),
        family: Family::Gross,
        level: Level::Law,
        follows: None,
        stability: None,
        support: None,
        curve: None,
        curves: IndexMap::new(),
        implies: rotations.into_iter().collect(),
        signature: effect.map_or("", |effect| effect.signature()),
        remedy: effect.map_or("", |effect| effect.remedy()),
        entries: Vec::new(),
    };
    Ok(Some(SetAside { cause, with_all: (!is_hidden).then_some(errors) }))
}

/// What is left of all readings with some members fitted.
fn left_of_all(inputs: &Inputs, competition: &Competition, members: &[usize]) -> Result<Vec<f64>, CalibrationError> {
    let fitted = LinearFit::new(&competition.problem, members, 1.0, Vec::new(), Vec::new());
    let mut model = inputs.model.clone();
    for (step, &member) in members.iter().enumerate() {
        model.switch_on(entry(&competition.problem.hypotheses[member], &fitted.parameters(step)));
    }
    let values = model.completed(&with_nuisance(inputs.model, competition, &fitted));
    Ok(prediction::residuals(&model, inputs.campaign, &values)?)
}
