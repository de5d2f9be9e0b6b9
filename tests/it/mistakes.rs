//! Mistakes of new users: reported early, and no file lost by them.

use std::path::Path;

use super::cli::{PLANAR, Ran, run};

fn folder_with(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, content) in files {
        std::fs::write(folder.path().join(name), content).expect("written");
    }
    folder
}

fn warns(ran: &Ran, expected: &[&str]) {
    assert_eq!(ran.status, 0, "{}", ran.err);
    for word in expected {
        assert!(ran.err.contains(word), "`{word}`: {}", ran.err);
    }
}

fn refuses(ran: &Ran, expected: &[&str]) {
    assert_eq!((ran.status, ran.out.as_str()), (2, ""), "{}", ran.err);
    for word in expected {
        assert!(ran.err.contains(word), "`{word}`: {}", ran.err);
    }
}

const CAMPAIGN: &str = "robot: arm.yaml
units: {length: mm, angle: deg}
observes: position
measurements: [m.csv, n.csv]
";

fn residuals(folder: &Path) -> Ran {
    run(folder, &["residuals", "arm.yaml", "c.yaml"])
}

#[test]
fn joints_beyond_their_limits() {
    let sound = "pose,q1,q2,x,y,z\na,0,0,900,0,0\nb,10,90,800,200,0\n";
    let far = "pose,q1,q2,x,y,z\nc,-90,20,800,-100,0\nd,-90.5,20,800,-100,0\ne,-100,20,800,-100,0\n";
    let folder = folder_with(&[("arm.yaml", PLANAR), ("c.yaml", CAMPAIGN), ("m.csv", sound), ("n.csv", far)]);
    let ran = residuals(folder.path());
    warns(&ran, &["`q1` is beyond its limits -90 .. 90 deg in 2 of 5 readings; the first: -90.5 deg", "n.csv:3:3"]);
    warns(&ran, &["angles here are in deg", "`units`", "0 errors, 1 warning"]);
    std::fs::write(folder.path().join("n.csv"), far.replace("-90.5", "-90.00001").replace("-100,20", "90,20"))
        .expect("written");
    assert_eq!(residuals(folder.path()).err, "", "what rounding makes is nothing");

    let said = &["`q1` = 120 deg is beyond its limits -90 .. 90 deg", "angles here are in deg", "0 errors, 1 warning"];
    warns(&run(folder.path(), &["pose", "arm.yaml", "--joints", "q1=120"]), said);
    let turned = &["`q1` = 400 deg is beyond its limits", "less 360 deg it is within them", "0 errors, 1 warning"];
    warns(&run(folder.path(), &["pose", "arm.yaml", "--joints", "q1=400"]), turned);
    let solve = ["solve", "arm.yaml", "--target", "800,100,0", "--from"];
    warns(&run(folder.path(), &[&solve[..], &["q1=120"]].concat()), said);
    assert_eq!(run(folder.path(), &[&solve[..], &["q1=90"]].concat()).err, "");

    let table = "q1,q2\n10,20\n10,91\n-20,30\n30,-40\n-50,60\n";
    std::fs::write(folder.path().join("t.csv"), table).expect("written");
    for arguments in [
        &["pose", "arm.yaml", "--table", "t.csv"][..],
        &["simulate", "arm.yaml", "--poses", "t.csv", "--into", "s"],
        &["plan", "arm.yaml", "--poses", "6", "--test", "t.csv"],
    ] {
        let ran = run(folder.path(), arguments);
        warns(&ran, &["`q2` is beyond its limits -90 .. 90 deg in 1 of 5 rows; the first: 91 deg", "t.csv:3:4"]);
    }
    let ran = run(folder.path(), &["plan", "arm.yaml", "--poses", "6", "--range", "q1=-10:200"]);
    warns(&ran, &["--range `q1=-10:200` is narrowed to -10.0000:90.0000"]);
}

