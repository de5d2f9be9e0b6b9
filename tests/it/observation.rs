//! The family of kinds of readings: a kind of this file alone is read, predicted, differentiated, simulated and fitted.

use elastogeo::description::campaign::raw::{RawCampaign, RawEntry, RawInstrument, RawKinds, RawSigma};
use elastogeo::description::campaign::{Campaign, Target, TargetValue, expected_columns, resolve};
use elastogeo::description::table::{Dialect, read_table};
use elastogeo::effects::Catalogue;
use elastogeo::estimation::{Settings, calibrate};
use elastogeo::files::{LoadedRobot, Reader, load_robot};
use elastogeo::kinematics::{Geometry, Placements};
use elastogeo::observation::{
    CONTACT, DEFLECTION, DISTANCE, FAMILY, Kinds, MOST_ROWS, MeasuredPoint, Noise, Observation, Observes, PLANE, POSE,
    POSITION, PointDerivative, Rows, SOCKET, SPHERE, ValueColumn,
};
use elastogeo::parameter::Kind;
use elastogeo::prediction::{Linearised, Predictor};
use elastogeo::simulation::{Plan, draw_configurations, draw_errors, generator, simulate};
use nalgebra::Vector3;

/// Height of the point above the measurement frame's origin (m), and inclination of the tool's x axis to the horizontal
/// (rad), as a level and a height gauge give them.
struct Level;

static COLUMNS: [ValueColumn; 2] = [ValueColumn::length("height"), ValueColumn::angle("level")];

impl Level {
    fn axis(point: &MeasuredPoint) -> Vector3<f64> {
        point.orientation * Vector3::x()
    }
}

impl Observation for Level {
    fn name(&self) -> &'static str {
        "level"
    }

    fn about(&self) -> &'static str {
        "Height of the point and inclination of the tool's x axis."
    }

    fn columns(&self) -> &'static [ValueColumn] {
        &COLUMNS
    }

    fn sees_orientation(&self) -> bool {
        true
    }

    fn value(&self, point: &MeasuredPoint) -> Rows {
        [point.position().z, Self::axis(point).z.asin(), 0.0, 0.0, 0.0, 0.0]
    }

    fn derivative(&self, point: &MeasuredPoint, by: &PointDerivative) -> Rows {
        let (total, axis) = (by.total(), Self::axis(point));
        let level = total.rotation.cross(&axis).z / (1.0 - axis.z * axis.z).sqrt();
        [total.displacement.z, level, 0.0, 0.0, 0.0, 0.0]
    }

    fn sigmas(&self, noise: &Noise) -> Rows {
        [noise.position[2], noise.orientation, 0.0, 0.0, 0.0, 0.0]
    }
}

const LEVEL: Observes = Observes::new(&Level);

fn plan(robot: &LoadedRobot, observes: Observes, count: usize, sigma: f64) -> Plan {
    let geometry = Geometry::nominal(&robot.model).expect("assembled");
    Plan {
        configurations: draw_configurations(&geometry, count, 0.5, &mut generator(3)).expect("drawn"),
        markers: vec![None],
        repeats: 1,
        wrenches: vec![[300.0, -200.0, -2000.0, 50.0, 30.0, 20.0]],
        conditions: false,
        observes,
        sigma,
        sigma_orientation: sigma,
        estimate: [false, false],
    }
}

fn made(robot: &LoadedRobot, observes: Observes, count: usize, sigma: f64) -> Campaign {
    let values = draw_errors(&robot.model, 1.0, 0.0, &mut generator(4));
    simulate(&robot.model, &values, &plan(robot, observes, count, sigma), &mut generator(5)).expect("simulated")
}

/// A robot with an anchor.
fn robot() -> LoadedRobot {
    let mut robot = load_robot("kuka-kr270").expect("bundled");
    robot.model.anchors.insert("post".into(), Vector3::new(3.0, -1.0, 0.5));
    robot
}

