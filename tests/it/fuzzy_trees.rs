//! Rules in trees: declared, fitted over many inputs, with rotations, with reciprocity; and rules between local springs.

use serde_json::Value;

use crate::cli::{PLANAR, Ran, run};
use crate::figures::recorded;
use crate::support::{number, numbers};

fn json_of(ran: &Ran) -> Value {
    assert_eq!(ran.status, 0, "{}", ran.err);
    serde_json::from_str(&ran.out).expect("JSON")
}

/// Root mean square error on the readings held out, mm.
fn held_out(json: &Value) -> f64 {
    number(&json["residuals"]["check_after"]["rms"])
}

/// The planar arm with springs about its joints (N.mm/rad, here N.m).
fn sprung(springs: &str) -> String {
    PLANAR.replace("units: {length: mm, angle: deg}", "units: {length: mm, angle: deg, rotational_stiffness: N.m/rad}")
        + "joint_stiffness:\n  1: {kar: {value: 1e5, identifiable: true}}\n  2: {kar: {value: 5e4, identifiable: true}}\n"
        + springs
}

fn deflection(folder: &std::path::Path, robot: &str, joints: &str) -> Vec<f64> {
    let pose = ["pose", robot, "--joints", joints, "--wrench", "20,-300,0", "--format", "json"];
    numbers(&json_of(&run(folder, &pose))["deflection"]["marker tip"])
}

/// A tree gives what its splits say: the weight goes linearly across each, and outside the last value holds.
#[test]
fn a_declared_tree_is_evaluated_by_hand() {
    let folder = tempfile::tempdir().expect("a folder");
    let rules = "fuzzy:\n  inputs: [q1, q2]\n  at: tip\n  components:\n    x.fx:\n      tree: {input: q1, from: -20, to: 20, below: 1e-3, \
                 above: {input: q2, from: 0, to: 50, below: 2e-3, above: 5e-3}}\n";
    std::fs::write(folder.path().join("arm.yaml"), format!("{PLANAR}{rules}")).expect("written");
    for (q1, q2) in [(-30.0, 10.0), (-5.0, 10.0), (12.0, 49.0), (60.0, 80.0), (20.0, -10.0)] {
        let above = ((q1 + 20.0_f64) / 40.0).clamp(0.0, 1.0);
        let inner = (q2 / 50.0_f64).clamp(0.0, 1.0);
        let by_hand = (1.0 - above) * 1e-3 + above * ((1.0 - inner) * 2e-3 + inner * 5e-3);
        let joints = format!("q1={q1},q2={q2}");
        let pose = ["pose", "arm.yaml", "--joints", &joints, "--wrench", "2,0,0", "--format", "json"];
        let found = number(&json_of(&run(folder.path(), &pose))["deflection"]["marker tip"][0]);
        assert!((found - 2e-3 * by_hand).abs() < 1e-14, "{found} {by_hand} at {joints}");
    }
    let told = run(folder.path(), &["check", "arm.yaml"]);
    assert!(told.out.contains("rules of each component: x.fx 3"), "{}", told.out);
}

/// Components along the axes of a frame turn with it.
#[test]
fn components_turn_with_their_frame() {
    let folder = tempfile::tempdir().expect("a folder");
    let rules =
        "fuzzy:\n  inputs: [q2]\n  at: tip\n  axes: 1\n  components:\n    x.fx: {tree: 1e-3}\n    y.fy: {tree: 4e-3}\n";
    std::fs::write(folder.path().join("arm.yaml"), format!("{PLANAR}{rules}")).expect("written");
    let pose = ["pose", "arm.yaml", "--joints", "q1=30,q2=10", "--wrench", "2,0,0", "--format", "json"];
    let found = numbers(&json_of(&run(folder.path(), &pose))["deflection"]["marker tip"]);
    let (c, s) = (30_f64.to_radians().cos(), 30_f64.to_radians().sin());
    let by_hand = [2e-6 * (c * c + 4.0 * s * s), 2e-6 * (c * s - 4.0 * c * s)];
    assert!((found[0] - by_hand[0]).abs() < 1e-15 && (found[1] - by_hand[1]).abs() < 1e-15, "{found:?} {by_hand:?}");
}

