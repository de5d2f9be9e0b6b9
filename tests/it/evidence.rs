//! What a campaign can say of its evidence: sessions, contacts, unknown anchors, payloads, order, noise of each reading.

use crate::real_data::folder;
use std::path::Path;

use elastogeo::description::campaign::{Campaign, InSession, Payload, Sessions, Sharing, Target, TargetValue};
use elastogeo::diagnostic::Diagnostic;
use elastogeo::estimation::{Calibration, Settings, What, calibrate, split};
use elastogeo::files::{LoadedRobot, load_campaign, load_robot};
use elastogeo::identifiability::Criterion;
use elastogeo::kinematics::{Geometry, Placements};
use elastogeo::model::Model;
use elastogeo::observation::{DISTANCE, POSE, POSITION};
use elastogeo::parameter::Kind;
use elastogeo::plausibility::{Evidence, Limits, judge};
use elastogeo::prediction::{Linearised, Predictor};
use elastogeo::simulation::{Plan, draw_configurations, draw_errors, generator, measure, unmeasured};
use nalgebra::{Point3, Vector3};

use super::cli::run;
use crate::support::assert_derivatives_agree;

fn blank(
    robot: &LoadedRobot,
    observes: elastogeo::observation::Observes,
    count: usize,
    estimate: [bool; 2],
) -> Campaign {
    let geometry = Geometry::nominal(&robot.model).expect("assembled");
    let plan = Plan {
        configurations: draw_configurations(&geometry, count, 0.7, &mut generator(11)).expect("drawn"),
        markers: vec![None],
        repeats: 1,
        wrenches: Vec::new(),
        conditions: false,
        observes,
        sigma: 3e-5,
        sigma_orientation: 3e-5,
        estimate,
    };
    unmeasured(&robot.model, &plan)
}

fn fitted(model: &Model, campaign: &Campaign) -> Calibration {
    let held_out = split(campaign, 0.25, 1);
    calibrate(model, campaign, &held_out, &Settings::default(), &mut |_| {}).expect("calibrated")
}

/// Two sessions, between which the base was set up elsewhere and the tool was mounted anew.
fn two_sessions(robot: &LoadedRobot) -> (Campaign, Model, Vec<f64>) {
    let mut campaign = blank(robot, POSITION, 60, [true, true]);
    let names = ["monday", "friday"].map(String::from).to_vec();
    campaign.sessions = Sessions { names, base: Sharing::PerSession, tool: Sharing::PerSession, ..Sessions::default() };
    for (index, reading) in campaign.readings.iter_mut().enumerate() {
        reading.session = InSession { session: index % 2, station: 0 };
    }
    let model = robot.model.arranged(&campaign);
    let mut truth = model.registry.nominal();
    let drawn = draw_errors(&robot.model, 1.0, 0.0, &mut generator(12));
    truth[..drawn.len()].copy_from_slice(&drawn);
    for (session, sign) in [(0, 1.0), (1, -1.0)] {
        let of = InSession { session, station: 0 };
        for (k, value) in [1.2, -0.4, 0.3, 0.2, -0.1, 2.0].into_iter().enumerate() {
            truth[model.base_slot(of) + k] = sign * value;
        }
        truth[model.tool_slot(of)] += sign * 0.03;
    }
    let campaign = measure(&model, &truth, campaign, [3e-5, 3e-5], &mut generator(13)).expect("measured");
    (campaign, model, truth)
}

#[test]
fn each_session_has_its_own_base_and_tool() {
    let robot = load_robot("universal-ur5").expect("bundled");
    let (campaign, model, truth) = two_sessions(&robot);
    let found = fitted(&model, &campaign);
    assert!(found.after.check.distance[1] < 1.5e-4, "{:?}", found.after.check);
    assert!((0.8..1.2).contains(&found.noise_ratio), "{}", found.noise_ratio);
    // What is shared is the robot; bases are told apart by metres.
    let [one, two] = ["base@monday.x", "base@friday.x"].map(|name| {
        let slot = model.registry.slot(name).expect("a parameter");
        (found.values[slot], truth[slot])
    });
    assert!((one.0 - one.1).abs() < 0.02 && (two.0 - two.1).abs() < 0.02, "{one:?} {two:?}");
    // One base for both cannot serve.
    let mut shared = campaign.clone();
    shared.sessions.base = Sharing::All;
    let poor = fitted(&robot.model.arranged(&shared), &shared);
    assert!(poor.after.check.distance[1] > 0.1, "{:?}", poor.after.check);
}

