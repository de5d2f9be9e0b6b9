//! What is asked of the comparison of checks, each value with its reason.

use crate::settings::settings;

settings! {
    /// Limits of the comparison.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Settings {
        /// Probability that a year of checks of a robot that does not change raises any alarm. 5 % is the usual family-wise level.
        pub level: f64 = 0.05,
        /// Checks in a year, over which [`Settings::level`] is spent in equal parts (Bonferroni).
        pub checks_a_year: f64 = 12.0,
        /// A step is looked for at so many of the last checks: one that three checks together do not show is no longer urgent, and
        /// each more makes all limits wider.
        pub steps: usize = 3,
        /// Fewest checks through which a line is put: a slope through three has one check to contradict it.
        pub line: usize = 4,
        /// Probability with which the next check should show a change.
        pub power: f64 = 0.9,
        /// The change that it should show where none is named, in standard deviations of the last check's estimate.
        pub change: f64 = 3.0,
        /// Twice the logarithm of the likelihood by which a parameter explains a change better than another that is still named
        /// next to it: below 6 evidence is not strong (Kass and Raftery, *J. Am. Stat. Assoc.* 90, 1995).
        pub rival: f64 = 6.0,
        /// Most poses of a next check that are looked at, in multiples of the last check's.
        pub most: f64 = 100.0,
    }
}

impl Settings {
    /// Level of one check.
    pub fn of_check(&self) -> f64 {
        self.level / self.checks_a_year
    }

    /// Level of one of the tests of a check that compares so many parameters: of steps and the line, of each parameter alone
    /// and of all together, and of the residuals.
    pub fn of_test(&self, parameters: usize) -> f64 {
        self.of_check() / (((self.steps + 1) * (parameters + 1) + 1) as f64)
    }
}
