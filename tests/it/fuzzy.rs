//! Fuzzy compliances: the published rule base, the form of the IR663 paper's comparison, and what a new user gets wrong.

use elastogeo::description::fuzzy::{Premise, Rules};
use elastogeo::fuzzy::{firing, value};
use serde_json::Value;

use crate::cli::{PLANAR, Ran, run};
use crate::figures::recorded;
use crate::support::{golden, numbers};

/// Table 4 of the IR663 paper: modal values in deg, conclusions in mm.
fn table_4() -> (Rules, Vec<Vec<f64>>, Vec<[f64; 3]>) {
    let golden = golden();
    let table = &golden["fuzzy_table4"];
    let modes = ["theta2_modes_deg", "theta8_modes_deg"].map(|name| numbers(&table[name])).to_vec();
    let rules = Rules { premise: Premise::Grid(modes.clone()), conclusions: numbers(&table["b_mm_theta8_fastest"]) };
    let number = |sample: &Value, name: &str| sample[name].as_f64().expect("a number");
    let samples = table["samples"].as_array().expect("samples").iter();
    let samples = samples.map(|s| ["theta2_deg", "theta8_deg", "y_mm"].map(|name| number(s, name))).collect();
    (rules, modes, samples)
}

#[test]
fn table_4_evaluates_exactly() {
    let (rules, modes, samples) = table_4();
    for [a, b, y] in samples {
        assert!((value(&rules, &[a, b]) - y).abs() < 1e-12, "at {a}, {b}: {}", value(&rules, &[a, b]));
        let mut sum = 0.0;
        firing(&modes, &[a, b], &mut |_, weight| sum += weight);
        assert!((sum - 1.0_f64).abs() < 1e-15);
    }
}

/// The same rule base in a description: what `pose`, `stiffness` and `simulate` predict under a load.
#[test]
fn a_declared_rule_base_is_used_wherever_springs_are() {
    let folder = tempfile::tempdir().expect("a folder");
    let (rules, modes, samples) = table_4();
    let yaml = format!(
        "{PLANAR}fuzzy:\n  inputs: [q1, q2]\n  at: tip\n  components:\n    x.fx: {{modes: {:?}, conclusions: {:?}}}\n",
        modes, rules.conclusions
    );
    std::fs::write(folder.path().join("arm.yaml"), yaml).expect("written");
    for [a, b, y] in samples {
        let joints = format!("q1={a},q2={b}");
        let pose = ["pose", "arm.yaml", "--joints", &joints, "--wrench", "2,0,0", "--format", "json"];
        let ran = run(folder.path(), &pose);
        assert_eq!(ran.status, 0, "{}", ran.err);
        let json: Value = serde_json::from_str(&ran.out).expect("JSON");
        let found = json["deflection"]["marker tip"][0].as_f64().expect("a number");
        assert!((found - 2e-3 * y).abs() < 1e-14, "{found} {y}");
        let stiffness = ["stiffness", "arm.yaml", "--joints", &joints, "--at", "tip", "--format", "json"];
        let json: Value = serde_json::from_str(&run(folder.path(), &stiffness).out).expect("JSON");
        let found = json["compliance"][0][0].as_f64().expect("a number");
        assert!((found - 1e-3 * y).abs() < 1e-14, "{found} {y}");
    }
    let simulate = ["simulate", "arm.yaml", "--poses", "5", "--observes", "deflection", "--markers", "tip", "--noise"];
    let ran = run(folder.path(), &[&simulate[..], &["0", "--wrench", "1,0,0", "--into", "c"]].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    let rows = std::fs::read_to_string(folder.path().join("c/measurements.csv")).expect("written");
    for row in rows.lines().skip(1) {
        let cells: Vec<f64> = row.split(',').skip(2).take(3).map(|cell| cell.parse().expect("a number")).collect();
        assert!((cells[2] - value(&rules, &cells[..2])).abs() < 1e-6, "{row}");
    }
    let refused = run(folder.path(), &["pose", "arm.yaml", "--joints", "q1=1", "--wrench", "1,0,0", "--equilibrium"]);
    assert!(refused.status == 2 && refused.err.contains("leave --equilibrium out"), "{}", refused.err);
}

/// The campaign of the paper on an IR663 with compliant screws: 126 configurations, 36 of them held out, four loads along x
/// and z.
fn campaign(screws: bool) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let text =
        std::fs::read_to_string(format!("{}/robots/kuka-ir663.yaml", env!("CARGO_MANIFEST_DIR"))).expect("a file");
    let soft = text.replace("axial: {value: .inf}", "axial: {value: 2e4, identifiable: true}");
    assert_ne!(text, soft);
    std::fs::write(folder.path().join("screws.yaml"), soft).expect("written");
    let poses: Vec<String> =
        (0..126).map(|n| format!("0,{},{},0,90,0", 620 + 25 * (n / 9), 610 + 35 * (n % 9))).collect();
    let poses = format!("q1,stroke2,stroke8,q4,q5,q7\n{}\n", poses.join("\n"));
    std::fs::write(folder.path().join("grid.csv"), poses).expect("written");
    let robot = if screws { "screws.yaml" } else { "kuka-ir663" };
    let mut arguments: Vec<String> =
        ["simulate", robot, "--poses", "grid.csv", "--observes", "deflection"].map(String::from).to_vec();
    arguments.extend(["--markers", "wrist", "--errors", "0", "--noise", "0.03", "--check", "0.2857"].map(String::from));
    for force in [300, 600, 900, 1100] {
        arguments.extend(["--wrench".into(), format!("{force},0,0"), "--wrench".into(), format!("0,0,-{force}")]);
    }
    arguments.extend(["--into", "c"].map(String::from));
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let ran = run(folder.path(), &arguments);
    assert_eq!(ran.status, 0, "{}", ran.err);
    folder
}

