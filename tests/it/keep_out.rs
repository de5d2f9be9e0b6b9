//! Boxes that no link may pass through: the geometry by itself, and every command that heeds them.

use elastogeo::kinematics::{Geometry, Placements, beyond_limits, entered, passes_through};
use elastogeo::model::Model;
use elastogeo::simulation::{draw_errors, generator};
use nalgebra::Point3;
use rand::RngExt;

use super::cli::run;
use super::support::model_of;

/// The text of a bundled description.
fn bundled(name: &str) -> String {
    std::fs::read_to_string(format!("{}/robots/{name}.yaml", env!("CARGO_MANIFEST_DIR"))).expect("a file")
}

const INFINITE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

#[test]
fn a_line_and_a_box() {
    let unit = [[0.0, 1.0]; 3];
    let cases = [
        ([-1.0, 0.5, 0.5], [2.0, 0.5, 0.5], true),   // through two faces
        ([0.2, 0.2, 0.2], [0.8, 0.8, 0.8], true),    // inside
        ([0.5, 0.5, 0.5], [0.5, 0.5, 0.5], true),    // a point inside
        ([0.5, 0.5, 0.5], [9.0, 9.0, 9.0], true),    // out of it
        ([-1.0, 0.5, 0.5], [-0.1, 0.5, 0.5], false), // short of it
        ([1.1, 0.5, 0.5], [2.0, 0.5, 0.5], false),   // behind it
        ([0.0, 0.5, 0.5], [-1.0, 0.5, 0.5], false),  // leaves from a face
        ([-1.0, 0.0, 0.5], [2.0, 0.0, 0.5], false),  // in the plane of a face
        ([-0.5, 0.6, 0.5], [0.6, -0.5, 0.5], true),  // cuts an edge off: at x = y = 0.05
        ([-0.5, 0.4, 0.5], [0.4, -0.5, 0.5], false), // passes the edge
        ([-1.0, -1.0, -1.0], [2.0, 2.0, 2.0], true), // along the diagonal
        ([2.0, 2.0, 2.0], [2.0, 2.0, 2.0], false),   // a point outside
    ];
    for (a, b, expected) in cases {
        assert_eq!(passes_through(&unit, &a.into(), &b.into()), expected, "{a:?} {b:?}");
        assert_eq!(passes_through(&unit, &b.into(), &a.into()), expected, "{b:?} {a:?}");
    }
    let below = [INFINITE, INFINITE, [f64::NEG_INFINITY, 0.0]];
    assert!(passes_through(&below, &[5.0, 5.0, 1.0].into(), &[5.0, 5.0, -0.1].into()));
    assert!(!passes_through(&below, &[5.0, 5.0, 0.0].into(), &[-5.0, 5.0, 0.0].into()));
    // Against points along the line.
    let mut random = generator(5);
    let mut number = || 3.0 * random.random::<f64>() - 1.0;
    let mut through = 0;
    for _ in 0..2000 {
        let [a, b]: [Point3<f64>; 2] = std::array::from_fn(|_| [number(), number(), number()].into());
        let inside = |t: f64, by: f64| (a + (b - a) * t).iter().all(|v| (-by..=1.0 + by).contains(v));
        let touched = |by: f64| (0..=1000).any(|k| inside(f64::from(k) / 1000.0, by));
        let found = passes_through(&unit, &a, &b);
        assert!(found || !touched(-1e-9), "{a} {b}");
        assert!(!found || touched(6e-3), "{a} {b}");
        through += usize::from(found);
    }
    assert!((200..1800).contains(&through), "{through}");
}

/// Configurations of a table, rad and m.
fn rows(model: &Model, path: &std::path::Path) -> Vec<Vec<f64>> {
    let mut table = csv::Reader::from_path(path).expect("a table");
    let header = table.headers().expect("a header").clone();
    let column = |name: &str| header.iter().position(|known| known == name).expect("a column");
    let columns: Vec<(usize, f64)> =
        model.variables.iter().map(|v| (column(&v.name), if v.is_angle { 1f64.to_radians() } else { 1e-3 })).collect();
    let number = |row: &csv::StringRecord, (k, factor): (usize, f64)| row[k].parse::<f64>().expect("a number") * factor;
    table
        .records()
        .map(|row| row.expect("a row"))
        .map(|row| columns.iter().map(|c| number(&row, *c)).collect())
        .collect()
}

