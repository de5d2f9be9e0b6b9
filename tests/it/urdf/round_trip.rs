//! Read, and written and read again, a robot stays where it was.

use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Write;

use elastogeo::description::raw::{JointKind, RawBody, RawFrame, RawLoop, RawMarker, RawRobot};
use elastogeo::description::units::{Angle, Length, Mass};
use elastogeo::description::urdf::{export, import};
use elastogeo::diagnostic::{Diagnostic, Severity};
use indexmap::IndexMap;
use nalgebra::{Isometry3, Point3};
use proptest::prelude::*;

use super::forward::{Values, apart, assert_same, of_description, of_urdf};

const ARM: &str = include_str!("../../data/urdf/arm.urdf");

fn values<const N: usize>(list: [(&str, f64); N]) -> Values {
    list.map(|(name, value)| (name.to_owned(), value)).into_iter().collect()
}

fn read(text: &str) -> (RawRobot, Vec<Diagnostic>) {
    import("test.urdf", text).unwrap_or_else(|diagnostics| panic!("{diagnostics:#?}\n{text}"))
}

/// Asserts that the exported text puts every frame of the description where it was, and so does what is read from it.
fn assert_exported(robot: &RawRobot, values: &Values, urdf_values: &Values) -> (String, RawRobot) {
    let (text, _) = export(robot).unwrap_or_else(|diagnostics| panic!("{diagnostics:#?}"));
    let (before, between) = (of_description(robot, values), of_urdf(&text, urdf_values));
    for name in robot.frames.keys() {
        let apart = apart(&between[name], &before[name]);
        assert!(apart < 1e-12, "{name}: {apart:e} apart\n{text}");
    }
    let (again, _) = read(&text);
    assert_same(&text, &again, urdf_values, 1e-12);
    let after = of_description(&again, urdf_values);
    for name in robot.frames.keys() {
        let apart = apart(&after[name], &before[name]);
        assert!(apart < 1e-12, "{name} comes back {apart:e} apart\n{text}");
    }
    (text, again)
}

#[test]
fn an_arm_with_everything() {
    let (robot, diagnostics) = read(ARM);
    for k in 0..20 {
        let s = f64::from(k) * 0.37;
        let at =
            [("waist", s.sin()), ("shoulder", 3.0 * s), ("reach", 0.2 * s.cos()), ("elbow", -s), ("bend", s.sin())];
        assert_same(ARM, &robot, &values(at), 1e-12);
        assert_exported(&robot, &values(at), &values(at));
    }
    // Gamma and b are needed at the base and on side branches only.
    let spare: Vec<&str> = robot
        .frames
        .iter()
        .filter(|(_, frame)| frame.gamma.is_none() && frame.b.is_none())
        .map(|(name, _)| name.as_str())
        .collect();
    assert_eq!(spare, ["shoulder", "reach", "elbow", "roll", "bend"]);
    assert!(robot.frames.values().all(|frame| frame.beta.is_none()));
    assert_eq!(robot.couplings, ["roll = -0.5 * elbow"]);
    assert_eq!(robot.frames["roll"].variable, None);
    // The mimic's offset has gone into theta, and so out of the limits.
    assert_eq!(robot.frames["roll"].limits, Some([-3.25, 2.75]));
    assert_eq!(robot.frames["shoulder"].limits, None);
    assert_eq!(robot.tool.frame.as_deref(), Some("hand-tool0"));
    let said: Vec<&str> = diagnostics.iter().map(|diagnostic| diagnostic.message.as_str()).collect();
    assert_eq!(
        said,
        [
            "elements that are not read: `gazebo` (1), `transmission` (1)",
            "several links carry nothing; their frames are `bracket`, `hand-tool0`",
        ]
    );
}

#[test]
fn a_centre_of_mass_stays_in_its_body() {
    let (robot, _) = read(ARM);
    assert_eq!(robot.bodies.keys().collect::<Vec<_>>(), ["waist", "reach"]);
    let at = values([("waist", 0.4), ("shoulder", -1.0), ("reach", 0.3)]);
    let (urdf, ours) = (of_urdf(ARM, &at), of_description(&robot, &at));
    for (joint, com) in [("waist", Point3::new(0.1, -0.02, 0.3)), ("reach", Point3::origin())] {
        let found = ours[joint] * Point3::from(robot.bodies[joint].com.unwrap_or_default());
        assert!((found - urdf[joint] * com).norm() < 1e-13, "{joint}");
    }
    assert_eq!(robot.bodies["waist"].mass, Some(41.5));
}

