//! What load and own weight add to a reading: h(q, F, ...) of eq. (39) of the IR663 calibration paper.

use nalgebra::{Matrix6, Point3, Vector3, Vector6};

use crate::description::campaign::{Campaign, Reading};
use crate::elastics::{
    ElasticColumns, Elastics, Load, LoadCase, Mechanism, MotionWorkspace, Response, Statics, at_point, spatial,
};
use crate::elements::{Motion, VertexIndex};
use crate::fuzzy;
use crate::kinematics::{Geometry, Placements};
use crate::model::Model;
use crate::parameter::{Group, Slot};

/// Deflections of a campaign's readings; made once for a vector of values, shared between threads.
#[derive(Debug, Clone)]
pub struct Deflections<'m> {
    elastics: Elastics<'m>,
    columns: ElasticColumns,
    /// Which of the asked parameters the columns are.
    asked: Vec<usize>,
    /// Loaded vertices, and which of them each marker (last: the tool centre point) hangs on.
    vertices: Vec<VertexIndex>,
    ports: Vec<usize>,
    /// Whether anything deflects at all.
    active: bool,
    /// Own weight counts: readings are absolute.
    weight: bool,
    /// A fuzzy compliance stands in the place of the elastic elements.
    replaced: bool,
}

/// Room for one thread.
#[derive(Debug, Clone)]
pub struct Work {
    statics: Statics,
    responses: Vec<Response>,
    motions: Vec<MotionWorkspace>,
    /// Changes under own weight alone, by port and number of the motion.
    known: Vec<Vec<Vector6<f64>>>,
    columns: Vec<Vector6<f64>>,
}

/// What load does to a reading, base axes.
#[derive(Debug, Clone, Copy, Default)]
pub struct Deflected {
    /// Displacement, m.
    pub displacement: Vector3<f64>,
    /// Rotation vector, rad.
    pub rotation: Vector3<f64>,
}

impl<'m> Deflections<'m> {
    /// Deflections of `campaign` by `model` with `values`, differentiated by the elastic ones among `slots`.
    pub fn new(model: &'m Model, values: &[f64], campaign: &Campaign, slots: &[Slot]) -> Self {
        let asked: Vec<usize> =
            (0..slots.len()).filter(|&column| model.registry[slots[column]].group == Group::Elastic).collect();
        let elastic: Vec<Slot> = asked.iter().map(|&column| slots[column]).collect();
        let elastics = Elastics::new(model, values, &elastic);
        let weight = !campaign.observes.is_difference();
        let loaded = campaign.readings.iter().any(|reading| reading.wrench.iter().any(|w| *w != 0.0));
        let active =
            loaded && model.fuzzy.is_some() || elastics.is_compliant() && (loaded || weight && elastics.is_loaded());
        let carrier = |frame: usize, slot: Slot| {
            model.structure.carrier(frame, &Vector3::new(values[slot], values[slot + 1], values[slot + 2]))
        };
        let mut vertices: Vec<VertexIndex> = Vec::new();
        let ends = model.markers.iter().map(|marker| (marker.frame, marker.slot)).chain([model.tool]);
        let ports = ends
            .map(|(frame, slot)| {
                let vertex = carrier(frame, slot);
                vertices.iter().position(|known| *known == vertex).unwrap_or_else(|| {
                    vertices.push(vertex);
                    vertices.len() - 1
                })
            })
            .collect();
        let columns = ElasticColumns::new(&elastics, &elastic);
        let replaced = model.is_by_rules();
        Self { elastics, columns, asked, vertices, ports, active, weight, replaced }
    }

    /// Room for one thread.
    pub fn work(&self) -> Work {
        Work {
            statics: Statics::new(self.weight),
            responses: self.vertices.iter().map(|&vertex| Response::new(&self.elastics, vertex)).collect(),
            motions: vec![MotionWorkspace::default(); self.vertices.len()],
            known: vec![Vec::new(); self.vertices.len()],
            columns: vec![Vector6::zeros(); self.columns.columns],
        }
    }

    /// Statics of a placed configuration.
    ///
    /// # Errors
    /// [`Mechanism`].
    pub fn place(
        &self,
        geometry: &Geometry,
        q: &[f64],
        placements: &Placements,
        work: &mut Work,
    ) -> Result<(), Mechanism> {
        if self.active {
            self.elastics.prepare(placements, &mut work.statics)?;
            for response in &mut work.responses {
                response.evaluate(&self.elastics, &mut work.statics);
                fuzzy::put(geometry, q, placements, response);
            }
        }
        Ok(())
    }

    fn port(&self, reading: &Reading) -> usize {
        self.ports[reading.marker.unwrap_or(self.ports.len() - 1)]
    }

    fn wrench(reading: &Reading, point: &Vector3<f64>) -> Vector6<f64> {
        let w = &reading.wrench;
        spatial(point, &Vector3::new(w[0], w[1], w[2]), &Vector3::new(w[3], w[4], w[5]))
    }

