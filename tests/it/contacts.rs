//! Contacts of a ball: what sockets, faces and spheres find, and what they can tell of an arm, against a forward model of this
//! file: products of textbook matrices, differentiated by differences.

use std::fmt::Write as _;
use std::path::Path;

use nalgebra::{DMatrix, Isometry3, Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use elastogeo::files::load_campaign;
use elastogeo::prediction::{Linearised, Predictor};

use super::cli::run;
use crate::support::printed_json;

/// alpha (deg), d (mm), r (mm) of the UR5's frames.
const ROWS: [[f64; 3]; 6] = [
    [0.0, 0.0, 89.159],
    [90.0, 0.0, 0.0],
    [0.0, -425.0, 0.0],
    [0.0, -392.25, 109.15],
    [90.0, 0.0, 94.65],
    [-90.0, 0.0, 82.3],
];
/// Centre of the ball on the flange, mm.
const BALL: [f64; 3] = [12.0, -7.0, 95.0];

fn turn(axis: Vector3<f64>, angle: f64) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::identity(), UnitQuaternion::new(axis * angle))
}

fn shift(by: Vector3<f64>) -> Isometry3<f64> {
    Isometry3::from_parts(by.into(), UnitQuaternion::identity())
}

/// The ball (mm, rad). `moved` are six numbers for each fixed transform: a motion of the frame before its joint, mm and rad.
fn ball(q: &[f64], moved: &[f64], at: Vector3<f64>) -> Vector3<f64> {
    let (x, z) = (Vector3::x(), Vector3::z());
    let mut pose = Isometry3::identity();
    for (k, [alpha, d, r]) in ROWS.into_iter().enumerate() {
        let by = |first: usize| {
            moved.get(6 * k + first..6 * k + first + 3).map_or(Vector3::zeros(), Vector3::from_column_slice)
        };
        let fixed = turn(x, alpha.to_radians()) * shift(x * d);
        pose =
            pose * fixed * shift(by(0)) * turn(Vector3::x(), by(3).x) * turn(Vector3::y(), by(3).y) * turn(z, by(3).z);
        pose = pose * turn(z, q[k]) * shift(z * r);
    }
    (pose * nalgebra::Point3::from(at)).coords
}

/// What is touched; the unknown numbers of each, and how far the ball is from touching.
#[derive(Clone, Copy)]
enum Touched {
    Socket(Vector3<f64>),
    /// Point and unit normal.
    Face(Vector3<f64>, Vector3<f64>),
    /// Centre and distance.
    Sphere(Vector3<f64>, f64),
}

impl Touched {
    fn unknowns(self) -> usize {
        match self {
            Self::Socket(_) => 3,
            Self::Face(..) | Self::Sphere(..) => 4,
        }
    }

    fn gap(self, at: Vector3<f64>, x: &[f64]) -> Vec<f64> {
        let v = Vector3::from_column_slice(&x[..3]);
        match self {
            Self::Socket(centre) => (at - centre - v).iter().copied().collect(),
            Self::Face(point, normal) => {
                let normal = (normal + v).normalize();
                vec![normal.dot(&(at - point)) - x[3]]
            }
            Self::Sphere(centre, radius) => vec![(at - centre - v).norm() - radius - x[3]],
        }
    }
}

/// Configurations at which the ball touches, by Newton from random ones; joints within 150 deg.
fn touching(on: Touched, count: usize, random: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
    let at = Vector3::from(BALL);
    let mut found = Vec::new();
    while found.len() < count {
        let mut q: Vec<f64> = (0..6).map(|_| random.random_range(-2.4..2.4)).collect();
        for _ in 0..25 {
            let gap = on.gap(ball(&q, &[], at), &[0.0; 4]);
            if gap.iter().all(|gap| gap.abs() < 1e-10) {
                break;
            }
            let rows = gap.len();
            let jacobian = DMatrix::from_fn(rows, 6, |i, j| {
                let step = |sign: f64| {
                    let mut moved = q.clone();
                    moved[j] += sign * 1e-6;
                    on.gap(ball(&moved, &[], at), &[0.0; 4])[i]
                };
                (step(1.0) - step(-1.0)) / 2e-6
            });
            let Some(inverse) = (&jacobian * jacobian.transpose()).try_inverse() else { break };
            let change = jacobian.transpose() * (inverse * nalgebra::DVector::from_vec(gap));
            let scale = (0.3 / change.amax()).min(1.0);
            q.iter_mut().zip(change.iter()).for_each(|(q, change)| *q -= scale * change);
        }
        let gap = on.gap(ball(&q, &[], at), &[0.0; 4]);
        if gap.iter().all(|gap| gap.abs() < 1e-9) && q.iter().all(|q| q.abs() < 2.6) {
            found.push(q);
        }
    }
    found
}

