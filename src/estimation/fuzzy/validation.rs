//! Whether rules help readings that they were not fitted to.

use super::group::Group;
use super::grown::Grown;
use super::partition::Partition;
use super::samples::Samples;
use super::settings::FuzzySettings;

/// Root mean square error (distance) of the fitted samples when parts of the configurations are left out in turns, m:
/// without rules, and with these.
pub fn cross_validated(samples: &Samples, grown: &Grown, settings: &FuzzySettings) -> [f64; 2] {
    let fitted = samples.indices(false, |_| true);
    let mut poses: Vec<usize> = fitted.iter().map(|&k| samples.pose[k]).collect();
    poses.sort_unstable();
    poses.dedup();
    // In order of appearance, so that neighbouring configurations fall into different parts.
    let part_of = |k: usize| poses.partition_point(|pose| *pose < samples.pose[k]) % settings.folds;
    let (mut without, mut with) = (0.0, 0.0);
    for group in Group::all(samples, settings) {
        let own = |&column: &usize| grown.components.iter().find(|c| c.at == [group.axis, column]);
        let parts: Vec<Partition> = group.columns.iter().filter_map(own).map(|c| c.modes.clone()).collect();
        for part in 0..settings.folds {
            let (left_out, others): (Vec<usize>, Vec<usize>) = group.fitted.iter().partition(|&&k| part_of(k) == part);
            let b = group.solve_bounded(&parts, &others);
            with += group.residual(&parts, &b, &left_out).iter().map(|v| v * v).sum::<f64>();
        }
        without += group.fitted.iter().map(|&k| samples.d[k][group.axis].powi(2)).sum::<f64>();
    }
    [without, with].map(|squares| (squares / fitted.len().max(1) as f64).sqrt())
}
