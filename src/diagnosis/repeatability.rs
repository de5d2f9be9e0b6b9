//! Noise of repeated readings.

use crate::description::campaign::Campaign;
use crate::estimation::row_sigmas;

/// Noise over the sigmas of the rows, from readings of one point at one configuration under one load and from one side of
/// approach; `None` where they have fewer than `least` degrees of freedom.
pub fn repeatability(campaign: &Campaign, least: f64) -> Option<f64> {
    let sigmas = row_sigmas(campaign);
    let first_rows = campaign.first_rows();
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
    order.sort_by_key(|&i| configuration(i));
    let (mut squares, mut freedom) = (0.0, 0.0);
    for pose in order.chunk_by(|&a, &b| configuration(a) == configuration(b)) {
        let mut left = pose.to_vec();
        while let Some(first) = left.pop() {
            let (mut same, others): (Vec<usize>, Vec<usize>) = left.into_iter().partition(|&i| is_repeat(first, i));
            same.push(first);
            left = others;
            let count = same.len() as f64;
            for k in 0..campaign.readings[first]
                .observes
                .columns()
                .len()
                .min(campaign.readings[first].observes.length_rows())
            {
                let sigma = sigmas[first_rows[first] + k];
                let of = |i: &usize| campaign.readings[*i].measured[k];
                let mean = same.iter().map(of).sum::<f64>() / count;
                squares += same.iter().map(|i| ((of(i) - mean) / sigma).powi(2)).sum::<f64>();
                freedom += count - 1.0;
            }
        }
    }
    (freedom >= least && squares > 0.0).then(|| (squares / freedom).sqrt())
}