#[test]
fn a_leaf_that_moves_gives_the_tool_its_link_frame() {
    for axis in ["1 0 0", "0 1 0", "0 0 -1", "0.6 0 -0.8"] {
        let text = format!(
            r#"<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="continuous">
            <parent link="a"/><child link="b"/><origin xyz="1 2 3" rpy="0.1 0.2 0.3"/><axis xyz="{axis}"/></joint></robot>"#
        );
        let (robot, _) = read(&text);
        assert!(robot.tool.rotation.is_some());
        assert_same(&text, &robot, &values([("j", 0.7)]), 1e-12);
    }
}

#[test]
fn quarter_turns_come_out_clean() {
    // Axes as most files have them: every frame parallel to the base, axes along x, y or z; a pi/2 of eleven decimals.
    let text = r#"<robot name="r"><link name="0"/><link name="1"/><link name="2"/><link name="3"/><link name="4"/>
      <joint name="a" type="continuous"><parent link="0"/><child link="1"/><origin xyz="0 0 0.4865"/><axis xyz="0 0 1"/></joint>
      <joint name="b" type="continuous"><parent link="1"/><child link="2"/><origin xyz="0.15 0 0"/><axis xyz="0 1 0"/></joint>
      <joint name="c" type="continuous"><parent link="2"/><child link="3"/><origin xyz="0 0 0.475"/><axis xyz="0 1 0"/></joint>
      <joint name="d" type="continuous"><parent link="3"/><child link="4"/><origin xyz="0.6 0 0.02" rpy="0 1.57079632679 0"/></joint>
    </robot>"#;
    let (robot, _) = read(text);
    let table: Vec<[f64; 7]> = robot
        .frames
        .values()
        .map(|f| [f.beta, f.gamma, f.b, f.alpha, f.d, f.theta, f.r].map(|constant| constant.unwrap_or(0.0)))
        .collect();
    let q = FRAC_PI_2;
    assert_eq!(
        table,
        [
            [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.4865],
            [0.0, 0.0, 0.0, -q, 0.15, -q, 0.0],
            [0.0, 0.0, 0.0, 0.0, 0.475, q, 0.0],
            [0.0, 0.0, 0.0, -q, 0.6, PI, -0.02],
        ]
    );
}

#[test]
fn a_tilt_too_small_to_mean_is_kept_and_warned_of() {
    let text = |pi: &str| {
        format!(
            r#"<robot name="r"><link name="l0"/><link name="l1"/><link name="l2"/>
      <joint name="a" type="continuous"><parent link="l0"/><child link="l1"/><axis xyz="0 0 1"/></joint>
      <joint name="b" type="continuous"><parent link="l1"/><child link="l2"/><origin xyz="1 0 0.1" rpy="0 {pi} 0"/><axis xyz="-1 0 0"/></joint>
    </robot>"#
        )
    };
    let (robot, diagnostics) = read(&text("1.5708"));
    assert_same(&text("1.5708"), &robot, &values([("a", 0.3), ("b", 0.4)]), 1e-12);
    let frame = &robot.frames["b"];
    assert!((frame.beta.unwrap().abs() - 3.67e-6).abs() < 1e-8 && (frame.d.unwrap() - 1.0).abs() < 1e-5, "{frame:?}");
    assert_eq!((frame.gamma, frame.b), (None, None));
    assert_eq!(diagnostics.len(), 1);
    assert!(diagnostics[0].message.contains("3.7e-6 rad from parallel"), "{diagnostics:?}");
    let (robot, diagnostics) = read(&text("1.57079632679489661923"));
    assert_eq!((robot.frames["b"].beta, diagnostics), (None, vec![]));
}

