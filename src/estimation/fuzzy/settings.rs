//! What is asked of a fit of a fuzzy compliance, each limit with its reason.

use crate::settings::settings;

/// How modal values are placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Placement {
    /// Gauss-Newton on the residual that the best conclusions leave.
    GaussNewton,
    /// Random search of Solis and Wets (1981), seeded: as the IR663 paper, slower and no better.
    SolisWets(u64),
}

settings! {
    /// Limits of a fit of a fuzzy compliance. The defaults were set on the IR663 campaigns of the paper and on simulated
    /// deflections with 1 to 10 um of noise; leave them alone unless a campaign is far larger or smaller.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct FuzzySettings {
        /// How modal values are placed.
        pub placement: Placement = Placement::GaussNewton,
        /// Least part by which another set or split must lower the cross-validated error. One that lowers it by less follows
        /// chance: the error of some tens of readings is known to a few per cent only.
        pub worth: f64 = 0.01,
        /// Firing strength, summed over the fitted readings, below which a rule has seen no data: half of one reading.
        pub seen: f64 = 0.5,
        /// Least gap between neighbouring modes, and to the ends of the range, as a part of the largest gap: closer modes make a
        /// step that no compliance has.
        pub least_gap: f64 = 0.02,
        /// Most steps of Gauss-Newton: a placement is an intermediate result, and converges in fewer than ten.
        pub steps: usize = 25,
        /// Relative reduction of the squares below which Gauss-Newton ends: far below what `worth` asks of a set.
        pub cost_tolerance: f64 = 1e-6,
        /// Trials of the random search.
        pub trials: usize = 400,
        /// Weight of the difference between neighbouring conclusions relative to the readings of a rule: it decides only what
        /// the readings leave open.
        pub smoothing: f64 = 1e-3,
        /// Parts of the configurations that are left out in turns, to judge sets and splits, and again to judge a correction.
        pub folds: usize = 5,
        /// Least part by which a correction of springs must lower the cross-validated error to be kept.
        pub correction_worth: f64 = 0.03,
        /// Splits of a tree that may come to nothing before it ends: two inputs may only help together.
        pub patience: usize = 3,
        /// Least weight of a rule of a tree, in configurations: fewer than two do not tell a rule from its neighbour.
        pub least_support: f64 = 2.0,
        /// Least width of a cell that is split, rad or m: what no robot repeats.
        pub least_cell: f64 = 1e-6,
        /// Most splits on the way to a rule: what a description nests, and far more than halves of a range can be told apart.
        pub deepest: usize = 40,
        /// Weight, in configurations, with which each rule of a tree is drawn to the constant that fits best: it decides only
        /// what the readings leave open.
        pub pull: f64 = 0.01,
    }
}
