//! An error at a few angles of one joint, as a damaged tooth makes: it is no law of the catalogue and no wrong reading, and is told where it is.

use std::f64::consts::PI;
use std::path::Path;

use serde_json::Value;

use super::cli::run;
use super::plausibility::{Table, json, spoil};
use super::support::printed_json;

/// What `diagnose` finds where a joint stands off within some degrees of an angle: a raised cosine, deg.
fn diagnosed(at: &Path, robot: &str, seed: &str, (variable, centre, half_width, most): (&str, f64, f64, f64)) -> Value {
    let arm = ["simulate", robot, "--poses", "60", "--seed", seed, "--errors", "1", "--noise", "0.03"];
    let ran = run(at, &[&arm[..], &["--unknown-base", "--unknown-tool", "--into", robot]].concat());
    assert_eq!(ran.status, 0, "{}{}", ran.out, ran.err);
    spoil(&at.join(robot), |t: &mut Table| {
        let column = t.column(variable);
        for row in &mut t.rows {
            let angle: f64 = row[column].parse().expect("deg");
            let off = (angle - centre).abs() / half_width;
            let error = if off < 1.0 { most * 0.5 * (1.0 + (PI * off).cos()) } else { 0.0 };
            row[column] = (angle - error).to_string();
        }
    });
    json(&run(at, &["diagnose", robot, "--format", "json"]))
}

#[test]
fn an_error_at_a_few_angles_is_told_where_it_is() {
    let folder = tempfile::tempdir().expect("a folder");
    for (robot, seed, tooth) in
        [("kuka-kr270", "121", ("q1", 102.0, 24.0, -0.09)), ("franka-panda", "107", ("q3", 122.0, 23.0, -0.08))]
    {
        let found = diagnosed(folder.path(), robot, seed, tooth);
        let laws = found["causes"].as_array().expect("a list").iter().filter(|cause| cause["level"] == "law");
        assert_eq!(laws.count(), 0, "{robot}: {}", found["causes"]);
        let few = &found["rest"]["few_angles"];
        assert_eq!(few["variable"], tooth.0, "{robot}: {} {}", found["verdict"], found["rest"]);
        let [at, amount, share] = ["at_deg", "amount_deg", "share"].map(|key| few[key].as_f64().expect("a number"));
        assert!(
            (at - tooth.1).abs() < tooth.2 && (amount / tooth.3 - 1.0).abs() < 0.4 && share > 0.5,
            "{robot}: {few}"
        );
    }
}

/// All markers of two configurations are wrong by what one joint does there: where that is at one of its angles these are no outliers,
/// and where it is at two angles far apart they are.
#[test]
fn two_whole_configurations_at_one_angle_are_no_outliers() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let arm = ["simulate", "kuka-kr270", "--poses", "60", "--markers", "m1,m2,m3", "--unknown-base", "--seed", "5"];
    let found = |into: &str, poses: [&str; 2]| {
        let made = run(at, &[&arm[..], &["--into", into]].concat());
        assert_eq!(made.status, 0, "{}", made.err);
        spoil(&at.join(into), |table: &mut Table| {
            let [pose, q3] = ["pose", "q3"].map(|name| table.column(name));
            for row in table.rows.iter_mut().filter(|row| poses.contains(&row[pose].as_str())) {
                let value: f64 = row[q3].parse().expect("deg");
                row[q3] = (value + 0.05).to_string();
            }
        });
        printed_json(at, &["diagnose", into])
    };
    // q3 is 13.3 and 13.6 deg.
    let near = found("near", ["p004", "p034"]);
    assert_eq!((&near["verdict"], near["causes"].as_array().map(Vec::len)), (&"unexplained".into(), Some(0)));
    // -64.9 and 112.6 deg.
    let apart = found("apart", ["p017", "p042"]);
    assert_eq!(apart["causes"][0]["effect"], "outliers", "{}", apart["causes"]);
}
