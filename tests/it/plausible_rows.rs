//! Rows, points and conditions that are wrong in a part of a campaign only.

use elastogeo::files::load_campaign;

use super::cli::run;
use super::plausibility::{Table, doubts, json, of_code, spoil, starter};

fn ok(at: &std::path::Path, arguments: &[&str]) {
    let ran = run(at, arguments);
    assert_eq!(ran.status, 0, "{}{}", ran.out, ran.err);
}

/// One joint column is constant in one of two sessions, or a joint was read a degree off in half the rows: what the calibration leaves
/// is not written into a description, by neither command.
#[test]
fn a_wrong_column_of_half_the_rows_is_not_saved() {
    let folder = starter();
    let at = folder.path();
    let arm = ["simulate", "universal-ur5", "--poses", "60", "--seed", "5", "--into", "two", "--sessions", "mon,tue"];
    ok(at, &[&arm[..], &["--unknown-base", "--unknown-tool"]].concat());
    spoil(&at.join("two"), |t: &mut Table| {
        let [session, joint] = ["session", "q5"].map(|name| t.column(name));
        t.rows.iter_mut().filter(|row| row[session] == "tue").for_each(|row| row[joint] = "30".into());
    });
    spoil(&at.join("c"), |t: &mut Table| {
        let joint = t.column("q3");
        let half = t.rows.len() / 2;
        t.rows
            .iter_mut()
            .skip(half)
            .for_each(|row| row[joint] = (row[joint].parse::<f64>().expect("deg") + 1.0).to_string());
    });
    for campaign in ["two", "c"] {
        doubts(at, &["identify", campaign], "unlike-description", &["no constants describe these readings together"]);
        for command in [["identify", campaign, "--save", "x.yaml"], ["diagnose", campaign, "--apply", "x.yaml"]] {
            let ran = run(at, &command);
            assert!(ran.status == 1 && !at.join("x.yaml").exists(), "{command:?}: {} {}", ran.status, ran.out);
        }
    }
}

/// More readings are far off than `diagnose` sets aside: what it applies would hold them.
#[test]
fn outliers_that_are_not_all_set_aside_are_not_applied() {
    let folder = starter();
    let at = folder.path();
    spoil(&at.join("c"), |t: &mut Table| {
        let joint = t.column("q5");
        (0..10).for_each(|k| t.rows[40 + k][joint] = t.rows[10 + k][joint].clone());
    });
    for command in [["identify", "c", "--save", "x.yaml"], ["diagnose", "c", "--apply", "x.yaml"]] {
        let ran = run(at, &command);
        assert!(ran.status == 1 && !at.join("x.yaml").exists(), "{command:?}: {} {}", ran.status, ran.out);
    }
}

/// The readings of one marker stand in place of another's.
#[test]
fn a_marker_pasted_over_another_is_told() {
    let folder = starter();
    let at = folder.path();
    let arm = ["simulate", "kuka-kr270", "--poses", "40", "--markers", "m1,m2", "--seed", "3", "--into", "p"];
    ok(at, &[&arm[..], &["--unknown-base", "--unknown-tool"]].concat());
    let right = json(&run(at, &["identify", "p", "--format", "json"]));
    assert!(of_code(&right, "implausible").is_empty(), "{}", right["diagnostics"]);
    spoil(&at.join("p"), |t: &mut Table| {
        let columns = ["x", "y", "z"].map(|name| t.column(name));
        for row in (1..t.rows.len()).step_by(2) {
            columns.iter().for_each(|&column| t.rows[row][column] = t.rows[row - 1][column].clone());
        }
    });
    doubts(
        at,
        &["identify", "p"],
        "implausible",
        &["readings are those of another point to the last digit: m1 in place of m2"],
    );
    let ran = run(at, &["identify", "p", "--save", "x.yaml"]);
    assert!(ran.status == 1 && !at.join("x.yaml").exists() && !ran.out.contains("F = "), "{}{}", ran.out, ran.err);
}