/// The rank of the readings by every motion of every frame, the ball and the unknowns of what is touched; then of `known`
/// distances between sockets (by index).
fn rank(touched: &[(Touched, Vec<Vec<f64>>)], known: &[[usize; 2]]) -> usize {
    let firsts: Vec<usize> =
        touched.iter().scan(39, |at, (on, _)| Some(std::mem::replace(at, *at + on.unknowns()))).collect();
    let width = 39 + touched.iter().map(|(on, _)| on.unknowns()).sum::<usize>();
    let all = |x: &[f64]| -> Vec<f64> {
        let at = Vector3::from(BALL) + Vector3::from_column_slice(&x[36..39]);
        let mut gaps = Vec::new();
        for ((on, poses), &first) in touched.iter().zip(&firsts) {
            let own: Vec<f64> = (first..first + 4).map(|k| x.get(k).copied().unwrap_or(0.0)).collect();
            poses.iter().for_each(|q| gaps.extend(on.gap(ball(q, &x[..36], at), &own)));
        }
        for pair in known {
            let centre = |k: usize| match touched[k].0 {
                Touched::Socket(centre) => centre + Vector3::from_column_slice(&x[firsts[k]..firsts[k] + 3]),
                _ => unreachable!("sockets have distances"),
            };
            gaps.push((centre(pair[0]) - centre(pair[1])).norm());
        }
        gaps
    };
    let rows = all(&vec![0.0; width]).len();
    let mut jacobian = DMatrix::zeros(rows, width);
    for column in 0..width {
        let step = if column < 36 && column % 6 > 2 { 1e-5 } else { 1e-2 };
        let at = |sign: f64| {
            let mut x = vec![0.0; width];
            x[column] = sign * step;
            all(&x)
        };
        for (row, (up, down)) in at(1.0).iter().zip(at(-1.0)).enumerate() {
            jacobian[(row, column)] = (up - down) / (2.0 * step);
        }
    }
    let norms: Vec<f64> = jacobian.column_iter().map(|column| column.norm()).collect();
    for (mut column, norm) in jacobian.column_iter_mut().zip(norms) {
        column /= norm.max(1e-9);
    }
    let values = jacobian.singular_values();
    // Differences are good to some 1e-8: values between that and 1e-5 would say that the rank is not clear.
    let greatest = values.max();
    assert!(values.iter().all(|v| !(1e-7..1e-5).contains(&(v / greatest))), "{values}");
    values.iter().filter(|v| **v > 1e-6 * greatest).count()
}

fn campaign(folder: &Path, touched: &[(&str, Touched, &[Vec<f64>])], contacts: &str) {
    let mut table = String::from("contact,q1,q2,q3,q4,q5,q6\n");
    for (name, _, poses) in touched {
        for q in *poses {
            let joints: Vec<String> = q.iter().map(|q| format!("{:.14}", q.to_degrees())).collect();
            writeln!(table, "{name},{}", joints.join(",")).expect("written");
        }
    }
    let text = format!(
        "robot: universal-ur5\nunits: {{length: mm, angle: deg}}\nobserves: contact\ninstrument: {{sigma: 0.05}}\n\
         estimate: {{tool: true}}\n{contacts}\nmeasurements: contacts.csv\n"
    );
    std::fs::write(folder.join("contacts.csv"), table).expect("written");
    std::fs::write(folder.join("campaign.yaml"), text).expect("written");
}

fn value(of: &serde_json::Value, name: &str) -> f64 {
    let all = of["parameters"].as_array().expect("a list");
    let own = all.iter().find(|parameter| parameter["name"] == name).unwrap_or_else(|| panic!("{name}"));
    own["value"].as_f64().expect("a number")
}

