//! What the terminal shows: each command at 80 and at 140 columns, quiet, without colour; help and manual pages.

use std::path::Path;
use std::process::Command;

use crate::cli::{PLANAR, run};

/// Output on a screen of so many columns.
fn at(folder: &Path, columns: usize, arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_elastogeo"))
        .args(arguments)
        .current_dir(folder)
        .env("COLUMNS", columns.to_string())
        .output()
        .expect("the command starts");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// Numbers that are nothing but rounding (below 1e-9), and with them the spaces before them, differ between processors.
fn without_rounding(text: &str) -> String {
    let rounding = |word: &str| word.contains('e') && word.parse::<f64>().is_ok_and(|value| value.abs() < 1e-9);
    let line = |line: &str| match line.split_whitespace().any(rounding) {
        true => {
            line.split_whitespace().map(|word| if rounding(word) { "~0" } else { word }).collect::<Vec<_>>().join(" ")
        }
        false => line.to_string(),
    };
    text.lines().map(line).collect::<Vec<_>>().join("\n")
}

#[test]
fn every_command_fits_a_screen() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: String| std::fs::write(folder.path().join(name), text).expect("written");
    write("arm.yaml", PLANAR.into());
    let grid = (0..49).map(|n| format!("0,{},{},0,90,0\n", 620 + 50 * (n / 7), 610 + 45 * (n % 7)));
    write("grid.csv", format!("q1,stroke2,stroke8,q4,q5,q7\n{}", grid.collect::<String>()));
    // About joint 2 at the origin the spring's point turns on 184.7 mm; about its anchor, three points on 30, 45 and 60 mm.
    let about = |[x, y]: [f64; 2], radius: f64, angle: f64| [x + radius * angle.cos(), y + radius * angle.sin()];
    let point = |k: i32| {
        let [x, z] = about([0.0, 0.0], 184.7, -f64::from(10 * k).to_radians());
        format!("{},{x:.3},{},{z:.3}\n", f64::from(10 * k) - 120.0, 0.02 * f64::from(k % 3))
    };
    write("circle.csv", format!("q,x,y,z\n{}", (0..9).map(point).collect::<String>()));
    let turned = |k: i32| {
        let [x, z] = about([-680.0, -100.0], 30.0 + 15.0 * f64::from(k % 3), 0.08 * f64::from(k));
        format!("p{},{x:.3},0,{z:.3}\n", k % 3)
    };
    write("anchor.csv", format!("point,x,y,z\n{}", (0..18).map(turned).collect::<String>()));
    let cases: &[(&str, &[&str])] = &[
        ("init", &["init", "my-robot"]),
        ("explain", &["explain", "gear-ratio"]),
        ("explain-list", &["explain"]),
        ("check", &["check", "kuka-ir663"]),
        ("convert", &["convert", "arm.yaml", "other.yaml"]),
        ("pose", &["pose", "universal-ur5", "--joints", "q1=30,q2=-60,q3=90"]),
        ("solve", &["solve", "arm.yaml", "--target", "600,400,0"]),
        ("stiffness", &["stiffness", "kuka-kr270", "--joints", "q2=-60,q3=90", "--wrench", "0,0,-2500,0,0,0"]),
        ("simulate", &["simulate", "arm.yaml", "--poses", "30", "--into", "c"]),
        ("sensitivity", &["sensitivity", "arm.yaml", "c"]),
        ("identifiability", &["identifiability", "my-robot/robot.yaml", "my-robot"]),
        ("identify", &["identify", "my-robot", "--save", "calibrated.yaml"]),
        ("identify-compare", &["identify", "c", "--compare"]),
        ("identify-elastic", &["identify", "kr270-no-compensator"]),
        ("diagnose", &["diagnose", "kr270-no-compensator"]),
        ("residuals", &["residuals", "my-robot/robot.yaml", "my-robot"]),
        ("report", &["report", "c"]),
        ("view", &["view", "arm.yaml"]),
        ("compensate", &["compensate", "kuka-ir663", "ir663-strip", "--process", "ir663-strip"]),
        ("plan", &["plan", "arm.yaml", "--poses", "8", "--table", "poses.csv"]),
        (
            "simulate-deflections",
            &[
                "simulate",
                "kuka-ir663",
                "--into",
                "d",
                "--poses",
                "grid.csv",
                "--observes",
                "deflection",
                "--errors",
                "0",
                "--markers",
                "wrist",
                "--wrench=1000,0,0",
                "--wrench=0,0,-1000",
            ],
        ),
        ("identify-fuzzy", &["identify", "d", "--what", "fuzzy"]),
        ("identify-grey", &["identify", "d", "--what", "grey"]),
        ("identify-fuzzy-compare", &["identify", "d", "--what", "fuzzy", "--compare"]),
        ("compensator", &["compensator", "--circle", "circle.csv", "--anchor", "anchor.csv"]),
        (
            "blind-make",
            &["blind", "make", "--count", "2", "--seed", "7", "--plan", "kuka-kr270:deflection:20", "--into", "sealed"],
        ),
        ("blind-score", &["blind", "score", "sealed"]),
        ("man", &["man", "man1"]),
        ("help", &["identify", "--help"]),
    ];
    for (name, arguments) in cases {
        for columns in [80, 140] {
            // What a command wrote at the first width is in its way at the second.
            let into = [("init", "my-robot"), ("blind-make", "sealed")].into_iter().find(|(of, _)| of == name);
            if let Some((_, into)) = into.filter(|_| columns == 140) {
                std::fs::remove_dir_all(folder.path().join(into)).expect("removed");
            }
            let text = at(folder.path(), columns, arguments);
            let widest = text.lines().map(|line| line.chars().count()).max().unwrap_or(0);
            assert!(widest <= columns, "{name}: {widest} of {columns} columns\n{text}");
            insta::with_settings!({prepend_module_to_snapshot => true, omit_expression => true}, {
                insta::assert_snapshot!(format!("{name}-{columns}"), without_rounding(&text));
            });
        }
    }
}

