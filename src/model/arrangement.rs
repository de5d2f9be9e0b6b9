//! The measuring arrangement of a campaign in the model: poses of the base, tools and markers that differ between sessions,
//! and what readings refer to. Their parameters belong to the campaign, not to the robot: they are appended to the registry
//! and never written into a description.

use super::{Marker, Model};
use crate::description::campaign::{Campaign, InSession, Sharing, Target};
use crate::description::parameters::{BASE, MARKER, TOOL, symbols};
use crate::parameter::{Group, Kind, Parameter, Slot};

/// Common error of a point of the arrangement, m: it is only a size to compare columns by.
const LENGTH: f64 = 1e-2;
/// Common error of an angle or a ratio of the arrangement.
const RATIO: f64 = 1e-2;

/// Slots of the arrangement. What a list does not have is the model's own.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Arrangement {
    base: Shared,
    tool: Shared,
    scale: Shared,
    /// By target: slots of its values; none where they are known.
    targets: Vec<Vec<Option<Slot>>>,
    /// Bases, tools and markers of the sessions.
    copies: Vec<Copied>,
}

/// A base, tool or marker of a session.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Copied {
    /// `base@monday`.
    pub name: String,
    /// Its parameters.
    pub slots: std::ops::Range<Slot>,
}

/// First slots of a part that differs between sessions.
#[derive(Debug, Clone, PartialEq, Default)]
struct Shared {
    by: Sharing,
    first: Vec<Slot>,
}

impl Shared {
    fn slot(&self, of: InSession) -> Option<Slot> {
        self.first.get(of.part(self.by)).copied()
    }
}

impl Model {
    /// The model with the parameters of a campaign's arrangement: `base@<session>.x`, `tool@<session>.x`,
    /// `<marker>@<session>.x`, `scale@<station>`, and those of its targets, `<anchor>.x`. Effects that the description
    /// switches on keep their slots.
    #[must_use]
    pub fn arranged(&self, campaign: &Campaign) -> Self {
        let mut model = self.clone();
        let mut markers: Vec<String> = self.markers.iter().map(|marker| marker.name.clone()).collect();
        for &frame in &campaign.bodies {
            let name = self.frames[frame].name.clone();
            let owner = format!("body@{name}");
            let slot = model.known_point(&owner);
            model.markers.push(Marker { name, frame, slot });
            markers.push(owner);
        }
        let sessions = &campaign.sessions;
        if campaign.estimate_base && sessions.base != Sharing::All {
            let names = sessions.parts(sessions.base);
            let first = names.iter().map(|name| model.copies("base", &symbols(&BASE), self.base, name)).collect();
            model.arrangement.base = Shared { by: sessions.base, first };
        }
        if campaign.estimate_tool && sessions.tool != Sharing::All {
            let names = sessions.parts(sessions.tool);
            // The tool's six, and three of each marker behind them.
            let first = names.iter().map(|name| {
                let first = model.copies("tool", &symbols(&TOOL), self.tool.1, name);
                for (k, owner) in markers.iter().enumerate() {
                    model.copies(owner, &symbols(&MARKER), model.markers[k].slot, name);
                }
                first
            });
            let first = first.collect();
            model.arrangement.tool = Shared { by: sessions.tool, first };
        }
        if campaign.estimate_scale {
            let names = sessions.parts(sessions.scale);
            let first = names.iter().map(|name| {
                let name = if name.is_empty() { "scale".to_string() } else { format!("scale@{name}") };
                model.appended(name, Kind::Other("1"), 0.0)
            });
            let first = first.collect();
            model.arrangement.scale = Shared { by: sessions.scale, first };
        }
        model.arrangement.targets = campaign.targets.iter().map(|target| model.target_slots(target)).collect();
        model
    }