#[test]
fn derivatives_of_sessions_agree_with_differences() {
    let robot = load_robot("universal-ur5").expect("bundled");
    let (campaign, model, truth) = two_sessions(&robot);
    let slots: Vec<usize> = (robot.model.registry.all().len()..model.registry.all().len()).collect();
    assert_derivatives_agree(&model, &campaign, &truth, &slots);
}

#[test]
fn an_unknown_anchor_and_the_zero_of_a_draw_wire_are_found() {
    let robot = load_robot("universal-ur5").expect("bundled");
    let mut campaign = blank(&robot, DISTANCE, 150, [false, true]);
    let value =
        |symbol: &str| TargetValue { value: 0.0, kind: Kind::Length, parameter: Some(format!("wire.{symbol}")) };
    let target = Target {
        values: ["x", "y", "z", "zero"].map(value).to_vec(),
        has_start: false,
        ..Target::anchor("wire", &Vector3::zeros())
    };
    campaign.targets = vec![target];
    campaign.readings.iter_mut().for_each(|reading| reading.target = Some(0));
    let model = robot.model.arranged(&campaign);
    let mut truth = model.registry.nominal();
    let expected = [0.9, -0.7, 0.2, 0.0123];
    for (slot, value) in model.target_values(0).to_vec().into_iter().zip(expected) {
        truth[slot.expect("unknown")] = value;
    }
    let campaign = measure(&model, &truth, campaign, [3e-5, 0.0], &mut generator(5)).expect("measured");
    let found = fitted(&model, &campaign);
    assert!(found.after.check.distance[1] < 6e-5, "{:?}", found.after.check);
    // The robot's own errors are not known better than the readings say; the zero is a length of its own.
    let zero = model.registry.slot("wire.zero").expect("a parameter");
    let estimate = found.estimates.iter().find(|estimate| estimate.slot == zero).expect("a candidate");
    let ci95 = estimate.ci95.expect("identifiable");
    assert!((estimate.value - 0.0123).abs() < 2.0 * ci95 && ci95 < 2e-3, "{} +- {ci95}", estimate.value);
}

/// The weight of a payload is the wrench that it exerts at the measured point.
#[test]
fn a_payload_loads_as_its_weight_does() {
    let robot = load_robot("kuka-kr270").expect("bundled");
    let model = &robot.model;
    let mut campaign = blank(&robot, POSE, 6, [false, false]);
    let payload = Payload { mass: 200.0, com: Vector3::new(0.1, -0.05, 0.3), frame: model.tool.0 };
    let mut by_hand = campaign.clone();
    campaign.readings.iter_mut().for_each(|reading| reading.payload = Some(payload));
    let geometry = Geometry::nominal(model).expect("assembled");
    let mut placements = Placements::default();
    for index in 0..by_hand.readings.len() {
        geometry.place(by_hand.configuration(index), &mut placements).expect("placed");
        let frame = placements.frames[model.tool.0];
        let point = (frame * geometry.tool()).translation.vector;
        let weight = payload.mass * model.structure.gravity;
        let moment = ((frame * Point3::from(payload.com)).coords - point).cross(&weight);
        by_hand.readings[index].wrench = [weight.x, weight.y, weight.z, moment.x, moment.y, moment.z];
    }
    let at = |campaign: &Campaign| {
        let mut found = Linearised::default();
        let predictor = Predictor::new(model, campaign, Vec::new()).expect("a predictor");
        predictor.linearise(&model.registry.nominal(), false, &mut found).expect("predicted");
        found.residual
    };
    let (ours, wrench) = (at(&campaign), at(&by_hand));
    let nothing = at(&blank(&robot, POSE, 6, [false, false]));
    assert!(ours.iter().zip(&wrench).all(|(a, b)| (a - b).abs() < 1e-12));
    assert!(ours.iter().zip(&nothing).any(|(a, b)| (a - b).abs() > 1e-4), "200 kg bend the robot");
}

