//! What a user sees when a file is wrong: every fault in one run, each located, with the nearest valid name.

use std::path::Path;

use super::cli::{PLANAR, Ran, run};

fn folder_with(files: &[(&str, &[u8])]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, content) in files {
        std::fs::write(folder.path().join(name), content).expect("written");
    }
    folder
}

/// The lines with a message, as `message @ place`: without drawings.
fn check(yaml: &str) -> Ran {
    run(folder_with(&[("arm.yaml", yaml.as_bytes())]).path(), &["check", "arm.yaml"])
}

/// Replaces one piece of a sound description, adds to its end, and looks for the message and the one line that it names.
fn refuses(replace: (&str, &str), more: &str, at: &str, expected: &[&str]) {
    assert!(PLANAR.contains(replace.0), "{replace:?}");
    let text = PLANAR.replacen(replace.0, replace.1, 1) + more;
    let ran = check(&text);
    assert_eq!(ran.status, 2, "{text}\n{}", ran.err);
    assert_eq!(ran.out, "");
    for word in expected {
        assert!(ran.err.contains(word), "`{word}` is not said of\n{text}\n{}", ran.err);
    }
    if !at.is_empty() {
        let line = 1 + text.lines().position(|line| line.contains(at)).expect("the line");
        assert!(ran.err.contains(&format!("arm.yaml:{line}:")), "line {line} is not named\n{text}\n{}", ran.err);
    }
    assert!(ran.err.contains("1 error, "), "one fault, one error:\n{text}\n{}", ran.err);
}

const FOUR_BAR: &str = "units: {length: mm, angle: deg}
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, limits: [40, 100]}
  2: {antecedent: 1, joint: revolute, passive: true, d: 200}
  3: {antecedent: 2, joint: revolute, passive: true, d: 500}
  4: {antecedent: 0, joint: revolute, passive: true, gamma: 0, d: 450}
  5: {antecedent: 4, d: 300}
loops:
  bar:
    frames: [3, 5]
    branch: {2: -50, 4: 70}
tool: {frame: 3}
";

#[test]
fn frames_and_keys() {
    let none = ("units", "units");
    refuses(("antecedent: 1", "antecedent: 11"), "", "antecedent: 11", &["unknown frame `11`", "did you mean `1`?"]);
    refuses(("antecedent: 1,", ""), "", "  2:", &["frame `2` has no antecedent", "`0` is the base"]);
    refuses(("antecedent: 0", "antecedent: 2"), "", "antecedent: 2", &["circle: 1 <- 2 <- 1"]);
    refuses(
        ("  E:", "  E: {antecedent: 1}\n  E:"),
        "",
        "  E: {antecedent: 2",
        &["`E` is given twice", "first given here"],
    );
    refuses(("d: 500", "dd: 500"), "", "dd:", &["dd", "`d`"]);
    refuses(("length: mm", "length: millimetre"), "", "units", &["millimetre", "mm"]);
    refuses(("d: 500", "d: .nan"), "", "d: .nan", &["finite number"]);
    refuses(("d: 500", "d: .inf"), "", "d: .inf", &["finite number"]);
    refuses(("d: 500", "d: 1e300"), "", "d: 1e300", &["too great"]);
    refuses(
        ("variable: q2, d: 500, limits: [-90, 90]", "variable: q2, limits: [90, -90]"),
        "",
        "[90, -90]",
        &["write [-90, 90]"],
    );

    refuses(none, "calibration: {free: [2.dd]}\n", "free", &["unknown parameter `2.dd`", "did you mean `2.d`?"]);
    refuses(none, "calibration: {bounds: {2.dd: [0, 1]}}\n", "bounds", &["did you mean `2.d`?"]);
    refuses(none, "calibration: {tolerances: {2.dd: 1}}\n", "tolerances", &["did you mean `2.d`?"]);
    refuses(none, "calibration: {bounds: {2.d: [510, 490]}}\n", "bounds", &["write [490, 510]"]);
    let excluded = &["`2.d` is declared as 500, outside its bounds [510, 520]", "widen the bounds"];
    refuses(none, "calibration: {bounds: {2.d: [510, 520]}}\n", "bounds", excluded);
    let excluded = &["`tip.x` is declared as 10, outside its bounds [-inf, 9.9]"];
    refuses(none, "calibration: {bounds: {tip.x: [-.inf, 9.9]}}\n", "bounds", excluded);
    let turned = ("limits: [-90, 90]}\n  E", "theta: 30, limits: [-90, 90]}\n  E");
    refuses(
        turned,
        "calibration: {bounds: {2.theta: [31, 40]}}\n",
        "bounds",
        &["`2.theta` is declared as 30, outside"],
    );
    let sound =
        PLANAR.replacen(turned.0, turned.1, 1) + "calibration: {bounds: {2.theta: [30, 40], 2.d: [499, 500]}}\n";
    assert_eq!(check(&sound).status, 0, "{}", check(&sound).err);
    refuses(none, "calibration: {free: [2.d], fixed: [2.d]}\n", "fixed", &["both free and fixed"]);
}

