//! Which commands bring a loaded robot through its path?
//!
//! The KUKA IR663 bends an elastic strip (section 4 of the paper by Marie, Courteille and Maurine, bundled as
//! `ir663-strip`): the strip pushes the tool away, the more the nearer to the clamp. `cargo run --example compensate_path`
//! prints
//!
//! ```text
//! point 1: misses by 4.1592 mm uncorrected; stroke8 by -0.6571 mm
//! point 26: misses by 1.4486 mm uncorrected; stroke8 by -0.2333 mm
//! 26 of 26 points, 2.9910 mm rms uncorrected
//! ```

use std::fmt::Write;

use elastogeo::compensation::{Asked, Controller, Hold, Settings, compensate, desire};
use elastogeo::files::Reader;
use elastogeo::kinematics::{Geometry, Transform};

#[allow(dead_code)] // a test includes this file
fn main() -> Result<(), elastogeo::Error> {
    print!("{}", report()?);
    Ok(())
}

/// Compensates the bundled path under its process.
pub fn report() -> Result<String, elastogeo::Error> {
    let reader = Reader::default();
    // A calibrated description, as `identify --save` writes it, would be given as its file.
    let robot = reader.robot("kuka-ir663")?;
    let model = &robot.model;
    let path = reader.path("ir663-strip", &robot, robot.raw.units)?;
    let (process, _warnings) = reader.process("ir663-strip")?;

    // The controller takes the robot for the nominal, rigid one.
    let geometry = Geometry::nominal(model)?;
    let markers: Vec<usize> = (0..model.markers.len()).collect();
    let controller = Controller { geometry: &geometry, markers: &markers };
    let asked = Asked { joints: path.joints, position: path.position, orientation: path.orientation, hold: Hold::POSE };
    let desired = desire(&controller, &path.campaign, asked, &Transform::identity(), None, None);
    let settings = Settings::new(model.variables.len());
    let values = model.registry.nominal();
    let found = compensate(model, &values, &path.campaign, &desired, Some(&process), &settings)?;

    let mut text = String::new();
    let (mut squares, mut done) = (0.0, 0);
    for (number, (point, desired)) in found.points.iter().zip(&desired).enumerate() {
        let (Ok(point), Ok(desired)) = (point, desired) else {
            let _ = writeln!(text, "point {}: refused", number + 1);
            continue;
        };
        let missed = 1e3 * point.before.map_or(0.0, |deviation| deviation.all.norm());
        let (screw, name) = (2, &model.variables[2].name);
        let correction = 1e3 * (point.corrected.joints[screw] - desired.nominal[screw]);
        let _ =
            writeln!(text, "point {}: misses by {missed:.4} mm uncorrected; {name} by {correction:.4} mm", number + 1);
        squares += missed * missed;
        done += 1;
    }
    let rms = (squares / f64::from(done.max(1))).sqrt();
    let _ = writeln!(text, "{done} of {} points, {rms:.4} mm rms uncorrected", found.points.len());
    Ok(text)
}
