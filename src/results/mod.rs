//! What each command finds: plain `Serialize` structs with names and units, made once from what the library computes.
//!
//! Text, HTML and JSON render the same value. JSON is the struct as it stands: field names are keys, in their order.
//! `None` is null; no number stands for "none". What only text needs is not serialized.

mod against;
mod blind;
mod campaign;
mod certificate;
mod combinations;
mod compensation;
mod compensator;
mod configurations;
mod counts;
mod diagnosis;
mod errors;
mod faces;
mod fitted;
mod fuzzy;
mod identifiability;
mod identification;
mod own_weight;
mod parts;
mod place;
mod plan;
mod pose;
mod report;
mod residuals;
mod robot;
mod simulation;
mod since;
mod solve;
mod springs;
mod stiffness;
mod track;
pub mod units;
mod variation;
mod view;

pub use against::{AgainstOther, Before, Closer, Difference, SetErrors};
pub use blind::{BlindScore, LeftOut, ScoredCampaign};
pub use campaign::{
    AppliedLoads, CampaignCheck, InstrumentNoise, JointRange, NoiseFigure, ReferenceMotion, Sets, StatedNoise,
    ToEstimate,
};
pub use certificate::{Certificate, CertifiedErrors, CertifiedInstrument, CertifiedPose, CertifiedReading, Verdict};
pub use combinations::{CombinedParameter, CombinedParameters};
pub use compensation::{
    CompensatedPoint, Compensation, CorrectedPoint, Deviation, Distances, PointStatus, RefusedPoint, StripAt, StripLeft,
};
pub use compensator::{
    BothWays, Compensator, CompensatorWay, CompliancePoint, CompliancePoints, Estimated, LawMisfit, OtherCompliance,
    WithUnit,
};
pub use configurations::ConfigurationResidual;
pub use counts::{PartCount, ReadingOrder};
pub use diagnosis::{
    AfterAll, Cause, Diagnosis, Directions, Gap, Location, NextPose, Noise, NoiseFrom, Notes, Refitted, Region,
    Rejected, ShownNoise,
};
pub use errors::{CoordinateErrors, FitOrCheck, OrientationErrors, ReadingErrors};
pub use fitted::FittedReport;
pub use fuzzy::{
    AfterFit, ComponentRules, Condition, CrossValidated, FuzzyCompliance, Gain, GreyCompliance, GrowthStep, LoadLevel,
    LocalSpringsFound, MethodComparison, MethodErrors, MethodRow, RigidErrors, RuleBranch, RuleInput, RuleSplit, Timed,
};
pub use identifiability::{
    Dropped, ElasticSensitivity, MeanMax, Merged, Observability, ParameterSensitivity, Reduction, Sensitivities,
};
pub use identification::{
    Identification, NoiseSources, ParameterEstimate, PredictedError, Residuals, SchemeComparison, WeightSource,
};
pub use own_weight::OwnWeight;
pub use parts::{PartErrors, WorstReading};
pub use place::{Deflections, PlacedPoint, Placement, WorkpieceMove};
pub use plan::{Bought, ParameterWidth, Plan, PlannedError, PlannedPose, PlannedReading};
pub use pose::{Homogeneous, Pose, Poses};
pub use report::{
    CampaignSummary, ReadingReview, Report, SliceNode, SliceUnits, Sources, StageLabel, StepKey, StiffnessReview,
    StiffnessSlice, Swept, WaterfallStep, stage_label,
};
pub use residuals::{DescriptionResiduals, ReadingResidual};
pub use robot::{
    BodySummary, ElasticSummary, FrameSummary, FuzzySummary, ParameterSummary, RobotSummary, SnapshotAgreement,
    VariableSummary,
};
pub use simulation::{PathPoint, Simulation, TrueParameter, Truth};
pub use since::{MovedParameter, Since};
pub use solve::{InverseSolution, InverseSolutions};
pub use springs::SpringGroup;
pub use stiffness::Stiffness;
pub use track::{
    About, Track, TrackedChange, TrackedCheck, TrackedCourse, TrackedEvent, TrackedNext, TrackedParameter, TrackedValue,
};
pub use variation::{PathDeviations, Variation, Varied};
pub use view::{ToolDeflection, View};