#[test]
fn what_contacts_can_tell_is_what_an_independent_model_says() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let one = Touched::Socket(Vector3::new(420.0, 150.0, 120.0));
    let two = Touched::Socket(Vector3::new(465.0, 130.0, 128.0));
    let face = Touched::Face(Vector3::new(400.0, 0.0, 150.0), Vector3::new(0.2, 0.1, 1.0).normalize());
    let sphere = Touched::Sphere(Vector3::new(430.0, -100.0, 150.0), 40.0);
    let [of_one, of_two, of_face, of_sphere] =
        [(one, 14), (two, 14), (face, 40), (sphere, 40)].map(|(on, count)| touching(on, count, &mut random));
    let folder = tempfile::tempdir().expect("a folder");
    let mut found = Vec::new();
    type Case<'a> = (Vec<(&'static str, Touched, &'a [Vec<f64>])>, &'static str, &'static [[usize; 2]]);
    let cases: [Case; 5] = [
        (vec![("a", one, &of_one)], "contacts: {a: {kind: socket}}", &[]),
        (vec![("a", one, &of_one), ("b", two, &of_two)], "contacts: {a: {kind: socket}, b: {kind: socket}}", &[]),
        (
            vec![("a", one, &of_one), ("b", two, &of_two)],
            "contacts: {a: {kind: socket}, b: {kind: socket}}\ndistances: {a-b: 49.889878}",
            &[[0, 1]],
        ),
        (vec![("f", face, &of_face)], "contacts: {f: {kind: plane}}", &[]),
        (vec![("s", sphere, &of_sphere)], "contacts: {s: {kind: sphere}}", &[]),
    ];
    for (touched, contacts, known) in cases {
        campaign(folder.path(), &touched, contacts);
        let ours = printed_json(folder.path(), &["identifiability", "universal-ur5", "campaign.yaml"])["rank"]
            .as_u64()
            .expect("a number") as usize;
        let theirs: Vec<(Touched, Vec<Vec<f64>>)> =
            touched.iter().map(|(_, on, poses)| (*on, poses.to_vec())).collect();
        let theirs = rank(&theirs, known);
        assert_eq!(ours, theirs, "{contacts}");
        found.push(ours);
    }
    // A second socket adds its own three coordinates; the distance of both adds the size.
    assert_eq!(found[1] - found[0], 3, "{found:?}");
    assert_eq!(found[2] - found[1], 1, "{found:?}");
}

/// Where the robot stands and where unknown sockets are is one thing: the base stays where it is declared, and the sockets are found from there.
#[test]
fn unknown_sockets_do_not_move_the_base() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let at = Vector3::new(420.0, 150.0, 120.0);
    let one = Touched::Socket(at);
    let poses = touching(one, 20, &mut random);
    let folder = tempfile::tempdir().expect("a folder");
    campaign(folder.path(), &[("a", one, &poses)], "contacts: {a: {kind: socket}}");
    let path = folder.path().join("campaign.yaml");
    let text = std::fs::read_to_string(&path).expect("read");
    std::fs::write(&path, text.replace("{tool: true}", "{base: true, tool: true}")).expect("written");
    let found = printed_json(folder.path(), &["register", "campaign.yaml"]);
    for axis in ["x", "y", "z", "rx", "ry", "rz"] {
        let name = format!("base.{axis}");
        let own = found["parameters"].as_array().expect("a list").iter().find(|own| own["name"] == name.as_str());
        let own = own.expect("a parameter");
        assert!(own["identifiable"] == false && own["value"] == 0.0, "{own}");
    }
    for (axis, truth) in ["a.x", "a.y", "a.z"].into_iter().zip(at.iter()) {
        assert!((value(&found, axis) - truth).abs() < 1e-3, "{axis}: {}", value(&found, axis));
    }
}

