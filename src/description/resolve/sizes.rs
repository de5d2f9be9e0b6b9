//! Lengths and angles that no robot has: mostly those of a file that does not say its units.

use crate::description::frame::{Constants, Frame};
use crate::description::raw::{JointKind, RawRobot};
use crate::description::robot::Robot;
use crate::description::units::{Angle, Length};
use crate::diagnostic::{Code, Diagnostic};

use crate::diagnostic::Locate;
use crate::math::{median, norm};

/// Greatest sum of the lengths of a robot's frames, m.
const LONGEST: f64 = 50.0;
/// Greatest limit of an angle, rad: a bit more than three turns.
const WIDEST: f64 = 20.0;

/// Warnings where a description in m and rad reads like one in mm and deg.
///
/// `raw` is the description as written, `robot` what it means.
pub fn doubtful_sizes(raw: &RawRobot, robot: &Robot, locate: Locate) -> Vec<Diagnostic> {
    let cure = "lengths here are in m and angles in rad; if they are not, declare them: \
                `units: {length: mm, angle: deg}`";
    let mut diagnostics = Vec::new();
    diagnostics.extend(match raw.units.length {
        Length::Metre => too_long(raw, locate, cure),
        other => too_long(raw, locate, &format!("lengths here are in {}: check `units` of the file", other.symbol())),
    });
    diagnostics.extend(wide_limits(raw, locate, cure));
    diagnostics.extend(metres_as_millimetres(raw, locate));
    diagnostics.extend(radians_as_degrees(raw, locate));
    diagnostics.extend(limits_in_radians(raw, locate));
    let reach = reach(robot);
    diagnostics.extend(heavy_or_far(raw, reach, locate));
    let centres = centres_in_metres(raw, reach, locate);
    if centres.is_none() {
        diagnostics.extend(heavy_centres_in_metres(raw, locate));
    }
    diagnostics.extend(centres);
    diagnostics.extend(other_gravity(raw, locate));
    diagnostics
}

/// Limits of angles in rad that no joint has.
fn wide_limits(raw: &RawRobot, locate: Locate, cure: &str) -> Option<Diagnostic> {
    let widest =
        |limits: [f64; 2]| limits.into_iter().filter(|v| v.is_finite()).fold(0.0, |most: f64, v| most.max(v.abs()));
    let wide = raw.frames.iter().filter(|_| raw.units.angle == Angle::Radian).find_map(|(name, frame)| {
        let widest = widest(frame.limits.filter(|_| frame.joint == Some(JointKind::Revolute))?);
        (widest > WIDEST).then_some((name, widest))
    });
    let (name, widest) = wide?;
    let diagnostic = Diagnostic::warning(format!("joint `{name}` may turn by {} rad", rounded(widest)));
    Some(diagnostic.at(locate(&["frames", name, "limits"])).remedy(cure))
}

/// Lengths and limits of a URDF, whose units are the metre and the radian, that no robot has.
pub fn doubtful_urdf(raw: &RawRobot, robot: &Robot, locate: Locate) -> Vec<Diagnostic> {
    let wide = wide_limits(raw, locate, "limits of a URDF are in rad: are these written in deg?");
    let long = urdf_in_millimetres(raw, locate);
    // Of lengths that are too great masses say nothing.
    let heavy = if long.is_some() { Vec::new() } else { heavy(raw, reach(robot), locate) };
    long.into_iter().chain(wide).chain(heavy).collect()
}

/// Lengths of a URDF, whose unit is the metre, that no robot has.
fn urdf_in_millimetres(raw: &RawRobot, locate: Locate) -> Option<Diagnostic> {
    too_long(raw, locate, "lengths of a URDF are in m: is this one written in mm?")
}

/// Frames longer together than any robot.
fn too_long(raw: &RawRobot, locate: Locate, remedy: &str) -> Option<Diagnostic> {
    let (sum, longest) = lengths(raw);
    let sum = sum * raw.units.length.factor();
    let (name, key) = longest.filter(|_| sum > LONGEST && sum.is_finite())?;
    let diagnostic = Diagnostic::warning(format!("the lengths of the frames add up to {} m", rounded(sum)));
    Some(diagnostic.at(locate(&["frames", name, key])).remedy(remedy))
}

/// Least sum of the lengths of a robot's frames, m: the smallest arms measure 50 mm.
const SHORTEST: f64 = 0.02;

