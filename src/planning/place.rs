//! Where one can measure: limits, workspace, line of sight.

use nalgebra::Point3;

use super::request::Request;
use crate::kinematics::{Geometry, Placements};
use crate::simulation::{draw_errors, generator, within_limits};

/// A configuration to measure at, under a load.
#[derive(Debug, Clone, PartialEq)]
pub struct Station {
    /// Variables, rad and m.
    pub q: Vec<f64>,
    /// Load, N and N.m, base axes.
    pub load: [f64; 6],
    /// Points that can be measured there; `None` is the tool centre point.
    pub markers: Vec<Option<usize>>,
    /// Tool centre point, m, base frame.
    pub at: Point3<f64>,
}

impl Station {
    /// Whether both may be measured: neither the same nor too near.
    pub fn goes_with(&self, other: &Self, apart: f64) -> bool {
        let same = self.q.iter().zip(&other.q).all(|(a, b)| (a - b).abs() < 1e-9);
        if same { self.load != other.load } else { apart == 0.0 || (self.at - other.at).norm() >= apart }
    }
}

/// What a configuration has to keep.
pub struct Rules<'a> {
    pub request: &'a Request,
    pub geometry: &'a Geometry<'a>,
    disturbed: Vec<Geometry<'a>>,
}

impl<'a> Rules<'a> {
    pub fn new(request: &'a Request, geometry: &'a Geometry<'a>) -> Self {
        let model = geometry.model;
        let count = if model.stages.is_empty() { 0 } else { request.settings.disturbed };
        let off = |k| Geometry::new(model, &draw_errors(model, request.settings.off, 0.0, &mut generator(k))).ok();
        Self { request, geometry, disturbed: (0..count).filter_map(off).collect() }
    }

    /// The same for configurations that are not measured: without line of sight and workspace.
    pub fn seen_from_anywhere(&self, q: &[f64], placements: &Placements) -> bool {
        within_limits(self.geometry.model, q, placements) && self.is_sturdy(q)
    }

    fn is_sturdy(&self, q: &[f64]) -> bool {
        let mut placements = Placements::default();
        self.disturbed.iter().all(|geometry| geometry.place(q, &mut placements).is_ok())
    }

    /// What can be measured at placed frames; nothing where a rule is broken.
    pub fn seen(&self, q: &[f64], placements: &Placements) -> Option<Vec<Option<usize>>> {
        if !within_limits(self.geometry.model, q, placements) {
            return None;
        }
        let mut found = Vec::with_capacity(self.request.markers.len());
        for &marker in &self.request.markers {
            let (frame, local) = match marker {
                Some(m) => (self.geometry.model.markers[m].frame, self.geometry.marker(m)),
                None => (self.geometry.model.tool.0, self.geometry.tool().translation.vector.into()),
            };
            let placed = &placements.frames[frame];
            let point = placed * local;
            let outside = |space: &[[f64; 2]; 3]| (0..3).any(|k| !(space[k][0]..=space[k][1]).contains(&point[k]));
            if self.request.workspace.as_ref().is_some_and(outside) {
                return None;
            }
            if self.request.sight.is_none_or(|sight| sight.sees(&point, &(placed.rotation * sight.facing))) {
                found.push(marker);
            }
        }
        (!found.is_empty() && self.is_sturdy(q)).then_some(found)
    }

    /// The station of a configuration under a load, if it can be measured.
    pub fn station(&self, placements: &mut Placements, q: &[f64], load: [f64; 6]) -> Option<Station> {
        let inside = q.iter().zip(&self.request.within).all(|(q, [low, high])| (*low..=*high).contains(q));
        if !inside || self.geometry.place(q, placements).is_err() {
            return None;
        }
        let markers = self.seen(q, placements)?;
        Some(Station { q: q.to_vec(), load, markers, at: self.tool(placements) })
    }

    /// The tool centre point at placed frames.
    pub fn tool(&self, placements: &Placements) -> Point3<f64> {
        placements.frames[self.geometry.model.tool.0] * Point3::from(self.geometry.tool().translation.vector)
    }
}
