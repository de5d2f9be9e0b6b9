//! What checks look at, and their limits.

use crate::description::campaign::Campaign;
use crate::estimation::Calibration;
use crate::model::Model;
use crate::parameter::Group;
use crate::settings::settings;

/// What a check may look at.
#[derive(Clone, Copy)]
pub struct Evidence<'a> {
    /// The robot.
    pub model: &'a Model,
    /// Its readings.
    pub campaign: &'a Campaign,
    /// What was fitted to them; `None` before anything is.
    pub found: Option<&'a Calibration>,
    /// Residuals of all readings with base, tool and markers fitted alone, where they are known already (as
    /// [`Calibration::registered`]).
    pub registered: Option<&'a [f64]>,
}

impl<'a> Evidence<'a> {
    /// A campaign before anything is fitted.
    pub fn of(model: &'a Model, campaign: &'a Campaign) -> Self {
        Self { model, campaign, found: None, registered: None }
    }

    /// A campaign and its calibration.
    pub fn with(model: &'a Model, campaign: &'a Campaign, found: &'a Calibration) -> Self {
        Self { model, campaign, found: Some(found), registered: Some(&found.registered) }
    }

    /// A calibration that fitted more than where things stand.
    pub fn calibrated(&self) -> Option<&'a Calibration> {
        self.found.filter(|found| {
            let mut groups = found.kept_slots().into_iter().map(|slot| self.model.registry[slot].group);
            groups.any(|group| matches!(group, Group::Geometry | Group::Elastic | Group::Effect))
        })
    }
}

