//! The compiled robot: an immutable model, made of a resolved description.
//!
//! The model holds structure (tree, what moves each joint, loops, order of evaluation) and the parameter registry; it
//! holds no values but nominal ones. Values travel next to it as one vector by slot.

mod arrangement;
mod assemble;
mod beams;
mod bounds;
mod build;
mod builder;
mod coordinates;
mod effect;
mod fault;
mod free;
mod local_springs;
mod loops;
mod rewrite;
mod spanning;
mod structure;

pub use arrangement::Arrangement;
pub use bounds::contradictions;
pub use build::build;
pub use coordinates::Follower;
pub use effect::{
    CarriedLoad, Change, Changes, Condition, Driver, Family, Nonlinear, NonlinearKind, NonlinearParameter,
    NonlinearValue, ReadingContext, Site, SiteKind, Survey, all_springs, nuisance, usually_calibrated,
};
pub use fault::Fault;
pub use local_springs::LocalSprings;
pub use loops::{LoopGroup, LoopPlan, Stage};
pub use rewrite::{of_sessions, with_fuzzy, with_values};
pub use structure::{Boom, Edge, MassElement, Spot, Structure, Vertex};

use crate::description::fuzzy::Input;
use crate::description::parameters::Owner;
use crate::description::raw::JointKind;
use crate::description::robot::{FrameIndex, KeepOut, Motion, SumLimit, Variable};
use crate::parameter::{Group, Kind, Parameter, Registry, Slot};
use indexmap::IndexMap;
use nalgebra::Vector3;
use std::sync::Arc;

/// A compiled robot. Frames are in the order of [`crate::description::robot::Robot::frames`].
#[derive(Debug, Clone)]
pub struct Model {
    /// Display name.
    pub name: String,
    /// Actuated variables in the order of configuration vectors.
    pub variables: Vec<Variable>,
    /// Frames, each after its antecedent; the first is the base.
    pub frames: Vec<Frame>,
    /// Slider-cranks.
    pub actuators: Vec<Actuator>,
    /// Terms of each coupling.
    pub couplings: Vec<Vec<(f64, FrameIndex)>>,
    /// Of each coupling, whether it is the controller's ([`crate::description::robot::Coupling::is_of_controller`]).
    pub coupled_by_controller: Vec<bool>,
    /// Limits of sums of joints.
    pub limits: Vec<SumLimit>,
    /// Boxes through which no link may pass.
    pub keep_out: Vec<KeepOut>,
    /// Joints that are not driven by a variable of their own, in the order in which they can be evaluated.
    pub stages: Vec<Stage>,
    /// First of the six slots of the base's pose in the measurement frame.
    pub base: Slot,
    /// Frame of the tool centre point, and the first of its six slots.
    pub tool: (FrameIndex, Slot),
    /// Measured points.
    pub markers: Vec<Marker>,
    /// Fixed points in the measurement frame, m.
    pub anchors: IndexMap<String, Vector3<f64>>,
    /// Compliances, and what loads them.
    pub structure: Structure,
    /// Effects that can be switched on and that a diagnosis tries.
    pub catalogue: Arc<Catalogue>,
    /// Effects that have been switched on.
    pub effects: Vec<SwitchedOn>,
    /// What belongs to a campaign: sessions, anchors, contacts ([`Model::arranged`]).
    pub arrangement: Arrangement,
    /// Fuzzy compliance of the tool.
    pub fuzzy: Option<crate::description::fuzzy::Fuzzy>,
    /// Springs whose compliance depends on the configuration.
    pub local_springs: Option<LocalSprings>,
    /// All parameters.
    pub registry: Registry,
}