/// How many configurations have a point of a link (each 2 mm) inside a box (m).
fn inside(model: &Model, configurations: &[Vec<f64>], space: [[f64; 2]; 3]) -> usize {
    let geometry = Geometry::nominal(model).expect("assembled");
    let mut placements = Placements::default();
    let mut count = 0;
    for q in configurations {
        geometry.place(q, &mut placements).expect("placed");
        let origin = |k: usize| Point3::from(placements.frames[k].translation.vector);
        let mut lines: Vec<[Point3<f64>; 2]> =
            (1..model.frames.len()).map(|k| [origin(model.frames[k].antecedent), origin(k)]).collect();
        lines.push([origin(model.tool.0), placements.frames[model.tool.0] * geometry.tool() * Point3::origin()]);
        let hit = lines.iter().any(|[a, b]| {
            let steps = ((b - a).norm() / 2e-3).ceil() as usize;
            (0..=steps).any(|k| {
                let at = a + (b - a) * (k as f64 / steps.max(1) as f64);
                at.iter().zip(space).all(|(v, [low, high])| low + 2e-9 < *v && *v < high - 2e-9)
            })
        });
        count += usize::from(hit);
    }
    count
}

/// In front of the robot, at the height of its wrist.
const TABLE: (&str, [[f64; 2]; 3]) = ("300:700,-400:400,-200:300", [[0.3, 0.7], [-0.4, 0.4], [-0.2, 0.3]]);
const LOOP: (&str, [[f64; 2]; 3]) = ("-700:-200,-400:400,1400:", [[-0.7, -0.2], [-0.4, 0.4], [1.4, f64::INFINITY]]);

#[test]
fn plans_and_simulations_keep_out() {
    let folder = tempfile::tempdir().expect("a folder");
    for (robot, (text, space), observes) in [("universal-ur5", TABLE, "position"), ("kuka-ir663", LOOP, "pose")] {
        let model = elastogeo::files::load_robot(robot).expect("bundled").model;
        for with in [false, true] {
            let own = if with { vec!["--keep-out", text] } else { Vec::new() };
            let plan = ["plan", robot, "--poses", "18", "--observes", observes, "--table", "p.csv"];
            let ran = run(folder.path(), &[&plan[..], &own].concat());
            assert_eq!(ran.status, 0, "{}", ran.err);
            let planned = inside(&model, &rows(&model, &folder.path().join("p.csv")), space);
            let simulate = ["simulate", robot, "--poses", "40", "--errors", "0", "--into", "c"];
            let ran = run(folder.path(), &[&simulate[..], &own].concat());
            assert_eq!(ran.status, 0, "{}", ran.err);
            let drawn = inside(&model, &rows(&model, &folder.path().join("c/measurements.csv")), space);
            assert_eq!([planned > 0, drawn > 0], [!with; 2], "{robot}: {planned} {drawn}");
        }
    }
}

/// A robot with a box of its own.
fn declared() -> String {
    bundled("universal-ur5") + "\nkeep_out:\n  table: {x: [300, 700], y: [-400, 400], z: [-.inf, 300]}\n"
}

