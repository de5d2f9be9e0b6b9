//! Where is the tool of a robot with a closed loop, which commands bring it back there, and how stiff is it?
//!
//! The KUKA IR663 turns its arm by two ball screws and a four-bar linkage. `cargo run --example forward_and_inverse` prints
//!
//! ```text
//! tool centre point: x 1619.083, y -183.000, z 1370.544 mm
//! joint 9, closed by the loop: -127.2709 deg
//! 1 mm of screw 2 moves the tool by 3.2 mm
//! commands back to it: q1 0.000 deg, stroke2 800.000 mm, stroke8 750.000 mm, q4 0.000 deg, q5 90.000 deg, q7 0.000 deg
//! ```

use std::fmt::Write;

use elastogeo::files::load_robot;
use elastogeo::kinematics::{Geometry, Hold, InverseSettings, Placements, Target, solve};

#[allow(dead_code)] // a test includes this file
fn main() -> Result<(), elastogeo::Error> {
    print!("{}", report()?);
    Ok(())
}

/// Forward model at one configuration, its derivative by a screw, and the inverse model back to it.
pub fn report() -> Result<String, elastogeo::Error> {
    let robot = load_robot("kuka-ir663")?;
    let model = &robot.model;
    let geometry = Geometry::nominal(model)?;
    // q1, stroke2, stroke8, q4, q5, q7: rad and m.
    let q = [0.0, 0.8, 0.75, 0.0, 90f64.to_radians(), 0.0];

    let mut placements = Placements::default();
    let mut pose = |q: &[f64]| {
        geometry.place(q, &mut placements)?;
        let tool = placements.frames[model.tool.0] * geometry.tool();
        let passive = model.frame("9").map_or(0.0, |frame| placements.joints[frame]);
        Ok::<_, elastogeo::Error>((tool, passive))
    };
    let (tool, passive) = pose(&q)?;
    let mut text = String::new();
    let at = 1e3 * tool.translation.vector;
    let _ = writeln!(text, "tool centre point: x {:.3}, y {:.3}, z {:.3} mm", at.x, at.y, at.z);
    let _ = writeln!(text, "joint 9, closed by the loop: {:.4} deg", passive.to_degrees());

    let mut longer = q;
    longer[1] += 1e-3;
    let (moved, _) = pose(&longer)?;
    let away = 1e3 * (moved.translation.vector - tool.translation.vector).norm();
    let _ = writeln!(text, "1 mm of screw 2 moves the tool by {away:.1} mm");

    // The solution nearest to a start that is some way off.
    let target = Target { position: tool.translation.vector.into(), rotation: Some(tool.rotation), hold: Hold::POSE };
    let start = vec![0.2, 0.75, 0.7, 0.1, 1.2, 0.1];
    let found = solve(&geometry, &target, &InverseSettings { from: Some(start), ..InverseSettings::default() })?;
    let commands = found[0].joints.iter().zip(&model.variables).map(|(value, variable)| {
        let (value, unit) = if variable.is_angle { (value.to_degrees(), "deg") } else { (1e3 * value, "mm") };
        // Adding zero takes the sign off a rounded zero.
        format!("{} {:.3} {unit}", variable.name, (1e3 * value).round() / 1e3 + 0.0)
    });
    let _ = writeln!(text, "commands back to it: {}", commands.collect::<Vec<_>>().join(", "));
    Ok(text)
}
