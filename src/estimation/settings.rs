//! What is asked of a calibration: one struct per stage, each value with its reason.

use super::equivalence::Split;
use crate::description::campaign::Campaign;
use crate::identifiability::{Criterion, DEFAULT_TOLERANCE, Scaling};
use crate::least_squares::{self, Loss};
use crate::model::{Model, Nonlinear};
use crate::observation::{Observes, Purpose};
use crate::parameter::{Group, Slot};
use crate::settings::settings;

/// How the fit proceeds. All schemes end at the same parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    /// All readings and parameters at once.
    Batch,
    /// Configuration by configuration (IR663 paper, sec. 2.1.5).
    PoseByPose,
    /// Base and tool, then geometry, in turns (KR-270 paper, sec. III.A).
    Alternating,
}

impl Scheme {
    /// Most iterations where the user sets no limit. Batch and pose by pose converge quadratically and need fewer than 20;
    /// taking turns converges linearly, by a factor that comes close to 1 where base and geometry are nearly confounded. What
    /// a thousand turns do not reach (a factor above 0.98) has not converged, and is for the batch scheme.
    pub fn iterations(self) -> usize {
        match self {
            Self::Batch | Self::PoseByPose => 200,
            Self::Alternating => 1000,
        }
    }
}

/// Least and greatest scale of a robust loss, standard deviations. Below 0.5 most sound readings count as outliers (Huber's
/// loss comes to least absolute deviations, of 64 % efficiency); Tukey's below 1.547 would break down with fewer bad
/// readings than half and use under 29 % of the sound ones (Rousseeuw and Yohai 1984). Beyond 1000 all are plain squares.
const LOSS_SCALES: ([f64; 2], [f64; 2]) = ([0.5, 1e3], [1.547, 1e3]);

/// What is wrong with the scale of a robust loss, if anything.
///
/// ```
/// use elastogeo::{estimation::loss_fault, least_squares::Loss};
///
/// assert_eq!(loss_fault(Loss::Tukey(4.685)), None);
/// assert!(loss_fault(Loss::Huber(1e-300)).is_some());
/// ```
pub fn loss_fault(loss: Loss) -> Option<String> {
    let scale = loss.scale()?;
    let [least, greatest] = if matches!(loss, Loss::Tukey(_)) { LOSS_SCALES.1 } else { LOSS_SCALES.0 };
    let is_sound = (least..=greatest).contains(&scale);
    (!is_sound).then(|| format!("a robust loss with the scale {scale:?} is out of range: {least} to {greatest}"))
}

/// How readings are weighted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weights {
    /// By the campaign's stated noise (equally where none is stated).
    Stated,
    /// All coordinates alike (OLS).
    Equal,
    /// By the noise of each direction, estimated from the residuals of a first fit (WLS).
    Direction,
}

/// Which parameters are estimated next to base and tool.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct What {
    /// Geometry that the description frees.
    pub geometric: bool,
    /// Springs and beams that are declared identifiable.
    pub elastic: bool,
}

impl What {
    /// What a campaign's readings are made for: stiffness from deflections, geometry from all others (both, where it holds both), and springs too where the
    /// campaign names an effect of them under `calibrate:`.
    pub fn usual(model: &Model, campaign: &Campaign) -> Self {
        let of_springs = |name: &String| {
            let effect = model.catalogue.get(name)?;
            let sites = model.sites_with_constants(effect.as_ref());
            let mut own = sites.iter().flat_map(|site| effect.constants(model, site, &Nonlinear::default()));
            Some(own.any(|slot| model.registry[slot].group == Group::Elastic))
        };
        let usual = Self::of(campaign.observes);
        let named =
            || campaign.calibrate.iter().filter_map(of_springs).any(|is| is) && !model.elastic_slots().is_empty();
        Self { elastic: usual.elastic || campaign.holds_differences() || named(), ..usual }
    }

    /// What readings of a kind are made for.
    pub fn of(observes: Observes) -> Self {
        let elastic = observes.purpose() == Purpose::Stiffness;
        Self { geometric: !elastic, elastic }
    }
}