#[test]
fn what_moves_joints() {
    let said = |replace: (&str, &str), at: &str, expected: &[&str]| {
        assert!(FOUR_BAR.contains(replace.0), "{replace:?}");
        let text = FOUR_BAR.replacen(replace.0, replace.1, 1);
        let ran = check(&text);
        assert_eq!(ran.status, 2, "{text}\n{}", ran.err);
        let line = 1 + text.lines().position(|line| line.contains(at)).expect("the line");
        assert!(ran.err.contains(&format!("arm.yaml:{line}:")), "line {line} is not named\n{text}\n{}", ran.err);
        for word in expected {
            assert!(ran.err.contains(word), "`{word}` is not said of\n{text}\n{}", ran.err);
        }
    };
    assert_eq!(check(FOUR_BAR).status, 0, "{}", check(FOUR_BAR).err);
    said(("d: 300", "d: 3000"), "bar:", &["loop `bar` cannot close"]);
    said(("variable: q1, ", ""), "  1:", &["nothing moves joint `1`"]);
    said(("d: 500", "alpha: 45, d: 500"), "bar:", &["loop"]);
    said(("frames: [3, 5]", "frames: [3, 5]\n    kind: planar\n    gap: .nan"), "gap", &["finite number"]);
    said(
        ("d: 500}", "alpha: 45, d: 500}\n  6: {antecedent: 0, joint: revolute, passive: true}"),
        "  6:",
        &["joint `6` is passive, but no loop holds it"],
    );
    said(
        ("    frames: [3, 5]", "    kind: planar\n    frames: [3, 5]\n    meet: origin\n    at: {q2: 0}"),
        "q2",
        &["did you mean `q1`?"],
    );
    let bent = FOUR_BAR.replace("passive: true, d: 500", "passive: true, alpha: 45, d: 500");
    let ran = check(&bent.replace("    branch", "    kind: planar\n    branch"));
    assert!(ran.status == 2 && ran.err.contains("is not planar"), "{}", ran.err);
    said(("tool:", "couplings: [\"1 = 1 * 1\"]\ntool:"), "couplings", &["follows itself"]);
    said(("tool:", "couplings: [\"2 = 1 * 1\", \"2 = 2 * 1\"]\ntool:"), "couplings", &["in two couplings"]);
    said(
        ("tool:", "  over: {frames: [3, 5], meet: origin}\ncouplings: [\"1 = 1 * 2\"]\ntool:"),
        "couplings",
        &["moved by two things"],
    );
    said(("variable: q1, ", ""), "  1:", &["nothing moves"]);
    let follows = FOUR_BAR.replace("variable: q1, ", "") + "couplings: [\"1 = 1 * 2\"]\n";
    let ran = check(&follows);
    assert!(ran.status == 2 && ran.err.contains("in a circle") && ran.err.contains("arm.yaml:"), "{}", ran.err);
    let loose = FOUR_BAR.replace("variable: q1, limits: [40, 100]", "passive: true");
    let ran = check(&loose);
    assert!(ran.status == 2 && ran.err.contains("can move by itself") && ran.err.contains("arm.yaml:9"), "{}", ran.err);
}

#[test]
fn elastic_keys() {
    let none = ("units", "units");
    let sound = "materials: {steel: {young: 2e11, poisson: 0.3}}\nsections: {rod: {shape: rod, diameter: 20}}\n";
    let beam = |text: &str| format!("{sound}beams:\n  b: {text}\n");
    refuses(none, &beam("{from: 1, to: 22, section: rod, material: steel}"), "22", &["unknown node `22`", "`2`"]);
    refuses(none, &beam("{from: 1, to: 2, section: rodd, material: steel}"), "rodd", &["did you mean `rod`?"]);
    refuses(none, "sections: {b: {shape: box, width: 2, wall: 0.1}}\n", "sections", &["lacks `height`"]);
    let joint = |text: &str| format!("joint_stiffness:\n  2: {{kar: {text}}}\n");
    refuses(none, &joint("{value: 1, compliance: 1}"), "kar", &["both `value` and `compliance`"]);
    refuses(none, &joint("{value: -1}"), "kar", &["`-1` must be 0 or more"]);
    refuses(none, &joint("{value: .nan}"), "kar", &["must be 0 or more"]);
    refuses(none, "joint_stiffness: {E: {kar: {value: 1}}}\n", "joint_stiffness", &["frame `E` is fixed"]);
    refuses(none, "springs: {s: {bodies: [0, 1], anchors: [[0, 0, 0], [1, 0, 0]]}}\n", "springs", &["lacks `rate`"]);
    refuses(none, "effects: [{effect: backlsh, site: \"joint:1\"}]\n", "effects", &["did you mean `backlash`?"]);
    refuses(none, "effects: [{effect: backlash, site: \"joint:9\"}]\n", "effects", &["unknown frame `9`"]);
    refuses(none, "effects: [{effect: backlash, site: tool}]\n", "effects", &["write `joint:<name>`"]);
}