    /// Nominal values of this model, with those of the arrangement as `values` of another model of the same campaign have
    /// them: what a description that was calibrated and read again predicts the campaign with.
    #[must_use]
    pub fn nominal_at(&self, arrangement: &Self, values: &[f64]) -> Vec<f64> {
        let mut nominal = self.registry.nominal();
        let Arrangement { base, tool, scale, targets, .. } = &self.arrangement;
        let of = |first: &Vec<Slot>, count: usize| -> Vec<Slot> {
            first.iter().flat_map(|&first| first..first + count).collect()
        };
        let known = targets.iter().flatten().flatten().copied();
        let shared = [of(&base.first, 6), of(&tool.first, 6 + 3 * self.markers.len()), of(&scale.first, 1)];
        for slot in shared.into_iter().flatten().chain(known) {
            let there = arrangement.registry.slot(&self.registry[slot].name).and_then(|slot| values.get(slot));
            nominal[slot] = there.copied().unwrap_or(nominal[slot]);
        }
        nominal
    }

    fn target_slots(&mut self, target: &Target) -> Vec<Option<Slot>> {
        let slot = |value: &crate::description::campaign::TargetValue| {
            let name = value.parameter.as_ref()?;
            Some(self.registry.slot(name).unwrap_or_else(|| self.appended(name.clone(), value.kind, value.value)))
        };
        target.values.iter().map(slot).collect()
    }

    /// Appends the origin of a frame, a point that is never estimated.
    fn known_point(&mut self, owner: &str) -> Slot {
        let slots = symbols(&MARKER).map(|symbol| self.appended(format!("{owner}.{symbol}"), Kind::Length, 0.0));
        slots[0]
    }

    /// Appends a parameter of the arrangement.
    fn appended(&mut self, name: String, kind: Kind, nominal: f64) -> Slot {
        let tolerance = if kind == Kind::Length { LENGTH } else { RATIO };
        let (group, bounds) = (Group::Arrangement, [f64::NEG_INFINITY, f64::INFINITY]);
        let (free, closing, inverted) = (false, false, false);
        self.registry.add(Parameter { name, kind, group, nominal, bounds, tolerance, free, closing, inverted })
    }

    /// Appends copies of an owner's parameters, which stand from `slot` on, for a session; the first slot.
    fn copies(&mut self, owner: &str, symbols: &[&str], slot: Slot, session: &str) -> Slot {
        let first = self.registry.all().len();
        let name = format!("{owner}@{session}");
        for (k, symbol) in symbols.iter().enumerate() {
            let own = self.registry[slot + k].clone();
            self.registry.add(Parameter { name: format!("{name}.{symbol}"), ..own });
        }
        self.arrangement.copies.push(Copied { name, slots: first..first + symbols.len() });
        first
    }

    /// Whether a parameter is of a base, tool or marker of one session or station.
    pub fn is_of_a_session(&self, slot: Slot) -> bool {
        self.copied().iter().any(|copy| copy.slots.contains(&slot))
    }

    /// Bases, tools and markers of the sessions, in the order of their parameters.
    pub(super) fn copied(&self) -> &[Copied] {
        &self.arrangement.copies
    }

    /// First of the six slots of a session's base.
    pub fn base_slot(&self, of: InSession) -> Slot {
        self.arrangement.base.slot(of).unwrap_or(self.base)
    }

    /// First of the six slots of a session's tool.
    pub fn tool_slot(&self, of: InSession) -> Slot {
        self.arrangement.tool.slot(of).unwrap_or(self.tool.1)
    }

    /// First of the three slots of a session's marker.
    pub fn marker_slot(&self, marker: usize, of: InSession) -> Slot {
        self.arrangement.tool.slot(of).map_or(self.markers[marker].slot, |tool| tool + 6 + 3 * marker)
    }

    /// First slot of a measured point: of the tool centre point where no marker is given.
    pub fn point_slot(&self, marker: Option<usize>, of: InSession) -> Slot {
        marker.map_or_else(|| self.tool_slot(of), |marker| self.marker_slot(marker, of))
    }

    /// Slot of the scale of a session's instrument, where it is unknown.
    pub fn scale_slot(&self, of: InSession) -> Option<Slot> {
        self.arrangement.scale.slot(of)
    }

    /// Slots of the values of a target; none where they are known.
    pub fn target_values(&self, target: impl Into<Option<usize>>) -> &[Option<Slot>] {
        let own = target.into().and_then(|target| self.arrangement.targets.get(target));
        own.map_or(&[], Vec::as_slice)
    }
}