#[test]
fn a_kind_of_ones_own_is_read() {
    let robot = robot();
    let raw = RawCampaign {
        observes: Some(RawKinds::one(LEVEL)),
        units: serde_json::from_value(serde_json::json!({"length": "mm", "angle": "deg"})).expect("units"),
        instrument: Some(RawInstrument {
            sigma: Some(RawSigma::All(0.02)),
            orientation: Some(0.01),
            ppm: None,
            torque: None,
        }),
        ..RawCampaign::default()
    };
    let names: Vec<&str> = robot.robot.variables.iter().map(|variable| variable.name.as_str()).collect();
    let zeros = vec!["0"; names.len()].join(",");
    let text = format!("{},level,height\n{zeros},-30,1250\n", names.join(","));
    let dialect = Dialect { of_campaign: true, ..Dialect::default() };
    let entry = raw.completed(&RawEntry::default());
    let kinds = Kinds::standard().with(LEVEL).expect("a new name");
    let expected = expected_columns(&raw, &entry, &robot.robot, &kinds);
    let table =
        read_table("level.csv", text.as_bytes(), &expected, &Default::default(), &[], &dialect, 10).expect("read");
    let (campaign, _) = resolve(&raw, &|_| None, &robot.robot, &kinds, &[(entry, &table)]).expect("resolved");
    let measured = campaign.readings[0].measured;
    assert!((measured[0] - 1.25).abs() < 1e-12 && (measured[1] + 30_f64.to_radians()).abs() < 1e-12, "{measured:?}");
    assert_eq!(measured[2..], [0.0; MOST_ROWS - 2]);
    assert_eq!(campaign.rows(), 2);
}

#[test]
fn a_kind_of_ones_own_is_predicted_and_simulated() {
    let robot = robot();
    let campaign = made(&robot, LEVEL, 5, 0.0);
    // The same robot measured as poses: height and axis can be taken from those.
    let poses = made(&robot, POSE, 5, 0.0);
    for (level, pose) in campaign.readings.iter().zip(&poses.readings) {
        let axis = POSE.measured_orientation(&pose.measured).expect("a pose has one") * Vector3::x();
        assert!((level.measured[0] - pose.measured[2]).abs() < 1e-12);
        assert!((level.measured[1] - axis.z.asin()).abs() < 1e-9);
    }
    let noisy = made(&robot, LEVEL, 400, 1e-4);
    let ideal = made(&robot, LEVEL, 400, 0.0);
    for row in 0..2 {
        let squares =
            noisy.readings.iter().zip(&ideal.readings).map(|(a, b)| (a.measured[row] - b.measured[row]).powi(2));
        let rms = (squares.sum::<f64>() / 400.0).sqrt();
        assert!((0.9e-4..1.1e-4).contains(&rms), "row {row}: {rms}");
    }
}

/// Readings of another kind with the same points, whose target and scale are unknown.
fn with_unknown_target(mut campaign: Campaign, observes: Observes) -> Campaign {
    campaign.observes = observes;
    let count = match observes.name() {
        "inclination" | "contact-socket" => 3,
        "torque" => 2,
        _ => 4,
    };
    let values = ["a", "b", "c", "d"].into_iter().zip([1.5, -0.8, 0.6, 0.3]).take(count);
    campaign.targets = vec![Target {
        values: values
            .map(|(symbol, value)| TargetValue {
                value,
                kind: Kind::Length,
                parameter: Some(format!("target.{symbol}")),
            })
            .collect(),
        ..Target::anchor("target", &Vector3::zeros())
    }];
    campaign.estimate_scale = true;
    for reading in &mut campaign.readings {
        reading.observes = observes;
    }
    if observes.is_difference() {
        campaign.estimate_scale = false;
    }
    campaign
}