#[test]
fn structures_that_cannot_be() {
    let none = ("units", "units");
    let held = &["nothing would hold it"];
    for key in ["ka", "kr", "kar", "krr"] {
        refuses(none, &format!("joint_stiffness:\n  1: {{{key}: {{value: 0}}}}\n"), key, held);
        refuses(none, &format!("joint_stiffness:\n  1: {{{key}: {{compliance: .inf}}}}\n"), key, held);
        refuses(none, &format!("joint_stiffness:\n  1: {{{key}: {{value: -2}}}}\n"), key, &["`-2` must be 0 or more"]);
    }
    refuses(none, "base_stiffness:\n  krx: {value: -4}\n", "krx", &["`-4` must be 0 or more"]);
    refuses(none, "base_stiffness:\n  krx: {value: 0}\n", "krx", held);
    let bounded = |text: &str| format!("joint_stiffness:\n  1: {{kar: {{{text}}}}}\n");
    refuses(none, &bounded("value: 5, bounds: [6, 7]"), "kar", &["5 lies outside its bounds [6, 7]"]);
    refuses(none, &bounded("compliance: 0.5, bounds: [3, 7]"), "kar", &["2 lies outside its bounds [3, 7]"]);
    refuses(none, &bounded("value: 5, bounds: [7, 3]"), "kar", &["write [3, 7]"]);
    refuses(none, &bounded("value: 5, bounds: [-7, 8]"), "kar", &["cannot be below 0"]);
    assert_eq!(check(&format!("{PLANAR}{}", bounded("compliance: 0.5, bounds: [2, 7]"))).status, 0);

    // The same in the block of calibration, in the file's units and as the spring is declared.
    let stated = |spring: &str, bounds: &str| {
        format!("joint_stiffness: {{1: {{kar: {{{spring}}}}}}}\ncalibration:\n  bounds: {{joint1.kar: {bounds}}}\n")
    };
    let units = ("units: {length: mm,", "units: {rotational_stiffness: N.mm/rad, length: mm,");
    let outside = &["`joint1.kar` is declared as 5, outside its bounds [6, 7]"];
    refuses(units, &stated("value: 5", "[6, 7]"), "  bounds", outside);
    refuses(units, &stated("compliance: 5", "[6, 7]"), "  bounds", outside);
    refuses(units, &stated("value: 5", "[-6, 7]"), "  bounds", &["`joint1.kar` cannot be below 0"]);
    refuses(units, &stated("value: .inf", "[6, 7]"), "  bounds", &["`joint1.kar` is declared as inf"]);
    refuses(units, &stated("value: 5", "[7, 6]"), "  bounds", &["write [6, 7]"]);
    for spring in ["value: 6", "compliance: 6"] {
        let text = PLANAR.replacen(units.0, units.1, 1) + &stated(spring, "[6, 7]");
        assert_eq!(check(&text).status, 0, "{}", check(&text).err);
    }
    let base =
        |bounds: &str| format!("base_stiffness: {{kz: {{value: 8}}}}\ncalibration:\n  bounds: {{base.kz: {bounds}}}\n");
    refuses(none, &base("[9, 10]"), "  bounds", &["`base.kz` is declared as 8, outside its bounds [9, 10]"]);
    refuses(
        none,
        "materials: {steel: {young: 2e11, poisson: 0.3}}\ncalibration:\n  bounds: {steel.young: [1, 2]}\n",
        "  bounds",
        &["`steel.young` is declared as 200000000000"],
    );

    let sound = "materials: {steel: {young: 2e11, poisson: 0.3}}\nsections: {rod: {shape: rod, diameter: 20}}\n";
    let beams = |nodes: &str, ends: &str| {
        format!("{sound}nodes:\n{nodes}beams:\n  b: {{{ends}, section: rod, material: steel}}\n")
    };
    let same = beams("  a: {body: 1}\n  b: {body: 1}\n", "from: a, to: b");
    refuses(none, &same, "  b: {from", &["beam `b` has no length"]);
    let across = beams("  a: {body: 1}\n  b: {body: 2, at: E}\n", "from: a, to: b");
    refuses(none, &across, "  b: {from", &["joins nodes of two bodies, `1` and `2`"]);
    refuses(none, &beams("  a: {body: 1}\n", "from: a, to: a"), "  b: {from", &["ends where it begins"]);
    let loose = beams("  a: {body: 1}\n  c: {body: 2}\n  d: {body: 2, at: E}\n", "from: c, to: d")
        + "  e: {from: a, to: 2, section: rod, material: steel}\n";
    assert_eq!(check(&format!("{PLANAR}{}", loose.replace("  e: {from: a, to: 2", "  e: {from: 1, to: 2"))).status, 0);
    let hangs = beams(
        "  a: {body: 1}\n  b: {body: 1, at: 2}\n  c: {body: 1, point: [1, 2, 3]}\n  d: {body: 1, point: [1, 2, 9]}\n",
        "from: a, to: b",
    ) + "  e: {from: c, to: d, section: rod, material: steel}\n";
    let ran = check(&format!("{PLANAR}{hangs}"));
    assert_eq!(ran.status, 2);
    assert!(ran.err.contains("node `c` hangs on nothing") && ran.err.contains("arm.yaml:15:"), "{}", ran.err);

    let spring =
        |rate: &str| format!("springs:\n  s: {{bodies: [0, 1], anchors: [[0, 0, 0], [1, 0, 0]], rate: {rate}}}\n");
    for rate in ["{value: .inf}", "{compliance: 0}"] {
        refuses(none, &spring(rate), "  s:", &["a spring must give"]);
    }
    refuses(none, &spring("{value: 0}"), "  s:", held);
    refuses(none, &spring("{value: -1}"), "  s:", &["`-1` must be 0 or more"]);
}