/// Fuzzy springs deflect as an arm whose springs have the blended compliance, in statics and at equilibrium, and what
/// they say elsewhere is not used.
#[test]
fn local_springs_deflect_as_springs_of_the_blended_compliance() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    let rules = "fuzzy:\n  inputs: [q2]\n  springs:\n    joint1.kar: {tree: {input: q2, from: -40, to: 40, below: 1e5, above: 3e4}}\n    \
                 joint2.kar: {modes: [[0, 60]], conclusions: [.inf, 2e4]}\n";
    write("local.yaml", &sprung(rules));
    for q2 in [-50.0_f64, -10.0, 20.0, 55.0] {
        let (one, two) = (((q2 + 40.0) / 80.0).clamp(0.0, 1.0), (q2 / 60.0).clamp(0.0, 1.0));
        let stiff = [1.0 / ((1.0 - one) / 1e5 + one / 3e4), 1.0 / (two / 2e4)];
        let plain = sprung("").replace("1e5", &format!("{:e}", stiff[0]));
        let second = if stiff[1].is_finite() { format!("{:e}", stiff[1]) } else { ".inf".into() };
        write("plain.yaml", &plain.replace("5e4", &second));
        let joints = format!("q1=25,q2={q2}");
        let [local, plain] = ["local.yaml", "plain.yaml"].map(|robot| deflection(folder.path(), robot, &joints));
        let off = local.iter().zip(&plain).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-15, "{local:?} {plain:?}");
        let bent = |robot: &str| {
            let pose =
                ["pose", robot, "--joints", &joints, "--wrench", "20,-300,0", "--equilibrium", "--format", "json"];
            numbers(&json_of(&run(folder.path(), &pose))["deflection"]["marker tip"])
        };
        let off = bent("local.yaml").iter().zip(&bent("plain.yaml")).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-12, "{off} at equilibrium");
    }
    let told = run(folder.path(), &["check", "local.yaml"]);
    assert!(told.out.contains("fuzzy springs: inputs q2; rules of each: joint1.kar 2, joint2.kar 2"), "{}", told.out);
}

/// Rules between local springs are found where the springs differ by configuration, and saved; where they do not, one rule
/// is.
#[test]
fn local_springs_are_found_where_they_are() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    let rules = "fuzzy:\n  inputs: [q2]\n  springs:\n    joint1.kar: {tree: {input: q2, from: -90, to: 90, below: 1e5, above: 3e4}}\n    \
                 joint2.kar: {tree: {input: q2, from: -90, to: 90, below: 5e4, above: 2e4}}\n";
    write("local.yaml", &sprung(rules));
    write("plain.yaml", &sprung(""));
    for robot in ["local", "plain"] {
        let simulate =
            ["simulate", &format!("{robot}.yaml"), "--poses", "120", "--observes", "deflection", "--markers"];
        let loads =
            ["tip", "--wrench=300,0,0", "--wrench=0,300,0", "--errors", "0", "--noise", "0.01", "--into", robot];
        let ran = run(folder.path(), &[&simulate[..], &loads].concat());
        assert_eq!(ran.status, 0, "{}", ran.err);
    }
    let identify = |campaign: &str, more: &[&str]| {
        let arguments = ["identify", campaign, "--robot", "plain.yaml", "--what", "local", "--format", "json"];
        json_of(&run(folder.path(), &[&arguments[..], more].concat()))
    };
    let found = identify("local", &["--save", "found.yaml"]);
    assert_eq!(found["kept"], true, "{found}");
    let springs = number(&found["parametric"]["check_after"]["rms"]);
    let rules = held_out(&found);
    // Two coordinates with noise; the third does not move.
    assert!(springs > 5.0 * rules && (rules / (0.01 * 3_f64.sqrt()) - 1.0).abs() < 0.15, "{springs} {rules}");
    let again = json_of(&run(folder.path(), &["residuals", "found.yaml", "local", "--format", "json"]));
    assert!((number(&again["check"]["rms"]) - rules).abs() < 1e-9, "{again}");
    let truth = deflection(folder.path(), "local.yaml", "q1=10,q2=33");
    let saved = deflection(folder.path(), "found.yaml", "q1=10,q2=33");
    let (off, size) = (0..2)
        .fold((0.0_f64, 0.0_f64), |(off, size), k| (off.max((truth[k] - saved[k]).abs()), size.max(truth[k].abs())));
    assert!(off < 0.02 * size, "{truth:?} {saved:?}");
    assert_eq!(identify("plain", &[])["kept"], false);
    let compared = ["identify", "local", "--robot", "plain.yaml", "--what", "elastic,local", "--format", "json"];
    assert_eq!(json_of(&run(folder.path(), &compared))["methods"][1]["method"], "local springs");
}

