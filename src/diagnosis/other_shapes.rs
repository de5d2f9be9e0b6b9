//! Whether an error has another shape than a law says: at a joint a step, a corner or a bend at one value of what it goes with, a
//! polynomial of low degree, a period that is no pure swing, or a wave with corners or steps; with time a second change.
//!
//! A free curve has an amount for each knot, and with few configurations it predicts readings that were not fitted no better than a law
//! of nearly its shape. Shapes of one to three amounts have more power against such a law. Where one does certainly better than a law, or
//! as well as several laws at the joint together, the law is not named, and its site is.
//!
//! Source: truncated power functions with one knot, of degrees 0 to 2: Friedman, *Multivariate adaptive regression splines*, Ann. Stat. 19,
//! 1991, sec. 3.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::{DMatrix, DVector};

use super::compared::Compared;
use super::constancy::mean_and_deviation;
use super::held_out::{Additions, paired};
use super::hypothesis::Hypothesis;
use crate::effects::{Family, SiteKind};
use crate::math::{least_squares, project_off};

/// Knots: at these parts of the rows, by the value of what the law goes with; further out a knot has too few on one side.
const PARTS: std::ops::Range<usize> = 2..19;
/// Of so many.
const OF_PARTS: usize = 20;
/// Greatest degree of a truncated power.
const BENDS: i32 = 2;
/// Greatest degree of a polynomial.
const DEGREES: i32 = 3;
/// Swings of one period: with its second, its second and third, and its third harmonic; and twice the period.
const HARMONICS: [&[f64]; 4] = [&[1.0, 2.0], &[1.0, 2.0, 3.0], &[1.0, 3.0], &[0.5, 1.0]];
/// Waves of which the first harmonic is a cosine: triangle, square, rising and falling saw tooth, upper and lower half of a swing.
const WAVES: [fn(f64) -> f64; 6] = [
    |x| x.cos().asin(),
    |x| x.cos().signum(),
    |x| tooth(x + FRAC_PI_2),
    |x| -tooth(x - FRAC_PI_2),
    |x| x.cos().max(0.0),
    |x| x.cos().min(0.0),
];

/// A saw tooth, -1 to 1, that is zero at zero.
fn tooth(x: f64) -> f64 {
    (x + PI).rem_euclid(TAU) / PI - 1.0
}

/// With so many other laws at its joint a law is not named where it takes less than `of_site` of [`super::settings::ClaimSettings`] of what all
/// of them do; with one more, where it takes less than `near_curve`: so many laws together fit any shape. Chosen on two draws of a generator that
/// the project does not hold, judged on a third.
const SEVERAL: usize = 2;

/// Columns of each shape, what they move the rows by, over their sigmas.
struct Shapes {
    /// With a knot, and polynomials.
    bent: Vec<DMatrix<f64>>,
    /// Of the law's period.
    periodic: Vec<DMatrix<f64>>,
    /// Of its period, and of the phase that it has.
    waves: Vec<DMatrix<f64>>,
}