/// A description in millimetres and degrees with what a URDF can say, and some of what it cannot.
fn described() -> RawRobot {
    let mut robot = RawRobot { robot: Some("A & B <\"test\">".to_owned()), ..RawRobot::default() };
    robot.source = Some("drawing 7 -- the rest is assumed --".to_owned());
    (robot.units.length, robot.units.angle, robot.units.mass) = (Length::Millimetre, Angle::Degree, Mass::Gram);
    let frame = |antecedent: &str, constants: [f64; 7], joint: JointKind, variable: Option<&str>| {
        let [beta, gamma, b, alpha, d, theta, r] = constants.map(Some);
        let (antecedent, variable) = (Some(antecedent.to_owned()), variable.map(str::to_owned));
        RawFrame { antecedent, joint: Some(joint), variable, beta, gamma, b, alpha, d, theta, r, ..RawFrame::default() }
    };
    use JointKind::{Fixed, Prismatic, Revolute};
    let mut add = |name: &str, frame: RawFrame| robot.frames.insert(name.to_owned(), frame);
    let first = frame("0", [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 885.0], Revolute, Some("q1"));
    add("1", RawFrame { direction: Some(-1.0), offset: Some(0.4), limits: Some([-185.0, 185.0]), ..first });
    let second = frame("1", [0.0, 0.0, 0.0, -90.0, 350.0, -90.0, 0.0], Revolute, Some("q2"));
    add("2", RawFrame { limits: Some([-146.0, 0.0]), ..second });
    add("3'", frame("2", [0.02, 0.0, 0.0, 90.0, 1250.0, 180.0, -3.0], Revolute, None));
    let slide = frame("3'", [0.0, 30.0, 12.0, 90.0, 0.0, 90.0, 100.0], Prismatic, Some("a&b \"<"));
    add("slide", RawFrame { direction: Some(-1.0), offset: Some(2.0), limits: Some([-50.0, 500.0]), ..slide });
    let wrist = frame("slide", [0.0, 0.0, 0.0, -90.0, 0.0, 10.0, 0.0], Revolute, None);
    add("5", RawFrame { direction: Some(-1.0), offset: Some(1.0), limits: Some([-10.0, 90.0]), ..wrist });
    add("E", frame("5", [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 230.0], Fixed, None));
    let side = RawFrame { coaxial: Some("2".to_owned()), passive: true, ..frame("1", [0.0; 7], Revolute, None) };
    let side = RawFrame { beta: None, gamma: None, b: None, alpha: None, d: None, ..side };
    add("8", RawFrame { theta: Some(5.0), r: Some(20.0), ..side });
    robot.couplings = vec!["3' = -1 * 2".to_owned(), "5 = 2.5 * 1".to_owned()];
    let frames = Some(["8".to_owned(), "slide".to_owned()]);
    let branch = IndexMap::from([("8".to_owned(), 0.0)]);
    robot.loops.insert("four-bar".to_owned(), RawLoop { frames, branch, ..RawLoop::default() });
    robot.bodies.insert("2".to_owned(), RawBody { mass: Some(220e3), com: Some([520.0, 1.0, 0.0]) });
    (robot.tool.frame, robot.tool.at, robot.tool.rotation) =
        (Some("E".to_owned()), Some([10.0, 0.0, 100.0]), Some([0.0, 90.0, 0.0]));
    robot.markers.insert("m1".to_owned(), RawMarker { frame: None, at: Some([-94.0, 46.5, 47.0]) });
    robot.markers.insert("base_link".to_owned(), RawMarker { frame: Some("0".to_owned()), at: None });
    robot
}