#[test]
fn a_datum_cube_of_unknown_place_and_the_ball_are_found() {
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let cube = UnitQuaternion::new(Vector3::new(0.2, -0.3, 0.5));
    let corner = Vector3::new(430.0, 120.0, 140.0);
    let faces: Vec<(&str, Touched)> = ["fx", "fy", "fz"]
        .into_iter()
        .enumerate()
        .map(|(k, name)| (name, Touched::Face(corner, cube * Vector3::ith(k, 1.0))))
        .collect();
    let poses: Vec<Vec<Vec<f64>>> = faces.iter().map(|(_, on)| touching(*on, 12, &mut random)).collect();
    let folder = tempfile::tempdir().expect("a folder");
    let touched: Vec<(&str, Touched, &[Vec<f64>])> =
        faces.iter().zip(&poses).map(|((name, on), poses)| (*name, *on, poses.as_slice())).collect();
    let contacts = "contacts: {fx: {kind: plane}, fy: {kind: plane}, fz: {kind: plane}}\n\
                    angles: {fx-fy: 90, fy-fz: 90, fx-fz: 90}";
    campaign(folder.path(), &touched, contacts);
    let found = printed_json(folder.path(), &["register", "campaign.yaml"]);
    for (name, truth) in ["tool.x", "tool.y", "tool.z"].into_iter().zip(BALL) {
        assert!((value(&found, name) - truth).abs() < 1e-3, "{name}: {}", value(&found, name));
    }
    let normal =
        |face: &str| Vector3::from(["nx", "ny", "nz"].map(|axis| value(&found, &format!("{face}.{axis}")))).normalize();
    for (k, face) in ["fx", "fy", "fz"].into_iter().enumerate() {
        let along = normal(face).dot(&(cube * Vector3::ith(k, 1.0))).abs();
        assert!(along > 1.0 - 1e-8, "{face}: {along}");
    }
    // Angles hold: with a wrong one the faces no longer fit.
    let wrong = contacts.replace("fx-fy: 90", "fx-fy: 88");
    campaign(folder.path(), &touched, &wrong);
    let off = run(folder.path(), &["register", "campaign.yaml", "--force", "--format", "json"]);
    let off: serde_json::Value = serde_json::from_str(&off.out).expect("JSON");
    assert!((value(&off, "tool.x") - BALL[0]).abs() > 0.1, "{}", value(&off, "tool.x"));
    let said = off["diagnostics"].to_string();
    assert!(said.contains("`fx-fy` comes out at 90.00 deg where 88.00 deg is declared"), "{said}");

    // diagnose takes constraints too.
    campaign(folder.path(), &touched, contacts);
    let said = run(folder.path(), &["diagnose", "campaign.yaml"]);
    assert!([0, 1, 2].contains(&said.status) && !said.err.contains("panicked"), "{}", said.err);

    for (wrong, expected) in [
        ("angles: {fx-fq: 90}", "`fx-fq` names no two contacts"),
        ("angles: {fx-fy: 0}", "must be between 1 and 179 deg"),
        ("distances: {fx-fy: 50}", "the radius of the ball on `fx` is not known"),
    ] {
        campaign(folder.path(), &touched, &format!("{}\n{wrong}", contacts.lines().next().expect("a line")));
        let said = run(folder.path(), &["check", "campaign.yaml"]);
        assert!(said.status == 2 && said.err.contains(expected) && said.err.contains("campaign.yaml"), "{}", said.err);
    }
}

/// A small sphere, touched eight times from all sides by an arm three times as far from its description as usual, is not taken for a plane: of
/// these three, begun where that arm seems to touch, the radius ends at thousands of kilometres.
#[test]
fn a_small_sphere_is_found_from_few_contacts() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let text = "robot: universal-ur5\nunits: {length: mm, angle: deg}\ninstrument: {sigma: 0.03}\nestimate: {tool: true}\n\
                contacts: {ball: {kind: sphere}}\n\
                measurements: [{file: a.csv, observes: position}, {file: b.csv, observes: contact}]\n";
    std::fs::write(at.join("sphere.yaml"), text).expect("written");
    for seed in ["12", "20", "25"] {
        let made =
            run(at, &["simulate", "sphere.yaml", "--poses", "60", "--errors", "3", "--seed", seed, "--into", seed]);
        assert_eq!(made.status, 0, "{}", made.err);
        let file = at.join(seed).join("measurements-2.csv");
        let rows = std::fs::read_to_string(&file).expect("rows");
        let few: Vec<&str> = rows.lines().take(9).collect();
        std::fs::write(&file, few.join("\n") + "\n").expect("written");
        let truth: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(at.join(seed).join("truth.json")).expect("truth"))
                .expect("JSON");
        let truth = 1e3 * truth["parameters"]["ball.radius"]["true"].as_f64().expect("a number");
        let found = printed_json(at, &["identify", seed]);
        let all = found["parameters"].as_array().expect("a list");
        let radius = all.iter().find(|own| own["name"] == "ball.radius").expect("a radius");
        let [value, half] = ["value", "ci95"].map(|key| radius[key].as_f64().expect("a number"));
        assert!((value - truth).abs() < (3.0 * half).min(5.0), "{seed}: {value} +- {half} mm for {truth}");
    }
}