/// A campaign of the arm with its six variables drawn, noise 0.03 mm a coordinate.
fn six_inputs(poses: &str, more: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let mut arguments = vec!["simulate", "kuka-ir663", "--poses", poses, "--errors", "0", "--noise", "0.03"];
    arguments.extend(["--share", "0.8", "--wrench=1000,0,0", "--wrench=0,1000,0", "--wrench=0,0,-1000"]);
    arguments.extend(more);
    arguments.extend(["--into", "c"]);
    let ran = run(folder.path(), &arguments);
    assert_eq!(ran.status, 0, "{}", ran.err);
    folder
}

/// Six inputs: rules in a tree come close to the springs that made the readings, judged by readings that no part of the
/// fit saw, which a grid does not.
#[test]
fn six_inputs_of_the_ir663_come_close_to_its_springs() {
    let folder = six_inputs("200", &["--observes", "deflection", "--markers", "wrist"]);
    let of = |more: &[&str]| {
        let arguments = ["identify", "c", "--format", "json"];
        let json = json_of(&run(folder.path(), &[&arguments[..], more].concat()));
        (held_out(&json), json)
    };
    let (springs, _) = of(&["--what", "elastic"]);
    let (rules, found) = of(&["--what", "fuzzy"]);
    let (grid, _) = of(&["--what", "fuzzy", "--structure", "grid"]);
    let (base, _) = of(&["--what", "fuzzy", "--axes", "base"]);
    let inputs = found["inputs"].as_array().expect("inputs").len();
    let lines = [
        format!("springs: {springs:.4} mm"),
        format!("rules in a tree, axes of frame {}: {rules:.4} mm", found["axes"].as_str().expect("a frame")),
        format!("the same along the base's axes: {base:.4} mm"),
        format!("rules on a grid: {grid:.4} mm"),
    ];
    println!("{lines:?}, {inputs} inputs used");
    recorded("fuzzy-six-inputs", "cargo test six_inputs_of_the_ir663", &lines);
    assert!(rules < 1.5 * springs, "{rules} against {springs}");
    assert!(rules < 0.5 * grid && rules < 0.5 * base, "{rules} {grid} {base}");
}