#[test]
fn derivatives_under_a_payload_agree_with_differences() {
    let robot = load_robot("kuka-kr270").expect("bundled");
    let model = &robot.model;
    let mut campaign = blank(&robot, POSE, 3, [false, false]);
    let payload = Payload { mass: 2000.0, com: Vector3::new(0.3, -0.2, 0.5), frame: model.tool.0 };
    campaign.readings.iter_mut().for_each(|reading| reading.payload = Some(payload));
    let slots: Vec<usize> =
        (model.tool.1..model.tool.1 + 3).chain(model.free_slots()).chain(model.elastic_slots()).collect();
    let values = model.registry.nominal();
    let predictor = Predictor::new(model, &campaign, slots.clone()).expect("a predictor").with_sag();
    let (mut at, mut up, mut down) = (Linearised::default(), Linearised::default(), Linearised::default());
    predictor.linearise(&values, true, &mut at).expect("linearised");
    for (column, &slot) in slots.iter().enumerate() {
        let step = 1e-3 * model.registry[slot].tolerance;
        for (step, out) in [(step, &mut up), (-step, &mut down)] {
            let mut moved = values.clone();
            moved[slot] += step;
            predictor.linearise(&moved, false, out).expect("predicted");
        }
        for (reading, (up, down)) in up.predicted.iter().zip(&down.predicted).enumerate() {
            for row in 0..3 {
                let difference = (up[row] - down[row]) / (2.0 * step);
                let ours = at.jacobian[(6 * reading + row) * slots.len() + column];
                let near = 2e-5 * ours.abs() + 1e-13 / step;
                assert!(
                    (ours - difference).abs() < near,
                    "{}, row {row}: {ours} {difference}",
                    model.registry[slot].name
                );
            }
        }
    }
}

const PLANAR_CONTACT: &str = "robot: arm.yaml
units: {length: mm, angle: deg}
observes: contact
contacts: {hole: {kind: socket, group: placement}, pin: {kind: socket, group: placement}}
distances: {hole-pin: 50}
measurements: c.csv
";
const TABLE: &str = "pose,placement,contact,q1,q2\na,left,hole,0,90\nb,left,pin,10,80\n";

fn said(campaign: &str, table: &str) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    write("arm.yaml", super::cli::PLANAR);
    write("campaign.yaml", campaign);
    write("c.csv", table);
    let ran = run(folder.path(), &["check", "campaign.yaml"]);
    format!("{}\n{}{}", ran.status, ran.out, ran.err)
}

