//! Points of a scene at a configuration, at rest and deflected.

use nalgebra::{Point3, Vector3};

use super::{Beam, Scene, Spot};
use crate::elastics::at_point;
use crate::elements::screw_pins;
use crate::kinematics::{Geometry, Placements};
use crate::state::{Mechanics, State};

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

    /// How far each point moves (m, base axes) at the placed configuration under a force (N) and moment (N.m) at the tool
    /// centre point, own weight and preloads added where the mechanics count them; `points` are those of [`Scene::place`].
    pub fn deflect(
        &self,
        mechanics: &Mechanics,
        state: &State,
        points: &[Vector3<f64>],
        wrench: &[f64; 6],
    ) -> Vec<Vector3<f64>> {
        let all = mechanics.vertex_twists(state, &mechanics.point(state, None, wrench));
        self.points.iter().zip(points).map(|(point, at)| at_point(&all[point.vertex], at).0).collect()
    }
}
