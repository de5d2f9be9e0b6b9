//! Effects in a prediction: what each parameter of each switched-on effect adds to a reading, to first order.
//!
//! Columns are displacements (m) and rotations (rad) of the measured point, measurement frame.

use std::sync::Arc;

use nalgebra::{Point3, Rotation3, Vector3};

use super::measured_loads::MeasuredLoads;
use super::reading::ReadingAt;
use crate::description::campaign::{Campaign, Conditions, EARLIER_MOVES};
use crate::kinematics::shift;
use crate::model::{
    CarriedLoad, Change, Changes, Condition, Effect, EffectEntry, EffectParameter, Follower, Model, Nonlinear,
    ReadingContext, Site, SwitchedOn,
};
use crate::parameter::Slot;
use crate::state::{CarriedLoadPlan, CarriedLoads, JointLoadPlan, JointLoads, Mechanics, State};

/// An effect at a site with its nonlinear values, compiled for a model.
#[derive(Clone)]
pub struct Term {
    /// The effect.
    pub effect: Arc<dyn Effect>,
    /// Where it sits.
    pub site: Site,
    /// Its parameters.
    pub parameters: Vec<EffectParameter>,
    /// What one unit of each changes in a reading.
    changes: Changes,
    /// Time constant with which its site follows the thermometer, s.
    thermal_delay: Option<f64>,
}

impl std::fmt::Debug for Term {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}@{}", self.effect.name(), self.site.name)
    }
}

impl Term {
    /// Compiles an effect at a site.
    pub fn new(model: &Model, effect: &Arc<dyn Effect>, site: &Site, nonlinear: &Nonlinear) -> Self {
        Self {
            parameters: effect.parameters(model, site, nonlinear),
            changes: effect.changes(model, site, nonlinear),
            thermal_delay: effect.thermal_delay(nonlinear),
            effect: effect.clone(),
            site: site.clone(),
        }
    }
}

/// Temperature that a term reads.
#[derive(Debug, Clone)]
enum SiteTemperature {
    /// Of the surroundings.
    Surroundings,
    /// One of the temperatures of frames.
    Own(usize),
    /// By reading, as its site follows with a delay.
    Delayed(Vec<f64>),
}

impl SiteTemperature {
    fn new(term: &Term, frame: &str, conditions: &Conditions) -> Self {
        if let Some(delayed) = term.thermal_delay.and_then(|delay| conditions.delayed_temperatures(frame, delay)) {
            return Self::Delayed(delayed);
        }
        conditions.site_temperatures.get_index_of(frame).map_or(Self::Surroundings, Self::Own)
    }

    fn at(&self, conditions: &Conditions, index: usize) -> Option<f64> {
        let all = match self {
            Self::Delayed(all) => Some(all),
            Self::Own(site) => conditions.site_temperatures.get_index(*site).map(|(_, all)| all),
            Self::Surroundings => None,
        };
        all.or(conditions.temperature.as_ref()).and_then(|all| all.get(index)).copied()
    }
}

/// Terms compiled for a campaign; shared between threads.
#[derive(Debug, Clone)]
pub(super) struct Terms {
    /// The terms, in order; columns are theirs, one after the other.
    terms: Vec<Term>,
    /// Number of columns.
    pub columns: usize,
    /// First column of each term.
    first: Vec<usize>,
    loads: JointLoadPlan,
    carried: CarriedLoadPlan,
    measured: MeasuredLoads,
    /// Constants of the model that terms change in single readings.
    slots: Vec<Slot>,
    variables: usize,
    /// Joints that follow variables: coordinates after these.
    followers: Vec<Follower>,
    /// Whether some term depends on moves.
    looks_back: bool,
    /// By term: the temperature of its site.
    temperature: Vec<SiteTemperature>,
}

/// Workspace for one thread.
#[derive(Debug, Clone, Default)]
pub(super) struct TermWorkspace {
    loads: JointLoads,
    carried: CarriedLoads,
    /// By frame, measurement frame.
    bodies: Vec<CarriedLoad>,
    /// By coordinate.
    q: Vec<f64>,
    side: Vec<f64>,
    last_move: Vec<f64>,
    earlier_moves: Vec<f64>,
    changes: Vec<(usize, Change)>,
    /// Displacement and rotation of the reading by one unit of each column, measurement frame.
    pub columns: Vec<[f64; 6]>,
}