fn json_of(ran: &Ran) -> Value {
    assert_eq!(ran.status, 0, "{}", ran.err);
    serde_json::from_str(&ran.out).expect("JSON")
}

/// Root mean square error over all loads of a method.
fn overall(json: &Value, method: &str) -> f64 {
    let methods = json["methods"].as_array().expect("methods");
    let found = methods.iter().find(|entry| entry["method"] == method).expect("the method");
    let all = found["rows"].as_array().expect("rows").last().expect("a row");
    all["rms"].as_f64().expect("a number")
}

/// Table 5 of the paper: rules (0.065 mm) beat springs that leave the screws out (0.110 mm); declaring the screws beats
/// both.
#[test]
fn rules_beat_springs_without_screws_and_screws_beat_rules() {
    let folder = campaign(true);
    let compare = |robot: &str| {
        let arguments = ["identify", "c", "--robot", robot, "--what", "fuzzy", "--compare", "--fit-force", "900"];
        let ran = run(folder.path(), &[&arguments[..], &["--format", "json"]].concat());
        json_of(&ran)
    };
    let without = compare("kuka-ir663");
    let with = compare("screws.yaml");
    let [parametric, fuzzy, grey] = ["parametric", "fuzzy", "grey"].map(|method| overall(&without, method));
    let screws = overall(&with, "parametric");
    let rows = [
        ("springs, screws left out", parametric),
        ("fuzzy compliance", fuzzy),
        ("springs without screws, and a fuzzy correction", grey),
        ("springs and screws", screws),
    ];
    recorded("fuzzy", "cargo test rules_beat_springs", &rows.map(|(row, rms)| format!("{row}: {rms:.4} mm")));
    assert!(fuzzy <= parametric * 0.065 / 0.110, "{fuzzy} against {parametric}");
    // What springs leave after taking up all they can is rougher than the compliance itself.
    assert!(grey < 0.7 * parametric, "{grey} against {parametric}");
    assert!(screws < fuzzy && screws < grey, "{screws}, {fuzzy}, {grey}");
    assert!((screws / (0.03 * 3_f64.sqrt()) - 1.0).abs() < 0.1, "the noise: {screws}");
}

#[test]
fn what_is_identified_is_what_is_saved_and_random_search_is_no_better() {
    let folder = campaign(true);
    let arguments = ["identify", "c", "--robot", "kuka-ir663", "--what", "fuzzy", "--format", "json"];
    let saving = [&arguments[..], &["--save", "rules.yaml"]].concat();
    let fit = json_of(&run(folder.path(), &saving));
    let residuals = json_of(&run(folder.path(), &["residuals", "rules.yaml", "c", "--format", "json"]));
    let number = |value: &Value| value.as_f64().expect("a number");
    let (here, there) = (number(&fit["residuals"]["check_after"]["rms"]), number(&residuals["check"]["rms"]));
    assert!((here - there).abs() < 1e-9, "{here} {there}");
    assert!(fit["levels"].as_array().expect("levels").iter().all(|level| (number(&level["gain"]) - 1.0).abs() < 0.02));
    let random = json_of(&run(folder.path(), &[&arguments[..], &["--placement", "solis-wets"]].concat()));
    let random = number(&random["residuals"]["check_after"]["rms"]);
    assert!(here <= random * 1.05, "{here} against {random}");
}