#[test]
fn wrong_evidence_is_refused_with_place_and_remedy() {
    let right = said(PLANAR_CONTACT, TABLE);
    assert!(right.starts_with("0\n"), "{right}");
    let of_campaign = [
        ("kind: socket,", "kind: sokcet,", &["campaign.yaml:4", "sokcet", "socket"][..]),
        ("hole-pin: 50", "hole-pni: 50", &["campaign.yaml:5", "names no two contacts", "a-b: distance"]),
        ("hole-pin: 50", "hole-pin: -50", &["campaign.yaml:5", "above 0"]),
        (
            "contacts: {hole: {kind: socket, group: placement}, pin: {kind: socket, group: placement}}\ndistances: {hole-pin: 50}\n",
            "",
            &["contacts are observed, and none is declared", "contacts: {name: {kind: socket}}"],
        ),
        ("observes: contact", "observes: contacts", &["campaign.yaml:3", "contacts", "contact"]),
        (
            "observes: contact",
            "observes: contact\nestimate: {base: per-session}",
            &["estimate", "no session", "add a column `session`"],
        ),
        ("observes: contact", "observes: contact\nestimate: {base: per-sesion}", &["per-sesion", "per-session"]),
        ("observes: contact", "observes: contact\njoints: commanded", &["commanded.q1"]),
        ("observes: contact", "observes: contact\ninstrument: {ppm: -3}", &["ppm", "above 0"]),
        ("observes: contact", "observes: distance", &["distance"]),
        ("measurements: c.csv", "measurements: [{fil: c.csv}]", &["fil", "file"]),
    ];
    for (from, to, expected) in of_campaign {
        assert!(PLANAR_CONTACT.contains(from), "{from}");
        let found = said(&PLANAR_CONTACT.replacen(from, to, 1), TABLE);
        assert!(found.starts_with("2\n"), "{to}: {found}");
        expected.iter().for_each(|word| assert!(found.contains(word), "`{word}` is not said of `{to}`:\n{found}"));
    }
    let of_table = [
        ("left,pin", "left,pni", &["c.csv:3", "unknown contact `pni`", "pin"][..]),
        ("pose,placement", "pose,plcement", &["plcement"]),
        (
            "pose,placement,contact,q1,q2\na,left,hole",
            "pose,session,placement,contact,q1,q2\na,mon day,left,hole",
            &["c.csv"],
        ),
        (
            "q1,q2\na,left,hole,0,90\nb,left,pin,10,80",
            "q1,q2,approach.q2\na,left,hole,0,90,0.5\nb,left,pin,10,80,1",
            &["c.csv:2", "`0.5` is no side of approach", "write 1 where"],
        ),
    ];
    for (from, to, expected) in of_table {
        assert!(TABLE.contains(from), "{from}");
        let found = said(PLANAR_CONTACT, &TABLE.replacen(from, to, 1));
        assert!(found.starts_with("2\n"), "{to}: {found}");
        expected.iter().for_each(|word| assert!(found.contains(word), "`{word}` is not said of `{to}`:\n{found}"));
    }
}

/// What is missing or misspelt is one fault, with its own key: what refers to it is none.
#[test]
fn faults_that_follow_from_another_are_not_said() {
    let contacts =
        |kind: &str| PLANAR_CONTACT.replacen("hole: {kind: socket, group", &format!("hole: {{{kind}group"), 1);
    let carried = PLANAR_CONTACT.to_owned() + "payloads: {five: {com: [0, 0, 1]}}\n";
    let table = "pose,placement,contact,q1,q2,payload\na,left,hole,0,90,five\nb,left,pin,10,80,five\n";
    let torques = PUSHED.replace("deflection", "[position, torque]");
    for (campaign, table, expected) in [
        (contacts("kind: cone, "), TABLE, ["campaign.yaml:4:", "unknown choice `cone`"]),
        (contacts(""), TABLE, ["campaign.yaml:4:", "`contacts.hole` lacks `kind`"]),
        (carried, table, ["campaign.yaml:7:", "`payloads.five` lacks `mass`"]),
        (torques, "pose,q1,q2,x,y,z\na,0,90,0.1,0.2,0\n", ["campaign.yaml:3:", "no joint has a column"]),
        (
            PUSHED.replace("deflection", "inclination"),
            "pose,q1,q2,gx,gy,gz\na,0,90,0,0,0\n",
            ["c.csv:2:", "remove the row"],
        ),
    ] {
        let found = said(&campaign, table);
        assert!(found.starts_with("2\n") && found.contains("1 error,"), "{found}");
        expected.iter().for_each(|word| assert!(found.contains(word), "`{word}` is not said:\n{found}"));
    }
}

