//! Changes of a campaign, or of a description's values, of which [`super::hypothesis`] makes other ways to read files.

use nalgebra::{Rotation3, Vector3};

use crate::description::campaign::Campaign;
use crate::math::rotation_vector;
use crate::model::Model;
use crate::parameter::Slot;

/// Changes each configuration.
pub fn each(campaign: &mut Campaign, change: impl Fn(&mut [f64])) {
    campaign.joints.chunks_mut(campaign.variables.max(1)).for_each(change);
}

/// Reflects positions, and orientations where they `turn` too: a rotation about r, reflected by S, is one about -S r.
pub fn mirror(campaign: &mut Campaign, turns: bool, reflect: impl Fn(&mut Vector3<f64>)) {
    for reading in &mut campaign.readings {
        if reading.observes.measured_position(&reading.measured).is_none() && !reading.observes.is_difference() {
            continue;
        }
        let (lengths, angles) = reading.measured.split_at_mut(3);
        let mut position = Vector3::from_column_slice(lengths);
        reflect(&mut position);
        lengths.copy_from_slice(position.as_slice());
        if turns && reading.observes.sees_orientation() {
            let mut about = Vector3::from_column_slice(&angles[..3]);
            reflect(&mut about);
            angles[..3].copy_from_slice((-about).as_slice());
        }
    }
}

/// The campaign with the joints of the row, or of the configuration, `by` places further on at each reading; what has none
/// is left out.
pub fn shifted(campaign: &Campaign, by: isize, whole: bool) -> Campaign {
    // First reading of each run, by reading its run.
    let mut first: Vec<usize> = Vec::new();
    let mut run_of = Vec::with_capacity(campaign.readings.len());
    for (index, reading) in campaign.readings.iter().enumerate() {
        let begins = !whole || index == 0 || campaign.readings[index - 1].pose != reading.pose;
        if begins {
            first.push(index);
        }
        run_of.push(first.len() - 1);
    }
    let from = |index: usize| run_of[index].checked_add_signed(by).and_then(|run| first.get(run).copied());
    let mut moved = campaign.select(|index, _| from(index).is_some());
    moved.joints = (0..campaign.readings.len())
        .filter_map(from)
        .flat_map(|source| campaign.configuration(source).iter().copied())
        .collect();
    moved
}

/// Positions of alpha and d in the slots of a frame.
pub const ROW: [usize; 2] = [3, 4];

/// Moves alpha and d of each frame on the tool's chain to the frame after it, or before it.
pub fn move_rows(model: &Model, values: &mut [f64], next: bool) {
    let chain = model.path(model.tool.0);
    let old = values.to_vec();
    for (place, &frame) in chain.iter().enumerate() {
        let source = if next { place.checked_sub(1) } else { Some(place + 1) };
        let source = source.and_then(|place| chain.get(place));
        for k in ROW {
            values[model.frames[frame].slots[k]] = source.map_or(0.0, |&source| old[model.frames[source].slots[k]]);
        }
    }
}

/// Gives the last frame of the tool's chain a twist that its tool and markers were placed with.
pub fn take_back(model: &Model, values: &mut [f64], twist: f64) {
    let (frame, tool) = model.tool;
    let Some(&last) = model.path(frame).last() else { return };
    values[model.frames[last].slots[ROW[0]]] = twist;
    let undo = Rotation3::from_axis_angle(&Vector3::x_axis(), -twist);
    let point = |first: Slot| Vector3::from_fn(|k, _| first + k);
    let own = model.markers.iter().filter(|marker| marker.frame == frame).map(|marker| marker.slot);
    for slots in std::iter::once(tool).chain(own).map(point) {
        let at = undo * slots.map(|slot| values[slot]);
        slots.iter().zip(&at).for_each(|(&slot, &value)| values[slot] = value);
    }
    let slots = point(tool + 3);
    let turned = rotation_vector(&(undo * Rotation3::new(slots.map(|slot| values[slot]))));
    slots.iter().zip(&turned).for_each(|(&slot, &value)| values[slot] = value);
}
