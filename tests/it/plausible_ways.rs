//! Mistakes of which several readings of the files are as good, or in conventions and units of a part of the readings.

use std::fs;
use std::path::Path;

use super::cli::run;
use super::plausibility::{Table, doubts, json, of_code, spoil, starter};

fn ok(at: &Path, arguments: &[&str]) {
    let ran = run(at, arguments);
    assert_eq!(ran.status, 0, "{}{}", ran.out, ran.err);
}

/// The refusal of a command, with words of it.
fn refuses(at: &Path, arguments: &[&str], code: &str, words: &[&str]) {
    let ran = run(at, &[arguments, &["--format", "json"]].concat());
    assert_eq!(ran.status, 2, "{}{}", ran.out, ran.err);
    let told = of_code(&json(&ran), code);
    let all = told.iter().map(ToString::to_string).collect::<String>();
    words.iter().for_each(|word| assert!(all.contains(word), "{word}: {} {}", ran.out, ran.err));
}

/// With axes 1, 4 and 6 counted the other way an arm is its mirror image: both are named, for only one is the mistake.
#[test]
fn an_arm_and_its_mirror_image_are_both_named() {
    let folder = starter();
    let at = folder.path();
    spoil(&at.join("c"), |t: &mut Table| t.scale(&["q1", "q4", "q6"], -1.0));
    let words = ["one axis of the readings mirrored", "with `q1` negated and `q4` negated and `q6` negated", "; or: "];
    refuses(at, &["identify", "c"], "misread", &words);
}

/// Orientations as angles in the reverse order, as inverse rotations, in gon.
#[test]
fn orientations_of_another_convention_are_named() {
    let folder = starter();
    let at = folder.path();
    let arm = ["simulate", "universal-ur5", "--poses", "40", "--seed", "4", "--observes", "pose"];
    ok(at, &[&arm[..], &["--unknown-base", "--unknown-tool", "--into", "sound"]].concat());
    let rotation = ["rx", "ry", "rz"];
    let number = |t: &Table, row: usize, name: &str| t.rows[row][t.column(name)].parse::<f64>().expect("deg");
    let changed = |into: &str, change: &dyn Fn(nalgebra::Vector3<f64>) -> nalgebra::Vector3<f64>| {
        copied(&at.join("sound"), &at.join(into));
        spoil(&at.join(into), |t: &mut Table| {
            for row in 0..t.rows.len() {
                let own = nalgebra::Vector3::from(rotation.map(|name| number(t, row, name)));
                let new = change(own);
                let columns = rotation.map(|name| t.column(name));
                columns.iter().zip(&new).for_each(|(&column, value)| t.rows[row][column] = value.to_string());
            }
        });
    };
    changed("inverse", &|own| -own);
    refuses(at, &["identify", "inverse"], "misread", &["rotations inverted"]);
    changed("gon", &|own| own / 0.9);
    refuses(at, &["identify", "gon"], "wrong-units", &["in gon, and declared in deg"]);
    changed("angles", &|own| {
        let (x, y, z) = nalgebra::Rotation3::new(own.map(f64::to_radians)).euler_angles();
        nalgebra::Vector3::new(z, y, x).map(f64::to_degrees)
    });
    refuses(at, &["identify", "angles"], "misread", &["angles about z, y', x''"]);
    let found = json(&run(at, &["identify", "sound", "--format", "json"]));
    assert!(of_code(&found, "misread").is_empty(), "{}", found["diagnostics"]);
}

fn copied(from: &Path, to: &Path) {
    fs::create_dir(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder") {
        let path = entry.expect("an entry").path();
        if let (true, Some(name)) = (path.is_file(), path.file_name()) {
            fs::copy(&path, to.join(name)).expect("a copy");
        }
    }
}

/// A palletiser whose third zero is three degrees off: what its linkage tells there and not where it is a parallelogram is fitted too.
#[test]
fn a_zero_that_is_far_off_is_fitted_to_the_noise() {
    let folder = starter();
    let at = folder.path();
    let made = ["simulate", "palletiser", "--poses", "50", "--seed", "1", "--noise", "0.03", "--errors", "1"];
    ok(at, &[&made[..], &["--unknown-base", "--unknown-tool", "--into", "p"]].concat());
    spoil(&at.join("p"), |t: &mut Table| {
        let column = t.column("q3");
        t.rows.iter_mut().for_each(|row| row[column] = (row[column].parse::<f64>().expect("deg") + 3.0).to_string());
    });
    let found = doubts(at, &["identify", "p"], "moved-far", &["crank.theta"]);
    let left = found["residuals"]["check_after"]["rms"].as_f64().expect("mm");
    assert!(left < 0.07, "{left} mm, where the noise is 0.052");
}

/// A gantry's readings, whose noise is 0.01 mm.
fn gantry(at: &Path, spoiled: impl Fn(&mut Table)) {
    let made = ["simulate", "scara-rail", "--poses", "50", "--seed", "1", "--noise", "0.01", "--errors", "1"];
    ok(at, &[&made[..], &["--unknown-base", "--unknown-tool", "--into", "s"]].concat());
    spoil(&at.join("s"), spoiled);
}

/// What a cause explains is applied, however little calibration alone explains.
#[test]
fn a_cause_is_applied_where_calibration_explains_little() {
    let folder = starter();
    let at = folder.path();
    gantry(at, |t| t.scale(&["rail"], 1.02));
    let ran = run(at, &["diagnose", "s", "--apply", "x.yaml"]);
    assert!(ran.status == 0 && at.join("x.yaml").exists(), "{}{}", ran.out, ran.err);
    assert!(ran.out.contains("Explained: gear-ratio at joint:carriage"), "{}", ran.out);
}

/// One axis of the readings stretched: constants take up a part of it, and what is left is hundreds of times the noise.
#[test]
fn what_is_left_far_above_the_noise_is_not_saved() {
    let folder = starter();
    let at = folder.path();
    gantry(at, |t| t.scale(&["y"], 1.02));
    doubts(
        at,
        &["identify", "s"],
        "unlike-description",
        &["times the stated noise: no constants describe these readings"],
    );
    let ran = run(at, &["identify", "s", "--save", "x.yaml"]);
    assert!(ran.status == 1 && !at.join("x.yaml").exists(), "{}{}", ran.out, ran.err);
}

/// Without `calibrate:` geometry competes as a cause; what a calibration then says of the readings is said.
#[test]
fn a_diagnosis_says_what_identify_refuses() {
    let folder = starter();
    let at = folder.path();
    spoil(&at.join("c"), |t: &mut Table| t.scale(&["x", "y", "z"], 1.05));
    let campaign = at.join("c/campaign.yaml");
    let text = fs::read_to_string(&campaign).expect("text");
    let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with("calibrate:")).collect();
    fs::write(&campaign, lines.join("\n") + "\n").expect("written");
    let ran = run(at, &["diagnose", "c", "--apply", "x.yaml"]);
    assert!(ran.out.contains("`identify` refuses this campaign (moved-far)"), "{}{}", ran.out, ran.err);
    assert!(ran.status == 1 && !at.join("x.yaml").exists(), "{}{}", ran.out, ran.err);
}
