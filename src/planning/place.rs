//! Where one can measure: limits, workspace, line of sight.

use nalgebra::Point3;

use super::error::PlanningError;
use super::request::{Design, Request};
use crate::description::campaign::{Campaign, Reading};
use crate::kinematics::{Geometry, Placements, beyond_limits};
use crate::observation::{MOST_ROWS, TargetValues};
use crate::prediction::{Toucher, target_values};
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
    /// What is read there, by index in [`super::Design::ways`].
    pub way: usize,
}

impl Station {
    /// Whether both may be measured: neither the same nor too near.
    pub fn goes_with(&self, other: &Self, apart: f64) -> bool {
        let same = self.q.iter().zip(&other.q).all(|(a, b)| (a - b).abs() < 1e-9);
        if same { self.load != other.load } else { apart == 0.0 || (self.at - other.at).norm() >= apart }
    }
}

impl Design {
    /// Whether anything is touched.
    pub fn touches(&self) -> bool {
        self.ways.iter().flatten().any(|reading| reading.observes.touches())
    }
}

/// What a configuration has to keep.
pub struct Rules<'a> {
    pub request: &'a Request,
    pub geometry: &'a Geometry<'a>,
    disturbed: Vec<Geometry<'a>>,
    /// Brings the ball to what it touches, and by way its reading in the toucher's campaign and what it touches.
    contacts: Option<(Toucher<'a>, Vec<Option<Touched>>)>,
}

/// The reading of a contact in the campaign of all ways, and the values of what it touches.
type Touched = (usize, TargetValues);

impl<'a> Rules<'a> {
    /// `ways` are the readings of all ways, one after the other.
    pub fn new(request: &'a Request, geometry: &'a Geometry<'a>, ways: &'a Campaign) -> Result<Self, PlanningError> {
        let model = geometry.model;
        let count = if model.stages.is_empty() { 0 } else { request.settings.disturbed };
        let off = |k| Geometry::new(model, &draw_errors(model, request.settings.off, 0.0, &mut generator(k))).ok();
        let contacts = match &request.design {
            Some(design) if design.touches() => {
                let mut first = 0;
                let touched = |way: &Vec<Reading>| {
                    let own = way.iter().position(|reading| reading.observes.touches());
                    let index = own.map(|own| first + own);
                    first += way.len();
                    let target = own.map(|own| target_values(model, ways, way[own].target, &design.values));
                    index.zip(target)
                };
                Some((Toucher::new(model, &design.values, ways)?, design.ways.iter().map(touched).collect()))
            }
            _ => None,
        };
        Ok(Self { request, geometry, disturbed: (0..count).filter_map(off).collect(), contacts })
    }

    /// How many ways there are to read at a configuration.
    pub fn ways(&self) -> usize {
        self.request.design.as_ref().map_or(1, |design| design.ways.len())
    }

    /// Whether configurations have to be brought to a contact.
    pub fn touches(&self, way: usize) -> bool {
        self.contacts.as_ref().is_some_and(|(_, all)| all.get(way).is_some_and(Option::is_some))
    }

    /// The same for configurations that are not measured: without line of sight and workspace.
    pub fn seen_from_anywhere(&self, q: &[f64], placements: &Placements) -> bool {
        within_limits(self.geometry, q, placements) && self.is_sturdy(q)
    }

    /// Whether linkages off by [`super::Settings::off`] tolerances can take a configuration, within the limits of their joints.
    fn is_sturdy(&self, q: &[f64]) -> bool {
        let mut placements = Placements::default();
        // Variables are commanded, and keep their own limits however the linkage is off.
        self.disturbed.iter().all(|off| {
            off.place(q, &mut placements).is_ok() && beyond_limits(off.model, q, &placements).next().is_none()
        })
    }

    /// What can be measured at placed frames; nothing where a rule is broken.
    pub fn seen(&self, q: &[f64], placements: &Placements) -> Option<Vec<Option<usize>>> {
        if !within_limits(self.geometry, q, placements) {
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

    /// The station of a configuration under a load, if it can be measured; with a contact one near it.
    pub fn station(&self, placements: &mut Placements, q: &[f64], load: [f64; 6], way: usize) -> Option<Station> {
        let touching = match &self.contacts {
            Some((toucher, all)) => match all.get(way).copied().flatten() {
                Some((reading, target)) => Some(toucher.touching(reading, &target, q, &[0.0; MOST_ROWS])?),
                None => None,
            },
            None => None,
        };
        let q = touching.as_deref().unwrap_or(q);
        let inside = q.iter().zip(&self.request.within).all(|(q, [low, high])| (*low..=*high).contains(q));
        if !inside || self.geometry.place(q, placements).is_err() {
            return None;
        }
        let markers = self.seen(q, placements)?;
        Some(Station { q: q.to_vec(), load, markers, at: self.tool(placements), way })
    }

    /// The tool centre point at placed frames.
    pub fn tool(&self, placements: &Placements) -> Point3<f64> {
        placements.frames[self.geometry.model.tool.0] * Point3::from(self.geometry.tool().translation.vector)
    }
}
