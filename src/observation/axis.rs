//! `axis`: direction of the tool's z axis in the measurement frame, as a camera sees a rod or a two-angle target shows its own.
//! The turn of the tool about its axis does not show.

use nalgebra::Vector3;

use super::direction::Direction;
use super::kind::{MeasuredPoint, ValueColumn};

fn predicted(point: &MeasuredPoint) -> Vector3<f64> {
    point.orientation * Vector3::z()
}

pub(super) const AXIS: Direction = Direction {
    name: "axis",
    about: "Direction of the tool's z axis: two angles.",
    columns: &[ValueColumn::number("axis.x"), ValueColumn::number("axis.y"), ValueColumn::number("axis.z")],
    angles: &[ValueColumn::angle("azimuth"), ValueColumn::angle("elevation")],
    // The azimuth counts from x towards y, the elevation from the x-y plane towards z.
    of_angles: |[azimuth, elevation]| {
        let level = elevation.cos();
        Vector3::new(level * azimuth.cos(), level * azimuth.sin(), elevation.sin())
    },
    in_angles: |axis| [axis.y.atan2(axis.x), axis.z.clamp(-1.0, 1.0).asin()],
    residuals: "directions",
    depends_on: "the axes of the tool",
    fault: "axis.x, axis.y, axis.z are all zero, and give no direction",
    of_tool: Some(Vector3::new(0.0, 0.0, 1.0)),
    target_start: |_| None,
    predicted,
    change: |point, by| by.total().rotation.cross(&predicted(point)),
    by_target: |_, _| Vector3::zeros(),
};