#[test]
fn structures_that_can_move_by_themselves() {
    let pinned = "materials: {steel: {young: 2e11, poisson: 0.3}}
sections: {rod: {shape: rod, diameter: 20}}
nodes: {a: {body: 0, support: pinned}, b: {body: 0, point: [1000, 0, 0]}}
beams: {b: {from: a, to: b, section: rod, material: steel}}
joint_stiffness: {1: {kar: {value: 1000}}}
";
    let arm = format!("{PLANAR}{pinned}");
    let deflection = CAMPAIGN.replace("position", "deflection");
    let rows = "q1,q2,x,y,z,fz\n0,0,0.1,0,0,10\n10,10,0.1,0,0,10\n";
    let files: [(&str, &[u8]); 3] =
        [("arm.yaml", arm.as_bytes()), ("c.yaml", deflection.as_bytes()), ("m.csv", rows.as_bytes())];
    let folder = folder_with(&files);
    for (arguments, more) in [
        (&["stiffness", "arm.yaml", "--joints", "q1=0"][..], ""),
        (&["residuals", "arm.yaml", "c.yaml"], "m.csv:2 (configuration"),
    ] {
        let ran = run(folder.path(), arguments);
        assert!(ran.status == 1 && ran.out.is_empty(), "{arguments:?} {} {}", ran.status, ran.err);
        for word in [more, "node `a` can", "support a is passive", "nothing closes it"] {
            assert!(ran.err.contains(word), "{word}: {}", ran.err);
        }
    }
    let both = arm.replace("point: [1000, 0, 0]", "point: [1000, 0, 0], support: fixed");
    std::fs::write(folder.path().join("arm.yaml"), both).expect("written");
    let ran = run(folder.path(), &["stiffness", "arm.yaml", "--joints", "q1=0"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
}

#[test]
fn loads_beyond_reason() {
    let arm = format!("{PLANAR}joint_stiffness: {{2: {{kar: {{value: 1000, identifiable: true}}}}}}\n");
    let deflection = CAMPAIGN.replace("position", "deflection");
    let rows = "q1,q2,x,y,z,fz\n0,0,0.1,0,0,1e300\n10,10,0.1,0,0,10\n";
    let files: [(&str, &[u8]); 3] =
        [("arm.yaml", arm.as_bytes()), ("c.yaml", deflection.as_bytes()), ("m.csv", rows.as_bytes())];
    let folder = folder_with(&files);
    for command in [&["identify", "c.yaml"][..], &["residuals", "arm.yaml", "c.yaml"]] {
        let ran = run(folder.path(), command);
        assert!(ran.status == 2 && ran.err.contains("m.csv:2:") && ran.err.contains("`fz`"), "{}", ran.err);
        assert!(ran.err.contains("1 error, "), "{}", ran.err);
    }
    for wrench in ["1e300,0,0", "nan,0,0", "1,2", "inf,0,0"] {
        for command in ["stiffness", "pose"] {
            let ran = run(folder.path(), &[command, "arm.yaml", "--joints", "q1=0", "--wrench", wrench]);
            assert!(ran.status == 2 && ran.err.contains("--wrench"), "{command} {wrench}: {}", ran.err);
        }
    }
}

#[test]
fn the_compensator_can_be_left_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let simulated = ["simulate", "kuka-kr270", "--poses", "20", "--observes", "deflection", "--wrench", "0,0,-2500"];
    let ran = run(
        folder.path(),
        &[&simulated[..], &["--noise", "0.0001", "--errors", "0", "--seed", "4", "--into", "c"]].concat(),
    );
    assert_eq!(ran.status, 0, "{}", ran.err);
    let fitted = |campaign: &str| {
        let ran = run(folder.path(), &["identify", campaign, "--format", "json"]);
        assert_eq!(ran.status, 0, "{}", ran.err);
        ran.out
    };
    let with = fitted("c");
    assert!(with.contains("compensator.stiffness"));
    let file = folder.path().join("c/campaign.yaml");
    let text = std::fs::read_to_string(&file).expect("read");
    std::fs::write(&file, format!("{text}without: [compensator]\n")).expect("written");
    let without = fitted("c");
    assert!(!without.contains("compensator.stiffness"));
    let ratio = |out: &str| {
        let json: serde_json::Value = serde_json::from_str(out).expect("JSON");
        json["noise_ratio"].as_f64().unwrap_or_else(|| panic!("{json:#}"))
    };
    // The joints cannot stand in for a spring whose stiffness changes with the pose.
    assert!(ratio(&with) < 2.0 && ratio(&without) > 50.0, "{} {}", ratio(&with), ratio(&without));
}

#[test]
fn a_faulty_value_is_reported_once() {
    for replace in [
        ("variable: q2", "varable: q2"),
        ("variable: q2", "variable: [q2]"),
        ("antecedent: 1", "antecedent: [1]"),
        ("antecedent: 1", "antecedant: 1"),
        ("joint: revolute, variable: q2", "joint: revolut, variable: q2"),
        ("d: 500", "d: five"),
        ("tool: {frame: E}", "tool: {frme: E}"),
        ("frame: E, at", "frme: E, at"),
    ] {
        let text = PLANAR.replacen(replace.0, replace.1, 1);
        let ran = check(&text);
        assert!(ran.status == 2 && ran.err.contains("1 error, "), "{text}\n{}", ran.err);
    }
}

#[test]
fn several_faults_are_all_reported() {
    let text = PLANAR.replacen("antecedent: 1", "antecedent: 11", 1).replacen("d: 400", "d: four hundred", 1).replacen(
        "limits: [-90, 90]",
        "limits: [90, -90]",
        1,
    ) + "joint_stiffness: {2: {kar: {value: -3}}}\ncalibration: {free: [1.rr], freee: [1.r]}\n";
    let ran = check(&text);
    assert_eq!(ran.status, 2);
    insta::assert_snapshot!(ran.err);
}

#[test]
fn files_that_are_no_descriptions() {
    let bomb = std::iter::once("a: &a0 [x, x, x, x, x, x, x, x, x, x]\n".to_owned())
        .chain((1..9).map(|k| format!("b{k}: &a{k} [{}]\n", vec![format!("*a{}", k - 1); 10].join(", "))))
        .collect::<String>();
    let wide: Vec<u8> = [0xff, 0xfe].into_iter().chain(PLANAR.bytes().flat_map(|b| [b, 0])).collect();
    let cases: &[(&[u8], &str)] = &[
        (bomb.as_bytes(), "aliases"),
        (&[b"frames: ".to_vec(), vec![b'['; 10_000]].concat(), "nest"),
        (b"", "the file is empty"),
        (b"", "`elastogeo schema robot` prints"),
        (b"frames:\n", "declares no frame"),
        (&[0x7f, b'E', b'L', b'F', 2, 1, 1, 0, 0, 0xff, 0xfe], "UTF-8"),
        (&wide, "UTF-16"),
    ];
    for (bytes, expected) in cases {
        let ran = run(folder_with(&[("arm.yaml", bytes)]).path(), &["check", "arm.yaml"]);
        assert_eq!((ran.status, ran.out.as_str()), (2, ""), "{}", ran.err);
        assert!(ran.err.contains(expected) && ran.err.contains("arm.yaml:"), "{expected}: {}", ran.err);
    }
}

#[test]
fn urdf_faults_are_located() {
    let ran = check("units: {length: mm}\nurdf: gone.urdf\n");
    assert!(ran.status == 2 && ran.err.contains("arm.yaml:2:7"), "{}", ran.err);
    let robot = "<robot name=\"r\">\n<link name=\"a\"/>\n<joint name=\"j\" type=\"revolute\"><parent link=\"a\"/><child link=\"b\"/></joint>\n</robot>\n";
    for text in [robot, "<robot", "", "not XML"] {
        let ran = run(folder_with(&[("x.urdf", text.as_bytes())]).path(), &["check", "x.urdf"]);
        assert!(ran.status == 2 && ran.err.contains("x.urdf"), "{text}: {}", ran.err);
    }
}

const CAMPAIGN: &str = "robot: arm.yaml
units: {length: mm, angle: deg}
observes: position
instrument: {sigma: 0.05}
measurements: m.csv
";
const ROWS: &str = "pose,q1,q2,x,y,z,marker,set\n\
    a,0,0,900,0,0,TCP,fit\na,0,0,910,0,0,tip,fit\nb,10,20,800,200,0,TCP,check\nc,-30,40,800,-100,0,TCP,fit\n";

fn residuals(campaign: &str, rows: &[u8]) -> Ran {
    let folder = folder_with(&[("arm.yaml", PLANAR.as_bytes()), ("c.yaml", campaign.as_bytes()), ("m.csv", rows)]);
    run(folder.path(), &["residuals", "arm.yaml", "c.yaml"])
}

#[test]
fn tables() {
    assert_eq!(residuals(CAMPAIGN, ROWS.as_bytes()).status, 0);
    let marked = format!("\u{feff}{}", ROWS.replace('\n', "\r\n"));
    assert_eq!(residuals(CAMPAIGN, marked.as_bytes()).status, 0);
    let semicolons = ROWS.replace(',', ";");
    assert_eq!(residuals(CAMPAIGN, semicolons.as_bytes()).status, 0);
    let commas = semicolons.replace(";900;", ";900,25;");
    let ran = residuals(CAMPAIGN, commas.as_bytes());
    assert_eq!(ran.status, 0, "between semicolons a decimal comma needs no word: {}", ran.err);
    assert_eq!(residuals(&format!("{CAMPAIGN}csv: {{decimal: \",\"}}\n"), commas.as_bytes()).out, ran.out);
    let ran = residuals(&format!("{CAMPAIGN}csv: {{decimal: .}}\n"), commas.as_bytes());
    assert!(ran.status == 2 && ran.err.contains("declare it: `csv: {decimal"), "{}", ran.err);
    let both = commas.replace(";910;", ";910.5;");
    let ran = residuals(CAMPAIGN, both.as_bytes());
    assert!(ran.status == 2 && ran.err.contains("one decimal sign throughout"), "{}", ran.err);
    for (replace, place, expected) in [
        ((",q2,", ",p2,"), "m.csv:1:", "q2"),
        (("marker,set", "markr,set"), "m.csv:1:", "markr"),
        (("b,10,20", "b,ten,20"), "m.csv:4:3", "found `ten`"),
        (("b,10,20", "b,20"), "m.csv:4:", "expected 8 as in the header"),
        ((",tip,", ",tp,"), "m.csv:3:", "did you mean `tip`?"),
        (("tip,fit", "tip,check"), "m.csv:3:", "partly to fit and partly to check"),
        (("TCP,check", "TCP,chek"), "m.csv:4:", "did you mean `check`?"),
        (("b,10,20", "b,1e300,20"), "m.csv:4:3", "no robot"),
        (("800,200", "800,nan"), "m.csv:4:", "finite"),
    ] {
        let text = ROWS.replacen(replace.0, replace.1, 1);
        let ran = residuals(CAMPAIGN, text.as_bytes());
        assert!(ran.status == 2 && ran.err.contains(place) && ran.err.contains(expected), "{text}\n{}", ran.err);
    }
    for (text, expected) in [("", "empty"), ("pose,q1,q2,x,y,z\n", "no rows")] {
        let ran = residuals(CAMPAIGN, text.as_bytes());
        assert!(ran.status == 2 && ran.err.contains(expected) && ran.err.contains("m.csv:1:"), "{}", ran.err);
    }
}

#[test]
fn ignored_columns_are_left_out() {
    let loaded =
        ROWS.replace(",set\n", ",set,fz,note\n").replace("fit\n", "fit,-10,a\n").replace("check\n", "check,-10,b\n");
    let files = |ignore: &str| {
        let campaign = format!("{CAMPAIGN}ignore: {ignore}\n");
        folder_with(&[("arm.yaml", PLANAR.as_bytes()), ("c.yaml", campaign.as_bytes()), ("m.csv", loaded.as_bytes())])
    };
    let read = |ignore: &str| {
        let folder = files(ignore);
        let path = folder.path().join("c.yaml");
        elastogeo::files::load_campaign(path.to_str().expect("a name"), None).map(|loaded| loaded.campaign)
    };
    assert_eq!(read("[note]").expect("sound").readings[0].wrench[2], -10.0);
    let without = read("[note, fz, set, marker]").expect("sound");
    let first = without.readings[0];
    assert_eq!((first.wrench, first.check, without.readings[1].marker), ([0.0; 6], None, None));
    for needed in ["q1", "z"] {
        let said = read(&format!("[note, {needed}]")).expect_err("needed");
        let message = format!("`ignore:` leaves out the column `{needed}`, which is needed");
        assert!(said.len() == 1 && said[0].message == message, "{said:#?}");
    }
}

#[test]
fn campaigns() {
    for (replace, line, expected) in [
        (("arm.yaml", "universal-ur55"), 1, "did you mean `universal-ur5`?"),
        (("arm.yaml", "arn.yaml"), 1, "did you mean `arm.yaml`?"),
        (("position", "positon"), 3, "position"),
        (("0.05", "0"), 4, "must be a finite number above 0"),
        (("0.05", "-1"), 4, "must be a finite number above 0"),
        (("0.05", ".nan"), 4, "must be a finite number above 0"),
        (("0.05", "{x: 1, y: 0, z: 1}"), 4, "must be a finite number above 0"),
        (("m.csv", "[m.csv, n.csv]"), 5, "there is no file `n.csv`"),
        (("observes: position", "observes: distance"), 3, "none is declared"),
        (("measurements: m.csv", "calibrate: [geometri]"), 5, "did you mean `geometry`?"),
    ] {
        let text = CAMPAIGN.replacen(replace.0, replace.1, 1);
        let folder =
            folder_with(&[("arm.yaml", PLANAR.as_bytes()), ("c.yaml", text.as_bytes()), ("m.csv", ROWS.as_bytes())]);
        let ran = run(folder.path(), &["identify", "c.yaml"]);
        assert!(ran.status == 2 && ran.out.is_empty(), "{text}\n{}", ran.err);
        assert!(ran.err.contains(&format!("c.yaml:{line}:")) && ran.err.contains(expected), "{text}\n{}", ran.err);
    }
    let all = "robot: universal-ur55\nobserves: position\ninstrument: {sigma: -1}\nmeasurements: [m.csv, gone.csv]\n";
    let ran = run(folder_with(&[("c.yaml", all.as_bytes()), ("m.csv", b"")]).path(), &["identify", "c.yaml"]);
    assert_eq!(ran.status, 2);
    insta::assert_snapshot!(ran.err);
}

#[test]
fn campaigns_that_cannot_be_computed() {
    let files = |campaign: &str, rows: &str| {
        folder_with(&[
            ("arm.yaml", PLANAR.as_bytes()),
            ("c.yaml", campaign.as_bytes()),
            ("m.csv", rows.as_bytes()),
            ("bar.yaml", FOUR_BAR.replace("d: 450", "d: 700").as_bytes()),
        ])
    };
    let says = |folder: &Path, expected: &str| {
        let ran = run(folder, &["identify", "c.yaml"]);
        assert!(ran.status == 1 && ran.err.contains(expected) && ran.out.is_empty(), "{} {}", ran.status, ran.err);
    };
    let deflection = CAMPAIGN.replace("position", "deflection");
    let under_load =
        ROWS.replace(",set\n", ",set,fz\n").replace(",fit\n", ",fit,-10\n").replace(",check\n", ",check,-10\n");
    says(files(&deflection, &under_load).path(), "nothing elastic is identifiable");
    for command in ["identify", "diagnose"] {
        let ran = run(files(&deflection, ROWS).path(), &[command, "c.yaml"]);
        assert!(ran.status == 2 && ran.out.is_empty() && ran.err.contains("c.yaml:3:"), "{}", ran.err);
        assert!(ran.err.contains("no reading is loaded") && ran.err.contains("fx, fy, fz"), "{}", ran.err);
        let all = ROWS.replace(",fit", ",check");
        let ran = run(files(CAMPAIGN, &all).path(), &[command, "c.yaml"]);
        assert!(ran.status == 2 && ran.err.contains("no reading is left to fit"), "{}", ran.err);
        let loaded_aside = under_load.replace("fit,-10", "fit,0");
        let ran = run(files(&deflection, &loaded_aside).path(), &[command, "c.yaml"]);
        assert!(ran.status == 2 && ran.err.contains("no reading to fit is loaded"), "{}", ran.err);
    }
    let bar = CAMPAIGN.replace("arm.yaml", "bar.yaml");
    says(files(&bar, "q1,x,y,z\n60,1,2,3\n180,1,2,3\n").path(), "row 2");
}

#[test]
fn what_cannot_be_left_out_is_a_warning() {
    let arm = format!(
        "{PLANAR}joint_stiffness: {{2: {{kar: {{value: 10}}}}}}\ncalibration: {{tolerances: {{joint2.kar: 1}}}}\n"
    );
    let campaign = format!("{CAMPAIGN}without: [\"joint:2\", \"joint:3\"]\n");
    let folder =
        folder_with(&[("arm.yaml", arm.as_bytes()), ("c.yaml", campaign.as_bytes()), ("m.csv", ROWS.as_bytes())]);
    let ran = run(folder.path(), &["residuals", "arm.yaml", "c.yaml"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    assert!(ran.err.contains("c.yaml:6:") && ran.err.contains("did you mean `joint:2`?"), "{}", ran.err);
    assert!(ran.err.contains("0 errors, 1 warning"), "{}", ran.err);
}

/// A generator of its own: the cases are the same everywhere.
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(self.0 >> 33).unwrap_or(0) % n.max(1)
    }

    fn pick<'a>(&mut self, from: &[&'a str]) -> &'a str {
        from[self.below(from.len())]
    }
}