#[test]
fn a_correction_of_what_physics_explains_is_not_kept() {
    let folder = campaign(false);
    let arguments = ["identify", "c", "--what", "grey", "--format", "json"];
    let json = json_of(&run(folder.path(), &arguments));
    assert_eq!(json["kept"], false, "{json}");
}

#[test]
fn wrong_rules_are_refused() {
    let folder = campaign(true);
    let cases: &[(&[&str], &str)] = &[
        (&["c", "--what", "fuzy"], "did you mean `fuzzy`?"),
        (&["c", "--what", "fuzzy,geometric"], "identify the geometry first"),
        (&["c", "--what", "fuzzy,elastic", "--save", "x.yaml"], "ask for one"),
        (&["c", "--inputs", "q1"], "add --what fuzzy"),
        (&["c", "--reciprocal"], "add --what fuzzy"),
        (&["c", "--what", "fuzzy", "--structure", "grid", "--reciprocal"], "take --structure tree"),
        (&["c", "--what", "fuzzy", "--axes", "11x"], "no frame is called `11x`"),
        (&["c", "--what", "fuzzy", "--inputs", "stroke3"], "did you mean `stroke"),
        (&["c", "--what", "fuzzy", "--inputs", "stroke2,stroke2"], "given twice"),
        (&["c", "--what", "fuzzy", "--fit-force", "500"], "forces in the campaign, N: 300, 600, 900, 1100"),
        (&["kr270-simulated", "--what", "fuzzy"], "observes: deflection"),
        (&["kr270-no-compensator", "--what", "fuzzy"], "`load_point`"),
    ];
    for (arguments, expected) in cases {
        let ran = run(folder.path(), &[&["identify"], *arguments].concat());
        assert_eq!(ran.status, 2, "{arguments:?}: {}", ran.err);
        assert!(ran.err.contains(expected), "{arguments:?}: {}", ran.err);
        assert_eq!(ran.out, "");
    }
    let wrong: &[(&str, &str)] = &[
        ("inputs: [q3]\n  components: {x.fx: {modes: [[0]], conclusions: [1]}}", "did you mean `q1`?"),
        ("inputs: [q1]\n  components: {xx: {modes: [[0]], conclusions: [1]}}", "write displacement.load"),
        ("inputs: [q1]\n  components: {x.fx: {modes: [[1, 0]], conclusions: [1, 2]}}", "ascend"),
        ("inputs: [q1]\n  components: {x.fx: {modes: [[0, 1]], conclusions: [1]}}", "1 conclusions for 2 rules"),
        ("inputs: [q1, q2]\n  components: {x.fx: {modes: [[0, 1]], conclusions: [1, 2]}}", "1 lists for 2 inputs"),
        ("inputs: [q1]\n  at: tap\n  components: {x.fx: {modes: [[0]], conclusions: [1]}}", "did you mean `tip`?"),
        ("inputs: [q1]", "has no `components`"),
        ("inputs: [q1]\n  axes: F\n  components: {x.fx: {tree: 1}}", "unknown frame `F`"),
        ("inputs: [q1]\n  components: {x.fx: {tree: 1, modes: [[0]], conclusions: [1]}}", "both a `tree` and a grid"),
        ("inputs: [q1]\n  components: {x.fx: {tree: .inf}}", "finite"),
        (
            "inputs: [q1]\n  components: {x.fx: {tree: {input: q2, from: 0, to: 1, below: 1, above: 2}}}",
            "`q2` is no input of the rules",
        ),
        (
            "inputs: [q1]\n  components: {x.fx: {tree: {input: q1, from: 1, to: 1, below: 1, above: 2}}}",
            "`from` below `to`",
        ),
        ("inputs: [q1]\n  components: {x.fx: {tree: {input: q1, from: 1, to: 2, below: 1}}}", "tree"),
        ("inputs: [q1]\n  springs: {joint1.kar: {tree: 0}}", "holds nothing"),
        ("inputs: [q1]\n  springs: {joint1.kar: {}}", "`joint1.kar` has no rules"),
        ("inputs: [q1]\n  components: {x.fx: {tree: abc}}", "a conclusion (a number), or a split"),
        (
            "inputs: [q1]\n  components: {x.fx: {tree: {input: q1, from: 0, to: 1, below: 1, above: 2, at: 3}}}",
            "unknown key `at`",
        ),
        ("inputs: [q1]\n  springs: {joint1.kra: {tree: 1e5}}", "no spring of this description"),
    ];
    for (fuzzy, expected) in wrong {
        std::fs::write(folder.path().join("arm.yaml"), format!("{PLANAR}fuzzy:\n  {fuzzy}\n")).expect("written");
        let ran = run(folder.path(), &["check", "arm.yaml"]);
        assert_eq!(ran.status, 2, "{fuzzy}: {}", ran.err);
        assert!(ran.err.contains(expected), "{fuzzy}: {}", ran.err);
    }
}

