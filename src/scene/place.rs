//! Points of a scene at a configuration, at rest and deflected.

use nalgebra::{Point3, Vector3, Vector6};

use super::{Beam, Scene, Spot};
use crate::elastics::{Elastics, Mechanism, Response, Statics, at_point, spatial, twists};
use crate::elements::screw_pins;
use crate::kinematics::{Geometry, Placements};

impl Scene {
    /// Its points at placed frames, m, base frame.
    pub fn place(&self, geometry: &Geometry, placements: &Placements) -> Vec<Vector3<f64>> {
        self.points.iter().map(|point| self.spot(&point.spot, geometry, placements)).collect()
    }

    fn spot(&self, spot: &Spot, geometry: &Geometry, placements: &Placements) -> Vector3<f64> {
        match spot {
            Spot::At(frame, point) => (placements.frames[*frame] * Point3::from(*point)).coords,
            Spot::Pin(actuator, which) => {
                let actuator = &geometry.model.actuators[*actuator];
                let values = &geometry.values()[actuator.slot..actuator.slot + 5];
                let pins = screw_pins(values, placements.joints[actuator.joint]);
                (placements.frames[actuator.joint] * Point3::from(pins[*which])).coords
            }
            Spot::Corner(beam, end, [y, z]) => {
                let Beam { nodes, normal } = &self.beams[*beam];
                let [a, b] = nodes.map(|(frame, point)| (placements.frames[frame] * Point3::from(point)).coords);
                let along = (b - a).try_normalize(1e-12).unwrap_or_else(Vector3::x);
                let axes = placements.frames[*normal].rotation.matrix();
                // As the elastic beam: its local z is the frame's, or x where that lies along the beam.
                let up = [2, 0]
                    .into_iter()
                    .map(|k| axes.column(k).into_owned())
                    .map(|axis| axis - along * along.dot(&axis))
                    .find_map(|axis| axis.try_normalize(1e-6))
                    .unwrap_or_else(Vector3::z);
                [a, b][*end] + up.cross(&along) * *y + up * *z
            }
            Spot::Measured(point) => (geometry.base().inverse() * Point3::from(*point)).coords,
        }
    }

    /// How far each point moves (m, base axes) under a force (N) and moment (N.m) at the tool centre point, own weight
    /// and preloads added if asked; `points` are those of [`Scene::place`].
    ///
    /// # Errors
    /// A structure that can move without any force.
    pub fn deflect(
        &self,
        geometry: &Geometry,
        placements: &Placements,
        points: &[Vector3<f64>],
        wrench: &[f64; 6],
        weight: bool,
    ) -> Result<Vec<Vector3<f64>>, Mechanism> {
        let model = geometry.model;
        let elastics = Elastics::new(model, geometry.values(), &[]);
        let local = geometry.tool().translation.vector;
        let mut statics = Statics::new(weight);
        elastics.prepare(placements, &mut statics)?;
        let mut response = Response::new(&elastics, model.structure.carrier(model.tool.0, &local));
        response.evaluate(&elastics, &mut statics);
        let at = (placements.frames[model.tool.0] * Point3::from(local)).coords;
        let [fx, fy, fz, mx, my, mz] = *wrench;
        let load = spatial(&at, &Vector3::new(fx, fy, fz), &Vector3::new(mx, my, mz));
        let all: Vec<Vector6<f64>> = twists(&elastics, &statics, &response, &load, weight);
        Ok(self.points.iter().zip(points).map(|(point, at)| at_point(&all[point.vertex], at).0).collect())
    }
}
