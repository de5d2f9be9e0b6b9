//! How much a campaign holds that is not a repetition.

use std::collections::BTreeSet;

use super::Campaign;

/// Variables of one configuration agree to this, rad or m: rounding in a file, and less than a joint moves on purpose.
pub(super) const SAME_CONFIGURATION: f64 = 1e-3;

/// How much a campaign holds that is not a repetition.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Amount {
    /// Configurations that differ, whatever their names.
    pub configurations: usize,
    /// Residuals of readings that differ in configuration, session, point, target or load.
    pub rows: usize,
}

impl Campaign {
    /// What is left of a campaign when repetitions are taken out.
    ///
    /// ```
    /// let campaign = elastogeo::files::load_campaign("kr270-simulated", None)?.campaign;
    /// let amount = campaign.amount();
    /// // 30 configurations with 3 markers; the 3 repeats of each add nothing new.
    /// assert_eq!((amount.configurations, amount.rows, campaign.rows()), (30, 270, 810));
    /// # Ok::<(), elastogeo::Error>(())
    /// ```
    pub fn amount(&self) -> Amount {
        let mut configurations: BTreeSet<Vec<i64>> = BTreeSet::new();
        let mut seen = BTreeSet::new();
        let mut rows = 0;
        for (index, reading) in self.readings.iter().enumerate() {
            let steps = |value: &f64| (value / SAME_CONFIGURATION).round() as i64;
            let at: Vec<i64> = self.configuration(index).iter().map(steps).collect();
            let load = reading.wrench.map(f64::to_bits);
            let what = (reading.observes.name(), reading.marker, reading.target, reading.session, load);
            if seen.insert((at.clone(), what)) {
                rows += reading.observes.rows();
            }
            configurations.insert(at);
        }
        Amount { configurations: configurations.len(), rows }
    }
}