/// Rules in a file of their own do what the same rules do in the description; their faults are reported where they stand.
#[test]
fn rules_may_stand_in_a_file_of_their_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    let rules = "inputs: [q1, q2]\nat: tip\ncomponents:\n  x.fx: {modes: [[-24, 37], [33, 63]], conclusions: [1.0, 2.0, 1.5, 3.0]}\n";
    std::fs::create_dir(folder.path().join("parts")).expect("made");
    write("parts/rules.yaml", rules);
    write("beside.yaml", &format!("{PLANAR}fuzzy: {{file: parts/rules.yaml}}\n"));
    write("inside.yaml", &format!("{PLANAR}fuzzy:\n  {}\n", rules.trim_end().replace('\n', "\n  ")));
    let under = |robot: &str| {
        let ran =
            run(folder.path(), &["pose", robot, "--joints", "q1=10,q2=40", "--wrench", "2,0,0", "--format", "json"]);
        assert_eq!(ran.status, 0, "{}", ran.err);
        json_of(&ran)["deflection"].clone()
    };
    assert!(!under("inside.yaml").is_null());
    assert_eq!(under("beside.yaml"), under("inside.yaml"));
    let told = run(folder.path(), &["check", "beside.yaml"]);
    assert!(told.out.contains("fuzzy compliance of marker tip"), "{}", told.out);
    assert!(told.out.contains("inputs q1 q2; rules of each component: x.fx 4"), "{}", told.out);
    let json = json_of(&run(folder.path(), &["check", "beside.yaml", "--format", "json"]));
    assert_eq!(json["fuzzy"]["rules"]["x.fx"], 4);

    write("short.yaml", &rules.replace(", 3.0]", "]"));
    write("typo.yaml", &rules.replace("inputs:", "input:"));
    write("loop.yaml", "file: rules.yaml\n");
    let cases = [
        ("fuzzy: {file: short.yaml}", "short.yaml:4", "3 conclusions for 4 rules"),
        ("fuzzy: {file: typo.yaml}", "typo.yaml:1", "`inputs`"),
        ("fuzzy: {file: loop.yaml}", "loop.yaml:1", "cannot name another"),
        ("fuzzy: {file: none.yaml}", "arm.yaml", "there is no file"),
        ("fuzzy: {file: short.yaml, adds: true}", "arm.yaml", "has other keys"),
    ];
    for (line, place, what) in cases {
        write("arm.yaml", &format!("{PLANAR}{line}\n"));
        let ran = run(folder.path(), &["check", "arm.yaml"]);
        assert_eq!(ran.status, 2, "{line}: {}", ran.err);
        assert!(ran.err.contains(place) && ran.err.contains(what), "{line}: {}", ran.err);
    }
}