/// The text with a few words swapped for others, or lines dropped, doubled or moved.
fn mutated(text: &str, dice: &mut Dice) -> String {
    let evil = [
        "1e300",
        "-1e300",
        "1e-300",
        ".inf",
        ".nan",
        "0",
        "-1",
        "''",
        "[]",
        "{}",
        "E",
        "1",
        "3",
        "999999999999",
        "*a",
        "&a",
        "\u{e9}",
        "true",
        "q1",
    ];
    let mut text = text.to_owned();
    for _ in 0..1 + dice.below(3) {
        let words: Vec<std::ops::Range<usize>> = text
            .split(|c: char| !(c.is_alphanumeric() || c == '.' || c == '-'))
            .filter(|word| !word.is_empty())
            .map(|word| {
                let at = word.as_ptr() as usize - text.as_ptr() as usize;
                at..at + word.len()
            })
            .collect();
        if dice.below(5) > 0 && !words.is_empty() {
            let word = words[dice.below(words.len())].clone();
            text.replace_range(word, dice.pick(&evil));
        } else {
            let mut lines: Vec<&str> = text.lines().collect();
            if lines.is_empty() {
                continue;
            }
            let (from, to) = (dice.below(lines.len()), dice.below(lines.len()));
            let line = lines[from];
            match dice.below(3) {
                0 => drop(lines.remove(from)),
                1 => lines.insert(to, line),
                _ => lines.swap(from, to),
            }
            text = lines.join("\n") + "\n";
        }
    }
    text
}