/// Temperatures in kelvin, and cells of 0 where there is none.
#[test]
fn temperatures_of_another_kind_are_told() {
    let folder = starter();
    let at = folder.path();
    let arm =
        ["simulate", "kuka-kr270", "--poses", "60", "--markers", "m1,m2", "--conditions", "--seed", "5", "--into", "t"];
    let effect = ["--effect", "thermal-expansion@link:3:expansion=2.3e-4", "--unknown-base", "--unknown-tool"];
    ok(at, &[&arm[..], &effect].concat());
    ok(at, &["diagnose", "t", "--apply", "warm.yaml"]);
    for (temperature, told) in [("25", ""), ("298.15", "these look like kelvin"), ("80", "trust the prediction less")] {
        let path = format!("q1,q2,q3,q4,q5,q6,temperature\n0,-60,90,10,30,0,{temperature}\n");
        std::fs::write(at.join("path.csv"), path).expect("written");
        let ran = run(at, &["compensate", "warm.yaml", "path.csv", "--nominal", "kuka-kr270", "--format", "json"]);
        let found = of_code(&json(&ran), "outside-validity");
        let words = found.iter().any(|d| d["message"].as_str().is_some_and(|m| m.contains("temperature")));
        assert_eq!(words, !told.is_empty(), "{temperature}: {found:?}");
        assert!(ran.out.contains(told), "{temperature}: {}", ran.out);
    }
    spoil(&at.join("t"), |t: &mut Table| {
        let column = t.column("temperature");
        t.rows.iter_mut().take(40).for_each(|row| row[column] = "0".into());
    });
    for command in ["identify", "diagnose"] {
        doubts(at, &[command, "t"], "suspect-readings", &["`temperature` is 0 in 40 of"]);
    }
    for (offset, factor) in [(0.0, 1.0), (32.0, 1.8), (273.15, 1.0)] {
        spoil(&at.join("t"), |t: &mut Table| {
            let column = t.column("temperature");
            let warm = |k: usize| offset + factor * (20.0 + 0.1 * k as f64);
            t.rows.iter_mut().enumerate().for_each(|(k, row)| row[column] = warm(k).to_string());
        });
        let ran = run(at, &["check", "t"]);
        assert_eq!(ran.err.contains("hotter than any hall"), offset > 0.0, "{offset}: {}", ran.err);
    }
}

/// Moments of the other sense, and in N.mm; forces in kgf with moments in N.m.
#[test]
fn moments_against_their_forces_are_named() {
    let folder = starter();
    let at = folder.path();
    let arm =
        ["simulate", "kuka-kr270", "--poses", "40", "--observes", "deflection-pose", "--seed", "3", "--into", "m"];
    ok(at, &[&arm[..], &["--wrench", "200,300,-1500,100,200,300"]].concat());
    let table = std::fs::read_to_string(at.join("m/measurements.csv")).expect("a table");
    let moments = ["mx", "my", "mz"];
    for (columns, factor, words) in [
        (moments, -1.0, "the moments of the wrenches reversed"),
        (moments, 1e3, "moments times 0.001"),
        (["fx", "fy", "fz"], 1.0 / 9.80665, "are they in kgf, and moments in N.m?"),
    ] {
        std::fs::write(at.join("m/measurements.csv"), &table).expect("written");
        spoil(&at.join("m"), |t: &mut Table| t.scale(&columns, factor));
        let ran = run(at, &["identify", "m", "--save", "x.yaml"]);
        assert!(ran.status == 2 && ran.err.contains(words), "{factor}: {}{}", ran.out, ran.err);
    }
}

