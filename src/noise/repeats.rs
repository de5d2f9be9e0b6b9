//! Scatter of repeated readings: of one point at one configuration, under one load and from one side of approach.

use super::NoiseEstimate;
use crate::description::campaign::Campaign;

/// Readings of a configuration that count as repeats of each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Repeated {
    /// Those taken one after the other: what scatters is the instrument.
    InPlace,
    /// All: the robot may have come back.
    Anywhere,
}

/// Standard deviation of the lengths in repeated readings over `size` (of a reading's row), with its degrees of freedom; `None`
/// where nothing is repeated, or nothing scatters.
pub fn repeats(campaign: &Campaign, what: Repeated, size: impl Fn(usize, usize) -> f64) -> Option<NoiseEstimate> {
    let configurations = campaign.configurations();
    let configuration = |index: usize| configurations[campaign.readings[index].pose];
    let sides: Vec<&Vec<f64>> = campaign.conditions.approach.iter().flatten().collect();
    let is_repeat = |a: usize, b: usize| {
        let [one, other] = [&campaign.readings[a], &campaign.readings[b]];
        configuration(a) == configuration(b)
            && one.marker == other.marker
            && one.target == other.target
            && one.observes == other.observes
            && one.session == other.session
            && one.wrench == other.wrench
            && sides.iter().all(|all| all[a] == all[b])
    };
    let mut order: Vec<usize> = (0..campaign.readings.len()).collect();
    if what == Repeated::Anywhere {
        order.sort_by_key(|&i| configuration(i));
    }
    let (mut deviations, mut freedom) = (Vec::new(), 0.0);
    for pose in order.chunk_by(|&a, &b| configuration(a) == configuration(b)) {
        let mut left = pose.to_vec();
        while let Some(first) = left.pop() {
            let (mut same, others): (Vec<usize>, Vec<usize>) = left.into_iter().partition(|&i| is_repeat(first, i));
            same.push(first);
            left = others;
            let observes = campaign.readings[first].observes;
            for k in 0..observes.columns().len().min(observes.length_rows()) {
                let of = |i: &usize| campaign.readings[*i].measured[k];
                let mean = same.iter().map(of).sum::<f64>() / same.len() as f64;
                let size = size(first, k);
                if same.len() > 1 {
                    deviations.extend(same.iter().map(|i| (of(i) - mean) / size));
                    freedom += (same.len() - 1) as f64;
                }
            }
        }
    }
    NoiseEstimate::of(deviations, freedom)
}