/// An effect that a description leaves out, and may switch on: where it can sit, which parameters it has, and what one
/// unit of each changes in a reading. It is linear in its parameters, which are zero where it is absent; to first order,
/// an effect of millimetres is predicted to a micrometre. Prediction, derivatives, diagnosis and simulation follow from
/// what it says here. The standard ones are in [`crate::effects`], one file each; `examples/own_effect.rs` adds another.
pub trait Effect: Send + Sync {
    /// Name in the catalogue and in descriptions.
    fn name(&self) -> &'static str;
    /// Where it can sit.
    fn sits_at(&self) -> SiteKind;
    /// What it looks like in the residuals, in words.
    fn signature(&self) -> &'static str;
    /// What to do on the machine.
    fn remedy(&self) -> &'static str;
    /// Its sites on a robot.
    fn sites(&self, model: &Model) -> Vec<Site> {
        model.sites(self.sits_at())
    }
    /// Whether at a site it is the measurement that is wrong, and not the robot: nothing that a command could correct.
    fn is_of_the_measurement(&self, site: &Site) -> bool {
        site.kind == SiteKind::Instrument
    }
    /// Whether it comes again in every session, where it goes with time: a robot that warms up does.
    fn recurs(&self) -> bool {
        false
    }
    /// Whether it is the same with and without an applied load, so that a difference of the two does not show it.
    fn cancels_in_differences(&self) -> bool {
        false
    }
    /// Name of the effect, at the same site, that it is from its end on: a joint that slipped stays where it is.
    fn remains(&self) -> Option<&'static str> {
        None
    }
    /// What kind of thing it is, with these nonlinear values; by default by what it reads and where it sits.
    fn family(&self, _nonlinear: &Nonlinear) -> Family {
        Family::by_default(self.reads(), self.sits_at())
    }
    /// Whether its parameters are the amounts of a free curve, each of which can be left out alone.
    fn is_free_form(&self) -> bool {
        false
    }
    /// Sites of which laws of its family are parts of it: its own, and of a curve those that it holds too.
    fn covers(&self, _model: &Model, site: &Site) -> Vec<String> {
        vec![site.name.clone()]
    }
    /// Whether it becomes a law of another effect at the least, and at the greatest, value of its continuous parameter that is
    /// tried: at such an end it can stand in for that one, whether the catalogue has it or not.
    fn is_another_at_ends(&self, _nonlinear: &Nonlinear) -> [bool; 2] {
        [false; 2]
    }
    /// By how much (rad, m) its joint moves until it repeats; `None` of what does not.
    fn period(&self, _nonlinear: &Nonlinear) -> Option<f64> {
        None
    }
    /// The nonlinear parameter whose value cannot go with a site, and what to write there; `None` where all can.
    fn misplaced(&self, _site: &Site, _nonlinear: &Nonlinear) -> Option<(&'static str, &'static str)> {
        None
    }
    /// Conditions of a reading that it depends on.
    fn reads(&self) -> &'static [Condition] {
        &[]
    }
    /// Its nonlinear parameters, in order: one that exists only with another comes after it.
    fn nonlinear_parameters(&self) -> Vec<&'static NonlinearParameter> {
        Vec::new()
    }
    /// Whether readings that span so much tell these nonlinear values from a curve of any shape; else a diagnosis does not try them.
    fn is_identifiable(&self, _site: &Site, _survey: &Survey, _nonlinear: &Nonlinear) -> bool {
        true
    }
    /// Nonlinear values that a diagnosis tries, given what the campaign offers; none where the effect cannot show. By
    /// default the one that has no nonlinear parameters.
    fn candidates(&self, _model: &Model, _site: &Site, _survey: &Survey) -> Vec<Nonlinear> {
        vec![Nonlinear::default()]
    }
    /// Parameters of the model that it shifts, where it is nothing but constants off nominal.
    fn constants(&self, _model: &Model, _site: &Site, _nonlinear: &Nonlinear) -> Vec<Slot> {
        Vec::new()
    }
    /// Its parameters; by default its [`Effect::constants`].
    fn parameters(&self, model: &Model, site: &Site, nonlinear: &Nonlinear) -> Vec<EffectParameter> {
        model.shifts_of(&self.constants(model, site, nonlinear))
    }
    /// Times its common size that an amount may be at most, for a diagnosis to name it; `None` where the setting for all effects holds.
    fn greatest_amount(&self) -> Option<f64> {
        None
    }
    /// Of an effect that changes the compliance of its joint: by how much one unit of each parameter does where the joints of the frames stand so.
    fn compliance(&self, _site: &Site, _nonlinear: &Nonlinear, _joints: &[f64]) -> Option<Vec<f64>> {
        None
    }
    /// Time constant (s) with which its site follows the thermometer; `None` where it follows at once.
    fn thermal_delay(&self, _nonlinear: &Nonlinear) -> Option<f64> {
        None
    }
    /// What one unit of each parameter changes in a reading; by default nothing.
    fn changes(&self, _model: &Model, _site: &Site, _nonlinear: &Nonlinear) -> Changes {
        Arc::new(|_, _| {})
    }
}

impl Model {
    /// Parameters of an effect that is nothing but constants of the model: their shifts.
    pub fn shifts_of(&self, constants: &[Slot]) -> Vec<EffectParameter> {
        let of = |parameter: &Parameter| EffectParameter {
            is_positive: parameter.bounds[0] == 0.0,
            ..EffectParameter::new(&parameter.name, parameter.kind.unit(), parameter.tolerance)
        };
        constants.iter().map(|&slot| of(&self.registry[slot])).collect()
    }
}

impl std::fmt::Debug for dyn Effect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// A parameter of an effect; zero is absent.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectParameter {
    /// Symbol.
    pub symbol: String,
    /// SI unit.
    pub unit: &'static str,
    /// Common size, one sigma, SI.
    pub scale: f64,
    /// Whether it cannot be negative.
    pub is_positive: bool,
}