#[test]
fn one_name_for_two_configurations() {
    let first = "pose,q1,q2,x,y,z\na,0,0,900,0,0\na,0.001,0,900,0,0\nb,10,20,800,200,0\n";
    let second = "pose,q1,q2,x,y,z\nb,10,30,800,200,0\nb,10,40,800,200,0\na,5,0,900,0,0\n";
    let folder = folder_with(&[("arm.yaml", PLANAR), ("c.yaml", CAMPAIGN), ("m.csv", first), ("n.csv", second)]);
    let said =
        ["the pose `b` has rows with different joints: `q2` is 30.0000 deg, and 20.0000 deg before; so have 1 more"];
    let ran = residuals(folder.path());
    warns(&ran, &said);
    warns(&ran, &["n.csv:2:6", "m.csv:4:6", "first given here", "0 errors, 1 warning"]);
}

#[test]
fn plans_go_on_with_names_of_their_own() {
    let folder = folder_with(&[("arm.yaml", PLANAR)]);
    let folder = folder.path();
    assert_eq!(run(folder, &["simulate", "arm.yaml", "--poses", "12", "--into", "c"]).status, 0);
    let plan = ["plan", "arm.yaml", "--poses", "4", "--add-to", "c", "--table"];
    let ran = run(folder, &[&plan[..], &["more.csv"]].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    let table = std::fs::read_to_string(folder.join("more.csv")).expect("a table");
    let names: Vec<&str> = table.lines().skip(1).filter_map(|line| line.split(',').next()).collect();
    assert_eq!(names, ["p013", "p014", "p015", "p016"]);
    assert!(names.iter().all(|name| ran.out.contains(name)) && !ran.out.contains("p001"), "{}", ran.out);
    // What it wrote can be looked at.
    assert_eq!(run(folder, &["pose", "arm.yaml", "--table", "more.csv"]).status, 0);
    // Written over the readings it adds to, nothing would be left.
    let readings = std::fs::read_to_string(folder.join("c/measurements.csv")).expect("read");
    refuses(
        &run(folder, &[&plan[..], &["c/../c/measurements.csv"]].concat()),
        &["would be written over", "another name"],
    );
    assert_eq!(std::fs::read_to_string(folder.join("c/measurements.csv")).expect("read"), readings);
}

#[test]
fn nothing_that_was_read_is_written_over() {
    let path = "q1,q2\n10,20\n20,30\n";
    let folder = folder_with(&[("arm.yaml", PLANAR), ("path.csv", path)]);
    let folder = folder.path();
    assert_eq!(run(folder, &["simulate", "arm.yaml", "--poses", "20", "--into", "c"]).status, 0);
    let campaign = std::fs::read_to_string(folder.join("c/campaign.yaml")).expect("read");
    for arguments in [
        &["identify", "c", "--save", "arm.yaml"][..],
        &["identify", "c", "--save", "c/campaign.yaml"],
        &["identify", "c", "--save", "new.yaml", "--output", "arm.yaml"],
        &["diagnose", "c", "--apply", "./arm.yaml"],
        &["convert", "arm.yaml", "arm.yaml"],
        &["compensate", "arm.yaml", "path.csv", "--table", "path.csv"],
        &["pose", "arm.yaml", "--table", "path.csv", "--output", "path.csv"],
    ] {
        refuses(&run(folder, arguments), &["would be written over", "give another name"]);
    }
    // A table that a campaign names, by a command that has not read it; a page in the place of a description.
    let table = std::fs::read_to_string(folder.join("c/measurements.csv")).expect("read");
    let plan = ["plan", "arm.yaml", "--poses", "5", "--noise", "0.1", "--table", "c/measurements.csv"];
    refuses(&run(folder, &plan), &["would be written over", "campaign.yaml` names it"]);
    refuses(&run(folder, &["report", "c", "--output", "arm.yaml"]), &["a page is written", ".html"]);
    assert_eq!(std::fs::read_to_string(folder.join("c/measurements.csv")).expect("read"), table);
    assert_eq!(std::fs::read_to_string(folder.join("arm.yaml")).expect("read"), PLANAR);
    assert_eq!(std::fs::read_to_string(folder.join("path.csv")).expect("read"), path);
    assert_eq!(std::fs::read_to_string(folder.join("c/campaign.yaml")).expect("read"), campaign);
    assert!(!folder.join("new.yaml").exists());
    for _ in 0..2 {
        assert_eq!(run(folder, &["identify", "c", "--save", "new.yaml"]).status, 0, "what it wrote before may go");
    }
}

#[test]
fn simulated_readings_do_not_replace_real_ones() {
    let simulate = ["simulate", "arm.yaml", "--poses", "5", "--into", "c"];
    for kept in ["campaign.yaml", "measurements.csv"] {
        let folder = folder_with(&[("arm.yaml", PLANAR)]);
        std::fs::create_dir(folder.path().join("c")).expect("made");
        std::fs::write(folder.path().join("c").join(kept), "mine").expect("written");
        for truth in ["", "{}", "{\"mine\": 1}"] {
            if !truth.is_empty() {
                std::fs::write(folder.path().join("c/truth.json"), truth).expect("written");
            }
            let ran = run(folder.path(), &simulate);
            refuses(&ran, &[&format!("`c` has a {kept} that `simulate` did not write"), "give another folder"]);
        }
        assert_eq!(std::fs::read_to_string(folder.path().join("c").join(kept)).expect("read"), "mine");
    }
    let folder = folder_with(&[("arm.yaml", PLANAR)]);
    for _ in 0..2 {
        let ran = run(folder.path(), &simulate);
        assert_eq!(ran.status, 0, "its own may go: {}", ran.err);
    }
    for name in ["campaign.yaml", "measurements.csv"] {
        let path = folder.path().join("c").join(name);
        let edited = std::fs::read_to_string(&path).expect("read") + "\n";
        std::fs::write(&path, &edited).expect("written");
        refuses(&run(folder.path(), &simulate), &[&format!("{name} in `c` was edited since"), "--force"]);
        assert_eq!(std::fs::read_to_string(&path).expect("read"), edited);
        assert_eq!(run(folder.path(), &[&simulate[..], &["--force"]].concat()).status, 0);
        assert_ne!(std::fs::read_to_string(&path).expect("read"), edited);
    }
}

#[test]
fn units_that_nobody_declared() {
    let bare = PLANAR.lines().skip(1).map(|line| format!("{line}\n")).collect::<String>();
    let process =
        "springs:\n  - {at: [0.5, 0, 0], stiffness: [10, 0, 0]}\n  - {at: [900, 0, 0], stiffness: [10, 0, 0]}\n";
    let strip = "units: {length: mm}\nstrip: {clamp: [900, 0, 0], along: [0, 0, 1], push: [1, 0, 0], length: 500, \
                 width: 50, height: 5, young: 210}\n";
    let files = [("arm.yaml", bare.as_str()), ("good.yaml", PLANAR), ("p.yaml", process), ("s.yaml", strip)];
    let folder = folder_with(&files);
    let ran = run(folder.path(), &["check", "arm.yaml"]);
    warns(
        &ran,
        &["the lengths of the frames add up to 900 m", "arm.yaml:4:", "joint `1` may turn by 90 rad", "arm.yaml:3:"],
    );
    warns(&ran, &["`units: {length: mm, angle: deg}`", "0 errors, 2 warnings"]);
    std::fs::write(folder.path().join("path.csv"), "q1,q2\n0,0\n").expect("written");
    let compensate = |process: &str| {
        let path = ["compensate", "good.yaml", "path.csv", "--nominal", "good.yaml", "--process"];
        run(folder.path(), &[&path[..], &[process]].concat())
    };
    let ran = compensate("p.yaml");
    assert!(ran.err.contains("`at` is 900 m away") && ran.err.contains("p.yaml:3:10"), "{}", ran.err);
    assert!(ran.err.contains("`units: {length: mm}`") && ran.err.matches(" m away").count() == 1, "{}", ran.err);
    let ran = compensate("s.yaml");
    assert!(ran.err.contains("`young` of the strip is 210 Pa") && ran.err.contains("s.yaml:2:"), "{}", ran.err);
    assert!(ran.err.contains("`units: {pressure: GPa}`") && !ran.err.contains("away"), "{}", ran.err);
    // Of a unit that there is not, the one most like it would be another unit.
    std::fs::write(folder.path().join("yd.yaml"), PLANAR.replace("length: mm", "length: yd")).expect("written");
    refuses(
        &run(folder.path(), &["check", "yd.yaml"]),
        &["valid here: `m`, `cm`, `mm`, `um`, `in`, `ft`", "1 error, 0 warnings"],
    );
    std::fs::write(folder.path().join("nine.yaml"), PLANAR.replace("antecedent: 2", "antecedent: 9")).expect("written");
    refuses(&run(folder.path(), &["check", "nine.yaml"]), &["unknown frame `9`", "valid here: `0`, `1`, `2`"]);
}

#[test]
fn amounts_that_no_robot_has() {
    let arm = format!("{PLANAR}joint_stiffness: {{2: {{kar: {{value: 200000, identifiable: true}}}}}}\n");
    let with = |effect: &str| format!("{arm}effects:\n  - {effect}\n");
    let folder = folder_with(&[("arm.yaml", &arm)]);
    let simulate =
        |set: &str| run(folder.path(), &["simulate", "arm.yaml", "--poses", "3", "--into", "c", "--set", set]);
    refuses(&simulate("joint2.kar=-2e6"), &["makes `joint2.kar` -1800000, and it must be above 0", "says, 200000"]);
    refuses(&simulate("joint2.kar=-2e5"), &["makes `joint2.kar` 0, and it must be above 0"]);
    assert_eq!(simulate("joint2.kar=-1.9e5").status, 0);
    assert_eq!(simulate("joint2.kar=inf").status, 0);
    // Of what is rigid as described it is the stiffness itself.
    assert_eq!(simulate("joint1.kar=4e5").status, 0);
    let truth: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("c/truth.json")).expect("read")).expect("JSON");
    let compliance = truth["parameters"]["joint1.kar"]["true"].as_f64().expect("a number");
    assert!((compliance - 2.5e-6).abs() < 1e-15, "{compliance}");
    refuses(&simulate("joint1.kar=-4e5"), &["it must be above 0"]);
    let check = |effect: &str| {
        std::fs::write(folder.path().join("e.yaml"), with(effect)).expect("written");
        run(folder.path(), &["check", "e.yaml"])
    };
    let bearing = |amount: &str| {
        format!("{{effect: bearing-compliance, site: \"joint:2\", parameters: {{joint2.krr: {amount}}}}}")
    };
    warns(
        &check(&bearing("-1e-6")),
        &["`joint2.krr: -1e-6` makes it -1e-6 rad/(N.m)", "e.yaml:12:", "0 errors, 1 warning"],
    );
    assert_eq!(check(&bearing("1e-6")).err, "");
    // A spring that is compliant already changes by less.
    let less =
        |amount: &str| format!("{{effect: joint-compliance, site: \"joint:2\", parameters: {{joint2.kar: {amount}}}}}");
    assert_eq!(check(&less("-1e-6")).err, "");
    warns(&check(&less("-6e-6")), &["cannot be below 0", "what the description says, 5e-6"]);
    warns(&check("{effect: backlash, site: \"joint:2\"}"), &["`backlash` has no amount", "half_width"]);
    warns(&check("{effect: backlash, site: \"joint:2\", parameters: {changes_at: 10}}"), &["has no amount"]);
    assert_eq!(check("{effect: backlash, site: \"joint:2\", parameters: {half_width: 1e-4}}").err, "");
    let below = check("{effect: backlash, site: \"joint:2\", parameters: {half_width: -1e-4}}");
    warns(&below, &["`half_width: -1e-4` makes it -1e-4 rad, and it cannot be below 0"]);
}