#[test]
fn derivatives_of_every_kind_agree_with_differences() {
    let robot = robot();
    for observes in FAMILY.into_iter().filter(|kind| *kind != CONTACT).chain([LEVEL, SOCKET, PLANE, SPHERE]) {
        let campaign = with_unknown_target(made(&robot, POSITION, 4, 0.0), observes);
        let model = &robot.model.arranged(&campaign);
        let mut values = model.registry.nominal();
        for k in 0..6 {
            values[model.base + k] += 0.2 + 0.1 * k as f64;
            values[model.tool.1 + k] += 0.03 * (k + 1) as f64;
        }
        let slots: Vec<usize> = (model.base..model.base + 6)
            .chain(model.tool.1..model.tool.1 + 6)
            .chain(model.free_slots())
            .chain(model.elastic_slots())
            .chain(model.target_values(0).iter().flatten().copied())
            .chain(model.scale_slot(campaign.readings[0].session))
            .collect();
        let predictor = Predictor::new(model, &campaign, slots.clone()).expect("a predictor").with_sag();
        let [mut exact, mut up, mut down] =
            [const { None }; 3].map(|none: Option<Linearised>| none.unwrap_or_default());
        predictor.linearise(&values, true, &mut exact).expect("linearised");
        // Residuals about what is predicted: of orientations these are rotation vectors, which add only there.
        let mut campaign = campaign.clone();
        campaign.readings.iter_mut().zip(&exact.predicted).for_each(|(reading, value)| reading.measured = *value);
        let predictor = Predictor::new(model, &campaign, slots.clone()).expect("a predictor").with_sag();
        predictor.linearise(&values, true, &mut exact).expect("linearised");
        for (column, &slot) in slots.iter().enumerate() {
            let parameter = &model.registry[slot];
            let step = 1e-3 * parameter.tolerance.max(1e-6 * parameter.nominal.abs());
            for (step, out) in [(step, &mut up), (-step, &mut down)] {
                let mut moved = values.clone();
                moved[slot] += step;
                predictor.linearise(&moved, false, out).expect("predicted");
            }
            for (row, (up, down)) in up.residual.iter().zip(&down.residual).enumerate() {
                let difference = (down - up) / (2.0 * step);
                let ours = exact.jacobian[row * slots.len() + column];
                let rounding = 1e-14 / step;
                assert!(
                    (ours - difference).abs() < 2e-5 * ours.abs() + 20.0 * rounding + 1e-12 / parameter.tolerance,
                    "{observes:?}, {}, row {row}: {ours} {difference}",
                    parameter.name
                );
            }
        }
    }
}

#[test]
fn a_kind_of_ones_own_is_fitted() {
    let robot = robot();
    let campaign = made(&robot, LEVEL, 60, 1e-5);
    let found =
        calibrate(&robot.model, &campaign, &[false; 60], &Settings::default(), &mut |_| {}).expect("calibrated");
    assert!((0.7..1.3).contains(&found.noise_ratio), "noise over the stated one: {}", found.noise_ratio);
    assert!(found.before.fit.distance[1] > 10.0 * found.after.fit.distance[1]);
}

/// Height of the point above the measurement frame's origin, m, under any name.
struct Height {
    name: &'static str,
    columns: &'static [ValueColumn],
}

const OF_HEIGHT: [ValueColumn; 1] = [ValueColumn::length("height")];
const OF_JOINT: [ValueColumn; 1] = [ValueColumn::length("q1")];
const HEIGHT: Observes = Observes::new(&Height { name: "height", columns: &OF_HEIGHT });
const NAMED_AS_KNOWN: Observes = Observes::new(&Height { name: "position", columns: &OF_HEIGHT });
const TURNED: Observes = Observes::new(&Height { name: "turned", columns: &OF_JOINT });

impl Observation for Height {
    fn name(&self) -> &'static str {
        self.name
    }

    fn about(&self) -> &'static str {
        "Height of the point."
    }

    fn columns(&self) -> &'static [ValueColumn] {
        self.columns
    }

    fn value(&self, point: &MeasuredPoint) -> Rows {
        [point.position().z, 0.0, 0.0, 0.0, 0.0, 0.0]
    }

    fn derivative(&self, _: &MeasuredPoint, by: &PointDerivative) -> Rows {
        [by.total().displacement.z, 0.0, 0.0, 0.0, 0.0, 0.0]
    }

    fn sigmas(&self, noise: &Noise) -> Rows {
        [noise.position[2], 0.0, 0.0, 0.0, 0.0, 0.0]
    }
}