impl EffectParameter {
    /// One that can have either sign.
    pub fn new(symbol: impl Into<String>, unit: &'static str, scale: f64) -> Self {
        Self { symbol: symbol.into(), unit, scale, is_positive: false }
    }

    /// The same, where it cannot be negative.
    #[must_use]
    pub fn positive(self) -> Self {
        Self { is_positive: true, ..self }
    }
}

/// The effects of a model: those that its description may switch on and a diagnosis tries. The standard ones are
/// `Catalogue::standard()`.
#[derive(Debug, Clone, Default)]
pub struct Catalogue(Vec<Arc<dyn Effect>>);

impl Catalogue {
    /// These effects, in the order in which they are listed.
    pub fn new(effects: Vec<Arc<dyn Effect>>) -> Self {
        Self(effects)
    }

    /// The same with another effect, which replaces one of its name.
    #[must_use]
    pub fn with(mut self, effect: impl Effect + 'static) -> Self {
        self.0.retain(|known| known.name() != effect.name());
        self.0.push(Arc::new(effect));
        self
    }

    /// An effect by its name.
    pub fn get(&self, name: &str) -> Option<&Arc<dyn Effect>> {
        self.iter().find(|effect| effect.name() == name)
    }

    /// All effects, in order.
    pub fn iter(&self) -> impl Iterator<Item = &Arc<dyn Effect>> {
        self.0.iter()
    }

    /// Their names, in order.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.0.iter().map(|effect| effect.name())
    }
}

/// An effect at a site with its nonlinear values and its amounts: an entry of `effects:`, resolved.
#[derive(Debug, Clone)]
pub struct EffectEntry {
    /// The effect.
    pub effect: Arc<dyn Effect>,
    /// Where it sits.
    pub site: Site,
    /// Values of its nonlinear parameters.
    pub nonlinear: Nonlinear,
    /// Amounts by the symbols of its parameters, SI; one that is not given is zero.
    pub amounts: IndexMap<String, f64>,
}

impl std::fmt::Display for EffectEntry {
    /// `effect@site`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}@{}", self.effect.name(), self.site.name)
    }
}

/// An effect that has been switched on.
#[derive(Debug, Clone)]
pub struct SwitchedOn {
    /// The effect, its site, nonlinear values and amounts.
    pub entry: EffectEntry,
    /// Its parameters.
    pub parameters: Vec<EffectParameter>,
    /// Slot of each parameter's amount, `effect@site.symbol` in the registry; none where no amount is given, which is
    /// zero. Empty for an effect that shifts constants of the model.
    pub slots: Vec<Option<Slot>>,
    /// By how much it shifts constants of the model, SI.
    pub shifts: Vec<(Slot, f64)>,
}

/// A frame of the model.
#[derive(Debug, Clone)]
pub struct Frame {
    /// Name.
    pub name: String,
    /// The frame it is placed in.
    pub antecedent: FrameIndex,
    /// Kind of joint.
    pub joint: JointKind,
    /// What moves it.
    pub motion: Motion,
    /// Slots of beta, gamma, b, alpha, d, theta, r; the first five may be shared with a coaxial frame.
    pub slots: [Slot; 7],
    /// Declared constant of the moving coordinate (theta or r): its parameter's value less this is the joint's zero.
    pub home: f64,
    /// Limits of the joint variable.
    pub limits: Option<[f64; 2]>,
}

/// Positions of beta and alpha in [`Frame::slots`].
pub const TILTS: [usize; 2] = [0, 3];
/// Position of theta in [`Frame::slots`].
pub const THETA: usize = 5;
/// Position of r in [`Frame::slots`].
pub const R: usize = 6;

impl Frame {
    /// Slot of the coordinate that moves: theta, or r of a prismatic joint.
    pub fn moving_slot(&self) -> Slot {
        self.slots[if self.joint == JointKind::Prismatic { R } else { THETA }]
    }

    /// Whether the frame moves in its antecedent.
    pub fn moves(&self) -> bool {
        self.joint != JointKind::Fixed
    }
}

/// A slider-crank: the joint it turns, its variable, and the first of its slots (stroke, kappa, lambda, l1, l3).
#[derive(Debug, Clone)]
pub struct Actuator {
    /// Name.
    pub name: String,
    /// Joint turned.
    pub joint: FrameIndex,
    /// Variable.
    pub variable: usize,
    /// First slot.
    pub slot: Slot,
}

/// A measured point: its frame and the first of its three slots.
#[derive(Debug, Clone)]
pub struct Marker {
    /// Name.
    pub name: String,
    /// Frame.
    pub frame: FrameIndex,
    /// First slot.
    pub slot: Slot,
}

