//! Directions of the tool's axis: two angles calibrate what turns it, in either way of writing them.

use std::path::Path;

use super::cli::run;

fn identified(folder: &Path) -> serde_json::Value {
    let said = run(folder, &["identify", "seen", "--format", "json"]);
    assert_eq!(said.status, 0, "{}", said.err);
    serde_json::from_str(&said.out).expect("JSON")
}

fn value(of: &serde_json::Value, name: &str) -> (f64, f64) {
    let all = of["parameters"].as_array().expect("a list");
    let own = all.iter().find(|parameter| parameter["name"] == name).unwrap_or_else(|| panic!("{name}"));
    (own["value"].as_f64().expect("a number"), own["ci95"].as_f64().expect("identified"))
}

/// The table with azimuth and elevation in place of the vector.
fn as_angles(table: &str) -> String {
    let mut lines = table.lines();
    let title: Vec<&str> = lines.next().expect("a title").split(',').collect();
    let at = title.iter().position(|name| *name == "axis.x").expect("a column");
    let row = |cells: Vec<String>, two: [String; 2]| [&cells[..at], &two, &cells[at + 3..]].concat().join(",");
    let mut all = vec![row(title.iter().map(ToString::to_string).collect(), ["azimuth".into(), "elevation".into()])];
    for line in lines {
        let cells: Vec<String> = line.split(',').map(ToString::to_string).collect();
        let [x, y, z] = [0, 1, 2].map(|k| cells[at + k].parse::<f64>().expect("a number"));
        let [azimuth, elevation] = [y.atan2(x), z.atan2(x.hypot(y))].map(|angle| format!("{:.12}", angle.to_degrees()));
        all.push(row(cells, [azimuth, elevation]));
    }
    all.join("\n") + "\n"
}

#[test]
fn two_angles_of_the_tool_find_zeros_of_joints() {
    let folder = tempfile::tempdir().expect("a folder");
    let made = [
        "simulate",
        "universal-ur5",
        "--poses",
        "40",
        "--observes",
        "axis",
        "--orientation-noise",
        "0.001",
        "--errors",
        "0",
        "--set",
        "3.theta=0.1",
        "--set",
        "5.alpha=0.05",
        "--seed",
        "4",
        "--into",
        "seen",
    ];
    assert_eq!(run(folder.path(), &made).status, 0);
    let vector = identified(folder.path());
    let (found, ci95) = value(&vector, "5.alpha");
    assert!((found - 90.05).abs() < 2.0 * ci95 && ci95 < 0.01, "{found} +- {ci95}");
    let ratio = vector["noise_ratio"].as_f64().expect("a number");
    assert!((0.75..1.25).contains(&ratio), "{ratio}");
    let table = folder.path().join("seen/measurements.csv");
    let text = std::fs::read_to_string(&table).expect("read");
    std::fs::write(&table, as_angles(&text)).expect("written");
    let angles = identified(folder.path());
    let (a, b) = (value(&vector, "5.alpha").0, value(&angles, "5.alpha").0);
    assert!((a - b).abs() < 1e-6, "{a} {b}");

    // The same direction of any length, and files that hold none.
    let zero = text.replacen(text.lines().nth(1).expect("a row"), "p001,0,0,0,0,0,0,0,0,0,fit", 1);
    for (table_of, expected) in [(zero, "all zero"), (text.replacen("axis.z", "axis.w", 1), "if it is `axis.z`, add")] {
        std::fs::write(&table, table_of).expect("written");
        let said = run(folder.path(), &["check", "seen"]);
        assert!(said.status == 2 && said.err.contains(expected), "{}", said.err);
    }
}
