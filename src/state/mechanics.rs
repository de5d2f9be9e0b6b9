//! Kinematics and elastics of a model with one vector of values, and their state at one configuration.

use nalgebra::{Matrix6, Vector3, Vector6};

use super::frame_twists::{FrameTwistPlan, FrameTwists};
use crate::description::campaign::{InSession, LoadPoint, Payload, Reading};
use crate::description::robot::FrameIndex;
use crate::elastics::{
    ElasticColumns, Elastics, Load, LoadCase, Mechanism, MotionWorkspace, Response, Shares, Statics, at_point,
    put_fuzzy, shares, spatial, twists,
};
use crate::elements::{BodyPoint, Motion, VertexIndex};
use crate::kinematics::{AssemblyError, By, Geometry, Placements, Rates};
use crate::model::Model;
use crate::observation::Twist;
use crate::parameter::Slot;

/// A model with one vector of values; immutable, shared between threads.
#[derive(Debug, Clone)]
pub struct Mechanics<'m> {
    /// Placement of the frames.
    pub geometry: Geometry<'m>,
    elastics: Elastics<'m>,
    columns: ElasticColumns,
    pattern: Rates,
    /// Loaded vertices, and which of them each marker (last: the tool centre point) hangs on.
    vertices: Vec<VertexIndex>,
    ports: Vec<usize>,
    weight: bool,
    /// Whether anything deflects at all.
    deflects: bool,
}

/// What loads the structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Loads {
    /// Own weight and preloads count, in readings that are absolute.
    pub weight: bool,
    /// Wrenches may be applied.
    pub wrench: bool,
}

/// Why a configuration cannot be placed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StateError {
    /// A loop or actuator cannot close.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// The structure can move without force.
    #[error(transparent)]
    Mechanism(#[from] Mechanism),
}

/// The state of one configuration, for one thread. Reused between configurations: nothing is allocated after the first.
#[derive(Debug, Clone)]
pub struct State {
    /// Actuated variables, rad or m.
    pub q: Vec<f64>,
    /// Frames and joints, nothing deflected.
    pub placements: Placements,
    rates: Rates,
    has_rates: bool,
    statics: Statics,
    responses: Vec<Response>,
    motions: Vec<MotionWorkspace>,
    has_motions: bool,
    /// Changes of the sag under own weight alone, by loaded vertex and number of the motion.
    sag_changes: Vec<Vec<Option<Vector6<f64>>>>,
    elastic_twists: Vec<Vector6<f64>>,
}

/// A marker or the tool centre point under a wrench, at a placed configuration, base axes.
#[derive(Debug, Clone, Copy)]
pub struct LoadedPoint {
    /// The marker; none is the tool centre point.
    pub marker: Option<usize>,
    /// Whose base and tool it has.
    pub session: InSession,
    /// The point in its frame.
    pub at: BodyPoint,
    /// Its position with nothing deflected, m.
    pub position: Vector3<f64>,
    /// N.
    pub force: Vector3<f64>,
    /// N.m.
    pub moment: Vector3<f64>,
    /// Of the force, what acts elsewhere, N, and where from the point, m: the weight that the tool carries, the applied force.
    carried: [(Vector3<f64>, Vector3<f64>); 2],
    port: usize,
    /// Own weight counts in the reading: it is absolute.
    weight: bool,
}

impl LoadedPoint {
    fn wrench(&self) -> Vector6<f64> {
        spatial(&self.position, &self.force, &self.moment)
    }

    /// Force (N) and moment (N.m) that act at the point itself, and not elsewhere on its body.
    pub fn here(&self) -> (Vector3<f64>, Vector3<f64>) {
        let carried = self.carried.iter();
        carried.fold((self.force, self.moment), |(force, moment), (own, arm)| (force - own, moment - arm.cross(own)))
    }

    /// Forces (N) that act elsewhere on its body, and where (m, base frame, nothing deflected).
    pub fn elsewhere(&self) -> [(Vector3<f64>, Vector3<f64>); 2] {
        self.carried.map(|(force, arm)| (force, self.position + arm))
    }
}

/// A measured point: a marker (none: the tool centre point), as it is mounted in a session.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PointOf {
    /// The marker.
    pub marker: Option<usize>,
    /// The session.
    pub session: InSession,
    /// What the tool carries.
    pub payload: Option<Payload>,
    /// Where the wrench is applied.
    pub load_point: LoadPoint,
    /// Whether it is read with load less without it: own weight and preloads drop out.
    pub is_difference: bool,
}