    /// Deflection of a reading at `point` (m, base frame).
    pub fn of(&self, work: &Work, reading: &Reading, point: &Point3<f64>) -> Deflected {
        if !self.active {
            return Deflected::default();
        }
        let response = &work.responses[self.port(reading)];
        let twist = response.twist(&Self::wrench(reading, &point.coords), self.weight && work.statics.is_loaded());
        let (displacement, rotation) = at_point(&twist, &point.coords);
        Deflected { displacement, rotation }
    }

    /// The same where wrenches are not known beforehand.
    #[must_use]
    pub fn under_any_wrench(mut self) -> Self {
        self.active = self.elastics.is_compliant() || self.elastics.model.fuzzy.is_some();
        self
    }

    /// Displacement and rotation of a reading's point (m, base frame) by force and moment there, base axes.
    pub fn compliance(&self, work: &Work, reading: &Reading, point: &Point3<f64>) -> Matrix6<f64> {
        if self.active { work.responses[self.port(reading)].compliance_at(&point.coords) } else { Matrix6::zeros() }
    }

    /// Whether anything deflects.
    pub fn is_active(&self) -> bool {
        self.active
    }

    /// Gathers, at a placed configuration, what [`Deflections::by_motion`] needs.
    pub fn prepare_motion(&self, work: &mut Work) {
        work.known.iter_mut().for_each(Vec::clear);
        for (motion, response) in work.motions.iter_mut().zip(&work.responses) {
            let load = Load { wrench: Vector6::zeros(), weight: self.weight };
            motion.prepare(&LoadCase::new(&self.elastics, &work.statics, response, load));
        }
    }

    /// Change of a reading's deflection when its point (m, base frame) is `moved` and the frames move by `motion`, which
    /// is known by a number (`None` where they stand still).
    #[allow(clippy::too_many_arguments)] // the whole state of one reading
    pub fn by_motion(
        &self,
        work: &mut Work,
        placements: &Placements,
        reading: &Reading,
        point: &Point3<f64>,
        moved: &Vector3<f64>,
        motion: Option<(usize, &Motion)>,
    ) -> Deflected {
        let port = self.port(reading);
        let response = &work.responses[port];
        let wrench = Self::wrench(reading, &point.coords);
        let mut change = Vector6::zeros();
        if let Some((number, motion)) = motion.filter(|_| !self.replaced) {
            let load = Load { wrench, weight: self.weight };
            let case = LoadCase::new(&self.elastics, &work.statics, response, load);
            let motions = &mut work.motions[port];
            let mut fresh = || motions.by_motion(&case, placements, motion);
            // What own weight alone does is the same for all points of a body.
            change = if wrench == Vector6::zeros() {
                if work.known[port].len() <= number {
                    let change = fresh();
                    work.known[port].resize(number, Vector6::zeros());
                    work.known[port].push(change);
                }
                work.known[port][number]
            } else {
                fresh()
            };
        }
        let w = &reading.wrench;
        let turned = moved.cross(&Vector3::new(w[0], w[1], w[2]));
        change += response.compliance * spatial(&Vector3::zeros(), &Vector3::zeros(), &turned);
        let (_, turn) = at_point(&response.twist(&wrench, self.weight && work.statics.is_loaded()), &point.coords);
        let (displacement, rotation) = at_point(&change, &point.coords);
        Deflected { displacement: displacement + turn.cross(moved), rotation }
    }

    /// Displacement of a reading's point (m, base frame) by the applied wrench alone, base axes.
    pub fn by_wrench(&self, work: &Work, reading: &Reading, point: &Point3<f64>) -> Vector3<f64> {
        if !self.active {
            return Vector3::zeros();
        }
        let response = &work.responses[self.port(reading)];
        at_point(&response.twist(&Self::wrench(reading, &point.coords), false), &point.coords).0
    }

    /// Derivatives of a reading's deflection: column among the asked slots, and change.
    pub fn derivatives<'w>(
        &self,
        work: &'w mut Work,
        placements: &Placements,
        reading: &Reading,
        point: &Point3<f64>,
    ) -> impl Iterator<Item = (usize, Deflected)> + use<'w, '_> {
        if self.active && !self.asked.is_empty() && !self.replaced {
            let response = &work.responses[self.port(reading)];
            let wrench = Self::wrench(reading, &point.coords);
            let load = Load { wrench, weight: self.weight };
            let case = LoadCase::new(&self.elastics, &work.statics, response, load);
            self.columns.evaluate(&case, placements, &mut work.columns);
        } else {
            work.columns.fill(Vector6::zeros());
        }
        let point = point.coords;
        self.asked.iter().zip(&work.columns).map(move |(&column, twist)| {
            let (displacement, rotation) = at_point(twist, &point);
            (column, Deflected { displacement, rotation })
        })
    }
}