#[test]
fn a_kind_of_ones_own_is_named_by_files() {
    let kinds = Kinds::standard().with(HEIGHT).expect("no such kind before");
    assert_eq!(kinds.named("height"), Some(HEIGHT));
    let twice = kinds.clone().with(HEIGHT).expect("replaced");
    assert_eq!(twice.iter().filter(|kind| *kind == HEIGHT).count(), 1);
    assert_eq!(kinds.clone().with(NAMED_AS_KNOWN).expect_err("the family's names are its own"), POSITION);
    // A file names it where the reader has it, and nowhere else in the process.
    let folder = tempfile::tempdir().expect("a folder");
    let of = |observes: &str, columns: &str| {
        let file = folder.path().join("campaign.yaml");
        let text = format!("robot: universal-ur5\nobserves: {observes}\nmeasurements: readings.csv\n");
        std::fs::write(&file, text).expect("written");
        let readings = format!("q1,q2,q3,q4,q5,q6,{columns}\n0,0,0,0,0,0,{}\n", "0.5,".repeat(3).trim_end_matches(','));
        std::fs::write(folder.path().join("readings.csv"), readings).expect("written");
        file.display().to_string()
    };
    let reader = Reader::new(Catalogue::standard()).with_kinds(kinds);
    let file = of("height", "height,temperature,time");
    let read = reader.campaign(&file, None).expect("read").campaign;
    assert_eq!((read.observes, read.readings[0].measured[0]), (HEIGHT, 0.5));
    for (observes, given) in [("height", "one"), ("[position, height]", "a list")] {
        let file = of(observes, "x,y,z");
        let faults = Reader::default().campaign(&file, None).expect_err("not known to this reader").to_string();
        assert!(faults.contains("unknown kind of readings `height`") && faults.contains(":2:"), "{given}: {faults}");
        assert!(!faults.contains("column"), "no echo: {faults}");
    }
}

#[test]
fn a_kind_of_ones_own_shares_no_column_with_a_joint() {
    let kinds = Kinds::standard().with(TURNED).expect("a new name");
    let mut robot = load_robot("kuka-kr270").expect("bundled").robot;
    robot.variables[0].name = "q1".into();
    let raw = RawCampaign { observes: Some(RawKinds::one(TURNED)), ..RawCampaign::default() };
    let faults = resolve(&raw, &|_| None, &robot, &kinds, &[]).expect_err("one name for two things");
    assert!(faults.iter().any(|fault| fault.message.contains("`q1` is a column of a turned")), "{faults:?}");
}

#[test]
fn kinds_say_what_they_are_by_their_names() {
    assert_eq!(
        FAMILY.map(|kind| kind.name()),
        [
            "position",
            "pose",
            "deflection",
            "deflection-pose",
            "distance",
            "contact",
            "orientation",
            "axis",
            "inclination",
            "torque"
        ]
    );
    for kind in FAMILY {
        assert_eq!(Kinds::standard().named(kind.name()), Some(kind));
        assert_eq!(serde_json::to_value(kind).expect("written"), kind.name());
        assert!(kind.length_rows() <= kind.rows() && kind.rows() <= MOST_ROWS);
    }
    assert_eq!([POSITION, POSE, DEFLECTION, DISTANCE].map(|kind| kind.rows()), [3, 6, 3, 1]);
}

#[test]
fn readings_at_the_same_point_have_the_residual_of_their_noise() {
    // At the prediction itself residuals vanish, whatever the kind.
    let robot = robot();
    let geometry = Geometry::nominal(&robot.model).expect("assembled");
    let mut placements = Placements::default();
    geometry.place(&[0.1, -1.2, 1.3, 0.2, 0.4, 0.3], &mut placements).expect("placed");
    let at = placements.frames[robot.model.tool.0];
    let point = MeasuredPoint {
        undeflected: at.translation.vector,
        displacement: Vector3::new(1e-3, -2e-3, 5e-4),
        turned: Vector3::new(2e-3, 1e-3, -4e-3),
        orientation: at.rotation,
        body: at.rotation,
        gravity: -Vector3::z(),
        load: 30.0,
        measured: [0.0; MOST_ROWS],
        target: [3.0, -1.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0],
    };
    for kind in FAMILY.into_iter().chain([LEVEL]) {
        let residual = kind.residual(&kind.value(&point), &point);
        assert!(residual.iter().all(|v| v.abs() < 1e-15), "{kind:?}: {residual:?}");
    }
}