/// An arm whose screws give, described without them: local springs take up by rules what the springs of the joints cannot,
/// near the singular configurations of the linkage too, and come close to the springs and screws that made the readings.
#[test]
fn local_springs_stand_in_for_screws_left_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = format!("{}/robots/kuka-ir663.yaml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).expect("a file");
    let soft = text.replace("axial: {value: .inf}", "axial: {value: 2e4, identifiable: true}");
    assert_ne!(text, soft);
    std::fs::write(folder.path().join("screws.yaml"), soft).expect("written");
    let simulate = ["simulate", "screws.yaml", "--poses", "240", "--errors", "0", "--noise", "0.03", "--into", "c"];
    let observed = ["--observes", "deflection", "--markers", "wrist", "--wrench=1000,0,0", "--wrench=0,0,-1000"];
    let ran = run(folder.path(), &[&simulate[..], &observed].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    let arguments =
        ["identify", "c", "--robot", "kuka-ir663", "--what", "elastic,fuzzy,grey,local", "--format", "json"];
    let without = json_of(&run(folder.path(), &arguments));
    let methods = without["methods"].as_array().expect("methods");
    let all = |method: &str| {
        let own = methods.iter().find(|own| own["method"] == method).expect("the method");
        number(&own["rows"].as_array().expect("rows").last().expect("a row")["rms"])
    };
    let screws = json_of(&run(folder.path(), &["identify", "c", "--what", "elastic", "--format", "json"]));
    let truth = held_out(&screws);
    let lines = [
        format!("springs, screws left out: {:.4} mm", all("parametric")),
        format!("rules in a tree: {:.4} mm", all("fuzzy")),
        format!("springs without screws, and a fuzzy correction: {:.4} mm", all("grey")),
        format!("local springs without screws, blended by rules: {:.4} mm", all("local springs")),
        format!("springs and screws: {truth:.4} mm"),
    ];
    recorded("fuzzy-local-springs", "cargo test local_springs_stand_in", &lines);
    assert!(all("local springs") < 1.5 * truth && all("local springs") < 0.25 * all("parametric"), "{lines:?}");
}

/// What is held out has no say in the rules.
#[test]
fn held_out_readings_have_no_part_in_the_growth() {
    let folder = six_inputs("60", &["--observes", "deflection", "--markers", "wrist"]);
    let rules = |structure: &str| {
        let arguments = ["identify", "c", "--what", "fuzzy", "--structure", structure, "--format", "json"];
        let inputs = ["--inputs", "stroke2,stroke8"];
        let json = json_of(&run(folder.path(), &[&arguments[..], &inputs].concat()));
        (json["components"].clone(), held_out(&json))
    };
    let before = ["grid", "tree"].map(rules);
    let path = folder.path().join("c/measurements.csv");
    let text = std::fs::read_to_string(&path).expect("a file");
    let x = text.lines().next().expect("a header").split(',').position(|name| name == "x").expect("x");
    let spoiled = text.lines().map(|line| {
        let mut cells: Vec<String> = line.split(',').map(String::from).collect();
        if line.ends_with(",check") {
            cells[x] = "9.0".into();
        }
        cells.join(",")
    });
    std::fs::write(&path, spoiled.collect::<Vec<_>>().join("\n")).expect("written");
    for ((rules_before, error_before), structure) in before.iter().zip(["grid", "tree"]) {
        let (rules_after, error_after) = rules(structure);
        assert_eq!(*rules_before, rules_after, "{structure}");
        assert!(error_after > 3.0 * error_before, "{structure}: {error_before} {error_after}");
    }
}

/// Six components from poses and from three markers: rotations too, under forces and moments; with reciprocity the
/// compliance is symmetric.
#[test]
fn six_components_from_poses_and_from_markers() {
    let moments = ["--wrench=0,0,0,500,0,0", "--wrench=0,0,0,0,500,0", "--wrench=0,0,0,0,0,500"];
    let poses = six_inputs("150", &[&["--observes", "deflection-pose"][..], &moments].concat());
    let identify = |folder: &tempfile::TempDir, campaign: &str, more: &[&str]| {
        let arguments = ["identify", campaign, "--what", "fuzzy", "--format", "json"];
        json_of(&run(folder.path(), &[&arguments[..], more].concat()))
    };
    let found = identify(&poses, "c", &["--axes", "2", "--save", "rules.yaml"]);
    assert_eq!(found["components"].as_array().expect("components").len(), 36);
    let rigid = number(&found["rigid"]["check"]);
    assert!(held_out(&found) < 0.1 * rigid, "{} of {rigid}", held_out(&found));
    let compliance = |robot: &str| {
        let joints = "q1=20,stroke2=760,stroke8=740,q4=10,q5=80,q7=5";
        let json = json_of(&run(poses.path(), &["stiffness", robot, "--joints", joints, "--format", "json"]));
        json["compliance"].as_array().expect("rows").iter().map(numbers).collect::<Vec<_>>()
    };
    let (rules, springs) = (compliance("rules.yaml"), compliance("kuka-ir663"));
    for (row, (a, b)) in rules.iter().zip(&springs).enumerate() {
        for (column, (a, b)) in a.iter().zip(b).enumerate() {
            let size = (springs[row][row] * springs[column][column]).sqrt();
            assert!((a - b).abs() < 0.15 * size, "{row} {column}: {a:e} {b:e} of {size:e}");
        }
    }
    identify(&poses, "c", &["--axes", "2", "--reciprocal", "--save", "symmetric.yaml"]);
    let symmetric = compliance("symmetric.yaml");
    for row in 0..6 {
        for column in 0..row {
            let size = (symmetric[row][row] * symmetric[column][column]).sqrt();
            let (a, b) = (symmetric[row][column], symmetric[column][row]);
            assert!((a - b).abs() < 1e-12 * size, "{row} {column}: {a:e} {b:e}");
            assert!(rules[row][column] != rules[column][row], "{row} {column}: nothing to make symmetric");
        }
    }
}

/// Three markers under a load at one point tell displacement and rotation of the tool: the rules are those of the tool's own
/// displacement and rotation.
#[test]
fn three_markers_are_one_body() {
    let folder = tempfile::tempdir().expect("a folder");
    let simulate = ["simulate", "kuka-kr270", "--poses", "40", "--share", "0.6", "--observes", "deflection-pose"];
    let loads = ["--wrench=1500,0,0", "--wrench=0,1500,0", "--wrench=0,0,-1500", "--wrench=0,0,0,0,800,0"];
    let noise = ["--errors", "0", "--noise", "0", "--orientation-noise", "0", "--into", "c"];
    let ran = run(folder.path(), &[&simulate[..], &loads, &noise].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    let text = std::fs::read_to_string(folder.path().join("c/measurements.csv")).expect("a file");
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let column = |name: &str| header.iter().position(|known| *known == name).expect("a column");
    let model = elastogeo::files::load_robot("kuka-kr270").expect("a robot").model;
    let geometry = elastogeo::kinematics::Geometry::nominal(&model).expect("closes");
    let mut placements = elastogeo::kinematics::Placements::default();
    let mut rows = vec!["pose,marker,q1,q2,q3,q4,q5,q6,x,y,z,fx,fy,fz,mx,my,mz,set".to_string()];
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let of = |name: &str| cells[column(name)].parse::<f64>().expect("a number");
        let joints = ["q1", "q2", "q3", "q4", "q5", "q6"];
        geometry.place(&joints.map(|name| of(name).to_radians()), &mut placements).expect("placed");
        let vector = |names: [&str; 3]| nalgebra::Vector3::from(names.map(of));
        let (moved, turned) = (vector(["x", "y", "z"]), vector(["rx", "ry", "rz"]) * 1f64.to_radians());
        let tool = placements.frames[model.tool.0] * nalgebra::Point3::from(geometry.tool().translation.vector);
        for (index, marker) in model.markers.iter().enumerate() {
            let at = placements.frames[marker.frame] * geometry.marker(index);
            let d = moved + turned.cross(&((at - tool) * 1e3));
            let load = ["fx", "fy", "fz", "mx", "my", "mz"].map(|name| cells[column(name)]).join(",");
            let q = joints.map(|name| cells[column(name)]).join(",");
            let (pose, set) = (cells[column("pose")], cells[column("set")]);
            rows.push(format!("{pose},{},{q},{:.9},{:.9},{:.9},{load},{set}", marker.name, d.x, d.y, d.z));
        }
    }
    std::fs::create_dir(folder.path().join("m")).expect("made");
    std::fs::write(folder.path().join("m/measurements.csv"), rows.join("\n") + "\n").expect("written");
    let campaign = std::fs::read_to_string(folder.path().join("c/campaign.yaml")).expect("a file");
    let campaign = campaign
        .replace("measurements: measurements.csv", "measurements: [{file: measurements.csv, load_point: TCP}]")
        .replace("observes: deflection-pose", "observes: deflection");
    let campaign: Vec<&str> = campaign.lines().filter(|line| !line.contains("sigma_orientation")).collect();
    std::fs::write(folder.path().join("m/campaign.yaml"), campaign.join("\n") + "\n").expect("written");
    let rules = |campaign: &str| {
        let arguments = ["identify", campaign, "--what", "fuzzy", "--structure", "tree", "--inputs", "q2,q3"];
        json_of(&run(folder.path(), &[&arguments[..], &["--axes", "1", "--format", "json"]].concat()))
    };
    let (tool, markers) = (rules("c"), rules("m"));
    let [tool, markers] = [&tool, &markers].map(|json| json["components"].as_array().expect("components"));
    assert_eq!((tool.len(), markers.len()), (30, 30));
    for (one, other) in tool.iter().zip(markers) {
        assert_eq!(one["name"], other["name"]);
        let [one, other] = [one, other].map(|own| numbers(&own["conclusions"]));
        assert_eq!(one.len(), other.len());
        let size = one.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        assert!(one.iter().zip(&other).all(|(a, b)| (a - b).abs() < 1e-3 * size + 1e-9), "{one:?} {other:?}");
    }
}
