//! Noise of the instrument, and motion of what carries fixed reflectors, from readings of the reflectors alone.
//!
//! Each time, the reflectors are where they always are, moved as one rigid body, plus noise: a generalised Procrustes fit
//! (Gower, *Generalized Procrustes analysis*, Psychometrika 40, 1975). Whether they moved at all is an F test of that fit
//! against one without motion, or of a slow drift, whichever has the less chance (Bonferroni).

use nalgebra::{DMatrix, Rotation3, Vector3};

use super::NoiseEstimate;
use crate::description::campaign::{ReferenceReading, References};
use crate::math::quantiles::f_tail;
use crate::math::{distinct, orthonormal, rigid_fit};

/// Passes of the fit: places of reflectors and motions in turns converge by the square of the motion, which is small.
const PASSES: usize = 10;
/// Three reflectors fix a rotation; fewer a displacement only.
const FOR_ROTATION: usize = 3;
/// Degrees of the polynomials by which a slow drift is tried: even, and one that begins or ends.
const STEADY: [usize; 2] = [1, 3];

/// Motion of the reflectors as one body, over all times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Root mean square displacement of the reflectors from their mean places, m.
    pub rms: f64,
    /// Greatest displacement, m.
    pub greatest: f64,
    /// From the mean of the first tenth of the times to that of the last, m.
    pub drift: f64,
    /// Probability of as much by noise alone.
    pub p: f64,
}

/// What fixed reflectors say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceNoise {
    /// Scatter of the reflectors about a rigid body; with one reflector of its readings, motion included.
    pub noise: NoiseEstimate,
    /// None where one reflector cannot tell motion from noise.
    pub motion: Option<Motion>,
}

/// Noise and motion that the references of a campaign show; `None` where nothing was measured twice.
///
/// ```
/// use elastogeo::description::campaign::{ReferenceReading, References};
/// use elastogeo::noise::reference_noise;
/// use nalgebra::Vector3;
///
/// // Two reflectors, measured twice; between, both moved by 1 mm.
/// let at = |epoch: usize, reflector: usize| Vector3::new(1.0 + 1e-3 * epoch as f64, 2.0 * reflector as f64, 0.0);
/// let reading = |epoch, reflector| ReferenceReading { epoch, reflector, position: at(epoch, reflector) };
/// let readings = vec![reading(0, 0), reading(0, 1), reading(1, 0), reading(1, 1)];
/// let references = References { reflectors: vec!["a".into(), "b".into()], epochs: 2, readings, ..References::default() };
/// let found = reference_noise(&references).expect("measured twice");
/// assert!(found.noise.sigma < 1e-9);
/// assert!((found.motion.expect("two reflectors").greatest - 0.5e-3).abs() < 1e-9);
/// ```
pub fn reference_noise(references: &References) -> Option<ReferenceNoise> {
    let readings = &references.readings;
    let count = references.reflectors.len();
    let mut by_epoch: Vec<Vec<usize>> = vec![Vec::new(); references.epochs];
    for (index, reading) in readings.iter().enumerate() {
        by_epoch[reading.epoch].push(index);
    }
    by_epoch.retain(|own| !own.is_empty());
    let still = means(references, count, |index| readings[index].position);
    let at_rest: f64 = readings.iter().map(|r| (r.position - still[r.reflector]).norm_squared()).sum();
    let rest_freedom = 3.0 * (readings.len() as f64 - count as f64);
    if rest_freedom <= 0.0 {
        return None;
    }
    let noise = |squares: f64, degrees_of_freedom: f64| NoiseEstimate {
        sigma: (squares / degrees_of_freedom).sqrt(),
        degrees_of_freedom,
    };
    let freedoms: Vec<f64> = by_epoch.iter().map(|own| freedom(own.iter().map(|&i| readings[i].reflector))).collect();
    // All motions are against that of one time.
    let most = freedoms.iter().copied().fold(0.0, f64::max);
    let left_freedom = rest_freedom - (freedoms.iter().sum::<f64>() - most);
    if left_freedom <= 0.0 || by_epoch.len() < 2 {
        return Some(ReferenceNoise { noise: noise(at_rest, rest_freedom), motion: None });
    }
    let mut epoch_of = vec![0; readings.len()];
    for (epoch, own) in by_epoch.iter().enumerate() {
        own.iter().for_each(|&index| epoch_of[index] = epoch);
    }
    let (places, motions) = fitted(references, &by_epoch, &epoch_of, &freedoms, still.clone());
    let moved = |index: usize, from: &[Vector3<f64>]| {
        let (rotation, translation) = motions[epoch_of[index]];
        rotation * from[readings[index].reflector] + translation
    };
    let left: f64 =
        (0..readings.len()).map(|index| (readings[index].position - moved(index, &places)).norm_squared()).sum();
    let displaced: Vec<Vector3<f64>> =
        (0..readings.len()).map(|index| moved(index, &places) - still[readings[index].reflector]).collect();
    let tenth = by_epoch.len().div_ceil(10);
    let mean_of = |epochs: std::ops::Range<usize>| {
        let own: Vec<usize> = (0..readings.len()).filter(|&index| epochs.contains(&epoch_of[index])).collect();
        own.iter().map(|&index| displaced[index]).sum::<Vector3<f64>>() / own.len().max(1) as f64
    };
    let drift = mean_of(by_epoch.len() - tenth..by_epoch.len()) - mean_of(0..tenth);
    let motion = Motion {
        rms: (displaced.iter().map(Vector3::norm_squared).sum::<f64>() / displaced.len() as f64).sqrt(),
        greatest: displaced.iter().map(Vector3::norm).fold(0.0, f64::max),
        drift: drift.norm(),
        p: {
            let by_motion = rest_freedom - left_freedom;
            let any = f_tail((at_rest - left) / by_motion / (left / left_freedom), by_motion, left_freedom);
            let steady = STEADY.map(|degree| by_drift(readings, &still, &epoch_of, degree, [at_rest, rest_freedom]));
            let tried = 1.0 + steady.len() as f64;
            (tried * steady.into_iter().flatten().fold(any, f64::min)).min(1.0)
        },
    };
    Some(ReferenceNoise { noise: noise(left, left_freedom), motion: Some(motion) })
}