/// A declared effect whose column or order the campaign does not give counts as nothing, which is said.
#[test]
fn declared_effects_without_their_conditions_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    let effects = "effects:\n- {effect: settling, site: 'joint:1', parameters: {share: 1e-3}}\n\
                   - {effect: frame-drift, site: base, parameters: {x: 1e-6}}\n";
    write("arm.yaml", &(super::cli::PLANAR.to_owned() + effects));
    let campaign = "robot: arm.yaml\nunits: {length: mm, angle: deg}\nobserves: position\nmeasurements: c.csv\n";
    let rows = |time: [&str; 3]| {
        let [title, first, second] = time;
        format!("pose,q1,q2,x,y,z{title}\na,0,90,500,400,0{first}\nb,10,80,492.404,486.824,0{second}\n")
    };
    let warned = |order: &str, time: [&str; 3]| {
        write("campaign.yaml", &format!("{campaign}{order}"));
        write("c.csv", &rows(time));
        let ran = run(folder.path(), &["check", "campaign.yaml"]);
        assert_eq!(ran.status, 0, "{}", ran.err);
        ran.err.lines().find(|line| line.contains("count as nothing")).unwrap_or_default().to_owned()
    };
    let (without, with) = (["", "", ""], [",time", ",0", ",60"]);
    assert!(warned("", without).ends_with("does not give: frame-drift@base (times)"));
    assert!(warned("order: unknown\n", with).ends_with("does not give: settling@joint:1 (the order of measurement)"));
    assert_eq!(warned("", with), "");
}

const PUSHED: &str = "robot: arm.yaml
units: {length: mm, angle: deg}
observes: deflection
measurements: c.csv
";

#[test]
fn wrong_deflections_are_refused_with_place_and_remedy() {
    let table = "pose,q1,q2,x,y,z,rx,ry,rz,fx\na,0,90,0.1,0.2,0,0,0,0.01,100\nb,10,80,0.1,0.1,0,0,0,0.02,100\n";
    let right = said(PUSHED, table);
    assert!(right.starts_with("0\n") && right.contains("deflection-pose"), "{right}");
    let mixed = PUSHED.replace("observes: deflection", "observes: [deflection, pose]");
    for (campaign, table, expected) in [
        (PUSHED, table.replace(",ry", ",tilt"), &["c.csv:1", "tilt"][..]),
        (
            PUSHED,
            "pose,q1,q2,x,y,z,rz,fx\na,0,90,0.1,0.2,0,0.01,100\n".into(),
            &["c.csv:2", "has `rz`, and lacks `rx`, `ry`", "give all of them"],
        ),
        (&PUSHED.replace("deflection", "deflection-pose"), table.replace(",rz,", ",turn,"), &["c.csv:1", "rz"]),
        (
            PUSHED,
            "pose,q1,q2,x,y,z,fx,U95,sigma.z\na,0,90,0.1,0.2,0,100,0.1,0.2\n".into(),
            &["c.csv:2", "the columns `U95` and `sigma.z` both give the noise of a row", "`ignore:`"],
        ),
        (
            &mixed,
            table.into(),
            &[
                "campaign.yaml:3",
                "`deflection-pose` and `pose` are read from the same columns",
                "one kind of each reading",
            ],
        ),
    ] {
        let found = said(campaign, &table);
        assert!(found.starts_with("2\n"), "{found}");
        expected.iter().for_each(|word| assert!(found.contains(word), "`{word}` is not said:\n{found}"));
    }
}

/// Rows say their noise, their order and what the tool carries.
#[test]
fn rows_say_noise_order_and_session() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    write("arm.yaml", super::cli::PLANAR);
    write(
        "campaign.yaml",
        "robot: arm.yaml\nunits: {length: mm, angle: deg}\nobserves: position\ninstrument: {sigma: 0.03, ppm: 10}\nmeasurements: c.csv\n",
    );
    write(
        "c.csv",
        "pose,order,session,sigma.z,commanded.q1,q1,q2,x,y,z\na,4,m,0.5,0.1,0,90,3000,4000,0\nb,5,m,0.5,10.1,10,90,900,0,0\nc,9,m,0.5,0,30,90,900,0,0\n",
    );
    let path = folder.path().join("campaign.yaml");
    let campaign = load_campaign(path.to_str().expect("a path"), None).expect("read").campaign;
    let noise = campaign.readings[0].noise.position;
    // 0.03 mm and 10 ppm of 5 m; z as its column says.
    assert!((noise[0] - 8e-5).abs() < 1e-12 && (noise[2] - 5.5e-4).abs() < 1e-12, "{noise:?}");
    let moved = &campaign.conditions.last_move[0];
    assert!(moved[0].is_nan() && moved[2].is_nan(), "the first has no predecessor, the last an unknown one: {moved:?}");
    assert!((moved[1] - 10_f64.to_radians()).abs() < 1e-12);
    let other = campaign.conditions.other_joints[0].as_ref().expect("given");
    assert!((other[0] - 0.1_f64.to_radians()).abs() < 1e-12);
    assert_eq!(campaign.sessions.names, ["m"]);
}