impl Terms {
    /// Compiles terms for the readings of a campaign.
    pub fn new(mechanics: &Mechanics, campaign: &Campaign, terms: Vec<Term>) -> Self {
        let model = mechanics.geometry.model;
        let first = terms.iter().scan(0, |sum, term| {
            let first = *sum;
            *sum += term.parameters.len();
            Some(first)
        });
        let first = first.collect();
        let columns = terms.iter().map(|term| term.parameters.len()).sum();
        let slots = slots_changed(model, &terms);
        let loads = JointLoadPlan::new(mechanics, measured_frames(model, campaign), &slots);
        let (variables, followers) = (model.variables.len(), model.followers());
        let temperature_of =
            |term: &Term| SiteTemperature::new(term, &model.frames[term.site.frame].name, &campaign.conditions);
        let temperature = terms.iter().map(temperature_of).collect();
        let measured = MeasuredLoads::new(model, campaign);
        let looks_back = terms.iter().any(|term| term.effect.reads().contains(&Condition::LastMove));
        Self {
            terms,
            columns,
            first,
            loads,
            carried: CarriedLoadPlan::new(mechanics),
            measured,
            slots,
            variables,
            followers,
            looks_back,
            temperature,
        }
    }

    /// Workspace for one thread.
    pub fn workspace(&self) -> TermWorkspace {
        let coordinates = self.variables + self.followers.len();
        TermWorkspace {
            loads: self.loads.loads(),
            carried: self.carried.loads(),
            bodies: Vec::new(),
            q: vec![0.0; coordinates],
            side: vec![0.0; coordinates],
            last_move: vec![0.0; coordinates],
            earlier_moves: vec![0.0; if self.looks_back { EARLIER_MOVES * coordinates } else { 0 }],
            changes: Vec::new(),
            columns: vec![[0.0; 6]; self.columns],
        }
    }

    /// What a configuration's readings share: motions of frames, own weight on the joints.
    pub fn place(&self, mechanics: &Mechanics, state: &mut State, out: &mut TermWorkspace) {
        self.loads.place(mechanics, state, &mut out.loads);
        self.carried.place(mechanics, state, &mut out.carried);
    }

    /// Columns of one reading, into `out.columns`.
    pub fn evaluate(&self, at: &ReadingAt, out: &mut TermWorkspace) {
        let is_difference = at.reading().observes.is_difference();
        self.carry(at, is_difference, &mut out.carried, &mut out.bodies);
        let TermWorkspace { loads, bodies, q, side, last_move, earlier_moves, changes, columns, .. } = out;
        self.loads.load(at.state, at.point, loads);
        let JointLoads { total, joint_rate, .. } = loads;
        self.measured.replace(at, total, joint_rate);
        let conditions = &at.campaign.conditions;
        self.fill(q, |variable| at.state.q[variable]);
        self.fill(side, |variable| conditions.sides(variable).map_or(0.0, |all| all[at.index]));
        // What follows several variables comes from the side to which their sides add up.
        side[self.variables..].iter_mut().filter(|side| **side != 0.0).for_each(|side| *side = side.signum());
        self.fill(last_move, |variable| known(conditions.last_move.get(variable), at.index));
        for (earlier, all) in earlier_moves.chunks_exact_mut(q.len().max(1)).zip(&conditions.earlier_moves) {
            self.fill(earlier, |variable| known(all.get(variable), at.index));
        }
        let session_time = conditions.session_time.as_ref().and_then(|all| all.get(at.index)).copied();
        let time = conditions.time.as_ref().map(|all| all[at.index]);
        let base = at.base();
        let position = (base * Point3::from(at.point.position)).coords;
        let up = base.rotation * -at.mechanics.geometry.model.structure.gravity.try_normalize(0.0).unwrap_or_default();
        let by_wrench = at.mechanics.deflection_by_wrench(at.state, at.point);
        columns.fill([0.0; 6]);
        for ((term, &first), temperature) in self.terms.iter().zip(&self.first).zip(&self.temperature) {
            if is_difference && term.effect.cancels_in_differences() {
                continue;
            }
            let context = ReadingContext {
                q,
                joints: &at.state.placements.joints,
                load: &loads.total,
                own_load: &loads.own,
                side,
                last_move,
                earlier_moves,
                time,
                session_time,
                order: conditions.rank.get(at.index).copied(),
                temperature: temperature.at(conditions, at.index),
                marker: at.campaign.readings[at.index].marker,
                position,
                base: base.translation.vector,
                body: (base.rotation * at.state.placements.frames[at.point.at.frame].rotation),
                up,
                carried: bodies,
                deflection: base.rotation * by_wrench.displacement,
                is_difference,
            };
            changes.clear();
            (term.changes)(&context, changes);
            for &(parameter, change) in changes.iter() {
                // Joints stand there whether loaded or not: both readings of a difference hold it.
                if is_difference && matches!(change, Change::Joint(..)) {
                    continue;
                }
                let twist = self.twist(at, loads, change);
                let column = &mut columns[first + parameter];
                (0..6).for_each(|k| column[k] += twist[k]);
            }
        }
    }