/// Times in milliseconds, and sides of approach that never change.
#[test]
fn times_in_milliseconds_and_one_side_are_told() {
    let folder = starter();
    let at = folder.path();
    let arm = ["simulate", "universal-ur5", "--poses", "30", "--seed", "5", "--unknown-base", "--unknown-tool"];
    ok(at, &[&arm[..], &["--into", "t"]].concat());
    let added = |name: &'static str, value: fn(usize) -> String| {
        spoil(&at.join("t"), |t: &mut Table| {
            t.names.push(name.into());
            t.rows.iter_mut().enumerate().for_each(|(k, row)| row.push(value(k)));
        });
    };
    added("time", |k| (20_000 * k).to_string());
    let found = doubts(at, &["check", "t"], "suspect-readings", &["5.6 h", "is it in milliseconds?"]);
    assert_eq!(of_code(&found, "suspect-readings").len(), 1, "{found}");
    added("approach.q2", |_| "1".into());
    let ran = run(at, &["check", "t"]);
    assert!(ran.err.contains("`approach.q2` holds one side alone"), "{}", ran.err);
    // Both sides, and seconds.
    spoil(&at.join("t"), |t: &mut Table| {
        t.scale(&["time"], 1e-3);
        let column = t.column("approach.q2");
        t.rows[3][column] = "-1".into();
    });
    let ran = run(at, &["check", "t"]);
    assert!(!ran.err.contains("milliseconds") && !ran.err.contains("one side"), "{}", ran.err);
    // Hours that are taken for seconds.
    spoil(&at.join("t"), |t: &mut Table| t.scale(&["time"], 1.0 / 3600.0));
    doubts(at, &["check", "t"], "suspect-readings", &["is it in minutes or hours?"]);
}

/// Times of a clock that counts from a date hold as those that are counted from the first reading.
#[test]
fn times_of_a_clock_are_counted_from_the_first_reading() {
    let folder = starter();
    let at = folder.path();
    let arm = ["simulate", "universal-ur5", "--poses", "10", "--conditions", "--seed", "5", "--into", "t"];
    ok(at, &arm);
    let times = || {
        let loaded = load_campaign(&at.join("t").to_string_lossy(), None).expect("read");
        loaded.campaign.conditions.time.expect("times")
    };
    let before = times();
    spoil(&at.join("t"), |t: &mut Table| {
        let column = t.column("time");
        t.rows
            .iter_mut()
            .for_each(|row| row[column] = (1.78e9 + row[column].parse::<f64>().expect("a time")).to_string());
    });
    let first = before.iter().copied().fold(f64::INFINITY, f64::min);
    let after = times();
    assert!(before.iter().zip(&after).all(|(before, after)| (before - first - after).abs() < 1e-5), "{after:?}");
    assert!(before.iter().any(|time| *time > first), "{before:?}");
}

/// Sides of approach that are the reverse of the moves are told; those of the moves, and those that have nothing to do with them, are not.
#[test]
fn sides_against_the_moves_are_told() {
    let folder = starter();
    let at = folder.path();
    let arm = ["simulate", "universal-ur5", "--poses", "30", "--seed", "5", "--unknown-base", "--unknown-tool"];
    ok(at, &[&arm[..], &["--into", "t"]].concat());
    spoil(&at.join("t"), |t: &mut Table| {
        let q: Vec<usize> = (1..=3).map(|k| t.column(&format!("q{k}"))).collect();
        let value = |row: &[String], column: usize| -> f64 { row[column].parse().expect("a number") };
        let rows = t.rows.clone();
        for (k, row) in t.rows.iter_mut().enumerate() {
            let rises = |&column: &usize| k > 0 && value(&rows[k], column) > value(&rows[k - 1], column);
            row.extend(q.iter().map(|column| if rises(column) { "-1".to_string() } else { "1".into() }));
        }
        t.names.extend((1..=3).map(|k| format!("approach.q{k}")));
    });
    let told = || {
        let ran = run(at, &["check", "t"]);
        ran.err.contains("87 of 87 sides are the reverse of the joint's move")
    };
    assert!(!told());
    spoil(&at.join("t"), |t: &mut Table| t.scale(&["approach.q1", "approach.q2", "approach.q3"], -1.0));
    assert!(told());
    // Two joints as they moved, one against it.
    spoil(&at.join("t"), |t: &mut Table| t.scale(&["approach.q1", "approach.q2"], -1.0));
    assert!(!run(at, &["check", "t"]).err.contains("are the reverse"));
}