/// A ball in sockets at a known distance calibrates a real arm; see the data's notes for the figures of a plain fit.
#[test]
fn sockets_calibrate_real_arms() {
    let Some(data) = folder("panda-socket") else { return };
    let data = Path::new(&data).canonicalize().expect("a folder");
    let masses = [include_str!("../data/sockets/panda.yaml"), include_str!("../data/sockets/iiwa14.yaml")];
    let arms = [
        ("panda_1.csv", "panda.urdf", [0.592e-3, 0.45e-3], 0.5e-3),
        ("kuka_14.csv", "iiwa14.urdf", [0.255e-3, 0.21e-3], 0.1e-3),
    ];
    for ((file, urdf, most, most_off), masses) in arms.into_iter().zip(masses) {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: String| std::fs::write(folder.path().join(name), text).expect("written");
        write("arm.yaml", format!("robot: arm\nurdf: {{file: {}/{urdf}, to: ball_link}}\n", data.display()));
        write(
            "campaign.yaml",
            format!(
                "robot: arm.yaml\nunits: {{length: m, angle: rad}}\nobserves: contact\ninstrument: {{sigma: 5.0e-4}}\n\
                 estimate: {{tool: true}}\ncontacts:\n  socket0: {{kind: socket, group: placement}}\n  \
                 socket1: {{kind: socket, group: placement}}\ndistances: {{socket0-socket1: 0.05}}\n\
                 measurements: {}/{file}\ncolumns: {{contact: socket}}\n",
                data.display()
            ),
        );
        let path = folder.path().join("campaign.yaml");
        let loaded = load_campaign(path.to_str().expect("a path"), None).unwrap_or_else(|found| panic!("{found:?}"));
        let campaign = &loaded.campaign;
        let held_out: Vec<bool> = campaign.readings.iter().map(|reading| reading.check == Some(true)).collect();
        let found = calibrate(&loaded.robot.model, campaign, &held_out, &Settings::default(), &mut |_| {});
        let found = found.expect("calibrated");
        let scatter = found.after.check.distance[1];
        assert!(scatter < most[0], "{file}: held-out scatter {scatter} m");
        assert!(found.registration.check.distance[1] > 2.0 * scatter);
        // What noise decides is left as described, so that no constant comes out as no arm is.
        let judged = judge(&Evidence::with(&loaded.robot.model, campaign, &found), &Limits::default());
        assert!(!judged.iter().any(Diagnostic::is_error), "{file}: {judged:?}");

        // The noise need not be stated.
        let text = std::fs::read_to_string(&path).expect("read").replace("instrument: {sigma: 5.0e-4}\n", "");
        write("unstated.yaml", text);
        let unstated = folder.path().join("unstated.yaml");
        let loaded =
            load_campaign(unstated.to_str().expect("a path"), None).unwrap_or_else(|found| panic!("{found:?}"));
        let found = calibrate(&loaded.robot.model, &loaded.campaign, &held_out, &Settings::default(), &mut |_| {});
        let scatter = found.expect("calibrated").after.check.distance[1];
        assert!(scatter < most[0], "{file}: held-out scatter {scatter} m, its noise not stated");

        // With masses, and springs fitted too: joints give under own weight.
        let arm = std::fs::read_to_string(folder.path().join("arm.yaml")).expect("read");
        write("heavy.yaml", arm + masses);
        let text = std::fs::read_to_string(&path).expect("read").replace("arm.yaml", "heavy.yaml");
        write("heavy-campaign.yaml", text);
        let heavy = folder.path().join("heavy-campaign.yaml");
        let loaded = load_campaign(heavy.to_str().expect("a path"), None).unwrap_or_else(|found| panic!("{found:?}"));
        let settings = Settings { what: Some(What { geometric: true, elastic: true }), ..Settings::default() };
        let found = calibrate(&loaded.robot.model, &loaded.campaign, &held_out, &settings, &mut |_| {});
        let scatter = found.expect("calibrated").after.check.distance[1];
        assert!(scatter < most[1], "{file}: held-out scatter {scatter} m with springs");

        // One unknown distance of the sockets in all placements.
        let text = std::fs::read_to_string(&path).expect("read").replace("socket1: 0.05}", "socket1: unknown}");
        std::fs::write(&path, text).expect("written");
        let loaded = load_campaign(path.to_str().expect("a path"), None).unwrap_or_else(|found| panic!("{found:?}"));
        let settings = Settings { criterion: Criterion::Noise, ..Settings::default() };
        let model = &loaded.robot.model;
        let found = calibrate(model, &loaded.campaign, &held_out, &settings, &mut |_| {}).expect("calibrated");
        let slot = model.registry.slot("socket0-socket1.distance").expect("a parameter");
        let distance = found.estimates.iter().find(|estimate| estimate.slot == slot).expect("a candidate");
        assert!((distance.value - 0.05).abs() < most_off, "{file}: {} +- {:?}", distance.value, distance.ci95);

        // The same with masses, springs of joints, and two of the base, whose table gives.
        let arm = std::fs::read_to_string(folder.path().join("heavy.yaml")).expect("read");
        let tilt = "base_stiffness:\n  krx: {compliance: 1.0e-5, identifiable: true}\n  \
                    kry: {compliance: 1.0e-5, identifiable: true}\n";
        write("tilting.yaml", arm + tilt);
        let text = std::fs::read_to_string(&path).expect("read").replace("arm.yaml", "tilting.yaml");
        write("tilting-campaign.yaml", text);
        let tilting = folder.path().join("tilting-campaign.yaml");
        let loaded = load_campaign(tilting.to_str().expect("a path"), None).unwrap_or_else(|found| panic!("{found:?}"));
        let settings = Settings { what: Some(What { geometric: true, elastic: true }), ..Settings::default() };
        let model = &loaded.robot.model;
        let found = calibrate(model, &loaded.campaign, &held_out, &settings, &mut |_| {}).expect("calibrated");
        let slot = model.registry.slot("socket0-socket1.distance").expect("a parameter");
        let distance = found.estimates.iter().find(|estimate| estimate.slot == slot).expect("a candidate");
        assert!((distance.value - 0.05).abs() < 0.4e-3, "{file}: {} +- {:?}", distance.value, distance.ci95);
    }
}