impl From<Option<usize>> for PointOf {
    fn from(marker: Option<usize>) -> Self {
        Self { marker, ..Self::default() }
    }
}

impl From<&Reading> for PointOf {
    fn from(reading: &Reading) -> Self {
        let Reading { marker, session, payload, load_point, observes, .. } = *reading;
        Self { marker, session, payload, load_point, is_difference: observes.is_difference() }
    }
}

/// A motion of the frames by one column of [`FrameTwists`] of all frames.
#[derive(Debug, Clone, Copy)]
pub struct ColumnMotion<'a> {
    /// The twists.
    pub twists: &'a FrameTwists,
    /// Which column of them.
    pub column: usize,
    /// The parameter that moves them; none for a variable.
    pub by: Option<Slot>,
    /// As [`Rates::rate`] counts what moves the joints.
    pub driver: Option<usize>,
}

impl<'m> Mechanics<'m> {
    /// Puts `values` (all slots, SI) into the model; `elastic` are the parameters by which deflections are differentiated.
    ///
    /// # Errors
    /// The loops cannot be assembled with these values.
    pub fn new(model: &'m Model, values: &[f64], loads: Loads, elastic: &[Slot]) -> Result<Self, AssemblyError> {
        let geometry = Geometry::new(model, values)?;
        let elastics = Elastics::new(model, values, elastic);
        let by_wrench = loads.wrench && (model.fuzzy.is_some() || elastics.is_compliant());
        let deflects = by_wrench || loads.weight && elastics.is_compliant() && elastics.is_loaded();
        let mut vertices: Vec<VertexIndex> = Vec::new();
        let mut port = |frame: FrameIndex, local: Vector3<f64>| {
            let vertex = model.structure.carrier(frame, &local);
            vertices.iter().position(|known| *known == vertex).unwrap_or_else(|| {
                vertices.push(vertex);
                vertices.len() - 1
            })
        };
        let markers = model.markers.iter().enumerate();
        let mut ports: Vec<usize> =
            markers.map(|(index, marker)| port(marker.frame, geometry.marker(index).coords)).collect();
        ports.push(port(model.tool.0, geometry.tool().translation.vector));
        let columns = ElasticColumns::new(&elastics, elastic);
        let pattern = Rates::new(model);
        Ok(Self { geometry, elastics, columns, pattern, vertices, ports, weight: loads.weight, deflects })
    }

    /// Workspace for one thread.
    pub fn state(&self) -> State {
        State {
            q: Vec::with_capacity(self.geometry.model.variables.len()),
            placements: Placements::default(),
            rates: self.pattern.clone(),
            has_rates: false,
            statics: Statics::new(self.weight),
            responses: self.vertices.iter().map(|&vertex| Response::new(&self.elastics, vertex)).collect(),
            motions: vec![MotionWorkspace::default(); self.vertices.len()],
            has_motions: false,
            sag_changes: vec![Vec::new(); self.vertices.len()],
            elastic_twists: vec![Vector6::zeros(); self.columns.columns],
        }
    }

    /// Whether anything deflects.
    pub fn deflects(&self) -> bool {
        self.deflects
    }

    /// Plan of how frames move with variables and parameters.
    pub fn twist_plan(&self, frames: Vec<FrameIndex>, by: &[By]) -> FrameTwistPlan {
        FrameTwistPlan::new(&self.geometry, &self.pattern, frames, by)
    }

    /// Index of a parameter among what moves joints, as [`Rates::driver`].
    pub fn driver(&self, slot: Slot) -> Option<usize> {
        self.pattern.driver(slot)
    }

    /// Places the frames for the variables `q` (rad and m), and prepares the statics.
    ///
    /// # Errors
    /// What cannot be assembled, or can move without force.
    pub fn place(&self, q: &[f64], state: &mut State) -> Result<(), StateError> {
        self.place_by(&self.geometry, q, state)
    }

    /// As [`Mechanics::place`], with frames placed by other values than those of the structure.
    ///
    /// # Errors
    /// As [`Mechanics::place`].
    pub fn place_by(&self, geometry: &Geometry, q: &[f64], state: &mut State) -> Result<(), StateError> {
        state.q.clear();
        state.q.extend_from_slice(q);
        (state.has_rates, state.has_motions) = (false, false);
        geometry.place(q, &mut state.placements)?;
        if self.deflects {
            self.elastics.prepare(&state.placements, &mut state.statics)?;
            for response in &mut state.responses {
                response.evaluate(&self.elastics, &mut state.statics);
                put_fuzzy(geometry, &state.placements, response);
            }
        }
        Ok(())
    }