impl Model {
    /// Frames from the first after the base to `frame`.
    pub fn path(&self, frame: FrameIndex) -> Vec<FrameIndex> {
        let mut path = Vec::new();
        let mut index = frame;
        while index != 0 {
            path.push(index);
            index = self.frames[index].antecedent;
        }
        path.reverse();
        path
    }

    /// Frame by name.
    pub fn frame(&self, name: &str) -> Option<FrameIndex> {
        self.frames.iter().position(|frame| frame.name == name)
    }

    /// Marker by name.
    ///
    /// ```
    /// let model = elastogeo::files::load_robot("kuka-kr270")?.model;
    /// assert_eq!((model.marker("m2"), model.marker("m9")), (Some(1), None));
    /// # Ok::<(), elastogeo::Error>(())
    /// ```
    pub fn marker(&self, name: &str) -> Option<usize> {
        self.markers.iter().position(|marker| marker.name == name)
    }

    /// Whether rules stand in the place of what springs and beams give.
    pub fn is_by_rules(&self) -> bool {
        self.fuzzy.as_ref().is_some_and(|fuzzy| !fuzzy.adds)
    }

    /// Name of what a compliance depends on, and whether it is an angle.
    pub fn input(&self, of: Input) -> (&str, bool) {
        match of {
            Input::Variable(k) => (&self.variables[k].name, self.variables[k].is_angle),
            Input::Joint(k) => (&self.frames[k].name, self.frames[k].joint == JointKind::Revolute),
        }
    }

    /// The compliance of a joint along or about its axis, m/N or rad/(N.m); `None` where the description gives it none.
    pub fn axial_compliance(&self, frame: &Frame) -> Option<Slot> {
        let symbol = if frame.joint == JointKind::Prismatic { "ka" } else { "kar" };
        self.registry.slot(&Owner::Joint(&frame.name).parameter(symbol))
    }

    /// How far the robot reaches at most, m: its lengths and strokes together; infinite where it has none of both.
    pub fn reach(&self) -> f64 {
        let slides = self.variables.iter().filter(|variable| !variable.is_angle).filter_map(|variable| variable.limits);
        let strokes: f64 = slides.map(|[low, high]| high - low).sum();
        let mut slots: Vec<Slot> = self.frames.iter().flat_map(|frame| frame.slots).collect();
        slots.sort_unstable();
        slots.dedup();
        let own = slots.into_iter().map(|slot| &self.registry[slot]);
        let lengths = own.filter(|own| own.kind == Kind::Length && own.group == Group::Geometry);
        let all = lengths.map(|own| own.nominal.abs()).sum::<f64>() + strokes;
        if all > 0.0 { all } else { f64::INFINITY }
    }

    /// Middle of the limits of each variable, zero where it has none.
    pub fn middle(&self) -> Vec<f64> {
        let middle =
            |limits: [f64; 2]| if limits.iter().all(|l| l.is_finite()) { 0.5 * (limits[0] + limits[1]) } else { 0.0 };
        self.variables.iter().map(|variable| variable.limits.map_or(0.0, middle)).collect()
    }

    /// Values of this model from those of the model before effects were switched on.
    #[must_use]
    pub fn completed(&self, values: &[f64]) -> Vec<f64> {
        let added = self.registry.all().iter().skip(values.len()).map(|parameter| parameter.nominal);
        values.iter().copied().chain(added).collect()
    }

    /// Values with the constants shifted by the effects that are nothing but such shifts: those at which the structure deflects.
    #[must_use]
    pub fn shifted(&self, values: &[f64]) -> Vec<f64> {
        let mut shifted = values.to_vec();
        for (slot, amount) in self.effects.iter().flat_map(|on| &on.shifts) {
            if let Some(value) = shifted.get_mut(*slot) {
                *value += amount;
            }
        }
        shifted
    }

    /// Slots of the geometry that the description's rule frees.
    ///
    /// ```
    /// let model = elastogeo::files::load_robot("kuka-ir663")?.model;
    /// assert_eq!(model.free_slots().len(), 43); // as the IR663 paper counts them
    /// # Ok::<(), elastogeo::Error>(())
    /// ```
    pub fn free_slots(&self) -> Vec<Slot> {
        self.free_where(|group| group != Group::Elastic)
    }

    /// Slots of what gives and what loads it that the description declares identifiable.
    pub fn elastic_slots(&self) -> Vec<Slot> {
        self.free_where(|group| group == Group::Elastic)
    }

    fn free_where(&self, of: impl Fn(Group) -> bool) -> Vec<Slot> {
        let all = self.registry.all().iter().enumerate();
        all.filter(|(_, parameter)| parameter.free && of(parameter.group)).map(|(slot, _)| slot).collect()
    }
}