#[test]
fn no_description_and_no_table_makes_the_library_panic() {
    let mut dice = Dice(7);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("robot.yaml");
    let shown = path.to_str().expect("a name");
    for name in ["kuka-ir663", "kuka-kr270", "universal-ur5", "barrett-wam"] {
        let text = std::fs::read_to_string(format!("{}/robots/{name}.yaml", env!("CARGO_MANIFEST_DIR"))).expect("read");
        for _ in 0..100 {
            let text = mutated(&text, &mut dice);
            std::fs::write(&path, &text).expect("written");
            let started = std::time::Instant::now();
            if let Err(said) = elastogeo::files::load_robot(shown) {
                assert!(said.iter().any(elastogeo::diagnostic::Diagnostic::is_error), "{text}");
                elastogeo::render::diagnostics::render(&said, false);
            }
            assert!(started.elapsed().as_secs() < 20, "too slow:\n{text}");
        }
    }
    std::fs::write(folder.path().join("arm.yaml"), PLANAR).expect("written");
    let campaign = folder.path().join("c.yaml");
    for _ in 0..300 {
        let (header, rows) = if dice.below(2) > 0 {
            (CAMPAIGN.into(), mutated(ROWS, &mut dice))
        } else {
            (mutated(CAMPAIGN, &mut dice), ROWS.into())
        };
        std::fs::write(&campaign, header).expect("written");
        std::fs::write(folder.path().join("m.csv"), rows).expect("written");
        if let Err(said) = elastogeo::files::load_campaign(campaign.to_str().expect("a name"), None) {
            elastogeo::render::diagnostics::render(&said, false);
        }
    }
}