impl Compared<'_> {
    /// Whether an error of another shape at its site does certainly better than a law, or as well as this and others there that were
    /// chosen with it do together, on readings that were not fitted.
    pub fn is_of_other_shape(&self, at: usize) -> bool {
        let [own] = self.sets[at][..] else { return false };
        let (hypotheses, settings) = (&self.forward.problem.hypotheses, self.forward.settings);
        let law = &hypotheses[own];
        if self.changes_again(own) {
            return true;
        }
        let before = self.before();
        let Some(Shapes { bent, periodic, waves }) = self.shapes(law, &before) else { return false };
        let is_here = |h: &usize| hypotheses[*h].site.name == law.site.name && hypotheses[*h].family() == law.family();
        let (here, others): (Vec<usize>, Vec<usize>) = self.others.iter().partition(|&h| is_here(h));
        let together = [here.as_slice(), &[own]].concat();
        let laws = Additions::new(&self.forward.selector.projection, &others, &[vec![own], together]);
        let of_laws = self.forward.folds.losses(&laws);
        let gain = |losses: &[f64]| paired(&of_laws.base, losses).sum;
        let [alone, all] = [0, 1].map(|k| &of_laws.with[k]);
        let share = gain(alone) / gain(all);
        if here.len() >= SEVERAL && share < settings.of_site || here.len() > SEVERAL && share < settings.near_curve {
            return true;
        }
        let is_better = |shape: &[f64], least: f64, tried: usize| {
            gain(alone) < least * gain(shape) && paired(alone, shape).t > settings.certain_of(tried)
        };
        let of_bent = if law.is_named_by_driver() { settings.of_free } else { 1.0 };
        // Small corrections of a law do not make it another.
        let is_as_good = |shape: &[f64], least: f64, tried: usize| match share >= settings.near_curve {
            true => is_better(shape, least, tried),
            false => gain(shape) >= settings.near_curve * gain(all) && paired(shape, all).t < settings.paired_t,
        };
        let losses = |shapes: &[DMatrix<f64>]| self.forward.folds.losses(&laws.with(shapes)).with;
        let tried = bent.len() + periodic.len();
        if losses(&bent).iter().any(|shape| is_as_good(shape, of_bent, tried)) {
            return true;
        }
        // Swings have harmonics of their own, as gears do; great ones are those of another shape. Waves are one question more, of one amount
        // each, and do better than a swing with its second harmonic too.
        let periodic = losses(&periodic);
        let left = |losses: &Vec<f64>| losses.iter().sum::<f64>();
        let with_second = periodic.first().map_or(f64::INFINITY, left);
        let is_wave = |wave: &Vec<f64>| is_as_good(wave, 1.0, waves.len()) && left(wave) < with_second;
        periodic.iter().any(|shape| is_better(shape, settings.of_site, tried)) || losses(&waves).iter().any(is_wave)
    }

    /// Whether a law of what changes at one time does certainly better together with a second one of its kind at its site, at another time:
    /// certainly whichever is tried and by more than what the readings between two times that are tried would make, or as a curve does that
    /// is better by much.
    fn changes_again(&self, own: usize) -> bool {
        let (hypotheses, settings) = (&self.forward.problem.hypotheses, self.forward.settings);
        let is_moment = |&h: &usize| {
            let one = &hypotheses[h];
            one.is_same(&hypotheses[own]) && one.family() == Family::Time && one.nonlinear.time_of_change().is_some()
        };
        if !is_moment(&own) {
            return false;
        }
        let others: Vec<usize> = self.others.iter().copied().filter(|h| !is_moment(h)).collect();
        let again = (0..hypotheses.len()).filter(|h| *h != own && is_moment(h)).map(|h| vec![own, h]);
        let sets: Vec<Vec<usize>> = std::iter::once(vec![own]).chain(again).collect();
        let losses = self.forward.losses(&others, &sets);
        let Some((alone, twice)) = losses.with.split_first() else { return false };
        let gain = |with: &[f64]| paired(&losses.base, with).sum;
        let certain = settings.certain_of(twice.len());
        twice.iter().any(|with| {
            let (share, t) = (gain(alone) / gain(with), paired(alone, with).t);
            t > certain && share < settings.near_curve || t > settings.paired_t && share < settings.of_free
        })
    }

    /// Shapes that stand for a law of a joint in what the other causes leave; `None` of other laws, and where what it goes with does not vary.
    fn shapes(&self, law: &Hypothesis, before: &DVector<f64>) -> Option<Shapes> {
        let (problem, readings) = (self.forward.problem, self.tests.readings);
        // A difference of two readings shows that of two loads, which no shape of one load has.
        let is_difference = readings.campaign.readings.iter().any(|reading| reading.observes.is_difference());
        if law.site.kind != SiteKind::Joint || law.is_free() || is_difference {
            return None;
        }
        let joint = self.forward.free_errors.column(&law.site.name)?;
        let values = readings.goes_with(law)?;
        let [mean, deviation] = mean_and_deviation(&values)?;
        // Constraints are no readings.
        let known: Vec<Option<f64>> =
            problem.reading.iter().map(|reading| values.get(*reading).copied().flatten()).collect();
        let of = |shape: &dyn Fn(f64) -> f64| {
            DVector::from_fn(joint.len(), |row, _| known[row].map_or(0.0, |value| joint[row] * shape(value)))
        };
        let standard = |value: f64| (value - mean) / deviation;
        let mut sorted: Vec<f64> = known.iter().flatten().copied().collect();
        sorted.sort_by(f64::total_cmp);
        let knots = PARTS.filter_map(|part| sorted.get(part * sorted.len() / OF_PARTS).copied());
        let bent = knots.flat_map(|knot| (0..=BENDS).map(move |degree| (knot, degree)));
        let bent = bent.map(|(knot, degree)| {
            let beyond = |value: f64| if value > knot { (standard(value) - standard(knot)).powi(degree) } else { 0.0 };
            DMatrix::from_columns(&[of(&standard), of(&beyond)])
        });
        let smooth = (2..=DEGREES).map(|most| {
            let powers = (1..=most).map(|degree| of(&|value| standard(value).powi(degree)));
            DMatrix::from_columns(&powers.collect::<Vec<_>>())
        });
        let period = law.effect.period(&law.nonlinear);
        let swing = |order: f64, phase: f64, period: f64| of(&|value| (TAU * (order * value / period + phase)).cos());
        let swings = period.into_iter().flat_map(|period| {
            HARMONICS.map(|orders| {
                let phases = orders.iter().flat_map(|order| [0.0, 0.25].map(|phase| swing(*order, phase, period)));
                DMatrix::from_columns(&phases.collect::<Vec<_>>())
            })
        });
        let waves = period.into_iter().flat_map(|period| {
            let own = [0.0, 0.75].map(|phase| project_off(&swing(1.0, phase, period), &self.additions.basis));
            let amounts = least_squares(&DMatrix::from_columns(&own), before);
            let phase = amounts[1].atan2(amounts[0]);
            WAVES.map(|wave| DMatrix::from_columns(&[of(&|value| wave(TAU * value / period - phase))]))
        });
        Some(Shapes { bent: bent.chain(smooth).collect(), periodic: swings.collect(), waves: waves.collect() })
    }
}