settings! {
    /// What is asked of a calibration.
    ///
    /// The defaults calibrate what the campaign was made for, by all readings at once, and suit every robot tried so far. What
    /// changes the question (which parameters, which readings count how much) is for the user; the limits of the iteration
    /// further down are for whoever studies the method.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Settings {
        /// Which parameters are estimated; what the readings are made for where `None`.
        pub what: Option<What> = None,
        /// Exactly these parameters next to base and tool, whatever [`Settings::what`] and the description.
        pub only: Option<Vec<Slot>> = None,
        /// Parameters to hold at their nominal values, by name.
        pub hold: Vec<String> = Vec::new(),
        /// How springs that act as one are split back into their members.
        pub split: Split = Split::default(),
        /// Fit the logarithms of springs: their values stay above 0, and their intervals are of factors. Batch scheme only.
        pub logarithms: bool = false,
        /// Scheme of the fit. The iterative schemes exist to compare with the papers; leave it at `Batch`.
        pub scheme: Scheme = Scheme::Batch,
        /// Weights of readings.
        pub weights: Weights = Weights::Stated,
        /// Robust loss, for campaigns with outliers; its own documentation gives the usual scales, within [`loss_fault`]'s
        /// limits. The scale counts standard deviations: the stated ones, or those that the median absolute deviation of a first
        /// robust fit's residuals shows where they are greater or none is stated.
        pub loss: Loss = Loss::Squares,
        /// Whether the tolerances of geometric parameters pull them towards their nominal values: for campaigns too small to
        /// determine them.
        pub prior: bool = false,
        /// Column scaling of the reduction.
        pub scaling: Scaling = Scaling::Norm,
        /// When a parameter that is not exactly dependent is dropped. The default keeps what the IR663 paper kept with its 27
        /// poses; a smaller value keeps parameters that noise decides.
        pub criterion: Criterion = Criterion::Relative(DEFAULT_TOLERANCE),
        /// Whether factors of merged parameters are those at the solution, and intervals count what dropped parameters do in
        /// second order: one linearisation for each dropped one. To be left out where nobody looks at intervals.
        pub second_order: bool = true,
        /// Whether springs that come out far from what is declared, though readings hardly tell them, are held as declared also where
        /// they end within their bounds. A diagnosis leaves that out: what it looks for is still in the residuals by which it is judged.
        pub hold_far_springs: bool = true,
        /// Most iterations; where `None`, [`Scheme::iterations`].
        pub max_iterations: Option<usize> = None,
        /// [`crate::least_squares::Settings::cost_tolerance`] of the fit. Deflections are hundreds of standard deviations: a
        /// relative change of the cost below 1e-12 is far less than a thousandth of a standard deviation of any parameter, and
        /// what remains to be followed is rounding of the model, not the data.
        pub cost_tolerance: f64 = 1e-12,
        /// The first guess of base, tool and markers.
        pub registration: RegistrationSettings = RegistrationSettings::default(),
        /// The search for a start of the springs.
        pub start: StartSettings = StartSettings::default(),
    }
}

impl Settings {
    /// Limits of every batch fit within a calibration.
    pub(super) fn least_squares(&self, rows: usize) -> least_squares::Settings {
        let max_iterations = self.max_iterations.unwrap_or(Scheme::Batch.iterations());
        let (loss, cost_tolerance) = (self.loss, self.cost_tolerance);
        let cost_floor = 0.5 * rows as f64 * PERFECT.powi(2);
        least_squares::Settings { max_iterations, loss, cost_tolerance, cost_floor, ..Default::default() }
    }
}

/// Residuals, in standard deviations of the readings, below which simulated readings without noise are fitted: what is left
/// is rounding, of which no step can be judged.
const PERFECT: f64 = 1e-9;

settings! {
    /// The first guess of base, tool and markers ([`crate::estimation`] fits them properly afterwards).
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct RegistrationSettings {
        /// Most readings that a trial looks at, spread evenly: several times the dozen unknowns.
        pub readings: usize = 60,
        /// Most iterations of a trial; a dozen bring a trial in the right valley to a fraction of the others' cost.
        pub iterations: usize = 15,
        /// Trials that are fitted to all readings to the end.
        pub finalists: usize = 4,
        /// Most trials. The first sets out from the description, the second from the rigid fit of measured positions; the others
        /// turn that every way, for readings that are no positions and tools that are far from their description.
        pub starts: usize = usize::MAX,
        /// Most iterations of the fit to all readings.
        pub last_iterations: usize = 500,
    }
}

settings! {
    /// The search for a start of the springs: deflections are nearly linear in compliances, but a spring parallel to a joint can
    /// hide the joint, and its rate and free length enter as a product.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct StartSettings {
        /// All springs are multiplied by the power of ten that fits best, up to this many decades on either side of the
        /// description: from plastic gears to steel blocks lie four.
        pub decades: i32 = 4,
        /// Free lengths that are tried for a spring between bodies, as parts of its mean length over the campaign: from strongly
        /// stretched to compressed.
        pub lengths: [f64; 4] = [0.3, 0.6, 0.9, 1.2],
        /// Most iterations of each trial fit. Trials are compared, not reported: those that need more are not near a minimum.
        pub max_iterations: usize = 30,
        /// Cost tolerance of each trial fit: one part in 1e9 of the cost does not change which trial is best.
        pub cost_tolerance: f64 = 1e-9,
    }
}