settings! {
    /// Limits of the checks.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Limits {
        /// Farthest that base, tool or a marker may stand, m. Instruments of robot calibration (trackers, cameras, draw wires)
        /// reach less than 100 m; what a fit puts beyond that is a direction that ran away.
        pub farthest: f64 = 100.0,
        /// Registration may leave so many times what tolerances and noise make of a reading before other ways to read the files
        /// are tried. The sum over all constants is itself two or three times what registration leaves of a robot with such
        /// errors, because base and tool take part of them up.
        pub far: f64 = 3.0,
        /// Least error of a measured position, m: laser trackers state 10 um and more, and robots repeat to 5 um at best (ISO 9283 figures of
        /// their makers).
        pub finest: f64 = 2e-6,
        /// The error falls at least by this factor with a way to read the files that is named.
        pub fall: f64 = 4.0,
        /// What no way explains is refused beyond so many times what tolerances and noise allow, and
        pub hopeless: f64 = 10.0,
        /// beyond this share of the sum of the robot's lengths, or the spread of the readings over [`Limits::fall`]: smaller
        /// differences may be a poor description of the right robot. Beyond this share other ways to read the files are tried however
        /// wide the tolerances are.
        pub hopeless_share: f64 = 0.02,
        /// Readings on which ways are compared: several times the dozen unknowns of base and tool.
        pub readings: usize = 40,
        /// Least number of configurations among them.
        pub least_configurations: usize = 12,
        /// Greatest probability by chance alone at which something is said of the instrument; as a campaign is checked a few times,
        /// one in a thousand alarms by noise is tolerable.
        pub chance: f64 = 1e-3,
        /// Motion of fixed reflectors below so many times their scatter does not matter to a calibration.
        pub reference_motion: f64 = 1.0,
        /// Greatest motion of fixed reflectors, over a step of the readings, below which instrument and base did not make it: the mean
        /// lies between the places before and after, so that at least one of both is half the step away from it.
        pub reference_step: f64 = 0.5,
        /// Stated and shown noise may differ by this factor: repeats of a static reading leave out what differs over the workspace.
        pub shown_noise: f64 = 3.0,
        /// Arm at the end of which a rotation counts as a displacement, m: that of a tool.
        pub arm: f64 = 0.3,
        /// Half widths of its 95 % interval by which a value moved at least to count as moved: what is less is not determined.
        pub significant: f64 = 2.0,
        /// A constant that moved by more of its tolerances is warned of. Calibrated industrial arms move by up to 12 (a UR5's wrist);
        /// a tolerance is one standard deviation.
        pub moved: f64 = 20.0,
        /// A length that moved by more of its tolerances (100 mm where 1 mm is usual) is refused.
        pub moved_hopelessly: f64 = 100.0,
        /// An angle that moved further is refused, rad: no joint is mounted 30 degrees off.
        pub turned: f64 = std::f64::consts::FRAC_PI_6,
        /// All lengths together are off by at most so many standard deviations of their common factor, by the tolerances: beyond the first
        /// it is doubted (a tolerance of a known robot is seldom half of what it should be, and four standard deviations of that are no chance),
        /// beyond the second refused.
        pub scale: [f64; 2] = [4.0, 10.0],
        /// Estimated scale of an instrument from which it is doubted, and refused. A judgement: no unit is that near to another, and what an
        /// instrument is calibrated for is far below.
        pub instrument_scale: [f64; 2] = [1e-3, 1e-2],
        /// Least stiffness of an arm at its tool over the square of the sum of its lengths, N/m3. The bundled descriptions, from a
        /// small arm with a rail to a hexapod, have 4.8e3 to 7.4e5; a thousandth of most of them is below.
        pub softest: f64 = 100.0,
        /// Greatest stiffness of an arm at its tool over the sum L of its lengths, N/m2: a cantilever of solid steel, a fifth as thick as
        /// long, has 3 E I / L^4 = 5e7.
        pub stiffest: f64 = 5e7,
        /// Springs are within this factor of what is declared, by their median: units are wrong by 1000, guesses of the stiffness
        /// of a known kind of joint seldom by 30.
        pub stiffness_factor: f64 = 100.0,
        /// Least and greatest residuals over the stated noise. Instruments are stated up to five times too poor, or too good.
        pub noise: [f64; 2] = [0.2, 5.0],
        /// Displacement of a tool below which it may be the radius of a reflector or ball, m: those of laser trackers have 6.35 to 19.05 mm, some
        /// balls 25 mm.
        pub reflector: f64 = 0.03,
        /// Residuals over the stated noise from which a diagnosis doubts that statement, although it is the gap that it looks for: noise
        /// stated in rad for deg, or in m for mm, is 57 or 1000 times too small. A gap may be as great; then the doubt is needless.
        pub noise_wrong: f64 = 40.0,
        /// Median residual over the stated noise from which a calibration describes nothing: of measured arms one driven by cables leaves
        /// 36 times it, all others less than 20 times. A judgement.
        pub noise_hopeless: f64 = 60.0,
        /// Where every spring that the readings tell came out softer, or every one stiffer, by more than this factor, masses or stiffnesses are
        /// doubted. A judgement: single guesses are seldom off by 30 (see `stiffness_factor`), and not all to one side.
        pub all_springs: f64 = 10.0,
        /// Deflections are within this factor of those of the declared springs, by their median; beyond, units are doubted. Of springs
        /// that are guessed, all come out a few times too soft or too stiff together; between kgf and N, cm and mm lie ten.
        pub deflection_factor: f64 = 5.0,
        /// Factor from which springs fitted to deflections that are all off by about the same are doubted: wrenches may be in another unit. A judgement:
        /// joints that are declared without bearings and links come out softer together by less, and the units of force lie four and more apart.
        pub wrench_factor: f64 = 2.0,
        /// Standard deviation of the logarithm of the factor by which single springs differ from a common one: where all are off by more than
        /// [`Limits::deflection_factor`], and by the same to three times this, it is no coincidence of guesses.
        pub alike: f64 = 0.05,
        /// Degrees of freedom from which that is judged: the ratio is then known to 1/sqrt(2 n) = 16 %.
        pub noise_freedom: f64 = 20.0,
        /// Calibrated over registered errors of readings held out, beyond which it is reported and refused. Where there was nothing to
        /// calibrate, n residuals and p parameters leave sqrt(n / (n - p)): 1.1 for p = n / 6.
        pub worse: [f64; 2] = [1.1, 1.5],
        /// The same from which it is reported where more than the noise is left: nothing is better then, beyond what is rounded. A judgement.
        pub worse_open: f64 = 1.005,
        /// Configurations below which nothing is concluded: as many as [`crate::estimation::split`] needs to hold some out.
        pub fewest_configurations: usize = 8,
        /// Residuals for each fitted parameter below which errors of other readings are inflated by more than
        /// sqrt(1.5 / 0.5) = 1.7.
        pub rows_per_parameter: f64 = 1.5,
        /// What registration leaves falls at least by this factor where sessions with a base or tool of their own are suggested: a
        /// robot's own errors, differently sampled in each, are taken up by bases of their own to a lesser part.
        pub sessions_fall: f64 = 1.5,
        /// What calibration leaves falls at least by this factor where the other column of each joint is suggested. A judgement: a wrong
        /// column leaves more than twice the variance.
        pub joints_fall: f64 = 1.5,
        /// Such sessions are at least so many standard deviations of the noise apart.
        pub sessions_apart: f64 = 5.0,
        /// While readings that are simply wrong are sought before a calibration, those whose error is so many times the median are
        /// left out: normal errors of three coordinates reach 2.2 times it one in a thousand times, errors of geometry are bounded.
        pub trimmed: f64 = 5.0,
        /// A reading of n is called wrong whose error is so many times the median after calibration, times the cube root of n: errors of
        /// three coordinates with Student's t of three degrees of freedom go beyond that in one campaign of twenty
        /// (P(|x| > r) = 6.6 / r^3 of their norm x, whose median is 1.92). Normal noise reaches 3 times the median.
        pub outlying: f64 = 2.65,
        /// The same where the others are far above the noise too, and not by its cube root: what an unmodelled effect leaves is 15 times
        /// the median at a few configurations of the bundled campaigns.
        pub outlying_open: f64 = 30.0,
        /// Greatest share of the readings that can be wrong and the rest right: beyond it something else is the matter.
        pub wrong_share: f64 = 0.25,
        /// Least shared error that is spoken of, in standard deviations of the stated noise: simulated readings without noise
        /// leave rounding.
        pub shared_least: f64 = 1e-3,
        /// Greatest stated noise of an orientation that is believed, rad: directions at random are apart by pi / 2 in the mean, and the half
        /// of it hardly says more.
        pub loosest_angle: f64 = std::f64::consts::FRAC_PI_4,
        /// Greatest force on a tool that is believed, N: a hundred tons, as great presses have. The strongest industrial arms carry 2.3 t.
        pub force: f64 = 1e6,
        /// The same of robots with masses, in their own weights: arms carry at most a few times that.
        pub force_of_weight: f64 = 1e3,
    }
}