/// A KR-270 from two placements of a tracker.
const TWO_STATIONS: &str = "robot: kuka-kr270
units: {length: mm, angle: deg}
observes: position
instrument: {sigma: 0.1}
estimate: {base: per-station, tool: true}
calibrate: [geometry, joint-offset]
measurements:
- {file: one.csv, station: one}
- {file: two.csv, station: two}
";

/// What no description holds is fitted before residuals are shown: one reading that is 30 mm off does not move the base of its station.
#[test]
fn a_wrong_reading_does_not_move_its_station() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let campaign = TWO_STATIONS.replace(", tool: true", "");
    std::fs::write(at.join("campaign.yaml"), campaign).expect("written");
    let points = ["--poses", "12", "--noise", "0.1", "--errors", "0", "--seed", "2", "--into", "t"];
    let made = run(at, &[&["simulate", "campaign.yaml"][..], &points].concat());
    assert_eq!(made.status, 0, "{}", made.err);
    let path = &at.join("t/measurements-2.csv");
    let text = std::fs::read_to_string(path).expect("read");
    let mut lines: Vec<String> = text.lines().map(String::from).collect();
    let x = lines[0].split(',').position(|title| title == "x").expect("a column");
    let last = lines.len() - 1;
    let mut cells: Vec<String> = lines[last].split(',').map(String::from).collect();
    cells[x] = (cells[x].parse::<f64>().expect("x") + 30.0).to_string();
    lines[last] = cells.join(",");
    std::fs::write(path, lines.join("\n") + "\n").expect("written");
    let ran = run(at, &["residuals", "kuka-kr270", "t", "--format", "json"]);
    let found: serde_json::Value = serde_json::from_str(&ran.out).expect("JSON");
    let readings = found["readings"].as_array().expect("a list");
    let size = |own: &serde_json::Value| -> f64 {
        let squares = own["error"].as_array().expect("a vector").iter().map(|v| v.as_f64().expect("mm").powi(2));
        squares.sum::<f64>().sqrt()
    };
    let mut errors: Vec<f64> = readings.iter().map(size).collect();
    errors.sort_by(f64::total_cmp);
    let [.., sound, wrong] = errors[..] else { panic!("{found}") };
    assert!((wrong - 30.0).abs() < 0.6 && sound < 0.6, "{sound} {wrong}");
}