/// `--save-rules` writes what `--save` alone writes into the description, and the report draws it.
#[test]
fn identified_rules_are_saved_in_a_file_of_their_own_and_drawn() {
    let folder = campaign(false);
    let identify = ["identify", "c", "--what", "fuzzy", "--save"];
    let ran = run(folder.path(), &[&identify[..], &["whole.yaml"]].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    let ran = run(folder.path(), &[&identify[..], &["named.yaml", "--save-rules", "rules.yaml"]].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    let named = std::fs::read_to_string(folder.path().join("named.yaml")).expect("written");
    assert!(named.contains("file: rules.yaml") && !named.contains("conclusions"), "{named}");
    let residuals = |robot: &str| {
        let ran = run(folder.path(), &["residuals", robot, "c", "--format", "json"]);
        assert_eq!(ran.status, 0, "{}", ran.err);
        let mut json = json_of(&ran);
        json["seconds"] = Value::Null;
        json.to_string().replace(robot, "")
    };
    assert_eq!(residuals("named.yaml"), residuals("whole.yaml"));
    for (flags, what) in [
        (&["whole.yaml", "--save-rules", "r.txt"][..], "end the name in .yaml"),
        (&["whole.yaml", "--save-rules", "whole.yaml"], "the file of --save"),
    ] {
        let ran = run(folder.path(), &[&identify[..], flags].concat());
        assert_eq!(ran.status, 2, "{}", ran.err);
        assert!(ran.err.contains(what), "{}", ran.err);
    }
    let ran = run(folder.path(), &["report", "c", "--robot", "named.yaml", "--output", "r.html"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let page = std::fs::read_to_string(folder.path().join("r.html")).expect("written");
    assert!(page.contains("id=\"rules\"") && page.contains("Fuzzy compliance"), "no section");
}

/// Rules over many inputs and few readings: what hardly any reading reaches is what its neighbours are, and doubtful use is
/// told.
#[test]
fn rules_say_no_more_than_the_readings_did() {
    let folder = tempfile::tempdir().expect("a folder");
    // Joints 2 and 3 vary in turns: no reading has both far out.
    let pose = |k: i32| match k % 2 {
        0 => format!("0,{},50,0,40,0", -110 + 40 * k / 60),
        _ => format!("0,-110,{},0,40,0", 50 + 60 * k / 60),
    };
    let poses: Vec<String> = (0..60).map(pose).collect();
    let poses = format!("q1,q2,q3,q4,q5,q6\n{}\n", poses.join("\n"));
    std::fs::write(folder.path().join("poses.csv"), poses).expect("written");
    let simulate = [
        "simulate",
        "kuka-kr270",
        "--poses",
        "poses.csv",
        "--observes",
        "deflection",
        "--markers",
        "m1",
        "--into",
        "c",
    ];
    let loads = ["--errors", "0", "--wrench=1500,0,0", "--wrench=0,0,-1500", "--wrench=0,0,-800"];
    let ran = run(folder.path(), &[&simulate[..], &loads].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    let identify = ["identify", "c", "--what", "fuzzy", "--save", "rules.yaml", "--format", "json"];
    let json = json_of(&run(folder.path(), &identify));
    let mut unseen = 0;
    for component in json["components"].as_array().expect("components") {
        let conclusions = numbers(&component["conclusions"]);
        let bare: Vec<usize> = numbers(&component["unseen"]).iter().map(|rule| *rule as usize).collect();
        let seen = (0..conclusions.len()).filter(|rule| !bare.contains(rule)).map(|rule| conclusions[rule]);
        let [low, high] = seen.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], c| [low.min(c), high.max(c)]);
        let margin = 0.05 * (high - low);
        for rule in &bare {
            let own = conclusions[*rule];
            assert!(own >= low - margin && own <= high + margin, "{} rule {rule}: {own:e}", component["name"]);
        }
        unseen += bare.len();
    }
    println!("{unseen} rules without data");
    assert!(unseen > 0, "the case has rules that no reading reaches");
    // Two sizes in one direction: whether the arm is linear can be decided, and it is.
    let levels = json["levels"].as_array().expect("levels");
    let linear: Vec<f64> = levels.iter().filter_map(|level| level["linear"]["gain"].as_f64()).collect();
    assert!(linear.len() == 2 && linear.iter().all(|gain| (gain - 1.0).abs() < 0.02), "{levels:?}");

    let stiffness = ["stiffness", "rules.yaml", "--wrench", "0,0,-500", "--joints"];
    let at_home = run(folder.path(), &[&stiffness[..], &["q2=-70,q3=60", "--at", "m1"]].concat());
    assert!(at_home.status == 0 && at_home.out.contains("no strain-energy shares"), "{}", at_home.out);
    assert!(!at_home.err.contains("rotation"), "{}", at_home.err);
    let elsewhere = run(folder.path(), &[&stiffness[..], &["q1=170,q2=-30,q3=60"]].concat());
    assert!(elsewhere.err.contains("those of m1") && elsewhere.err.contains("are outside"), "{}", elsewhere.err);
    let view = run(folder.path(), &["view", "rules.yaml", "--wrench", "0,0,-500"]);
    assert!(view.status == 2 && view.err.contains("leave --wrench out"), "{}", view.err);
}