#[test]
fn a_description_in_other_units_is_written_in_si() {
    let robot = described();
    for k in 0..8 {
        let (a, b, c, d) = (0.3 * f64::from(k), -0.2 * f64::from(k), 0.05 * f64::from(k), 0.7);
        let ours = values([("q1", a), ("q2", b), ("a&b \"<", c)]);
        let theirs = values([("1", a), ("2", b), ("slide", c)]);
        let (text, again) = assert_exported(&robot, &ours, &theirs);
        let (before, after) = (of_description(&robot, &ours), of_urdf(&text, &theirs));
        let tool = Isometry3::new([0.01, 0.0, 0.1].into(), [0.0, FRAC_PI_2, 0.0].into());
        assert!(apart(&after["tool0"], &(before["E"] * tool)) < 1e-12);
        assert!(apart(&after["m1"], &(before["E"] * Isometry3::translation(-0.094, 0.0465, 0.047))) < 1e-12);
        assert!(apart(&after["base_link_"], &Isometry3::identity()) < 1e-15);
        assert_eq!(again.tool.frame.as_deref(), Some("tool0"));
        assert_eq!(again.robot, robot.robot);
        assert_eq!(again.bodies["2"], RawBody { mass: Some(220.0), com: Some([0.52, 0.001, 0.0]) });
        assert_eq!(again.frames["1"].limits, Some([-185.0, 185.0].map(f64::to_radians)));
        assert_eq!(again.frames["slide"].limits, Some([-0.05, 0.5]));
        assert_eq!((again.frames["1"].direction, again.frames["2"].direction), (Some(-1.0), None));
        assert_eq!(again.couplings, ["3' = -1 * 2", "5 = 2.5 * 1"]);
        // A passive joint can be set.
        let turned = of_urdf(&text, &values([("8", d)]));
        assert!(apart(&turned["8"], &of_urdf(&text, &Values::new())["8"]) > 0.1);
    }
    let (_, diagnostics) = export(&robot).unwrap();
    assert!(diagnostics.iter().all(|diagnostic| diagnostic.severity == Severity::Warning));
    let said: Vec<&str> = diagnostics.iter().map(|diagnostic| diagnostic.message.as_str()).collect();
    assert_eq!(
        said,
        ["a URDF cannot close loops (`four-bar`)", "inertia tensors are written as zero: the description has none",]
    );
}

#[test]
fn what_cannot_be_written_is_refused_with_every_reason() {
    let mut robot = described();
    robot.frames["E"].antecedent = Some("55".to_owned());
    robot.frames["2"].antecedent = Some("slide".to_owned());
    robot.frames["5"].alpha = Some(f64::NAN);
    robot.frames["8"].antecedent = None;
    robot.couplings.push("7 = 1 * 1".to_owned());
    robot.couplings.push("7 =".to_owned());
    let said: Vec<String> = export(&robot).unwrap_err().into_iter().map(|diagnostic| diagnostic.message).collect();
    for part in ["`55`", "circle", "`NaN`", "`8` has no antecedent", "`7`", "`7 =`"] {
        assert!(said.iter().any(|message| message.contains(part)), "{part}: {said:#?}");
    }
    let mut robot = described();
    robot.tool = Default::default();
    // The end of a loop carries no tool; without the loop there are two ends.
    let (text, _) = export(&robot).unwrap();
    assert!(text.split("<joint name=\"m1\"").nth(1).unwrap().contains("<parent link=\"E\"/>"));
    robot.loops.clear();
    (robot.frames["8"].passive, robot.frames["8"].variable) = (false, Some("q8".to_owned()));
    let said = export(&robot).unwrap_err();
    assert!(said.iter().any(|diagnostic| diagnostic.message.contains("tool's frame is not clear")), "{said:#?}");
    robot.frames.insert("\u{1}".to_owned(), RawFrame { antecedent: Some("0".to_owned()), ..RawFrame::default() });
    assert!(export(&robot).unwrap_err().iter().any(|diagnostic| diagnostic.message.contains("XML cannot hold")));
}

#[test]
fn a_joint_that_follows_two_is_written_with_a_warning() {
    let mut robot = described();
    robot.couplings[1] = "5 = 2.5 * 1 - 2".to_owned();
    let (text, diagnostics) = export(&robot).unwrap();
    assert!(
        diagnostics.iter().any(|diagnostic| diagnostic.message.contains("follows several others")),
        "{diagnostics:?}"
    );
    assert_eq!(text.matches("<mimic").count(), 1);
}

/// One random joint: parent, kind, origin, axis, mimic.
type Piece = (prop::sample::Index, u8, [f64; 3], [f64; 3], [f64; 3], f64);

fn angle() -> impl Strategy<Value = f64> {
    prop_oneof![
        2 => -PI..PI,
        3 => (-2_i32..=2).prop_map(|k| f64::from(k) * FRAC_PI_2),
        1 => ((-2_i32..=2), -10.0..-2.0_f64).prop_map(|(k, e)| f64::from(k) * FRAC_PI_2 + 10_f64.powf(e)),
    ]
}

fn length() -> impl Strategy<Value = f64> {
    prop_oneof![2 => -2.0..2.0_f64, 2 => Just(0.0), 1 => Just(0.35)]
}

