//! Noise as instruments have it.

use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StudentT};

use crate::blind::design::normal;
use crate::description::campaign::Campaign;
use crate::settings::named;

/// Share of the variance that the readings of a configuration, or neighbours in time, have in common.
const COMMON: f64 = 0.64;
/// Noise at the instrument, over that at the mean distance.
const NEAR: f64 = 0.2;

named! {
    /// A kind of noise; all have the same root mean square.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Noise {
        /// Each coordinate by itself.
        Independent "independent",
        /// Readings of one configuration share most of it.
        Shared "shared",
        /// Student's t of three degrees of freedom.
        HeavyTailed "heavy-tailed",
        /// 1/f in time.
        Flicker "1/f",
        /// Growing with the distance from the instrument.
        Distant "distant",
    }
}

impl Noise {
    /// One of them; of differences those that these have.
    pub fn draw(is_difference: bool, random: &mut ChaCha8Rng) -> Self {
        let all = [Self::Independent, Self::Shared, Self::HeavyTailed, Self::Flicker, Self::Distant];
        all[random.random_range(0..if is_difference { 4 } else { 5 })]
    }

    /// Errors of all readings, in sigmas, given what would be shown without.
    pub fn errors(self, campaign: &Campaign, shown: &[[f64; 3]], random: &mut ChaCha8Rng) -> Vec<Vector3<f64>> {
        let poses = campaign.poses.len();
        let common: Vec<Vector3<f64>> = match self {
            Self::Shared => (0..poses).map(|_| vector(random)).collect(),
            Self::Flicker => flicker(poses, random),
            _ => Vec::new(),
        };
        let tails = StudentT::new(3.0).ok();
        let lengths: Vec<f64> = shown.iter().map(|at| Vector3::from(*at).norm()).collect();
        let mean = lengths.iter().sum::<f64>() / lengths.len().max(1) as f64;
        let mut one = |(reading, length): (&crate::description::campaign::Reading, &f64)| match (self, &tails) {
            (Self::HeavyTailed, Some(tails)) => Vector3::from_fn(|_, _| tails.sample(random)) / 3.0_f64.sqrt(),
            (Self::Distant, _) => vector(random) * (NEAR + (1.0 - NEAR) * length / mean.max(f64::MIN_POSITIVE)),
            (Self::Shared | Self::Flicker, _) => {
                common[reading.pose] * COMMON.sqrt() + vector(random) * (1.0 - COMMON).sqrt()
            }
            _ => vector(random),
        };
        campaign.readings.iter().zip(&lengths).map(&mut one).collect()
    }
}

fn vector(random: &mut ChaCha8Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| normal(random))
}

/// Waves of all frequencies with a power in inverse proportion to them.
fn flicker(count: usize, random: &mut ChaCha8Rng) -> Vec<Vector3<f64>> {
    let fastest = (count / 2).max(1);
    let waves: Vec<[Vector3<f64>; 2]> = (0..fastest).map(|_| [vector(random), vector(random)]).collect();
    let power: f64 = (1..=fastest).map(|k| 1.0 / k as f64).sum();
    let at = |pose: usize| {
        let wave = |(k, [a, b]): (usize, &[Vector3<f64>; 2])| {
            let cycles = (k + 1) as f64;
            let (sine, cosine) = (std::f64::consts::TAU * cycles * pose as f64 / count as f64).sin_cos();
            (a * sine + b * cosine) / cycles.sqrt()
        };
        waves.iter().enumerate().map(wave).sum::<Vector3<f64>>() / power.sqrt()
    };
    (0..count).map(at).collect()
}
