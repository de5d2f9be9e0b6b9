//! A description as a model of the simulator MuJoCo (MJCF).
//!
//! Each frame is a body of its name with a joint of its name, whose value is that of the description's joint (rad, m).
//! Springs of joints and of the pedestal are joints of their own after it (`2.kar`), couplings and closed loops are
//! equality constraints, springs between bodies and screws are tendons. Source: MuJoCo's XML reference (equalities,
//! tendons, actuators), and its chapter on computation (softness of constraints, integrators).

mod drives;
mod joined;
mod scale;
mod tree;
mod writer;

use self::scale::{STEP, is_held, is_soft, parallel};
use self::writer::{Writer, escaped, numbers, triple};
use crate::description::robot::Robot;
use crate::diagnostic::Diagnostic;
use crate::kinematics::{AssemblyError, Geometry, Placements};
use crate::model::Model;

/// Mass of what has none, kg: MuJoCo moves nothing without.
const LEAST_MASS: f64 = 1e-6;
/// How constraints pull a violation back, and how hard they are: within two steps, and as hard as MuJoCo has them.
const SOLREF: [f64; 2] = [2.0 * STEP, 0.5];
const SOLIMP: &str = "0.9999 0.9999 0.001 0.5 2";

/// The model as XML, and warnings of what it does not hold.
///
/// # Errors
/// Loops that cannot be closed as described.
pub fn mjcf(robot: &Robot, model: &Model) -> Result<(String, Vec<Diagnostic>), AssemblyError> {
    let geometry = Geometry::nominal(model)?;
    let mut placements = Placements::default();
    let middle = model.middle();
    geometry.place(&middle, &mut placements)?;
    let mut writer = Writer::new(robot, &placements);
    lost_parts(&mut writer);
    let name = escaped(&robot.name);
    let (g, [time, ratio]) = (robot.elastic.gravity, SOLREF);
    writer.line(0, format!("<mujoco model=\"{name}\">"));
    writer.line(
        1,
        format!("<compiler angle=\"radian\" autolimits=\"true\" boundmass=\"{LEAST_MASS}\" boundinertia=\"1e-9\"/>"),
    );
    // Improvements count in proportion to the mean inertia, which actuators make great: the tolerance is next to none.
    writer.line(
        1,
        format!(
            "<option gravity=\"{}\" timestep=\"{STEP}\" integrator=\"implicitfast\" iterations=\"50\" \
             tolerance=\"1e-14\"/>",
            triple(&g)
        ),
    );
    writer.line(1, format!("<default><equality solref=\"{time} {ratio}\" solimp=\"{SOLIMP}\"/></default>"));
    writer.line(1, "<worldbody>");
    writer.body(0, 2);
    writer.line(1, "</worldbody>");
    writer.equalities();
    writer.tendons();
    writer.actuators(model);
    writer.line(1, "<keyframe>");
    let (qpos, ctrl) = (numbers(&writer.qpos), numbers(&middle));
    writer.line(2, format!("<key name=\"middle\" qpos=\"{qpos}\" ctrl=\"{ctrl}\"/>"));
    writer.line(1, "</keyframe>");
    writer.line(0, "</mujoco>");
    let lost = writer.lost;
    let diagnostics = (!lost.is_empty()).then(|| {
        Diagnostic::warning(format!("not written to the MJCF: {}", lost.join(", ")))
            .remedy("keep the description as well: `pose`, `compensate` and `simulate` use them")
    });
    Ok((writer.out, diagnostics.into_iter().collect()))
}

/// What no model of MuJoCo holds, or this one does not; effects apart.
fn lost_parts(writer: &mut Writer) {
    let robot = writer.robot;
    let names = |all: Vec<&str>| all.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    let weak = robot.elastic.springs.iter().filter(|spring| is_soft(&spring.rate) && !is_held(spring));
    let parallel = robot.elastic.joints.iter().filter(|joint| {
        parallel(robot, joint.frame).and_then(|k| joint.springs[k]).is_some_and(|spring| is_soft(&spring))
    });
    let lost_rules: &[&str] = if robot.fuzzy.is_some() || robot.spring_rules.is_some() { &["fuzzy"] } else { &[] };
    let parts = [
        ("beams", robot.elastic.beams.iter().map(|own| own.name.as_str()).collect::<Vec<_>>()),
        ("springs that act on the stiffness alone", weak.map(|own| own.name.as_str()).collect()),
        ("springs about passive joints", parallel.map(|own| robot.frames[own.frame].name.as_str()).collect()),
        ("limits of sums", robot.limits.iter().map(|own| own.name.as_str()).collect()),
        ("boxes to keep out of", robot.keep_out.iter().map(|own| own.name.as_str()).collect()),
        ("rules", lost_rules.to_vec()),
    ];
    let lost = parts.into_iter().filter(|(_, all)| !all.is_empty());
    writer.lost.extend(lost.map(|(what, all)| format!("{what} ({})", names(all))));
}
