//! What the deviations of a path depend on: declared numbers varied one after the other.

use serde_json::Value;

use crate::cli::run;
use crate::figures::recorded;
use crate::support::{number, printed_json};

const LEVER: &str = "units: {length: mm, angle: deg, stiffness: N/mm, rotational_stiffness: N.mm/rad}
variables: [q1]
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, limits: [-90, 90]}
  E: {antecedent: 1, d: 1000}
tool: {frame: E}
joint_stiffness:
  1: {kar: {value: 1e8}}
";

/// A lever whose only spring gives: its deviation goes with the inverse of the stiffness.
#[test]
fn a_single_spring_has_the_elasticity_minus_one() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("lever.yaml"), LEVER).expect("written");
    std::fs::write(folder.path().join("path.csv"), "q1\n0\n10\n").expect("written");
    let compensate = ["compensate", "lever.yaml", "path.csv", "--wrench=0,10,0,0,0,0", "--hold", "position"];
    let found = printed_json(folder.path(), &[&compensate[..], &["--vary", "joint_stiffness.*=0.5,4"]].concat());
    assert!((number(&found["declared"]["greatest"][1]) - 1e-4).abs() < 1e-8, "{found}");
    for (varied, factor) in found["varied"].as_array().expect("varied").iter().zip([0.5, 4.0]) {
        assert_eq!(varied["places"], serde_json::json!(["joint_stiffness.1.kar.value"]));
        assert!((number(&varied["greatest"][1]) * factor - 1e-4).abs() < 1e-8 && number(&varied["factor"]) == factor);
        assert!((number(&varied["elasticity"]) + 1.0).abs() < 1e-4, "{varied}");
    }
}

#[test]
fn what_cannot_be_varied_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("lever.yaml"), LEVER).expect("written");
    std::fs::write(folder.path().join("path.csv"), "q1\n0\n").expect("written");
    for (vary, said) in [
        ("joint_stifness.1.kar.value=2", "did you mean `joint_stiffness.1.kar.value`"),
        ("joint_stiffness.*", "give PARAMETER=FACTOR"),
        ("joint_stiffness.*=0", "give PARAMETER=FACTOR"),
        ("joint_stiffness.*=1,nan", "give PARAMETER=FACTOR"),
        ("process.strip.young=2", "names no number"),
        ("place.x=10", "does not say positions"),
    ] {
        let arguments = ["compensate", "lever.yaml", "path.csv", "--wrench=0,10,0,0,0,0", "--vary", vary];
        let ran = run(folder.path(), &arguments);
        assert_eq!(ran.status, 2, "{vary}: {}", ran.out);
        assert!(ran.err.contains(said), "{vary}: {}", ran.err);
    }
    let ran = run(folder.path(), &["compensate", "lever.yaml", "path.csv", "--vary", "joint_stiffness.*=2"]);
    assert!(ran.status == 2 && ran.err.contains("nothing pushes on the tool"), "{}", ran.err);
}