/// A sum of coordinates that overflows, and a file without anything, are refused with what to do.
#[test]
fn urdfs_of_nothing_and_of_everything() {
    let arm = |at: &str| {
        format!(
            "<robot name=\"arm\"><link name=\"a\"/><link name=\"b\"/><link name=\"c\"/>
<joint name=\"p\" type=\"revolute\"><parent link=\"a\"/><child link=\"b\"/><origin xyz=\"{at} 0 0\"/><axis xyz=\"0 0 1\"/></joint>
<joint name=\"q\" type=\"revolute\"><parent link=\"b\"/><child link=\"c\"/><origin xyz=\"{at} 0 0\"/><axis xyz=\"1 0 0\"/></joint>
</robot>"
        )
    };
    let folder = folder_with(&[("sound.urdf", &arm("0.5")), ("great.urdf", &arm("1e308")), ("empty.urdf", "<!-- -->")]);
    assert_eq!(run(folder.path(), &["check", "sound.urdf"]).status, 0);
    refuses(&run(folder.path(), &["check", "great.urdf"]), &["= help: check the value"]);
    refuses(&run(folder.path(), &["check", "empty.urdf"]), &["not well-formed XML", "whose root is `<robot"]);
}

#[test]
fn tables_of_other_commands() {
    let path = "pose;q1;q2\na;10,5;20\n\"b; c\";20;30,25\n";
    let process = "springs:\n  - {at: [0.8, 0.1, 0], stiffness: [10, 0, 0]}\n";
    let folder = folder_with(&[("arm.yaml", PLANAR), ("path.csv", path), ("p.yaml", process)]);
    let folder = folder.path();
    let other = PLANAR.replace("d: 500", "d: 505");
    std::fs::write(folder.join("nominal.yaml"), &other).expect("written");
    let compensate = ["compensate", "arm.yaml", "path.csv", "--nominal", "nominal.yaml", "--table", "out.csv"];
    let ran = run(folder, &[&compensate[..], &["--hold", "position"]].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    let out = std::fs::read_to_string(folder.join("out.csv")).expect("read");
    assert!(out.starts_with("pose,q1,q2,x,y,z,rx,ry,rz\n"), "{out}");
    // The same without the poses, which are not the robot's own: joints count.
    let joints: String = out.lines().map(|line| line.split(',').take(3).collect::<Vec<_>>().join(",") + "\n").collect();
    std::fs::write(folder.join("joints.csv"), &joints).expect("written");
    let simulated = |table: &str, into: &str, more: &[&str]| {
        let ran = run(folder, &[&["simulate", "arm.yaml", "--poses", table, "--into", into][..], more].concat());
        assert_eq!(ran.status, 0, "{}", ran.err);
        (ran.out.replace(into, ""), std::fs::read_to_string(folder.join(into).join("measurements.csv")).expect("read"))
    };
    for more in [&[][..], &["--process", "p.yaml"]] {
        assert_eq!(simulated("out.csv", "whole", more), simulated("joints.csv", "alone", more), "{more:?}");
    }
    let tested = |table: &str| run(folder, &["plan", "arm.yaml", "--poses", "6", "--test", table]);
    assert_eq!(tested("out.csv").status, 0, "{}", tested("out.csv").err);
    assert_eq!(tested("out.csv").out, tested("joints.csv").out);
    assert_eq!(run(folder, &["pose", "arm.yaml", "--table", "out.csv"]).status, 0);
    // Remedies of what no campaign names.
    std::fs::write(folder.join("odd.csv"), "q1,q2,temprature\n1,2,3\n").expect("written");
    for arguments in [
        &["compensate", "arm.yaml", "odd.csv"][..],
        &["pose", "arm.yaml", "--table", "odd.csv"],
        &["simulate", "arm.yaml", "--poses", "odd.csv", "--into", "d"],
        &["plan", "arm.yaml", "--poses", "4", "--test", "odd.csv"],
    ] {
        let ran = run(folder, arguments);
        refuses(&ran, &["unknown column `temprature`", "remove the column"]);
        assert!(!ran.err.contains("ignore:") && !ran.err.contains("columns:"), "{}", ran.err);
    }
}

#[test]
fn folders_and_empty_files() {
    let folder = folder_with(&[("arm.yaml", PLANAR), ("e.yaml", ""), ("e.csv", ""), ("path.csv", "q1,q2\n1,2\n")]);
    let folder = folder.path();
    std::fs::create_dir(folder.join("d")).expect("made");
    std::fs::write(folder.join("d/robot.yaml"), PLANAR).expect("written");
    refuses(&run(folder, &["check", "d"]), &["`d` is a folder", "give a file in it: `d/robot.yaml`"]);
    refuses(&run(folder, &["identify", "d"]), &["`campaign.yaml` is sought there", "`d/robot.yaml`"]);
    let process = |name: &str| run(folder, &["compensate", "arm.yaml", "path.csv", "--process", name]);
    refuses(&process("d"), &["there is no file `d/process.yaml`", "give a file in it: `d/robot.yaml`"]);
    refuses(&process("e.yaml"), &["the file is empty", "`elastogeo schema process` prints"]);
    refuses(&run(folder, &["identify", "e.yaml"]), &["`elastogeo schema campaign` prints"]);
    let remedy = "a header line that names its columns, of pose, marker, q1, q2, x,";
    refuses(&run(folder, &["compensate", "arm.yaml", "e.csv"]), &["the file is empty", remedy]);
}

/// A description in the place of a campaign, and the other way round, is named as what it is.
#[test]
fn a_description_is_no_campaign() {
    let folder = folder_with(&[("arm.yaml", PLANAR), ("c.yaml", CAMPAIGN)]);
    let folder = folder.path();
    let words = ["this is the description of a robot, and no campaign", "`robot: arm.yaml`", "1 error, 0 warnings"];
    refuses(&run(folder, &["identify", "arm.yaml"]), &words);
    let words = ["this is a campaign, and no description of a robot", "under `robot:`", "1 error, 0 warnings"];
    refuses(&run(folder, &["pose", "c.yaml", "--joints", "q1=1"]), &words);
}

/// A sum of joints whose signs stand without blanks is read as one name, which is said.
#[test]
fn sums_of_joints_need_blanks() {
    let folder = folder_with(&[("arm.yaml", &format!("{PLANAR}limits: {{q2-q1: [-60, 60]}}\n"))]);
    let words = ["unknown joint `q2-q1`", "write blanks around + and -: `q2 - q1`"];
    refuses(&run(folder.path(), &["check", "arm.yaml"]), &words);
}

/// Options that would be of no effect are refused.
#[test]
fn options_of_no_effect_are_refused() {
    let folder = folder_with(&[("arm.yaml", PLANAR)]);
    let folder = folder.path();
    assert_eq!(run(folder, &["simulate", "arm.yaml", "--poses", "30", "--into", "c"]).status, 0);
    refuses(
        &run(folder, &["identify", "c", "--train", "31"]),
        &["--train `31`, and", "configurations are there to fit"],
    );
    assert_eq!(run(folder, &["identify", "c", "--train", "15"]).status, 0);
    refuses(&run(folder, &["identify", "c", "--loss-scale", "3"]), &["--loss"]);
}

/// More rows than memory is meant for, in one file and in two, are refused with the limit and what they would take.
#[test]
fn more_rows_than_are_meant_are_refused() {
    let rows = |count: usize| "a,0,0,900,0,0\n".repeat(count);
    let [all, part] = [80_001, 50_000].map(|count| format!("pose,q1,q2,x,y,z\n{}", rows(count)));
    let few = "pose,q1,q2,x,y,z\na,0,0,900,0,0\n";
    let words = ["more than 80000 rows", "csv: {max_rows: ..}", "5 to 7 kB a row"];
    let folder = folder_with(&[("arm.yaml", PLANAR), ("c.yaml", CAMPAIGN), ("m.csv", &all), ("n.csv", few)]);
    refuses(&residuals(folder.path()), &[&words[..], &["m.csv:80002"]].concat());
    let folder = folder_with(&[("arm.yaml", PLANAR), ("c.yaml", CAMPAIGN), ("m.csv", &part), ("n.csv", &part)]);
    refuses(&residuals(folder.path()), &[&words[..], &["c.yaml:4"]].concat());
    std::fs::write(folder.path().join("c.yaml"), format!("{CAMPAIGN}csv: {{max_rows: 100}}\n")).expect("written");
    refuses(&residuals(folder.path()), &["more than 100 rows"]);
}
