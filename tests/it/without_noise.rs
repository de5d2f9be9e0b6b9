//! Mistakes in campaigns that state no noise: what is left must not pass for it.

use std::fs;
use std::path::Path;

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::cli::run;
use super::plausibility::{Table, json, of_code, refuses, simulated, spoil};

/// Takes the statement of the noise, and what is held out, from the campaign in `s`.
fn silent(at: &Path) {
    let file = at.join("s/campaign.yaml");
    let text = fs::read_to_string(&file).expect("text");
    let without = text.replace("instrument:\n  sigma: 0.03\n", "");
    assert_ne!(text, without);
    fs::write(&file, without).expect("written");
    spoil(&at.join("s"), |table| {
        let set = table.column("set");
        table.names.remove(set);
        table.rows.iter_mut().for_each(|row| {
            row.remove(set);
        });
    });
}

fn with_noise() -> [&'static str; 4] {
    ["--noise", "0.03", "--errors", "0.5"]
}

/// Positions of several markers dealt out at random: their mutual distances scatter by a metre, which is no noise.
#[test]
fn readings_that_are_exchanged_are_no_noise() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let arguments = ["--markers", "m1,m2,m3", "--poses", "40", "--seed", "3", "--unknown-base", "--unknown-tool"];
    simulated(at, "kuka-kr270", &[&with_noise()[..], &arguments].concat());
    silent(at);
    spoil(&at.join("s"), |table: &mut Table| {
        let columns = ["x", "y", "z"].map(|name| table.column(name));
        let mut points: Vec<[String; 3]> = table.rows.iter().map(|row| columns.map(|k| row[k].clone())).collect();
        points.shuffle(&mut ChaCha8Rng::seed_from_u64(8));
        for (row, point) in table.rows.iter_mut().zip(points) {
            columns.iter().zip(point).for_each(|(&k, value)| row[k] = value);
        }
    });
    refuses(at, &["identify", "s", "--save", "x.yaml"], "unlike-description", &["registration leaves"]);
    assert!(!at.join("x.yaml").exists());
}

/// The last joint counts the other way, and the markers are near its axis: registration leaves less than tolerances allow.
#[test]
fn a_last_joint_that_counts_the_other_way() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let arguments = ["--markers", "TCP,wrist", "--poses", "50", "--seed", "3", "--unknown-base", "--unknown-tool"];
    simulated(at, "kuka-ir663", &[&with_noise()[..], &arguments].concat());
    silent(at);
    assert_eq!(run(at, &["identify", "s", "--save", "sound.yaml"]).status, 0);
    assert!(at.join("sound.yaml").exists());
    spoil(&at.join("s"), |table| table.scale(&["q7"], -1.0));
    refuses(at, &["identify", "s", "--save", "x.yaml"], "misread", &["`q7` negated"]);
    assert!(!at.join("x.yaml").exists());
}

/// Three readings of ten are wrong: the fit bends to them, and half of the others still say so.
#[test]
fn many_wrong_readings_are_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let arguments = ["--markers", "m1,m2,m3", "--poses", "40", "--seed", "3", "--unknown-base", "--unknown-tool"];
    simulated(at, "kuka-kr270", &[&with_noise()[..], &arguments].concat());
    silent(at);
    spoil(&at.join("s"), |table| {
        let mut random = ChaCha8Rng::seed_from_u64(8);
        let columns = ["x", "y", "z"].map(|name| table.column(name));
        for row in &mut table.rows {
            if random.random_range(0.0..1.0) < 0.3 {
                for k in columns {
                    let value: f64 = row[k].parse().expect("a number");
                    row[k] = (value + random.random_range(-8.0..8.0)).to_string();
                }
            }
        }
    });
    let ran = run(at, &["identify", "s", "--save", "x.yaml", "--format", "json"]);
    let found = json(&ran);
    let said = [of_code(&found, "outlying-readings"), of_code(&found, "unlike-description")].concat();
    assert!(!said.is_empty() && !at.join("x.yaml").exists(), "{}", found["diagnostics"]);
}

/// A calibration that makes unseen readings worse, however little, is said and not written where nothing says that it is noise.
#[test]
fn nothing_worse_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    // A robot as described: calibration has nothing to find.
    let arguments = ["--noise", "0.03", "--errors", "0", "--poses", "60", "--seed", "3", "--unknown-base"];
    simulated(at, "universal-ur5", &[&arguments[..], &["--unknown-tool"]].concat());
    silent(at);
    let ran = run(at, &["identify", "s", "--save", "x.yaml", "--format", "json"]);
    let found = json(&ran);
    let [before, after] =
        ["check_registration", "check_after"].map(|of| found["residuals"][of]["rms"].as_f64().unwrap_or(f64::NAN));
    assert!(after > before && after < 1.1 * before, "{before} {after}: this campaign shows nothing");
    assert_eq!(of_code(&found, "worse-than-registered").len(), 1, "{}", found["diagnostics"]);
    assert!(!at.join("x.yaml").exists());
}