    /// How joints move with the variables and parameters at the placed configuration, [`State::rates`].
    pub fn evaluate_rates(&self, state: &mut State) {
        if !state.has_rates {
            state.rates.evaluate(&self.geometry, &state.q, &state.placements);
            state.has_rates = true;
        }
    }

    /// How frames (`only` one of them, or all that were planned) move at the placed configuration.
    pub fn evaluate_twists(
        &self,
        state: &mut State,
        plan: &FrameTwistPlan,
        only: Option<FrameIndex>,
        out: &mut FrameTwists,
    ) {
        if plan.needs_rates(only) {
            self.evaluate_rates(state);
        }
        plan.evaluate(&self.geometry, &state.placements, &state.rates, only, out);
    }

    /// A marker (none: the tool centre point) at the placed configuration under a wrench (N and N.m, base axes).
    pub fn point(&self, state: &State, of: impl Into<PointOf>, wrench: &[f64; 6]) -> LoadedPoint {
        let PointOf { marker, session, payload, load_point, is_difference } = of.into();
        let model = self.geometry.model;
        let of_marker = |marker: Option<usize>| {
            let frame = marker.map_or(model.tool.0, |marker| model.markers[marker].frame);
            BodyPoint { frame, point: self.geometry.point(model.point_slot(marker, session)).coords }
        };
        let at = of_marker(marker);
        let position = at.place(&state.placements.frames);
        let (mut force, mut moment) =
            (Vector3::new(wrench[0], wrench[1], wrench[2]), Vector3::new(wrench[3], wrench[4], wrench[5]));
        let mut carried = [(Vector3::zeros(), Vector3::zeros()); 2];
        let applied = match load_point {
            LoadPoint::Measured => None,
            LoadPoint::Marker(marker) => Some(of_marker(marker)),
            LoadPoint::Frame(frame) => Some(BodyPoint { frame, point: Vector3::zeros() }),
        };
        if let Some(applied) = applied {
            let arm = applied.place(&state.placements.frames) - position;
            carried[1] = (force, arm);
            moment += arm.cross(&force);
        }
        if let Some(Payload { mass, com, frame }) = payload {
            let weight = mass * model.structure.gravity;
            let arm = BodyPoint { frame, point: com }.place(&state.placements.frames) - position;
            force += weight;
            moment += arm.cross(&weight);
            carried[0] = (weight, arm);
        }
        LoadedPoint {
            marker,
            session,
            at,
            position,
            force,
            moment,
            carried,
            port: self.ports[marker.unwrap_or(self.ports.len() - 1)],
            weight: self.weight && !is_difference,
        }
    }

    /// Displacement and rotation of a point by its wrench, own weight included where it counts.
    pub fn deflection(&self, state: &State, point: &LoadedPoint) -> Twist {
        self.deflection_under(state, point, point.weight && state.statics.is_loaded())
    }

    /// The same by the wrench alone.
    pub fn deflection_by_wrench(&self, state: &State, point: &LoadedPoint) -> Twist {
        self.deflection_under(state, point, false)
    }

    fn deflection_under(&self, state: &State, point: &LoadedPoint, weight: bool) -> Twist {
        if !self.deflects {
            return Twist::zero();
        }
        let twist = state.responses[point.port].twist(&point.wrench(), weight);
        twist_at(&twist, &point.position)
    }

    /// Displacement and rotation of a point by force and moment there.
    pub fn compliance(&self, state: &State, point: &LoadedPoint) -> Matrix6<f64> {
        if self.deflects { state.responses[point.port].compliance_at(&point.position) } else { Matrix6::zeros() }
    }

    /// What each element contributes to a point's deflection, own weight included where it counts.
    pub fn shares(&self, state: &State, point: &LoadedPoint) -> Shares {
        shares(&self.elastics, &state.statics, &state.responses[point.port], &point.wrench(), point.weight)
    }

    /// Spatial twist of every vertex of the structure by a point's wrench, own weight included where it counts.
    pub fn vertex_twists(&self, state: &State, point: &LoadedPoint) -> Vec<Vector6<f64>> {
        twists(&self.elastics, &state.statics, &state.responses[point.port], &point.wrench(), point.weight)
    }

