//! Certificates: figures are those of `identify`, the verdict follows its rule, accuracy and repeatability are those of ISO 9283 by
//! hand, and the files hold the same.

use std::path::Path;

use serde_json::Value;

use crate::cli::run;

/// The starter campaign, with more lines in its campaign file.
fn folder(more: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    assert_eq!(run(folder.path(), &["init", "c"]).status, 0);
    let file = folder.path().join("c/campaign.yaml");
    let text = std::fs::read_to_string(&file).expect("text");
    std::fs::write(file, format!("{text}{more}")).expect("written");
    folder
}

fn certificate(at: &Path, arguments: &[&str]) -> Value {
    let ran = run(at, &[&["report", "c", "--certificate", "--format", "json"], arguments].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    serde_json::from_str(&ran.out).expect("JSON")
}

#[test]
fn a_certificate_states_what_identify_finds() {
    let folder = folder("certificate: {operator: A. Meyer, robot_serial: \"4711\", tolerance: 0.3}\n");
    let at = folder.path();
    let found = certificate(at, &[]);
    let ran = run(at, &["identify", "c", "--format", "json"]);
    let identified: Value = serde_json::from_str(&ran.out).expect("JSON");
    for (own, key) in [("before", "check_registration"), ("after", "check_after")] {
        for figure in ["mean", "rms", "max"] {
            let [a, b] =
                [&found[own][figure], &identified["residuals"][key][figure]].map(|v| v.as_f64().expect("a number"));
            assert!((a - b).abs() < 1e-9, "{own} {figure}: {a} {b}");
        }
    }
    assert_eq!(found["verdict"], "pass");
    // k = 2 of the stated 0.03 mm.
    assert!((found["instrument"]["expanded"].as_f64().expect("a number") - 0.06).abs() < 1e-12);
    let after = found["readings"].as_array().expect("readings").iter().filter(|r| r["set"] == "check");
    let errors: Vec<f64> = after.map(|r| r["after"].as_f64().expect("a number")).collect();
    let n = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / n;
    let deviation = (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    assert!((found["after"]["mean_3s"].as_f64().expect("a number") - mean - 3.0 * deviation).abs() < 1e-12);

    let max = found["after"]["max"].as_f64().expect("a number");
    for (tolerance, verdict) in
        [(max + 0.07, "pass"), (max + 0.05, "undecided"), (max - 0.05, "undecided"), (max - 0.07, "fail")]
    {
        assert_eq!(certificate(at, &["--tolerance", &tolerance.to_string()])["verdict"], verdict, "{tolerance}");
    }
    for bad in ["0", "-1", "nan", "inf"] {
        let ran = run(at, &["report", "c", "--certificate", "--tolerance", bad]);
        assert!(ran.status == 2 && ran.err.contains("tolerance"), "{bad}: {}", ran.err);
        assert!(!at.join("certificate.html").exists());
    }

    let ran = run(at, &["report", "c", "--certificate", "--json", "c.json", "--xml", "c.xml"]);
    assert!(ran.status == 0 && ran.out.contains("PASS"), "{} {}", ran.out, ran.err);
    let page = std::fs::read_to_string(at.join("certificate.html")).expect("a page");
    assert!(!page.contains("class=\"fault\"") && page.contains("A. Meyer") && page.contains("4711"));
    assert!(page.contains("Not stated in the campaign") && page.contains("traceability"));
    let xml = std::fs::read_to_string(at.join("c.xml")).expect("XML");
    let document = roxmltree::Document::parse(&xml).expect("well-formed");
    let stated = |name: &str| document.descendants().find(|node| node.has_tag_name(name)).and_then(|node| node.text());
    assert_eq!((stated("verdict"), stated("operator")), (Some("pass"), Some("A. Meyer")));
    let json: Value = serde_json::from_str(&std::fs::read_to_string(at.join("c.json")).expect("text")).expect("JSON");
    assert_eq!(json["after"], found["after"]);
    let ran = run(at, &["report", "c", "--certificate", "--json", "x", "--xml", "x"]);
    assert!(ran.status == 2 && ran.err.contains("two results"), "{}", ran.err);
}

/// Without the instrument's noise nothing is decided; a campaign that is misread has no certificate.
#[test]
fn no_verdict_without_grounds() {
    let folder = folder("");
    let at = folder.path();
    let file = at.join("c/campaign.yaml");
    let text = std::fs::read_to_string(&file).expect("text");
    let without: Vec<&str> = text.lines().filter(|line| !line.starts_with("instrument:")).collect();
    assert_ne!(without.len(), text.lines().count());
    std::fs::write(&file, without.join("\n") + "\n").expect("written");
    let found = certificate(at, &["--tolerance", "5"]);
    assert_eq!(found["verdict"], "undecided");
    assert!(found["reason"].as_str().is_some_and(|why| why.contains("not stated")));
    std::fs::write(&file, text.replace("length: mm", "length: m")).expect("written");
    let ran = run(at, &["report", "c", "--certificate"]);
    assert!(ran.status == 2 && !at.join("certificate.html").exists(), "{}", ran.out);
    let ran = run(at, &["report", "kr270-simulated", "--certificate", "--robot", "nothing"]);
    assert_eq!(ran.status, 2);
}

/// Four readings of one configuration, two from either side, by hand.
#[test]
fn accuracy_and_repeatability_of_poses() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let arguments =
        ["simulate", "universal-ur5", "--poses", "25", "--repeats", "4", "--noise", "0.05", "--unknown-base"];
    assert_eq!(run(at, &[&arguments[..], &["--into", "c"]].concat()).status, 0);
    let table = at.join("c/measurements.csv");
    let text = std::fs::read_to_string(&table).expect("text");
    let mut lines = text.lines();
    let head = format!("{},approach.q1", lines.next().expect("a header"));
    let rows = lines.enumerate().map(|(k, line)| format!("{line},{}", if k % 4 < 2 { 1 } else { -1 }));
    std::fs::write(&table, std::iter::once(head).chain(rows).collect::<Vec<_>>().join("\n") + "\n").expect("written");
    let found = certificate(at, &[]);
    let (poses, readings) =
        (found["poses"].as_array().expect("poses"), found["readings"].as_array().expect("readings"));
    assert_eq!(poses.len(), 25);
    for pose in poses {
        let own = readings.iter().filter(|reading| reading["pose"] == pose["pose"]);
        let own: Vec<Vec<f64>> =
            own.map(|r| r["error"].as_array().expect("x, y, z").iter().filter_map(Value::as_f64).collect()).collect();
        let mean = |all: &[Vec<f64>]| -> Vec<f64> {
            (0..3).map(|k| all.iter().map(|e| e[k]).sum::<f64>() / all.len() as f64).collect()
        };
        let apart = |a: &[f64], b: &[f64]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
        let spread = |all: &[Vec<f64>]| {
            let (centre, n) = (mean(all), all.len() as f64);
            let l: Vec<f64> = all.iter().map(|e| apart(e, &centre)).collect();
            let l_mean = l.iter().sum::<f64>() / n;
            let s = (l.iter().map(|l| (l - l_mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
            [apart(&centre, &[0.0; 3]), l_mean + 3.0 * s]
        };
        let [one, other, all] = [&own[..2], &own[2..], &own[..]].map(spread);
        let expected = [
            ("/accuracy", one[0].max(other[0])),
            ("/repeatability", one[1].max(other[1])),
            ("/variation", apart(&mean(&own[..2]), &mean(&own[2..]))),
            ("/multidirectional/0", all[0]),
            ("/multidirectional/1", all[1]),
            ("/directions/0/accuracy", one[0]),
            ("/directions/1/repeatability", other[1]),
        ];
        for (key, expected) in expected {
            assert!((pose.pointer(key).and_then(Value::as_f64).expect("a number") - expected).abs() < 1e-9, "{key}");
        }
        assert_eq!(pose["cycles"], 4);
        assert_eq!(pose["directions"][1]["approach"], "q1-");
    }
}

/// Configurations that are fitted and held out both are not unseen: there is no verdict on them.
#[test]
fn configurations_that_were_fitted_give_no_verdict() {
    let folder = folder("");
    let at = folder.path();
    let file = at.join("c/measurements.csv");
    let text = std::fs::read_to_string(&file).expect("text");
    let mut lines = text.lines();
    let head = lines.next().expect("a header");
    let set = head.split(',').position(|name| name == "set").expect("a column `set`");
    let marked = |line: &str, mark: &str| {
        let mut cells: Vec<&str> = line.split(',').collect();
        cells[set] = mark;
        format!("{mark}-{}\n", cells.join(","))
    };
    let twice: String = lines.flat_map(|line| [marked(line, "fit"), marked(line, "check")]).collect();
    std::fs::write(&file, format!("{head}\n{twice}")).expect("written");
    for (tolerance, verdict) in [(&["--tolerance", "5"][..], Value::from("undecided")), (&[], Value::Null)] {
        let found = certificate(at, tolerance);
        assert_eq!(found["verdict"], verdict);
        assert!(found["reason"].as_str().is_some_and(|why| why.contains("were fitted as well")), "{}", found["reason"]);
    }
}