/// Probability that noise alone drifts as much as the displacement of all reflectors does by a polynomial of the number of the time, of a
/// degree; `still` are their mean places. Without epochs or freedom enough `None`.
///
/// The test of any motion has a displacement for each time and little power against a slow drift, which has few values.
fn by_drift(
    readings: &[ReferenceReading],
    still: &[Vector3<f64>],
    epoch_of: &[usize],
    degree: usize,
    [at_rest, freedom]: [f64; 2],
) -> Option<f64> {
    let last = epoch_of.iter().max().copied().filter(|last| *last > degree)? as f64;
    let power = |index: usize, k: usize| (2.0 * epoch_of[index] as f64 / last - 1.0).powi(k as i32 + 1);
    // Of each reflector about its mean, as its positions are.
    let mut means = vec![(vec![0.0; degree], 0.0); still.len()];
    for (index, reading) in readings.iter().enumerate() {
        let (sums, count) = &mut means[reading.reflector];
        sums.iter_mut().enumerate().for_each(|(k, sum)| *sum += power(index, k));
        *count += 1.0;
    }
    let columns = DMatrix::from_fn(readings.len(), degree, |index, k| {
        let (sums, count) = &means[readings[index].reflector];
        power(index, k) - sums[k] / count
    });
    let values = DMatrix::from_fn(readings.len(), 3, |index, k| {
        (readings[index].position - still[readings[index].reflector])[k]
    });
    let basis = orthonormal(&columns, None);
    let (taken, used) = (basis.tr_mul(&values).norm_squared(), 3.0 * basis.ncols() as f64);
    let left = (freedom - used).max(0.0);
    (used > 0.0 && left > 0.0 && at_rest > taken).then(|| f_tail(taken / used / ((at_rest - taken) / left), used, left))
}

/// A rotation and a translation (m).
type RigidMotion = (Rotation3<f64>, Vector3<f64>);

/// Places of the reflectors and motion of all of them at each time, in turns from `places`: a time with too few reflectors for
/// a rotation has a displacement.
fn fitted(
    references: &References,
    by_epoch: &[Vec<usize>],
    epoch_of: &[usize],
    freedoms: &[f64],
    mut places: Vec<Vector3<f64>>,
) -> (Vec<Vector3<f64>>, Vec<RigidMotion>) {
    let readings = &references.readings;
    let mut motions = vec![(Rotation3::identity(), Vector3::zeros()); by_epoch.len()];
    for _ in 0..PASSES {
        for ((motion, own), freedom) in motions.iter_mut().zip(by_epoch).zip(freedoms) {
            let from: Vec<Vector3<f64>> = own.iter().map(|&index| places[readings[index].reflector]).collect();
            let to: Vec<Vector3<f64>> = own.iter().map(|&index| readings[index].position).collect();
            *motion = match *freedom > 3.0 {
                true => rigid_fit(&from, &to),
                false => {
                    let shift: Vector3<f64> = from.iter().zip(&to).map(|(a, b)| b - a).sum();
                    (Rotation3::identity(), shift / own.len() as f64)
                }
            };
        }
        places = means(references, references.reflectors.len(), |index| {
            let (rotation, translation) = motions[epoch_of[index]];
            rotation.inverse() * (readings[index].position - translation)
        });
    }
    (places, motions)
}

/// Degrees of freedom of the motion of one time.
fn freedom(reflectors: impl Iterator<Item = usize>) -> f64 {
    let seen: Vec<usize> = distinct(reflectors);
    if seen.len() >= FOR_ROTATION { 6.0 } else { 3.0 }
}

/// Mean of something of each reflector.
fn means(references: &References, count: usize, of: impl Fn(usize) -> Vector3<f64>) -> Vec<Vector3<f64>> {
    let mut sums = vec![(Vector3::zeros(), 0.0); count];
    for (index, reading) in references.readings.iter().enumerate() {
        let (sum, number) = &mut sums[reading.reflector];
        *sum += of(index);
        *number += 1.0;
    }
    sums.into_iter().map(|(sum, number)| sum / number).collect()
}