#[test]
fn a_declared_box_is_heeded_everywhere() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    std::fs::write(path.join("robot.yaml"), declared()).expect("written");
    let model = model_of(&declared());
    let geometry = Geometry::nominal(&model).expect("assembled");
    // The tool in the box, and a posture high above it.
    let [low, high] = ["q1=180,q2=-30,q3=60,q4=-120,q5=-90", "q1=180,q2=-90,q3=30,q4=-30,q5=-90"];
    let pose = |joints: &str| run(path, &["pose", "robot.yaml", "--joints", joints]);
    let found = pose(low);
    assert!(found.status == 0 && found.err.contains("passes through `table`"), "{}", found.err);
    assert!(found.err.contains("the link from frame"), "{}", found.err);
    assert_eq!(pose(high).err, "");
    std::fs::write(path.join("two.csv"), "q1,q2,q3,q4,q5,q6\n180,-90,30,-30,-90,0\n180,-30,60,-120,-90,0\n")
        .expect("written");
    let found = run(path, &["pose", "robot.yaml", "--table", "two.csv"]);
    assert!(found.err.contains("`table` is entered in 1 of 2 rows") && found.err.contains("row 2"), "{}", found.err);

    // The point is in the box whatever the branch; of another, which is not, some branches are.
    let found = run(path, &["solve", "robot.yaml", "--target", "500,100,200,180,0,0"]);
    assert!(found.status != 0 && found.err.contains("keep_out `table`"), "{}", found.err);
    let above = ["solve", "robot.yaml", "--target", "500,100,400,0,90,0", "--format", "json"];
    let solutions = |robot: &str| -> Vec<Vec<f64>> {
        let found = run(path, &[&["solve", robot], &above[2..]].concat());
        assert_eq!(found.status, 0, "{}", found.err);
        let json: serde_json::Value = serde_json::from_str(&found.out).expect("JSON");
        let one = |s: &serde_json::Value| {
            model.variables.iter().map(|v| s["joints"][&v.name].as_f64().expect("a number")).collect()
        };
        json["solutions"].as_array().expect("a list").iter().map(one).collect()
    };
    let enters = |q: &Vec<f64>| {
        let mut placements = Placements::default();
        geometry.place(q, &mut placements).expect("placed");
        entered(&geometry, &placements).next().is_some()
    };
    let (all, kept) = (solutions("universal-ur5"), solutions("robot.yaml"));
    let entering = all.iter().filter(|q| enters(q)).count();
    assert!(entering > 0 && kept.len() == all.len() - entering && !kept.iter().any(enters), "{all:?}");

    std::fs::write(path.join("path.csv"), "q1,q2,q3,q4,q5,q6\n180,-30,60,-120,-90,0\n").expect("written");
    let found = run(path, &["compensate", "robot.yaml", "path.csv", "--nominal", "robot.yaml"]);
    assert!(found.status == 1 && found.out.contains("passes through `table`"), "{}\n{}", found.out, found.err);

    // Written and read back.
    assert_eq!(run(path, &["convert", "robot.yaml", "again.yaml"]).status, 0);
    let again = elastogeo::files::load_robot(path.join("again.yaml").to_str().expect("a name")).expect("read").model;
    assert_eq!(again.keep_out, model.keep_out);
    let lost = run(path, &["convert", "robot.yaml", "robot.urdf"]);
    assert!(lost.err.contains("keep_out"), "{}", lost.err);
}

#[test]
fn wrong_boxes_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let cases = [
        ("1:2,3:4", "from and to along x, y and z"),
        ("1:2,3:4,5:x", "from and to along x, y and z"),
        (":,:,:", "from and to along x, y and z"),
        ("1:2,3:4,5:nan", "from and to along x, y and z"),
        ("2:1,3:4,5:6", "least before greatest"),
        ("1:1,3:4,5:6", "least before greatest"),
        ("-500:500,-500:500,-500:500", "does not move"),
        (":,:,300:", "make what is kept out of smaller"),
    ];
    for (text, expected) in cases {
        let ran = run(
            folder.path(),
            &["plan", "universal-ur5", "--poses", "18", "--range", "q2=-95:-85", "--keep-out", text],
        );
        assert!(ran.status == 2 && ran.err.contains(expected), "{text}: {}", ran.err);
    }
    let declared = [
        ("{x: [2, 1]}", "write [1, 2]"),
        ("{x: [1, 1]}", "not empty"),
        ("{}", "no x, y or z"),
        ("{x: [1, .nan]}", "both ends must be numbers"),
        ("{w: [1, 2]}", "unknown"),
        ("[1, 2]", ""),
    ];
    for (text, expected) in declared {
        let robot = bundled("universal-ur5") + &format!("\nkeep_out:\n  table: {text}\n");
        std::fs::write(folder.path().join("robot.yaml"), &robot).expect("written");
        let line = robot.lines().count();
        let ran = run(folder.path(), &["check", "robot.yaml"]);
        assert!(ran.status == 2 && ran.err.contains(expected), "{text}: {}", ran.err);
        assert!(ran.err.contains(&format!("robot.yaml:{line}")), "{text}: {}", ran.err);
    }
}

/// Linkages off by two tolerances keep the limits of their joints at every configuration planned.
#[test]
fn plans_leave_room_for_linkages_that_are_off() {
    let narrow = bundled("five-bar").replace("[20, 165]", "[60, 110]");
    assert!(narrow.contains("[60, 110]"));
    let model = model_of(&narrow);
    let request = super::planning::request(&model, 12);
    let planned = elastogeo::planning::plan(&model, &request, &mut |_| {}).expect("planned");
    let settings = &request.settings;
    let mut placements = Placements::default();
    for k in 0..settings.disturbed {
        let values = draw_errors(&model, settings.off, 0.0, &mut generator(k));
        let off = Geometry::new(&model, &values).expect("assembled");
        for station in &planned.stations {
            off.place(&station.q, &mut placements).expect("placed");
            let beyond = beyond_limits(&model, &station.q, &placements).next();
            assert!(beyond.is_none(), "{:?}: {beyond:?}", station.q);
        }
    }
}
