//! How a plan is searched: one struct, each value with its reason. What is planned is the [`super::Request`].

use crate::settings::settings;

settings! {
    /// How a plan is searched. The defaults find, on the bundled robots, plans that longer searches better by less than a
    /// percent of the error; leave them unless the method itself is studied.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Settings {
        /// Configurations drawn to choose from (three for each asked for, if that is more). Refinement moves their joints, so that
        /// they need not be dense.
        pub drawn: usize = 300,
        /// Random designs from which the exchange starts in addition to the greedy one: it ends in local optima.
        pub starts: u64 = 8,
        /// Least gain (of a loss, a logarithm) that is worth an exchange or a move: a tenth of a thousandth of the error.
        pub worth: f64 = 1e-4,
        /// Most passes of exchanges over all stations; the last pass usually changes nothing.
        pub passes: usize = 6,
        /// Most refinements of the joints, each with an exchange after it; [`Settings::least_refinement`] ends them before.
        pub refinements: u32 = 8,
        /// A refinement that lowers the loss (a logarithm: this share of the error) by less is the last.
        pub least_refinement: f64 = 1e-3,
        /// Steps of the joints in a refinement, as parts of the box: coarse ones first.
        pub steps: [f64; 4] = [0.2, 0.07, 0.02, 0.006],
        /// Directions drawn in addition to those of single variables.
        pub directions: usize = 6,
        /// Moves of one station before the next has its turn.
        pub moves: usize = 3,
        /// Of criteria of singular values, which have no cheap update: candidates tried, the best by the determinant.
        pub short_list: usize = 24,
        /// Test poses drawn where none are given.
        pub tests: usize = 100,
        /// Random sets with which a planned one is compared: the standard error of the median of 20 is 0.28 of the spread of
        /// single sets.
        pub random_sets: u64 = 20,
        /// Robots as far off as this many tolerances have to take every configuration too: one at the edge of what the nominal
        /// linkage can take is out of the real one's reach.
        pub off: f64 = 2.0,
        /// How many of them are tried.
        pub disturbed: u64 = 6,
        /// Whether constants of the robot count as known to their tolerances before anything is measured, as `identify --prior` takes
        /// them: fewer readings than parameters then do.
        pub prior: bool = false,
        /// Added to the information matrix, of which a candidate holds 1 in the mean: keeps it invertible while stations are too
        /// few. Far below [`Settings::seen`], far above rounding.
        pub ridge: f64 = 1e-9,
        /// Least information about any combination, on the same scale, with which it counts as seen.
        pub seen: f64 = 1e-7,
        /// Weight of the variance of every combination in the error at test poses, over the mean weight: what test poses do not
        /// depend on (the place of a second station, the mount of a sensor) is to be found as well. Ten times [`Settings::seen`]: a
        /// combination that is hardly seen then outweighs all test poses.
        pub nuisance: f64 = 1e-6,
    }
}