    /// Change of a point's deflection when the point is displaced by `moved` (m) and the frames move by `motion` (none:
    /// stand still).
    pub fn deflection_by_motion(
        &self,
        state: &mut State,
        point: &LoadedPoint,
        moved: &Vector3<f64>,
        motion: Option<ColumnMotion>,
    ) -> Twist {
        let load = Load { wrench: point.wrench(), weight: point.weight };
        let mut change = Vector6::zeros();
        // What rules say of the tool's compliance does not depend on the frames in a way known here.
        if let Some(motion) = motion.filter(|_| !self.geometry.model.is_by_rules()) {
            self.gather_motions(state);
            let known = state.sag_changes[point.port].get(motion.column).copied().flatten();
            change = match known.filter(|_| is_sag(&load)) {
                Some(known) => known,
                None => self.by_motion(state, point.port, load, &motion),
            };
        }
        let response = &state.responses[point.port];
        // What acts elsewhere on the tool turns with its body, and stays where the point alone moves in it.
        let turn = motion.map(|motion| {
            let column = motion.twists.of(point.at.frame)[motion.column];
            Vector3::new(column[3], column[4], column[5])
        });
        let swung = |arm: &Vector3<f64>| turn.map_or(-moved, |turn| turn.cross(arm));
        let elsewhere: Vector3<f64> = point.carried.iter().map(|(force, arm)| swung(arm).cross(force)).sum();
        let turned = moved.cross(&point.force) + elsewhere;
        change += response.compliance * spatial(&Vector3::zeros(), &Vector3::zeros(), &turned);
        let turn = self.deflection(state, point).rotation;
        let change = twist_at(&change, &point.position);
        Twist::new(change.displacement + turn.cross(moved), change.rotation)
    }

    fn by_motion(&self, state: &mut State, port: usize, load: Load, motion: &ColumnMotion) -> Vector6<f64> {
        let State { placements, rates, statics, responses, motions, sag_changes, .. } = state;
        let case = LoadCase::new(&self.elastics, statics, &responses[port], load);
        let moving = Motion {
            by: motion.by,
            frames: &|frame| motion.twists.of(frame)[motion.column],
            joints: &|joint| motion.driver.map_or(0.0, |driver| rates.rate(joint, driver)),
        };
        let change = motions[port].by_motion(&case, placements, &moving);
        // What own weight alone does is the same for all points of a body.
        if is_sag(&load) {
            let known = &mut sag_changes[port];
            known.resize(known.len().max(motion.column + 1), None);
            known[motion.column] = Some(change);
        }
        change
    }

    fn gather_motions(&self, state: &mut State) {
        if state.has_motions {
            return;
        }
        state.has_motions = true;
        state.sag_changes.iter_mut().for_each(Vec::clear);
        for (motion, response) in state.motions.iter_mut().zip(&state.responses) {
            let load = Load { wrench: Vector6::zeros(), weight: self.weight };
            motion.prepare(&LoadCase::new(&self.elastics, &state.statics, response, load));
        }
    }

    /// Derivatives of a point's deflection by the elastic parameters asked for, in their order.
    pub fn deflection_by_parameters<'s>(
        &self,
        state: &'s mut State,
        point: &LoadedPoint,
    ) -> impl Iterator<Item = Twist> + use<'s> {
        if self.deflects && self.columns.columns > 0 && !self.geometry.model.is_by_rules() {
            let State { placements, statics, responses, elastic_twists, .. } = state;
            let load = Load { wrench: point.wrench(), weight: point.weight };
            let case = LoadCase::new(&self.elastics, statics, &responses[point.port], load);
            self.columns.evaluate(&case, placements, elastic_twists);
        } else {
            state.elastic_twists.fill(Vector6::zeros());
        }
        let position = point.position;
        state.elastic_twists.iter().map(move |twist| twist_at(twist, &position))
    }
}

/// Whether own weight alone loads the structure.
fn is_sag(load: &Load) -> bool {
    load.weight && load.wrench == Vector6::zeros()
}

impl State {
    /// How joints move with the variables and parameters; after [`Mechanics::evaluate_rates`].
    pub fn rates(&self) -> &Rates {
        &self.rates
    }
}

fn twist_at(spatial: &Vector6<f64>, point: &Vector3<f64>) -> Twist {
    let (displacement, rotation) = at_point(spatial, point);
    Twist::new(displacement, rotation)
}