    /// What each body carries in a reading, and where it is.
    fn carry(&self, at: &ReadingAt, is_difference: bool, carried: &mut CarriedLoads, bodies: &mut Vec<CarriedLoad>) {
        self.carried.load(at.point, is_difference, carried);
        let base = at.base();
        bodies.clear();
        bodies.extend(at.state.placements.frames.iter().zip(&carried.total).map(|(frame, (load, carries_point))| {
            let [force, moment] = load;
            let origin = frame.translation.vector;
            let axes = frame.rotation.inverse();
            let (force, moment) = (axes * force, axes * (moment - origin.cross(force)));
            CarriedLoad {
                origin: (base * Point3::from(origin)).coords,
                axes: base.rotation * frame.rotation,
                wrench: [force.x, force.y, force.z, moment.x, moment.y, moment.z],
                carries_point: *carries_point,
            }
        }));
    }

    /// Values of all coordinates from those of the variables.
    fn fill(&self, out: &mut [f64], of_variable: impl Fn(usize) -> f64) {
        let (variables, followers) = out.split_at_mut(self.variables);
        variables.iter_mut().enumerate().for_each(|(variable, value)| *value = of_variable(variable));
        followers.iter_mut().zip(&self.followers).for_each(|(value, follower)| *value = follower.of(variables));
    }

    /// Displacement and rotation of a reading by a change.
    fn twist(&self, at: &ReadingAt, loads: &JointLoads, change: Change) -> [f64; 6] {
        let moved = loads.twists.of(at.point.at.frame);
        let (column, amount) = match change {
            Change::Joint(own, amount) | Change::Deflection(own, amount) => {
                (moved[own], amount / loads.joint_rate[own])
            }
            Change::Slot(slot, amount) => match self.slots.binary_search(&slot) {
                Ok(index) => (moved[self.variables + self.followers.len() + index], amount),
                Err(_) => return [0.0; 6],
            },
            Change::Point(moved, turned) => return [moved.x, moved.y, moved.z, turned.x, turned.y, turned.z],
        };
        let base = at.base().rotation;
        let arm = at.state.placements.frames[at.point.at.frame].rotation * at.point.at.point;
        let moved = base * shift(&column, &arm) * amount;
        let turned = base * Vector3::new(column[3], column[4], column[5]) * amount;
        [moved.x, moved.y, moved.z, turned.x, turned.y, turned.z]
    }
}

/// A condition of a reading; 0 where it is not known.
fn known(all: Option<&Vec<f64>>, index: usize) -> f64 {
    all.and_then(|all| all.get(index)).copied().filter(|value| value.is_finite()).unwrap_or(0.0)
}

/// Frames of the measured points, some twice.
pub(super) fn measured_frames(model: &Model, campaign: &Campaign) -> Vec<usize> {
    let frame = |marker: Option<usize>| marker.map_or(model.tool.0, |m| model.markers[m].frame);
    campaign.readings.iter().map(|reading| frame(reading.marker)).collect()
}

/// Effects that are switched on.
#[derive(Debug, Clone, Default)]
pub struct Declared {
    /// Those that are more than constants of the model.
    pub terms: Vec<Term>,
    /// For each parameter of each term, the slot of its amount; none where it is not given, which is zero.
    pub amounts: Vec<Option<Slot>>,
    /// By how much constants of the model are shifted.
    pub shifts: Vec<(Slot, f64)>,
}

/// Effects that the model has switched on.
pub fn declared(model: &Model) -> Declared {
    let mut declared = Declared::default();
    for SwitchedOn { entry: EffectEntry { effect, site, nonlinear, .. }, slots, shifts, .. } in &model.effects {
        if shifts.is_empty() {
            declared.terms.push(Term::new(model, effect, site, nonlinear));
            declared.amounts.extend(slots);
        }
        declared.shifts.extend(shifts);
    }
    declared
}

/// Amounts by their slots; zero where a parameter is not given.
pub(super) fn amounts_of(slots: &[Option<Slot>], values: &[f64]) -> Vec<f64> {
    slots.iter().map(|slot| slot.and_then(|slot| values.get(slot).copied()).unwrap_or_default()).collect()
}

/// Constants that terms change in single readings, from a reading in which everything is known.
fn slots_changed(model: &Model, terms: &[Term]) -> Vec<Slot> {
    let ones = vec![1.0; model.coordinates()];
    let joints = vec![0.1; model.frames.len()];
    let given = ReadingContext {
        q: &ones,
        joints: &joints,
        load: &ones,
        own_load: &ones,
        side: &ones,
        last_move: &ones,
        earlier_moves: &[],
        time: Some(1.0),
        session_time: Some(1.0),
        order: Some(1.0),
        temperature: Some(30.0),
        marker: None,
        position: Vector3::repeat(1.0),
        base: Vector3::zeros(),
        body: Rotation3::identity(),
        up: Vector3::z(),
        carried: &[],
        deflection: Vector3::repeat(1.0),
        is_difference: false,
    };
    let mut slots = Vec::new();
    let mut changes = Vec::new();
    for term in terms {
        changes.clear();
        (term.changes)(&given, &mut changes);
        slots.extend(changes.iter().filter_map(|(_, change)| match change {
            Change::Slot(slot, _) => Some(*slot),
            _ => None,
        }));
    }
    slots.sort_unstable();
    slots.dedup();
    slots
}