/// A KR-270 and its three reference points from two placements of a tracker, 18 configurations each, three readings of each point at
/// 0.1 mm: the bases lie in their intervals, which are of the order of those of the KR-270 paper's Table I.
#[test]
fn two_stations_as_in_table_i() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    std::fs::write(at.join("campaign.yaml"), TWO_STATIONS).expect("written");
    // Without errors of its first joint, which a base cannot be told from.
    let points = ["--markers", "m1,m2,m3", "--repeats", "3", "--poses", "18", "--noise", "0.1", "--errors", "0"];
    // Half widths of 95 % intervals as printed: mm and deg, both placements.
    let printed = [("x", 0.045, 0.122), ("y", 0.032, 0.053), ("z", 0.044, 0.121)];
    let turned = [("rx", 0.001, 0.004), ("ry", 0.002, 0.004), ("rz", 0.001, 0.003)];
    let (mut held, mut all, mut lines) = (0, 0, Vec::new());
    for seed in ["1", "2", "3", "4"] {
        let into = format!("trial-{seed}");
        let ran = run(at, &[&["simulate", "campaign.yaml", "--into", &into, "--seed", seed][..], &points].concat());
        assert!(ran.status == 0 && ran.err.is_empty(), "{}", ran.err);
        let read = |text: &str| -> serde_json::Value { serde_json::from_str(text).expect("JSON") };
        let truth = read(&std::fs::read_to_string(at.join(&into).join("truth.json")).expect("written"));
        let ran = run(at, &["identify", &into, "--format", "json"]);
        assert_eq!(ran.status, 0, "{}", ran.err);
        let found = read(&ran.out);
        let fitted = found["parameters"].as_array().expect("a list");
        for (k, (symbol, one, two)) in printed.into_iter().chain(turned).enumerate() {
            for (station, paper) in [("one", one), ("two", two)] {
                let name = format!("base@{station}.{symbol}");
                let own = fitted.iter().find(|parameter| parameter["name"] == name.as_str()).expect(&name);
                let [value, width] = ["value", "ci95"].map(|key| own[key].as_f64().expect("a number"));
                // The paper does not say how many configurations were seen from where.
                assert!((0.1..10.0).contains(&(width / paper)), "{name}: {width}, printed {paper}");
                let size = if k < 3 { 1e3 } else { 1f64.to_degrees() };
                let exact = truth["parameters"][&name]["true"].as_f64().expect("a number") * size;
                held += usize::from((value - exact).abs() <= width);
                all += 1;
                if seed == "1" {
                    lines.push(format!("{name}: +- {width:.4}, paper {paper}"));
                }
            }
        }
    }
    println!("{held} of {all} intervals hold the truth\n{}", lines.join("\n"));
    // 48 intervals of 95 %: fewer than 40 come by chance once in a thousand times.
    assert!(held >= 40, "{held} of {all}");
}