#[test]
fn a_pipe_gets_whole_lines_and_quiet_prints_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let piped = run(folder.path(), &["check", "kuka-ir663"]);
    assert!(piped.out.lines().any(|line| line.chars().count() > 140), "{}", piped.out);
    let quiet = run(folder.path(), &["convert", "universal-ur5", "r.yaml", "--quiet"]);
    assert_eq!((quiet.status, quiet.out.as_str(), quiet.err.as_str()), (0, "", ""));
    assert!(folder.path().join("r.yaml").is_file(), "files are written all the same");
    let wrong = run(folder.path(), &["check", "universal-ur55", "-q"]);
    assert!(wrong.status == 2 && wrong.err.contains("did you mean"), "{}", wrong.err);
    // A schema is a file's text: no screen breaks its lines.
    let whole = at(folder.path(), 60, &["schema", "robot"]);
    assert_eq!(whole, run(folder.path(), &["schema", "robot"]).out);
}

/// Names of all commands that the help lists.
fn commands(folder: &Path) -> Vec<String> {
    let help = run(folder, &["--help"]).out;
    let list = help.split("Commands:").nth(1).and_then(|rest| rest.split("Options:").next()).expect("commands");
    let names = list.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    names.filter_map(|line| Some(line.split_whitespace().next()?.to_string())).filter(|name| name != "help").collect()
}

#[test]
fn every_command_has_examples_that_parse_and_a_manual_page() {
    let folder = tempfile::tempdir().expect("a folder");
    let names = commands(folder.path());
    assert!(names.len() > 18, "{names:?}");
    assert_eq!(run(folder.path(), &["man", "man1"]).status, 0);
    for name in &names {
        let arguments: Vec<Vec<&str>> = match name.as_str() {
            "blind" => vec![vec!["blind", "make"], vec!["blind", "score"]],
            name => vec![vec![name]],
        };
        for mut words in arguments {
            let page = folder.path().join(format!("man1/elastogeo-{}.1", words.join("-")));
            let page = std::fs::read_to_string(&page).unwrap_or_else(|error| panic!("{}: {error}", page.display()));
            assert!(page.contains(".SH") && page.contains("Examples"), "{words:?}");
            words.push("--help");
            let help = run(folder.path(), &words).out;
            let examples: Vec<&str> = help.lines().filter_map(|line| line.strip_prefix("  elastogeo ")).collect();
            assert!(!examples.is_empty(), "{words:?} has no example");
            for example in examples {
                // Flags that no command knows are refused before the help is printed.
                let mut words: Vec<&str> = example.split_whitespace().collect();
                words.push("--help");
                let ran = run(folder.path(), &words);
                assert_eq!(ran.status, 0, "{example}: {}", ran.err);
            }
        }
    }
}