/// The table of docs/compensation.md: by what the deviations of the forming path differ from the paper's 0.4 to 1.5 mm, and the
/// deflections of the arm over the volume in which the paper gives 1.6 to 2.5 mm by 1100 N.
#[test]
fn what_the_deviations_by_the_strip_depend_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let varied = [
        "sections.*.wall=0.5,2",
        "materials.steel.young=0.5,2",
        "materials.steel.density=0.001",
        "process.carried=0.001",
        "joint_stiffness.2.kar=2",
        "joint_stiffness.8.kar=2",
        "joint_stiffness.*.kr=2",
        "joint_stiffness.10.kr=2",
        "process.strip.young=0.9",
        "process.strip.height=0.9",
        "place.x=-400,200",
        "place.z=-800,-400,400",
    ];
    let compensate = ["compensate", "kuka-ir663", "ir663-strip", "--process", "ir663-strip"];
    let asked: Vec<&str> = varied.iter().flat_map(|varied| ["--vary", varied]).collect();
    let found = printed_json(folder.path(), &[&compensate[..], &asked].concat());
    // The path slides along the strip from its sixth point on.
    let from_to = |of: &Value| {
        let points = of["points"].as_array().expect("points");
        let z = |point: Option<&Value>| 1e3 * point.map_or(f64::NAN, |point| point[2].as_f64().unwrap_or(f64::NAN));
        [z(points.get(5)), z(points.last())]
    };
    let [from, to] = from_to(&found["declared"]);
    let mut lines = vec![format!("as declared: {from:.4} to {to:.4} mm")];
    for of in found["varied"].as_array().expect("varied") {
        let by = match of["factor"].as_f64() {
            Some(factor) => format!("x {factor}"),
            None => format!("{:+} mm", 1e3 * number(&of["moved"])),
        };
        let elasticity = of["elasticity"].as_f64().map(|by| format!(", elasticity {by:+.3}")).unwrap_or_default();
        let [from, to] = from_to(of);
        lines.push(format!("{} {by}: {from:.4} to {to:.4} mm{elasticity}", of["what"].as_str().expect("a name")));
    }
    // Nearer and lower at once, at the lower end of the volume.
    let moved = |dx: f64, dz: f64| {
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/processes/ir663-strip");
        let read = |name: &str| std::fs::read_to_string(format!("{root}/{name}")).expect("a file");
        let clamp = format!("clamp: [{}, 0, {}]", 2230.0 + dx, 1425.0 + dz);
        let process = read("process.yaml").replace("clamp: [2230, 0, 1425]", &clamp);
        assert!(process.contains(&clamp));
        let mut path = String::new();
        for line in read("path.csv").lines() {
            let cells: Vec<&str> = line.split(',').collect();
            path += &match (cells[1].parse::<f64>(), cells[3].parse::<f64>()) {
                (Ok(x), Ok(z)) => format!("{},{},0,{},180,0,0\n", cells[0], x + dx, z + dz),
                _ => format!("{line}\n"),
            };
        }
        std::fs::write(folder.path().join("moved.yaml"), process).expect("written");
        std::fs::write(folder.path().join("moved.csv"), path).expect("written");
        let arguments = ["compensate", "kuka-ir663", "moved.csv", "--process", "moved.yaml"];
        printed_json(folder.path(), &[&arguments[..], &["--vary", "joint_stiffness.8.kar=1.2"]].concat())
    };
    for (dx, dz) in [(-400.0, -550.0), (-200.0, -800.0)] {
        let found = moved(dx, dz);
        let ([from, to], [stiffer_from, stiffer_to]) = (from_to(&found["declared"]), from_to(&found["varied"][0]));
        lines.push(format!(
            "place.x {dx} mm, place.z {dz} mm: {from:.4} to {to:.4} mm; with joint_stiffness.8.kar x 1.2 {stiffer_from:.4} to {stiffer_to:.4}"
        ));
    }
    recorded("strip-varied", "cargo test what_the_deviations_by_the_strip", &lines);

    // The grid of the paper's Fig. 9 and D.26, the tool down as on the strip.
    let mut grid = String::from("pose,x,y,z,rx,ry,rz\n");
    for i in 0..9 {
        for j in 0..7 {
            let (x, z) = (1250.0 + 125.0 * f64::from(i), 850.0 + 1300.0 / 6.0 * f64::from(j));
            grid += &format!("p{i}{j},{x},0,{z},180,0,0\n");
        }
    }
    std::fs::write(folder.path().join("grid.csv"), grid).expect("written");
    let pushed = ["compensate", "kuka-ir663", "grid.csv", "--wrench=0,0,-1100,0,0,0"];
    let found = printed_json(folder.path(), &[&pushed[..], &["--vary", "joint_stiffness.8.kar=1.5,2"]].concat());
    let range = |of: &Value| {
        let sizes = of["points"].as_array().expect("points").iter();
        let size = |point: &Value| (0..3).map(|k| point[k].as_f64().unwrap_or(f64::NAN).powi(2)).sum::<f64>().sqrt();
        let mut sizes: Vec<f64> = sizes.map(|point| 1e3 * size(point)).filter(|size| size.is_finite()).collect();
        sizes.sort_by(f64::total_cmp);
        let at = |share: f64| sizes[(share * (sizes.len() - 1) as f64) as usize];
        format!("{} places, {:.2} to {:.2} mm, half of them below {:.2}", sizes.len(), at(0.0), at(1.0), at(0.5))
    };
    let mut lines = vec![format!("as declared: {}", range(&found["declared"]))];
    for of in found["varied"].as_array().expect("varied") {
        lines.push(format!("joint_stiffness.8.kar x {}: {}", number(&of["factor"]), range(of)));
    }
    recorded("strip-grid", "cargo test what_the_deviations_by_the_strip", &lines);
}
