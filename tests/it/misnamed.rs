//! Readings, payloads and descriptions that are named, or counted, otherwise than they were: each mistake is named.

use std::path::Path;

use super::cli::run;
use super::plausibility::{doubts, refuses, starter};

fn write(at: &Path, name: &str, text: &str) {
    std::fs::write(at.join(name), text).expect("written");
}

fn ok(at: &Path, arguments: &[&str]) {
    let ran = run(at, arguments);
    assert_eq!(ran.status, 0, "{arguments:?}: {}{}", ran.out, ran.err);
}

/// A table by its columns, changed row by row.
fn rewritten(at: &Path, from: &str, to: &str, header: &str, row: impl Fn(&dyn Fn(&str) -> f64) -> String) {
    std::fs::create_dir_all(at.join(to)).expect("a folder");
    let campaign = std::fs::read_to_string(at.join(from).join("campaign.yaml")).expect("text");
    write(at, &format!("{to}/campaign.yaml"), &campaign);
    let table = std::fs::read_to_string(at.join(from).join("measurements.csv")).expect("text");
    let mut lines = table.lines();
    let names: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let mut all = format!("pose,q1,q2,q3,q4,q5,q6,{header}\n");
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let of = |name: &str| cells[names.iter().position(|known| *known == name).expect("a column")];
        let number = |name: &str| of(name).parse::<f64>().expect("a number");
        let kept: Vec<&str> = ["pose", "q1", "q2", "q3", "q4", "q5", "q6"].iter().map(|name| of(name)).collect();
        all += &format!("{},{}\n", kept.join(","), row(&number));
    }
    write(at, &format!("{to}/measurements.csv"), &all);
}

/// Pitch and roll of an inclinometer in rad where deg are declared, and with their columns exchanged.
#[test]
fn angles_of_a_sensor_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let level = ["simulate", "universal-ur5", "--poses", "40", "--observes", "inclination"];
    ok(at, &[&level[..], &["--orientation-noise", "0.005", "--errors", "0.3", "--into", "sound"]].concat());
    // Of the body: Ry(pitch) Rx(roll) turns level axes to those in which gravity shows.
    let angles = |number: &dyn Fn(&str) -> f64| {
        let [x, y, z] = ["gx", "gy", "gz"].map(number);
        let length = x.hypot(y).hypot(z);
        [(x / length).asin(), (-y).atan2(-z)]
    };
    let degrees = |[pitch, roll]: [f64; 2]| format!("{:.9},{:.9}", pitch.to_degrees(), roll.to_degrees());
    rewritten(at, "sound", "deg", "pitch,roll", |number| degrees(angles(number)));
    ok(at, &["check", "deg"]);
    rewritten(at, "sound", "rad", "pitch,roll", |number| {
        let [pitch, roll] = angles(number);
        format!("{pitch:.12},{roll:.12}")
    });
    refuses(at, &["check", "rad"], "wrong-units", &["with `pitch` and `roll` read as rad", "declared in deg?"]);
    rewritten(at, "sound", "exchanged", "roll,pitch", |number| degrees(angles(number)));
    refuses(at, &["check", "exchanged"], "misread", &["with `pitch` and `roll` exchanged", "columns swapped?"]);
}

/// Lengths of a wire in m where mm are declared: the zero of a joint next to it, about which the unknown anchor turns, is not named.
#[test]
fn wires_in_another_unit_are_named_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let wire = "robot: universal-ur5\nunits: {length: mm, angle: deg}\nobserves: distance\ninstrument: {sigma: 0.05}\n\
        estimate: {base: false, tool: true}\ncalibrate: [geometry, joint-offset]\n\
        anchors: {outlet: {at: unknown, zero: unknown, near: [1500, 0, 200]}}\n";
    write(at, "wire.yaml", wire);
    ok(at, &["simulate", "wire.yaml", "--poses", "80", "--seed", "1", "--errors", "0.5", "--into", "sound"]);
    rewritten(at, "sound", "metres", "distance,anchor", |number| format!("{:.9},outlet", 1e-3 * number("distance")));
    refuses(at, &["check", "metres"], "wrong-units", &["with the readings times 1000 the error", "declared in mm"]);
    let ran = run(at, &["check", "metres"]);
    assert!(!ran.err.contains("another zero of that joint"), "{}", ran.err);
}

/// Two payloads exchanged in their column: no spring stands in for that.
#[test]
fn exchanged_payloads_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let arm = "robot: two-joint arm\nunits: {length: mm, angle: deg, rotational_stiffness: N.m/rad}\nvariables: [q1, q2]\n\
        gravity: [0, -9.81, 0]\nframes:\n  1: {antecedent: 0, joint: revolute, variable: q1, limits: [-120, 120]}\n\
        \x20 2: {antecedent: 1, joint: revolute, variable: q2, d: 500, limits: [-120, 120]}\n  E: {antecedent: 2, d: 400}\n\
        tool: {frame: E}\nbodies:\n  1: {mass: 8, com: [250, 0, 0]}\n  2: {mass: 4, com: [150, 0, 0]}\njoint_stiffness:\n\
        \x20 1: {kar: {value: 40000, identifiable: true}}\n  2: {kar: {value: 20000, identifiable: true}}\n";
    write(at, "arm.yaml", arm);
    let campaign = "robot: arm.yaml\nunits: {length: mm, angle: deg}\nobserves: position\ninstrument: {sigma: 0.02}\n\
        estimate: {base: true, tool: false}\n\
        payloads: {small: {mass: 2, com: [50, 0, 0]}, block: {mass: 5, com: [50, 0, 0]}}\n";
    write(at, "loads.yaml", campaign);
    ok(at, &["simulate", "loads.yaml", "--poses", "60", "--seed", "4", "--elastic-errors", "1", "--into", "c"]);
    let identify = ["identify", "c", "--what", "geometric,elastic"];
    ok(at, &identify);
    let table = std::fs::read_to_string(at.join("c/measurements.csv")).expect("text");
    let exchanged = table.replace(",small,", ",?,").replace(",block,", ",small,").replace(",?,", ",block,");
    write(at, "c/measurements.csv", &exchanged);
    let said = ["the payloads `small` and `block` exchanged", "names exchanged in the column `payload`?"];
    refuses(at, &identify, "misread", &said);
}

/// Readings of another arm of the same variables, and such as were computed from the description itself.
#[test]
fn another_robot_and_no_measurement_are_told() {
    let folder = starter();
    let at = folder.path();
    let made = ["simulate", "universal-ur5", "--poses", "40", "--errors", "0.3", "--unknown-base", "--into", "ur5"];
    ok(at, &made);
    ok(at, &["residuals", "universal-ur5", "ur5"]);
    doubts(at, &["residuals", "universal-ur10", "ur5"], "unlike-description", &["other ways to read the files"]);
    let computed = ["simulate", "universal-ur5", "--poses", "40", "--errors", "0", "--noise", "0", "--unknown-base"];
    ok(at, &[&computed[..], &["--into", "computed"]].concat());
    let path = at.join("computed/campaign.yaml");
    let text = std::fs::read_to_string(&path).expect("text");
    let unstated: Vec<&str> =
        text.lines().filter(|line| !line.starts_with("instrument:") && !line.contains("sigma:")).collect();
    std::fs::write(&path, unstated.join("\n")).expect("written");
    doubts(at, &["identify", "computed"], "implausible", &["no instrument measures a robot so well"]);
}