/// Opposite faces of a cube, `apart` (mm), touched from outside by a ball of radius `radius` (mm) with few orientations.
#[test]
fn parallel_faces_at_a_known_distance_give_the_robot_its_size() {
    let mut random = ChaCha8Rng::seed_from_u64(21);
    let (apart, radius) = (200.0, 12.0);
    let cube = UnitQuaternion::new(Vector3::new(0.1, -0.2, 0.4));
    let middle = Vector3::new(430.0, 120.0, 140.0);
    let face = |axis: usize, sign: f64| {
        let normal = cube * Vector3::ith(axis, sign);
        Touched::Face(middle + normal * (0.5 * apart + radius), normal)
    };
    let names = ["px", "mx", "py", "my", "pz"];
    let faces = [face(0, 1.0), face(0, -1.0), face(1, 1.0), face(1, -1.0), face(2, 1.0)];
    let poses: Vec<Vec<Vec<f64>>> = faces.iter().map(|on| touching(*on, 25, &mut random)).collect();
    let touched: Vec<(&str, Touched, &[Vec<f64>])> =
        names.iter().zip(&faces).zip(&poses).map(|((name, on), poses)| (*name, *on, poses.as_slice())).collect();
    let folder = tempfile::tempdir().expect("a folder");
    let kinds: Vec<String> = names.iter().map(|name| format!("{name}: {{kind: plane, radius: {radius}}}")).collect();
    let contacts = format!("contacts: {{{}}}\n", kinds.join(", "));
    let angles = "angles: {px-py: 90, px-pz: 90, py-pz: 90}\n";
    let rank = |distances: &str| {
        campaign(folder.path(), &touched, &format!("{contacts}{angles}{distances}"));
        printed_json(folder.path(), &["identifiability", "universal-ur5", "campaign.yaml"])["rank"]
            .as_u64()
            .expect("a number")
    };
    // Each second face has the first's normal, two directions less to be seen; and the distances show the size.
    let (without, with) = (rank(""), rank("distances: {px-mx: 200, py-my: 200}\n"));
    assert_eq!(with, without - 4 + 1);
    let held = |distance: f64| {
        campaign(
            folder.path(),
            &touched,
            &format!("{contacts}{angles}distances: {{px-mx: {distance}, py-my: {distance}}}\n"),
        );
        printed_json(folder.path(), &["identify", "campaign.yaml", "--check", "0", "--force"])
    };
    let found = held(apart);
    let scale = |found: &serde_json::Value| value(found, "3.d") / -425.0;
    assert!((scale(&found) - 1.0).abs() < 1e-6, "{}", scale(&found));
    for (name, truth) in ["tool.x", "tool.y", "tool.z"].into_iter().zip(BALL) {
        assert!((value(&found, name) - truth).abs() < 1e-2, "{name}: {}", value(&found, name));
    }
    // A cube that is said to be larger by a hundredth makes the robot larger.
    let larger = scale(&held(1.01 * apart));
    assert!((larger - 1.01).abs() < 2e-3, "{larger}");
    for (wrong, expected) in [
        ("distances: {px-mx: unknown}", "the distance of two faces must be known"),
        ("distances: {px-px: 200}", "`px-px` names one contact twice"),
        ("distances: {px-mx: 200, mx-px: 210}", "`mx-px` is the distance that `px-mx` gives"),
        ("distances: {px-mx: -3}", "must be a finite number above 0"),
    ] {
        campaign(folder.path(), &touched, &format!("{contacts}{wrong}"));
        let said = run(folder.path(), &["check", "campaign.yaml"]);
        assert!(said.status == 2 && said.err.contains(expected) && said.err.contains("campaign.yaml"), "{}", said.err);
    }
}