/// A file in mm whose numbers are metres.
fn metres_as_millimetres(raw: &RawRobot, locate: Locate) -> Option<Diagnostic> {
    let (sum, longest) = lengths(raw);
    let (name, key) = longest?;
    let sum = sum * raw.units.length.factor();
    let unit = raw.units.length.symbol();
    (sum > 0.0 && sum < SHORTEST && raw.units.length != Length::Metre).then(|| {
        Diagnostic::warning(format!("the lengths of the frames add up to {:.3} mm", 1e3 * sum))
            .at(locate(&["frames", name, key]))
            .remedy(format!("lengths here are in {unit}; if they are in m, declare `units: {{length: m}}`"))
    })
}

/// Sum of the absolute lengths of the frames as declared, and the longest: its frame and key.
fn lengths(raw: &RawRobot) -> (f64, Option<(&str, &'static str)>) {
    let all = || {
        raw.frames.iter().flat_map(|(name, frame)| {
            let of = [("b", frame.b), ("d", frame.d), ("r", frame.r)];
            of.into_iter().filter_map(move |(key, value)| Some((name.as_str(), key, value?.abs())))
        })
    };
    let longest = all().max_by(|a, b| a.2.total_cmp(&b.2)).map(|(name, key, _)| (name, key));
    (all().map(|(.., length)| length).sum(), longest)
}

/// An angle of a frame that is meant in radians has a multiple of a quarter turn to so many digits.
const QUARTER: f64 = 2e-3;

/// A file in degrees whose constants are multiples of a quarter turn in radians.
fn radians_as_degrees(raw: &RawRobot, locate: Locate) -> Option<Diagnostic> {
    if raw.units.angle != Angle::Degree {
        return None;
    }
    let angles = raw.frames.iter().flat_map(|(name, frame)| {
        let of = [("alpha", frame.alpha), ("theta", frame.theta), ("gamma", frame.gamma), ("beta", frame.beta)];
        of.into_iter().filter_map(move |(key, value)| Some((name, key, value.filter(|value| *value != 0.0)?)))
    });
    let quarters = |value: f64| value.abs() / std::f64::consts::FRAC_PI_2;
    let is_radian = |value: f64| (quarters(value) - quarters(value).round()).abs() < QUARTER && quarters(value) > 0.5;
    let mut meant = angles.filter(|(.., value)| is_radian(*value) && value.abs() < 7.0);
    let (name, key, value) = meant.next()?;
    let more = meant.count();
    let also = if more > 0 { format!(", and {more} more like it") } else { String::new() };
    Some(
        Diagnostic::warning(format!("`{key}` of frame `{name}` is {value} deg, a quarter turn in rad{also}"))
            .code(Code::Implausible)
            .at(locate(&["frames", name, key]))
            .remedy("angles here are in deg: write 90, 180, -90, or declare `units: {angle: rad}`"),
    )
}

/// Widest limit of any joint, deg, from which limits read like angles in rad: one turn in rad.
const TURN: f64 = 6.3;
/// Joints with limits from which that is said: a few may be narrow on purpose.
const JOINTS: usize = 4;

/// A file in degrees whose joints can hardly turn.
fn limits_in_radians(raw: &RawRobot, locate: Locate) -> Option<Diagnostic> {
    let limits = raw.frames.iter().filter_map(|(name, frame)| {
        let limits = frame.limits.filter(|_| frame.joint == Some(JointKind::Revolute) && frame.variable.is_some())?;
        Some((name, limits.into_iter().fold(0.0, |most: f64, v| most.max(v.abs()))))
    });
    let limits: Vec<_> = limits.collect();
    let (name, widest) = limits.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    (raw.units.angle == Angle::Degree && limits.len() >= JOINTS && *widest <= TURN && *widest > 0.0).then(|| {
        Diagnostic::warning(format!("no joint may turn further than {widest} deg"))
            .code(Code::Implausible)
            .at(locate(&["frames", name, "limits"]))
            .remedy("limits here are in deg: if they are in rad, write them in deg, or declare `units: {angle: rad}`")
    })
}

/// Sum of the lengths of a robot's frames, m, of those that share an axis once, and of the travels of joints that slide.
fn reach(robot: &Robot) -> f64 {
    let of = |frame: &Frame| {
        let Constants { b, d, r, .. } = frame.constants;
        let shared = if frame.coaxial.is_some() { 0.0 } else { b.abs() + d.abs() };
        let travel = frame.limits.filter(|_| frame.joint == JointKind::Prismatic).map_or(0.0, |[low, high]| high - low);
        shared + r.abs() + if travel.is_finite() { travel.abs() } else { 0.0 }
    };
    robot.frames.iter().map(of).sum()
}

/// Greatest mass of a body, kg: the largest industrial robots weigh 12 t in all.
const HEAVIEST: f64 = 1e4;
/// Density of steel, kg/m3: a body is no heavier than a bar of steel as long as the robot's lengths together, a tenth as thick,
const STEEL: f64 = 7850.0;
/// or than this, kg: where a robot's lengths are not all written.
const LIGHT: f64 = 100.0;
/// A centre of mass lies within so many times the sum of the robot's lengths from its frame, or within `NEAR`.
const FARTHEST: f64 = 1.0;
/// Distance at which it is never doubted, m: where a robot's lengths are not all written.
const NEAR: f64 = 0.5;

/// Greatest mass (kg) that is not doubted, of a body of a robot whose lengths add up to so much (m).
pub fn heaviest(lengths: f64) -> f64 {
    (STEEL * lengths * (0.1 * lengths).powi(2)).clamp(LIGHT, HEAVIEST)
}

/// Masses that no robot has.
fn heavy(raw: &RawRobot, reach: f64, locate: Locate) -> Vec<Diagnostic> {
    let (unit, heaviest) = (raw.units.mass, heaviest(reach));
    let of = |(name, mass): (&String, Option<f64>)| {
        let heavy = mass.map(|value| value * unit.factor()).filter(|kg| *kg > heaviest)?;
        let warning = Diagnostic::warning(format!(
            "body `{name}` has a mass of {heavy:.3e} kg, in a robot whose lengths add up to {reach:.2} m"
        ));
        let remedy = format!("masses here are in {}: check the value", unit.symbol());
        Some(warning.code(Code::Implausible).at(locate(&["bodies", name, "mass"])).remedy(remedy))
    };
    raw.bodies.iter().map(|(name, body)| (name, body.mass)).filter_map(of).collect()
}

/// Masses that no robot has, and centres of mass that lie outside it.
fn heavy_or_far(raw: &RawRobot, reach: f64, locate: Locate) -> Vec<Diagnostic> {
    let length = raw.units.length;
    let mut all = heavy(raw, reach, locate);
    for (name, body) in &raw.bodies {
        let far = body.com.map(|com| norm(&com) * length.factor());
        if let Some(far) = far.filter(|far| *far > (FARTHEST * reach).max(NEAR)) {
            let warning = Diagnostic::warning(format!(
                "the centre of mass of body `{name}` lies {far:.2} m from its frame, where all lengths of the robot together are {reach:.2} m"
            ));
            let remedy = format!("centres are in the body's frame, in {}: check values and units", length.symbol());
            all.push(warning.code(Code::Implausible).at(locate(&["bodies", name, "com"])).remedy(remedy));
        }
    }
    all.extend(light(raw, reach, locate));
    all
}

/// Least mass of a robot over the sum of its lengths, kg/m: small desktop arms have two.
const LIGHTEST: f64 = 0.5;

/// Masses that together no robot has.
fn light(raw: &RawRobot, reach: f64, locate: Locate) -> Option<Diagnostic> {
    let unit = raw.units.mass;
    let masses = raw.bodies.iter().filter_map(|(name, body)| Some((name, body.mass.filter(|mass| *mass > 0.0)?)));
    let masses: Vec<(&String, f64)> = masses.collect();
    let all = masses.iter().map(|(_, mass)| mass * unit.factor()).sum::<f64>();
    let (name, _) = masses.first().filter(|_| masses.len() >= CENTRES && all < LIGHTEST * reach)?;
    let message = format!("all bodies together weigh {all:.3} kg, in a robot whose lengths add up to {reach:.2} m");
    let remedy = format!("masses here are in {}: check the values", unit.symbol());
    let place = locate(&["bodies", name, "mass"]);
    Some(Diagnostic::warning(message).code(Code::Implausible).at(place).remedy(remedy))
}

/// Bodies with a centre of mass from which a common error of unit is believed, and the part of the robot's lengths within which all
/// centres of mass lie then: an arm's links are not all balanced about their frames to a thousandth.
const CENTRES: usize = 2;
const BALANCED: f64 = 1e-3;

/// A file in mm whose centres of mass are in metres.
fn centres_in_metres(raw: &RawRobot, reach: f64, locate: Locate) -> Option<Diagnostic> {
    // In the file's unit, as the centres are.
    let reach = reach / raw.units.length.factor();
    let size = |com: [f64; 3]| norm(&com);
    let off: Vec<(&String, f64)> = raw
        .bodies
        .iter()
        .filter_map(|(name, body)| Some((name, size(body.com?))))
        .filter(|(_, far)| *far > 0.0)
        .collect();
    let (name, farthest) = off.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let unit = raw.units.length.symbol();
    let are_metres = raw.units.length != Length::Metre && off.len() >= CENTRES && *farthest < BALANCED * reach;
    are_metres.then(|| {
        Diagnostic::warning(format!(
            "the centres of mass of all bodies lie within {farthest:.3} {unit} of their frames, where the lengths of the robot add up to {reach:.0} {unit}"
        ))
        .code(Code::Implausible)
        .at(locate(&["bodies", name, "com"]))
        .remedy(format!("centres are in {unit}: if these are in m, write them in {unit}"))
    })
}

/// Part of the distance at which the centres of mass of all bodies lie (by the median) below which that of a heavy body is doubted. A judgement.
const NEARER: f64 = 2e-2;
/// Distance of a centre of mass from its frame, m, below which it looks like a number of metres among millimetres.
pub(super) const CENTRED: f64 = 1e-3;

/// Bodies as heavy as half of them at least, in a file that is not in metres, whose centres of mass lie hundreds of times nearer to
/// their frames than those of the others: light parts of a wrist may be balanced so well.
fn heavy_centres_in_metres(raw: &RawRobot, locate: Locate) -> Option<Diagnostic> {
    let size = |com: [f64; 3]| norm(&com);
    let off: Vec<(&String, f64, f64)> = raw
        .bodies
        .iter()
        .filter_map(|(name, body)| Some((name, body.mass?, size(body.com?))))
        .filter(|(_, mass, far)| *mass > 0.0 && *far > 0.0)
        .collect();
    let usual = median(&mut off.iter().map(|(.., far)| *far).collect::<Vec<f64>>())?;
    let heavy = median(&mut off.iter().map(|(_, mass, _)| *mass).collect::<Vec<f64>>())?;
    let most = (NEARER * usual).min(CENTRED / raw.units.length.factor());
    let near: Vec<_> = off.iter().filter(|(_, mass, far)| *mass >= heavy && *far < most).collect();
    let (name, _, far) = near.first().filter(|_| raw.units.length != Length::Metre)?;
    let unit = raw.units.length.symbol();
    let names: Vec<String> = near.iter().map(|(name, ..)| format!("`{name}`")).collect();
    let message = format!(
        "the centre of mass of body {} lies within {far:.3} {unit} of its frame, where those of others lie {usual:.0} {unit} from theirs",
        names.join(", ")
    );
    let diagnostic = Diagnostic::warning(message).code(Code::Implausible).at(locate(&["bodies", name, "com"]));
    Some(diagnostic.remedy(format!("centres are in {unit}: if this one is in m, write it in {unit}")))
}

/// Least and greatest acceleration of gravity on the ground, m/s2, with room: 9.764 on a mountain at the equator, 9.834 at a pole.
const GRAVITY: [f64; 2] = [9.7, 9.9];

/// Gravity of another planet, or in another unit; none at all is said on purpose.
fn other_gravity(raw: &RawRobot, locate: Locate) -> Option<Diagnostic> {
    let size = raw.gravity?.iter().map(|v| v * v).sum::<f64>().sqrt();
    let is_usual = (GRAVITY[0]..=GRAVITY[1]).contains(&size);
    (size > 0.0 && size.is_finite() && !is_usual).then(|| {
        Diagnostic::warning(format!("gravity is {size} m/s2"))
            .code(Code::WrongUnits)
            .at(locate(&["gravity"]))
            .remedy("give it in m/s2, whatever the units of the description: [0, 0, -9.81] of a standing arm")
    })
}

fn rounded(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}
