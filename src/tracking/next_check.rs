//! How many poses the next check needs to show a given change.
//!
//! Poses like those of the last check each add the same information: with `n` poses in place of its `N` the covariance is `C N / n`.
//! The next check is compared with the mean of those since the last change, or with the line of what grows, of covariance `M`. A change `a` of parameter `i` alone
//! then has the mean `a ((M + C N / n)^-1)_ii^1/2` of its statistic, which must be greater than the limit of the test by the
//! quantile of the power. This holds for poses chosen as those were; `plan` chooses better ones.

use super::check::Check;
use super::contrast::inverse;
use super::monitor::{History, root};
use super::settings::Settings;
use crate::math::quantiles::two_sided_t;

/// What the next check needs to show a change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NextCheck {
    /// Which parameter.
    pub parameter: usize,
    /// A change of it, SI.
    pub change: f64,
    /// Fewest poses; `None` where no number shows it: the checks before are not certain enough.
    pub poses: Option<usize>,
}

/// Fewest poses that show changes (parameter, SI) with the power asked for.
pub fn next_check(
    checks: &[Check],
    history: &History,
    changes: &[(usize, f64)],
    settings: &Settings,
) -> Option<Vec<NextCheck>> {
    let (last, check) = (history.scaled.last()?, checks.last()?);
    let mean = history.stretch.covariance_of_next(&history.scaled)?;
    let level = settings.of_test(last.values.len());
    let above = root(|z| two_sided_t(z, f64::INFINITY) - 2.0 * (1.0 - settings.power));
    let have = check.poses as f64;
    // Of every pose so many readings; fewer than parameters determine nothing.
    let rows = (last.freedom.min(1e6) + last.values.len() as f64) / have.max(1.0);
    let least = (last.values.len() as f64 / rows.max(1.0)).floor() as usize + 2;
    let is_shown = |parameter: usize, change: f64, poses: usize| -> Option<bool> {
        let information = inverse(&(&mean + &last.covariance * (have / poses as f64)))?;
        let size = history.scale.get(parameter)?;
        let seen = change.abs() / size * information.get((parameter, parameter))?.max(0.0).sqrt();
        let freedom = (rows * poses as f64 - last.values.len() as f64).max(1.0);
        Some(seen >= root(|z| two_sided_t(z, freedom) - level) + above)
    };
    let fewest = |(parameter, change): &(usize, f64)| {
        let (mut low, mut high) = (least, ((settings.most * have) as usize).max(least));
        let poses = if is_shown(*parameter, *change, high)? {
            while low < high {
                let middle = usize::midpoint(low, high);
                if is_shown(*parameter, *change, middle)? { high = middle } else { low = middle + 1 }
            }
            Some(high)
        } else {
            None
        };
        Some(NextCheck { parameter: *parameter, change: *change, poses })
    };
    changes.iter().map(fewest).collect()
}

/// Changes of the settings' size of each parameter of the last check, SI.
pub fn usual_changes(checks: &[Check], settings: &Settings) -> Vec<(usize, f64)> {
    let widths = checks.last().map(|check| check.robot.covariance.diagonal());
    let sizes =
        widths.iter().flat_map(|widths| widths.iter().map(|variance| settings.change * variance.max(0.0).sqrt()));
    sizes.enumerate().collect()
}