/// A cube with two opposite faces, put down three times, touched with noise: no face tells where the robot stands, so that six
/// directions of each placement drop out exactly, and the fit ends where the truth is.
#[test]
fn opposite_faces_leave_where_the_robot_stands_open() {
    let folder = tempfile::tempdir().expect("a folder");
    let cube = "robot: universal-ur5\nunits: {length: mm, angle: deg}\nobserves: contact\ninstrument: {sigma: 0.03}\n\
        estimate: {tool: true}\ncalibrate: [geometry, joint-offset]\ncontacts:\n  \
        fx: {kind: plane, near: [500, 100, 100], radius: 5, group: placement}\n  \
        gx: {kind: plane, near: [420, 100, 100], radius: 5, group: placement}\n  \
        fy: {kind: plane, near: [460, 150, 100], radius: 5, group: placement}\n  \
        fz: {kind: plane, near: [460, 100, 140], radius: 5, group: placement}\n\
        angles: {fx-fy: 90, fy-fz: 90, fx-fz: 90}\ndistances: {fx-gx: 80}\nmeasurements: x.csv\n";
    std::fs::write(folder.path().join("cube.yaml"), cube).expect("written");
    for seed in ["2", "3"] {
        let made = ["simulate", "cube.yaml", "--poses", "240", "--placements", "3", "--seed", seed, "--into", seed];
        assert_eq!(run(folder.path(), &made).status, 0);
        let found = printed_json(folder.path(), &["identify", seed]);
        // Of each placement the normals and offsets of its faces are columns. Lengths of normals mean nothing, and where the robot
        // stands is no face's matter: all that drops out does so exactly.
        let [columns, rank, kept] = ["columns", "rank", "kept"].map(|key| found[key].as_u64().expect("a number"));
        assert_eq!((columns, rank, kept), (68, 51, 51), "seed {seed}");
        let left = found["residuals"]["check_after"]["rms"].as_f64().expect("a number");
        assert!(left < 0.06, "seed {seed}: {left}");
    }
}

/// Known distances between sockets that no three points have.
#[test]
fn distances_that_cannot_be_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let sockets = "robot: universal-ur5\nunits: {length: mm, angle: deg}\nobserves: contact\ninstrument: {sigma: 0.03}\n\
        estimate: {tool: true}\ncontacts: {a: {kind: socket}, b: {kind: socket}, c: {kind: socket}}\nmeasurements: x.csv\n";
    let simulated = |distances: &str| {
        std::fs::write(folder.path().join("c.yaml"), format!("{sockets}distances: {distances}\n")).expect("written");
        run(folder.path(), &["simulate", "c.yaml", "--poses", "60", "--into", "t", "--seed", "3"])
    };
    let impossible = simulated("{a-b: 80, b-c: 60, a-c: 150}");
    assert!(impossible.status == 2, "{}", impossible.err);
    assert!(impossible.err.contains("`a-c`: 150 is longer than the way along other known distances, 140"));
    // An unknown one is drawn as the others allow.
    let drawn = simulated("{a-b: 80, b-c: unknown, a-c: 150}");
    assert_eq!(drawn.status, 0, "{}", drawn.err);
    let truth = std::fs::read_to_string(folder.path().join("t/truth.json")).expect("read");
    let truth: serde_json::Value = serde_json::from_str(&truth).expect("JSON");
    let length = truth["parameters"]["b-c.distance"]["true"].as_f64().expect("a number");
    assert!((0.07..=0.23).contains(&length), "{length}");
}