fn axis() -> impl Strategy<Value = [f64; 3]> {
    let unit = (0_usize..3, any::<bool>()).prop_map(|(k, up)| {
        let mut axis = [0.0; 3];
        axis[k] = if up { 1.0 } else { -1.0 };
        axis
    });
    let any = [-1.0..1.0_f64, -1.0..1.0, -1.0..1.0].prop_filter("too short", |v| v.iter().any(|x| x.abs() > 0.05));
    prop_oneof![3 => unit, 1 => any]
}

fn piece() -> impl Strategy<Value = Piece> {
    (
        any::<prop::sample::Index>(),
        0_u8..8,
        [length(), length(), length()],
        [angle(), angle(), angle()],
        axis(),
        -2.0..2.0_f64,
    )
}

/// The URDF of these joints; a fixed link at the end of each.
fn written(pieces: &[Piece]) -> String {
    let mut text = String::from("<robot name=\"random\"><link name=\"l\"/>");
    let mut movers: Vec<usize> = Vec::new();
    for (k, (parent, kind, xyz, rpy, axis, number)) in pieces.iter().enumerate() {
        // Mostly a chain.
        let parent = match k {
            0 => "l".to_owned(),
            _ if *kind < 6 => format!("l{}", k - 1),
            _ => format!("l{}", parent.index(k)),
        };
        let kind = ["continuous", "revolute", "prismatic", "continuous", "continuous", "fixed", "revolute", "fixed"]
            [usize::from(*kind)];
        let triple = |[a, b, c]: &[f64; 3]| format!("{a:?} {b:?} {c:?}");
        let (xyz, rpy, axis) = (triple(xyz), triple(rpy), triple(axis));
        let mimic = match movers.last() {
            Some(master) if kind == "revolute" && *number > 0.0 => {
                format!("<mimic joint=\"j{master}\" multiplier=\"{number}\" offset=\"{}\"/>", number - 1.5)
            }
            _ => String::new(),
        };
        if kind != "fixed" {
            movers.push(k);
        }
        write!(
            text,
            "<link name=\"l{k}\"/><joint name=\"j{k}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"l{k}\"/>
             <origin xyz=\"{xyz}\" rpy=\"{rpy}\"/><axis xyz=\"{axis}\"/>{mimic}</joint>
             <link name=\"e{k}\"/><joint name=\"f{k}\" type=\"fixed\"><parent link=\"l{k}\"/><child link=\"e{k}\"/>
             <origin xyz=\"{rpy}\" rpy=\"{xyz}\"/></joint>"
        )
        .unwrap();
    }
    text + "</robot>"
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn any_urdf_is_where_it_was(pieces in prop::collection::vec(piece(), 1..9), q in prop::array::uniform9(-3.0..3.0_f64)) {
        let text = written(&pieces);
        let (robot, _) = read(&text);
        let at: Values = q.iter().enumerate().map(|(k, &value)| (format!("j{k}"), value)).collect();
        assert_same(&text, &robot, &at, 1e-12);
        assert_same(&text, &robot, &Values::new(), 1e-12);
        let urdf: Values = at.clone();
        assert_exported(&robot, &at, &urdf);
    }

    #[test]
    fn any_table_is_where_it_was(
        rows in prop::collection::vec((prop::array::uniform4(angle()), prop::array::uniform3(length()), any::<bool>()), 1..8),
        q in prop::array::uniform8(-3.0..3.0_f64),
    ) {
        let mut frames = IndexMap::new();
        let mut antecedent = "0".to_owned();
        for (k, ([beta, gamma, alpha, theta], [b, d, r], turns)) in rows.iter().enumerate() {
            let [beta, gamma, b, alpha, d, theta, r] = [beta, gamma, b, alpha, d, theta, r].map(|value| Some(*value));
            let joint = Some(if *turns { JointKind::Revolute } else { JointKind::Prismatic });
            let (name, variable) = (format!("j{k}"), Some(format!("j{k}")));
            let frame = RawFrame { antecedent: Some(antecedent), joint, variable, ..RawFrame::default() };
            frames.insert(name.clone(), RawFrame { beta, gamma, b, alpha, d, theta, r, ..frame });
            antecedent = name;
        }
        let at: Values = q.iter().enumerate().map(|(k, &value)| (format!("j{k}"), value)).collect();
        assert_exported(&RawRobot { frames, ..RawRobot::default() }, &at, &at);
    }
}