/// What a campaign of sockets identifies must not depend on how well the ball sat: with noise and an arm that is off, the
/// rank is that of the independent model where the ball sits exactly.
#[test]
fn what_sockets_tell_does_not_depend_on_their_noise() {
    let mut random = ChaCha8Rng::seed_from_u64(6);
    let one = Touched::Socket(Vector3::new(420.0, 150.0, 120.0));
    let two = Touched::Socket(Vector3::new(465.0, 130.0, 128.0));
    let exact = [touching(one, 16, &mut random), touching(two, 16, &mut random)];
    let theirs = rank(&[(one, exact[0].clone()), (two, exact[1].clone())], &[[0, 1]]);
    let folder = tempfile::tempdir().expect("a folder");
    for noise in [0.0, 1e-4, 1e-3] {
        let noisy: Vec<Vec<Vec<f64>>> = exact
            .iter()
            .map(|poses| {
                let shaken = |q: &Vec<f64>| q.iter().map(|q| q + random.random_range(-noise..=noise)).collect();
                poses.iter().map(shaken).collect()
            })
            .collect();
        let touched = [("a", one, noisy[0].as_slice()), ("b", two, noisy[1].as_slice())];
        campaign(
            folder.path(),
            &touched,
            "contacts: {a: {kind: socket}, b: {kind: socket}}\ndistances: {a-b: 49.889878}",
        );
        let ours = printed_json(folder.path(), &["identifiability", "universal-ur5", "campaign.yaml"]);
        assert_eq!(ours["rank"].as_u64(), Some(theirs as u64), "noise {noise}: {}", ours["dropped"]);
        assert_eq!(ours["kept"].as_u64(), Some(theirs as u64), "noise {noise}");
    }
}

/// Rows of angles, of parallel faces and of distances: derivatives by everything they refer to, against central differences at
/// values drawn at random (normals of any length).
#[test]
fn derivatives_of_constraints_are_differences() {
    let mut random = ChaCha8Rng::seed_from_u64(33);
    let folder = tempfile::tempdir().expect("a folder");
    let on = Touched::Socket(Vector3::new(420.0, 150.0, 120.0));
    let poses = touching(on, 3, &mut random);
    let touched: Vec<(&str, Touched, &[Vec<f64>])> =
        ["a", "b", "c", "d", "e", "f"].map(|name| (name, on, poses.as_slice())).into();
    let contacts = "contacts: {a: {kind: socket}, b: {kind: socket}, c: {kind: plane, radius: 12}, d: {kind: plane, radius: 12}, \
                    e: {kind: sphere}, f: {kind: plane}}\n\
                    distances: {a-b: 50, c-d: 200, a-e: unknown}\nangles: {c-f: 88}\n";
    campaign(folder.path(), &touched, contacts);
    let path = folder.path().join("campaign.yaml");
    let loaded = load_campaign(path.to_str().expect("a name"), None).expect("readable");
    let (model, campaign) = (&loaded.robot.model, &loaded.campaign);
    assert!(campaign.constraints.len() >= 4, "{}", campaign.constraints.len());
    let slots: Vec<usize> =
        (0..campaign.targets.len()).flat_map(|k| model.target_values(k).iter().flatten().copied()).collect();
    let mut values = model.registry.nominal();
    slots.iter().for_each(|&slot| values[slot] = random.random_range(0.2..1.2));
    let predictor = Predictor::new(model, campaign, slots.clone()).expect("readings");
    let mut at = Linearised::default();
    predictor.linearise(&values, true, &mut at).expect("predicted");
    let first = at.residual.len() - campaign.constraints.len();
    let mut moving = vec![0; campaign.constraints.len()];
    for (column, slot) in slots.iter().enumerate() {
        let residual = |change: f64| {
            let (mut moved, mut found) = (values.clone(), Linearised::default());
            moved[*slot] += change;
            predictor.linearise(&moved, false, &mut found).expect("predicted");
            found.residual
        };
        let (plus, minus) = (residual(1e-6), residual(-1e-6));
        for row in first..at.residual.len() {
            let (by, difference) = (at.jacobian[row * slots.len() + column], (minus[row] - plus[row]) / 2e-6);
            let name = &model.registry[*slot].name;
            assert!((by - difference).abs() < 1e-8, "constraint {} by {name}: {by} {difference}", row - first);
            moving[row - first] += usize::from(difference.abs() > 1e-3);
        }
    }
    assert!(moving.iter().all(|count| *count >= 2), "{moving:?}");
}

/// Touches follow from the joints alone: a curve that undoes a slide removes the noise of the slide's own sensor, and is no cause.
#[test]
fn a_slide_does_not_undo_its_own_reading() {
    let campaign = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/sockets/scara/campaign.yaml");
    let folder = tempfile::tempdir().expect("a folder");
    let found = printed_json(folder.path(), &["diagnose", &campaign.to_string_lossy()]);
    assert_eq!(found["verdict"], "no-gap", "{}", found["causes"]);
}
